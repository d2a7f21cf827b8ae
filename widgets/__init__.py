"""Everything a hand or an eye touches.

``launch`` opens the window; ``main_window`` wires views, panels and menus; ``live_session`` is the only caller that
changes a running session. ``robot_view`` draws the body, ``map_view`` the map; they never know of each other: each
emits what the hand did, and draws the frame it is given.
"""
