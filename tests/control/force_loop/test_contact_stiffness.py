"""Stiffness of a contact, measured from changes of its force."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.force_loop.contact_stiffness import MeasuredStiffness, StiffnessEstimator

NOMINAL = 2e4
STIFFNESS = 5e3
DT = 0.005
TIME = DT * np.arange(120)
APPROACH = 0.6e-3 * (1 - np.exp(-TIME / 0.15))
"""Displacement of the skin along its normal [m], up to 3 N."""


def measured(force, way, *, commanded=None, delay=0.0):
    """The estimator after forces (k,) at displacements (k,)."""
    estimator = StiffnessEstimator(NOMINAL)
    commanded = way if commanded is None else commanded
    steps = zip(force, np.diff(way, prepend=0.0), np.diff(commanded, prepend=0.0), strict=True)
    for at, moved, requested in steps:
        estimator.look(float(at), float(moved), float(requested), DT, delay)
    return estimator


def noise(size, *, seed=0):
    return np.random.default_rng(seed).normal(0, size, len(TIME))


def test_stiffness_is_nominal_until_it_is_measured():
    assert StiffnessEstimator(NOMINAL).stiffness(3.0) == NOMINAL
    assert measured(np.full(120, 3.0), np.zeros(120)).stiffness(3.0) == NOMINAL, "it rests at the goal"


@pytest.mark.parametrize(("size", "most"), [(0.0, 1.1), (0.01, 1.3)])
def test_approach_measures_the_stiffness(size, most):
    """The contact may be stiffer at the goal than during the approach."""
    assert 0.97 < measured(STIFFNESS * APPROACH + noise(size), APPROACH).stiffness(3.0) / STIFFNESS < most


def test_soft_contact_is_accepted_from_the_second_window_on():
    """Windows of five readings."""
    once, twice = (measured(STIFFNESS * APPROACH[20:last], APPROACH[20:last]) for last in (29, 30))
    assert (once.measured, once.stiffness(1.0)) == (False, NOMINAL)
    assert twice.measured
    assert twice.stiffness(1.0) == pytest.approx(STIFFNESS, rel=0.01)


def test_stiffness_hidden_by_noise_stays_nominal():
    assert measured(STIFFNESS * APPROACH + noise(0.1), APPROACH).stiffness(3.0) == NOMINAL


def test_cover_that_stiffens_has_the_stiffness_at_the_goal():
    """F = c d²: 2 F / d at 3 N."""
    force = 3.0 * (APPROACH / 0.6e-3) ** 2
    assert measured(force, APPROACH).stiffness(3.0) == pytest.approx(2 * 3.0 / 0.6e-3, rel=0.1)


def test_late_readings_belong_to_earlier_positions_of_the_arm():
    read = np.concatenate([np.zeros(4), np.repeat(STIFFNESS * APPROACH[::4], 4)])[:120]
    right = measured(read, APPROACH, delay=4 * DT).stiffness(3.0)
    assert 0.97 < right / STIFFNESS < 1.06
    assert measured(read, APPROACH).stiffness(3.0) > 1.14 * right, "with the current positions it would seem stiffer"


HAND = 2e-3 * np.sin(2 * np.pi * 1.5 * TIME)
MOTIONS = {
    "a hand presses, and the arm yields": (3 + STIFFNESS * 0.4 * HAND, -0.1 * HAND, np.zeros(120)),
    "a hand presses, and a controller retreats": (3 + STIFFNESS * 0.4 * HAND, np.cumsum(-0.01 * HAND), None),
    "the skin is pushed without a command": (STIFFNESS * APPROACH, APPROACH, np.zeros(120)),
    "an object is pushed along": (3.0 + noise(0.05), 0.01 * TIME, None),
    "a hand comes as fast as the arm goes": (STIFFNESS * (APPROACH + 1.5e-3 * TIME), APPROACH, None),
    "the hand leaves": (3 - STIFFNESS * 1e-3 * TIME + STIFFNESS * 0.1 * APPROACH, APPROACH, None),
}


@pytest.mark.parametrize("course", MOTIONS)
def test_motion_of_the_object_does_not_count_as_softness(course):
    force, way, commanded = MOTIONS[course]
    assert measured(force, way, commanded=commanded).stiffness(3.0) >= 0.9 * STIFFNESS
    if "hand comes" not in course:
        assert measured(force, way, commanded=commanded).stiffness(3.0) == NOMINAL


def test_softer_contact_needs_two_windows_and_a_stiffer_one_a_single_one():
    estimator = measured(STIFFNESS * APPROACH[:5], APPROACH[:5])
    assert estimator.stiffness(3.0) == NOMINAL, "one window is not enough"
    soft = measured(STIFFNESS * APPROACH, APPROACH)
    way = 0.6e-3 + 2e-5 * np.arange(6)
    for k, at in enumerate(way):
        moved = 2e-5 if k else 0.6e-3 - APPROACH[-1]
        soft.look(float(STIFFNESS * 0.6e-3 + 3 * STIFFNESS * (at - 0.6e-3)), moved, moved, DT, 0.0)
    assert soft.stiffness(3.0) > 2 * STIFFNESS, "at once"
    force = STIFFNESS * (0.6e-3 + 3 * (way[-1] - 0.6e-3))
    for at, moved in zip(APPROACH, np.diff(APPROACH, prepend=0.0), strict=True):
        soft.look(float(force + STIFFNESS * at), float(moved), float(moved), DT, 0.0)
    assert soft.stiffness(3.0) < 1.3 * STIFFNESS, "until the next window does not confirm it"


def test_later_window_at_more_force_confirms_earlier_ones():
    """Two windows at a quarter of the force allow up to twice their stiffness at the whole of it."""
    estimator = StiffnessEstimator(NOMINAL)
    windows = [(0.75, STIFFNESS), (0.75, STIFFNESS), (3.0, 1.2 * STIFFNESS)]
    estimator._measured.extend(MeasuredStiffness(stiffness, force) for force, stiffness in windows)
    assert estimator.stiffness(3.0) == pytest.approx(1.2 * STIFFNESS)


def test_later_window_below_two_earlier_ones_confirms_neither():
    estimator = StiffnessEstimator(NOMINAL)
    windows = [(0.75, STIFFNESS), (0.75, STIFFNESS), (3.0, 0.9 * STIFFNESS)]
    estimator._measured.extend(MeasuredStiffness(stiffness, force) for force, stiffness in windows)
    assert estimator.stiffness(3.0) == pytest.approx(2 * STIFFNESS)


def test_reset_discards_the_stiffness():
    estimator = measured(STIFFNESS * APPROACH, APPROACH)
    estimator.reset()
    assert estimator.stiffness(3.0) == NOMINAL


def test_contact_may_be_stiffer_with_more_force_but_not_softer_with_less():
    one = MeasuredStiffness(STIFFNESS, 3.0)
    assert one.at(12.0) == pytest.approx(2 * STIFFNESS)
    assert one.at(1.0) == one.at(3.0) == STIFFNESS
