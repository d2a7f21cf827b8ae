"""One course on our own arm: what it says is what happened."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.control.map_path import path_about
from app.experiments.control_course import Course, run_course
from app.experiments.control_setup import ControlSetup, beside_ball
from app.maps.build import build_map
from app.skin.misplace import misplaced
from app.touch.sensor.effects import SensorEffects
from app.touch.sensor.gain_spread import GainSpread
from tests.numerics.pressed_arm import forearm

FOLLOW = ControlSettings(law="hybrid", task="follow_path", path_speed=0.04, path_size=0.02)


@cache
def beside():
    return ControlSetup(beside_ball(forearm()))


@cache
def course(speed=0.04) -> Course:
    return run_course(beside(), replace(FOLLOW, path_speed=speed), 6.0, settling=0.5)


def test_a_round_takes_its_length_over_the_speed():
    length = path_about("lemniscate", np.zeros(2), 0.02).length
    assert course().finished == pytest.approx(length / 0.04, rel=0.03)
    assert len(course().force) == round(course().finished / course().tick)
    assert course().lost == 0.0
    assert course().stopped == ""


def test_its_errors_are_of_the_body_and_the_true_force():
    assert 0.0005 < course().error_rms < course().error_p95 < 0.012
    assert course().force_p95(3.0) < 1.0
    assert course().in_band(3.0, 1.0) > 0.95
    assert course().in_band(6.0, 1.0) == 0.0
    assert 0.0 < course().control_ms < 50.0
    assert -0.5 < course().energy_minimum <= 0.0
    assert 0.01 < course().speed.max() < 2.0


def test_slower_is_nearer():
    assert course(0.015).error_rms < 0.8 * course(0.06).error_rms


def test_the_same_course_gives_the_same_numbers():
    again = run_course(beside(), FOLLOW, 6.0, settling=0.5)
    assert np.array_equal(again.body_error, course().body_error)
    assert np.array_equal(again.force, course().force)


def test_two_rounds_take_twice_as_long():
    twice = run_course(beside(), FOLLOW, 6.0, settling=0.5, rounds=2.0)
    assert twice.finished == pytest.approx(2 * course().finished, rel=0.05)


def test_an_open_path_ends_at_its_other_end():
    line = run_course(beside(), replace(FOLLOW, path_kind="polyline"), 6.0, settling=0.5)
    assert line.finished == pytest.approx(0.02 / 0.04, rel=0.05)


def test_what_takes_too_long_is_not_finished():
    short = run_course(beside(), FOLLOW, 0.3, settling=0.2)
    assert np.isnan(short.finished)
    assert len(short.force) == 60


def test_a_task_without_a_path_takes_all_its_time():
    held = run_course(beside(), replace(FOLLOW, task="hold_point"), 0.5, settling=0.5)
    assert np.isnan(held.finished)
    assert held.error_p95 < 0.01
    assert np.isfinite(held.map_error).all()


def test_what_the_supervisor_stops_ends():
    stopped = run_course(beside(), replace(FOLLOW, max_force=1.0), 3.0, settling=0.0)
    assert stopped.stopped.startswith("stopped: ")
    assert np.isnan(stopped.finished)
    assert len(stopped.force) < 100


def test_forces_are_true_ones_whatever_is_read():
    """What is read is held at the goal; taxels whose gains are wrong are pressed otherwise."""
    hold = replace(FOLLOW, task="keep_force", force_gain=0.003)
    wrong = replace(beside(), sensor=SensorEffects(gain_spread=GainSpread(sd=0.3)))
    true, read = (run_course(setup, hold, 0.1, settling=3.0) for setup in (beside(), wrong))
    assert true.force == pytest.approx(3.0, abs=0.1)
    assert np.abs(read.force - 3.0).min() > 0.15


def test_a_misplaced_skin_is_followed_where_its_taxels_truly_are():
    """What is believed lies 3 mm aside on the average; the contact is not as far from its path as that."""
    wrong = replace(beside(), believed=build_map(misplaced(beside().prepared.skin, 0.002, seed=1)))
    found = run_course(wrong, FOLLOW, 6.0, settling=0.5)
    assert np.isfinite(found.error_rms)
    assert found.error_rms < 0.008


def test_nothing_is_nothing():
    none = np.zeros(0)
    empty = Course(0.005, none, none, none, none, none, *[float("nan")] * 3)
    assert np.isnan([empty.error_p95, empty.error_rms, empty.force_p95(3.0)]).all()
    assert empty.lost == 1.0
    assert empty.in_band(3.0, 1.0) == 0.0
    assert empty.energy_minimum == 0.0
