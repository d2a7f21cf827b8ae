"""The MuJoCo model of a scene: the robot, and of everything else only what the effects that are on need.

- ``model_assembly``: the whole model, compiled.
- ``object_geoms``: the scene's objects in it; ``model_names``: names of what is added to the robot.
- ``contact_pairs``: who may touch whom; ``contact_stiffness``: how stiff that is; ``contact_points``: where it touches.
- ``piece_contacts``: contacts of links that collide in several convex pieces.
"""
