"""The six control schemes of controllers with a task: joint velocities from errors of position and force at contacts.

Four give the point of every contact a velocity in space (``PointVelocityScheme``); ``ForceServo`` turns its force error
into a speed:

* Admittance: force and map errors move a mass in a viscous liquid, and the arm follows it.
* Hybrid force-position control (Raibert and Craig 1981): force along the normal, position across it.
* Parallel force-position control (Chiaverini and Sciavicco 1993): both act in all directions, and force has precedence.
  In acceleration form, with k_D = 1 / inertia_time and the other gains times k_D so that they keep their meaning:
  v' = k_D (K_P e_x + (k_F e_f + k_I integral of e_f) n - v). The integral cancels the position term along the normal,
  so the force error converges to zero at any contact location. Against a spring k_e it is stable for
  k_I k_e < k_D (K_P + k_F k_e) (Routh).
* Tactile servoing with a projection matrix (Li, Schürmann, Haschke and Ritter 2013), the simplest: errors in the
contact
  frame, two of position and one of force, are weighted by gains, selected by a projection matrix and turned into a
  velocity of the point. It takes the map for a rotated copy of the skin and ignores its stretch.

Two order the goals by priority:

* Priority (Nakamura 1987; Siciliano and Slotine 1991): force first, then position, then the rest posture.
* A quadratic program: force and position within bounds on speed, acceleration, joints and forces. It minimizes over
  joint velocities  w |outward speed - push|² + |sliding - requested|² + e |speed - rest|²  in a box, with weak
  directions damped as in least squares. The force of each contact after a tick, by a nominal stiffness, is at most its
  cap: linear inequalities, which daqp solves exactly (Arnström, Bemporad and Axehill 2022).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import compress

import daqp
import numpy as np

from tactile_maps.control.force_loop.loop_stability import CONTACT_STIFFNESS
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import MAX_JOINT_SPEED, MAX_POINT_SPEED
from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind
from tactile_maps.control.motion.task_priority import (
    ArmState,
    ContactKey,
    PriorityLevel,
    SpeedBound,
    TaskContact,
    normal_row,
    point_rows,
    single_level,
    singular_damping,
    singular_directions,
    solve_within_limits,
    weak_direction,
)
from tactile_maps.core.arrays import FloatArray, all_finite, length, within_length
from tactile_maps.core.errors import SimulationError

_LESS = 0.98
"""An error counts as smaller than an earlier one below this share of it."""


class ForceServo:
    """PI force controller with one integral per contact. Mutable; the integral of a contact is discarded with the
    contact.

    Integration starts only once the force has reached its goal, or once the error has stopped decreasing for
    ``integral_time`` (for example because a position goal opposes it). Integrating during the initial rise would push
    the arm into the object. While the output is saturated, the integral may decrease but not grow (conditional
    integration).

    Args:
        max_speed: Largest output [m/s].

    Attributes:
        held: Whether a joint is at its torque limit, or an approach is slowed down. Integrals do not grow then either.
        stuck: Ids of contacts whose point does not make the commanded motion. Their integrals do not grow.
    """

    def __init__(self, max_speed: float) -> None:
        self._max_speed = max_speed
        self.held = False
        self.stuck: frozenset[int] = frozenset()
        self._integrals: dict[ContactKey, float] = {}
        self._reached: set[ContactKey] = set()
        self._least: dict[ContactKey, tuple[float, float]] = {}  # error, and for how long none was less

    def keep(self, contacts: Iterable[ContactKey]) -> None:
        """Discard all other contacts."""
        kept = set(contacts)
        self._integrals = {key: value for key, value in self._integrals.items() if key in kept}
        self._reached &= kept
        self._least = {key: seen for key, seen in self._least.items() if key in kept}

    def integral(self, contact: ContactKey) -> float:
        """Return the integral of a contact [N s]."""
        return self._integrals.get(contact, 0.0)

    def push(
        self,
        settings: ControlSettings,
        contact: ContactKey,
        error: float,
        dt: float,
        limits: ActiveLimits,
        *,
        feedforward: float = 0.0,
    ) -> float:
        """Return the speed of the contact point along the outward normal [m/s]; positive values press harder.

        Args:
            settings: Settings with ``force_gain`` and ``integral_time``; with inf the integral does not change.
            contact: Key of the contact.
            error: Desired minus measured force [N].
            dt: Time since the previous call [s].
            limits: Collects a ``POINT_SPEED`` entry when the output saturates.
            feedforward: Additional outward speed [m/s]. The sum is saturated, so the integral can cancel a feedforward
                term that keeps the force away from its goal.
        """
        before = self.integral(contact)
        self._gather(contact, error, dt, settings.integral_time)
        requested = settings.force_gain * (error + self.integral(contact) / settings.integral_time) + feedforward
        bounded = min(max(requested, -self._max_speed), self._max_speed)
        if bounded != requested:
            limits.add(Limit(LimitKind.POINT_SPEED))
        if self.held or contact[0] in self.stuck or error * (requested - bounded) > 0:
            self._integrals[contact] = _only_unwound(before, self.integral(contact))
        return bounded

    def _gather(self, contact: ContactKey, error: float, dt: float, patience: float) -> None:
        if contact not in self._reached:
            least, waited = self._least.get(contact, (error, 0.0))
            self._least[contact] = (error, 0.0) if error < _LESS * least else (least, waited + dt)
            if error <= 0 or waited > patience:
                self._reached.add(contact)
        if contact in self._reached and math.isfinite(patience):
            self._integrals[contact] = self.integral(contact) + error * dt


def _only_unwound(before: float, after: float) -> float:
    """Return an integral that may return to zero, but neither grows nor changes its sign."""
    if before * after < 0:
        return 0.0
    return after if abs(after) < abs(before) else before


_NO_FORCE = 1e-6
"""Force along the skin that has no direction [N]."""
_SAME_SPEED = 1e-9
"""Difference of speeds that does not break a bound [m/s]."""


def shear_bounds(settings: ControlSettings, contacts: Sequence[TaskContact]) -> list[SpeedBound]:
    """Return the bounds that keep forces along the skin at most ``max_shear``.

    The skin moves with the force at least at the force gain times the excess; below the limit it may move against the
    force, the slower the nearer the limit is (a control barrier function).
    """
    most = settings.max_shear
    if most == math.inf:
        return []
    forces = [(contact, length(contact.shear)) for contact in contacts]
    return [
        SpeedBound(
            contact.shear.dot(contact.move) / size,
            min(settings.force_gain * (size - most), MAX_POINT_SPEED),
            Limit(LimitKind.SHEAR_CAP, value=size, bound=most),
        )
        for contact, size in forces
        if size > _NO_FORCE
    ]


class ForceScheme:
    """Base of the control schemes: a force servo, and least squares within the limits of the joints. Mutable."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Discard all integrals."""
        self._servo = ForceServo(MAX_POINT_SPEED)

    def start(self, contacts: Sequence[TaskContact], arm: ArmState) -> None:
        """Start a tick with these contacts; discard all others."""
        self._servo.keep(contact.key for contact in contacts)
        self._servo.held = arm.reference.bounded
        self._servo.stuck = arm.stuck

    def push(
        self,
        settings: ControlSettings,
        contact: TaskContact,
        dt: float,
        limits: ActiveLimits,
        *,
        feedforward: float = 0.0,
    ) -> float:
        """Return the outward speed [m/s] for the force error, see ``ForceServo.push``."""
        return self._servo.push(settings, contact.key, contact.force_error, dt, limits, feedforward=feedforward)

    def solve(
        self,
        levels: Sequence[PriorityLevel],
        settings: ControlSettings,
        contacts: Sequence[TaskContact],
        arm: ArmState,
        limits: ActiveLimits,
    ) -> FloatArray:
        """Solve by damped least squares; bounds on the shear of contacts have priority over all goals."""
        left = shear_bounds(settings, arm.touched)
        kept: list[SpeedBound] = []
        while True:
            found = ActiveLimits()
            first = [PriorityLevel(np.array([b.row for b in kept]), np.array([b.least for b in kept]))] if kept else []
            speed = self.least_squares([*first, *levels], contacts, arm, found)
            broken = [bound.row.dot(speed) < bound.least - _SAME_SPEED for bound in left]
            if not any(broken):
                break
            kept += compress(left, broken)
            left = [bound for bound, is_broken in zip(left, broken, strict=True) if not is_broken]
        for limit in (*(bound.limit for bound in kept), *found.found):
            limits.add(limit)
        return speed

    def least_squares(
        self, levels: Sequence[PriorityLevel], contacts: Sequence[TaskContact], arm: ArmState, limits: ActiveLimits
    ) -> FloatArray:
        """Return the joint velocity (n,) for the levels, without bounds on the shear."""
        return solve_within_limits(levels, arm.reference, arm.start, limits)


