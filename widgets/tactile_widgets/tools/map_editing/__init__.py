"""Tools that edit the map: ``map_edit_tool`` is what they share, ``mesh_picking`` finds what a person means.

``pin_tool``, ``seam_tool`` and ``interest_tool`` stand on these; ``arrange_tool`` moves, turns and scales patches by
their ``transform_box``; ``grid_tool`` lays a grid of taxels on a surface.
"""
