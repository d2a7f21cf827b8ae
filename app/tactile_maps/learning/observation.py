"""Observations of a policy: arrays of fixed shapes, in SI units except pressures."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.robots.model.robot import Robot
from tactile_maps.session.frame import Frame

IMAGE_WIDTH = 32
"""Length of the tactile image's longer side [px]."""
MOST_CONTACTS = 4
"""Maximum number of contacts, the strongest first."""
_LARGEST = {"image": 1e6, "contacts": 1e5, "position": 1e3, "velocity": 1e5}
"""Bounds of the spaces, far beyond the limits of the simulation's divergence check: nothing is ever clipped."""

Observation = dict[str, NDArray[Any]]


class FrameObserver:
    """Converts frames to observations.

    - ``image`` (rows, columns): tactile image [kPa].
    - ``contacts`` (4, 4): position on the map [m], force [N] and area [m²] of each contact; zeros where
      ``contact_mask`` (4,) is 0.
    - ``position`` and ``velocity`` (joints,) [rad, rad/s].

    Args:
        robot: The robot.
        map_: Map of its skin.

    Attributes:
        image: Renderer of the tactile image.
        spaces: Spaces by key of the observation.
    """

    def __init__(self, robot: Robot, map_: TactileMap) -> None:
        self.image = TactileImage(map_, width=IMAGE_WIDTH)
        joints = (len(robot.joints),)
        shapes = {
            "image": self.image.shown.shape,
            "contacts": (MOST_CONTACTS, 4),
            "position": joints,
            "velocity": joints,
        }
        self.spaces: dict[str, Any] = {
            name: spaces.Box(-_LARGEST[name], _LARGEST[name], shape, np.float32) for name, shape in shapes.items()
        }
        self.spaces["contact_mask"] = spaces.MultiBinary(MOST_CONTACTS)

    def observe(self, frame: Frame) -> Observation:
        """Return the observation of a frame. Cost: 30 µs for 1000 taxels."""
        contacts = np.zeros((MOST_CONTACTS, 4), np.float32)
        mask = np.zeros(MOST_CONTACTS, np.int8)
        for number, region in enumerate(frame.regions[:MOST_CONTACTS]):
            contacts[number] = (*region.map_point, region.force, region.area)
            mask[number] = 1
        return {
            "image": np.asarray(self.image.render(frame.pressures), dtype=np.float32),
            "contacts": contacts,
            "contact_mask": mask,
            "position": frame.posture.astype(np.float32),
            "velocity": frame.velocity.astype(np.float32),
        }
