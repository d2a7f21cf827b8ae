"""Force that the skin does not measure: on bare links, on uncovered parts, and under taxels without readings.

It follows from the motion of the joints and the torques of their drives: mass matrix times acceleration, plus
velocity-product and gravity terms, less passive and drive torques, is the torque of all external forces (a
generalized-momentum observer, De Luca et al. 2006, with velocities differentiated over one tick). Torques that the
forces read by the skin explain are subtracted. A reading may be too high, so each force counts with any value from zero
to the reading. The contact may also have friction, which the skin does not measure, of up to ``FRICTION`` times that
force. The rest is attributed to one contact without friction at a point of the robot's surface.
"""

from __future__ import annotations

import copy
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import daqp
import mujoco
import numpy as np
from scipy.spatial import ConvexHull, QhullError

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray, all_finite, largest
from tactile_maps.core.caches import weak_cache
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.kinematics import Configuration, kinematic_model
from tactile_maps.robots.model.robot import Robot

FILTER_TIME = 0.01
"""Time constant of the low-pass filter of joint torques [s]."""
PERSISTENCE = 0.02
"""Force counts only if it lasted for this time [s] plus twice the period and delay of the skin's readings."""
SKIN_TOLERANCE = 0.25
"""Joint torque within this share of that of the forces read counts as measured: normals, places and gains err."""
FRICTION = 1.0
"""Friction of a measured contact in proportion to its force, at most: that of rubber on dry surfaces."""
DRIVE_TOLERANCE = 0.02
"""Relative error of drive torques."""
FIT_TOLERANCE = 0.15
"""Relative error of the joint torques with which a contact may explain them."""
_RIDGE = 1e-9
"""Regularization of the shares of contacts, relative: the joints may not tell contacts apart. Without it daqp fails."""
_AT_LIMIT = 1e-3
"""Distance from a limit [rad, or m] within which its own torque is possible."""
_DIRECTIONS = 120
_POINTS = 150
"""Numbers for each link: directions in which its extreme points are found, and points on their convex hull."""


@dataclass(frozen=True, eq=False)
class DriveTorques(ArrayFields):
    """Drive torques between two commands, without compensation of gravity.

    Attributes:
        mean: (n,) mean torque of the drives [N m, or N for a slide].
        gravity: True if gravity acts on the joints without compensation.
        dry_friction: True if the joints have the dry friction that the robot's file states.
    """

    mean: FloatArray
    gravity: bool = False
    dry_friction: bool = False


class UnmeasuredForce(NamedTuple):
    """A force that the skin does not measure.

    Attributes:
        link: The link on which it acts, most likely.
        force: The least normal force at one point that explains the joint torques [N].
    """

    link: str
    force: float


NO_FORCE = UnmeasuredForce("", 0.0)


