"""Tools of control: ``control_settings_editor`` knows the settings in force and their undo steps.

``control_tool`` is what ``path_tool`` and ``target_tool`` share, ``drawn_path`` the path under the mouse.
"""
