"""The tools that pin, cut and mark the map: a hand on the map or on the body in, edits through the editor out.

``pin_tool``, ``seam_tool`` and ``interest_tool`` are what a person takes. ``places`` finds the vertex, pin or seam that
the pointer means in either view, ``edges`` knows paths, runs and where edges lie on the map, ``areas`` what is around
vertices, and ``drawing`` how all of it looks on the map; on the body the robot view draws the same as ``body_marks``.
"""