class UnmeasuredForceMonitor:
    """Finds force that the skin does not measure. Mutable; ``reset`` forgets the past.

    Joints at their limits and joints that the model couples to others are left out, since other torques act there. A
    force is found only as far as joints feel it: near a joint's axis, or along it, it moves nothing.

    Args:
        robot: The robot; it may have no joints.

    Cost: 50 us a tick, 1 ms where readings alone do not explain the torques; building takes 0.1 s of CPU for a robot.
    """

    def __init__(self, robot: Robot) -> None:
        self._model = copy.copy(kinematic_model(robot))
        self._data = mujoco.MjData(self._model)
        self._gravity = self._model.opt.gravity.copy()
        self._mass = np.zeros((self._model.nv, self._model.nv))
        self._surface = _surface(robot)
        self._limited = self._model.jnt_limited.astype(bool)
        margin = self._model.jnt_margin + _AT_LIMIT
        self._lower = self._model.jnt_range[:, 0] + margin
        self._upper = self._model.jnt_range[:, 1] - margin
        self._coupled = _coupled_joints(self._model)
        self.reset()

    def reset(self) -> None:
        """Forget earlier postures and forces."""
        self._last: tuple[FloatArray, FloatArray] | None = None
        self._external = np.zeros(self._model.nv)
        self._found: deque[tuple[float, UnmeasuredForce]] = deque()

    def look(
        self,
        configuration: Configuration,
        velocity: FloatArray,
        regions: Sequence[ContactRegion],
        torques: DriveTorques,
        dt: float,
        *,
        latency: float = 0.0,
    ) -> UnmeasuredForce:
        """Return the force that lasted for ``PERSISTENCE`` plus twice ``latency``, extrapolated to now if it rises.

        Args:
            configuration: The robot at its current posture.
            velocity: (n,) measured.
            regions: All contacts that can be read.
            torques: Drive torques since the previous call.
            dt: Time since the previous call [s].
            latency: Period plus delay of the skin's readings [s].
        """
        posture = configuration.posture
        last = self._last
        self._last = (posture, velocity.copy())
        if last is None or not len(posture):
            return NO_FORCE
        share = 1 - np.exp(-dt / FILTER_TIME)
        external = self._external_torque(last, posture, velocity, torques, dt)
        free = ~(self._coupled | (self._limited & ((posture < self._lower) | (posture > self._upper))))
        self._external = np.where(free, self._external + share * (external - self._external), 0.0)
        read = [np.where(free, _contact_torques(configuration, region), 0.0) for region in regions]
        tolerance = DRIVE_TOLERANCE * np.abs(torques.mean)
        for normal, *_ in read:
            tolerance = tolerance + SKIN_TOLERANCE * np.abs(normal)
        if torques.dry_friction:
            tolerance = tolerance + self._model.dof_frictionloss
        least = self._least(_unexplained(self._external, read, tolerance), tolerance, free)
        return self._lasting(least, dt, PERSISTENCE + 2 * latency)

    def _external_torque(
        self,
        last: tuple[FloatArray, FloatArray],
        posture: FloatArray,
        velocity: FloatArray,
        torques: DriveTorques,
        dt: float,
    ) -> FloatArray:
        """(n,) mean torque of all external forces since the last tick [N m]."""
        data = self._data
        self._model.opt.gravity[:] = self._gravity if torques.gravity else 0.0
        data.qpos[:] = 0.5 * (last[0] + posture)
        data.qvel[:] = (posture - last[0]) / dt
        mujoco.mj_fwdPosition(self._model, data)
        mujoco.mj_fwdVelocity(self._model, data)
        mujoco.mj_fullM(self._model, data, self._mass)
        return self._mass @ (velocity - last[1]) / dt + data.qfrc_bias - data.qfrc_passive - torques.mean

    def _least(self, torque: FloatArray, tolerance: FloatArray, free: BoolArray) -> UnmeasuredForce:
        """Return the least force at a surface point that explains ``torque`` (n,) within ``tolerance`` (n,)."""
        excess = np.where(free, np.sign(torque) * np.maximum(np.abs(torque) - tolerance, 0.0), 0.0)
        if not largest(excess):
            return NO_FORCE
        columns = self._surface.torques(self._model, self._data)  # (points, n) of 1 N
        lever = np.abs(columns).max(axis=0, initial=0.0)
        felt = free & (lever > 0)
        if not largest(excess[felt]):  # no point of the surface can cause the torque
            return NO_FORCE
        # Torques over the longest lever are forces, of slides and hinges alike.
        excess = excess[felt] / lever[felt]
        columns = columns[:, felt] / lever[felt]
        unit = largest(excess)  # the squares of the smallest numbers are 0
        excess = excess / unit
        along = np.maximum(columns @ excess, 0.0)
        forces = along / np.maximum(np.einsum("ij,ij->i", columns, columns), 1e-12)
        errors = np.sqrt(np.maximum(1 - along * forces / excess.dot(excess), 0.0))
        explains = np.flatnonzero(errors <= max(FIT_TOLERANCE, 1.2 * float(errors.min())))
        least = int(explains[forces[explains].argmin()])
        return UnmeasuredForce(self._surface.links[self._surface.link_of[least]], float(unit * forces[least]))

    def _lasting(self, found: UnmeasuredForce, dt: float, duration: float) -> UnmeasuredForce:
        """Return the force that lasted for ``duration`` [s]: its least values, extrapolated where they rise.

        The least of the older and of the newer half of that time are extrapolated to now, at most to ``found``. A force
        that rises is then not reported late, and a peak shorter than half of the time hardly counts.
        """
        self._found.append((dt, found))
        total = sum(step for step, _ in self._found)
        while total - self._found[0][0] >= duration:
            total -= self._found.popleft()[0]
        if total < duration:
            return NO_FORCE
        forces = [one for _, one in self._found]
        half = (len(forces) + 1) // 2
        older = min(one.force for one in forces[:half])
        newer = min(forces[half:], key=lambda one: one.force, default=found)
        if not older:
            return NO_FORCE
        return newer._replace(force=min(newer.force + max(newer.force - older, 0.0), found.force))


