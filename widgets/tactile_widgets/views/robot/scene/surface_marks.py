"""How meshes are handed to VTK, and flat marks that lie on the curved skin.

Marks are rings or discs at taxels, ribbons along lines, arrowheads, diamonds: triangles first, then the actors that
show them in their colours, without light, filled again where they change. ``SurfaceMarks`` is the base of all marks
that move with a link, take a theme, and are hidden while the skin is off the body.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkRenderingCore import vtkPolyDataMapper

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.common.colours import Theme, rgb

MATTE: dict[str, Any] = {"interpolation": "Phong", "ambient": 0.34, "diffuse": 0.70, "specular": 0.0}
"""How surfaces of robots and skins take the light, as ``pyvista.Property`` has it."""


def set_matrix(actor: Any, matrix: FloatArray) -> None:
    """Place an actor by a (4, 4) matrix, in place."""
    own = actor.GetUserMatrix()
    if own is None:
        own = vtkMatrix4x4()
        actor.SetUserMatrix(own)
    own.DeepCopy(matrix.ravel())


def polydata(vertices: FloatArray, normals: FloatArray, faces: IntArray) -> pv.PolyData:
    """Points (n, 3), unit normals (n, 3) and triangles (m, 3) as copies for VTK, so that it computes no normals."""
    surface = pv.PolyData.from_regular_faces(vertices.copy(), faces.copy())
    surface.point_data.active_normals = normals.copy()
    return surface


def add_surface(
    plotter: Any,
    mesh: pv.PolyData,
    colour: str | None = None,
    *,
    texture: pv.Texture | None = None,
    pickable: bool = True,
    **look: Any,
) -> pv.Actor:
    """A lit actor of ``mesh``: what changes of it is drawn from then on.

    Args:
        plotter: Where to draw.
        mesh: With its normals; not copied.
        colour: Without one, and without a texture, each point has its own, in the active scalars.
        texture: Where the points of the mesh have texture coordinates.
        pickable: Whether VTK's pickers meet it.
        look: As ``pyvista.Property`` has it, beside or instead of ``MATTE``.

    Cost: 0.5 ms. PyVista's ``add_mesh`` takes 4 ms, and its filters, written in Python, would find normals and scalars
    anew in each picture, and again for the depth that it takes (2 ms a picture of our arm).
    """
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(mesh)
    mapper.SetScalarModeToUsePointData()
    mapper.SetColorModeToDirectScalars()
    mapper.SetScalarVisibility(colour is None and texture is None)
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
    """An actor of ``mesh``, hidden until it is placed or filled; without ``colour`` each cell has its own, ``ink``.

    Cost: 0.1 ms. PyVista's ``add_mesh`` takes 1.2 ms, most of it for a table of colours that no mark looks up, and a
    robot has seventy marks.
    """
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(mesh)
    mapper.SetScalarModeToUseCellData()
    mapper.SetColorModeToDirectScalars()
    mapper.SetScalarVisibility(colour is None)
    actor = pv.Actor(mapper, pv.Property(color=colour, lighting=lit, opacity=opacity, line_width=line_width))
    actor.visibility = False
    plotter.add_actor(actor, pickable=False, reset_camera=False, render=False)
    return actor


_SIDES = 20
_INNER = 0.62
_LIFT = 1.2e-3
_LOW = 0.5e-3
"""Of rings and of discs above the skin [m], so that its curvature does not swallow them; other marks lie between."""


class TaxelMarkers:
    """Flat rings or discs at some taxels of a skin, coloured one by one. Mutable: ``show``, ``colour`` and ``place``.

    Args:
        plotter: Where to draw.
        skin: Whose taxels.
        filled: Discs instead of rings.

    Attributes:
        actors: One for each patch, in the frame of its link.
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
        """Show these taxels (k,), in these colours (k, 3), and no others, on the body.

        ``radius`` is a share of each taxel's own size, the root of its area.
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
        """Put each patch's taxels at positions (n, 3) [m] with unit normals (n, 3), in the frame its actor is in."""
        for number, (mesh, own) in enumerate(zip(self._meshes, self._shown, strict=True)):
            if len(own):
                local = own - self._skin.first[number]
                size = self._radius * np.sqrt(self._skin.areas[own])
                mesh.points[:] = self._rims(positions[number][local], normals[number][local], size)
                mesh.GetPoints().Modified()
                mesh.Modified()

    def colour(self, taxels: IntArray, colours: NDArray[np.uint8]) -> None:
        """Give the taxels that are shown, the same (k,), other colours (k, 3)."""
        start = 0
        for mesh, own in zip(self._meshes, self._shown, strict=True):
            if len(own):
                mesh.cell_data["ink"][:] = np.repeat(colours[start : start + len(own)], 2 * _SIDES, axis=0)
                mesh.GetCellData().GetArray("ink").Modified()
            start += len(own)

    def _rims(self, positions: FloatArray, normals: FloatArray, size: FloatArray) -> FloatArray:
        """(2 * sides * k, 3) points of the inner rims, then of the outer ones."""
        across, along = tangent_axes(normals)
        middle = positions + self._lift * normals
        size = size[:, None]
        spoke = self._circle[:, 0, None, None] * (size * across) + self._circle[:, 1, None, None] * (size * along)
        return np.stack([middle + self._inner * spoke, middle + spoke]).reshape(-1, 3)


