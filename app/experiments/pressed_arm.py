"""A robot held at home and a probe that presses its skin: the same scene for whatever steps in time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from app.arrays import FloatArray
from app.control.command import JointCommand
from app.control.gains import joint_impedance
from app.errors import SkinError
from app.geometry.surface_point import SurfacePoint
from app.robots.configuration import Configuration
from app.robots.library import find_robot
from app.robots.robot import Robot
from app.scene.bodies import primitive
from app.scene.objects import Body, ObjectSpec
from app.scene.stability import PROBE
from app.skin.cover import cover
from app.skin.cover_spec import CoverSpec
from app.skin.skin import Skin

PRESS = 10.0
"""The probe's motors push so hard [N]."""
ARRIVED = 0.1
"""The probe's motors have come to their end by then [s]; the arm then gives way until it carries the force."""
_RADIUS, _AWAY, _BEYOND = 0.012, 0.002, 0.05
_FREQUENCY, _DAMPING = 30.0, 1.0


@dataclass(frozen=True, eq=False)
class PressedArm:
    """What the experiments simulate.

    Attributes:
        robot: Our own arm.
        skin: On upper arm, forearm and hand.
        probe: A ball of 12 mm and 0.1 kg that presses with ``PRESS`` along an axis of the world.
        at: Where on the skin.
        command: Holds the arm at home.
    """

    robot: Robot
    skin: Skin
    probe: Body
    at: SurfacePoint
    command: JointCommand


@lru_cache(maxsize=4)
def pressed_arm(taxels: int, seed: int = 0) -> PressedArm:
    """The arm in so many taxels. Cost: 1 s at 1,000, kept."""
    robot = find_robot("arm")
    return pressed(
        robot, cover(robot, CoverSpec(("upper_arm", "forearm", "hand"), taxels=taxels, seed=seed)), "forearm"
    )


def pressed(robot: Robot, skin: Skin, link: str = "") -> PressedArm:
    """A robot held at home, with the probe beside its skin.

    Args:
        robot: Any.
        skin: Its skin.
        link: Which link is pressed; by default the one where skin faces an axis of the world best.

    Raises:
        SkinError: Nothing there wears skin.
    """
    configuration = Configuration(robot)
    number, axis = _facing_an_axis(skin, configuration, link)
    at = skin.taxel_point(number)
    touched = configuration.pose(skin.link(at)).points(skin.position(at))
    way = [(seconds, *(touched + along * axis)) for seconds, along in
           ((0.0, _RADIUS + _AWAY), (ARRIVED, -_BEYOND), (3600.0, -_BEYOND))]  # fmt: skip
    spec = ObjectSpec("probe", "probe", size=(_RADIUS,), mass=PROBE, friction=0.0, max_force=PRESS)
    spec = replace(spec, path=tuple((float(t), float(x), float(y), float(z)) for t, x, y, z in way))
    command = joint_impedance(configuration.inertia(), robot.home, frequency=_FREQUENCY, damping_ratio=_DAMPING)
    return PressedArm(robot, skin, Body(spec, primitive(spec)), at, command)


def _facing_an_axis(skin: Skin, configuration: Configuration, link: str) -> tuple[int, FloatArray]:
    """The taxel whose normal comes nearest to an axis of the world, and that axis; of equals the first."""
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    best = (-np.inf, 0, axes[0])
    for first, patch in zip(skin.first[:-1], skin.patches, strict=True):
        if link in ("", patch.link) and len(patch.taxels):
            facing = configuration.pose(patch.link).directions(patch.taxels.normals) @ axes.T
            taxel, axis = np.unravel_index(np.argmax(facing), facing.shape)
            if facing[taxel, axis] > best[0]:
                best = (float(facing[taxel, axis]), int(first + taxel), axes[axis])
    if not np.isfinite(best[0]):
        raise SkinError("there is no skin to press", place=link or "robot", remedy="Cover a link")
    return best[1], best[2]
