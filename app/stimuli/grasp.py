"""A grasp: fingers around a place on a link, which press against each other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from app.arrays import FloatArray
from app.geometry.raycast import RayCaster
from app.stimuli.place import Ground, Place, long_axes
from app.stimuli.stimulus import Stimulus
from app.stimuli.track import Track, still

_THIN = 1e-3


@dataclass(frozen=True, kw_only=True)
class Grasp(Stimulus):
    """Several fingers press at once from around a link, hold, lift together.

    The fingers stand in the section across the patch's long axis through ``at``, evenly around its middle, the first
    one at ``at``; each presses the outermost skin of the link there, whichever patch that is on.

    Attributes:
        at: Where the first finger presses.
        fingers: How many.
        hold: From the press to the lift [s].
    """

    kind: ClassVar[str] = "grasp"
    ranges: ClassVar[Mapping[str, tuple[float, float]]] = {"fingers": (2, 20), "hold": (0.0, 3600.0)}

    at: Place = (0.5, 0.25)
    fingers: int = 3
    hold: float = 1.5

    def __post_init__(self) -> None:
        super().__post_init__()
        self.check_place("at", self.at)

    def tracks(self, ground: Ground) -> tuple[Track, ...]:
        """One track a finger.

        Raises:
            SceneError: There is no skin on the side where a finger must press.
        """
        patch = ground.patch(self.patch)
        first, axis = ground.point(patch, self.at), long_axes(ground.skin.patches[patch])[0]
        middle = _middle(ground, patch, first, axis)
        places = [
            (patch, first),
            *(self._opposing(ground, patch, first, middle, axis, n) for n in range(1, self.fingers)),
        ]
        return tuple(still(n, self.tip, *place, press=0.0, lift=self.hold) for n, place in enumerate(places))

    def _opposing(
        self, ground: Ground, patch: int, first: FloatArray, middle: FloatArray, axis: FloatArray, number: int
    ) -> tuple[int, FloatArray]:
        """Patch and point (3,) of another finger: the first thing a ray towards the middle meets."""
        turn, out = 2 * np.pi * number / self.fingers, first - middle
        out = np.cos(turn) * out + np.sin(turn) * np.cross(axis, out)
        out /= np.linalg.norm(out)
        patches, link = ground.skin.patches, ground.skin.patches[patch].link
        far = max(other.surface.size for other in patches if other.link == link)
        best: tuple[float, int, FloatArray] | None = None
        for index, other in enumerate(patches):
            hit = RayCaster(other.surface).first_hit(middle + far * out, -out) if other.link == link else None
            # Beyond the middle is the other side, which another finger presses.
            if hit is not None and hit.distance < far and (best is None or hit.distance < best[0]):
                best = hit.distance, index, other.surface.point(hit.face, hit.weights)
        if best is None:
            raise self.refusal(
                "fingers", self.fingers, f"Finger {number + 1} finds no skin on its side of {link}; grasp elsewhere"
            )
        return best[1], best[2]


def _middle(ground: Ground, patch: int, first: FloatArray, axis: FloatArray) -> FloatArray:
    """(3,) middle of the link's skin in the plane across ``axis`` through ``first``, link frame [m]; inside of it."""
    crossings = [first[None]]
    for other in ground.skin.patches:
        if other.link == ground.skin.patches[patch].link:
            ends = other.surface.vertices[other.surface.edges]
            height = (ends - first) @ axis
            cut = (height[:, 0] < 0) != (height[:, 1] < 0)
            share = height[cut, 0] / (height[cut, 0] - height[cut, 1])
            crossings.append(ends[cut, 0] + share[:, None] * (ends[cut, 1] - ends[cut, 0]))
    points = np.concatenate(crossings)
    # Halfway between the outermost, so that a side with more triangles weighs no more.
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    normal = ground.skin.normal(ground.surface_point(patch, first))
    inward = np.asarray((normal @ axis) * axis - normal)
    # A flat piece of skin has its middle in itself.
    return middle if (middle - first) @ inward > _THIN else first + _THIN * inward
