"""Shapes of the map, without Qt: borders and seams of each chart, prepared once, and their places in a layout."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.editing.document import MapDocument
from tactile_maps.flattening.chart import Chart
from tactile_maps.skin.model.skin import Patch
from tactile_widgets.views.map.items.map_coordinates import SceneTransform

_LONGEST = 3.0
"""Maximum length of a wireframe's lines, in multiples of the median."""
Wireframe = tuple[bool, IntArray]
"""Lines drawn in place of a chart: whether their ends are taxels, and (e, 2) taxels or points of the chart."""


@dataclass(frozen=True, eq=False)
class ChartShape:
    """A flattened patch in its chart's own frame, which does not depend on the layout.

    Attributes:
        chart: The chart.
        outline: (b, 2) closed border [m].
        border: Polylines (k, 2), the parts of the outline where the skin ends.
        seam: Polylines (k, 2), the parts along which the patch was cut: on the body the skin continues there.
        taxels: (n, 2) locations of the taxels [m].
        loop: (b,) points of the chart along the outline.
        on_seam: (b,) whether each side of the outline is a cut.
    """

    chart: Chart
    outline: FloatArray
    border: tuple[FloatArray, ...]
    seam: tuple[FloatArray, ...]
    taxels: FloatArray
    loop: IntArray
    on_seam: BoolArray

    @classmethod
    def of(cls, patch: Patch, chart: Chart, *, known: ChartShape | None = None) -> ChartShape:
        """Prepare the shape; ``known`` is an earlier one of the patch, with the same loop if its faces are the same."""
        if known is not None and np.array_equal(known.chart.faces, chart.faces):
            loop = known.loop
            on_seam = known.on_seam
        else:
            loop = chart.border
            on_seam = np.isin(chart.border, chart.seam_edges[:, 0])
        closed = chart.plane[np.append(loop, loop[0])]
        border, seam = split_loop(closed, on_seam)
        corners = chart.plane[chart.faces[patch.taxels.faces]]
        taxels = np.einsum("kc,kcd->kd", patch.taxels.weights, corners)
        return cls(chart, closed, border, seam, taxels, loop, on_seam)

    def lines(self, net: Wireframe) -> FloatArray:
        """(e, 2, 2) lines of a wireframe [m]."""
        by_taxels, ends = net
        return (self.taxels if by_taxels else self.chart.plane)[ends]


@dataclass(frozen=True, eq=False)
class PatchShape:
    """A patch at its place on the map.

    Attributes:
        name: Name shown to the user.
        chart: Its shape.
        placed: (3, 2) matrix from chart points [m] to scene points; see ``SceneTransform.placed``.
        shown: Whether it is drawn.
    """

    name: str
    chart: ChartShape
    placed: FloatArray
    shown: bool = True

    def to_scene(self, points: FloatArray) -> FloatArray:
        """Convert chart points (..., 2) [m] to scene points."""
        return np.asarray(points) @ self.placed[:2] + self.placed[2]

    def to_chart(self, points: FloatArray) -> FloatArray:
        """Convert scene points (..., 2) to chart points [m]."""
        return (points - self.placed[2]) @ np.linalg.inv(self.placed[:2])

    @cached_property
    def outline(self) -> FloatArray:
        """(b, 2) closed border [scene units]."""
        return self.to_scene(self.chart.outline)

    @cached_property
    def box(self) -> FloatArray:
        """(2, 2) upper left and lower right corner [scene units]."""
        return np.stack([self.outline.min(axis=0), self.outline.max(axis=0)])


