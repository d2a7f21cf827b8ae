"""Axes of taxels: the number of components that each one measures, and the first tangent of its frame.

The frame of a taxel is (t1, t2, n), right-handed and orthonormal: n is its outward normal, t1 a direction along the
skin, and t2 = n x t1. A taxel with one axis measures pressure along n; one with three axes also measures the
tangential traction along t1 and t2. Only t1 is stored; a row of NaN means that no source states it, and
``maps.model.taxel_frames`` then takes the direction of the map's x axis.
"""

from __future__ import annotations

from typing import overload

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import SkinError

NUMBERS_OF_AXES = (1, 3)
"""Numbers of axes that a taxel may have."""
TANGENT_TOLERANCE = 1e-6
"""Largest deviation of a stored tangent from length one, and of its cosine to the normal from zero."""
_SHORTEST = 1e-6
"""Length of the projection of a unit tangent below which its direction on the surface is undefined."""


def checked_axes(axes: IntArray | None, count: int) -> IntArray | None:
    """Return the numbers of axes (n,) of ``count`` taxels; None if all of them have one.

    Raises:
        SkinError: There is not one number for each taxel, or a number is neither 1 nor 3.
    """
    if axes is None:
        return None
    if axes.shape != (count,):
        raise SkinError("the number of rows or columns is wrong", place="axes", value=axes.shape)
    invalid = ~np.isin(axes, NUMBERS_OF_AXES)
    if invalid.any():
        row = int(invalid.argmax())
        remedy = "Choose 1 (pressure) or 3 (pressure and shear)"
        raise SkinError("invalid number of axes", place=f"axes, row {row}", value=int(axes[row]), remedy=remedy)
    return axes if (axes > 1).any() else None


def checked_tangents(tangents: FloatArray | None, normals: FloatArray | None, count: int) -> FloatArray | None:
    """Return the tangents t1 (n, 3) of ``count`` taxels; None if none is stated.

    Args:
        tangents: (n, 3) unit vectors perpendicular to the normals, NaN for a taxel whose tangent is not stated.
        normals: (n, 3) outward unit normals; None for taxels without, whose tangents are only checked for length one.
        count: Number of taxels.

    Raises:
        SkinError: There is not one row for each taxel, or a tangent has a number that is not finite, is not of length
            one, or is not perpendicular to its normal.
    """
    if tangents is None:
        return None
    if tangents.shape != (count, 3):
        raise SkinError("the number of rows or columns is wrong", place="tangents", value=tangents.shape)
    stated = np.asarray(~np.isnan(tangents).all(axis=1))
    lengths = np.linalg.norm(tangents, axis=1)
    _check(tangents, stated & ~np.isfinite(tangents).all(axis=1), "a tangent is not a finite number")
    _check(tangents, stated & ~(np.abs(lengths - 1) <= TANGENT_TOLERANCE), "a tangent is not of length one")
    if normals is not None:
        away = np.abs(np.einsum("ij,ij->i", tangents, normals))
        problem = "a tangent is not perpendicular to the normal"
        _check(tangents, stated & ~(away <= TANGENT_TOLERANCE), problem)
    return tangents if stated.any() else None


@overload
def tangents_on(tangents: FloatArray, normals: FloatArray) -> FloatArray: ...
@overload
def tangents_on(tangents: FloatArray | None, normals: FloatArray) -> FloatArray | None: ...
def tangents_on(tangents: FloatArray | None, normals: FloatArray) -> FloatArray | None:
    """Return unit ``tangents`` (n, 3) projected along other ``normals`` (n, 3), of length one; None stays None.

    A tangent that is parallel to its normal has no direction on the surface: its row becomes NaN, as if not stated.
    """
    if tangents is None:
        return None
    flat = tangents - np.einsum("ij,ij->i", tangents, normals)[:, None] * normals
    flat = np.where(np.linalg.norm(flat, axis=1, keepdims=True) > _SHORTEST, flat, np.nan)
    once = unit_rows(flat)
    return unit_rows(once - np.einsum("ij,ij->i", once, normals)[:, None] * normals)  # again, after cancellation


def unit_rows(vectors: FloatArray) -> FloatArray:
    """Return ``vectors`` (n, 3) of length one; NaN where one has no direction."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.divide(vectors, lengths, out=np.full_like(vectors, np.nan), where=lengths > 0)


def _check(tangents: FloatArray, bad: BoolArray, problem: str) -> None:
    if bad.any():
        row = int(bad.argmax())
        remedy = "State a unit vector perpendicular to the normal, or none"
        raise SkinError(problem, place=f"tangents, row {row}", value=tangents[row].tolist(), remedy=remedy)
