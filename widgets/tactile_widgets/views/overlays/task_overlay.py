"""A controller's task, ready to be drawn in both views: path, target, contact path."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray
from tactile_maps.core.reading_units import THIN, ReadingUnits
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, lacking_shares

TRAIL_SECONDS = 4.0
"""Duration of the contact path that is shown [s]."""
_STEP = 0.003
"""Maximum side length of a line on the body, which is curved where the map is straight [m]."""
_INWARD = 1e-6


@dataclass(frozen=True, eq=False)
class SkinPolyline(ArrayFields):
    """A line within one patch, on the map and on the body.

    Attributes:
        patch: Index of the patch.
        on_map: (k, 2) points on the map [m].
        on_body: (n, 3) points of the same line on the body, link frame [m].
        normals: (n, 3) unit normals of the skin there.
    """

    patch: int
    on_map: FloatArray
    on_body: FloatArray
    normals: FloatArray


@dataclass(frozen=True, eq=False)
class ReferencePath:
    """A path on the skin.

    Attributes:
        lines: Its pieces, in the direction of motion.
        crossings: (c, 2, 2) jumps where it continues elsewhere on the map: start and end [m].
        crossed: (c, 2) patches of start and end of each jump.
    """

    lines: tuple[SkinPolyline, ...] = ()
    crossings: FloatArray = field(default_factory=lambda: np.zeros((0, 2, 2)))
    crossed: IntArray = field(default_factory=lambda: np.zeros((0, 2), np.int64))

    def __bool__(self) -> bool:
        """Whether it has any piece."""
        return bool(self.lines)


NO_PATH = ReferencePath()


@dataclass(frozen=True, eq=False)
class ContactTrail:
    """Recent locations of the contact, oldest first.

    Attributes:
        patch: (k,) patch of each location.
        on_map: (k, 2) [m].
        on_body: (k, 3) link frame [m].
        normals: (k, 3) unit normals of the skin there.
        age: (k,) 0 now, 1 when faded.
        starts: (k,) whether a new line begins there: after a loss of contact, behind a seam, on another patch; the
            first location always begins a line.
    """

    patch: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))
    on_map: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    on_body: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    normals: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    age: FloatArray = field(default_factory=lambda: np.zeros(0))
    starts: BoolArray = field(default_factory=lambda: np.zeros(0, bool))

    @property
    def lines(self) -> list[slice]:
        """Ranges of two or more locations that form a line."""
        cuts = [0, *(np.flatnonzero(self.starts[1:]) + 1).tolist(), len(self.starts)]
        return [slice(a, b) for a, b in pairwise(cuts) if b - a > 1]

    def without_oldest(self, count: int) -> ContactTrail:
        """Return the path without its first ``count`` locations."""
        kept = slice(count, None)
        places = self.on_map[kept], self.on_body[kept], self.normals[kept]
        return ContactTrail(self.patch[kept], *places, self.age[kept], self.starts[kept])


@dataclass(frozen=True, eq=False)
class TaskOverlay:
    """The task at one instant; the same object as long as nothing changes.

    Attributes:
        path: Reference path; the same object as long as it does not change.
        target: Current target of the contact.
        goal: Force goal [N].
        contact: Id of the task's contact region; 0 for none.
        tail: Contact path.
        controlled: Ids of the regions with controlled force, if there are several.
    """

    path: ReferencePath = field(default_factory=lambda: NO_PATH)
    target: SurfacePoint | None = None
    goal: float | None = None
    contact: int = 0
    tail: ContactTrail = field(default_factory=ContactTrail)
    controlled: tuple[int, ...] = ()

    def __bool__(self) -> bool:
        """Whether there is anything to draw."""
        return bool(self.path or self.target is not None or self.goal is not None or self.tail.lines)

    def looks_like(self, other: TaskOverlay) -> bool:
        """Whether both overlays have the same picture."""
        facts = [(one.target, one.goal, one.contact, one.controlled) for one in (self, other)]
        return facts[0] == facts[1] and self.path is other.path and self.tail is other.tail

    def force_words(self, region: ContactRegion, units: ReadingUnits, notes: Iterable[ContactNote] = ()) -> str:
        """Format a region's force, with the goal if it has one; its peak reading if readings are not calibrated.

        "≥" marks a force that lacks a part below the threshold, which ``notes`` state.
        """
        least = f"≥{THIN}" if units.force is not None and region.link in lacking_shares(notes) else ""
        if self.goal is None or region.id not in (self.contact, *self.controlled):
            return least + units.contact_words(region.force, region.peak)
        return f"{least}{region.force:.1f} of {units.contact_words(self.goal, region.peak)}"


NO_TASK = TaskOverlay()


def lines_on_skin(points: FloatArray, map_: TactileMap) -> tuple[SkinPolyline, ...]:
    """Return the parts of a polyline (k, 2) [m] on the map that are on the skin.

    Cost: 0.3 ms for 100 mm.
    """
    fine = _finer(points)
    if len(fine) > 1:  # ends on a border are moved inwards, or rounding could move them off the skin
        fine[0] += _INWARD * (fine[1] - fine[0])
        fine[-1] += _INWARD * (fine[-2] - fine[-1])
    patch, face, weights = map_.to_body_many(fine)
    cuts = np.flatnonzero(np.diff(patch)) + 1
    found = []
    for start, end in zip([0, *cuts.tolist()], [*cuts.tolist(), len(patch)], strict=True):
        if patch[start] >= 0 and end - start > 1:
            own = slice(start, end)
            found.append(
                SkinPolyline(int(patch[start]), fine[own], *_places(map_.skin, patch[start], face[own], weights[own]))
            )
    return tuple(found)


def _finer(points: FloatArray) -> FloatArray:
    """Subdivide a polyline into sides no longer than ``_STEP``."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    counts = np.maximum(np.ceil(lengths / _STEP), 1).astype(int)
    shares = np.concatenate([np.arange(count) / count for count in counts] or [np.zeros(0)])
    sides = np.repeat(np.arange(len(counts)), counts)
    return np.concatenate([points[sides] + shares[:, None] * (points[sides + 1] - points[sides]), points[-1:]])


def _places(skin: Skin, patch: int, face: IntArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Positions [m] and unit normals (n, 3) of locations on one patch, link frame."""
    surface = skin.patches[patch].surface
    corners = surface.faces[face]
    places, normals = (
        np.einsum("kc,kcd->kd", weights, part[corners]) for part in (surface.vertices, surface.vertex_normals)
    )
    return places, normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
