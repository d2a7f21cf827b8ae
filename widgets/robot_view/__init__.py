"""The body: the robot in three dimensions, its skin coloured by what it feels, and the hand on it.

Read in this order: ``robot_view`` turns the hand into pokes and views; ``robot_canvas`` under it draws the newest frame
when ``drawing`` says so, on one of the two kinds of ``canvas``, with an ``overlay`` of captions and the
``orientation_cube``. ``robot_scene`` and its ``marks`` draw on any PyVista plotter and know no Qt. ``viewpoint``,
``orbit`` and ``pick`` are arithmetic: pixel to ray, ray to skin, and the eye moved by hand.
"""
