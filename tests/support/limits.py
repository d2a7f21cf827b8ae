"""Kinds of limits reported in tests."""

from __future__ import annotations

from collections.abc import Iterable

from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind


def kinds(limits: ActiveLimits | Iterable[Limit]) -> list[LimitKind]:
    """Return the kinds of the limits, in order."""
    return [limit.kind for limit in (limits.found if isinstance(limits, ActiveLimits) else limits)]
