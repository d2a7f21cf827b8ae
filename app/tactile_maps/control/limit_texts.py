"""Texts for the reasons why the arm is limited, for window, command line and reports."""

from __future__ import annotations

from collections.abc import Iterable

from tactile_maps.control.motion.limits import Limit, LimitKind, RegraspFailure

_NAMES = {
    LimitKind.JOINT_LIMIT: "joint limit",
    LimitKind.TORQUE_LIMIT: "torque limit",
    LimitKind.JOINT_SPEED: "joint speed",
    LimitKind.JOINT_ACCELERATION: "joint acceleration",
    LimitKind.POINT_SPEED: "contact point speed",
    LimitKind.FORCE_CAP: "force cap",
    LimitKind.WEAK_DIRECTION: "singular configuration: little motion along the contact",
    LimitKind.FORCE_RISES: "no force control here: the joints hardly move the skin off",
    LimitKind.HELD_BACK: "the arm is blocked",
    LimitKind.ENERGY_TANK: "net energy output to the contact",
    LimitKind.SLOW_HOMING: "slow return to the rest posture",
    LimitKind.JOINT_RESPONSE: "joint response differs",
    LimitKind.CONTACT_LOST: "contact lost",
    LimitKind.CONTACT_STICKS: "the contact sticks to the skin",
    LimitKind.OUT_OF_REACH: "the target is out of reach",
    LimitKind.CONTACTS_OPPOSED: "force not controlled: the joints cannot relieve all contacts at once",
    LimitKind.CONTACT_IMMOBILE: "force not controlled: no joint moves the skin there",
    LimitKind.PATH_WAITS: "the path waits for the contact",
    LimitKind.PLACE_UNCERTAIN: "the skin is too coarse to follow the path closely",
    LimitKind.PATH_LEAVES_SKIN: "the path leaves the skin",
    LimitKind.PATH_REFUSED: "the path cannot be projected onto the skin",
    LimitKind.POINT_OFF_SKIN: "the point to hold is not on the skin",
    LimitKind.CONTACT_ELSEWHERE: "the contact is on another patch than the point to hold",
    LimitKind.REGRASP_PLANNED: "planning a regrasp",
    LimitKind.REGRASP_MOVES: "regrasping",
    LimitKind.REGRASP_RETURNS: "returning from a regrasp",
    LimitKind.REGRASP_FAILED: "the regrasp failed",
    LimitKind.SKIN_UNREADABLE: "no valid skin readings",
    LimitKind.SKIN_SATURATED: "the skin is saturated",
    LimitKind.OSCILLATION: "the force oscillates",
    LimitKind.OSCILLATION_AT_SMALLEST_GAIN: "the force oscillates at the smallest gain",
    LimitKind.FORCE_GAIN_HELD: "force gain reduced",
    LimitKind.FORCE_GAIN_RAISED: "force gain raised for soft joints",
    LimitKind.POSITION_GAIN_HELD: "position gain reduced",
    LimitKind.FORCE_GAIN_UNSTABLE: "force gain too high",
    LimitKind.STOPPED_BY_FORCE: "stopped: contact force too high",
    LimitKind.STOPPED_BY_SPEED: "stopped: joint speed too high",
    LimitKind.STOPPED_BY_SLIDE_SPEED: "stopped: sliding joint too fast",
    LimitKind.STOPPED_BY_POINT_SPEED: "stopped: contact point speed too high",
    LimitKind.STOPPED_BY_UNMEASURED_FORCE: "stopped: force that the skin does not measure",
    LimitKind.STOPPED_UNREADABLE: "stopped: no valid skin readings",
    LimitKind.STOPPED_BY_MISMATCH: "stopped: one wrench from several contacts",
}
_CAUSES = {
    RegraspFailure.NO_ARM: "the robot has no actuated joints",
    RegraspFailure.UNREACHABLE: "out of the arm's reach",
    RegraspFailure.FACES_AWAY: "the skin there cannot be turned towards the object",
    RegraspFailure.NO_POSTURE: "no posture of the arm was found",
    RegraspFailure.NO_LIFT: "the skin cannot be lifted off the object",
    RegraspFailure.BLOCKED: "every posture found collides",
    RegraspFailure.NO_PATH: "no collision-free path was found",
    RegraspFailure.NOTHING_THERE: "no contact at the new place",
    RegraspFailure.TIMEOUT: "timed out",
    RegraspFailure.OBSTACLE: "an obstacle was hit",
    RegraspFailure.OBJECT_FOLLOWS: "the object moved with the skin",
}
_REGRASPS = (
    LimitKind.REGRASP_PLANNED,
    LimitKind.REGRASP_MOVES,
    LimitKind.REGRASP_RETURNS,
    LimitKind.REGRASP_FAILED,
)
_CONTINUE = "remove the contact to continue"
_FACTS = {
    LimitKind.JOINT_LIMIT: "{names}",
    LimitKind.TORQUE_LIMIT: "{names}",
    LimitKind.ENERGY_TANK: "{value:.1f}\u202fJ",
    LimitKind.CONTACTS_OPPOSED: "{names}, {value:.1f}\u202fN",
    LimitKind.CONTACT_IMMOBILE: "{names}, {value:.1f}\u202fN",
    LimitKind.SLOW_HOMING: "the lost contact may be in the way",
    LimitKind.JOINT_RESPONSE: "{names}, {value:.2g}\u202frad/s, damping ratio {ratio:.2g}",
    LimitKind.PLACE_UNCERTAIN: "the contact is located within {milli:.1f}\u202fmm, more than {most:.1f}\u202fmm",
    LimitKind.PATH_REFUSED: "{limit.detail}",
    LimitKind.CONTACT_ELSEWHERE: "point on the {first}, contact on the {last}",
    LimitKind.SKIN_SATURATED: "no more force is applied",
    LimitKind.OSCILLATION: "force gain reduced to {milli:.2g}\u202fmm/s per N",
    LimitKind.OSCILLATION_AT_SMALLEST_GAIN: "{milli:.2g}\u202fmm/s per N",
    LimitKind.FORCE_GAIN_RAISED: "{milli:.2g}\u202fmm/s per N",
    LimitKind.FORCE_GAIN_HELD: "{milli:.2g}\u202fmm/s per N, skin {timing}",
    LimitKind.POSITION_GAIN_HELD: "{value:.2g}/s, skin {timing}",
    LimitKind.FORCE_GAIN_UNSTABLE: "stable up to {most:.2g}\u202fmm/s per N, skin {timing}",
    LimitKind.STOPPED_BY_FORCE: "{value:.0f}\u202fN, more than {bound:.0f}\u202fN; " + _CONTINUE,
    LimitKind.STOPPED_BY_UNMEASURED_FORCE: "{of}at least {value:.0f}\u202fN, more than {bound:.0f}\u202fN; "
    + _CONTINUE,
    LimitKind.STOPPED_BY_SPEED: "{of}{value:.1f}\u202frad/s; " + _CONTINUE,
    LimitKind.STOPPED_BY_SLIDE_SPEED: "{of}{value:.2g}\u202fm/s; " + _CONTINUE,
    LimitKind.STOPPED_BY_POINT_SPEED: "{value:.2g}\u202fm/s; " + _CONTINUE,
    LimitKind.STOPPED_UNREADABLE: _CONTINUE,
    LimitKind.STOPPED_BY_MISMATCH: "{of}{value:.2g}\u202fN\u202fm unexplained; leave one contact to continue",
}
"""Facts of each kind of limit; for the fields see ``_fact``."""
_WITHOUT_FIGURES = {
    LimitKind.CONTACTS_OPPOSED: "{names}",
    LimitKind.CONTACT_IMMOBILE: "{names}",
    LimitKind.OSCILLATION: "reduce the force gain",
    LimitKind.FORCE_GAIN_UNSTABLE: "skin {timing}",
    LimitKind.STOPPED_BY_MISMATCH: "{of}leave one contact to continue",
}
"""Facts of limits whose figures are not known; by default none, and what to do after a stop."""