def _ring_triangles(count: int) -> IntArray:
    """(2 * sides * count, 3) triangles of so many rings, all of one together; points as ``_rims`` has them."""
    numbers = np.arange(2 * _SIDES * count).reshape(2, _SIDES, count)
    (inner, outer), (inner_next, outer_next) = numbers, np.roll(numbers, -1, axis=1)
    halves = np.stack([np.stack([inner, outer, outer_next], -1), np.stack([inner, outer_next, inner_next], -1)])
    return halves.transpose(2, 0, 1, 3).reshape(-1, 3)


def tangent_axes(normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors (k, 3) each across ``normals`` (k, 3) and across each other."""
    aside = np.eye(3)[np.abs(normals).argmin(axis=1)]
    across = np.cross(aside, normals)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return across, np.cross(normals, across)


_GAP = 0.6
"""Of a dash, the length of the gap after it."""


def ribbon(
    points: FloatArray, normals: FloatArray, width: float | FloatArray, *, lift: float, dash: float = 0.0
) -> FloatArray:
    """(t, 3, 3) triangles of a ribbon along a line over a surface.

    Args:
        points: (k, 3) [m] of the line, at least one.
        normals: (k, 3) unit, of the surface there.
        width: Across [m]; of a whole line also (k - 1,), of each side.
        lift: How far above the surface [m].
        dash: Length of a dash [m]; 0 for none.
    """
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    breaks = along
    if dash > 0:
        turns = np.arange(0.0, along[-1], (1 + _GAP) * dash)
        breaks = np.unique(np.clip(np.concatenate([along, turns, turns + dash]), 0, along[-1]))
    place, up = (np.stack([np.interp(breaks, along, part[:, k]) for k in range(3)], 1) for part in (points, normals))
    place = place + lift * up
    step = np.diff(place, axis=0)
    middle = 0.5 * (breaks[1:] + breaks[:-1])
    shown = np.linalg.norm(step, axis=1) > 0
    if dash > 0:
        shown &= middle % ((1 + _GAP) * dash) < dash
    widths = np.broadcast_to(np.asarray(width, dtype=np.float64), len(step))
    aside = _unit(np.cross(up[1:] + up[:-1], step))
    # At a bend both sides end alike, or there would be a notch.
    ends = _unit(np.concatenate([aside[:1], _unit(aside[1:] + aside[:-1]), aside[-1:]]))
    before = 0.5 * widths[:, None] * ends[:-1]
    after = 0.5 * widths[:, None] * ends[1:]
    corners = np.stack([place[:-1] - before, place[1:] - after, place[1:] + after, place[:-1] + before], axis=1)
    return quads(corners[shown])


def _unit(vectors: FloatArray) -> FloatArray:
    """(k, 3) of length 1, or 0 where they were."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)


def arrowheads(points: FloatArray, normals: FloatArray, size: float, *, every: float, lift: float) -> FloatArray:
    """(t, 3, 3) triangles that point along a line (k, 3) over a surface.

    Args:
        points: Of the line [m].
        normals: (k, 3) unit, of the surface there.
        size: Length and width of each [m].
        every: From one to the next [m]; on a short line there is one, in its middle.
        lift: How far above the surface [m].
    """
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    back = np.arange(min(every / 3, along[-1] / 2), along[-1] - size, every)
    ends = (np.stack([np.interp(at, along, points[:, k]) for k in range(3)], 1) for at in (back, back + size))
    tail, tip = ends
    up = np.stack([np.interp(back, along, normals[:, k]) for k in range(3)], 1)
    aside = np.cross(up, tip - tail)
    aside *= 0.5 * size / np.maximum(np.linalg.norm(aside, axis=1, keepdims=True), 1e-12)
    return np.stack([tail - aside, tip, tail + aside], axis=1) + lift * up[:, None]


def diamonds(points: FloatArray, normals: FloatArray, half: FloatArray) -> FloatArray:
    """(2 k, 3, 3) triangles of diamonds around ``points`` (k, 3), half their diagonals ``half`` (k,) [m]."""
    across, up = (half[:, None] * axis for axis in tangent_axes(normals))
    return quads(np.stack([points + across, points + up, points - across, points - up], axis=1))


def quads(corners: FloatArray) -> FloatArray:
    """(2 k, 3, 3) triangles of quadrilaterals (k, 4, 3), two after each other."""
    return corners[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)


_LINE_SHARE = 1 / 280
"""Width of a line, as a share of the root of the skin's area."""
ColouredTriangles = tuple[FloatArray, str]
"""Triangles (t, 3, 3) [m] and their colour, as hex."""


def line_width(skin: Skin) -> float:
    """How wide a line is drawn on a skin [m]."""
    return _LINE_SHARE * float(np.sqrt(sum(patch.surface.area for patch in skin.patches)))


def fill_mesh(mesh: pv.PolyData, actor: Any, pieces: Sequence[ColouredTriangles]) -> None:
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


def empty_mesh() -> pv.PolyData:
    """A mesh that ``fill`` can fill."""
    mesh = pv.PolyData(np.zeros((3, 3)), faces=[3, 0, 1, 2])
    mesh.cell_data["ink"] = np.zeros((1, 3), np.uint8)
    return mesh


class SurfaceMarks(ABC):
    """Actors a patch, in the frame of its link. Mutable.

    Args:
        theme: Of their colours.
        prepared: Whose skin is marked.

    Attributes:
        link_actors: Link number and actor of all that moves with a link.
    """

    def __init__(self, theme: Theme, prepared: PreparedScene) -> None:
        self._theme = theme
        self._skin = prepared.skin
        self._hidden = False
        self._width = line_width(prepared.skin)
        self._links = [prepared.robot.link_index[patch.link] for patch in prepared.skin.patches]
        self.link_actors: list[tuple[int, Any]] = []

    def _attach_to_links(self, kinds: Iterable[Sequence[Any]]) -> None:
        """Let actors, one a patch of each kind, move with their links."""
        self.link_actors = [pair for kind in kinds for pair in zip(self._links, kind, strict=True)]

    def hide(self, *, hidden: bool) -> None:
        """Hide everything while the skin is off the body, or show it again."""
        self._hidden = hidden
        self._draw()

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = theme
        self._draw()

    @abstractmethod
    def _draw(self) -> None:
        """Draw all of it anew."""
