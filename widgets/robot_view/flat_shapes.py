"""Flat marks on the skin as actors: triangles in their colours, without light, filled again where they change."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pyvista as pv

from app.arrays import FloatArray
from app.skin.skin import Skin
from widgets.colours import rgb

_THIN = 1 / 280
"""Width of a line, as a share of the root of the skin's area."""
Piece = tuple[FloatArray, str]
"""Triangles (t, 3, 3) [m] and their colour, as hex."""


def line_width(skin: Skin) -> float:
    """How wide a line is drawn on a skin [m]."""
    return _THIN * float(np.sqrt(sum(patch.surface.area for patch in skin.patches)))


def fill(mesh: pv.PolyData, actor: Any, pieces: Sequence[Piece]) -> None:
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


def nothing() -> pv.PolyData:
    """A mesh that ``fill`` can fill."""
    mesh = pv.PolyData(np.zeros((3, 3)), faces=[3, 0, 1, 2])
    mesh.cell_data["ink"] = np.zeros((1, 3), np.uint8)
    return mesh


def add(plotter: Any, mesh: pv.PolyData, *, opacity: float = 1.0) -> Any:
    """Its actor, hidden until it is filled."""
    actor = plotter.add_mesh(
        mesh, scalars="ink", rgb=True, lighting=False, pickable=False, reset_camera=False, copy_mesh=False,
        show_scalar_bar=False, opacity=opacity,
    )  # fmt: skip
    actor.visibility = False
    return actor
