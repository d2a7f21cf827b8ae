"""The tools a person takes: they edit the map through the editor, or set path, target and force through the settings
editor.

``map_edit_tool`` is what the tools that edit share, ``mesh_picking`` finds what they mean; ``pin_tool``, ``seam_tool``
and ``interest_tool`` stand on them. ``arrange_tool`` moves, turns and scales patches by their ``transform_box``.
``control_settings_editor`` knows the settings in force and their undo steps; ``control_tool`` is what ``path_tool`` and
``target_tool`` share, ``drawn_path`` the path under the mouse.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
