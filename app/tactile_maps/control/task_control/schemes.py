"""The six control schemes of controllers with a task: how errors of place and force at contacts become joint
velocities.

Four tell for every contact how its point should move in space (``PointVelocityScheme``), with force error to speed by
``ForceServo``:

* admittance: force and map errors move a mass in a viscous liquid, and the arm goes where it goes;
* hybrid force-position control (Raibert and Craig 1981): force along the normal, position across it;
* parallel force-position control (Chiaverini and Sciavicco 1993): both act along all directions, and force wins. In
acceleration form with
  k_D = 1 / inertia_time, and the other gains times k_D so that they keep their meaning:
  v' = k_D (K_P e_x + (k_F e_f + k_I integral of e_f) n - v). Position along the normal gives way to the integral of
  force, which is bounded only together with it: the error of force goes to zero wherever the contact stands. Against a
  spring k_e it is stable while k_I k_e < k_D (K_P + k_F k_e) (Routh);
* tactile servoing with a projection matrix (Li, Schürmann, Haschke and Ritter 2013), the simplest: errors in the frame
of the touch, two of place
  and one of force, are weighted by gains, chosen by a projection matrix and turned into a velocity of the point. It
  takes the map for a turned copy of the skin and knows no stretch.

Two say what is wanted first:

* priority (Nakamura 1987; Siciliano and Slotine 1991): force first, then the place, then the rest posture;
* a quadratic program: force and place as well as bounds on speed, acceleration, joints and forces let it.
  min over joint velocities of w |outward speed - push|² + |sliding - wanted|² + e |speed - rest|², in a box, with weak
  directions damped as least squares have it. A contact whose force would pass its cap within a tick, by a nominal
  stiffness, is pushed less whatever the rest wants: not a box, so it comes as a heavy term, for those contacts only
  that need it.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from tactile_maps.control.force_loop.loop_stability import CONTACT_STIFFNESS
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import MAX_JOINT_SPEED, MAX_POINT_SPEED
from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind
from tactile_maps.control.motion.task_priority import (
    ArmState,
    ContactKey,
    PriorityLevel,
    TaskContact,
    point_rows,
    single_level,
    singular_damping,
    singular_directions,
    solve_within_limits,
    weak_direction,
)
from tactile_maps.core.arrays import FloatArray, length

_LESS = 0.98
"""Share of an error that a later one has to be below to count as less."""


class ForceServo:
    """A PI force loop for each contact. Mutable: the integrals; a contact that is lost takes its own with it.

    The integral waits until the force has come as near to the goal as it comes without: it was reached once, or the
    error grew no less for ``integral_time`` (where the wish to be elsewhere holds against it). Integrating while the
    force first rises would push the arm into what it touches. While the speed is at its bound, an
    error that asks for still more only unwinds the integral, it never winds it up (conditional integration).

    Args:
        max_speed: Bound of the answer [m/s].

    Attributes:
        held: Whether a joint is at its torque limit. Integrals do not grow then either.
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
        """Forget all contacts but these."""
        kept = set(contacts)
        self._integrals = {key: value for key, value in self._integrals.items() if key in kept}
        self._reached &= kept
        self._least = {key: seen for key, seen in self._least.items() if key in kept}

    def integral(self, contact: ContactKey) -> float:
        """[N s] gathered for a contact."""
        return self._integrals.get(contact, 0.0)

    def push(
        self,
        settings: ControlSettings,
        contact: ContactKey,
        error: float,
        dt: float,
        limits: ActiveLimits,
        *,
        beside: float = 0.0,
    ) -> float:
        """Outward speed of the touched point [m/s]: positive presses more.

        Args:
            settings: Of them ``force_gain`` and ``integral_time``; at inf the integral stands.
            contact: Which.
            error: Wanted minus measured force [N].
            dt: Since the last question [s].
            limits: Told when the answer is bounded.
            beside: Outward speed that is wanted besides [m/s], part of the answer. Only the sum is bounded, so that
                the integral outgrows whatever of it holds the force off its goal.
        """
        before = self.integral(contact)
        self._gather(contact, error, dt, settings.integral_time)
        wanted = settings.force_gain * (error + self.integral(contact) / settings.integral_time) + beside
        bounded = min(max(wanted, -self._max_speed), self._max_speed)
        if bounded != wanted:
            limits.add(Limit(LimitKind.POINT_SPEED))
        if self.held or contact[0] in self.stuck or error * (wanted - bounded) > 0:
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
    """An integral that may go back to zero, and neither grows nor changes its sign."""
    if before * after < 0:
        return 0.0
    return after if abs(after) < abs(before) else before


