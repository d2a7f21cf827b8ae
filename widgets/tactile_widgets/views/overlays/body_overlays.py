"""Texture of the map's image and marks of a tool, which the robot view draws on the body.

An area around vertices is everything closer to them, along each edge, than to other vertices: ``area_triangles`` and
``area_outlines`` compute its shape.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.common.colours import Theme
from tactile_widgets.views.overlays.task_overlay import SkinPolyline


@dataclass(frozen=True, eq=False)
class SkinTexture:
    """Image of a flattened skin; its pixels change in place with every tick.

    Attributes:
        pixels: (h, w) 0xffRRGGBB, row 0 at the top.
        extent: (2, 2) lower-left and upper-right corner [m].
        places: For each patch, (k, 2) locations of its chart's points in the image [m]. They differ from those on the
            map, because moving a patch on the map does not change the image.
    """

    pixels: NDArray[np.uint32]
    extent: FloatArray
    places: tuple[FloatArray, ...]


def area_triangles(faces: IntArray, marked: BoolArray) -> IntArray:
    """(t, 3, 2) triangles that cover the area around ``marked`` (n,) vertices; each corner is halfway between two."""
    one = _turned(faces, marked, 1)
    two = _turned(faces, ~marked, 1)
    whole = faces[marked[faces].all(axis=1)]
    parts = (
        np.stack([_mid(whole, k, k) for k in range(3)], axis=1),
        np.stack([_mid(one, 0, 0), _mid(one, 0, 1), _mid(one, 0, 2)], axis=1),
        np.stack([_mid(two, 1, 1), _mid(two, 2, 2), _mid(two, 0, 2)], axis=1),
        np.stack([_mid(two, 1, 1), _mid(two, 0, 2), _mid(two, 0, 1)], axis=1),
    )
    return np.concatenate(parts)


def area_outlines(faces: IntArray, marked: BoolArray, points: FloatArray) -> list[FloatArray]:
    """Return the outlines (k, 2) of the area and its holes on a chart with these ``faces`` and ``points`` (n, 2)."""
    one = _turned(faces, marked, 1)
    two = _turned(faces, ~marked, 1)
    rim = Connectivity(faces).boundary_edges
    here, there = marked[rim].T
    inside = rim[here & there]
    out = rim[here & ~there]
    back = rim[there & ~here]
    starts = (_mid(one, 0, 1), _mid(two, 0, 2), _mid(inside, 0, 0), _mid(out, 0, 0), _mid(back, 0, 1))
    ends = (_mid(one, 0, 2), _mid(two, 0, 1), _mid(inside, 1, 1), _mid(out, 0, 1), _mid(back, 1, 1))
    pairs = [np.sort(np.concatenate(part), axis=1) @ [len(points), 1] for part in (starts, ends)]
    following = dict(zip(*(part.tolist() for part in pairs), strict=True))
    loops = []
    while following:
        node, after = following.popitem()
        loop = [node]
        while after in following:
            loop.append(after)
            after = following.pop(after)
        loops.append(points[np.stack(np.divmod(loop, len(points)), axis=1)].mean(axis=1))
    return loops


def _turned(faces: IntArray, marked: BoolArray, count: int) -> IntArray:
    """(k, 3) faces with this number of marked corners, rotated so that a marked one comes first."""
    own = faces[marked[faces].sum(axis=1) == count]
    first = marked[own].argmax(axis=1)
    return own[np.arange(len(own))[:, None], (first[:, None] + np.arange(3)) % 3]


def _mid(faces: IntArray, a: int, b: int) -> IntArray:
    """(k, 2) pairs of vertices that define the point halfway between them."""
    return faces[:, [a, b]]


SEAM_COLOUR = "#343b44"
"""Colour of seams on the skin, which is light in both themes."""


class MarkRole(Enum):
    """Meaning of a mark, which determines its colour and dash."""

    SEAM = "seam"
    HELD = "held"
    OFFERED = "offered"
    ERASED = "erased"
    PIN = "pin"
    REFERENCE = "reference"
    SKETCHED = "sketched"

    @property
    def dashed(self) -> bool:
        """Whether its line is dashed, as for cuts and previews."""
        return self in (MarkRole.SEAM, MarkRole.OFFERED, MarkRole.SKETCHED)

    def ink(self, theme: Theme) -> str:
        """Return its colour as hex."""
        if self is MarkRole.ERASED:
            return theme.fault
        if self in (MarkRole.REFERENCE, MarkRole.SKETCHED):
            return theme.intent
        return {MarkRole.SEAM: SEAM_COLOUR, MarkRole.PIN: "#ffffff"}.get(self, theme.accent)


@dataclass(frozen=True, eq=False)
class EdgeMark:
    """A line along edges.

    Attributes:
        patch: Index of the patch.
        vertices: (k,) vertices of the patch's surface, in order.
        role: Meaning of the mark.
    """

    patch: int
    vertices: IntArray
    role: MarkRole


@dataclass(frozen=True, eq=False)
class PolylineMark:
    """A line anywhere on one patch.

    Attributes:
        line: The line.
        role: Meaning of the mark.
    """

    line: SkinPolyline
    role: MarkRole


@dataclass(frozen=True)
class PointMark:
    """A small diamond.

    Attributes:
        at: Skin location.
        role: Meaning of the mark.
        large: Whether it is under the pointer.
    """

    at: SurfacePoint
    role: MarkRole
    large: bool = False


@dataclass(frozen=True, eq=False)
class AreaMark:
    """A translucent area around vertices.

    Attributes:
        patch: Index of the patch.
        vertices: (k,) vertices of the patch's surface.
    """

    patch: int
    vertices: IntArray


@dataclass(frozen=True, eq=False)
class ToolMarks:
    """All marks of a tool; the same object as long as nothing changes.

    Attributes:
        skin: Skin of the marks; on another one they are not drawn. None without marks.
        lines: Lines along edges.
        spots: Points.
        tints: Areas.
        strokes: Lines across faces.
    """

    skin: Skin | None = None
    lines: tuple[EdgeMark, ...] = ()
    spots: tuple[PointMark, ...] = ()
    tints: tuple[AreaMark, ...] = ()
    strokes: tuple[PolylineMark, ...] = ()


NO_MARKS = ToolMarks()
