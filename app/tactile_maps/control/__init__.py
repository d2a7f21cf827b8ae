"""Contact control: from contacts to joint commands. It does not depend on simulation and can drive hardware.

``controller_manager``   runs the selected controller in a session, and switches without a jump
``controllers``          the eight controllers; ``controller_registry`` lists them and those of plug-ins
``motion``               settings, observation and command; limits; motion of joints from motion on the map
``force_loop``           stability of the force loop: contact stiffness, largest stable gain, signs of oscillation
``gain_limits``          gains reduced to what sensor delay, arm and contact allow
``task_control``         shared by the six controllers with a task: goals of contacts, control schemes, monitors
``path_following``       moves a contact along a path, with regrasps that avoid collisions
``behaviours``           changes of settings that contact events trigger
``limit_texts``          texts for the reasons why the arm is limited

Impedance and hold force have no task. All controllers move a desired posture, which a stiff joint impedance holds.
"""
