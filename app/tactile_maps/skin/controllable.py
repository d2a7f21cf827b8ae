"""The share of a skin on which the robot can control a contact force."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.home_posture import LEAST_TILT, motion_tilts
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.model.skin import Skin


def controllable_share(robot: Robot, skin: Skin) -> Mapping[str, float]:
    """Return the share of the taxels of each link on which the force of a contact can be controlled at home.

    Where the joints move a taxel at less than ``LEAST_TILT`` to the skin, a small error of the normal reverses the
    response to a force. The parts of the skin that no joint moves count as zero.

    Cost: 10 us a taxel.
    """
    configuration = Configuration(robot)
    counts = dict[str, list[bool]]()
    for taxel in range(len(skin)):
        at = skin.taxel_point(taxel)
        link = skin.link(at)
        normal = configuration.pose(link).rotation @ skin.normal(at)
        move = configuration.jacobian(link, skin.position(at))[None]
        tilt = motion_tilts((normal @ move[0])[None], move)[0]
        counts.setdefault(link, []).append(bool(tilt > LEAST_TILT))
    return {link: float(np.mean(found)) for link, found in counts.items()}
