"""What the joints do about a contact. Knows no simulation: the same controller could drive hardware.

``command`` holds the values, ``settings_check`` their ranges; every law answers one question (``law``), and
``contact_motion`` is the controller that a session asks, whichever law is on (``laws``).

``impedance`` and ``hold_force`` stand alone. The others do a task: ``task_keeper`` says what is wanted of each contact
(``map_sight`` how far it is from there, ``border_contact`` what touches two patches at once), and ``report`` how it
goes. A path is drawn (``map_path``), cut at the patches' borders (``path_cut``) and laid on the skin (``path_walk``,
``laid_path``); ``path_follower`` leads the target along it, and where it goes on at a far place or on another link, the
``carrier`` takes the contact there: ``transfer`` lifts, carries and presses, along a way that ``carry_plan`` finds by
``aim``. ``task_law`` is what laws with a task share: Jacobians, the way home, ``slip_watch``, ``energy_tank`` and
``supervisor``. They differ in their ``rule``, how errors of a ``task_contact`` become joint velocities: ``hybrid``,
``admittance``, ``parallel`` and ``projection`` tell how the touched point moves in space (``point_rule``), ``priority``
and ``quadratic_program`` what is wanted first; by means of ``force_servo`` and ``levels``. All move a ``reference``, a
wanted posture that a stiff impedance (``gains``) holds.

For every law the controller minds the skin's limits (``skin_readings``): ``loop_watch`` holds gains to what a skin can
hold that is read so seldom and so late, ``swing_watch`` says when the force swings. Contact events may change the
settings: a ``behaviour`` says which, ``behaviour_watch`` waits for them.
"""