class PointVelocityScheme(ForceScheme, ABC):
    """A ``ControlScheme`` that gives each contact's point a velocity, all of equal priority. Mutable.

    It stores the last requested velocity of each contact.
    """

    def reset(self) -> None:
        """Discard integrals and velocities."""
        super().reset()
        self._velocities: dict[ContactKey, FloatArray] = {}

    @abstractmethod
    def velocity(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: ActiveLimits) -> FloatArray:
        """Return the requested velocity (3,) of the contact point [m/s], world frame; called once a tick."""

    def levels(
        self, settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState, limits: ActiveLimits
    ) -> list[PriorityLevel]:
        """Velocities of all contacts' points."""
        self.start(contacts, arm)
        self._velocities = {contact.key: self.velocity(settings, contact, arm.dt, limits) for contact in contacts}
        moves = [(contact, self._velocities[contact.key] + contact.made_up) for contact in contacts]
        return single_level([point_rows(contact, velocity) for contact, velocity in moves])

    def least_squares(
        self, levels: Sequence[PriorityLevel], contacts: Sequence[TaskContact], arm: ArmState, limits: ActiveLimits
    ) -> FloatArray:
        """Solve by damped least squares; where that loses speed, the normal speeds have priority.

        A weak direction is oblique to the skin. Damped, it would lose some of a normal speed and turn some of a
        tangential one into a normal one, which no feedback of force can cancel. Without a contact that is moved along
        the skin, all speeds are normal, and none has priority: a contact that the joints hardly move would otherwise
        drag the arm along the skin of the others until they are lost.
        """
        found = ActiveLimits()
        speed = super().least_squares(levels, contacts, arm, found)
        normal = [contact for contact in contacts if not contact.straight]
        if LimitKind.WEAK_DIRECTION in found and not all(contact.slides for contact in normal):
            found = ActiveLimits()
            first = single_level([normal_row(contact, self._velocities[contact.key]) for contact in normal])
            speed = super().least_squares([*first, *levels], contacts, arm, found)
        for limit in found.found:
            limits.add(limit)
        return speed

    def lagged(self, contact: TaskContact, aim: FloatArray, time: float, dt: float) -> FloatArray:
        """Return the last velocity (3,), moved towards ``aim`` with a time constant [s]; ``aim`` if that is less than a
        tick.

        A contact starts at rest.
        """
        before = self._velocities.get(contact.key)
        before = np.zeros(3) if before is None else before
        return before + min(dt / time, 1.0) * (aim - before) if time > dt else aim


