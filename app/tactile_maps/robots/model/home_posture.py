"""A home posture for robots whose file states none and whose zero posture is not suitable for force control.

``choose_home`` looks at each limb: the joints that move one outermost link. Where a joint is at its limit, or the
links can hardly be moved in some direction (a straight arm), the limb gets another posture: of seeded samples from the
middle of the joint ranges the one in which its links move most evenly in all directions and in which most of their
surface can be moved off a contact. The others remain at zero.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import Finding, RobotError, did_you_mean
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.model.mujoco_spec import joints_before
from tactile_maps.robots.model.robot import Joint
from tactile_maps.robots.model.sanitize import touching_bodies

LEAST_TILT = np.deg2rad(15)
"""Smallest angle between the skin and the motion that joints give a point of it, for which the force on the point can
be controlled: normals of contacts may err by this much [rad]."""
LEAST_MARGIN = 0.02
"""A joint is at its limit when the distance is less than this share of its range."""
LEAST_EVENNESS = 0.25
"""A limb whose links move by less than this share as evenly as they could counts as ill-conditioned."""
MIDDLE = 0.6
"""Share of each joint range from which postures are sampled."""
SAMPLES = 300
MAX_SAMPLES = 3000
"""Postures of each limb, and of all limbs together."""
_SURFACE_SAMPLES = 24
_JOINTS_FOR_SPACE = 3  # fewer joints do not move a point in all directions


def motion_tilts(outward: FloatArray, move: FloatArray) -> FloatArray:
    """Return the angles (..., k) between the skin and the motion of its points by which the joints press most [rad].

    Args:
        outward: (..., k, n) speed of each point along its normal per joint velocity.
        move: (..., k, 3, n) velocity of each point per joint velocity.
    """
    squares = np.einsum("...n,...n->...", outward, outward)
    ways = np.linalg.norm(np.einsum("...in,...n->...i", move, outward), axis=-1)
    sines = np.divide(squares, ways, out=np.zeros_like(ways), where=ways > 1e-12)
    return np.arcsin(np.clip(sines, 0.0, 1.0))


@dataclass(frozen=True, eq=False)
class _Samples:
    """Points of the surface of one body and their normals, both (k, 3) in the body frame."""

    body: int
    points: FloatArray
    normals: FloatArray


@dataclass(frozen=True, eq=False)
class _Limb:
    """The joints (k,) that move an outermost link, and the links that at least three of them move."""

    joints: IntArray
    links: tuple[_Samples, ...]


def choose_home(
    model: mujoco.MjModel, home: FloatArray, surfaces: Mapping[int, Mesh]
) -> tuple[FloatArray, list[Finding]]:
    """Return a home posture (joints,) [rad, m] for a robot whose file states none, and the finding that reports it.

    Args:
        model: The robot alone, compiled, with scalar joints only.
        home: (joints,) the posture that results from the file.
        surfaces: Meshes of the links by body number, in their frames [m].

    Cost: 50 ms for an arm of six joints, 0.1 s for a hand of twelve.
    """
    coupled = _coupled_joints(model)
    limbs = [] if coupled is None else _limbs(model, surfaces, np.random.default_rng(0))
    if coupled is None or not limbs:
        return home, []
    search = _Search(model, home)
    fixed = coupled.copy()
    reasons = list[str]()
    for limb in limbs:
        free = limb.joints[~fixed[limb.joints]]
        samples = min(SAMPLES, MAX_SAMPLES // len(limbs))
        reason = search.improve(limb, free, np.random.default_rng(0), samples)
        fixed[limb.joints] = True
        if reason:
            reasons.append(reason)
    moved = search.home != home
    if not moved.any():
        return home, []
    names = ", ".join(model.joint(int(i)).name for i in np.flatnonzero(moved))
    note = (
        f"the file states no home posture, and at zero {'; '.join(dict.fromkeys(reasons))}: chosen away from limits and"
        " singular postures. State home to set another"
    )
    return search.home, [Finding("home-chosen", names, note, int(moved.sum()))]


def _coupled_joints(model: mujoco.MjModel) -> BoolArray | None:
    """Return the joints that a coupling relates to others (joints,); None where loops of links are closed."""
    coupled = np.zeros(model.nq, dtype=bool)
    for kind, one, other in zip(model.eq_type, model.eq_obj1id, model.eq_obj2id, strict=True):
        if kind != mujoco.mjtEq.mjEQ_JOINT:
            return None
        coupled[[joint for joint in (one, other) if joint >= 0]] = True
    return coupled


def _limbs(model: mujoco.MjModel, surfaces: Mapping[int, Mesh], rng: np.random.Generator) -> list[_Limb]:
    """Return the limbs, the one with most joints first."""
    samples = dict[int, _Samples]()
    chains = dict[int, tuple[int, ...]]()
    for body, mesh in surfaces.items():
        joints = joints_before(model, body)
        if len(joints) >= _JOINTS_FOR_SPACE and mesh.area > 0:
            faces = rng.choice(len(mesh.faces), _SURFACE_SAMPLES, p=mesh.face_areas / mesh.area)
            points = mesh.vertices[mesh.faces[faces]].mean(axis=1)
            samples[body] = _Samples(body, points, mesh.face_normals[faces])
            chains[body] = joints
    inner = {chain[:count] for chain in chains.values() for count in range(len(chain))}
    limbs = []
    for chain in sorted(set(chains.values()) - inner, key=lambda chain: (-len(chain), chain)):
        links = tuple(samples[body] for body, joints in chains.items() if joints == chain[: len(joints)])
        limbs.append(_Limb(np.array(chain, dtype=np.intp), links))
    return limbs


class _Search:
    """The home posture as far as it is chosen. Mutable.

    Attributes:
        home: (joints,) [rad, m].
    """

    def __init__(self, model: mujoco.MjModel, home: FloatArray) -> None:
        self._model = model
        self._data = mujoco.MjData(model)
        self._slides = model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE
        self._limited = model.jnt_limited.astype(bool)
        self.home = home.copy()
        self._allowed = touching_bodies(model, self._data, home)

    def improve(self, limb: _Limb, free: IntArray, rng: np.random.Generator, count: int) -> str:
        """Move the ``free`` joints of a limb where its posture is not suitable; return why, or nothing."""
        if not len(free):
            return ""
        at_limit = free[self._margins(free) < LEAST_MARGIN]
        inside = self._inside(at_limit)
        middle, half = self._ranges(free)
        postures = np.tile(inside, (count + 1, 1))
        postures[0, free] = middle
        postures[1:, free] = middle + MIDDLE * half * rng.uniform(-1.0, 1.0, (count, len(free)))
        qualities = self._qualities(limb, postures)
        lowest = min(self._lowest(limb, self.home), 0.0) - 1e-3
        names = ", ".join(self._model.joint(int(i)).name for i in at_limit)
        even = self._quality(limb, inside) >= LEAST_EVENNESS * qualities.max()
        if even and not len(at_limit):
            return ""
        if even and self._is_free(limb, inside, lowest):
            self.home = inside
            return f"{names} at a limit"
        for number in np.argsort(-qualities, kind="stable"):
            if self._is_free(limb, postures[number], lowest):
                self.home = self._nearest(limb, free, postures[number], lowest)
                return "the links hardly move in some direction" if not even else f"{names} at a limit"
        return ""

    def _inside(self, at_limit: IntArray) -> FloatArray:
        """Return home with the joints that are at a limit at the edge of the middle of their range."""
        inside = self.home.copy()
        middle, half = self._ranges(at_limit)
        inside[at_limit] = middle + MIDDLE * half * np.sign(self.home[at_limit] - middle)
        return inside

    def _is_free(self, limb: _Limb, posture: FloatArray, lowest: float) -> bool:
        """Whether no other links touch each other than at home, and no link is below ``lowest`` [m]."""
        touching = touching_bodies(self._model, self._data, posture)
        return self._lowest(limb, posture) >= lowest and touching <= self._allowed

    def _nearest(self, limb: _Limb, free: IntArray, chosen: FloatArray, lowest: float) -> FloatArray:
        """Return ``chosen`` with the joints at zero again that are not needed, such as the first one of an arm."""
        quality = self._quality(limb, chosen)
        margins = self._margins(free)
        for joint, margin in zip(free.tolist(), margins.tolist(), strict=True):
            trial = chosen.copy()
            trial[joint] = self.home[joint]
            kept = margin >= LEAST_MARGIN and self._quality(limb, trial) >= 0.99 * quality
            if kept and self._is_free(limb, trial, lowest):
                chosen = trial
        return chosen

    def _ranges(self, joints: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the middles (k,) of the joint ranges and half their widths; a turn or a metre where there is none."""
        span = np.where(self._slides[joints], 0.5, np.pi)
        lower, upper = self._model.jnt_range[joints].T
        middle = np.where(self._limited[joints], 0.5 * (lower + upper), self.home[joints])
        half = np.where(self._limited[joints], 0.5 * (upper - lower), span)
        return middle, np.minimum(half, span)

    def _margins(self, joints: IntArray) -> FloatArray:
        """Return the distance (k,) of the home posture from the nearest limit as a share of each range."""
        lower, upper = self._model.jnt_range[joints].T
        width = np.maximum(upper - lower, 1e-12)
        margins = np.minimum(self.home[joints] - lower, upper - self.home[joints]) / width
        return np.where(self._limited[joints], margins, np.inf)

    def _place(self, posture: FloatArray) -> None:
        self._data.qpos[:] = posture
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)

    def _quality(self, limb: _Limb, posture: FloatArray) -> float:
        return float(self._qualities(limb, posture[None])[0])

    def _qualities(self, limb: _Limb, postures: FloatArray) -> FloatArray:
        """Return the mean over the links of evenness times the share of the tilts that suffice, 0 to 1.

        Args:
            limb: The limb.
            postures: (k, joints) [rad, m].
        """
        shape = len(limb.links), len(postures)
        rotations = np.zeros((*shape, 3, 3))
        linear, angular = np.zeros((2, *shape, 3, self._model.nv))
        for k, posture in enumerate(postures):
            self._place(posture)
            for number, link in enumerate(limb.links):
                rotations[number, k] = self._data.xmat[link.body].reshape(3, 3)
                mujoco.mj_jacBody(self._model, self._data, linear[number, k], angular[number, k], link.body)
        total = np.zeros(len(postures))
        for number, link in enumerate(limb.links):
            turned = rotations[number].transpose(0, 2, 1)
            move = point_motion(linear[number], angular[number], link.points @ turned)
            tilts = motion_tilts(np.einsum("kpi,kpin->kpn", link.normals @ turned, move), move)
            stretch = np.linalg.svd(move.mean(axis=1), compute_uv=False)
            evenness = np.divide(stretch[:, -1], stretch[:, 0], out=np.zeros(len(stretch)), where=stretch[:, 0] > 0)
            total += evenness * np.minimum(tilts / LEAST_TILT, 1.0).mean(axis=1)
        return total / len(limb.links)

    def _lowest(self, limb: _Limb, posture: FloatArray) -> float:
        """Return the height of the lowest sampled point of a limb [m]."""
        self._place(posture)
        lows = [
            (link.points @ self._data.xmat[link.body].reshape(3, 3)[2]).min() + self._data.xpos[link.body, 2]
            for link in limb.links
        ]
        return float(min(lows))


