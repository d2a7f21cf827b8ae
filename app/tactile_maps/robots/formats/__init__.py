"""Readers of what robots come in: MJCF, URDF with xacro, meshes; and the touch sensors that an MJCF file states."""
