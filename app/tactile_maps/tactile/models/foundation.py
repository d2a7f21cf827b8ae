"""Foundation model: the cover as an elastic layer that computes the contact force itself, instead of the solver.

Every quadrature point has a spring of the layer's real stiffness per area, K = E (1 - nu) / ((1 + nu) (1 - 2 nu) h) (a
Winkler foundation; Johnson, Contact Mechanics, 4.3). A point at depth d inside a body has the pressure  p = K (d + T
d'), never negative, with the material's relaxation time T = 1 ms. It pushes link and body apart along the body's
surface normal, with equal and opposite forces at the same point of the world. There is no friction. Sliding a body
along a flat bed, or turning it about the bed's normal, changes no depth, so that the springs resist neither. The sum
over points does: the strips in which a side of the body is its nearest surface are as narrow as the depth, and fall
between the points. Where a body rests within a flat part of the bed, the elastic force along the bed and the elastic
torque about its normal are therefore removed; the force passes through the body's centre of mass, so that a ball is not
turned. The bare points of a skinned link (``Skin.bare_points``) are springs as well, so that nothing falls through the
parts without skin; no taxel reads them, and a note states their share of a load.

The force is explicit, so a time step must be shorter than 0.6 sqrt(m / k), with k the layer's stiffness under the whole
contact and m the effective mass of the two bodies. A longer step is rejected rather than divided: dividing it would
change the rest of the physics, and the cost of a scene would depend on its forces. A body that is deeper than the
thickness of the layer and than half its own size is rejected as well, and so is one that passed through within a step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import mujoco
import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import SimulationError
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.broadphase import FACING
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, bent_skin_notes, border_notes
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Box, Cylinder, Load, Plane, Shape, Sphere
from tactile_maps.tactile.mechanics.receptive_field import (
    ReceptiveField,
    load_points,
    points_of_link,
    quadrature_points,
)
from tactile_maps.tactile.models.water_fill import WaterFillModel


class ContactWrench(NamedTuple):
    """Force and torque, in the world.

    Attributes:
        body: Number of the body on which they act.
        other: Number of the other body, on which the opposite acts.
        point: (3,) where the force acts [m].
        force: (3,) [N].
        torque: (3,) about that point [N m].
    """

    body: int
    other: int
    point: FloatArray
    force: FloatArray
    torque: FloatArray


RELAXATION = 1e-3
"""Relaxation time of the layer [s]: damping per area over stiffness per area."""
STABLE = 0.6
"""An explicit spring gains no energy while dt < 0.6 sqrt(m / k); measured."""
SLACK = 3e-3
"""Distance from a body below which points are checked in every step [m]."""
_NUDGE = 1e-6
_SAME_NORMAL = 1e-6
_LEVEL = 1e-5
"""Tolerances of flatness: one minus the cosine between normals, and difference of heights [m]."""
_NEIGHBOURS = 25


@dataclass(frozen=True, eq=False)
class ContactCandidate:
    """A link with skin and a body that may press it.

    Attributes:
        link: The link.
        body: Number of the other body in the model.
        shape: Shape of the other body.
        pose: ``T_body_shape``.
        by: Displayed name of the other body; the link's name if it is a link.
        own: Shape of the link itself and its ``T_link_shape``, where the other body is a link called ``by`` that has
            skin too: two layers in series are half as stiff, and both feel the force.
    """

    link: str
    body: int
    shape: Shape
    pose: Pose
    by: str
    own: tuple[Shape, Pose] | None = None


class FoundationModel:
    """The elastic layer: ``push`` applies the forces of a step, ``pressures`` returns the readings of the taxels.

    A taxel measures the force along its own normal. On flat skin the sum of pressure times area therefore is the normal
    force. On bent skin it differs by geometry, since the force on each point acts along the body's normal: with the
    skin's normal at an angle s to the force and the body's at an angle b on the other side, a point adds cos(s + b) to
    the sum and cos(b) to the force. Readings sum to less than the force on convex skin and to more on concave skin. No
    single factor corrects that without the body's shape, so a note states the ratio of each contact.

    Of two links with skin in contact one makes the force. The other spreads the same scalar sum as by water-fill, so
    that the readings of both sides agree. Fingers bring their own force; it is spread as by water-fill too.

    Args:
        model: The compiled model, without contacts of the skin.
        skin: The skin.
        layer: Its cover.
        candidates: Pairs that may touch.
        field: Receptive field of the taxels.
        averages: Whether readings are the mean of all steps since ``begin``.

    Attributes:
        notes: Deviations at the last reading.
        wrenches: Contact wrenches of the last step.

    Cost at every step, with 400 taxels on a busy core: 14 µs a pair that is far apart; in contact 0.5 ms for a ball of
    20 mm and 2.3 ms for the face of a box of 40 mm, since it grows with the number of points in contact.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        skin: Skin,
        layer: ElasticLayer,
        candidates: Sequence[ContactCandidate],
        field: ReceptiveField,
        *,
        averages: bool = False,
    ) -> None:
        self._averages = averages
        self._steps = 0
        self._model = model
        self._stiffness = layer.foundation
        self._field = field
        self._thickness = layer.thickness
        self._fill = WaterFillModel(skin, layer=layer, field=field)
        beds = {link: _LinkPoints(model, skin, link) for link in skin.links}
        self._pairs = [_ContactPair(beds[candidate.link], candidate) for candidate in candidates]
        self._felt: list[tuple[IntArray, FloatArray]] = []
        self._shares: dict[tuple[str, str], FloatArray] = {}
        self._mirrored: list[Load] = []
        self.notes: tuple[ContactNote, ...] = ()
        self.wrenches: list[ContactWrench] = []
        self._pushed = 0.0
        self._sums: dict[tuple[str, str], FloatArray] = {}

    def begin(self) -> None:
        """Begin a tick."""
        self._felt = []
        self._mirrored = []
        self._shares = {}
        self._steps = 0
        self._pushed = 0.0
        self._sums = {}

    @property
    def total_force(self) -> float:
        """Sum of the magnitudes of all its forces at the last step [N], or on average since ``begin``."""
        return self._pushed / max(self._steps, 1)

    def push(self, data: mujoco.MjData) -> None:
        """Add the layer's forces on both bodies of every pair to ``data.qfrc_applied``.

        Args:
            data: State with positions and velocities of this instant (``mj_step1``).

        Raises:
            SimulationError: The layer under a contact is too stiff for the time step, or is pressed through.
        """
        if not self._averages:
            self.begin()
        self._steps = self._steps + 1
        self.wrenches = []
        for pair in self._pairs:
            press = self._press(data, pair)
            if press is not None:
                self._apply(data, pair, press)

    def pressures(self, loads: Sequence[Load]) -> FloatArray:
        """Return the mean pressures (taxels,) [Pa] for the forces of the last step and of fingers (``loads``)."""
        steps = max(self._steps, 1)
        mirrored = [replace(load, force=load.force / steps) for load in self._mirrored]
        pressures = self._fill.pressures([*loads, *mirrored])
        self.notes = self._fill.notes
        for (by, link), (bare, total) in self._shares.items():
            self.notes += border_notes(bare / total, by, link)
        for (by, link), (felt, force) in self._sums.items():
            self.notes += bent_skin_notes(float(felt), float(force), by, link)
        for points, forces in self._felt:
            self._field.add(pressures, points, forces / steps)
        return pressures

    def _press(self, data: mujoco.MjData, pair: _ContactPair) -> _LayerForces | None:
        """Return the layer's forces at this instant; None without contact."""
        if pair.went_through(data, self._model.opt.timestep):
            raise SimulationError(
                "the layer is pressed through",
                place=f"{pair.candidate.by} on {pair.candidate.link} at {data.time:.3f} s",
                value="its middle went behind the layer within a step",
                remedy="Press less, or use a stiffer layer or a shorter time step",
            )
        found = pair.found
        if found is None:
            return None
        bed = pair.bed
        candidate = pair.candidate
        points, depth, away = found
        places = bed.positions[points] @ data.xmat[bed.body].reshape(3, 3).T + data.xpos[bed.body]
        layers = 1 if candidate.own is None else 2
        stiffness = self._stiffness / layers
        self._refuse_deep(data, candidate, float(depth.max()), layers)
        self._refuse_stiff(data, pair, stiffness * float(bed.areas[points].sum()))
        rate = _closing(self._model, data, bed.body, candidate.body, places, away)
        forces = np.maximum(stiffness * (depth + RELAXATION * rate), 0.0) * bed.areas[points]
        elastic = np.where(forces > 0, stiffness * depth * bed.areas[points], 0.0)
        outward = bed.normals[points] @ data.xmat[bed.body].reshape(3, 3).T
        felt = -np.einsum("ij,ij->i", away, outward) * forces
        return _LayerForces(points, places, away, outward, forces, elastic, felt)

    def _apply(self, data: mujoco.MjData, pair: _ContactPair, press: _LayerForces) -> None:
        total = float(press.forces.sum())
        if total <= 0:
            return
        bed = pair.bed
        candidate = pair.candidate
        forces = press.forces[:, None] * press.away
        middle = press.forces @ press.places / total
        force = forces.sum(axis=0)
        torque = _torque(press.places - middle, forces)
        if pair.is_within_flat(press.points):
            centre = pair.centre(self._model, data)
            along, turning = _along_flat(press, centre)
            force -= along
            torque += _torque((middle - centre)[None], along[None]) - turning
        for body, sign in ((bed.body, 1.0), (candidate.body, -1.0)):
            mujoco.mj_applyFT(self._model, data, sign * force, sign * torque, middle, body, data.qfrc_applied)
        self.wrenches.append(ContactWrench(bed.body, candidate.body, middle, force, torque))
        self._pushed += float(np.linalg.norm(force))
        read = int(np.searchsorted(press.points, bed.read))  # the bare points are the last
        self._felt.append((bed.points[press.points[:read]], press.felt[:read]))
        share = self._shares.setdefault((candidate.by, candidate.link), np.zeros(2))
        share += press.forces[read:].sum(), total
        sums = self._sums.setdefault((candidate.by, candidate.link), np.zeros(2))
        felt = press.felt[:read].sum()
        sums += felt, felt if bed.is_flat(press.points) else np.linalg.norm(forces[:read].sum(axis=0))
        if candidate.own is not None:
            self._mirrored.append(_mirrored_load(data, pair, middle, force, float(press.felt.sum())))

    def _refuse_deep(self, data: mujoco.MjData, candidate: ContactCandidate, depth: float, layers: int) -> None:
        """Reject a body that is too deep: one that is completely inside would touch no spring."""
        most = max(layers * self._thickness, 0.5 * candidate.shape.reach)
        if depth > most:
            raise SimulationError(
                "the layer is pressed through",
                place=f"{candidate.by} on {candidate.link} at {data.time:.3f} s",
                value=f"{1e3 * depth:.3g} mm deep, of {1e3 * most:.3g} mm at most",
                remedy="Press less, or use a stiffer layer or a shorter time step",
            )

    def _refuse_stiff(self, data: mujoco.MjData, pair: _ContactPair, stiffness: float) -> None:
        """Reject a contact whose explicit spring is unstable with the mass of both bodies."""
        weights = self._model.body_invweight0[:, 0]
        candidate = pair.candidate
        mobility = float(weights[pair.bed.body] + weights[candidate.body])
        longest = STABLE / np.sqrt(max(stiffness * mobility, 1e-12))
        if self._model.opt.timestep > longest:
            raise SimulationError(
                "the layer is too stiff for the time step",
                place=f"{candidate.by} on {candidate.link} at {data.time:.3f} s",
                value=f"{stiffness:.3g} N/m against {1 / mobility:.3g} kg",
                remedy=f"Use a time step of at most {1e3 * longest:.2g} ms, or a softer or thicker layer",
            )


