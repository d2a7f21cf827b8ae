"""Meshes for VTK, and flat marks on the curved skin.

Marks are rings or discs at taxels, ribbons along lines, arrowheads, diamonds: triangles, drawn by actors without light.
``SurfaceMarks`` is the base class of all marks that move with a link and are hidden while the skin is off the body.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkRenderingCore import vtkPolyDataMapper

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.geometry.surface.points import cumulative_lengths, points_along
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.common.colours import Theme, rgb

MATTE: dict[str, Any] = {"interpolation": "Phong", "ambient": 0.34, "diffuse": 0.70, "specular": 0.0}
"""Lighting of robots and skins, as arguments of ``pyvista.Property``."""


def set_matrix(actor: Any, matrix: FloatArray) -> None:
    """Place an actor by a (4, 4) matrix, in place."""
    own = actor.GetUserMatrix()
    if own is None:
        own = vtkMatrix4x4()
        actor.SetUserMatrix(own)
    own.DeepCopy(matrix.ravel())


def polydata(vertices: FloatArray, normals: FloatArray, faces: IntArray) -> pv.PolyData:
    """Return a mesh with copies of points (n, 3), unit normals (n, 3), so that VTK computes none, and faces (m, 3)."""
    surface = pv.PolyData.from_regular_faces(vertices.copy(), faces.copy())
    surface.point_data.active_normals = normals.copy()
    return surface


def _mapper(mesh: pv.PolyData, *, coloured: bool) -> vtkPolyDataMapper:
    """Return a mapper of ``mesh``; with ``coloured``, its scalars are colours."""
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(mesh)
    mapper.SetColorModeToDirectScalars()
    mapper.SetScalarVisibility(coloured)
    return mapper


def add_surface(
    plotter: Any,
    mesh: pv.PolyData,
    colour: str | None = None,
    *,
    texture: pv.Texture | None = None,
    pickable: bool = True,
    **look: Any,
) -> pv.Actor:
    """Add a lit actor of ``mesh``; later changes of the mesh are drawn.

    Args:
        plotter: Plotter that draws it.
        mesh: Mesh with normals; not copied.
        colour: Colour of the surface; without it and a texture, each point has its own in the active scalars.
        texture: Texture, if the points of the mesh have texture coordinates.
        pickable: Whether VTK's pickers find it.
        look: Arguments of ``pyvista.Property``, which override ``MATTE``.

    Cost: 0.5 ms. PyVista's ``add_mesh`` takes 4 ms, and its Python filters would compute normals and scalars again for
    each picture, and for its depth (2 ms per picture of our arm).
    """
    mapper = _mapper(mesh, coloured=colour is None and texture is None)
    mapper.SetScalarModeToUsePointData()
    actor = pv.Actor(mapper, pv.Property(color=colour or "white", **(MATTE | look)))
    if texture is not None:
        actor.SetTexture(texture)
    plotter.add_actor(actor, pickable=pickable, reset_camera=False, render=False)
    return actor


def add_mark(
    plotter: Any,
    mesh: pv.PolyData,
    colour: str | None = None,
    *,
    lit: bool = False,
    opacity: float = 1.0,
    line_width: float | None = None,
) -> pv.Actor:
    """Add an actor of ``mesh``, hidden at first; without ``colour`` each cell has its own in ``ink``.

    Cost: 0.1 ms. PyVista's ``add_mesh`` takes 1.2 ms, mostly for a colour table that no mark uses, and a robot has
    seventy marks.
    """
    mapper = _mapper(mesh, coloured=colour is None)
    mapper.SetScalarModeToUseCellData()
    actor = pv.Actor(mapper, pv.Property(color=colour, lighting=lit, opacity=opacity, line_width=line_width))
    actor.visibility = False
    plotter.add_actor(actor, pickable=False, reset_camera=False, render=False)
    return actor


_SIDES = 20
_INNER = 0.62
_LIFT = 1.2e-3
_LOW = 0.5e-3
"""Height of rings and of discs above the skin [m], so that its curvature hides none; other marks are between."""


class TaxelMarkers:
    """Flat rings or discs at some taxels of a skin, each in its own colour.

    Args:
        plotter: Plotter that draws them.
        skin: The skin.
        filled: Whether they are discs rather than rings.

    Attributes:
        actors: One actor per patch, in the frame of its link.
    """

    def __init__(self, plotter: Any, skin: Skin, *, filled: bool = False) -> None:
        self._skin = skin
        angle = np.arange(_SIDES) * 2 * np.pi / _SIDES
        self._circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        self._radius = 0.0
        self._inner, self._lift = (0.0, _LOW) if filled else (_INNER, _LIFT)
        self._meshes = [empty_mesh() for _ in skin.patches]
        self.actors: list[Any] = [add_mark(plotter, mesh) for mesh in self._meshes]
        self._shown: list[IntArray] = [np.zeros(0, int) for _ in skin.patches]

    def show(self, taxels: IntArray, colours: NDArray[np.uint8], *, radius: float) -> None:
        """Show these taxels (k,) only, in these colours (k, 3), on the body.

        ``radius`` is a fraction of each taxel's size, the square root of its area.
        """
        self._radius = radius
        for number, (actor, mesh) in enumerate(zip(self.actors, self._meshes, strict=True)):
            first, end = self._skin.first[number : number + 2]
            own = taxels[(taxels >= first) & (taxels < end)]
            self._shown[number] = own
            actor.visibility = bool(len(own))
            if len(own):
                made = pv.PolyData.from_regular_faces(np.zeros((2 * _SIDES * len(own), 3)), _ring_triangles(len(own)))
                made.cell_data["ink"] = np.zeros((made.n_cells, 3), np.uint8)
                mesh.copy_from(made)
                mesh.cell_data.active_scalars_name = "ink"
        self.colour(taxels, colours)
        felt = [patch.taxels for patch in self._skin.patches]
        self.place([part.positions for part in felt], [part.normals for part in felt])

    def place(self, positions: Sequence[FloatArray], normals: Sequence[FloatArray]) -> None:
        """Move each patch's taxels to positions (n, 3) [m] with unit normals (n, 3), in the frame of its actor."""
        for number, (mesh, own) in enumerate(zip(self._meshes, self._shown, strict=True)):
            if len(own):
                local = own - self._skin.first[number]
                size = self._radius * np.sqrt(self._skin.areas[own])
                mesh.points[:] = self._rims(positions[number][local], normals[number][local], size)
                mesh.GetPoints().Modified()
                mesh.Modified()

    def colour(self, taxels: IntArray, colours: NDArray[np.uint8]) -> None:
        """Change the colours (k, 3) of the taxels that are shown, the same (k,)."""
        start = 0
        for mesh, own in zip(self._meshes, self._shown, strict=True):
            if len(own):
                mesh.cell_data["ink"][:] = np.repeat(colours[start : start + len(own)], 2 * _SIDES, axis=0)
                mesh.GetCellData().GetArray("ink").Modified()
            start += len(own)

    def _rims(self, positions: FloatArray, normals: FloatArray, size: FloatArray) -> FloatArray:
        """(2 * sides * k, 3) points of the inner rims, then of the outer rims."""
        across, along = tangent_axes(normals)
        middle = positions + self._lift * normals
        size = size[:, None]
        spoke = self._circle[:, 0, None, None] * (size * across) + self._circle[:, 1, None, None] * (size * along)
        return np.stack([middle + self._inner * spoke, middle + spoke]).reshape(-1, 3)


