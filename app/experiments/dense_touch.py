"""A touch that is known: a ball pressed into a bed of springs sampled so densely that sampling no longer shows.

Plain code of its own, which shares nothing with the contact models that are judged by it: a signed distance in closed
form, summed over every point. What is felt below the surface is the Boussinesq stress of those forces.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from app.arrays import FloatArray, IntArray
from app.geometry.pose import Pose
from app.skin.skin import Skin
from app.touch.layer import Layer
from app.touch.load import Load
from app.touch.shapes import Ball

PRESSED = 1e-3
"""How deep the balls are pressed in [m]."""
_FACING = 0.2

Blur = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class DensePoints:
    """Points spread over a link's skin, or over the part of it that a touch concerns.

    Attributes:
        link: Which link.
        positions: (k, 3) [m], link frame.
        normals: (k, 3) outward.
        areas: (k,) [m²].
        taxel: (k,) which taxel feels there, numbered through the skin.
        parts: (k,) of the taxel's cell that each point stands for [m²]. Not its area, where the points of a cell are so
            few that their areas add up to another than the cell's.
    """

    link: str
    positions: FloatArray
    normals: FloatArray
    areas: FloatArray
    taxel: IntArray
    parts: FloatArray


@dataclass(frozen=True, eq=False)
class Touch:
    """What a model is told, and what it should say.

    Attributes:
        load: Force, centre of pressure and the ball.
        surface: (taxels,) force on each taxel's cell [N].
        felt: (taxels,) force that passes through each taxel's cell at the depth of the taxels [N].
    """

    load: Load
    surface: FloatArray
    felt: FloatArray


def ball_radius(contact: float, *, pressed: float = PRESSED) -> float:
    """Of the ball whose contact with a plane has a radius of ``contact`` [m] when pressed in so deep [m]."""
    return (contact**2 + pressed**2) / (2 * pressed)


def press(
    dense: DensePoints, at: FloatArray, normal: FloatArray, contact: float, *, taxels: int, blur: Blur, layer: Layer
) -> Touch:
    """Press a ball into the skin at one of its points: springs along its radii, felt across the skin.

    Args:
        dense: The skin around.
        at: (3,) the point [m].
        normal: (3,) of the skin there, outward; the ball comes along it.
        contact: Radius of the contact on a plane [m].
        taxels: In the whole skin.
        blur: From pressures at the points to those at the taxels' depth.
        layer: Its foundation is what yields.
    """
    radius = ball_radius(contact)
    centre = at + (radius - PRESSED) * normal
    away = dense.positions - centre
    far = np.linalg.norm(away, axis=1)
    across = -np.einsum("ij,ij->i", away, dense.normals) / np.maximum(far, 1e-12)
    sunk = np.maximum(radius - far, 0)
    sunk[dense.normals @ normal < _FACING] = 0
    pressures = layer.foundation * sunk * across
    forces = pressures * dense.areas
    force = float(forces.sum())
    aside = forces @ (dense.positions - at) / force
    point = at + aside - (aside @ normal) * normal
    load = Load(dense.link, point, normal, force, Ball(radius), Pose(np.eye(3), centre))
    return Touch(load, _on_cells(dense, pressures, taxels), _on_cells(dense, blur(pressures), taxels))


def _on_cells(dense: DensePoints, pressures: FloatArray, taxels: int) -> FloatArray:
    """(taxels,) force on each cell [N]; all of it on some cell."""
    forces = np.bincount(dense.taxel, pressures * dense.parts, taxels)
    return np.asarray(forces * (pressures @ dense.areas / forces.sum()))


def misplaced(touch: Touch, by: float) -> Touch:
    """The same touch, where the model is told that the ball is somewhere else along the skin, so far off [m].

    Force and centre of pressure are still told as they are: collision hulls fit the skin less well than solvers count.
    """
    load = touch.load
    helper = np.eye(3)[np.abs(load.normal).argmin()]
    aside = np.cross(load.normal, helper)
    pose = Pose(load.pose.rotation, load.pose.translation + by * aside / np.linalg.norm(aside))
    return replace(touch, load=replace(load, pose=pose))


def near_blur(dense: DensePoints, depth: float) -> Blur:
    """Stress at ``depth`` [m] by summing over every pair of points: for a few thousand points. Cost: 0.1 µs a pair."""

    def felt(pressures: FloatArray) -> FloatArray:
        pressed = np.flatnonzero(pressures)
        sources = dense.positions[pressed]
        squared = ((dense.positions[:, None] - sources) ** 2).sum(axis=2) + depth**2
        kernel = 3 * depth**3 / (2 * np.pi * squared**2.5)
        kernel[dense.normals @ dense.normals[pressed].T < _FACING] = 0
        return np.asarray(kernel @ (pressures * dense.areas)[pressed])

    return felt


def errors(touch: Touch, pressures: FloatArray, skin: Skin, centres: FloatArray) -> Mapping[str, float]:
    """How far a model's pressures (taxels,) are off.

    Args:
        touch: What it was told and should say.
        pressures: What it says [Pa].
        skin: What was touched.
        centres: (taxels, 3) middles of the taxels' cells [m], see ``cell_centres``.

    Returns:
        ``force_percent`` of the total; ``place_mm`` of the centre of pressure, along the skin; ``surface_percent`` and
        ``felt_percent``: the forces on the cells that are wrong, added up, of the total at the surface and below it.
    """
    load = touch.load
    forces = pressures * skin.areas
    total = float(forces.sum())
    aside = forces @ (centres - load.point) / total if total > 0 else np.full(3, np.nan)
    place = float(np.linalg.norm(aside - (aside @ load.normal) * load.normal))
    return {
        "force_percent": 100 * abs(total - load.force) / load.force,
        "place_mm": 1e3 * place,
        "surface_percent": 100 * float(np.abs(forces - touch.surface).sum()) / load.force,
        "felt_percent": 100 * float(np.abs(forces - touch.felt).sum()) / load.force,
    }


def cell_centres(skin: Skin) -> FloatArray:
    """(taxels, 3) mean position of each taxel's cell [m], link frame: where its force is taken to act."""
    centres = []
    for patch in skin.patches:
        points, count = patch.taxels.quadrature, len(patch.taxels)
        sums = [np.bincount(points.taxel, points.areas * points.positions[:, axis], count) for axis in range(3)]
        centres.append(np.column_stack(sums) / patch.taxels.areas[:, None])
    return np.concatenate(centres)
