"""Places on the skin as scripts specify them: fractions of a patch, or points in the link's frame."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import SceneError
from tactile_maps.geometry.geodesics import edge_graph, path_in_tree, shortest_path_tree
from tactile_maps.geometry.surface.closest_point import ClosestPoint, closest_point
from tactile_maps.geometry.surface.mesh import SurfacePoint, edge_lengths
from tactile_maps.geometry.surface.points import cumulative_lengths, points_along
from tactile_maps.skin.model.skin import Patch, Skin

SkinLocation: TypeAlias = tuple[float, ...]
"""Place on a patch: (along, around) its long axis, each 0 to 1, or (x, y, z) [m] in the frame of its link."""
STEP = 0.001
"""Spacing of the points of a path [m]."""
_SMOOTHING = 9
_FARTHEST = 0.01
_LEAP = 3 * STEP


class SkinLocator:
    """Positions of the places of scripts on a skin. The first query of a patch builds its search tree.

    Args:
        skin: Skin with at least one patch.
    """

    def __init__(self, skin: Skin) -> None:
        self.skin = skin

    def patch(self, name: str, *, key: str = "patch") -> int:
        """Return the index of a patch by name; an empty name is the first patch. ``key`` names it in errors.

        Raises:
            SceneError: Unknown patch; the error lists the valid ones.
        """
        names = [patch.name for patch in self.skin.patches]
        if not names or (name and name not in names):
            known = f"Choose one of: {', '.join(names)}" if names else "Cover at least one link"
            raise SceneError("unknown patch", place=key, value=name, remedy=known)
        return names.index(name) if name else 0

    def project(self, patch: int, points: FloatArray) -> FloatArray:
        """Return the points (k, 3) of the patch's surface nearest to ``points`` (k, 3), link frame [m]."""
        faces, weights, _ = self._tree(patch).query(points)
        return self.skin.patches[patch].surface.points(faces, weights)

    def surface_point(self, patch: int, point: FloatArray) -> SurfacePoint:
        """Return the point of the patch's surface nearest to ``point`` (3,), link frame [m]. About 20 µs."""
        faces, weights, _ = self._tree(patch).query(point[None])
        a, b, c = weights[0]
        return SurfacePoint(patch, int(faces[0]), (float(a), float(b), float(c)))

    def point(self, patch: int, place: SkinLocation, *, key: str = "at") -> FloatArray:
        """Return the position (3,) of a place, link frame [m]. ``key`` names the place in errors.

        Raises:
            SceneError: A place in the link's frame is farther than 10 mm from the patch.
        """
        if len(place) == 2:
            return self.skin.patches[patch].taxels.positions[_taxel_at(self.skin.patches[patch], place)]
        target = np.array(place)
        found = self.project(patch, target[None])[0]
        away = float(np.linalg.norm(found - target))
        if away > _FARTHEST:
            raise SceneError(
                "this place is not on the skin",
                place=key,
                value=list(place),
                remedy=f"The patch {self.skin.patches[patch].name} is {1000 * away:.0f} mm away: "
                f"its nearest place is {np.round(found, 4).tolist()}",
            )
        return found

    def surface_path(self, patch: int, first: SkinLocation, last: SkinLocation) -> FloatArray:
        """Return a path (k, 3) between two places on the patch's surface, with points about 1 mm apart, link frame [m].

        It is straight between two places in the link's frame, unless that leaves the surface; otherwise it is the
        shortest path through neighbouring taxels, with rounded corners. If the taxels are not connected, it is the last
        place alone.
        """
        ends = self.point(patch, first, key="start"), self.point(patch, last, key="end")
        if len(first) == len(last) == 3:
            straight = self.straight_path(patch, *ends)
            if np.linalg.norm(np.diff(straight, axis=0), axis=1).max(initial=0.0) < _LEAP:
                return straight
        positions = self.skin.patches[patch].taxels.positions
        taxels = [int(np.linalg.norm(positions - end, axis=1).argmin()) for end in ends]
        route = _taxels_between(self.skin.patches[patch], *taxels)
        if route[0] != taxels[0]:
            return ends[1][None]
        return self.project(patch, np.concatenate([ends[0][None], _resampled(positions[route])[1:-1], ends[1][None]]))

    def straight_path(self, patch: int, first: FloatArray, last: FloatArray) -> FloatArray:
        """Return points (k, 3) of a straight line between two points (3,), projected to the surface, link frame [m]."""
        count = int(np.ceil(np.linalg.norm(last - first) / STEP)) + 1
        return self.project(patch, np.linspace(first, last, max(count, 1)))

    def _tree(self, patch: int) -> ClosestPoint:
        return closest_point(self.skin.patches[patch].surface)


def principal_axes(patch: Patch) -> FloatArray:
    """Return the principal axes (3, 3) of the patch's taxels as rows, the longest first; link frame."""
    centred = patch.taxels.positions - patch.taxels.positions.mean(axis=0)
    axes = np.linalg.svd(centred, full_matrices=False)[2] if len(centred) > 2 else np.eye(3)
    # The sign of a singular vector is arbitrary: fix it by the largest component.
    return axes * np.sign(axes[np.arange(3), np.abs(axes).argmax(axis=1)])[:, None]


def _taxel_at(patch: Patch, place: SkinLocation) -> int:
    """Return the taxel nearest to fractions (along, around) of the patch's extents about its long axis."""
    axes = principal_axes(patch)
    centred = patch.taxels.positions - patch.taxels.positions.mean(axis=0)
    along = centred @ axes[0]
    around = np.arctan2(centred @ axes[2], centred @ axes[1]) / (2 * np.pi)
    miss = (along - along.min()) / max(float(np.ptp(along)), 1e-12) - place[0]
    turn = (around - place[1] + 0.5) % 1.0 - 0.5
    return int(np.argmin(miss**2 + turn**2))


def _taxels_between(patch: Patch, first: int, last: int) -> list[int]:
    """Return the taxels of the shortest path; only the last if there is none."""
    pairs = patch.taxels.neighbours
    positions = patch.taxels.positions
    graph = edge_graph(pairs, edge_lengths(positions, pairs), len(positions))
    return path_in_tree(shortest_path_tree(graph, first)[1], last).tolist()


def _resampled(line: FloatArray) -> FloatArray:
    """Return points ``STEP`` apart along a polyline, with corners rounded by a running mean."""
    steps = cumulative_lengths(line)
    places = np.arange(0.0, steps[-1] + STEP, STEP)
    even = points_along(line, steps, places)
    width = min(_SMOOTHING, (len(even) - 1) // 2)
    for _ in range(3):
        total = np.cumsum(np.pad(even, ((width + 1, width), (0, 0)), mode="edge"), axis=0)
        even = (total[2 * width + 1 :] - total[: -2 * width - 1]) / (2 * width + 1)
    return even
