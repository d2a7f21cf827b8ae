"""The tactile map on the screen, live while it is edited, and the hand on it.

Read in this order: ``map_view`` wires everything and hands presses to poking, choosing or an edit tool; ``map_hit``
knows where on the skin a place of the view is and how to say that, ``camera`` what the viewport shows; both know no Qt.
``map_picture`` keeps one document ready to be drawn: the ``atlas`` of the patches' ``tile``s, rebuilt only where a
chart changed, their ``map_shapes``, the ``live_image`` filled in place by each frame, the ``contour`` around touched
areas, ``live_flaws`` and the items in the scene. ``map_painter`` draws what lies over it, ``map_canvas`` zooms and
pans. ``arrange_tool`` moves, scales and turns patches: ``arrange_frame`` is its geometry, ``arrange_drag`` what a drag
means, ``arrange_marks`` how it looks.
"""
