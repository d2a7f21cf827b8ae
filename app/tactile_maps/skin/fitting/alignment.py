"""Spatial calibration: the pose of a rigid group of taxels, from the mesh of its link or from touches at known places.

Both minimise residuals over the rigid displacement of the group by Gauss-Newton steps in the tangent space of SE(3)
(Chen and Medioni 1992), with the weights of Huber (1981) for outliers. A displacement is stated in the frame of the
link: ``displaced = pose.points(stated)``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray
from tactile_maps.core.errors import SkinError
from tactile_maps.geometry.surface.closest_point import ClosestPoint, closest_point
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.pose import Pose

_STARTS = 6
"""Number of starts: the stated pose, and random displacements of it."""
_STEPS = 60
_ENOUGH = 1e-7
"""Size of a step [m] that ends the iteration."""
_LEVER = 1e-3
"""Distance [m] that counts as much as one radian between the normal of a taxel and that of the mesh."""
_STAY = 1e-2
"""Weight of the squared displacement of a taxel, relative to that of its squared distance: what the mesh does not
determine, such as sliding along a plane, remains as stated.
"""
_HUBER = 1.345
"""Residuals above this many robust standard deviations count linearly (Huber 1981, 95 % efficiency)."""
_LEAST_SCALE = 1e-4
"""Least robust standard deviation [m]."""
_FREE = 1e-2
"""Share of the largest eigenvalue below which the mesh does not determine a direction."""
LEAST_TOUCHES = 3
_FELT = 0.05
"""Readings below this share of the largest one of a touch are left out."""
_LEAST_SPREAD = 0.05
"""Least distance of the touches from a line, as a share of their extent along it."""


@dataclass(frozen=True, eq=False)
class Alignment(ArrayFields):
    """Rigid displacement of a group of taxels.

    Attributes:
        pose: Displacement in the frame of the link.
        before: (k,) distances of the taxels from the mesh, or of the touches from their places, as stated [m].
        after: (k,) the same after the displacement [m].
        uncertainty: Standard error of the displaced taxels [m], the largest one of the group; NaN if it was not
            estimated.
        free: Number of directions, of 6, that the data do not determine; the group remains as stated in them.
    """

    pose: Pose
    before: FloatArray
    after: FloatArray
    uncertainty: float
    free: int

    @property
    def angle(self) -> float:
        """Angle of the rotation [rad]."""
        return float(Rotation.from_matrix(self.pose.rotation).magnitude())


def align_to_mesh(mesh: Mesh, positions: FloatArray, normals: FloatArray | None = None, *, seed: int = 0) -> Alignment:
    """Return the displacement that puts a rigid group of taxels onto a mesh, with its normals along those of the mesh.

    Directions that the mesh does not determine, such as sliding along a plane, remain as stated. Of the stated pose
    and random displacements of it, by about 20 degrees and up to a quarter of the group's extent, the start with the
    least final cost is used.

    Args:
        mesh: The surface [m].
        positions: (k, 3) stated positions of the taxels [m], in the frame of the mesh.
        normals: (k, 3) stated outward unit normals, or None.
        seed: Seed of the random displacements.

    Raises:
        SkinError: There are no taxels, or a position is not finite.
        MeshError: The mesh has no faces.

    Cost: 20 ms for each start of a group of 10 taxels, 0.1 s for 400.
    """
    if not len(positions) or not np.isfinite(positions).all():
        raise SkinError("a group needs taxels with finite positions", value=len(positions))
    closest = closest_point(mesh)
    fit = _MeshFit(mesh, closest, positions, normals)
    random = np.random.default_rng(seed)
    extent = float(np.linalg.norm(np.ptp(positions, axis=0)))
    best = fit.refined(Pose.identity())
    for _ in range(_STARTS - 1):
        turn = Rotation.from_rotvec(random.normal(size=3) * np.radians(30) / 3).as_matrix()
        shift: FloatArray = random.uniform(-0.25, 0.25, 3) * extent
        found = fit.refined(_about(fit.centre, turn, shift))
        if found[1] < best[1]:
            best = found
    pose = best[0]
    before = closest.query(positions)[2]
    after = closest.query(pose.points(positions))[2]
    return Alignment(pose, before, after, np.nan, fit.free(pose))


class _MeshFit:
    """Robust least squares of distances, normals and displacement of one group.

    Args:
        mesh: The surface.
        closest: Its search tree.
        positions: (k, 3) stated positions [m].
        normals: (k, 3) stated normals, or None.
    """

    def __init__(self, mesh: Mesh, closest: ClosestPoint, positions: FloatArray, normals: FloatArray | None) -> None:
        self._mesh = mesh
        self._closest = closest
        self._positions = positions
        self._normals = normals
        self.centre = positions.mean(axis=0)

    def refined(self, pose: Pose) -> tuple[Pose, float]:
        """Return the pose of a local minimum from ``pose``, and its cost [m²]."""
        damping = 1e-6
        cost, matrix, gradient = self._linearised(pose)
        for _ in range(_STEPS):
            damped = matrix + damping * np.diag(np.diag(matrix))
            step = np.asarray(np.linalg.solve(damped, -gradient), dtype=np.float64)
            centre = pose.points(self.centre)
            moved = _about(centre, Rotation.from_rotvec(step[:3]).as_matrix(), step[3:]) @ pose
            found = self._linearised(moved)
            if found[0] < cost:
                pose = moved
                damping = max(damping / 10, 1e-9)
                gained = cost - found[0]
                cost, matrix, gradient = found
                if np.abs(step[3:]).max() < _ENOUGH and gained < 1e-6 * cost + _ENOUGH**2:
                    break
            else:
                damping *= 10
                if damping > 1e3:
                    break
        return pose, cost

    def _linearised(self, pose: Pose) -> tuple[float, FloatArray, FloatArray]:
        """Return cost [m²], matrix (6, 6) and gradient (6,) of a step: rotation about the centre, and shift."""
        points = pose.points(self._positions)
        arms = points - pose.points(self.centre)
        away, along, facing = self._distances(points)
        scale = max(1.4826 * float(np.median(away)), _LEAST_SCALE)
        weight = np.minimum(1.0, _HUBER * scale / np.maximum(away, 1e-12))
        rows = np.hstack([np.cross(arms, along), along])
        matrix = (rows * weight[:, None]).T @ rows
        gradient = (rows * weight[:, None]).T @ away
        cost = float((weight * away**2 * (2 - weight)).sum())
        stay = points - self._positions
        blocks = [(_rows_of_points(arms), stay, _STAY)]
        if self._normals is not None:
            turned = pose.directions(self._normals)
            blocks.append(
                (np.dstack([_minus_cross(turned), np.zeros((len(points), 3, 3))]), turned - facing, _LEVER**2)
            )
        for jacobian, residual, factor in blocks:
            matrix += factor * np.einsum("kij,kil->jl", jacobian, jacobian)
            gradient += factor * np.einsum("kij,ki->j", jacobian, residual)
            cost += factor * float((residual**2).sum())
        return cost, matrix, gradient

    def _distances(self, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return distances (k,), the directions (k, 3) in which they grow, and the normals (k, 3) of the mesh."""
        faces, weights, away = self._closest.query(points)
        facing = self._mesh.face_normals[faces]
        offset = points - self._mesh.points(faces, weights)
        side = np.where((offset * facing).sum(axis=1) < 0, -1.0, 1.0)[:, None]
        along = np.where(away[:, None] > 1e-7, offset / np.maximum(away, 1e-12)[:, None], side * facing)
        return away, along, facing

    def free(self, pose: Pose) -> int:
        """Return the number of directions that distances and normals do not determine."""
        points = pose.points(self._positions)
        arms = points - pose.points(self.centre)
        _, along, _ = self._distances(points)
        reach = max(float(np.sqrt((arms**2).sum(axis=1).mean())), 1e-9)
        rows = np.hstack([np.cross(arms, along) / reach, along])
        values = np.linalg.eigvalsh(rows.T @ rows)
        return int((values < _FREE * values[-1]).sum())


