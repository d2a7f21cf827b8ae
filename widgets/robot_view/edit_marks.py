"""What an edit tool marks on the body, in three dimensions just above the skin: lines, diamonds and tints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from app.arrays import FloatArray, IntArray
from app.geometry.mesh import Mesh
from app.session.prepare import Prepared
from widgets.body_marks import NO_MARKS, BodyLine, BodyMarks, BodySpot, BodyStroke, Role
from widgets.colours import Theme
from widgets.edit_tools.areas import area_triangles
from widgets.robot_view.flat_shapes import Piece, add, fill, nothing
from widgets.robot_view.link_marks import LinkMarks
from widgets.robot_view.ribbons import diamonds, ribbon

_RIM = "#1d2126"
_TINT_OPACITY = 0.4
_SMALL, _LARGE = 2.6, 3.6
"""Half a diamond's diagonal, in widths of a line."""


class EditMarks(LinkMarks):
    """Two actors a patch, in the frame of its link: solid marks and tints. Mutable; ``show`` replaces all of them.

    Args:
        plotter: Where to draw.
        theme: Accents.
        prepared: Whose skin is marked.

    Attributes:
        riders: Link number and actor of all that moves with a link.
    """

    def __init__(self, plotter: Any, theme: Theme, prepared: Prepared) -> None:
        super().__init__(theme, prepared)
        self._marks = NO_MARKS
        self._solids = [nothing() for _ in prepared.skin.patches]
        self._tints = [nothing() for _ in prepared.skin.patches]
        self._solid_actors = [add(plotter, mesh) for mesh in self._solids]
        self._tint_actors = [add(plotter, mesh, opacity=_TINT_OPACITY) for mesh in self._tints]
        self._ride((self._solid_actors, self._tint_actors))

    def show(self, marks: BodyMarks) -> None:
        """Show these and no others. Cost: 1 ms for a hundred edges; nothing for the same again."""
        if marks is not self._marks:
            self._marks = marks
            self._draw()

    def _draw(self) -> None:
        marks = NO_MARKS if self._hidden else self._marks
        for number, patch in enumerate(self._skin.patches):
            lines = [line for line in marks.lines if line.patch == number]
            spots = [spot for spot in marks.spots if spot.at.patch == number]
            tinted = [tint.vertices for tint in marks.tints if tint.patch == number]
            strokes = [stroke for stroke in marks.strokes if stroke.line.patch == number]
            pieces = [*self._lines(patch.surface, lines), *self._strokes(strokes), *self._spots(spots)]
            fill(self._solids[number], self._solid_actors[number], pieces)
            tints = [(self._tint(patch.surface, vertices), self._theme.accent) for vertices in tinted]
            fill(self._tints[number], self._tint_actors[number], tints)

    def _lines(self, surface: Mesh, lines: Sequence[BodyLine]) -> list[Piece]:
        return [
            piece
            for line in lines
            for piece in self._line(surface.vertices[line.vertices], surface.vertex_normals[line.vertices], line.role)
        ]

    def _strokes(self, strokes: Sequence[BodyStroke]) -> list[Piece]:
        return [
            piece for stroke in strokes for piece in self._line(stroke.line.on_body, stroke.line.normals, stroke.role)
        ]

    def _line(self, points: FloatArray, normals: FloatArray, role: Role) -> list[Piece]:
        dash = 5.0 * self._width if role.dashed else 0.0
        top = ribbon(points, normals, self._width, lift=0.5 * self._width, dash=dash), self._ink(role)
        if role is Role.SEAM:
            return [top]
        return [(ribbon(points, normals, 2.0 * self._width, lift=0.35 * self._width), _RIM), top]

    def _spots(self, spots: Sequence[BodySpot]) -> list[Piece]:
        if not spots:
            return []
        points = np.array([self._skin.position(spot.at) for spot in spots])
        normals = np.array([self._skin.normal(spot.at) for spot in spots])
        half = self._width * np.array([_LARGE if spot.large else _SMALL for spot in spots])
        rims = diamonds(points + 0.7 * self._width * normals, normals, half + 0.9 * self._width)
        tops = diamonds(points + 0.95 * self._width * normals, normals, half)
        inks = [self._ink(spot.role) for spot in spots]
        return [(rims, _RIM), *zip(tops.reshape(len(spots), -1, 3, 3), inks, strict=True)]

    def _tint(self, surface: Mesh, vertices: IntArray) -> FloatArray:
        """(t, 3, 3) the area around ``vertices``."""
        marked = np.zeros(len(surface.vertices), bool)
        marked[vertices] = True
        ends = area_triangles(surface.faces, marked)
        return (surface.vertices[ends] + 0.2 * self._width * surface.vertex_normals[ends]).mean(axis=2)

    def _ink(self, role: Role) -> str:
        return role.ink(self._theme)
