"""The map's shapes without Qt: each chart's borders and seams, prepared once, and where a layout puts them."""

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
"""A net has no line longer than so many times the median."""
Wireframe = tuple[bool, IntArray]
"""Lines that stand for a chart: whether their ends are taxels, and (e, 2) taxels or points of the chart."""


@dataclass(frozen=True, eq=False)
class ChartShape:
    """One patch flattened, in its chart's own frame; moving it changes nothing here.

    Attributes:
        chart: Its chart.
        outline: (b, 2) closed border [m].
        border: Polylines (k, 2), the parts of the outline where the skin ends.
        seam: Polylines (k, 2), the parts along which the patch was cut: on the body the skin goes on there.
        taxels: (n, 2) where its taxels are [m].
        loop: (b,) the chart's points along the outline.
        on_seam: (b,) which sides of it are cuts.
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
        """Prepare it; ``known`` is the same patch's shape before, whose loop is the same where its faces are."""
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
        """(e, 2, 2) the lines of a net [m]."""
        by_taxels, ends = net
        return (self.taxels if by_taxels else self.chart.plane)[ends]


@dataclass(frozen=True, eq=False)
class PatchShape:
    """One patch where it lies on the map.

    Attributes:
        name: What people call it.
        chart: Its shape.
        placed: (3, 2) that takes chart points [m] into the scene; see ``SceneTransform.placed``.
        shown: Whether it is drawn.
    """

    name: str
    chart: ChartShape
    placed: FloatArray
    shown: bool = True

    def to_scene(self, points: FloatArray) -> FloatArray:
        """Chart points (..., 2) [m] as scene points."""
        return np.asarray(points) @ self.placed[:2] + self.placed[2]

    @cached_property
    def box(self) -> FloatArray:
        """(2, 2) upper left and lower right corner [scene units]."""
        outline = self.to_scene(self.chart.outline)
        return np.stack([outline.min(axis=0), outline.max(axis=0)])


@dataclass(frozen=True, eq=False)
class MapShapes:
    """All patches and taxels of a map.

    Attributes:
        frame: Places the map in the scene.
        patches: In the skin's order.
        pitch: Typical distance of neighbouring taxels [scene units].
    """

    frame: SceneTransform
    patches: tuple[PatchShape, ...]
    pitch: float

    @classmethod
    def of(cls, document: MapDocument, frame: SceneTransform, *, known: MapShapes | None = None) -> MapShapes:
        """Prepare the shapes of ``document``; charts that ``known`` has too are taken from there."""
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
        """(n, 2) where the taxels are, those of hidden patches too [scene units]."""
        return np.concatenate([np.zeros((0, 2)), *(patch.to_scene(patch.chart.taxels) for patch in self.patches)])

    @property
    def numbers(self) -> tuple[int, ...]:
        """The patches that are shown."""
        return tuple(number for number, patch in enumerate(self.patches) if patch.shown)

    def on_shown(self) -> BoolArray:
        """(n,) which taxels are on a patch that is shown."""
        return np.concatenate([np.zeros(0, bool), *(np.full(len(p.chart.taxels), p.shown) for p in self.patches)])

    @property
    def bounds(self) -> FloatArray | None:
        """(2, 2) upper left and lower right corner of all that is shown [scene units]; None if nothing is."""
        boxes = np.array([patch.box for patch in self.patches if patch.shown])
        return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)]) if len(boxes) else None


def split_loop(closed: FloatArray, marked: BoolArray) -> tuple[tuple[FloatArray, ...], tuple[FloatArray, ...]]:
    """Cut a closed line into the polylines of its plain and of its marked edges, each as long as possible.

    Long polylines matter: dashes begin anew with each, and short ones would join to a solid line.

    Args:
        closed: (b + 1, 2), the last point repeats the first.
        marked: (b,) for each edge.
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
    """What stands for a chart's mesh where there is no time for all of it.

    The taxels joined to their neighbours, or where these are not known the mesh itself; evenly thinned.

    Args:
        shape: The chart's.
        patch: Whose chart.
        most: So many lines at most.

    Returns:
        For ``ChartShape.lines``. Cost: 3 ms for 10,000 faces without taxels' neighbours.
    """
    by_taxels = len(patch.taxels.neighbours) > 0
    sides = shape.chart.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    edges = patch.taxels.neighbours if by_taxels else np.unique(np.sort(sides, axis=1), axis=0)
    lengths = np.linalg.norm(np.diff(shape.lines((by_taxels, edges)), axis=1)[:, 0], axis=1)
    edges = edges[lengths <= _LONGEST * np.median(lengths)]  # neighbours across a seam are far apart on the map
    return by_taxels, edges[np.linspace(0, len(edges) - 1, min(len(edges), most)).astype(int)]
