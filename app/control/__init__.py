"""What the joints do about a contact. Knows no simulation: the same controller could drive hardware.

``command`` holds the values, ``settings_check`` their ranges; every law answers one question (``law``), and
``contact_motion`` is the controller that a session asks, whichever law is on (``laws``).

``impedance`` and ``hold_force`` stand alone. The others do a task: ``task_keeper`` says what is wanted of each contact
(``map_path`` where a path leads, ``map_sight`` how far that is), and ``task_law`` is what they share: Jacobians, the
way home, ``slip_watch``, ``energy_tank`` and ``supervisor``. They differ in their ``rule``, how errors of a
``task_contact`` become joint velocities: ``hybrid``, ``admittance``, ``parallel``, ``projection``, ``priority`` and
``quadratic_program``, by means of ``force_servo`` and ``levels``. All move a ``reference``, a wanted posture that a
stiff impedance (``gains``) holds.
"""