def limit_point_speed(velocity: FloatArray, limits: ActiveLimits) -> FloatArray:
    """Return the velocity (3,) of a contact point, reduced to the largest speed."""
    bounded = within_length(velocity, MAX_POINT_SPEED)
    if bounded is not velocity:
        limits.add(Limit(LimitKind.POINT_SPEED))
    return bounded


class AdmittanceScheme(PointVelocityScheme):
    """Admittance with mobility ``force_gain`` and time constant ``inertia_time``: M v' + v / gain = force error.

    The mass is M = time / gain. Without integral, an object that approaches at a speed v causes an error v / gain.
    """

    def velocity(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: ActiveLimits) -> FloatArray:
        """Return the velocity of the mass at the contact."""
        place = contact.along(settings, MAX_POINT_SPEED)
        aim = limit_point_speed(place + settings.force_gain * contact.force_error * contact.normal, limits)
        return self.lagged(contact, aim, settings.inertia_time, dt)


class HybridScheme(PointVelocityScheme):
    """Selection by the skin's normal; if that is wrong, motion changes the force."""

    def velocity(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: ActiveLimits) -> FloatArray:
        """Return the velocity towards the target across the normal plus that of the force servo along it."""
        along = contact.along(settings, MAX_POINT_SPEED)
        normal = contact.normal
        return along + (self.push(settings, contact, dt, limits) - along.dot(normal)) * normal


