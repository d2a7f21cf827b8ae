"""A contact led along a path that was drawn on the map.

``surface_path`` is the path on the body, cut where it crosses to another place. ``follower`` leads a target along it
and waits for the contact; where the path goes on at a far place or on another link, ``regrasp`` lets go, carries the
arm there and presses again, or says why it cannot.

The way there is a ``regrasp_plan``: postures that touch, or the proof of ``reach`` that there are none; straight lines
of the joints between them or, by ``motion_planning``, a way around; all with the ``clearance`` that the robot's shapes
keep of each other and of obstacles.
"""