class PointVelocityScheme(ABC):
    """A ``ControlScheme`` that gives each contact's point a velocity, all wanted alike. Mutable.

    It remembers by contact, and forgets with the contact: the force servo's integral and the velocity last wanted.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """At rest, no integral."""
        self._servo = ForceServo(MAX_POINT_SPEED)
        self._wanted: dict[ContactKey, FloatArray] = {}

    @abstractmethod
    def velocity(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: ActiveLimits) -> FloatArray:
        """(3,) wanted of the point of the skin under a contact [m/s], world frame; asked once a tick."""

    def levels(
        self, settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState, limits: ActiveLimits
    ) -> list[PriorityLevel]:
        """Velocities of all contacts' points."""
        self.keep(contacts)
        self._servo.held = arm.reference.torque_limited
        self._servo.stuck = arm.stuck
        self._wanted = {contact.key: self.velocity(settings, contact, arm.dt, limits) for contact in contacts}
        return single_level([point_rows(contact, self._wanted[contact.key]) for contact in contacts])

    def solve(
        self,
        levels: Sequence[PriorityLevel],
        settings: ControlSettings,
        contacts: Sequence[TaskContact],
        arm: ArmState,
        limits: ActiveLimits,
    ) -> FloatArray:
        """Damped least squares."""
        return solve_within_limits(levels, arm.reference, arm.start, limits)

    def keep(self, contacts: Sequence[TaskContact]) -> None:
        """Forget all contacts but these."""
        self._servo.keep(contact.key for contact in contacts)

    def push(
        self, settings: ControlSettings, contact: TaskContact, dt: float, limits: ActiveLimits, *, beside: float = 0.0
    ) -> float:
        """Outward speed [m/s] for the force error, proportional and integral, and what is wanted ``beside`` [m/s]."""
        return self._servo.push(settings, contact.key, contact.force_error, dt, limits, beside=beside)

    def lagged(self, contact: TaskContact, aim: FloatArray, time: float, dt: float) -> FloatArray:
        """The velocity (3,) wanted a tick ago, nearer to ``aim`` with a time constant [s]; at once if a tick is more.

        A contact starts at rest.
        """
        before = self._wanted.get(contact.key)
        before = np.zeros(3) if before is None else before
        return before + min(dt / time, 1.0) * (aim - before) if time > dt else aim


def limit_point_speed(velocity: FloatArray, limits: ActiveLimits) -> FloatArray:
    """The velocity (3,) of a touched point, slower if it is too fast."""
    speed = length(velocity)
    if speed <= MAX_POINT_SPEED:
        return velocity
    limits.add(Limit(LimitKind.POINT_SPEED))
    return velocity * (MAX_POINT_SPEED / speed)


class AdmittanceScheme(PointVelocityScheme):
    """Mobility ``force_gain`` and time constant ``inertia_time``: M v' + v / gain = force error, M = time / gain.

    Without integral: what comes at a speed v is met with an error v / gain.
    """

    def velocity(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: ActiveLimits) -> FloatArray:
        """That of the mass at the contact."""
        place = contact.along(settings.position_gain, MAX_POINT_SPEED)
        aim = limit_point_speed(place + settings.force_gain * contact.force_error * contact.normal, limits)
        return self.lagged(contact, aim, settings.inertia_time, dt)


class HybridScheme(PointVelocityScheme):
    """Selection by the normal that the skin tells; a normal that is wrong lets motion leak into force."""

    def velocity(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: ActiveLimits) -> FloatArray:
        """What brings the contact on, without its part along the normal, where force is served."""
        along = contact.along(settings.position_gain, MAX_POINT_SPEED)
        normal = contact.normal
        return along + (self.push(settings, contact, dt, limits) - along.dot(normal)) * normal