class _LinkPoints:
    """The springs of one link; the first ``read`` are those of its skin, the others are its bare points."""

    def __init__(self, model: mujoco.MjModel, skin: Skin, link: str) -> None:
        everything = load_points(skin)
        self.body = int(model.body(link).id)
        self.points: IntArray = points_of_link(skin, link)
        self.read = int(np.searchsorted(self.points, len(quadrature_points(skin).areas)))
        self.positions = everything.positions[self.points]
        self.normals = everything.normals[self.points]
        self.areas = everything.areas[self.points]
        self.extent = float(np.linalg.norm(self.positions, axis=1).max(initial=0.0))

    def is_flat(self, points: IntArray) -> bool:
        """Whether ``points`` are in one plane and have the same normal."""
        normal = self.normals[points[0]]
        offset = self.positions[points] - self.positions[points[0]]
        return bool((self.normals[points] @ normal).min() > 1 - _SAME_NORMAL and abs(offset @ normal).max() < _LEVEL)

    @cached_property
    def on_rim(self) -> BoolArray:
        """(n,) whether a point is at the border of the flat part that it is on.

        There the directions to its neighbours in the same plane leave more than 120 degrees free. Cost: 20 µs a point,
        once.
        """
        _, near = cKDTree(self.positions).query(self.positions, k=min(_NEIGHBOURS, len(self.positions)))
        near = near.reshape(len(self.positions), -1)[:, 1:]
        offset = self.positions[near] - self.positions[:, None]
        agreement = np.einsum("ijk,ik->ij", self.normals[near], self.normals)
        height = np.einsum("ijk,ik->ij", offset, self.normals)
        level = (agreement > 1 - _SAME_NORMAL) & (abs(height) < _LEVEL)
        first = np.cross(self.normals, np.eye(3)[np.abs(self.normals).argmin(axis=1)])
        second = np.cross(self.normals, first)
        angle = np.arctan2(np.einsum("ijk,ik->ij", offset, second), np.einsum("ijk,ik->ij", offset, first))
        # Neighbours on other planes get the angle of one that counts.
        least = angle.min(axis=1, keepdims=True, initial=math.pi, where=level)
        ordered = np.sort(np.where(level, angle, least), axis=1)
        if not ordered.size:
            return np.ones(len(self.positions), dtype=bool)
        gaps = np.diff(ordered, axis=1, append=ordered[:, :1] + 2 * math.pi)
        return np.asarray(gaps.max(axis=1) > 2 * math.pi / 3)