MOST_RETURN = 0.02
"""Largest distance along the normal that the parallel scheme corrects [m], equal to the largest error of tasks along
the skin. Beyond it the pull back is constant, and the integral cancels it even while the contact moves on."""


@dataclass(frozen=True, eq=False)
class NormalOffset:
    """Displacement of a contact along its normal since it began, while the normal turns with the skin.

    Attributes:
        point: (3,) current position, world [m].
        normal: (3,) outward unit normal there.
        away: Distance back to the start along the normals of the track [m].
    """

    point: FloatArray
    normal: FloatArray
    away: float

    def after(self, point: FloatArray, normal: FloatArray) -> NormalOffset:
        """Return the offset at the next ``point`` (3,).

        It uses the mean of both normals, which is perpendicular to a chord of the skin. With one of them each step
        would add
        half its squared length times the curvature, always with the same sign: noise of the position would accumulate.
        """
        mean = self.normal + normal
        size = float(np.linalg.norm(mean))
        step = float(mean.dot(point - self.point)) / size if size > 0 else 0.0
        return NormalOffset(point, normal, self.away - step)


class ParallelScheme(PointVelocityScheme):
    """No selection: a wrong normal has less effect than in hybrid control, because the force integral has precedence.

    Along the normal a contact is drawn back to where it began. Both parts of its position error follow the skin: that
    of the task acts in the tangent plane, and the start is moved along in it, so that a normal that turns on the way
    causes no error of its own.
    """

    def reset(self) -> None:
        """Discard integrals, velocities and starting points."""
        super().reset()
        self._offsets: dict[ContactKey, NormalOffset] = {}

    def start(self, contacts: Sequence[TaskContact], arm: ArmState) -> None:
        """Start a tick; a new contact begins here."""
        super().start(contacts, arm)
        begun = {contact.key: NormalOffset(contact.point, contact.normal, 0.0) for contact in contacts}
        self._offsets = {key: self._offsets.get(key, offset) for key, offset in begun.items()}

    def velocity(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: ActiveLimits) -> FloatArray:
        """Return the sum of the responses to both errors, with the lag of the virtual inertia."""
        normal = contact.normal
        offset = self._offsets[contact.key] = self._offsets[contact.key].after(contact.point, normal)
        back = settings.position_gain * min(max(offset.away, -MOST_RETURN), MOST_RETURN)
        along = contact.along(settings, MAX_POINT_SPEED)
        outward = self.push(settings, contact, dt, limits, feedforward=back) - along.dot(normal)
        aim = limit_point_speed(along + outward * normal, limits)
        return self.lagged(contact, aim, settings.inertia_time, dt)


class ProjectionScheme(PointVelocityScheme):
    """Projection onto the errors that the task selects; those of position count only if the contact may not slide."""

    def velocity(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: ActiveLimits) -> FloatArray:
        """Return the response to the selected errors, rotated from the contact frame into space."""
        push = self.push(settings, contact, dt, limits) * contact.normal
        place = np.zeros(3)
        if contact.error is not None:
            place = -(settings.position_gain * contact.error + contact.velocity).dot(contact.map_axes)
        return limit_point_speed(push + contact.yielding(settings, place, MAX_POINT_SPEED), limits)


class PriorityScheme(ForceScheme):
    """Goals in strict order; near a singularity the weak direction is damped."""

    def levels(
        self, settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState, limits: ActiveLimits
    ) -> list[PriorityLevel]:
        """Return forces of all contacts, then positions of those that may not slide; together if force alone slides."""
        self.start(contacts, arm)
        levels = single_level([self._pushed(settings, contact, arm.dt, limits) for contact in contacts])
        held = [c for c in contacts if not c.slides and not c.straight]
        if held:
            rows = np.concatenate([c.map_axes.dot(c.move) for c in held])
            speed = np.concatenate([c.map_axes.dot(c.along(settings, MAX_POINT_SPEED) + c.made_up) for c in held])
            levels.append(PriorityLevel(rows, speed, held[0].map_axes if len(held) == 1 else None))
        return levels

    def _pushed(
        self, settings: ControlSettings, contact: TaskContact, dt: float, limits: ActiveLimits
    ) -> PriorityLevel:
        """Return the rows of one contact in the first level."""
        push = self.push(settings, contact, dt, limits)
        normal = contact.normal
        if not contact.straight:
            return PriorityLevel(contact.outward[None], np.array([push]), normal[None])
        along = contact.along(settings, MAX_POINT_SPEED) + contact.made_up
        return point_rows(contact, along + (push - along.dot(normal)) * normal)

    def least_squares(
        self, levels: Sequence[PriorityLevel], contacts: Sequence[TaskContact], arm: ArmState, limits: ActiveLimits
    ) -> FloatArray:
        """Solve by damped least squares, level by level; the remaining freedom is used to return to rest."""
        return solve_within_limits(levels, arm.reference, arm.start, limits, rest=arm.home)


