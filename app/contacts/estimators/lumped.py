"""What a force-torque sensor in the link would know of a contact without a skin: the paper's baseline."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray
from app.contacts.estimators.estimate import ForceEstimate, Reading
from app.contacts.estimators.wrench import Wrench
from app.errors import MapError
from app.geometry.mesh import Mesh
from app.geometry.raycast import RayCaster
from app.geometry.surface_point import SurfacePoint
from app.skin.skin import Skin

_LEAST, _UNKNOWNS = 1e-9, 6
_LARGEST_TILT = 1e-6


class Lumped:
    """Meets the line along which the force acts with the skin of the link. Built once for a skin.

    A pure force f with moment m about the origin acts along the line through f x m / |f|² in the direction f (Bicchi,
    Salisbury, Brock, Contact sensing from force measurements, IJRR 1993). Contact pushes, so the place is where the
    line first enters the skin.

    What it cannot tell: several contacts at once (it sees their sum, acting somewhere between them), a contact that
    twists, how large a contact is. Friction it does feel, since the sensor, unlike taxels, knows the whole force; what
    is reported is the part along the skin's normal.

    Args:
        skin: The skin.
    """

    def __init__(self, skin: Skin) -> None:
        self._skin = skin
        self._casters: dict[int, RayCaster] = {}

    def estimate(self, reading: Reading) -> ForceEstimate:
        """Normal force and place; never a distribution. Cost: 50 µs a patch of the link.

        Raises:
            MapError: The reading has no wrench.
        """
        wrench, link = reading.wrench, reading.region.link
        if wrench is None:
            raise MapError("there is no force and torque to go by", place=link, remedy="Choose another estimator")
        size = float(np.linalg.norm(wrench.force))
        at, refused = None, ""
        if size < _LEAST:
            refused = "No force is felt"
        elif 2 * wrench.rank < _UNKNOWNS:
            refused = f"Only {wrench.rank} of the {_UNKNOWNS} numbers of force and torque are known"
        else:
            at = self._entry(wrench, link)
            refused = "" if at else f"The force's line misses the skin of {link}: several contacts, or a twist"
        force = size if at is None else float(-wrench.force @ self._skin.normal(at))
        return ForceEstimate(
            force, at, condition=wrench.condition, effective_rank=wrench.rank, unknowns=_UNKNOWNS, refused=refused
        )

    def _entry(self, wrench: Wrench, link: str) -> SurfacePoint | None:
        """Where the force's line first enters the skin of the link."""
        force = wrench.force
        along = force / np.linalg.norm(force)
        foot = np.cross(force, wrench.torque) / float(force @ force)
        found = []
        for number, patch in enumerate(self._skin.patches):
            if patch.link == link:
                caster = self._casters.get(number)
                if caster is None:
                    caster = self._casters[number] = RayCaster(patch.surface)
                found += _entries(caster, patch.surface, number, foot, along)
        return min(found, key=lambda entry: entry[0])[1] if found else None


def _entries(
    caster: RayCaster, surface: Mesh, patch: int, foot: FloatArray, along: FloatArray
) -> list[tuple[float, SurfacePoint]]:
    """The first place at which a line enters one surface, with how far along it lies [m]; or none."""
    start = -float(np.linalg.norm(foot)) - float(np.abs(surface.bounds).max()) * 2
    while (hit := caster.first_hit(foot + start * along, along)) is not None:
        start += hit.distance
        if float(surface.face_normals[hit.face] @ along) < -_LARGEST_TILT:
            return [(start, SurfacePoint(patch, hit.face, hit.weights))]
        start += 1e-5 * surface.size  # it leaves here; go on behind
    return []
