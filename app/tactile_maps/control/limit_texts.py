"""Texts for the reasons why the arm is limited, for window, command line and reports."""

from __future__ import annotations

from collections.abc import Iterable

from tactile_maps.control.motion.limits import Limit, LimitKind, RegraspFailure

_REGRASPS = (
    LimitKind.REGRASP_PLANNED,
    LimitKind.REGRASP_MOVES,
    LimitKind.REGRASP_RETURNS,
    LimitKind.REGRASP_FAILED,
)
_CONTINUE = "remove the contact to continue"


def limit_text(limit: Limit) -> str:
    """Return a limit with its figures, like "joint limit: elbow" or "net energy output to the contact: 0.9 J"."""
    fact = _fact(limit)
    return f"{limit.kind.title}: {fact}" if fact else limit.kind.title


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
        "resume": _CONTINUE,
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
        return limit.kind.fact.format(**fields)
    except KeyError:  # a figure is not known
        template = limit.kind.without_figures or ("{resume}" if limit.kind.stops else "")
        return template.format(**fields)


def _destination(names: list[str]) -> str:
    """Return the link a regrasp leads to."""
    if not names:
        return ""
    return f"to the {names[-1]}" if names[0] != names[-1] else f"to another place of the {names[-1]}"


def _why_no_regrasp(limit: Limit) -> str:
    """Return a text like "out of the arm's reach by 120 mm" or "every posture found collides: forearm with post 1"."""
    cause = "" if limit.cause is None else limit.cause.text
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
