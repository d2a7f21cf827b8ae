"""Tools that edit the map: ``map_edit_tool`` is their base class, ``mesh_picking`` finds mesh elements at the pointer.

``pin_tool``, ``seam_tool`` and ``interest_tool`` are based on these; ``arrange_tool`` moves, rotates and scales patches
with a ``transform_box``; ``grid_tool`` places a grid of taxels on a surface.
"""
