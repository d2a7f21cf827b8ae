"""Why the arm is limited: one of each kind a tick."""

from __future__ import annotations

from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind


def test_of_each_kind_the_first_stays_and_names_are_gathered():
    limits = ActiveLimits()
    assert limits.found == ()
    limits.add(Limit(LimitKind.JOINT_LIMIT, ("elbow",)))
    limits.add(Limit(LimitKind.JOINT_SPEED))
    limits.add(Limit(LimitKind.JOINT_LIMIT, ("wrist", "elbow")))
    assert limits.found == (Limit(LimitKind.JOINT_LIMIT, ("elbow", "wrist")), Limit(LimitKind.JOINT_SPEED))
    assert LimitKind.JOINT_SPEED in limits
    assert LimitKind.FORCE_CAP not in limits


def test_only_safety_stops_stop():
    assert {kind for kind in LimitKind if kind.stops} == {
        LimitKind.STOPPED_BY_FORCE, LimitKind.STOPPED_BY_SPEED, LimitKind.STOPPED_BY_MISMATCH,
        LimitKind.STOPPED_UNREADABLE, LimitKind.STOPPED_BY_POINT_SPEED, LimitKind.STOPPED_BY_SLIDE_SPEED,
        LimitKind.STOPPED_BY_UNMEASURED_FORCE,
    }  # fmt: skip