class _ContactPair:
    """State of one pair, with a cache of the close points.

    A signed distance changes no faster than the bodies move, so only the points nearer than a slack can touch until
    something has moved by the slack, or by the smallest distance if that is larger.
    """

    def __init__(self, bed: _LinkPoints, candidate: ContactCandidate) -> None:
        self.bed = bed
        self.candidate = candidate
        self._near: IntArray = np.zeros(0, dtype=np.int64)
        self.found: tuple[IntArray, FloatArray, FloatArray] | None = None
        self._beyond = False
        self._middle = np.zeros(3)
        self._time = math.inf
        self._room = -1.0
        self._level: bool | None = None
        self._rotation = np.eye(3)
        self._offset = np.zeros(3)

    def went_through(self, data: mujoco.MjData, step: float) -> bool:
        """Whether the body's centre passed behind the layer within the last step.

        It is computed in the frame of the link, so that either of both may move. Cost: 2 µs, and more for the points on
        the way if the body moved by more than its bounding radius.
        """
        bed = self.bed
        before = self._middle
        earlier = self._time
        pressed = self.found is not None
        self.found = self.deep(data)
        turn = data.xmat[bed.body].reshape(3, 3)
        middle = data.xmat[self.candidate.body].reshape(3, 3) @ self.candidate.pose.translation
        self._middle = (middle + data.xpos[self.candidate.body] - data.xpos[bed.body]) @ turn
        self._time = data.time
        if self.found is not None or not 0 < data.time - earlier < 1.5 * step:
            return False
        if pressed and self._beyond:
            return True
        way = self._middle - before
        far = float(way @ way)
        if far <= self.candidate.shape.reach**2:
            return False
        share = np.clip((bed.positions - before) @ way / far, 0.0, 1.0)
        off = bed.positions - before - share[:, None] * way
        met = np.einsum("ij,ij->i", off, off) < self.candidate.shape.reach**2
        return bool((met & (bed.normals @ way < 0)).any())

    def deep(self, data: mujoco.MjData) -> tuple[IntArray, FloatArray, FloatArray] | None:
        """Return the points inside the body that face it, their depths [m], and the body's outward normals there,
        world frame; None without any."""
        bed = self.bed
        candidate = self.candidate
        turn = data.xmat[candidate.body].reshape(3, 3) @ candidate.pose.rotation
        place = data.xmat[candidate.body].reshape(3, 3) @ candidate.pose.translation + data.xpos[candidate.body]
        # A point x of the link is at  x rotation + offset  in the shape's frame.
        rotation = data.xmat[bed.body].reshape(3, 3).T @ turn
        offset = (data.xpos[bed.body] - place) @ turn
        self._keep_near(rotation, offset)
        self._beyond = False
        if not self._near.size:
            return None
        seen = bed.positions[self._near] @ rotation + offset
        distance = candidate.shape.distance(seen)
        inside = np.flatnonzero(distance < 0)
        if not inside.size:
            return None
        away = _gradient(candidate.shape, seen[inside])
        # The far side of a link is not pressed from within, nor its bare sides by a face that reaches over an edge.
        cosine = np.einsum("ij,ij->i", away @ rotation.T, bed.normals[self._near[inside]])
        facing = cosine < np.where(self._near[inside] < bed.read, 0.0, -FACING)
        self._beyond = not facing.any()
        inside = inside[facing]
        return (self._near[inside], -distance[inside], away[facing] @ turn.T) if inside.size else None

    def is_within_flat(self, points: IntArray) -> bool:
        """Whether all points close to the body, of which ``points`` are in contact, are inside a flat part of the bed.

        Points of the link's far side do not count.
        """
        if self._level is None:
            bed = self.bed
            front = self._near[bed.normals[self._near] @ bed.normals[points[0]] > -0.5]
            self._level = bed.is_flat(front) and not bed.on_rim[front].any()
        return self._level

    def centre(self, model: mujoco.MjModel, data: mujoco.MjData) -> FloatArray:
        """Return the body's centre of mass (3,), world frame [m]; the origin of its shape if it has no mass."""
        body = self.candidate.body
        if model.body_mass[body] > 0:
            return np.asarray(data.xipos[body])
        return np.asarray(data.xmat[body].reshape(3, 3) @ self.candidate.pose.translation + data.xpos[body])

    def _keep_near(self, rotation: FloatArray, offset: FloatArray) -> None:
        turned = np.linalg.norm(rotation - self._rotation) * self.bed.extent
        if turned + np.linalg.norm(offset - self._offset) < self._room:
            return
        distance = self.candidate.shape.distance(self.bed.positions @ rotation + offset)
        self._near = np.flatnonzero(distance < SLACK)
        self._level = None
        self._room = max(SLACK, float(distance.min(initial=np.inf)))
        self._rotation = rotation
        self._offset = offset


