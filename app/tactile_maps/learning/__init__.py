"""Gymnasium environments in which a policy learns from touch; importing this package registers them.

``registration``  names of the environments, such as ``TactileMaps-Follow-v0``
``tasks``         their tasks: follow a path with the contact, retreat from touch, explore the map
``environment``   shared by all: session, actions, episodes
``observation``   observations of the policy
``touched_arm``   the scene, prepared once in each process, and the ball that touches the arm
"""

from tactile_maps.learning.registration import ENVIRONMENTS, register_environments

__all__ = ["ENVIRONMENTS", "register_environments"]

register_environments()
