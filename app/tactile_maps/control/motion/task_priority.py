"""Contacts and goals as rows of Jacobians, solved in order of priority, so that lower levels do not disturb higher
ones.

A ``ContactGoal`` is the goal of a task for one contact, a ``TaskContact`` that contact as input of a control scheme.
Rows of equal priority form a ``PriorityLevel``. ``solve_hierarchy`` returns the least joint velocity for the levels in
order (Siciliano and Slotine 1991), damped in weak directions (Nakamura and Hanafusa 1986); ``solve_within_limits``
gives the work of joints at a limit to the others. A ``ControlScheme`` computes joint velocities from errors;
controllers with a task differ only in it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
from scipy.linalg.lapack import dgesdd

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import PostureReference, at_limit, limit_joint_speed
from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind
from tactile_maps.core.arrays import FloatArray, any_true, length, readonly, within_length
from tactile_maps.maps.model.jacobian import least_norm_motion


class ContactPresence(Enum):
    """Presence of a task's contact."""

    FELT = "felt"
    """Read from the skin at this tick."""
    LOST = "lost"
    """No longer read: kept at its last place, without force, and searched for there."""


class ShearGoal(NamedTuple):
    """Goal of the force along the skin.

    Attributes:
        force: (2,) force of the touching body along the map's axes [N].
        slack: Difference from it that does not move the contact [N].
        ease: Speed at a lasting excess over that at a sudden one.
    """

    force: FloatArray
    slack: float = 0.0
    ease: float = 1.0


@dataclass(frozen=True, eq=False)
class ContactGoal:
    """Goal of a task for one contact.

    Attributes:
        region: The contact.
        force: Force goal [N].
        error: (2,) vector to the target on the map [m]; None if the contact may slide freely.
        velocity: (2,) velocity of the target on the map [m/s].
        to_map: (2, 3) the map's Jacobian at the contact, world frame, if it has been computed already.
        presence: Whether the contact is read.
        shear: Goal of the force along the skin; None for none.
    """

    region: ContactRegion
    force: float
    error: FloatArray | None = None
    velocity: FloatArray | None = None
    to_map: FloatArray | None = None
    presence: ContactPresence = ContactPresence.FELT
    shear: ShearGoal | None = None


ContactKey: TypeAlias = tuple[int, ContactPresence]
_ZERO = readonly(np.zeros(3))


