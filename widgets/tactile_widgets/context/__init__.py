"""What every presenter is given, instead of the window.

``app_context`` is the value that holds it all; ``linked_views`` keeps robot and map in step: one hover, one selection,
one scale; ``notifier`` says what happened, in the ``notification_bar`` and the ``progress_indicator``; ``dialogs``
asks.
"""