MOST_RETURN = 0.02
"""Of the way back along the normal that the parallel scheme answers [m], as much as tasks ask for along the skin. From
there on the pull back is constant, and the integral takes up all of it even while the contact goes on moving."""


@dataclass(frozen=True, eq=False)
class NormalOffset:
    """How far a contact has moved along its normal since it began, as the normal turns with the skin.

    Attributes:
        point: (3,) where it is, world [m].
        normal: (3,) outward unit normal there.
        away: Along the normals on the way, from where it is to where it began [m].
    """

    point: FloatArray
    normal: FloatArray
    away: float

    def after(self, point: FloatArray, normal: FloatArray) -> NormalOffset:
        """Moved on to ``point`` (3,).

        By the mean of both normals, to which a chord of the skin is at right angles. By one of them each step would add
        half its length squared times the curvature, always of one sign: noise of the place would pull for ever.
        """
        mean = self.normal + normal
        length = float(np.linalg.norm(mean))
        step = float(mean.dot(point - self.point)) / length if length > 0 else 0.0
        return NormalOffset(point, normal, self.away - step)


class ParallelScheme(PointVelocityScheme):
    """No selection: a wrong normal leaks less than in hybrid control, since the integral of force has the last word.

    Along the normal a contact is drawn back to where it began. Both parts of its error of place follow the skin: that
    of the task acts in the tangent plane, and the place where it began goes along with it there, so that a normal that
    turns on the way makes no error of its own.
    """

    def reset(self) -> None:
        """At rest, no integral, no place known."""
        super().reset()
        self._offsets: dict[ContactKey, NormalOffset] = {}

    def keep(self, contacts: Sequence[TaskContact]) -> None:
        """Where the others began is forgotten too."""
        super().keep(contacts)
        begun = {contact.key: NormalOffset(contact.point, contact.normal, 0.0) for contact in contacts}
        self._offsets = {key: self._offsets.get(key, offset) for key, offset in begun.items()}

    def velocity(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: ActiveLimits) -> FloatArray:
        """Both errors' answers added up, taken up slowly."""
        normal = contact.normal
        offset = self._offsets[contact.key] = self._offsets[contact.key].after(contact.point, normal)
        back = settings.position_gain * min(max(offset.away, -MOST_RETURN), MOST_RETURN)
        along = contact.along(settings.position_gain, MAX_POINT_SPEED)
        outward = self.push(settings, contact, dt, limits, beside=back) - along.dot(normal)
        aim = limit_point_speed(along + outward * normal, limits)
        return self.lagged(contact, aim, settings.inertia_time, dt)


class ProjectionScheme(PointVelocityScheme):
    """Which of the three errors count is the task's matter: those of place only where the contact may not slide."""

    def velocity(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: ActiveLimits) -> FloatArray:
        """The chosen errors, turned from the frame of the touch into space."""
        push = self.push(settings, contact, dt, limits) * contact.normal
        if contact.error is None:
            return limit_point_speed(push, limits)
        place = settings.position_gain * contact.error + contact.velocity
        return limit_point_speed(push - place.dot(contact.map_axes), limits)