@dataclass(frozen=True, eq=False)
class TaskContact:
    """A contact with its goals at one posture, world frame.

    Attributes:
        id: Id of the region.
        force: Measured force [N].
        force_error: Desired minus measured force [N].
        normal: (3,) outward.
        point: (3,) [m].
        move: (3, n) velocity of the point of the skin per joint velocity.
        to_map: (2, 3) map velocity per velocity along the skin; an object at rest in the world moves by minus that.
            Zero if the contact may slide, since it is not used then.
        error: (2,) on the map [m]; None if the contact may slide.
        velocity: (2,) velocity of the target on the map [m/s].
        presence: Whether the contact is read.
        tilt: Tolerated error of its normal [rad], see ``force_loop.normal_motion``.
        straight: Whether the tolerated error is too small to let the point slide while it moves along the normal.
        shear: (3,) force of the touching body along the skin [N]; zero where it is not measured.
        shear_goal: Goal of that force; None for none.
        friction: Friction coefficient of the contact.
        lasting: (3,) force that the skin yields to in addition, because the excess has lasted [N].
        made_up: (3,) velocity along the skin that makes up for the yielding of soft joints [m/s], in addition to
            ``along`` and without the lag of a virtual inertia.
        curvature: Curvature of the skin in the direction of ``velocity`` [1/m].
    """

    id: int
    force: float
    force_error: float
    normal: FloatArray
    point: FloatArray
    move: FloatArray
    to_map: FloatArray
    error: FloatArray | None
    velocity: FloatArray
    presence: ContactPresence = ContactPresence.FELT
    tilt: float = math.pi / 2
    straight: bool = False
    shear: FloatArray = field(default_factory=lambda: _ZERO)
    shear_goal: ShearGoal | None = None
    friction: float = 0.0
    lasting: FloatArray = field(default_factory=lambda: _ZERO)
    made_up: FloatArray = field(default_factory=lambda: _ZERO)
    curvature: float = 0.0

    @property
    def slides(self) -> bool:
        """Whether the contact may slide freely: it has no goal along the skin."""
        return self.error is None and self.shear_goal is None

    @property
    def key(self) -> ContactKey:
        """Key by which schemes store data of the contact; a lost contact starts without its previous integral."""
        return self.id, self.presence

    @cached_property
    def outward(self) -> FloatArray:
        """(n,) outward speed of the point per joint velocity; positive presses more."""
        return self.normal.dot(self.move)

    @cached_property
    def map_axes(self) -> FloatArray:
        """(2, 3) orthonormal axes along the skin that are nearest to the map's axes."""
        left, _, right = _svd(self.to_map)
        return left.dot(right)

    def along(self, settings: ControlSettings, most: float) -> FloatArray:
        """Return the velocity of the skin (3,) [m/s] that moves the contact towards its goals along the skin.

        An object at rest in the world slides in the opposite direction on the skin.

        Args:
            settings: Settings with ``position_gain`` [1/s] and ``force_gain`` [m/s/N].
            most: Largest speed [m/s].
        """
        velocity = np.zeros(3)
        if self.error is not None:
            on_map = settings.position_gain * self.error + self.velocity
            velocity = within_length(-least_norm_motion(self.to_map, on_map), most)
        return self.yielding(settings, velocity, most)

    def yielding(self, settings: ControlSettings, velocity: FloatArray, most: float) -> FloatArray:
        """Return the velocity of the skin (3,) with the part that yields to the force above the goal of the shear.

        Of a contact that also has a place, the force is controlled along the direction of its goal, and the place
        across it.

        Args:
            settings: Settings with ``force_gain`` [m/s/N].
            velocity: (3,) velocity towards the place [m/s].
            most: Largest speed [m/s].
        """
        if self.shear_goal is None:
            return velocity
        axis = self.shear_goal.force.dot(self.map_axes)
        excess = self.excess + self.lasting
        size = length(axis)
        if self.error is not None and size > _NO_FORCE:
            axis = axis / size
            excess = excess.dot(axis) * axis
            velocity = velocity - velocity.dot(axis) * axis
        return within_length(velocity + settings.force_gain * excess, most)

    @cached_property
    def excess(self) -> FloatArray:
        """(3,) force along the skin beyond its goal and slack [N]; zero without a goal."""
        if self.shear_goal is None:
            return np.zeros(3)
        excess = self.shear - self.shear_goal.force.dot(self.map_axes)
        return max(1.0 - self.shear_goal.slack / max(length(excess), _NO_FORCE), 0.0) * excess


_NO_FORCE = 1e-6
"""Force along the skin that has no direction [N]."""
_WORLD = readonly(np.eye(3))
_POSTURE_RATE = 2.0
"""Largest change of a joint's speed per change of its position, before damping begins [1/s].

Slower than the force loop, which corrects the effect of the motion on the force: on a stretched arm all controllers
keep the contact with 2 per second; with 5 per second most lose it."""
_WEAK_SHARE = 0.3
"""A singular value below this share of the rows' norm may change its sign with a small change of posture."""
_LEAST_LOST = 1e-4
"""Loss of speed that is not reported [m/s]."""
_RANK = 1e-6
"""Singular values below this share of the largest count as zero."""


@dataclass(frozen=True, eq=False)
class PriorityLevel:
    """Rows of equal priority.

    Attributes:
        rows: (m, n) in metres per unit of joint velocity.
        speed: (m,) requested speed of each row [m/s].
        axes: (m, 3) direction of each row's speed, world frame; None if unknown.
    """

    rows: FloatArray
    speed: FloatArray
    axes: FloatArray | None = None


class SpeedBound(NamedTuple):
    """Smallest speed of a point along a direction.

    Attributes:
        row: (n,) speed of the point per joint velocity.
        least: Smallest speed [m/s].
        limit: Limit to be reported while the bound changes the motion.
    """

    row: FloatArray
    least: float
    limit: Limit


