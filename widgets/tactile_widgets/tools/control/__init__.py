"""Control tools: ``control_settings_editor`` stores the current settings and their undo steps.

``control_tool`` is the common base of ``path_tool`` and ``target_tool``, ``drawn_path`` the geometry of a drawn path.
"""
