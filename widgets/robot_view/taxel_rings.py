"""Rings around taxels on the body, or discs in their place: one small mesh a patch, which moves with its link."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from app.arrays import FloatArray, IntArray
from app.skin.skin import Skin

_SIDES = 20
_INNER = 0.62
_LIFT, _LOW = 1.2e-3, 0.5e-3
"""Of rings and of discs above the skin [m], so that its curvature does not swallow them; other marks lie between."""


class TaxelRings:
    """Flat rings or discs at some taxels of a skin, coloured one by one. Mutable: ``show``, ``colour`` and ``place``.

    Args:
        plotter: Where to draw.
        skin: Whose taxels.
        filled: Discs instead of rings.

    Attributes:
        actors: One for each patch, in the frame of its link.
    """

    def __init__(self, plotter: Any, skin: Skin, *, filled: bool = False) -> None:
        self._plotter, self._skin = plotter, skin
        angle = np.arange(_SIDES) * 2 * np.pi / _SIDES
        self._circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        self._radius = 0.0
        self._inner, self._lift = (0.0, _LOW) if filled else (_INNER, _LIFT)
        self._meshes = [_nothing() for _ in skin.patches]
        self.actors: list[Any] = [self._actor(mesh) for mesh in self._meshes]
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
                made = pv.PolyData.from_regular_faces(np.zeros((2 * _SIDES * len(own), 3)), _halves(len(own)))
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

    def _actor(self, mesh: pv.PolyData) -> Any:
        actor = self._plotter.add_mesh(
            mesh, scalars="ink", rgb=True, lighting=False, pickable=False, reset_camera=False, copy_mesh=False,
            show_scalar_bar=False,
        )  # fmt: skip
        actor.visibility = False
        return actor

    def _rims(self, positions: FloatArray, normals: FloatArray, size: FloatArray) -> FloatArray:
        """(2 * sides * k, 3) points of the inner rims, then of the outer ones."""
        across, along = axes_across(normals)
        middle, size = positions + self._lift * normals, size[:, None]
        spoke = self._circle[:, 0, None, None] * (size * across) + self._circle[:, 1, None, None] * (size * along)
        return np.stack([middle + self._inner * spoke, middle + spoke]).reshape(-1, 3)


def _halves(count: int) -> IntArray:
    """(2 * sides * count, 3) triangles of so many rings, all of one together; points as ``_rims`` has them."""
    numbers = np.arange(2 * _SIDES * count).reshape(2, _SIDES, count)
    (inner, outer), (inner_next, outer_next) = numbers, np.roll(numbers, -1, axis=1)
    halves = np.stack([np.stack([inner, outer, outer_next], -1), np.stack([inner, outer_next, inner_next], -1)])
    return halves.transpose(2, 0, 1, 3).reshape(-1, 3)


def _nothing() -> pv.PolyData:
    mesh = pv.PolyData(np.zeros((3, 3)), faces=[3, 0, 1, 2])
    mesh.cell_data["ink"] = np.zeros((1, 3), np.uint8)
    return mesh


def axes_across(normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors (k, 3) each across ``normals`` (k, 3) and across each other."""
    aside = np.eye(3)[np.abs(normals).argmin(axis=1)]
    across = np.cross(aside, normals)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return across, np.cross(normals, across)