MAX_ACCELERATION = 30.0
"""Largest acceleration of a hinge [rad/s²]; slides and slow joints reach their largest speed in the same time."""
LIMIT_RATE = 7.5
"""Largest speed of a joint towards its limit, per distance from it [1/s]."""
CAP_SHARE = 0.8
"""Largest force of contacts, as a share of the force at which the arm stops."""
_FORCE_WEIGHT = 100.0
_REST_WEIGHT = 1e-3
_SOFT = 8
"""Kind of a row in daqp that is violated as little as possible where the box leaves no other choice."""
_UNBOUNDED = 1e30


class QuadraticProgramScheme(PriorityScheme):
    """Errors of ``PriorityScheme`` in one quadratic program with bounds.

    Cost: 20 µs for seven joints and 30 µs with eight caps that apply (``findings.md`` of the guide).
    """

    def solve(
        self,
        levels: Sequence[PriorityLevel],
        settings: ControlSettings,
        contacts: Sequence[TaskContact],
        arm: ArmState,
        limits: ActiveLimits,
    ) -> FloatArray:
        """Solve for the speed in the box whose forces keep their caps; slow down where there is no solution.

        Raises:
            SimulationError: A coefficient of the program is not finite.
        """
        lower, upper = self._box(arm)
        hessian, gradient = _quadratic(levels, arm.home, arm.reference.max_speed, limits)
        bounds = [_force_cap(contact, settings, arm.dt) for contact in arm.touched]
        bounds += [*shear_bounds(settings, arm.touched), *_friction_bounds(settings, arm.touched)]
        speed, applied, problem = _solve_bounded(hessian, gradient, lower, upper, bounds)
        if problem:
            limits.add(Limit(LimitKind.NOT_SOLVED, detail=problem))
        _report_limits(speed, lower, upper, arm, limits)
        for bound in applied:
            limits.add(bound.limit)
        return speed

    def _box(self, arm: ArmState) -> tuple[FloatArray, FloatArray]:
        """Return bounds (n,) of the speed: largest speed, largest change, and reduced speed near a joint limit."""
        full = arm.reference.max_speed
        change = _max_change(arm)
        above = LIMIT_RATE * np.maximum(arm.reference.upper - arm.start, 0)
        below = LIMIT_RATE * np.minimum(arm.reference.lower - arm.start, 0)
        upper = np.minimum(np.minimum(full, arm.speed + change), above)
        lower = np.maximum(np.maximum(-full, arm.speed - change), below)
        return np.minimum(lower, upper), np.maximum(lower, upper)


def _max_change(arm: ArmState) -> FloatArray:
    """Return the largest change of the joint speeds (n,) in a tick."""
    return MAX_ACCELERATION * arm.dt * (arm.reference.max_speed / MAX_JOINT_SPEED)


def _quadratic(
    levels: Sequence[PriorityLevel], rest: FloatArray, max_speed: FloatArray, limits: ActiveLimits
) -> tuple[FloatArray, FloatArray]:
    """Return Hessian (n, n) and gradient (n,) with the damping of weak directions; see ``levels``."""
    hessian = np.diag(np.full(len(rest), _REST_WEIGHT))
    gradient = -_REST_WEIGHT * rest
    for weight, level in zip((_FORCE_WEIGHT, 1.0), levels, strict=False):
        left, gains, right = singular_directions(level.rows * max_speed)
        parts = list(zip(gains.tolist(), level.speed.dot(left).tolist(), strict=True))
        damping = singular_damping(parts, level, max_speed)
        for limit in weak_direction(parts, damping, left, level.axes):
            limits.add(limit)
        damped = np.square(gains) + damping
        right = right / max_speed
        hessian += weight * (right.T * damped).dot(right)
        gradient -= weight * level.speed.dot(level.rows)
    return hessian, gradient


