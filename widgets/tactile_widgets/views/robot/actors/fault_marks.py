"""Marks of dead, stuck and blind taxels on the body, in the same shapes as on the map."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import Theme
from tactile_widgets.overlays.taxel_faults import NO_FAULTS, STROKES, Fault, TaxelFaults
from tactile_widgets.views.robot.actors.surface_marks import (
    ColouredTriangles,
    SurfaceMarks,
    quads,
    tangent_axes,
)

_SIZES = {Fault.BLIND: 0.5, Fault.DEAD: 0.3, Fault.STUCK: 0.3}
"""Half the size of a mark, as a fraction of the square root of its taxel's area."""
_RIM = "#ffffff"
_INK = "#1d2126"
_WIDTHS = {_RIM: 0.12, _INK: 0.06}
"""Width of a line, in the same unit."""
_LIFTS = {_RIM: 0.04, _INK: 0.06}
"""Height above the skin, in the same unit, so that its curvature does not hide the marks."""


class FaultMarks(SurfaceMarks):
    """Marks of faulty taxels; ``show`` replaces all of them.

    Args:
        plotter: Plotter that draws them.
        theme: Colours of everything except the skin.
        prepared: Robot and skin.
    """

    def __init__(self, plotter: Any, theme: Theme, prepared: PreparedScene) -> None:
        super().__init__(theme, prepared)
        self._faults = NO_FAULTS
        self._marks = self._make_marks(plotter)
        for mark in self._marks:
            mark.actor.prop.culling = "back"  # on the far side they would show beyond the edge of the body

    def show(self, faults: TaxelFaults) -> None:
        """Show these marks only; does nothing for the same object."""
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
            self._marks[number].fill(pieces)


def _lines(points: FloatArray, normals: FloatArray, scale: FloatArray, strokes: FloatArray, ink: str) -> FloatArray:
    """(t, 3, 3) triangles of the strokes (s, 2, 2) at each point (k, 3), in multiples of its ``scale`` (k,) [m]."""
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
