"""Contacts with their goals as rows of Jacobians, solved in order of priority: what is less wanted keeps out of what is
more.

A ``ContactGoal`` is what a task wants of a contact, a ``TaskContact`` that contact as a control scheme meets it. Rows
wanted equally make a ``PriorityLevel``; ``solve_hierarchy`` gives the least joint velocity for the levels in order
(Siciliano and Slotine 1991), damped in weak directions (Nakamura and Hanafusa 1986), and ``solve_within_limits`` lets
joints at a limit leave the work to the others. ``ControlScheme`` is the one question on which controllers with a task
differ: how errors become joint velocities.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from typing import Protocol, TypeAlias

import numpy as np
from scipy.linalg.lapack import dgesdd

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import PostureReference, at_limit, limit_joint_speed
from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind
from tactile_maps.core.arrays import FloatArray, any_true, length, readonly
from tactile_maps.maps.model.jacobian import least_norm_motion


class ContactPresence(Enum):
    """What is known of a contact that a task is about."""

    FELT = "felt"
    """Read from the skin at this tick."""
    LOST = "lost"
    """Not read any more: remembered as it was, without force, and sought there."""


@dataclass(frozen=True, eq=False)
class ContactGoal:
    """What a task wants of one contact.

    Attributes:
        region: Which.
        force: Goal [N].
        error: (2,) the way to go on the map [m]; None where the contact may slide as it likes.
        velocity: (2,) at which the goal itself moves on the map [m/s].
        to_map: (2, 3) the map's Jacobian at the contact, world frame, where it was asked for already.
        presence: Whether it is there.
    """

    region: ContactRegion
    force: float
    error: FloatArray | None = None
    velocity: FloatArray | None = None
    to_map: FloatArray | None = None
    presence: ContactPresence = ContactPresence.FELT


ContactKey: TypeAlias = tuple[int, ContactPresence]


@dataclass(frozen=True, eq=False)
class TaskContact:
    """A contact with what is wanted of it, at one posture, world frame.

    Attributes:
        id: Of the region.
        force: Measured [N].
        force_error: Wanted minus measured [N].
        normal: (3,) outward.
        point: (3,) [m].
        move: (3, n) velocity of the point of the skin per joint velocity.
        to_map: (2, 3) map velocity per velocity along the skin; what stands still in the world moves by minus that.
            Zero where the contact may slide: nobody asks.
        error: (2,) on the map [m]; None where the contact may slide.
        velocity: (2,) of the goal on the map [m/s].
        presence: Whether it is there.
        tilt: By how much its normal may err [rad], see ``force_loop.normal_motion``.
        straight: Whether it is too little to let the point slide on its way along the normal.
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

    @property
    def key(self) -> ContactKey:
        """By which schemes remember it: one that was lost is sought without the integral it had."""
        return self.id, self.presence

    @cached_property
    def outward(self) -> FloatArray:
        """(n,) outward speed of the point per joint velocity: it presses more."""
        return self.normal.dot(self.move)

    @cached_property
    def map_axes(self) -> FloatArray:
        """(2, 3) the map's two axes along the skin as nearly as can be: of length one and square to each other."""
        left, _, right = _svd(self.to_map)
        return left.dot(right)

    def along(self, gain: float, most: float) -> FloatArray:
        """(3,) velocity of the skin [m/s] that brings the contact on: what stands still in the world slides back on it.

        Args:
            gain: Speed per error [1/s].
            most: Greatest speed [m/s].
        """
        if self.error is None:
            return np.zeros(3)
        wanted = -least_norm_motion(self.to_map, gain * self.error + self.velocity)
        speed = length(wanted)
        return wanted * (most / speed) if speed > most else wanted


_WORLD = readonly(np.eye(3))
_POSTURE_RATE = 2.0
"""Most that the speed of a joint may change per change of its position, before damping sets in [1/s].

Slower than the force loop, which has to correct what the motion does to the force: on an arm that is stretched out
all controllers keep the contact with 2 per second, with 5 per second most lose it.
"""
_WEAK_SHARE = 0.3
"""A singular value below this share of the rows' norm may change sign by a small change of posture."""
_LEAST_LOST = 1e-4
"""Loss of speed that is not reported [m/s]."""
_RANK = 1e-6
"""Singular values below this share of the largest carry nothing."""


