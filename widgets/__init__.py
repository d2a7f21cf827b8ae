"""Everything a hand or an eye touches.

``launch`` opens the window; ``main_window`` wires views, panels and menus. Two owners of change stand behind it:
``live_session`` is the only caller that changes a running session, ``editor`` the only one that changes the document
being edited; ``seeing`` and ``editing`` connect their actions. ``engines`` says who works beside the window: the thread
that runs the session, and the processes that prepare, lay flat and measure.

``robot_view`` draws the body, ``map_view`` the map; they never know of each other: each emits what the hand did, and
draws the frame it is given. ``edit_tools`` are what a hand may hold over either.
"""
