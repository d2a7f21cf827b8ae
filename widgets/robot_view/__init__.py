"""The body: the robot in three dimensions, its skin coloured by what it feels, and the hand on it.

Read in this order: ``robot_view`` turns the hand into pokes, views and edits (``edit_hand``); below, ``robot_display``
says what is missing and ``robot_canvas`` draws the newest frame when ``drawing`` says so, on one of the two kinds of
``canvas``, with an ``overlay`` of captions and the ``orientation_cube``. ``robot_scene`` draws on any PyVista plotter
and knows no Qt, with ``marks`` and ``edit_marks`` (shaped by ``ribbons``). ``viewpoint``, ``orbit`` and ``pick`` are
arithmetic: pixel to ray, ray to skin, and the eye moved by hand.
"""