def align_to_touches(centres: FloatArray, places: FloatArray, taxels: FloatArray) -> Alignment:
    """Return the displacement of a group of taxels by which the centres of touches agree with their known places.

    Args:
        centres: (k, 3) centres of the readings of each touch, computed with the stated positions of the taxels [m].
        places: (k, 3) known places of the touches [m], in the same frame of the link.
        taxels: (n, 3) stated positions of the taxels [m], for which the uncertainty is stated.

    Raises:
        SkinError: There are fewer than three touches, or they are on a line, so that the rotation about it is not
            determined; the error names its direction.
    """
    if len(centres) < LEAST_TOUCHES:
        remedy = f"Touch at least {LEAST_TOUCHES} places that are not on a line, better 20 or more"
        raise SkinError("too few touches to find a pose", value=len(centres), remedy=remedy)
    _check_spread(centres)
    weight = np.ones(len(centres))
    for _ in range(_STEPS):
        pose = _registered(centres, places, weight)
        residual = places - pose.points(centres)
        away = np.linalg.norm(residual, axis=1)
        scale = max(float(np.median(away)), _LEAST_SCALE)
        newer = np.minimum(1.0, _HUBER * scale / np.maximum(away, 1e-12))
        if np.abs(newer - weight).max() < 1e-6:
            break
        weight = newer
    arms = pose.points(centres) - np.average(pose.points(centres), axis=0, weights=weight)
    rows = _rows_of_points(arms)
    information = np.einsum("k,kij,kil->jl", weight, rows, rows)
    variance = (weight * away**2).sum() / max(3 * len(centres) - 6, 1)
    covariance = variance * np.linalg.inv(information)
    reach = pose.points(taxels) - np.average(pose.points(centres), axis=0, weights=weight)
    spread = np.einsum("kij,jl,kil->k", _rows_of_points(reach), covariance, _rows_of_points(reach))
    before = np.linalg.norm(places - centres, axis=1)
    return Alignment(pose, before, away, float(np.sqrt(spread.max())), 0)