def _friction_bounds(settings: ControlSettings, contacts: Sequence[TaskContact]) -> list[SpeedBound]:
    """Return the bounds that keep contacts from using more than the allowed share s of their friction.

    With the force Q along the skin, the normal force F and the same stiffness in both directions, the excess Q - s mu F
    falls with the speed of the skin along Q, and with s mu times its outward speed.
    """
    if settings.friction_use == math.inf:
        return []
    found = []
    for contact in contacts:
        share = settings.friction_use * contact.friction
        size = length(contact.shear)
        if size > _NO_FORCE:
            row = contact.shear.dot(contact.move) / size + share * contact.outward
            least = settings.force_gain * (size - share * contact.force)
            found.append(SpeedBound(row, least, Limit(LimitKind.FRICTION_CAP)))
    return found


def _force_cap(contact: TaskContact, settings: ControlSettings, dt: float) -> SpeedBound:
    """Return the bound for a force below its cap after the next tick, by a nominal stiffness."""
    excess = contact.force - CAP_SHARE * settings.max_force
    least = min(excess / (CONTACT_STIFFNESS * dt), MAX_POINT_SPEED)
    return SpeedBound(-contact.outward, least, Limit(LimitKind.FORCE_CAP))


_PROBLEMS = {
    -1: "no speed satisfies the bounds",
    -2: "the iterations repeat",
    -3: "the minimum is unbounded",
    -4: "too many iterations",
    -5: "the costs are not convex",
    -6: "the initial set of bounds is overdetermined",
}
"""Exit flags of daqp without a solution."""


def _solve_bounded(
    hessian: FloatArray, gradient: FloatArray, lower: FloatArray, upper: FloatArray, bounds: Sequence[SpeedBound]
) -> tuple[FloatArray, list[SpeedBound], str]:
    """Return the minimum in the box, the bounds that hold it, and the reason if no solution was found.

    The box always holds; bounds that it makes impossible are violated as little as possible.

    Returns:
        Speed (n,), empty without joints and the smallest in the box without a solution; bounds; text, empty if solved.

    Raises:
        SimulationError: A number is not finite.
    """
    n = len(gradient)
    if not n:
        return np.zeros(0), [], ""
    rows = np.array([bound.row for bound in bounds]).reshape(len(bounds), n)
    least = np.array([bound.least for bound in bounds])
    given = {"costs": (hessian, gradient), "joint speeds": (lower, upper), "bounds of contacts": (rows, least)}
    for place, numbers in given.items():
        if not all_finite(np.concatenate([part.ravel() for part in numbers])):
            remedy = "Check the readings, the posture and the settings of the controller"
            raise SimulationError("the quadratic program has a number that is not finite", place=place, remedy=remedy)
    kinds = np.zeros(n + len(bounds), dtype=np.int32)
    kinds[n:] = _SOFT
    speed, _, solved, result = daqp.solve(
        np.ascontiguousarray(hessian),
        gradient,
        rows,
        np.concatenate([upper, np.full(len(bounds), _UNBOUNDED)]),
        np.concatenate([lower, least]),
        kinds,
    )
    if solved <= 0:
        return np.clip(np.zeros(n), lower, upper), [], _PROBLEMS.get(solved, f"exit flag {solved}")
    holding = result["lam"][n:] < 0
    return np.clip(speed, lower, upper), [bound for bound, holds in zip(bounds, holding, strict=True) if holds], ""


def _report_limits(
    speed: FloatArray, lower: FloatArray, upper: FloatArray, arm: ArmState, limits: ActiveLimits
) -> None:
    at = (speed <= lower + 1e-9) | (speed >= upper - 1e-9)
    if not at.any():
        return
    fast = at & (np.abs(speed) >= arm.reference.max_speed - 1e-6)
    if fast.any():
        limits.add(Limit(LimitKind.JOINT_SPEED))
    slow = at & ~fast
    changing = np.abs(np.abs(speed - arm.speed) - _max_change(arm)) < 1e-6
    if (slow & changing).any():
        limits.add(Limit(LimitKind.JOINT_ACCELERATION))
    arm.reference.report_joint_limits(slow & ~changing, limits)
