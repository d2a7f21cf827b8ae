"""Skins with errors of calibration: the same taxels at other assumed positions.

The positions of taxels are known from a calibration, with a mean error of 2 mm at best, and 7 mm as published for the
arm of an iCub. The map is made from the assumed positions and used by the controller; the touched skin is the true one.

Each taxel moves by a normally distributed error along all three axes, either alone or rigidly with its module of about
ten. The surface moves with it, linearly between adjacent taxels, as in a mesh whose vertices are the taxels. Triangles
between taxels therefore tilt, shear and, for errors above a quarter of the pitch, flip (theory page, 5.2). The order,
areas and neighbours of the taxels and the triangles are unchanged, so that a ``SurfacePoint`` is the same material
point on both skins.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import lsmr
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import Finding, SkinError, check_range
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.points import sums_by_label
from tactile_maps.skin.model.skin import Patch, Skin, Taxels
from tactile_maps.skin.model.taxel_axes import tangents_on
from tactile_maps.skin.reconstruction.triangulation import triangulate
from tactile_maps.skin.taxel_placement.sampling import farthest_points

ErrorUnit: TypeAlias = Literal["taxel", "module"]

MODULE_TAXELS = 10
"""Number of taxels of a module, as in iCub's triangles."""
MAX_ERROR = 0.05
"""Largest error of a calibration [m]."""
_CANCELLED = 1e-6
"""Length of a mean of unit normals below which its direction is undefined."""


def with_calibration_error(skin: Skin, sd: float, *, seed: int = 0, by: ErrorUnit = "taxel") -> Skin:
    """Return the assumed skin of a calibration with an error; areas are the true ones, known from manufacture.

    Args:
        skin: The true skin.
        sd: Standard deviation of the error of a taxel along each axis [m], 0 to 0.05.
        seed: Seed of the errors; with the same seed they are proportional to ``sd``.
        by: Unit that is misplaced: each ``taxel``, or each ``module`` of about ten adjacent ones, which is moved and
            rotated, with half of the variance each.

    Raises:
        SkinError: The error is out of range, or the unit is unknown.

    Cost: 0.1 s for 1000 taxels.
    """
    check_range("the calibration error", sd, 0, MAX_ERROR, error=SkinError, place="sd", unit="m")
    if by not in _SHIFTS:
        raise SkinError("unknown unit", place="by", value=by, remedy=f"Choose {' or '.join(_SHIFTS)}")
    if sd == 0:
        return skin
    streams = np.random.default_rng(seed).spawn(len(skin.patches))
    moved = [
        _shift_patch(patch, _SHIFTS[by](patch.taxels.positions, stream, sd), sd)
        for patch, stream in zip(skin.patches, streams, strict=True)
    ]
    note = Finding("misplaced", "skin", f"assumed {1e3 * sd:g} mm off along each axis, by {by}", len(skin))
    return replace(skin, patches=tuple(moved), findings=(*skin.findings, note))


def with_sleeve_displaced(skin: Skin, *, shift: float = 0.0, turn: float = 0.0) -> Skin:
    """Return the assumed skin where the true one is a displaced sleeve.

    Each patch moves rigidly along and about the longest axis of its taxels. Its shape, and so its map, is the same.

    Args:
        skin: The true skin.
        shift: Displacement along the axis [m].
        turn: Rotation about the axis through the middle of the taxels [rad].

    Raises:
        SkinError: A number is not finite, or the shift is longer than 5 cm.
    """
    if not (abs(shift) <= MAX_ERROR and np.isfinite(turn)):  # NaN compares false
        raise SkinError(
            "the sleeve cannot be displaced like this",
            value=f"{shift} m, {turn} rad",
            remedy="Choose a shift of -0.05 to 0.05 m and a finite turn",
        )
    moved = tuple(_displaced(patch, shift, turn) for patch in skin.patches)
    note = Finding("misplaced", "skin", f"assumed {1e3 * shift:g} mm along and {turn:g} rad about its axis", len(skin))
    return replace(skin, patches=moved, findings=(*skin.findings, note))


def _displaced(patch: Patch, shift: float, turn: float) -> Patch:
    positions = patch.taxels.positions
    middle = positions.mean(axis=0)
    axis = np.linalg.svd(positions - middle, full_matrices=False)[2][0]
    rotation = Rotation.from_rotvec(turn * axis).as_matrix()

    def move(points: FloatArray) -> FloatArray:
        return np.asarray(middle + (points - middle) @ rotation.T + shift * axis)

    taxels = patch.taxels
    quadrature = patch.taxels.quadrature
    return replace(
        patch,
        surface=Mesh(move(patch.surface.vertices), patch.surface.faces),
        taxels=replace(
            taxels,
            positions=move(positions),
            normals=taxels.normals @ rotation.T,
            tangents=None if taxels.tangents is None else taxels.tangents @ rotation.T,
            quadrature=replace(quadrature, positions=move(quadrature.positions)),
        ),
    )


def with_area_error(skin: Skin, factor: float) -> Skin:
    """Return the assumed skin where the gains of all taxels have the same error, as a factor of the areas.

    Args:
        skin: The true skin.
        factor: Assumed force over true force, 0.01 to 100.

    Raises:
        SkinError: The factor is out of range.
    """
    check_range("the gain error", factor, 0.01, 100, error=SkinError, place="factor")
    return replace(skin, patches=tuple(_enlarged(patch, factor) for patch in skin.patches))


