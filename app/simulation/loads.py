"""What presses the skin at one instant, whoever presses: a finger or another link."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from app.arrays import FloatArray, readonly
from app.errors import SimulationError
from app.skin.skin import Skin

CONTACT_RADIUS = 0.008
"""Radius [m] of the ball that stands in for whatever touches at a solver contact, whose shape MuJoCo does not tell."""


@dataclass(frozen=True, eq=False)
class Load:
    """A normal force on a link's skin.

    Attributes:
        link: Which link.
        point: (3,) where, link frame [m].
        normal: (3,) outward unit normal of the skin, link frame; the force acts against it.
        force: [N], >= 0.
        radius: Of the ball that presses [m], > 0.

    Raises:
        SimulationError: Force or radius is no such number.
    """

    link: str
    point: FloatArray
    normal: FloatArray
    force: float
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "point", readonly(self.point))
        object.__setattr__(self, "normal", readonly(self.normal))
        if not (math.isfinite(self.force) and self.force >= 0 and math.isfinite(self.radius) and self.radius > 0):
            raise SimulationError(
                "there is no such load", place=f"on {self.link}", value=f"{self.force} N, radius {self.radius} m"
            )


def contact_loads(model: mujoco.MjModel, data: mujoco.MjData, skin: Skin) -> list[Load]:
    """The solver's contacts on skinned links, normal components; when two such links touch, both feel it.

    Args:
        model: The compiled model.
        data: After a step.
        skin: Which links feel.
    """
    links = {int(model.body(patch.link).id): patch.link for patch in skin.patches}
    loads, wrench = [], np.zeros(6)
    for number in range(data.ncon):
        contact = data.contact[number]
        mujoco.mj_contactForce(model, data, number, wrench)
        if wrench[0] <= 0:
            continue
        # The contact frame's x axis points from the first geom to the second: outward for the first body.
        for geom, sign in zip(contact.geom, (1.0, -1.0), strict=True):
            body = int(model.geom_bodyid[geom])
            if body in links:
                rotation = data.xmat[body].reshape(3, 3)
                point = rotation.T @ (contact.pos - data.xpos[body])
                normal = sign * rotation.T @ contact.frame[:3]
                loads.append(Load(links[body], point, normal, float(wrench[0]), CONTACT_RADIUS))
    return loads
