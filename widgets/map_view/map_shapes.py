"""The map's fixed shapes in scene units, prepared once per map: patch borders, seams, taxels and their sizes."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from app.arrays import BoolArray, FloatArray
from app.maps.tactile_map import TactileMap
from widgets.map_view.map_hit import MapFrame

_SAME_POINT = 1e-9
"""Two ends closer than this are one point [m]; far below any taxel, far above rounding."""


@dataclass(frozen=True, eq=False)
class PatchShape:
    """One patch on the map.

    Attributes:
        name: The patch's name.
        outline: (b, 2) closed border [scene units].
        border: Polylines (k, 2), the parts of the outline where the skin ends.
        seam: Polylines (k, 2), the parts along which the patch was cut: on the body the skin goes on there.
    """

    name: str
    outline: FloatArray
    border: tuple[FloatArray, ...]
    seam: tuple[FloatArray, ...]


@dataclass(frozen=True, eq=False)
class MapShapes:
    """All patches and taxels of a map.

    Attributes:
        frame: Places the map in the scene.
        patches: In the skin's order.
        taxels: (n, 2) [scene units].
        pitch: Typical distance of neighbouring taxels [scene units].
    """

    frame: MapFrame
    patches: tuple[PatchShape, ...]
    taxels: FloatArray
    pitch: float

    @classmethod
    def of(cls, tactile_map: TactileMap) -> MapShapes:
        """Prepare the shapes of ``tactile_map``."""
        frame, areas = MapFrame.around(tactile_map.bounds), tactile_map.skin.areas
        patches = tuple(
            _patch_shape(frame, patch.name, outline, seams)
            for patch, outline, seams in zip(
                tactile_map.skin.patches, tactile_map.outlines, tactile_map.seams, strict=True
            )
        )
        pitch = frame.scale * float(np.sqrt(areas.mean())) if len(areas) else 0.0
        return cls(frame, patches, frame.to_scene(tactile_map.taxel_points), pitch)


def _patch_shape(frame: MapFrame, name: str, outline: FloatArray, seams: FloatArray) -> PatchShape:
    closed = outline if np.allclose(outline[0], outline[-1]) else np.vstack([outline, outline[:1]])
    cut = {_edge_key(edge) for edge in np.asarray(seams).reshape(-1, 2, 2)}
    on_seam = np.array([_edge_key(edge) in cut for edge in np.stack([closed[:-1], closed[1:]], axis=1)], dtype=bool)
    border, seam = split_loop(frame.to_scene(closed), on_seam)
    return PatchShape(name, frame.to_scene(closed), border, seam)


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
    ring, flags = np.roll(closed[:-1], -changes[0], axis=0), np.roll(marked, -changes[0])
    ring = np.vstack([ring, ring[:1]])
    starts = [*(changes - changes[0]).tolist(), len(flags)]
    runs = [(bool(flags[start]), ring[start : end + 1]) for start, end in itertools.pairwise(starts)]
    return tuple(run for on, run in runs if not on), tuple(run for on, run in runs if on)


def _edge_key(edge: FloatArray) -> tuple[tuple[int, ...], ...]:
    ends = np.rint(edge / _SAME_POINT).astype(np.int64)
    return tuple(sorted(tuple(int(value) for value in end) for end in ends))
