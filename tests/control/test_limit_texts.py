"""Limits of one tick, and their texts."""

from __future__ import annotations

import pytest

from tactile_maps.control.limit_texts import limit_text, limit_texts
from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind, RegraspFailure

STOPPED = {
    LimitKind.STOPPED_BY_FORCE,
    LimitKind.STOPPED_BY_SPEED,
    LimitKind.STOPPED_BY_MISMATCH,
    LimitKind.STOPPED_UNREADABLE,
    LimitKind.STOPPED_BY_POINT_SPEED,
    LimitKind.STOPPED_BY_SLIDE_SPEED,
    LimitKind.STOPPED_BY_UNMEASURED_FORCE,
}
FAILED = LimitKind.REGRASP_FAILED


def test_first_limit_of_each_kind_stays_and_receives_new_names():
    limits = ActiveLimits()
    assert limits.found == ()
    limits.add(Limit(LimitKind.JOINT_LIMIT, ("elbow",)))
    limits.add(Limit(LimitKind.JOINT_SPEED))
    limits.add(Limit(LimitKind.JOINT_LIMIT, ("wrist", "elbow")))
    assert limits.found == (Limit(LimitKind.JOINT_LIMIT, ("elbow", "wrist")), Limit(LimitKind.JOINT_SPEED))
    assert LimitKind.JOINT_SPEED in limits
    assert LimitKind.FORCE_CAP not in limits


def test_every_kind_has_its_own_name_which_begins_its_text():
    assert {kind for kind in LimitKind if kind.stops} == STOPPED
    names = [kind.title for kind in LimitKind]
    assert len(set(names)) == len(names)
    assert all(limit_text(Limit(kind)).startswith(kind.title) for kind in LimitKind)
    causes = {limit_text(Limit(FAILED, cause=cause)) for cause in RegraspFailure}
    assert len(causes) == len(RegraspFailure)


@pytest.mark.parametrize(
    ("limit", "facts"),
    [
        (Limit(LimitKind.JOINT_LIMIT, ("l_elbow", "l_wrist")), "l elbow, l wrist"),
        (
            Limit(LimitKind.JOINT_RESPONSE, ("hand_roll",), value=8.0, damping_ratio=1.81),
            "hand roll, 8\u202frad/s, damping ratio 1.8",
        ),
        (
            Limit(LimitKind.WEAK_DIRECTION, value=0.098, bound=0.03, direction=(0.0, -1.0, 0.0)),
            "98\u202fmm/s lost along (0, -1, 0), at most 30\u202fmm/s there",
        ),
        (
            Limit(LimitKind.CONTACTS_OPPOSED, ("upper_arm", "forearm"), value=12.04, bound=3.0),
            "upper arm, forearm, 12.0\u202fN",
        ),
        (Limit(LimitKind.CONTACT_IMMOBILE, ("base",), value=7.0, bound=3.0), "base, 7.0\u202fN"),
        (
            Limit(LimitKind.PLACE_UNCERTAIN, value=0.0041, bound=0.003),
            "one reading locates the contact within 4.1\u202fmm, more than 3.0\u202fmm",
        ),
        (Limit(LimitKind.UNMEASURED_FORCE, ("l_hand",), value=12.4), "l hand, at least 12\u202fN"),
        (Limit(LimitKind.ENERGY_TANK, value=0.9), "0.9\u202fJ"),
        (
            Limit(LimitKind.STOPPED_BY_FORCE, value=41.2, bound=40.0),
            "41\u202fN, more than 40\u202fN; remove the contact to continue",
        ),
        (
            Limit(LimitKind.STOPPED_BY_UNMEASURED_FORCE, ("l_hand",), value=41.2, bound=40.0),
            "l hand, at least 41\u202fN, more than 40\u202fN; remove the contact to continue",
        ),
        (Limit(LimitKind.STOPPED_BY_SPEED, value=3.14, bound=3.0), "3.1\u202frad/s; remove the contact to continue"),
        (
            Limit(LimitKind.STOPPED_BY_SPEED, ("l_elbow",), value=3.14, bound=3.0),
            "l elbow, 3.1\u202frad/s; remove the contact to continue",
        ),
        (
            Limit(LimitKind.STOPPED_BY_SLIDE_SPEED, ("lift",), value=0.62, bound=0.5),
            "lift, 0.62\u202fm/s; remove the contact to continue",
        ),
        (
            Limit(LimitKind.STOPPED_BY_POINT_SPEED, value=1.24, bound=1.0),
            "1.2\u202fm/s; remove the contact to continue",
        ),
        (Limit(LimitKind.STOPPED_UNREADABLE), "remove the contact to continue"),
        (
            Limit(LimitKind.STOPPED_BY_MISMATCH, ("forearm",), value=0.312, bound=0.1),
            "forearm, 0.31\u202fN\u202fm unexplained; leave one contact to continue",
        ),
        (Limit(LimitKind.OSCILLATION, value=0.002), "force gain reduced to 2\u202fmm/s per N"),
        (Limit(LimitKind.OSCILLATION), "reduce the force gain"),
        (Limit(LimitKind.FORCE_GAIN_RAISED, value=0.002), "2\u202fmm/s per N"),
        (
            Limit(LimitKind.FORCE_GAIN_HELD, value=0.002, bound=0.01, period=0.2, delay=0.1),
            "2\u202fmm/s per N, skin read at 5\u202fHz, 100\u202fms delay",
        ),
        (
            Limit(LimitKind.POSITION_GAIN_HELD, value=1.0, bound=4.0, period=0.2, delay=0.0),
            "1/s, skin read at 5\u202fHz",
        ),
        (
            Limit(LimitKind.FORCE_GAIN_UNSTABLE, value=0.03, bound=0.02, period=0.05, delay=0.0),
            "stable up to 20\u202fmm/s per N, skin read at 20\u202fHz",
        ),
        (Limit(LimitKind.CONTACT_ELSEWHERE, ("hand", "forearm")), "point on the hand, contact on the forearm"),
        (Limit(LimitKind.PATH_REFUSED, detail="it circles"), "it circles"),
        (Limit(LimitKind.REGRASP_MOVES, ("forearm", "left_hand")), "to the left hand"),
        (
            Limit(LimitKind.REGRASP_RETURNS, ("hand", "hand"), cause=RegraspFailure.NOTHING_THERE),
            "to another place of the hand, no contact at the new place",
        ),
        (
            Limit(FAILED, ("hand", "upper_arm"), value=0.019, cause=RegraspFailure.UNREACHABLE),
            "to the upper arm, out of the arm's reach by 19\u202fmm",
        ),
        (
            Limit(FAILED, ("hand", "arm"), cause=RegraspFailure.BLOCKED, between=("l_elbow", "post 1")),
            "to the arm, every posture found collides: l elbow with post 1",
        ),
    ],
)
def test_text_contains_the_figures(limit, facts):
    assert limit_text(limit) == f"{limit.kind.title}: {facts}"


def test_several_limits_are_in_one_line():
    assert limit_texts((Limit(LimitKind.JOINT_SPEED), Limit(LimitKind.FORCE_CAP))) == "joint speed; force cap"
    assert limit_texts(()) == ""
