"""Reasons why the arm is limited, with their texts; ``limit_texts`` fills in the figures."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

from tactile_maps.core.codec import AnyFloat


class Severity(Enum):
    """Consequence of a limit."""

    ADAPTED = "adapted"
    """Gains or speeds were adapted; the goal is still reached."""
    UNMET = "unmet"
    """The goal is not reached."""
    STOPPED = "stopped"
    """The arm was stopped."""


class LimitKind(Enum):
    """Kind of limit on the controller or its task, or of a safety stop. Parentheses list other attributes of ``Limit``.

    Bounds on motion: ``JOINT_LIMIT`` and ``TORQUE_LIMIT`` (names: the joints), ``JOINT_SPEED``,
    ``JOINT_ACCELERATION``, ``POINT_SPEED`` (of the contact point), ``APPROACH_SPEED`` (names: the link; value: force of
    its impact at the requested speed, and bound [N]), ``FORCE_CAP``, ``WEAK_DIRECTION`` (value: lost speed
    [m/s]; bound: singular value, the largest speed in this direction [m/s]; direction), ``NOT_SOLVED`` (the quadratic
    program, so that the joints slow down; detail: why), ``FORCE_RISES`` (in a weak
    direction, although it should fall), ``HELD_BACK`` (names: joints
    that do not follow the desired posture), ``ENERGY_TANK``
    (value: energy given [J]),
    ``SLOW_HOMING`` (after a lost contact), ``UNMEASURED_FORCE`` (a part without skin presses on something; names: the
    most likely link; value: smallest force that explains the joint torques [N]), ``JOINT_RESPONSE`` (names: the joint
    that differs most from the requested natural frequency and damping ratio; value: its frequency [rad/s];
    damping_ratio).

    The contact: ``CONTACT_LOST``, ``CONTACT_STICKS`` (its place on the skin does not change as the arm moves the skin),
    ``NO_APPROACH`` (value: motion
    towards the target that the arm attempted [m]; bound: requested motion [m]), ``OUT_OF_REACH`` (the target; value:
    distance of its place on the skin from the object, at the nearest posture that a search found [m]),
    ``CONTACTS_OPPOSED`` and ``CONTACT_IMMOBILE`` (force that is not controlled: the requested joint velocity for
    several contacts does not relieve this one, or the joints at full speed move the skin there less than half as fast
    as its force requires; names: the links; value: largest force [N]; bound: its goal [N]),
    ``FORCE_GOAL_RAISED`` (names: the links that hold; value: the goal [N]) and
    ``GRIP_LIMITED`` (names: as before;
    value: force that would prevent slip, bound: largest goal [N]), ``SHEAR_CAP`` (value: force along the skin, bound:
    largest one [N]), ``FRICTION_CAP`` (the quadratic program yields along the skin), ``SHEAR_GOAL_LIMITED`` (names: the
    link; value: the goal, bound: what friction or the cap allows [N]) and ``SHEAR_UNMEASURED`` (names: the link).

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

    Attributes:
        title: Name for window, command line and reports.
        fact: Template of the figures of a limit; ``limit_texts`` lists the fields.
        without_figures: Template where a figure is not known; by default only what to do after a stop.
    """

    title: str
    fact: str
    without_figures: str

    def __new__(cls, value: str, title: str = "", fact: str = "", without_figures: str = "") -> LimitKind:
        kind = object.__new__(cls)
        kind._value_ = value
        kind.title = title
        kind.fact = fact
        kind.without_figures = without_figures
        return kind

    JOINT_LIMIT = "joint-limit", "joint limit", "{names}"
    TORQUE_LIMIT = "torque-limit", "torque limit", "{names}"
    JOINT_SPEED = "joint-speed", "joint speed"
    JOINT_ACCELERATION = "joint-acceleration", "joint acceleration"
    POINT_SPEED = "point-speed", "contact point speed"
    APPROACH_SPEED = (
        "approach-speed",
        "slower, to limit the force of an impact",
        "{names}, {value:.0f}\u202fN at the requested speed, at most {bound:.0f}\u202fN",
    )
    FORCE_CAP = "force-cap", "force cap"
    WEAK_DIRECTION = "weak-direction", "little motion in one direction"
    NOT_SOLVED = "not-solved", "slowing down: the quadratic program has no solution", "{limit.detail}"
    FORCE_RISES = "force-rises", "no force control here: the joints hardly move the skin off"
    HELD_BACK = "held-back", "the arm does not follow the desired posture", "{names}"
    ENERGY_TANK = "energy-tank", "net energy output to the contact", "{value:.1f}\u202fJ"
    SLOW_HOMING = "slow-homing", "slow return to the rest posture", "the lost contact may be in the way"
    UNMEASURED_FORCE = (
        "unmeasured-force",
        "force that the skin does not measure",
        "{of}at least {value:.0f}\u202fN",
    )
    JOINT_RESPONSE = (
        "joint-response",
        "joint response differs",
        "{names}, {value:.2g}\u202frad/s, damping ratio {ratio:.2g}",
    )
    CONTACT_LOST = "contact-lost", "contact lost"
    CONTACT_STICKS = "contact-sticks", "the contact does not move over the skin as requested"
    NO_APPROACH = (
        "no-approach",
        "the arm hardly moves the contact towards the target",
        "{milli:.1f} of {most:.1f}\u202fmm",
    )
    OUT_OF_REACH = (
        "out-of-reach",
        "the target is out of reach",
        "{milli:.0f}\u202fmm from the object at the nearest posture",
    )
    CONTACTS_OPPOSED = (
        "contacts-opposed",
        "force not controlled: the joint motion does not relieve all contacts",
        "{names}, {value:.1f}\u202fN",
        "{names}",
    )
    CONTACT_IMMOBILE = (
        "contact-immobile",
        "force not controlled: the joints move the skin there too slowly",
        "{names}, {value:.1f}\u202fN",
        "{names}",
    )
    PATH_WAITS = "path-waits", "the path waits for the contact"
    PLACE_UNCERTAIN = (
        "place-uncertain",
        "coarse skin: inaccurate path",
        "one reading locates the contact within {milli:.1f}\u202fmm, more than {most:.1f}\u202fmm",
    )
    PATH_LEAVES_SKIN = "path-leaves-skin", "the path leaves the skin"
    PATH_REFUSED = "path-refused", "the path cannot be projected onto the skin", "{limit.detail}"
    POINT_OFF_SKIN = "point-off-skin", "the point to hold is not on the skin"
    CONTACT_ELSEWHERE = (
        "contact-elsewhere",
        "the contact is on another patch than the point to hold",
        "point on the {first}, contact on the {last}",
    )
    REGRASP_PLANNED = "regrasp-planned", "planning a regrasp"
    REGRASP_MOVES = "regrasp-moves", "regrasping"
    REGRASP_RETURNS = "regrasp-returns", "returning from a regrasp"
    REGRASP_FAILED = "regrasp-failed", "the regrasp failed"
    FORCE_GOAL_RAISED = "force-goal-raised", "force goal raised to prevent slip", "{value:.1f}\u202fN"
    GRIP_LIMITED = (
        "grip-limited",
        "the contact may slip",
        "to hold it needs {value:.1f}\u202fN, more than the largest goal of {bound:.1f}\u202fN",
    )
    SHEAR_CAP = "shear-cap", "shear limit", "{value:.1f}\u202fN along the skin, at most {bound:.1f}\u202fN"
    FRICTION_CAP = "friction-cap", "friction limit", "the skin moves with the object"
    SHEAR_GOAL_LIMITED = (
        "shear-goal-limited",
        "shear goal reduced",
        "{names}, {value:.1f}\u202fN, possible are {bound:.1f}\u202fN",
    )
    SHEAR_UNMEASURED = "shear-unmeasured", "the skin does not measure shear", "{names}"
    SKIN_UNREADABLE = "skin-unreadable", "no valid skin readings"
    SKIN_SATURATED = "skin-saturated", "the skin is saturated", "no more force is applied"
    OSCILLATION = (
        "oscillation",
        "the force oscillates",
        "force gain reduced to {milli:.2g}\u202fmm/s per N",
        "reduce the force gain",
    )
    OSCILLATION_AT_SMALLEST_GAIN = (
        "oscillation-at-smallest-gain",
        "the force oscillates at the smallest gain",
        "{milli:.2g}\u202fmm/s per N",
    )
    FORCE_GAIN_HELD = "force-gain-held", "force gain reduced", "{milli:.2g}\u202fmm/s per N, skin {timing}"
    FORCE_GAIN_RAISED = "force-gain-raised", "force gain raised for soft joints", "{milli:.2g}\u202fmm/s per N"
    POSITION_GAIN_HELD = "position-gain-held", "position gain reduced", "{value:.2g}/s, skin {timing}"
    FORCE_GAIN_UNSTABLE = (
        "force-gain-unstable",
        "force gain too high",
        "stable up to {most:.2g}\u202fmm/s per N, skin {timing}",
        "skin {timing}",
    )
    STOPPED_BY_FORCE = (
        "stopped-by-force",
        "stopped: contact force too high",
        "{value:.0f}\u202fN, more than {bound:.0f}\u202fN; {resume}",
    )
    STOPPED_BY_SPEED = "stopped-by-speed", "stopped: joint speed too high", "{of}{value:.1f}\u202frad/s; {resume}"
    STOPPED_BY_SLIDE_SPEED = (
        "stopped-by-slide-speed",
        "stopped: sliding joint too fast",
        "{of}{value:.2g}\u202fm/s; {resume}",
    )
    STOPPED_BY_POINT_SPEED = (
        "stopped-by-point-speed",
        "stopped: contact point speed too high",
        "{value:.2g}\u202fm/s; {resume}",
    )
    STOPPED_BY_UNMEASURED_FORCE = (
        "stopped-by-unmeasured-force",
        "stopped: force that the skin does not measure",
        "{of}at least {value:.0f}\u202fN, more than {bound:.0f}\u202fN; {resume}",
    )
    STOPPED_UNREADABLE = "stopped-unreadable", "stopped: no valid skin readings", "{resume}"
    STOPPED_BY_MISMATCH = (
        "stopped-by-mismatch",
        "stopped: one wrench from several contacts",
        "{of}{value:.2g}\u202fN\u202fm unexplained; leave one contact to continue",
        "{of}leave one contact to continue",
    )

    @property
    def stops(self) -> bool:
        """Whether the safety monitor stops the arm until nothing touches it, or one contact is left."""
        return self.name.startswith("STOPPED")

    @property
    def severity(self) -> Severity:
        """Consequence of the limit."""
        if self.stops:
            return Severity.STOPPED
        return Severity.ADAPTED if self in _ADAPTED else Severity.UNMET


_ADAPTED = frozenset(
    {
        LimitKind.JOINT_SPEED,
        LimitKind.JOINT_ACCELERATION,
        LimitKind.POINT_SPEED,
        LimitKind.APPROACH_SPEED,
        LimitKind.SLOW_HOMING,
        LimitKind.JOINT_RESPONSE,
        LimitKind.PATH_WAITS,
        LimitKind.PLACE_UNCERTAIN,
        LimitKind.REGRASP_PLANNED,
        LimitKind.REGRASP_MOVES,
        LimitKind.REGRASP_RETURNS,
        LimitKind.FORCE_GAIN_HELD,
        LimitKind.FORCE_GAIN_RAISED,
        LimitKind.POSITION_GAIN_HELD,
    }
)


class RegraspFailure(Enum):
    """Reason why a contact could not be moved to another place of the skin, with its text."""

    text: str

    def __new__(cls, value: str, text: str = "") -> RegraspFailure:
        failure = object.__new__(cls)
        failure._value_ = value
        failure.text = text
        return failure

    NO_ARM = "no-arm", "the robot has no actuated joints"
    UNREACHABLE = "unreachable", "out of the arm's reach"
    """Proved: within its joint limits the arm never brings the place there."""
    FACES_AWAY = "faces-away", "the skin there cannot be turned towards the object"
    """Proved: the place gets there, but never faces the object."""
    NO_POSTURE = "no-posture", "no posture of the arm was found"
    """No posture was found; there may be one."""
    NO_LIFT = "no-lift", "the skin cannot be lifted off the object"
    """The skin cannot be lifted off the object."""
    BLOCKED = "blocked", "every posture found collides"
    """Every posture found collides."""
    NO_PATH = "no-path", "no collision-free path was found"
    """Postures were found, but no path to them within the samples of the planner."""
    NOTHING_THERE = "nothing-there", "no contact at the new place"
    TIMEOUT = "timeout", "timed out"
    OBSTACLE = "obstacle", "an obstacle was hit"
    OBJECT_FOLLOWS = "object-follows", "the object moved with the skin"


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
        detail: Message of the error that rejected a path, or of the solver.
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
