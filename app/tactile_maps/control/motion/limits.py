"""Reasons why the arm is limited, as values; ``limit_texts`` words them for people."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

from tactile_maps.core.codec import AnyFloat


class LimitKind(Enum):
    """Kind of limit on the controller or its task, or of a safety stop. Parentheses list other attributes of ``Limit``.

    Bounds on motion: ``JOINT_LIMIT`` and ``TORQUE_LIMIT`` (names: the joints), ``JOINT_SPEED``,
    ``JOINT_ACCELERATION``, ``POINT_SPEED`` (of the contact point), ``FORCE_CAP``, ``WEAK_DIRECTION`` (value: lost speed
    [m/s]; bound: singular value, the largest speed in this direction [m/s]; direction), ``FORCE_RISES`` (in a weak
    direction, although it should fall), ``HELD_BACK`` (the arm does not follow the desired posture), ``ENERGY_TANK``
    (value: energy given [J]),
    ``SLOW_HOMING`` (after a lost contact), ``JOINT_RESPONSE`` (names: the joint that differs most from the requested
    natural frequency and damping ratio; value: its frequency [rad/s]; damping_ratio).

    The contact: ``CONTACT_LOST``, ``CONTACT_STICKS`` (it moves along with the skin), ``OUT_OF_REACH`` (the target),
    ``CONTACTS_OPPOSED`` and ``CONTACT_IMMOBILE`` (force that is not controlled, because the joints cannot relieve all
    contacts at once, or because no joint moves the skin there; names: the links; value: largest force [N]; bound: its
    goal [N]).

    The task: ``PATH_WAITS``, ``PLACE_UNCERTAIN`` (value: 95 % quantile of the error of the measured place of the
    contact, and bound [m]), ``PATH_LEAVES_SKIN``, ``PATH_REFUSED`` (detail: why), ``POINT_OFF_SKIN``,
    ``CONTACT_ELSEWHERE`` (names: patch of the target, patch of the contact), and ``REGRASP_PLANNED``,
    ``REGRASP_MOVES``, ``REGRASP_RETURNS`` (cause), ``REGRASP_FAILED`` (cause, between; value: distance out of reach
    [m]), all with names: old link, new link.

    The skin: ``SKIN_UNREADABLE``, ``SKIN_SATURATED``; the loop: ``OSCILLATION`` (value: reduced force gain [m/s/N];
    None while it is not reduced), ``OSCILLATION_AT_SMALLEST_GAIN`` (value: force gain [m/s/N]), ``FORCE_GAIN_HELD``
    (value: reduced gain [m/s/N]), ``POSITION_GAIN_HELD`` (value: reduced gain [1/s]), ``FORCE_GAIN_UNSTABLE`` (bound:
    largest stable gain [m/s/N]), these three with the sensor's period and delay, ``FORCE_GAIN_RAISED`` (value: raised
    gain [m/s/N]; bound: gain in the settings).

    Safety stops: ``STOPPED_BY_FORCE`` (value and bound [N]), ``STOPPED_BY_SPEED`` (names: the hinge; value and
    bound [rad/s]), ``STOPPED_BY_SLIDE_SPEED`` (names: the slide; value and bound [m/s]), ``STOPPED_BY_POINT_SPEED``
    (value and bound [m/s]: of a touched point), ``STOPPED_BY_UNMEASURED_FORCE`` (force that the skin does not measure;
    names: the most likely link; value: smallest force that explains the joint torques, and bound [N]),
    ``STOPPED_UNREADABLE``, ``STOPPED_BY_MISMATCH`` (names: the link; value and bound [N m]: torque that no single
    contact explains).
    """

    JOINT_LIMIT = "joint-limit"
    TORQUE_LIMIT = "torque-limit"
    JOINT_SPEED = "joint-speed"
    JOINT_ACCELERATION = "joint-acceleration"
    POINT_SPEED = "point-speed"
    FORCE_CAP = "force-cap"
    WEAK_DIRECTION = "weak-direction"
    FORCE_RISES = "force-rises"
    HELD_BACK = "held-back"
    ENERGY_TANK = "energy-tank"
    SLOW_HOMING = "slow-homing"
    JOINT_RESPONSE = "joint-response"
    CONTACT_LOST = "contact-lost"
    CONTACT_STICKS = "contact-sticks"
    OUT_OF_REACH = "out-of-reach"
    CONTACTS_OPPOSED = "contacts-opposed"
    CONTACT_IMMOBILE = "contact-immobile"
    PATH_WAITS = "path-waits"
    PLACE_UNCERTAIN = "place-uncertain"
    PATH_LEAVES_SKIN = "path-leaves-skin"
    PATH_REFUSED = "path-refused"
    POINT_OFF_SKIN = "point-off-skin"
    CONTACT_ELSEWHERE = "contact-elsewhere"
    REGRASP_PLANNED = "regrasp-planned"
    REGRASP_MOVES = "regrasp-moves"
    REGRASP_RETURNS = "regrasp-returns"
    REGRASP_FAILED = "regrasp-failed"
    SKIN_UNREADABLE = "skin-unreadable"
    SKIN_SATURATED = "skin-saturated"
    OSCILLATION = "oscillation"
    OSCILLATION_AT_SMALLEST_GAIN = "oscillation-at-smallest-gain"
    FORCE_GAIN_HELD = "force-gain-held"
    FORCE_GAIN_RAISED = "force-gain-raised"
    POSITION_GAIN_HELD = "position-gain-held"
    FORCE_GAIN_UNSTABLE = "force-gain-unstable"
    STOPPED_BY_FORCE = "stopped-by-force"
    STOPPED_BY_SPEED = "stopped-by-speed"
    STOPPED_BY_SLIDE_SPEED = "stopped-by-slide-speed"
    STOPPED_BY_POINT_SPEED = "stopped-by-point-speed"
    STOPPED_BY_UNMEASURED_FORCE = "stopped-by-unmeasured-force"
    STOPPED_UNREADABLE = "stopped-unreadable"
    STOPPED_BY_MISMATCH = "stopped-by-mismatch"

    @property
    def stops(self) -> bool:
        """Whether the safety monitor stops the arm until nothing touches it, or one contact is left."""
        return self.name.startswith("STOPPED")


class RegraspFailure(Enum):
    """Reason why a contact could not be moved to another place of the skin."""

    NO_ARM = "no-arm"
    UNREACHABLE = "unreachable"
    """Proved: within its joint limits the arm never brings the place there."""
    FACES_AWAY = "faces-away"
    """Proved: the place gets there, but never faces the object."""
    NO_POSTURE = "no-posture"
    """No posture was found; there may be one."""
    NO_LIFT = "no-lift"
    """The skin cannot be lifted off the object."""
    BLOCKED = "blocked"
    """Every posture found collides."""
    NO_PATH = "no-path"
    """Postures were found, but no path to them within the samples of the planner."""
    NOTHING_THERE = "nothing-there"
    TIMEOUT = "timeout"
    OBSTACLE = "obstacle"
    OBJECT_FOLLOWS = "object-follows"


@dataclass(frozen=True)
class Limit:
    """Reason why the arm is limited; ``LimitKind`` lists the attributes that each kind sets.

    Attributes:
        kind: Kind of limit.
        names: Names of the joints, links or patches concerned.
        value: Measured or current value, SI.
        bound: Bound of the value, SI.
        period: Time between two samples of the skin [s].
        delay: Time from a sample to its arrival [s].
        cause: Reason why a regrasp turned back or failed.
        detail: Message of the error that rejected a path.
        between: The two links or objects that collide.
        damping_ratio: Damping ratio of a joint; 1 is critical.
        direction: (3,) unit vector, world frame.
    """

    kind: LimitKind
    names: tuple[str, ...] = ()
    value: AnyFloat | None = None
    bound: AnyFloat | None = None
    period: float | None = None
    delay: float | None = None
    cause: RegraspFailure | None = None
    detail: str = ""
    between: tuple[str, ...] = ()
    damping_ratio: float | None = None
    direction: tuple[float, float, float] | None = None


class ActiveLimits:
    """Limits of one tick, one of each kind, in the order in which they were added. Mutable."""

    def __init__(self) -> None:
        self._by_kind: dict[LimitKind, Limit] = {}

    def add(self, limit: Limit) -> None:
        """Add a limit; an earlier one of the same kind stays and receives the new names."""
        known = self._by_kind.get(limit.kind)
        if known is not None:
            limit = replace(known, names=tuple(dict.fromkeys((*known.names, *limit.names))))
        self._by_kind[limit.kind] = limit

    @property
    def found(self) -> tuple[Limit, ...]:
        """All limits."""
        return tuple(self._by_kind.values())

    def __contains__(self, kind: LimitKind) -> bool:
        return kind in self._by_kind