class PriorityScheme:
    """What the arm cannot do besides keeping the force, it leaves; near a singularity the weak direction is damped."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """No integral."""
        self._servo = ForceServo(MAX_POINT_SPEED)

    def levels(
        self, settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState, limits: ActiveLimits
    ) -> list[PriorityLevel]:
        """Forces of all contacts, then places of those that may not slide; both alike where force alone would slide."""
        self._servo.keep(contact.key for contact in contacts)
        self._servo.held = arm.reference.torque_limited
        self._servo.stuck = arm.stuck
        parts = [self._pushed(settings, contact, arm.dt, limits) for contact in contacts]
        levels = single_level(parts)
        held = [c for c in contacts if c.error is not None and not c.straight]
        if held:
            rows = np.concatenate([c.map_axes.dot(c.move) for c in held])
            speed = np.concatenate([c.map_axes.dot(c.along(settings.position_gain, MAX_POINT_SPEED)) for c in held])
            levels.append(PriorityLevel(rows, speed, held[0].map_axes if len(held) == 1 else None))
        return levels

    def _pushed(
        self, settings: ControlSettings, contact: TaskContact, dt: float, limits: ActiveLimits
    ) -> PriorityLevel:
        """Return the rows of the first level."""
        push = self._servo.push(settings, contact.key, contact.force_error, dt, limits)
        normal = contact.normal
        if not contact.straight:
            return PriorityLevel(contact.outward[None], np.array([push]), normal[None])
        along = contact.along(settings.position_gain, MAX_POINT_SPEED)
        return point_rows(contact, along + (push - along.dot(normal)) * normal)

    def solve(
        self,
        levels: Sequence[PriorityLevel],
        settings: ControlSettings,
        contacts: Sequence[TaskContact],
        arm: ArmState,
        limits: ActiveLimits,
    ) -> FloatArray:
        """Damped least squares, level after level; what they leave free goes to rest."""
        return solve_within_limits(levels, arm.reference, arm.start, limits, rest=arm.home)


MAX_ACCELERATION = 30.0
"""Largest acceleration of a hinge [rad/s²]; slides and slow joints reach their largest speed in the same time."""
LIMIT_RATE = 7.5
"""Largest speed of a joint towards its limit, per distance from it [1/s]."""
CAP_SHARE = 0.8
"""Share of the greatest force, at which the arm stops, that contacts may reach."""
_FORCE_WEIGHT = 100.0
_CAP_WEIGHT = 1e4
_REST_WEIGHT = 1e-3
_ROUNDS = 3


class QuadraticProgramScheme(PriorityScheme):
    """The errors of ``PriorityScheme``, in one program with bounds."""

    def solve(
        self,
        levels: Sequence[PriorityLevel],
        settings: ControlSettings,
        contacts: Sequence[TaskContact],
        arm: ArmState,
        limits: ActiveLimits,
    ) -> FloatArray:
        """MuJoCo's box-constrained solver, again with the caps that the first answer would break."""
        lower, upper = self._box(arm)
        hessian, gradient = _quadratic(levels, arm.home, arm.reference.max_speed, limits)
        cap = CAP_SHARE * settings.max_force
        held = set[int]()
        for _ in range(_ROUNDS):
            speed = _solve_box(hessian, gradient, lower, upper, arm.speed)
            over = [c for c in arm.touched if c.id not in held and _next_force(c, speed, arm.dt) > cap]
            if not over:
                break
            for contact in over:
                held.add(contact.id)
                row = contact.outward
                most = max((cap - contact.force) / (CONTACT_STIFFNESS * arm.dt), -MAX_POINT_SPEED)
                hessian = hessian + _CAP_WEIGHT * np.outer(row, row)
                gradient = gradient - _CAP_WEIGHT * most * row
        _tell(speed, lower, upper, arm, limits)
        if held:
            limits.add(Limit(LimitKind.FORCE_CAP))
        return speed

    def _box(self, arm: ArmState) -> tuple[FloatArray, FloatArray]:
        """Bounds (n,) of the speed: greatest speed, greatest change, and slower towards a limit that is near."""
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
    """Return Hessian (n, n) and gradient (n,), with the damping of directions that are too slow; see ``levels``."""
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


def _solve_box(
    hessian: FloatArray, gradient: FloatArray, lower: FloatArray, upper: FloatArray, warm: FloatArray
) -> FloatArray:
    """(n,) the minimum in the box; without joints it is empty."""
    n = len(warm)
    answer = np.minimum(np.maximum(warm, lower), upper)
    if n:
        factor = np.zeros((n, n + 7))
        rank = mujoco.mju_boxQP(answer, factor, None, np.ascontiguousarray(hessian), gradient, lower, upper)
        answer = answer if rank >= 0 else np.zeros(n)
    return answer


def _next_force(contact: TaskContact, speed: FloatArray, dt: float) -> float:
    return contact.force + CONTACT_STIFFNESS * dt * float(contact.outward @ speed)


def _tell(speed: FloatArray, lower: FloatArray, upper: FloatArray, arm: ArmState, limits: ActiveLimits) -> None:
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
    arm.reference.tell_joint_limits(slow & ~changing, limits)