def _contact_torques(configuration: Configuration, region: ContactRegion) -> FloatArray:
    """(3, n) joint torques of a contact [N m]: of the force read by the skin, shear included, and of full friction."""
    rotation = configuration.pose(region.link).rotation
    normal = rotation @ region.link_normal
    # The reflection that takes the normal to the first axis takes the other two to axes along the skin.
    mirror = normal + [np.copysign(1.0, normal[0]), 0.0, 0.0]
    axes = np.eye(3)[1:] - np.outer(normal[1:], mirror / abs(mirror[0]))
    forces = region.force * np.vstack([-normal, FRICTION * axes])
    if region.shear is not None:
        forces[0] += rotation @ region.shear.force
    return forces @ configuration.jacobian(region.link, region.link_position)


def _unexplained(external: FloatArray, read: Sequence[FloatArray], tolerance: FloatArray) -> FloatArray:
    """Return the part of ``external`` (n,) that measured contacts leave, by bounded least squares.

    Args:
        external: (n,) torques [N m].
        read: (3, n) torques of each contact, see ``_contact_torques``: shares from 0 to 1 of its normal force, and from
            -1 to 1 of its friction along each axis, are subtracted.
        tolerance: (n,) torques that need no explanation [N m]; within it the normal forces are subtracted as read.
    """
    rest = external - sum((normal for normal, *_ in read), np.zeros_like(external))
    if not read or (np.abs(rest) <= tolerance).all():
        return rest
    columns = np.concatenate(read)
    sizes = np.linalg.norm(columns, axis=1)
    unit = float(sizes.max())
    if not 0 < unit < np.inf or not all_finite(external):
        return rest
    # In shares times sizes the program has the same scale for light and heavy contacts.
    axes = columns / np.where(sizes > 0, sizes, 1.0)[:, None]
    most = sizes / unit
    least = most * np.tile([0.0, -1.0, -1.0], len(read))
    kinds = np.zeros(len(axes), dtype=np.int32)
    parts, _, solved, _ = daqp.solve(
        axes @ axes.T + _RIDGE * np.eye(len(axes)),
        -axes @ (external / unit),
        np.zeros((0, len(axes))),
        most,
        least,
        kinds,
    )
    return external - unit * parts @ axes if solved > 0 else rest


def _coupled_joints(model: mujoco.MjModel) -> BoolArray:
    """(n,) whether an equality constraint of the model acts on each joint."""
    coupled = np.zeros(model.nv, dtype=bool)
    for kind, first, second in zip(model.eq_type, model.eq_obj1id, model.eq_obj2id, strict=True):
        for one in (int(first), int(second)):
            if kind == mujoco.mjtEq.mjEQ_JOINT:
                coupled[[one] if one >= 0 else []] = True
            else:
                coupled |= _moves(model, one)
    return coupled


