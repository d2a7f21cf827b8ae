"""A number of each figure: measured, predicted and explained."""

from __future__ import annotations

import pytest

from tactile_maps.studies.loop_laws.predictions import (
    IDEAL_JOINTS,
    ONSET_GAIN,
    OUR_SERVO,
    PERIOD,
    PLANTS,
    loop_of,
)
from tests.support.loop_trials import LAGGING_JOINTS, QUANTITIES

CASE = {"controller": "hybrid", "what": "force", "delay": 0, "x": 0.0, "seed": 0, "plant": IDEAL_JOINTS}


def row(figure, **output):
    return QUANTITIES[figure]({**CASE, **output})


def test_loops_match_their_case():
    assert loop_of(CASE).ticks == 1, "ideal joints need no more"
    assert loop_of({**CASE, "plant": OUR_SERVO, "delay": 2}).delay == 2
    assert loop_of({**CASE, "plant": OUR_SERVO}).servo == PLANTS[OUR_SERVO] == 40.0
    assert loop_of(CASE, period=1.0).period == 1.0


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("figure", "output", "theory"),
    [
        ("stability", {"delay": 1}, 1.0),
        ("stability", {"delay": 1, "what": "place"}, 1.0),
        ("onset", {"delay": 1}, 1 / (ONSET_GAIN * PERIOD)),
        ("settling", {"delay": 1}, 9 * PERIOD),
        ("ripple", {"x": 0.4, "samples": 400}, 0.5),
        ("behind", {"delay": 1, "what": "as seen"}, 1.0),
        ("stretch", {"delay": 1, "x": 2.0, "controller": "projection"}, 11),
        ("turn", {"delay": 1, "x": 30.0}, 20),
        ("lag", {"delay": 1, "x": 0.1}, 10.0),
    ],
)
def test_ideal_joints_agree_with_theory(figure, output, theory):
    measured, predicted, explained = row(figure, **output)
    assert predicted == pytest.approx(theory, rel=1e-6)
    assert measured == pytest.approx(predicted, rel=0.1)
    assert explained == pytest.approx(predicted, rel=0.02)


@pytest.mark.long
def test_feedforward_leads_by_the_delay():
    measured, predicted, explained = row("behind", delay=2, what="true lag with known speed")
    assert predicted == 0
    assert measured == pytest.approx(explained, rel=1e-6)
    assert explained == pytest.approx(1e3 * 0.001 * PERIOD * 2)


@pytest.mark.long
def test_lagging_joints_tolerate_less_stiffness():
    measured, predicted, explained = row("lag", plant=LAGGING_JOINTS, delay=1, x=0.05)
    assert measured == pytest.approx(explained, rel=0.05)
    assert measured < 0.95 * predicted
