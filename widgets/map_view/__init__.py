"""The tactile map on the screen, and the hand on it.

Read in this order: ``map_view`` wires everything; ``map_tools`` decides what a press, a stroke or a drag means,
``map_hit`` where on the skin it is and how to say that, and ``camera`` what the viewport shows; these three know no Qt.
``map_picture`` keeps one map ready to draw: its ``map_shapes``, the ``live_image`` filled in place by each frame, the
``contour`` around touched areas and the ``map_items`` in the scene. ``map_painter`` draws what lies over it,
``map_canvas`` zooms and pans, and ``state_card`` speaks while there is no map to show.
"""