def _enlarged(patch: Patch, factor: float) -> Patch:
    taxels = patch.taxels
    quadrature = patch.taxels.quadrature
    quadrature = replace(quadrature, areas=factor * quadrature.areas)
    return replace(patch, taxels=replace(taxels, areas=factor * taxels.areas, quadrature=quadrature))


class _Errors(NamedTuple):
    """Errors of the places of taxels.

    Attributes:
        shift: (n, 3) displacements, in units of ``sd``.
        turn: (n, 3) rotation vectors of their frames [rad].
    """

    shift: FloatArray
    turn: FloatArray


def _taxel_errors(positions: FloatArray, stream: np.random.Generator, _sd: float) -> _Errors:
    """Return errors of single taxels, whose frames are not rotated."""
    return _Errors(stream.standard_normal(positions.shape), np.zeros_like(positions))


def _module_errors(positions: FloatArray, stream: np.random.Generator, sd: float) -> _Errors:
    """Return errors of modules that move and rotate about their middles."""
    shift = np.empty_like(positions)
    turns = np.zeros_like(positions)
    for module in group_into_modules(positions):
        arms = positions[module] - positions[module].mean(axis=0)
        reach = float(np.sqrt(2 / 3 * (arms**2).sum(axis=1).mean()))
        way, turn = stream.standard_normal((2, 3)) * (0.5**0.5 if reach > 0 else 1.0)
        if reach > 0:
            turns[module] = turn * sd / reach
        turned = Rotation.from_rotvec(turns[module]).apply(arms) - arms
        shift[module] = way + turned / sd
    return _Errors(shift, turns)


_SHIFTS: dict[str, Callable[[FloatArray, np.random.Generator, float], _Errors]] = {
    "taxel": _taxel_errors,
    "module": _module_errors,
}


def group_into_modules(positions: FloatArray) -> list[IntArray]:
    """Return groups of about ten adjacent taxels, in ascending order: those nearest to evenly spread middles.

    Args:
        positions: (n, 3) [m].
    """
    count = max(round(len(positions) / MODULE_TAXELS), 1)
    middles = positions[farthest_points(positions, count, np.zeros(1, dtype=np.int64))]
    for _ in range(8):
        nearest = cKDTree(middles).query(positions)[1]
        size = np.bincount(nearest, minlength=count)
        sums = sums_by_label(nearest, positions, count)
        middles = np.where(size[:, None] > 0, sums / np.maximum(size, 1)[:, None], middles)
    groups = [np.flatnonzero(nearest == number) for number in range(count)]
    return [group for group in groups if len(group)]


def _shift_patch(patch: Patch, errors: _Errors, sd: float) -> Patch:
    """Return the patch with its taxels moved by ``errors``, in units of ``sd`` [m], and the surface between them."""
    shift = sd * errors.shift
    surface = patch.surface
    taxels = patch.taxels
    moves = _interpolate_shift(patch, shift, surface.vertices)
    corners = surface.faces[taxels.faces]
    moves += _least_norm_correction(
        corners, taxels.weights, shift - np.einsum("nc,ncd->nd", taxels.weights, moves[corners]), moves
    )
    believed = Mesh(surface.vertices + moves, surface.faces)
    quadrature = taxels.quadrature
    normals = _shifted_normals(believed, taxels)
    tangents = taxels.tangents
    if tangents is not None:
        tangents = np.einsum("nij,nj->ni", Rotation.from_rotvec(errors.turn).as_matrix(), tangents)
    return replace(
        patch,
        surface=believed,
        taxels=replace(
            taxels,
            positions=believed.points(taxels.faces, taxels.weights),
            normals=normals,
            tangents=tangents_on(tangents, normals),
            quadrature=replace(
                quadrature, positions=quadrature.positions + _interpolate_shift(patch, shift, quadrature.positions)
            ),
        ),
    )


def _interpolate_shift(patch: Patch, shift: FloatArray, points: FloatArray) -> FloatArray:
    """Return shifts (k, 3) of points (k, 3) of the surface, linear in the triangles between taxels."""
    taxels = patch.taxels
    joined = triangulate(taxels.positions, normals=taxels.normals, where=patch.name).mesh
    if not len(joined.faces):
        return shift[cKDTree(taxels.positions).query(points)[1]]
    faces, weights, _ = ClosestPoint(joined).query(points)
    return np.einsum("kc,kcd->kd", weights, shift[joined.faces[faces]])


def _least_norm_correction(corners: IntArray, weights: FloatArray, left: FloatArray, moves: FloatArray) -> FloatArray:
    """Return the smallest moves of vertices, shaped like ``moves``, that move points in triangles by ``left``.

    Linear functions between taxels have a kink at each taxel, which the actual triangles smooth.
    """
    rows = np.repeat(np.arange(len(left)), 3)
    carry = coo_matrix((weights.ravel(), (rows, corners.ravel())), shape=(len(left), len(moves))).tocsr()
    return np.stack([lsmr(carry, left[:, k], atol=1e-12, btol=1e-12)[0] for k in range(3)], axis=1)


def _shifted_normals(believed: Mesh, taxels: Taxels) -> FloatArray:
    """Return (n, 3) normals of the assumed surface at the taxels; the true ones where the surface is folded."""
    normals = np.einsum("nc,ncd->nd", taxels.weights, believed.vertex_normals[believed.faces[taxels.faces]])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.where(length > _CANCELLED, normals / np.maximum(length, _CANCELLED), taxels.normals)
