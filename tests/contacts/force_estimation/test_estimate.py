"""What estimators get and answer, and the sum of pressure times area."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tactile_maps.contacts.force_estimation.estimate import (
    ESTIMATORS,
    AreaSum,
    EstimateRefusal,
    ForceEstimate,
    Wrench,
    numerical_rank,
    wrench_of_torques,
)
from tactile_maps.core.errors import MapError, RobotError
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.library import load_robot
from tests.contacts.force_estimation.readings_by_hand import SKIN, reading, without_region
from tests.support.touch import bar


def test_they_are_plain_words_and_the_usual_one_comes_first():
    assert ESTIMATORS[0] == "area-sum"
    assert len(set(ESTIMATORS)) == len(ESTIMATORS)
    assert all(re.fullmatch("[a-z]+(-[a-z]+)*", name) for name in ESTIMATORS)


@pytest.mark.parametrize("value", [[1.0, 2.0], [1.0, 2.0, float("nan")]])
def test_a_wrench_is_six_finite_numbers(value):
    with pytest.raises(MapError, match="three finite numbers"):
        Wrench(np.array(value), np.zeros(3))


def test_the_torques_of_an_arm_tell_the_force_at_its_hand():
    """Seven joints tell all six numbers: a push at a known point comes back, with its moment."""
    robot = load_robot("arm")
    configuration = Configuration(robot)
    random = np.random.default_rng(0)
    for link in ("hand",):
        for _ in range(5):
            configuration.update(robot.home + random.normal(0, 0.3, len(robot.joints)))
            point = random.normal(0, 0.05, 3)
            push = random.normal(0, 5, 3)
            world = configuration.pose(link).rotation @ push
            found = wrench_of_torques(configuration, link, configuration.jacobian(link, point).T @ world)
            assert found.rank == 6
            assert found.force == pytest.approx(push, abs=1e-6)
            assert found.torque == pytest.approx(np.cross(point, push), abs=1e-6)
            assert 1 < found.condition < 1e4


def test_one_hinge_tells_one_number():
    robot = bar()
    found = wrench_of_torques(Configuration(robot), "bar", np.array([2.0]))
    assert found.rank == 1
    assert found.torque[1] == pytest.approx(2.0, rel=1e-6), "about its axis, y"


def test_the_base_tells_nothing():
    robot = bar(hinged=False)
    found = wrench_of_torques(Configuration(robot), "bar", np.zeros(0))
    assert (found.rank, found.condition) == (0, float("inf"))
    assert not found.force.any()


@pytest.mark.parametrize("torques", [[1.0, 2.0], [float("nan")]])
def test_torques_that_are_none_are_refused(torques):
    with pytest.raises(MapError, match="torques"):
        wrench_of_torques(Configuration(bar()), "bar", np.array(torques))


def test_a_link_that_is_none_is_refused():
    with pytest.raises(RobotError):
        wrench_of_torques(Configuration(bar()), "tail", np.zeros(1))


def test_it_owns_its_arrays():
    forces = np.ones(2)
    found = ForceEstimate(2.0, None, np.array([3, 4]), forces)
    forces[0] = 9
    assert found.forces[0] == 1
    assert not found.taxels.flags.writeable


def test_misfit_is_residual_over_noise():
    assert ForceEstimate(1.0, None, residual=200.0, noise=100.0).misfit == 2.0
    assert ForceEstimate(1.0, None, residual=200.0).misfit == float("inf")
    assert ForceEstimate(1.0, None).misfit == 0.0


FALLING = np.array([1.0, 0.5, 0.1, 0.01])


def test_without_noise_all_can_be_told():
    rank = numerical_rank(FALLING, np.ones(4), 0.0, unknowns=4)
    assert (rank.effective, rank.condition) == (4, 100.0)
    assert rank.refusal is None


def test_noise_hides_what_is_weak():
    assert numerical_rank(FALLING, np.ones(4), 0.05, unknowns=4).effective == 3
    assert numerical_rank(FALLING, np.ones(4), 0.2, unknowns=4).effective == 2
    assert numerical_rank(FALLING, np.ones(4), 0.2, unknowns=4).refusal is None, "half is enough"
    rank = numerical_rank(FALLING, np.ones(4), 0.7, unknowns=4)
    assert rank.effective == 1
    assert rank.refusal is EstimateRefusal.RANK


def test_readings_of_nothing_tell_nothing():
    assert numerical_rank(FALLING, np.zeros(4), 1.0, unknowns=4).effective == 0
    assert numerical_rank(np.zeros(4), np.ones(4), 0.0, unknowns=4).effective == 0
    assert numerical_rank(np.zeros(0), np.zeros(0), 0.0, unknowns=0).condition == float("inf")


def test_fewer_readings_than_unknowns_are_singular():
    rank = numerical_rank(FALLING, np.ones(4), 0.0, unknowns=9)
    assert rank.condition == float("inf")
    assert rank.refusal is EstimateRefusal.RANK


def test_two_equal_taxels_are_one():
    """Duplicates make two equal rows: one unknown less can be told."""
    matrix = np.eye(4)[[0, 0, 2, 3]]
    values = np.linalg.svd(matrix, compute_uv=False)
    assert numerical_rank(values, np.ones(4), 0.0, unknowns=4).effective == 3


@pytest.mark.parametrize("depth", [0.0, 0.002, 0.005])
def test_it_is_the_regions_force(depth):
    given = reading(depth=depth)
    found = AreaSum(SKIN).estimate(given)
    assert found.force == pytest.approx(given.region.force, rel=1e-12)
    assert found.force == pytest.approx(10.0, rel=0.05)
    assert found.at == given.region.at
    assert found.forces.sum() == pytest.approx(found.force)
    assert (found.condition, found.effective_rank) == (1.0, found.unknowns)
    assert found.refused is None
    assert found.misfit == 0.0


def test_what_lies_in_the_noise_has_no_rank():
    found = AreaSum(SKIN).estimate(without_region(reading(noise=100.0)))
    assert found.force == 0.0
    assert found.effective_rank == 0
    assert np.isfinite(found.misfit)
