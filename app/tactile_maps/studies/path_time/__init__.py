"""What accuracy costs in time: the shortest time in which a contact path is followed well enough, by one factor at a
time.

``representation`` and ``force_feedback`` are the studies: their factors and levels. ``conditions`` is what a controller
works with, ``path_time`` lists and measures cases, ``speed_search`` finds the fastest speed, ``gains`` are by theory,
``charts`` draws, ``expectations`` says what theory expects.
"""