@dataclass(frozen=True, eq=False)
class MapShapes:
    """All patches and taxels of a map.

    Attributes:
        frame: Transform between map points and scene points.
        patches: Patches in the skin's order.
        pitch: Typical distance of neighbouring taxels [scene units].
    """

    frame: SceneTransform
    patches: tuple[PatchShape, ...]
    pitch: float

    @classmethod
    def of(cls, document: MapDocument, frame: SceneTransform, *, known: MapShapes | None = None) -> MapShapes:
        """Prepare the shapes of ``document``; those of unchanged charts are taken from ``known``."""
        before: Sequence[ChartShape | None] = [None] * len(document.charts)
        if known is not None:
            before = [patch.chart for patch in known.patches]
        patches = tuple(
            PatchShape(
                edit.name or skin_patch.name,
                old if old is not None and old.chart is chart else ChartShape.of(skin_patch, chart, known=old),
                frame.placed(placement),
                edit.visible,
            )
            for skin_patch, chart, placement, edit, old in zip(
                document.skin.patches,
                document.charts,
                document.layout.placements,
                document.patches,
                before,
                strict=True,
            )
        )
        areas = document.skin.areas
        return cls(frame, patches, frame.scale * float(np.sqrt(areas.mean())) if len(areas) else 0.0)

    @cached_property
    def taxels(self) -> FloatArray:
        """(n, 2) locations of all taxels, including those of hidden patches [scene units]."""
        return np.concatenate([np.zeros((0, 2)), *(patch.to_scene(patch.chart.taxels) for patch in self.patches)])

    @property
    def numbers(self) -> tuple[int, ...]:
        """Indices of the patches that are shown."""
        return tuple(number for number, patch in enumerate(self.patches) if patch.shown)

    def on_shown(self) -> BoolArray:
        """(n,) whether each taxel is on a patch that is shown."""
        return np.concatenate([np.zeros(0, bool), *(np.full(len(p.chart.taxels), p.shown) for p in self.patches)])

    @property
    def bounds(self) -> FloatArray | None:
        """(2, 2) upper left and lower right corner of the shown patches [scene units]; None if all are hidden."""
        boxes = np.array([patch.box for patch in self.patches if patch.shown])
        return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)]) if len(boxes) else None


def split_loop(closed: FloatArray, marked: BoolArray) -> tuple[tuple[FloatArray, ...], tuple[FloatArray, ...]]:
    """Split a closed line into polylines of its plain and of its marked edges, each as long as possible.

    Long polylines matter: each starts a new dash, so that short ones would form a solid line.

    Args:
        closed: (b + 1, 2); the last point repeats the first.
        marked: (b,) whether each edge is marked.
    """
    changes = np.flatnonzero(marked != np.roll(marked, 1))
    if len(changes) == 0:
        return ((), (closed,)) if marked.size and marked[0] else ((closed,), ())
    ring = np.roll(closed[:-1], -changes[0], axis=0)
    flags = np.roll(marked, -changes[0])
    ring = np.vstack([ring, ring[:1]])
    starts = [*(changes - changes[0]).tolist(), len(flags)]
    runs = [(bool(flags[start]), ring[start : end + 1]) for start, end in itertools.pairwise(starts)]
    return tuple(run for on, run in runs if not on), tuple(run for on, run in runs if on)


def wireframe(shape: ChartShape, patch: Patch, *, most: int) -> Wireframe:
    """Simplify a chart to lines that can be drawn during a drag.

    The lines connect neighbouring taxels, or if neighbours are unknown, are the mesh's edges; evenly thinned.

    Args:
        shape: Shape of the chart.
        patch: Patch of the chart.
        most: Maximum number of lines.

    Returns:
        Wireframe for ``ChartShape.lines``. Cost: 3 ms for 10,000 faces if neighbours are unknown.
    """
    by_taxels = len(patch.taxels.neighbours) > 0
    sides = shape.chart.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    edges = patch.taxels.neighbours if by_taxels else np.unique(np.sort(sides, axis=1), axis=0)
    lengths = np.linalg.norm(np.diff(shape.lines((by_taxels, edges)), axis=1)[:, 0], axis=1)
    edges = edges[lengths <= _LONGEST * np.median(lengths)]  # neighbours across a seam are far apart on the map
    return by_taxels, edges[np.linspace(0, len(edges) - 1, min(len(edges), most)).astype(int)]
