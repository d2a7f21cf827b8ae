"""Motion of a contact along a path drawn on the map.

``surface_path``        path on the body, divided where it continues on another patch or link
``follower``            moves a target along the path and waits for the contact
``contact_place``       place of a contact between the taxels of a coarse skin
``slide_observer``      velocity on the map that is lost in the contact, and its compensation
``regrasp``             releases the contact, moves the arm and presses at another place
``regrasp_plan``        postures and route of a regrasp, or the reason why none was found
``reach``               proves that a place of the skin cannot reach a point
``inverse_kinematics``  posture in which a place of the skin reaches a point
``motion_planning``     straight and sampled paths of the joints without collision
``clearance``           distances of the robot's shapes from each other and from obstacles
"""
