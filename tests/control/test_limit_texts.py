"""The words for limits."""

from __future__ import annotations

import pytest

from tactile_maps.control.limit_texts import limit_name, limit_text, limit_texts
from tactile_maps.control.motion.limits import Limit, LimitKind, RegraspFailure


def test_every_kind_has_a_name_of_its_own_and_a_text_that_begins_with_it():
    names = [limit_name(kind) for kind in LimitKind]
    assert len(set(names)) == len(names)
    assert all(limit_text(Limit(kind)).startswith(limit_name(kind)) for kind in LimitKind)


@pytest.mark.parametrize(
    ("limit", "words"),
    [
        (Limit(LimitKind.JOINT_LIMIT, ("l_elbow", "l_wrist")), "joint limit: l elbow, l wrist"),
        (
            Limit(LimitKind.JOINT_RESPONSE, ("hand_roll",), value=8.0, damping_ratio=1.81),
            "joint response differs: hand roll, 8\u202frad/s, damping ratio 1.8",
        ),
        (
            Limit(LimitKind.CONTACTS_OPPOSED, ("upper_arm", "forearm"), value=12.04, bound=3.0),
            "force not controlled: the joints cannot relieve all contacts at once: upper arm, forearm, 12.0\u202fN",
        ),
        (
            Limit(LimitKind.CONTACT_IMMOBILE, ("base",), value=7.0, bound=3.0),
            "force not controlled: no joint moves the skin there: base, 7.0\u202fN",
        ),
        (
            Limit(LimitKind.PLACE_UNCERTAIN, value=0.0041, bound=0.003),
            "the skin is too coarse to follow the path closely: the contact is located within 4.1\u202fmm, more than"
            " 3.0\u202fmm",
        ),
        (Limit(LimitKind.ENERGY_TANK, value=0.9), "net energy output to the contact: 0.9\u202fJ"),
        (
            Limit(LimitKind.STOPPED_BY_FORCE, value=41.2, bound=40.0),
            "stopped: contact force too high: 41\u202fN, more than 40\u202fN; remove the contact to continue",
        ),
        (
            Limit(LimitKind.STOPPED_BY_SPEED, value=3.14, bound=3.0),
            "stopped: joint speed too high: 3.1\u202frad/s; remove the contact to continue",
        ),
        (
            Limit(LimitKind.STOPPED_BY_SPEED, ("l_elbow",), value=3.14, bound=3.0),
            "stopped: joint speed too high: l elbow, 3.1\u202frad/s; remove the contact to continue",
        ),
        (
            Limit(LimitKind.STOPPED_BY_SLIDE_SPEED, ("lift",), value=0.62, bound=0.5),
            "stopped: sliding joint too fast: lift, 0.62\u202fm/s; remove the contact to continue",
        ),
        (
            Limit(LimitKind.STOPPED_BY_POINT_SPEED, value=1.24, bound=1.0),
            "stopped: contact point speed too high: 1.2\u202fm/s; remove the contact to continue",
        ),
        (
            Limit(LimitKind.STOPPED_BY_MISMATCH, ("forearm",), value=0.312, bound=0.1),
            "stopped: one wrench from several contacts: forearm, 0.31\u202fN\u202fm unexplained; "
            "leave one contact to continue",
        ),
        (
            Limit(LimitKind.FORCE_GAIN_HELD, value=0.002, bound=0.01, period=0.2, delay=0.1),
            "force gain reduced: 2\u202fmm/s per N, skin read at 5\u202fHz, 100\u202fms delay",
        ),
        (
            Limit(LimitKind.POSITION_GAIN_HELD, value=1.0, bound=4.0, period=0.2, delay=0.0),
            "position gain reduced: 1/s, skin read at 5\u202fHz",
        ),
        (
            Limit(LimitKind.FORCE_GAIN_UNSTABLE, value=0.03, bound=0.02, period=0.05, delay=0.0),
            "force gain too high: stable up to 20\u202fmm/s per N, skin read at 20\u202fHz",
        ),
        (Limit(LimitKind.REGRASP_MOVES, ("forearm", "left_hand")), "regrasping: to the left hand"),
        (
            Limit(LimitKind.REGRASP_RETURNS, ("hand", "hand"), cause=RegraspFailure.NOTHING_THERE),
            "returning from a regrasp: to another place of the hand, no contact at the new place",
        ),
        (
            Limit(LimitKind.CONTACT_ELSEWHERE, ("hand", "forearm")),
            "the contact is on another patch than the point to hold: point on the hand, contact on the forearm",
        ),
        (Limit(LimitKind.PATH_REFUSED, detail="it circles"), "the path cannot be projected onto the skin: it circles"),
    ],
)
def test_figures_are_told(limit, words):
    assert limit_text(limit) == words


@pytest.mark.parametrize(
    ("limit", "text"),
    [
        (Limit(LimitKind.REGRASP_FAILED, ("hand", "upper_arm"), value=0.019, cause=RegraspFailure.UNREACHABLE),
         "the regrasp failed: to the upper arm, out of the arm's reach by 19\u202fmm"),
        (Limit(LimitKind.REGRASP_FAILED, ("hand", "arm"), cause=RegraspFailure.BLOCKED, between=("l_elbow", "post 1")),
         "the regrasp failed: to the arm, every posture found collides: l elbow with post 1"),
        (Limit(LimitKind.REGRASP_FAILED, ("hand", "forearm"), cause=RegraspFailure.NO_PATH),
         "the regrasp failed: to the forearm, no collision-free path was found"),
    ],
)  # fmt: skip
def test_a_refused_regrasp_says_what_is_in_the_way(limit, text):
    assert limit_text(limit) == text


def test_every_cause_of_a_failed_regrasp_is_told_differently():
    told = {limit_text(Limit(LimitKind.REGRASP_FAILED, cause=cause)) for cause in RegraspFailure}
    assert len(told) == len(RegraspFailure)


def test_several_stand_in_one_line():
    assert limit_texts((Limit(LimitKind.JOINT_SPEED), Limit(LimitKind.FORCE_CAP))) == "joint speed; force cap"
    assert limit_texts(()) == ""
