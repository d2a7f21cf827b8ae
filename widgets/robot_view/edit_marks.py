"""What an edit tool marks on the body, in three dimensions just above the skin: lines, diamonds and tints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pyvista as pv

from app.arrays import FloatArray, IntArray
from app.geometry.mesh import Mesh
from app.session.prepare import Prepared
from widgets.body_marks import NO_MARKS, BodyLine, BodyMarks, BodySpot, Role
from widgets.colours import Theme, rgb
from widgets.edit_tools.areas import area_triangles
from widgets.robot_view.ribbons import diamonds, ribbon

_THIN = 1 / 280
"""Width of a line, as a share of the root of the skin's area."""
_RIM = "#1d2126"
_TINT_OPACITY = 0.4
_SMALL, _LARGE = 2.6, 3.6
"""Half a diamond's diagonal, in widths of a line."""


class EditMarks:
    """Two actors a patch, in the frame of its link: solid marks and tints. Mutable; ``show`` replaces all of them.

    Args:
        plotter: Where to draw.
        theme: Accents.
        prepared: Whose skin is marked.

    Attributes:
        riders: Link number and actor of all that moves with a link.
    """

    def __init__(self, plotter: Any, theme: Theme, prepared: Prepared) -> None:
        self._theme, self._skin, self._marks, self._hidden = theme, prepared.skin, NO_MARKS, False
        self._width = _THIN * float(np.sqrt(sum(patch.surface.area for patch in prepared.skin.patches)))
        self._solids = [_nothing() for _ in prepared.skin.patches]
        self._tints = [_nothing() for _ in prepared.skin.patches]
        self._solid_actors = [_add(plotter, mesh, opacity=1.0) for mesh in self._solids]
        self._tint_actors = [_add(plotter, mesh, opacity=_TINT_OPACITY) for mesh in self._tints]
        links = [prepared.robot.link_index[patch.link] for patch in prepared.skin.patches]
        pairs = (self._solid_actors, self._tint_actors)
        self.riders: list[tuple[int, Any]] = [pair for kind in pairs for pair in zip(links, kind, strict=True)]

    def show(self, marks: BodyMarks) -> None:
        """Show these and no others. Cost: 1 ms for a hundred edges; nothing for the same again."""
        if marks is not self._marks:
            self._marks = marks
            self._draw()

    def hide(self, *, hidden: bool) -> None:
        """Hide everything while the skin is off the body, or show it again."""
        self._hidden = hidden
        self._draw()

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = theme
        self._draw()

    def _draw(self) -> None:
        marks = NO_MARKS if self._hidden else self._marks
        for number, patch in enumerate(self._skin.patches):
            lines = [line for line in marks.lines if line.patch == number]
            spots = [spot for spot in marks.spots if spot.at.patch == number]
            tinted = [tint.vertices for tint in marks.tints if tint.patch == number]
            pieces = [*self._lines(patch.surface, lines), *self._spots(spots)]
            _fill(self._solids[number], self._solid_actors[number], pieces)
            tints = [(self._tint(patch.surface, vertices), self._theme.accent) for vertices in tinted]
            _fill(self._tints[number], self._tint_actors[number], tints)

    def _lines(self, surface: Mesh, lines: Sequence[BodyLine]) -> list[tuple[FloatArray, str]]:
        pieces = []
        for line in lines:
            points, normals = surface.vertices[line.vertices], surface.vertex_normals[line.vertices]
            dash = 5.0 * self._width if line.role.dashed else 0.0
            if line.role is not Role.SEAM:
                pieces.append((ribbon(points, normals, 2.0 * self._width, lift=0.35 * self._width), _RIM))
            pieces.append(
                (ribbon(points, normals, self._width, lift=0.5 * self._width, dash=dash), self._ink(line.role))
            )
        return pieces

    def _spots(self, spots: Sequence[BodySpot]) -> list[tuple[FloatArray, str]]:
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


def _fill(mesh: pv.PolyData, actor: Any, pieces: Sequence[tuple[FloatArray, str]]) -> None:
    """Triangles (t, 3, 3) of each colour, the later ones over the earlier; nothing hides the actor."""
    count = sum(len(triangles) for triangles, _ in pieces)
    actor.visibility = bool(count)
    if count:
        points = np.concatenate([triangles for triangles, _ in pieces]).reshape(-1, 3)
        made = pv.PolyData.from_regular_faces(points, np.arange(len(points)).reshape(-1, 3))
        inks = [np.tile((255 * np.array(rgb(ink))).round().astype(np.uint8), (len(part), 1)) for part, ink in pieces]
        made.cell_data["ink"] = np.concatenate(inks)
        mesh.copy_from(made)
        mesh.cell_data.active_scalars_name = "ink"


def _nothing() -> pv.PolyData:
    mesh = pv.PolyData(np.zeros((3, 3)), faces=[3, 0, 1, 2])
    mesh.cell_data["ink"] = np.zeros((1, 3), np.uint8)
    return mesh


def _add(plotter: Any, mesh: pv.PolyData, *, opacity: float) -> Any:
    actor = plotter.add_mesh(
        mesh, scalars="ink", rgb=True, lighting=False, pickable=False, reset_camera=False, copy_mesh=False,
        show_scalar_bar=False, opacity=opacity,
    )  # fmt: skip
    actor.visibility = False
    return actor
