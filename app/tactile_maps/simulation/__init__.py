"""Physics of robot, objects and fingers, and the readings of the skin.

``simulation``        the whole: robot, objects, fingers and skin, with effects that may change
``physics``           steps of one compiled model
``model``             assembly of the MuJoCo model
``fingers``           springs that press the skin
``pressing_shapes``   solid shapes that can press a link
``contact_loads``     loads of contacts on skin and links; ``mean_loads`` averages them over steps
``step_checks``       checks of each step: commands, tunnelling, divergence; ``contact_watch`` checks contacts
``start_overlaps``    objects that overlap the robot at the start
``robot_contacts``    contacts of the robot in a posture that it is to be placed in
``known_load_check``  a known weight on the skin
"""
