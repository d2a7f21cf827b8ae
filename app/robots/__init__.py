"""Robots: from any file to one self-contained value, and the kinematics of a posture.

``robot``        the value: links, joints, home, its MJCF and its meshes
``load``         which reader for which file; a mesh alone as a robot
``library``      robots by name; iCub
``mjcf``         the reader of MJCF files
``urdf``         the reader of URDF files, with the repairs they need
``xacro``        the macros of URDF, expanded without running anything
``model_files``  where the files lie that a model names: its tree, packages, given roots
``mesh_files``   checked triangles from any mesh file; the meshes of a robot in MuJoCo's format
``safe_files``   bounded reads, XML without tricks, repaired where that is sound
``touch_sensors``  the touch sensors that an MJCF file states
``sanitize``     a spec stripped to the robot, degenerate meshes, collision exclusions
``build``        where every reader ends: spec to robot, tessellated links, smoke test
``mujoco_spec``  MJCF text, spec and compiled model, there and back
``kinematics``   where the links are at a posture, and how they move with the joints
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
