"""Overlays of both views.

``task_overlay``          a controller's task: path, target, force goal and contact path
``task_overlay_builder``  builds the task from settings, ticks and the map
``body_overlays``         texture and tool marks that the robot view draws on the body
``callouts``              places captions next to contacts
``painting``              paints captions, pins, lines and handles with a QPainter
``paint_cache``           keeps pixels of drawings that seldom change
"""