def solve_hierarchy(
    levels: Sequence[PriorityLevel], rest: FloatArray, max_speed: FloatArray
) -> tuple[FloatArray, Limit | None]:
    """Return the least joint velocity (n,) for the levels in order (Siciliano and Slotine 1991), and what is damped.

    Joint velocities count as shares of ``max_speed``, so that hinges and slides, long and short levers compare. The
    singular value of a direction is then the speed [m/s] that the joints can give it. A direction from which more is
    requested, or whose speed would change too fast with posture, is damped (Nakamura and Hanafusa 1986, one by one, see
    ``singular_damping``); all others are exact. The projector for the next level is not damped: a damped one leaks.

    Args:
        levels: The highest priority first.
        rest: (n,) joint velocity requested where the levels leave it free.
        max_speed: (n,) greatest speed of each joint [rad/s, or m/s for a slide].

    Returns:
        Joint velocity (n,), and the limit of the direction that loses most speed (see ``weak_direction``) or None.

    Cost: 15 µs a level.
    """
    share = np.zeros(len(rest))
    weak: list[Limit] = []
    felt: list[FloatArray] = []  # orthonormal rows of every level, one after the other: what is used up
    for level in levels:
        if not level.rows.size:
            continue
        rows = level.rows * max_speed
        left, gains, right = singular_directions(_without(felt, rows))
        parts = list(zip(gains.tolist(), (level.speed - rows.dot(share)).dot(left).tolist(), strict=True))
        damping = singular_damping(parts, level, max_speed)
        motion = [
            part * gain / (gain**2 + more) if part else 0.0 for (gain, part), more in zip(parts, damping, strict=True)
        ]
        share = share + np.array(motion).dot(right)
        weak.extend(weak_direction(parts, damping, left, level.axes))
        felt.append(right[: sum(gain > max(_RANK * parts[0][0], 1e-12) for gain, _ in parts)])
    worst = max(weak, key=lambda limit: limit.value or 0.0, default=None)
    return (share + _without(felt, rest / max_speed)) * max_speed, worst


def _without(felt: Sequence[FloatArray], rows: FloatArray) -> FloatArray:
    """Return ``rows`` (n,) or (m, n) without their components along the ``felt`` rows (k, n)."""
    for used in felt:
        rows = rows - rows.dot(used.T).dot(used)
    return rows