def touch_centres(
    positions: FloatArray, readings: FloatArray, *, noise: FloatArray | float = 0.0
) -> tuple[FloatArray, BoolArray]:
    """Return the centres (t, 3) [m] of the readings of touches, and which of the touches have one.

    Args:
        positions: (n, 3) stated positions of the taxels [m].
        readings: (t, n) changes from the untouched skin, positive under pressure; NaN for taxels that did not report.
        noise: Readings below this value, for all or each of the taxels (n,), are left out.
    """
    felt = np.nan_to_num(readings)
    felt = np.where((felt >= _FELT * felt.max(axis=1, keepdims=True)) & (felt > noise), felt, 0.0)
    total = felt.sum(axis=1)
    there = total > 0
    centres = felt @ positions / np.where(there, total, 1.0)[:, None]
    return centres, there


def _check_spread(points: FloatArray) -> None:
    """Raise SkinError if points (k, 3) are on a line: the rotation about it is not determined."""
    _, sizes, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    if sizes[0] <= 0 or sizes[1] < _LEAST_SPREAD * sizes[0]:
        if sizes[0] < 1e-6:
            raise SkinError("all touches are at one place", remedy="Touch places that are not on a line")
        direction = ", ".join(f"{value:.2f}" for value in axes[0])
        found = f"direction {direction}, {1e3 * sizes[1] / np.sqrt(len(points)):.2g} mm from it"
        remedy = "The rotation about it is not determined: touch places off this line"
        raise SkinError("all touches are on a line", value=found, remedy=remedy)


def _registered(moving: FloatArray, fixed: FloatArray, weight: FloatArray) -> Pose:
    """Return the pose of weighted least squares between pairs of points (Kabsch 1976)."""
    from_centre = np.average(moving, axis=0, weights=weight)
    to_centre = np.average(fixed, axis=0, weights=weight)
    u, _, vt = np.linalg.svd(((moving - from_centre) * weight[:, None]).T @ (fixed - to_centre))
    sign = np.sign(np.linalg.det(vt.T @ u.T))
    rotation = vt.T @ np.diag([1.0, 1.0, sign]) @ u.T
    return Pose(rotation, to_centre - rotation @ from_centre)


def _about(centre: FloatArray, rotation: FloatArray, shift: FloatArray) -> Pose:
    """Return the displacement that rotates about a point and then shifts."""
    return Pose(rotation, centre - rotation @ centre + shift)


def _minus_cross(vectors: FloatArray) -> FloatArray:
    """Return (k, 3, 3) the matrices of -v x, the change of each vector by a small rotation."""
    matrices = np.zeros((len(vectors), 3, 3))
    x, y, z = vectors.T
    matrices[:, 0, 1] = z
    matrices[:, 0, 2] = -y
    matrices[:, 1, 0] = -z
    matrices[:, 1, 2] = x
    matrices[:, 2, 0] = y
    matrices[:, 2, 1] = -x
    return matrices


def _rows_of_points(arms: FloatArray) -> FloatArray:
    """Return (k, 3, 6) the change of points at ``arms`` (k, 3) from the centre by rotation and shift."""
    return np.dstack([_minus_cross(arms), np.broadcast_to(np.eye(3), (len(arms), 3, 3))])
