"""MuJoCo model of a scene: the robot, and only what the selected effects need.

``model_assembly``     the compiled model
``object_geoms``       objects; ``model_names`` names what is added to the robot
``contact_pairs``      pairs of bodies that can touch
``contact_stiffness``  solver parameters from stiffness and friction of the cover
``contact_points``     corrections of MuJoCo's contact points between flat faces
``piece_contacts``     contacts of links that collide in several convex pieces
"""