def singular_directions(rows: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return left singular vectors (m, k), values (k,) and right vectors (k, n) of ``rows`` (m, n), m > 0."""
    strength = length(rows[0])
    if len(rows) > 1 or not strength:
        return _svd(rows)
    return np.ones((1, 1)), np.array((strength,)), rows / strength


def _svd(rows: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the thin singular value decomposition of a small matrix by the LAPACK routine that ``np.linalg.svd`` also
    calls.

    The result is the same to rounding in 6 µs; NumPy's checks of its input take as long again.

    Raises:
        LinAlgError: An element is not finite.
    """
    if not rows.size:
        return np.linalg.svd(rows, full_matrices=False)
    left, gains, right, info = dgesdd(rows, full_matrices=0)
    if info:
        raise np.linalg.LinAlgError("SVD did not converge")
    return left, gains, right


def singular_damping(parts: Sequence[tuple[float, float]], level: PriorityLevel, max_speed: FloatArray) -> list[float]:
    """Return what is added to the square of each singular value where least squares divide by it [m²/s²].

    It is zero for a direction with singular value g [m/s] from which a speed r [m/s] is requested if both hold:

    - g ≥ r: the joints can give the speed;
    - g² ≥ r c / ``_POSTURE_RATE``, or g ≥ ``_WEAK_SHARE`` of the rows' norm: the joint speed changes with posture by at
      most ``_POSTURE_RATE``. The bound c on the change of g with posture [m/s²] is the norm of the rows, which are
      levers, with every joint at its greatest speed.

    Below, with b² the larger bound on g², the joint speed is  2 g / (g² + b²)  per requested speed: never more than the
    joints' greatest speed, and zero with the singular value. Without the second bound an arm that is stretched out
    passes back and forth through its singular posture, since the direction of joint motion flips there.

    Args:
        parts: Singular value and requested speed of each direction [m/s].
        level: The level. The second bound holds for the motion of one point, whose axes are known: directions in
            which several contacts move differently are weak because the contacts are near each other, not by posture.
        max_speed: (n,) greatest speed of each joint [rad/s, or m/s for a slide].
    """
    norm = 0.0 if level.axes is None else length((level.rows * max_speed).ravel())
    curvature = norm * float(max_speed.max(initial=0.0)) / _POSTURE_RATE
    weak = (_WEAK_SHARE * norm) ** 2
    bounds = [max(part**2, min(abs(part) * curvature, weak)) for _, part in parts]
    return [0.5 * max(bound - gain**2, 0.0) for bound, (gain, _) in zip(bounds, parts, strict=True)]


def weak_direction(
    parts: Sequence[tuple[float, float]], damping: Sequence[float], left: FloatArray, axes: FloatArray | None
) -> tuple[Limit, ...]:
    """Return a ``WEAK_DIRECTION`` limit for the direction that loses most speed by damping; empty if none loses any.

    Args:
        parts: Singular value and requested speed of each direction [m/s].
        damping: Damping of each direction, see ``singular_damping``.
        left: (m, k) directions in the rows of a level.
        axes: (m, 3) axes of the rows, see ``PriorityLevel``.
    """
    lost = [
        abs(part) * more / (gain**2 + more) if more else 0.0 for (gain, part), more in zip(parts, damping, strict=True)
    ]
    most = max(lost, default=0.0)
    if most <= _LEAST_LOST:
        return ()
    worst = lost.index(most)
    direction = None
    if axes is not None:
        x, y, z = math.copysign(1.0, parts[worst][1]) * left[:, worst].dot(axes)
        direction = float(x), float(y), float(z)
    return (Limit(LimitKind.WEAK_DIRECTION, value=most, bound=parts[worst][0], direction=direction),)


@dataclass(frozen=True, eq=False)
class ArmState:
    """State of the arm that a scheme moves.

    Attributes:
        start: (n,) current desired posture.
        home: (n,) joint velocity that would return it to rest.
        speed: (n,) joint velocity requested at the previous tick.
        reference: Reference with the arm's limits.
        touched: All contacts, with and without goals.
        dt: Time to the next tick [s].
        stuck: Ids of contacts whose point does not make the commanded motion.
    """

    start: FloatArray
    home: FloatArray
    speed: FloatArray
    reference: PostureReference
    touched: tuple[TaskContact, ...]
    dt: float
    stuck: frozenset[int] = frozenset()


class ControlScheme(Protocol):
    """Control scheme of a controller with a task. Mutable; ``reset`` discards the past."""

    def reset(self) -> None:
        """Discard the past."""

    def levels(
        self, settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState, limits: ActiveLimits
    ) -> list[PriorityLevel]:
        """Return the goals of the contacts, the highest priority first; called once a tick."""

    def solve(
        self,
        levels: Sequence[PriorityLevel],
        settings: ControlSettings,
        contacts: Sequence[TaskContact],
        arm: ArmState,
        limits: ActiveLimits,
    ) -> FloatArray:
        """Return the joint velocity (n,) for the levels."""


def solve_within_limits(
    levels: Sequence[PriorityLevel],
    reference: PostureReference,
    start: FloatArray,
    limits: ActiveLimits,
    *,
    rest: FloatArray | None = None,
) -> FloatArray:
    """Return the joint velocity (n,) by damped least squares; the others do the work of joints at a limit.

    Args:
        levels: The highest priority first.
        reference: Reference with the arm's limits.
        start: (n,) current desired posture.
        limits: Collects the limits of the result.
        rest: (n,) joint velocity where the levels leave it free; none by default.
    """
    rest = np.zeros(len(start)) if rest is None else rest
    moving = np.ones(len(start), dtype=bool)
    for _ in range(len(start)):
        speed, weak = solve_hierarchy(levels, rest, reference.max_speed)
        stuck = at_limit(reference, start, speed) & moving
        if not any_true(stuck):
            break
        moving &= ~stuck
        levels = [replace(level, rows=level.rows * moving) for level in levels]
        rest = rest * moving
        reference.report_joint_limits(stuck, limits)
    else:
        return np.zeros_like(start)
    if weak is not None:
        limits.add(weak)
    return limit_joint_speed(speed, reference.max_speed, limits)


def point_rows(contact: TaskContact, velocity: FloatArray) -> PriorityLevel:
    """Return rows that give a contact's point a ``velocity`` (3,); only its normal part if the contact may slide."""
    if contact.slides and not contact.straight:
        return normal_row(contact, velocity)
    return PriorityLevel(contact.move, velocity, _WORLD)


def normal_row(contact: TaskContact, velocity: FloatArray) -> PriorityLevel:
    """Return the row that gives a contact's point the normal part of a ``velocity`` (3,)."""
    return PriorityLevel(contact.outward[None], np.array([contact.normal @ velocity]), contact.normal[None])


def single_level(parts: Sequence[PriorityLevel]) -> list[PriorityLevel]:
    """Return one level with all rows; directions are known where one contact is moved."""
    if len(parts) == 1:
        return [parts[0]]
    return [PriorityLevel(np.concatenate([p.rows for p in parts]), np.concatenate([p.speed for p in parts]))]