def point_motion(linear: FloatArray, angular: FloatArray, arms: FloatArray) -> FloatArray:
    """Return the velocities (..., k, 3, n) per joint velocity of points of a link.

    Args:
        linear: (..., 3, n) velocity of the link's origin per joint velocity, world frame.
        angular: (..., 3, n) its angular velocity.
        arms: (..., k, 3) the points from the origin, world frame [m].
    """
    turned = np.cross(angular.swapaxes(-1, -2)[..., None, :, :], arms[..., None, :])  # (..., k, n, 3)
    return np.asarray(linear[..., None, :, :] + turned.swapaxes(-1, -2))


def check_home(home: Mapping[str, float], joints: Sequence[Joint], *, source: str) -> None:
    """Raise an error for a home posture with an unknown joint or a position outside the limits of a joint.

    Args:
        home: Joint values by joint name [rad, m].
        joints: Joints of the robot.
        source: Path or name of the robot, for errors.

    Raises:
        RobotError: It names the joint, the value and the range.
    """
    by_name = {joint.name: joint for joint in joints}
    for name, value in home.items():
        if name not in by_name:
            remedy = did_you_mean(name, tuple(by_name))
            raise RobotError(
                "the robot has no such joint", file=source, place=f"home.{name}", value=name, remedy=remedy
            )
        joint = by_name[name]
        if not joint.lower - 1e-9 <= value <= joint.upper + 1e-9:
            remedy = f"Choose {joint.lower:.4g} to {joint.upper:.4g} {'m' if joint.slide else 'rad'}"
            problem = "the home position of a joint is out of range"
            raise RobotError(problem, file=source, place=f"home.{name}", value=value, remedy=remedy)