@dataclass(frozen=True, eq=False)
class _LayerForces:
    """The forces of one contact.

    Attributes:
        points: (k,) numbers of the points.
        places: (k, 3) their positions, world frame [m].
        away: (k, 3) outward normals of the other body there, world.
        outward: (k, 3) outward normals of the skin there, world.
        forces: (k,) along ``away`` [N].
        elastic: (k,) the part of the springs, without the dampers [N].
        felt: (k,) the part of ``forces`` against ``outward`` [N].
    """

    points: IntArray
    places: FloatArray
    away: FloatArray
    outward: FloatArray
    forces: FloatArray
    elastic: FloatArray
    felt: FloatArray


def _torque(arms: FloatArray, forces: FloatArray) -> FloatArray:
    """Return the sum (3,) of the cross products of ``arms`` and ``forces`` (k, 3)."""
    turn = arms.T @ forces
    return np.array([turn[1, 2] - turn[2, 1], turn[2, 0] - turn[0, 2], turn[0, 1] - turn[1, 0]])


def _along_flat(press: _LayerForces, centre: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the springs' force along a flat bed [N] and their torque about its normal through ``centre`` [N m]."""
    normal = press.outward[0]
    forces = press.elastic[:, None] * press.away
    force = forces.sum(axis=0)
    turning = _torque(press.places - centre, forces) @ normal
    return force - force @ normal * normal, turning * normal


def _pose(data: mujoco.MjData, body: int) -> Pose:
    return Pose(data.xmat[body].reshape(3, 3), data.xpos[body])


def _gradient(shape: Shape, points: FloatArray) -> FloatArray:
    """Return (k, 3) outward unit normals of the shape's surface at ``points`` (k, 3), shape frame.

    Closed forms for simple shapes; central differences for all others, mainly meshes. One-sided differences err by the
    step over the radius, which made a ball at rest spin faster and faster. At the centre of a ball the normal is zero.
    """
    if isinstance(shape, Sphere):
        return _unit(points)
    if isinstance(shape, Plane):
        return np.tile([0.0, 0.0, 1.0], (len(points), 1))
    if isinstance(shape, Box):
        beyond = np.ascontiguousarray(np.abs(points).T) - np.array(shape.half)[:, None]
        return _unit(np.copysign(_away_from_sides(beyond).T, points))
    if isinstance(shape, Cylinder):
        directions = points.copy()
        aside = np.sqrt(np.einsum("ij,ij->i", points[:, :2], points[:, :2]))
        side, cap = _away_from_sides(np.array([aside - shape.radius, np.abs(points[:, 2]) - shape.half]))
        directions[:, :2] *= (side / np.maximum(aside, _NUDGE))[:, None]
        directions[:, 2] = np.copysign(cap, points[:, 2])
        return _unit(directions)
    nudges = _NUDGE * np.concatenate([np.eye(3), -np.eye(3)])
    ahead, behind = shape.distance((points + nudges[:, None]).reshape(-1, 3)).reshape(2, 3, -1)
    slopes = (ahead - behind).T
    length = np.sqrt(np.einsum("ij,ij->i", slopes, slopes))
    return np.asarray(slopes / np.maximum(length, 1e-3 * _NUDGE)[:, None])


def _away_from_sides(beyond: FloatArray) -> FloatArray:
    """Return (n, k) a direction away from the nearest of perpendicular sides, given the distances (n, k) beyond them.

    Inside, sides as near as the nearest count alike, so that the directions at mirrored points are mirrored.
    """
    nearest = beyond.max(axis=0)
    return np.where(nearest < 0, beyond > nearest - _NUDGE, np.maximum(beyond, 0.0))


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return np.asarray(vectors / np.maximum(length, 1e-3 * _NUDGE)[:, None])


def _closing(
    model: mujoco.MjModel, data: mujoco.MjData, link: int, other: int, places: FloatArray, away: FloatArray
) -> FloatArray:
    """Return the rate of change of the points' depths (k,) [m/s]."""
    closing = np.zeros(len(places))
    motion = np.zeros(6)
    for body, sign in ((other, 1.0), (link, -1.0)):
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, motion, 0)
        (x, y, z), arm = motion[:3], places - data.xpos[body]
        turning = arm @ np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        closing += sign * np.einsum("ij,ij->i", away, turning + motion[3:])
    return closing


def _mirrored_load(data: mujoco.MjData, pair: _ContactPair, middle: FloatArray, force: FloatArray, felt: float) -> Load:
    """Return the load on the other link's skin: the shape of this link, with the same sum of forces along normals."""
    candidate = pair.candidate
    assert candidate.own is not None
    shape, pose = candidate.own
    other = _pose(data, candidate.body).inverse
    normal = other.directions(force / np.linalg.norm(force))
    where = other @ _pose(data, pair.bed.body) @ pose
    return Load(candidate.by, other.points(middle), normal, felt, shape, where, candidate.link)