def limit_name(kind: LimitKind) -> str:
    """Return the name of a limit without figures; it stays the same as long as the limit lasts."""
    return _NAMES[kind]


def limit_text(limit: Limit) -> str:
    """Return a limit with its figures, like "joint limit: elbow" or "net energy output to the contact: 0.9 J"."""
    fact = _fact(limit)
    return f"{_NAMES[limit.kind]}: {fact}" if fact else _NAMES[limit.kind]


def limit_texts(limits: Iterable[Limit]) -> str:
    """Return all limits in one line, separated by semicolons; empty if there are none."""
    return "; ".join(limit_text(limit) for limit in limits)


def _fact(limit: Limit) -> str:
    names = [name.replace("_", " ") for name in limit.names]
    if limit.kind in _REGRASPS:
        return ", ".join(part for part in (_destination(names), _why_no_regrasp(limit)) if part)
    if limit.kind is LimitKind.WEAK_DIRECTION:
        return _weak_direction(limit)
    fields = {
        "limit": limit,
        "names": ", ".join(names),
        "of": f"{names[0]}, " if names else "",
        "timing": _timing(limit),
        **dict(zip(("first", "last"), names, strict=False)),
    }
    if limit.value is not None:
        fields |= {"value": limit.value, "milli": 1e3 * limit.value}
    if limit.bound is not None:
        fields |= {"bound": limit.bound, "most": 1e3 * limit.bound}
    if limit.damping_ratio is not None:
        fields["ratio"] = limit.damping_ratio
    try:
        return _FACTS.get(limit.kind, "").format(**fields)
    except KeyError:  # a figure is not known
        return _WITHOUT_FIGURES.get(limit.kind, _CONTINUE if limit.kind.stops else "").format(**fields)


def _destination(names: list[str]) -> str:
    """Return the link a regrasp leads to."""
    if not names:
        return ""
    return f"to the {names[-1]}" if names[0] != names[-1] else f"to another place of the {names[-1]}"


def _why_no_regrasp(limit: Limit) -> str:
    """Return a text like "out of the arm's reach by 120 mm" or "every posture found collides: forearm with post 1"."""
    cause = "" if limit.cause is None else _CAUSES[limit.cause]
    if limit.cause is RegraspFailure.UNREACHABLE and limit.value is not None:
        cause += f" by {1e3 * limit.value:.0f}\u202fmm"
    if not limit.between:
        return cause
    one, other = (name.replace("_", " ") for name in limit.between)
    return f"{cause}: {one} with {other}"


def _weak_direction(limit: Limit) -> str:
    """Return a text like "30 mm/s lost along (0, 0, 1), at most 20 mm/s there"."""
    if limit.value is None:
        return ""
    text = f"{1e3 * limit.value:.2g}\u202fmm/s lost"
    if limit.direction is not None:
        text += f" along ({', '.join(f'{round(x, 2) + 0.0:g}' for x in limit.direction)})"
    return text if limit.bound is None else f"{text}, at most {1e3 * limit.bound:.2g}\u202fmm/s there"


def _timing(limit: Limit) -> str:
    rate = f"read at {1 / limit.period:.3g}\u202fHz" if limit.period else "read continuously"
    return f"{rate}, {1e3 * limit.delay:.0f}\u202fms delay" if limit.delay else rate
