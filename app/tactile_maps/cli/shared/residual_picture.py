"""Picture of the residuals of placed taxels: the mesh in two views, with a vector from each taxel to the mesh."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray
from tactile_maps.geometry.surface.closest_point import closest_point
from tactile_maps.geometry.surface.mesh import Mesh

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection

_TILT = np.radians(55.0)
"""Angle of each view from the mean normal of the taxels."""
_MARGIN = 0.15
"""Part of the mesh around the taxels that is drawn, as a share of their extent."""
_LONGEST = 0.06
"""Length of the longest vector, as a share of the extent of the taxels."""
_FACTORS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
"""Possible exaggerations of the vectors."""
_LIGHT = 0.95
"""Grey of faces that face the viewer."""
_DARK = 0.55
"""Grey of faces that are seen from the side."""
_COLOURS = "plasma"


def residual_picture(mesh: Mesh, stated: FloatArray, placed: FloatArray) -> bytes:
    """Return a PNG of the mesh with taxels and vectors to the closest points of the mesh, stated and placed.

    Vectors of a row are exaggerated by the same factor, which its title states.

    Args:
        mesh: Mesh of the link [m].
        stated: (k, 3) stated positions of the taxels [m], frame of the mesh.
        placed: (k, 3) positions after the displacement [m].
    """
    from matplotlib.figure import Figure

    vectors = [_to_mesh(mesh, positions) for positions in (stated, placed)]
    most = 1e3 * max(float(np.linalg.norm(each, axis=1).max()) for each in vectors)
    figure = Figure(figsize=(9.0, 7.4), layout="constrained")
    grid = figure.subplots(2, 2)
    directions = _directions(mesh, placed)
    outward = mesh.face_normals[closest_point(mesh).query(placed)[0]]
    for axes, name, positions, away in zip(grid, ("As stated", "Placed"), (stated, placed), vectors, strict=True):
        lengths = 1e3 * np.linalg.norm(away, axis=1)
        factor = _factor(positions, lengths)
        for one, view in zip(axes, directions, strict=True):
            _draw_mesh(one, mesh, positions, view)
            marks = _draw_taxels(one, positions, factor * away, lengths, view, shown=outward @ view[2] > 0, most=most)
        text = f"{name}: {lengths.mean():.2f} mm from the mesh (mean), vectors × {factor:g}"
        axes[0].set_title(text, fontsize=8, loc="left")
        figure.colorbar(marks, ax=axes, label="distance from the mesh [mm]", shrink=0.8)
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=110)
    return file.getvalue()


def _to_mesh(mesh: Mesh, positions: FloatArray) -> FloatArray:
    """Return (k, 3) vectors from positions (k, 3) to their closest points on the mesh [m]."""
    faces, weights, _ = closest_point(mesh).query(positions)
    return np.einsum("ij,ijk->ik", weights, mesh.vertices[mesh.faces[faces]]) - positions


def _directions(mesh: Mesh, positions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two views: rows right, up and to the viewer, tilted from the mean normal about the longest axis."""
    faces, _, _ = closest_point(mesh).query(positions)
    axes = np.linalg.svd(positions - positions.mean(axis=0), full_matrices=True)[2]
    up = axes[0]
    outward = mesh.face_normals[faces].mean(axis=0)
    outward = outward - (outward @ up) * up
    length = float(np.linalg.norm(outward))
    outward = outward / length if length > 0.1 else axes[2]
    side = np.cross(up, outward)
    views = []
    for angle in (-_TILT, _TILT):
        toward = np.cos(angle) * outward + np.sin(angle) * side
        views.append(np.array([np.cross(up, toward), up, toward]))
    return views[0], views[1]


def _factor(positions: FloatArray, lengths: FloatArray) -> float:
    """Return the exaggeration with which the longest vector has a readable length."""
    room = 1e3 * _LONGEST * float(np.linalg.norm(np.ptp(positions, axis=0)))
    most = max(float(lengths.max()), 1e-6)
    return max((one for one in _FACTORS if one * most <= room), default=_FACTORS[0])


def _draw_mesh(axes: Axes, mesh: Mesh, positions: FloatArray, view: FloatArray) -> None:
    """Draw the faces around the taxels that face the viewer, the nearest ones last."""
    from matplotlib.collections import PolyCollection

    corners = mesh.vertices[mesh.faces] @ view.T
    facing = mesh.face_normals @ view[2]
    seen = (positions @ view.T)[:, :2]
    low, high = seen.min(axis=0), seen.max(axis=0)
    margin = _MARGIN * float((high - low).max())
    middle = corners.mean(axis=1)
    inside = ((middle[:, :2] >= low - margin) & (middle[:, :2] <= high + margin)).all(axis=1)
    drawn = np.flatnonzero((facing > 0) & inside)
    drawn = drawn[np.argsort(middle[drawn, 2])]
    grey = _DARK + (_LIGHT - _DARK) * facing[drawn]
    colours = np.repeat(grey[:, None], 3, axis=1)
    axes.add_collection(
        PolyCollection(list(corners[drawn, :, :2]), facecolors=colours, edgecolors=colours, linewidths=0.3)
    )
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin)
    axes.set_aspect("equal")
    axes.set_axis_off()


def _draw_taxels(
    axes: Axes,
    positions: FloatArray,
    vectors: FloatArray,
    lengths: FloatArray,
    view: FloatArray,
    *,
    shown: BoolArray,
    most: float,
) -> PathCollection:
    """Draw taxels and their vectors, coloured by ``lengths`` (k,) [mm]; return the marks, for the bar of colours."""
    from matplotlib.collections import LineCollection

    starts = (positions[shown] @ view.T)[:, :2]
    ends = ((positions + vectors)[shown] @ view.T)[:, :2]
    lines = LineCollection(list(np.stack([starts, ends], axis=1)), array=lengths[shown], linewidths=1.2, cmap=_COLOURS)
    lines.set_clim(0.0, most)
    axes.add_collection(lines)
    x, y = starts.T
    return axes.scatter(x, y, s=5, c=lengths[shown], cmap=_COLOURS, vmin=0.0, vmax=most)