def _moves(model: mujoco.MjModel, body: int) -> BoolArray:
    """(n,) whether each joint moves ``body``."""
    found = np.zeros(model.nv, dtype=bool)
    while body > 0:
        first = int(model.body_jntadr[body])
        found[first : first + int(model.body_jntnum[body])] = True
        body = int(model.body_parentid[body])
    return found


@dataclass(frozen=True, eq=False)
class _Surface:
    """Points on the convex hulls of links that joints move.

    Attributes:
        links: Names.
        bodies: Number of each link's body.
        link_of: (points,) number of the link, rising.
        wrenches: (points, 6) force of 1 N along the inward normal and its torque about the link's origin [N m], in the
            link frame.
    """

    links: tuple[str, ...]
    bodies: tuple[int, ...]
    link_of: IntArray
    wrenches: FloatArray

    def torques(self, model: mujoco.MjModel, data: mujoco.MjData) -> FloatArray:
        """(points, n) joint torques of 1 N along the inward normal at each point."""
        torques = np.empty((len(self.link_of), model.nv))
        jacobian = np.empty((2, 3, model.nv))
        ends = np.searchsorted(self.link_of, np.arange(len(self.links) + 1))
        for body, first, last in zip(self.bodies, ends[:-1], ends[1:], strict=True):
            mujoco.mj_jacBody(model, data, jacobian[0], jacobian[1], body)
            at_link = data.xmat[body].reshape(3, 3).T @ jacobian
            np.matmul(self.wrenches[first:last], at_link.reshape(6, -1), out=torques[first:last])
        return torques


@weak_cache
def _surface(robot: Robot) -> _Surface:
    model = kinematic_model(robot)
    links = list[str]()
    bodies = []
    wrenches = [np.zeros((0, 6))]
    for link in robot.links:
        body = int(model.body(link.name).id)
        if link.mesh is None or not _moves(model, body).any():
            continue
        points, normals = _hull_points(link.mesh)
        links.append(link.name)
        bodies.append(body)
        wrenches.append(np.concatenate([-normals, -np.cross(points, normals)], axis=1))
    link_of = np.repeat(np.arange(len(links)), [len(one) for one in wrenches[1:]])
    return _Surface(tuple(links), tuple(bodies), link_of, np.concatenate(wrenches))


def _hull_points(mesh: Mesh) -> tuple[FloatArray, FloatArray]:
    """Return points (k, 3) evenly on the convex hull of a mesh, and the hull's outward normals (k, 3) there.

    The hull has no inner walls. It is that of the extreme points in ``_DIRECTIONS`` directions; of a flat mesh it is
    these points alone.
    """
    number = np.arange(_DIRECTIONS) + 0.5
    # Fibonacci lattice
    polar = np.arccos(1 - 2 * number / _DIRECTIONS)
    azimuth = np.pi * (1 + np.sqrt(5)) * number
    directions = np.column_stack([np.cos(azimuth) * np.sin(polar), np.sin(azimuth) * np.sin(polar), np.cos(polar)])
    extreme = (directions @ mesh.vertices.T).argmax(axis=1)
    corners, first = np.unique(extreme, return_index=True)
    vertices = mesh.vertices[corners]
    try:
        hull = ConvexHull(vertices)
    except (QhullError, ValueError):
        return vertices, directions[first]
    corner = vertices[hull.simplices]
    areas = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    counts = np.maximum(np.rint(_POINTS * areas / areas.sum()), 1).astype(np.intp)
    face = np.repeat(np.arange(len(counts)), counts)
    within = np.arange(len(face)) - np.repeat(np.cumsum(counts) - counts, counts) + 0.5
    # Uniform on a triangle: square root and golden ratio sequence.
    root = np.sqrt(within / counts[face])
    turn = (0.6180339887 * within) % 1.0
    weights = np.column_stack([1 - root, root * (1 - turn), root * turn])
    return np.einsum("ki,kij->kj", weights, corner[face]), hull.equations[face, :3]
