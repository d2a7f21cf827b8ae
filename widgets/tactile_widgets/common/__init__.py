"""What every part of the window stands on: colours and themes, settings, kinds of tools and files, small widgets.

``colours`` has the two themes and the scales of pressure and distortion, ``settings`` what is remembered between
launches, ``controller_settings`` what of a controller can be chosen, in words. ``tool_kinds`` names the tools,
``file_types`` says what a file is by its name. ``make`` constructs Qt objects, ``lists`` has what lists share;
``guide_window``, ``number_field`` and ``panel`` are widgets of more than one place.
"""