def _ring_triangles(count: int) -> IntArray:
    """(2 * sides * count, 3) triangles of this number of rings, ring by ring; points are in the order of ``_rims``."""
    numbers = np.arange(2 * _SIDES * count).reshape(2, _SIDES, count)
    inner, outer = numbers
    inner_next, outer_next = np.roll(numbers, -1, axis=1)
    halves = np.stack([np.stack([inner, outer, outer_next], -1), np.stack([inner, outer_next, inner_next], -1)])
    return halves.transpose(2, 0, 1, 3).reshape(-1, 3)


def tangent_axes(normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two unit vectors (k, 3) each, perpendicular to ``normals`` (k, 3) and to each other."""
    aside = np.eye(3)[np.abs(normals).argmin(axis=1)]
    across = np.cross(aside, normals)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return across, np.cross(normals, across)


_GAP = 0.6
"""Length of a gap, as a fraction of the dash before it."""


def ribbon(
    points: FloatArray, normals: FloatArray, width: float | FloatArray, *, lift: float, dash: float = 0.0
) -> FloatArray:
    """(t, 3, 3) triangles of a ribbon along a line over a surface.

    Args:
        points: (k, 3) points of the line [m], at least one.
        normals: (k, 3) unit normals of the surface there.
        width: Width [m]; for a solid line also (k - 1,), the width of each side.
        lift: Height above the surface [m].
        dash: Length of a dash [m]; 0 for a solid line.
    """
    along = cumulative_lengths(points)
    breaks = along
    if dash > 0:
        turns = np.arange(0.0, along[-1], (1 + _GAP) * dash)
        breaks = np.unique(np.clip(np.concatenate([along, turns, turns + dash]), 0, along[-1]))
    place, up = (points_along(part, along, breaks) for part in (points, normals))
    place = place + lift * up
    step = np.diff(place, axis=0)
    middle = 0.5 * (breaks[1:] + breaks[:-1])
    shown = np.linalg.norm(step, axis=1) > 0
    if dash > 0:
        shown &= middle % ((1 + _GAP) * dash) < dash
    widths = np.broadcast_to(np.asarray(width, dtype=np.float64), len(step))
    aside = _unit(np.cross(up[1:] + up[:-1], step))
    # At a bend, both sides end on one line; otherwise there would be a notch.
    ends = _unit(np.concatenate([aside[:1], _unit(aside[1:] + aside[:-1]), aside[-1:]]))
    before = 0.5 * widths[:, None] * ends[:-1]
    after = 0.5 * widths[:, None] * ends[1:]
    corners = np.stack([place[:-1] - before, place[1:] - after, place[1:] + after, place[:-1] + before], axis=1)
    return quads(corners[shown])


def _unit(vectors: FloatArray) -> FloatArray:
    """(k, 3) vectors of length 1; zero vectors are unchanged."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)


def arrowheads(points: FloatArray, normals: FloatArray, size: float, *, every: float, lift: float) -> FloatArray:
    """(t, 3, 3) triangles that point along a line (k, 3) over a surface.

    Args:
        points: Points of the line [m].
        normals: (k, 3) unit normals of the surface there.
        size: Length and width of each arrowhead [m].
        every: Distance between arrowheads [m]; a short line has one in its middle.
        lift: Height above the surface [m].
    """
    along = cumulative_lengths(points)
    back = np.arange(min(every / 3, along[-1] / 2), along[-1] - size, every)
    tail, tip = (points_along(points, along, at) for at in (back, back + size))
    up = points_along(normals, along, back)
    aside = np.cross(up, tip - tail)
    aside *= 0.5 * size / np.maximum(np.linalg.norm(aside, axis=1, keepdims=True), 1e-12)
    return np.stack([tail - aside, tip, tail + aside], axis=1) + lift * up[:, None]


def diamonds(points: FloatArray, normals: FloatArray, half: FloatArray) -> FloatArray:
    """(2 k, 3, 3) triangles of diamonds around ``points`` (k, 3) with half diagonals ``half`` (k,) [m]."""
    across, up = (half[:, None] * axis for axis in tangent_axes(normals))
    return quads(np.stack([points + across, points + up, points - across, points - up], axis=1))


def quads(corners: FloatArray) -> FloatArray:
    """(2 k, 3, 3) triangles of quadrilaterals (k, 4, 3), two for each."""
    return corners[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)


_LINE_SHARE = 1 / 280
"""Width of a line as a fraction of the square root of the skin's area."""
ColouredTriangles = tuple[FloatArray, str]
"""Triangles (t, 3, 3) [m] and their colour, as hex."""


def line_width(skin: Skin) -> float:
    """Return the width of a line on a skin [m]."""
    return _LINE_SHARE * float(np.sqrt(sum(patch.surface.area for patch in skin.patches)))


def empty_mesh() -> pv.PolyData:
    """Make a mesh with a colour for each cell, to be filled later."""
    mesh = pv.PolyData(np.zeros((3, 3)), faces=[3, 0, 1, 2])
    mesh.cell_data["ink"] = np.zeros((1, 3), np.uint8)
    return mesh


class FlatMarks:
    """An actor of coloured triangles without light.

    Args:
        plotter: Plotter that draws it.
        opacity: Opacity, 0 to 1.
    """

    def __init__(self, plotter: Any, *, opacity: float = 1.0) -> None:
        self._mesh = empty_mesh()
        self.actor = add_mark(plotter, self._mesh, opacity=opacity)

    def fill(self, pieces: Sequence[ColouredTriangles]) -> None:
        """Replace all triangles; later pieces are drawn over earlier ones."""
        count = sum(len(triangles) for triangles, _ in pieces)
        self.actor.visibility = bool(count)
        if count:
            points = np.concatenate([triangles for triangles, _ in pieces]).reshape(-1, 3)
            made = pv.PolyData.from_regular_faces(points, np.arange(len(points)).reshape(-1, 3))
            colours = [(255 * np.array(rgb(ink))).round().astype(np.uint8) for _, ink in pieces]
            made.cell_data["ink"] = np.repeat(colours, [len(triangles) for triangles, _ in pieces], axis=0)
            self._mesh.copy_from(made)
            self._mesh.cell_data.active_scalars_name = "ink"


class SurfaceMarks(ABC):
    """Marks on the skin that move with its links.

    Args:
        theme: Colours of the marks.
        prepared: Robot and skin.

    Attributes:
        link_actors: Link number and actor of everything that moves with a link.
    """

    def __init__(self, theme: Theme, prepared: PreparedScene) -> None:
        self._theme = theme
        self._skin = prepared.skin
        self._hidden = False
        self._width = line_width(prepared.skin)
        self._links = [prepared.robot.link_index[patch.link] for patch in prepared.skin.patches]
        self.link_actors: list[tuple[int, Any]] = []

    def _make_marks(self, plotter: Any, *, opacity: float = 1.0) -> list[FlatMarks]:
        """Make one actor per patch, in the frame of its link."""
        marks = [FlatMarks(plotter, opacity=opacity) for _ in self._links]
        self.link_actors += [(link, each.actor) for link, each in zip(self._links, marks, strict=True)]
        return marks

    def hide(self, *, hidden: bool) -> None:
        """Hide everything while the skin is off the body, or show it again."""
        self._hidden = hidden
        self._draw()

    def set_theme(self, theme: Theme) -> None:
        """Set the theme."""
        self._theme = theme
        self._draw()

    @abstractmethod
    def _draw(self) -> None:
        """Draw all marks again."""
