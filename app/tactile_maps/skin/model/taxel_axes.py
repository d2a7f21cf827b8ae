"""Axes of taxels: the number of components that each one measures, and the first tangent of its frame.

The frame of a taxel is (t1, t2, n), right-handed and orthonormal: n is its outward normal, t1 a direction along the
skin, and t2 = n x t1. A taxel with one axis measures pressure along n; one with three axes also measures the
tangential traction along t1 and t2. Only t1 is stored; a row of NaN means that no source states it, and
``maps.model.taxel_frames`` then takes the direction of the map's x axis.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import overload

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import Finding, SkinError, add_finding

NUMBERS_OF_AXES = (1, 3)
"""Numbers of axes that a taxel may have."""
TANGENT_TOLERANCE = 1e-6
"""Largest deviation of a stored tangent from length one, and of its cosine to the normal from zero."""
_SHORTEST = 1e-6
"""Length of the projection of a unit tangent below which its direction on the surface is undefined."""


MAX_FRAME_DEVIATION = np.radians(5.0)
"""Largest deviation of the frame of a taxel in a file from an orthonormal one [rad]; smaller ones are corrected."""
_ROUNDED = 1e-3
"""Deviation of a frame [rad] up to which it counts as rounding of the numbers in a file, and is not reported."""


def check_number_of_axes(axes: int, place: str = "axes") -> None:
    """Raise a SkinError unless ``axes`` is a number of axes that a taxel may have."""
    if axes not in NUMBERS_OF_AXES:
        remedy = "Choose 1 (pressure) or 3 (pressure and shear)"
        raise SkinError("invalid number of axes", place=place, value=axes, remedy=remedy)


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
        check_number_of_axes(int(axes[row]), f"axes, row {row}")
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


def stated_frames(
    axes: IntArray | None,
    t1: FloatArray | None,
    t2: FloatArray | None,
    normals: FloatArray | None,
    *,
    where: str,
    findings: list[Finding],
    place: Callable[[int], str],
) -> FloatArray | None:
    """Return the tangents (n, 3) of a file, made orthonormal to the normals; None if none is stated.

    Args:
        axes: (n,) stated numbers of axes, or None; a finding reports tangents without them.
        t1: (n, 3) first tangents of any length; NaN or zero where not stated.
        t2: (n, 3) second tangents, like ``t1``, or None; they are only checked.
        normals: (n, 3) outward unit normals, or None.
        where: Name of the file, for findings.
        findings: Receives corrections of up to 5 degrees.
        place: Returns the place in the file of a row, for errors.

    Raises:
        SkinError: A tangent is incomplete, or a frame is left-handed or deviates from an orthonormal one by more than
            5 degrees.
    """
    if t1 is None:
        return None
    first = _directions(t1, "t1", place)
    second = np.full_like(first, np.nan) if t2 is None else _directions(t2, "t2", place)
    both = _stated(first) & _stated(second)
    _refuse(second, _stated(second) & ~both, "t2 is stated without t1", place, "State both, or only t1")
    if normals is not None:
        off = _angles_off(first, normals)
        problem = "t1 is not perpendicular to the normal"
        remedy = "State a direction along the skin, or leave it out: it is then the x direction of the map"
        _refuse(first, off > MAX_FRAME_DEVIATION, problem, place, remedy)
        right = unit_rows(np.cross(normals, first))
        along = np.einsum("ij,ij->i", second, right)
        left_handed = along < -np.cos(MAX_FRAME_DEVIATION)
        remedy = "Swap t1 and t2, or reverse one of them: t2 is the normal x t1"
        _refuse(second, left_handed, "the frame (t1, t2, normal) is left-handed", place, remedy)
        off = np.fmax(off, np.arccos(np.clip(along, -1, 1)))
    else:
        off = _angles_off(first, second)
    problem = "t2 is not perpendicular to t1 and the normal"
    remedy = "State the normal x t1, or leave t2 out"
    _refuse(second, off > MAX_FRAME_DEVIATION, problem, place, remedy)
    action = f"made orthonormal: up to {np.degrees(off.max(initial=0.0)):.2g} degrees off"
    add_finding(findings, "frame-not-orthonormal", where, action, int((off > _ROUNDED).sum()))
    action = "the number of axes is not stated: one; a taxel that measures shear has 3 axes"
    add_finding(findings, "axes-unstated", where, action, int(_stated(first).sum()) if axes is None else 0)
    tangents = first if normals is None else tangents_on(first, normals)
    return tangents if _stated(tangents).any() else None


def axes_summary(axes: IntArray | None, tangents: FloatArray | None, count: int) -> dict[str, int]:
    """Return the number of taxels with three axes, and the number of those whose tangent is stated.

    Args:
        axes: (n,) numbers of axes, or None.
        tangents: (n, 3) first tangents, NaN where not stated, or None.
        count: Number of taxels.
    """
    three = np.zeros(count, dtype=bool) if axes is None else axes == 3
    stated = three & _stated(tangents) if tangents is not None else np.zeros(count, dtype=bool)
    return {"three_axis": int(three.sum()), "stated_tangents": int(stated.sum())}


def axes_text(summary: Mapping[str, int], count: int) -> str:
    """Return an ``axes_summary`` of ``count`` taxels as text, empty if all of them have one axis."""
    three = summary.get("three_axis")
    if not three:
        return ""
    stated = summary["stated_tangents"]
    source = "stated" if stated == three else f"stated for {stated}, else from the map" if stated else "from the map"
    return f"3 for {'all' if three == count else three} taxels, t1 {source}"


def _stated(tangents: FloatArray) -> BoolArray:
    return np.asarray(np.isfinite(tangents).all(axis=1))


def _directions(vectors: FloatArray, name: str, place: Callable[[int], str]) -> FloatArray:
    """Return unit vectors (n, 3); NaN for rows that are empty or zero.

    Raises:
        SkinError: A row is incomplete.
    """
    empty = np.isnan(vectors)
    partial = np.asarray(~(empty.all(axis=1) | np.isfinite(vectors).all(axis=1)))
    _refuse(vectors, partial, f"{name} must be three finite numbers", place, "Complete it, or leave all three out")
    sizes = np.abs(vectors).max(axis=1, keepdims=True, initial=0.0)
    return unit_rows(np.divide(vectors, sizes, out=np.full_like(vectors, np.nan), where=sizes > 0))


def _angles_off(ones: FloatArray, others: FloatArray) -> FloatArray:
    """Return (n,) deviations of the angles between unit vectors from a right angle [rad]; 0 for missing ones."""
    return np.abs(np.arcsin(np.clip(np.nan_to_num(np.einsum("ij,ij->i", ones, others)), -1, 1)))


def _refuse(vectors: FloatArray, bad: BoolArray, problem: str, place: Callable[[int], str], remedy: str) -> None:
    if bad.any():
        row = int(bad.argmax())
        raise SkinError(problem, place=place(row), value=vectors[row].round(6).tolist(), remedy=remedy)


def _check(tangents: FloatArray, bad: BoolArray, problem: str) -> None:
    if bad.any():
        row = int(bad.argmax())
        remedy = "State a unit vector perpendicular to the normal, or none"
        raise SkinError(problem, place=f"tangents, row {row}", value=tangents[row].tolist(), remedy=remedy)
