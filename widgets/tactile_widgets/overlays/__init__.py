"""What is drawn over robot and map alike, as values that both views draw in their own way.

``task_overlay`` is a controller's task: path, target, force goal and the contact's trail; ``task_overlay_builder`` puts
it together. ``body_overlays`` is what the robot view draws on the body for others: the map as a texture and the marks
of a tool. ``callouts`` finds room for the words about contacts. ``painting`` draws pins, lines, handles and labels with
a QPainter.
"""
