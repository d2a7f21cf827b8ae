"""The tactile map on the screen, and the hand on it.

Read in this order: ``map_view`` wires everything; ``map_hit`` knows where on the skin a place of the view is and how
to say that, ``camera`` what the viewport shows; both know no Qt, nor does the hand both views share (``widgets.hand``).
``map_picture`` keeps one map ready to draw: its ``map_shapes``, the ``live_image`` filled in place by each frame, the
``contour`` around touched areas and the ``map_items`` in the scene. ``map_painter`` draws what lies over it,
``map_canvas`` zooms and pans.
"""
