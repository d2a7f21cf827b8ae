"""Robots: from any file to one self-contained value, and the kinematics of a posture.

``robot``            the value: links, joints, home, its MJCF and its meshes
``load``             which reader for which file; a mesh alone as a robot
``library``          robots by name; iCub
``formats``          the readers: MJCF, URDF with the repairs it needs, xacro expanded without running anything, checked
                     triangles from any mesh file; the touch sensors that an MJCF file states
``files``            where the files lie that a model names, bounded reads, XML without tricks, limits of a model's size
``sanitize``         a spec stripped to the robot, degenerate meshes, collision exclusions
``build``            where every reader ends: spec to robot, tessellated links, smoke test
``mujoco_spec``      MJCF text, spec and compiled model, there and back
``mujoco_warnings``  warnings of MuJoCo's C code as findings
``kinematics``       where the links are at a posture, and how they move with the joints
"""
