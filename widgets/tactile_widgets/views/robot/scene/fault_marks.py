"""Marks of dead, stuck and blind taxels on the body, in the shapes that the map uses for them."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import Theme
from tactile_widgets.overlays.taxel_faults import NO_FAULTS, STROKES, Fault, TaxelFaults
from tactile_widgets.views.robot.scene.surface_marks import (
    ColouredTriangles,
    SurfaceMarks,
    add_mark,
    empty_mesh,
    fill_mesh,
    quads,
    tangent_axes,
)

_SIZES = {Fault.BLIND: 0.5, Fault.DEAD: 0.3, Fault.STUCK: 0.3}
"""Half a mark, as a share of the root of its taxel's area."""
_RIM = "#ffffff"
_INK = "#1d2126"
_WIDTHS = {_RIM: 0.12, _INK: 0.06}
"""Width of a line, likewise."""
_LIFTS = {_RIM: 0.04, _INK: 0.06}
"""Height above the skin, likewise, so that its curvature does not hide the marks."""


class FaultMarks(SurfaceMarks):
    """One actor a patch, in the frame of its link. Mutable; ``show`` replaces all marks.

    Args:
        plotter: Where to draw.
        theme: Of everything that is not skin.
        prepared: Whose skin is marked.
    """

    def __init__(self, plotter: Any, theme: Theme, prepared: PreparedScene) -> None:
        super().__init__(theme, prepared)
        self._faults = NO_FAULTS
        self._meshes = [empty_mesh() for _ in prepared.skin.patches]
        self._actors = [add_mark(plotter, mesh) for mesh in self._meshes]
        for actor in self._actors:
            actor.prop.culling = "back"  # on the far side they would show beyond the edge of the body
        self._attach_to_links((self._actors,))

    def show(self, faults: TaxelFaults) -> None:
        """Mark these taxels and no others; nothing for the same again."""
        if faults is not self._faults:
            self._faults = faults
            self._draw()

    def _draw(self) -> None:
        found = {} if self._hidden else self._faults.of(np.zeros(len(self._skin)))
        for number, patch in enumerate(self._skin.patches):
            first, end = self._skin.first[number : number + 2]
            pieces: list[ColouredTriangles] = []
            for fault, size in _SIZES.items():
                marked = np.flatnonzero(found[fault][first:end]) if fault in found else ()
                if len(marked):
                    points = patch.taxels.positions[marked]
                    normals = patch.taxels.normals[marked]
                    scale = np.sqrt(self._skin.areas[first:end][marked])
                    strokes = size * STROKES[fault]
                    pieces += [(_lines(points, normals, scale, strokes, ink), ink) for ink in (_RIM, _INK)]
            fill_mesh(self._meshes[number], self._actors[number], pieces)


def _lines(points: FloatArray, normals: FloatArray, scale: FloatArray, strokes: FloatArray, ink: str) -> FloatArray:
    """(t, 3, 3) triangles of the strokes (s, 2, 2) at each point (k, 3), in units of its ``scale`` (k,) [m]."""
    axes = np.stack(tangent_axes(normals), axis=1)
    ends = np.einsum("sec,kcx->ksex", strokes, axes) + _LIFTS[ink] * normals[:, None, None]
    along = ends[:, :, 1] - ends[:, :, 0]
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    along *= 0.5 * _WIDTHS[ink]
    aside = np.cross(normals[:, None], along)
    start = ends[:, :, 0] - along
    end = ends[:, :, 1] + along
    corners = np.stack([start - aside, end - aside, end + aside, start + aside], axis=2)
    placed = points[:, None, None] + scale[:, None, None, None] * corners
    return quads(placed.reshape(-1, 4, 3))
