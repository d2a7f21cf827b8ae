"""Context of the presenters, which they receive instead of the window.

``app_context``         the value that holds it
``notifier``            shows messages and the progress of jobs
``notification_bar``    floating bars for messages and first hints
``progress_indicator``  progress of a job in the status line
"""
