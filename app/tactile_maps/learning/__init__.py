"""Environments of Gymnasium in which a policy learns from touch; importing this package registers them.

- ``registration``: their names, as ``TactileMaps-Follow-v0``.
- ``tasks``: what each wants: follow a path with the contact, retreat from touch, explore the map.
- ``environment``: what they share: a session, actions, episodes.
- ``observation``: what a policy sees.
- ``touched_arm``: the scene that is prepared once a process, and the ball that touches.
"""

from tactile_maps.learning.registration import ENVIRONMENTS, register_environments

__all__ = ["ENVIRONMENTS", "register_environments"]

register_environments()