@dataclass(frozen=True, eq=False)
class PriorityLevel:
    """Rows that are wanted equally.

    Attributes:
        rows: (m, n) in metres per unit of joint velocity.
        speed: (m,) what they should give [m/s].
        axes: (m, 3) direction of each row's speed, world frame; None where it is not known.
    """

    rows: FloatArray
    speed: FloatArray
    axes: FloatArray | None = None


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
        left, gains, right = singular_directions(_beside(felt, rows))
        parts = list(zip(gains.tolist(), (level.speed - rows.dot(share)).dot(left).tolist(), strict=True))
        damping = singular_damping(parts, level, max_speed)
        answer = [
            part * gain / (gain**2 + more) if part else 0.0 for (gain, part), more in zip(parts, damping, strict=True)
        ]
        share = share + np.array(answer).dot(right)
        weak.extend(weak_direction(parts, damping, left, level.axes))
        felt.append(right[: sum(gain > max(_RANK * parts[0][0], 1e-12) for gain, _ in parts)])
    worst = max(weak, key=lambda limit: limit.value or 0.0, default=None)
    return (share + _beside(felt, rest / max_speed)) * max_speed, worst


def _beside(felt: Sequence[FloatArray], rows: FloatArray) -> FloatArray:
    """The part of ``rows`` (n,) or (m, n) that none of the ``felt`` rows (k, n) feels."""
    for used in felt:
        rows = rows - rows.dot(used.T).dot(used)
    return rows


def singular_directions(rows: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Left singular vectors (m, k), values (k,) and right vectors (k, n) of ``rows`` (m, n), m > 0.

    A single row has itself.
    """
    strength = length(rows[0])
    if len(rows) > 1 or not strength:
        return _svd(rows)
    return np.ones((1, 1)), np.array((strength,)), rows / strength


def _svd(rows: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The thin singular value decomposition of a small matrix, by the LAPACK routine that ``np.linalg.svd`` calls too.

    The same to rounding, in 6 µs: NumPy's takes as long again to find out what it was given.

    Raises:
        LinAlgError: It holds something that is no number.
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

    Below, with b² the larger bound on g², the answer is  2 g / (g² + b²)  per requested speed: never more than the
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
        damping: Of each direction, see ``singular_damping``.
        left: (m, k) directions in the rows of a level.
        axes: (m, 3) of the rows, see ``PriorityLevel``.
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
    """The arm a scheme moves.

    Attributes:
        start: (n,) the wanted posture until now.
        home: (n,) joint velocity that would take it back to rest.
        speed: (n,) joint velocity wanted at the tick before.
        reference: Its limits.
        touched: All contacts, wanted or not.
        dt: To the next tick [s].
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
    """How a controller with a task answers. Mutable; ``reset`` forgets the past."""

    def reset(self) -> None:
        """Forget everything."""

    def levels(
        self, settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState, limits: ActiveLimits
    ) -> list[PriorityLevel]:
        """What is wanted of the contacts now, the most wanted first; asked once a tick."""

    def solve(
        self,
        levels: Sequence[PriorityLevel],
        settings: ControlSettings,
        contacts: Sequence[TaskContact],
        arm: ArmState,
        limits: ActiveLimits,
    ) -> FloatArray:
        """(n,) joint velocity for the levels."""


def solve_within_limits(
    levels: Sequence[PriorityLevel],
    reference: PostureReference,
    start: FloatArray,
    limits: ActiveLimits,
    *,
    rest: FloatArray | None = None,
) -> FloatArray:
    """(n,) joint velocity by damped least squares; joints at a limit leave the work to the others.

    Args:
        levels: The most wanted first.
        reference: The arm's limits.
        start: (n,) the wanted posture until now.
        limits: Told what bounds the answer.
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
        reference.tell_joint_limits(stuck, limits)
    else:
        return np.zeros_like(start)
    if weak is not None:
        limits.add(weak)
    return limit_joint_speed(speed, reference.max_speed, limits)


def point_rows(contact: TaskContact, velocity: FloatArray) -> PriorityLevel:
    """Return rows that give a contact's point a ``velocity`` (3,); only its normal part if the contact may slide."""
    if contact.error is None and not contact.straight:
        return PriorityLevel(contact.outward[None], np.array([contact.normal @ velocity]), contact.normal[None])
    return PriorityLevel(contact.move, velocity, _WORLD)


def single_level(parts: Sequence[PriorityLevel]) -> list[PriorityLevel]:
    """Return one level with all rows; directions are known where one contact is moved."""
    if len(parts) == 1:
        return [parts[0]]
    return [PriorityLevel(np.concatenate([p.rows for p in parts]), np.concatenate([p.speed for p in parts]))]
