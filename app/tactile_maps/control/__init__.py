"""What the joints do about a contact. Knows no simulation: the same controllers could drive hardware.

``command`` holds the values that go in and come out, ``limits`` why the arm is limited; ``limit_texts`` words that for
a person. ``controller_manager`` is what a session asks: it runs the chosen one of the eight ``controllers`` or of a
plug-in (``controller_registry``), switches without a jump, and minds the skin's limits (``force_loop``).

Two controllers stand alone, impedance and hold force; six do a task. ``task_control`` has what is wanted of each
contact, how errors become joint velocities (``map_kinematics``, solved in order of ``task_priority``), and the monitors
that stop what is unsafe. ``path_following`` leads a target along a path on the skin; where it goes on at a far place or
on another link, it regrasps there along a way planned clear of the robot itself and of obstacles. All move a wanted
posture that a stiff ``joint_impedance`` holds.

``behaviours``: contact events may change the settings.
"""
