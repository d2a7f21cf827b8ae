"""The study that compares controllers on the same paths, robots and sensors."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from tactile_maps.control.controllers import CONTROL_SCHEMES
from tactile_maps.core.errors import UsageError
from tactile_maps.studies.sweeps.controller_accuracy import (
    COMPARED,
    FEW_SEEDS,
    FINGER_FORCE,
    FORCE_ONLY,
    GOAL,
    PATHS,
    SECOND_CONTACT,
    SEEDS,
    SENSORS,
    STUDY,
    cases,
    figures,
    measure,
    settings_for,
    setup_for,
)
from tactile_maps.studies.testbeds.fixed_ball import SKIN_LINKS
from tactile_maps.studies.testbeds.path_following import run_path


def test_full_table_has_every_combination_once():
    requested = cases(False, 0)
    rules = set(itertools.product(SKIN_LINKS, PATHS, CONTROL_SCHEMES, SENSORS, range(FEW_SEEDS)))
    rules |= set(itertools.product(SKIN_LINKS, (COMPARED,), CONTROL_SCHEMES, ("skin",), range(SEEDS)))
    holds = set(itertools.product(SKIN_LINKS, ("held",), (FORCE_ONLY,), SENSORS, range(FEW_SEEDS)))
    holds |= set(itertools.product(SKIN_LINKS, ("held",), (FORCE_ONLY,), ("skin",), range(SEEDS)))
    found = [tuple(case[key] for key in ("robot", "path", "controller", "sensor", "seed")) for case in requested]
    assert set(found) == rules | holds
    assert len(found) == len(set(found))
    assert {case["robot"] for case in cases(True, 0)} == set(SKIN_LINKS)


def test_seeds_of_the_comparison_are_complete_one_after_another_before_all_other_cases():
    requested = cases(False, 5)
    size = len(SKIN_LINKS) * (len(CONTROL_SCHEMES) + 1)
    compared = requested[: SEEDS * size]
    assert [case["seed"] for case in compared] == [5 + number for number in range(SEEDS) for _ in range(size)]
    assert {(case["path"], case["sensor"]) for case in compared} == {(COMPARED, "skin"), ("held", "skin")}
    assert {case["seed"] for case in requested[SEEDS * size :]} == {5, 6, 7}


@pytest.fixture(scope="module")
def rows():
    requested = [("line", "hybrid", "skin"), ("held", FORCE_ONLY, "wrench")]
    cases_ = [
        {"robot": "arm", "path": path, "controller": controller, "sensor": sensor, "seed": 0}
        for path, controller, sensor in requested
    ]
    return [{**case, **row} for case in cases_ for row in measure(case)]


@pytest.mark.long
def test_row_contains_errors_times_and_gains(rows):
    row = rows[0]
    assert 0 < row["body_rms_mm"] < row["body_p95_mm"] < 5
    assert 0 < row["map_rms_mm"] < row["map_p95_mm"] < 5
    assert abs(row["force_bias_N"]) < row["force_rms_N"] < 0.2
    assert row["finished_s"] == pytest.approx(row["asked_s"], abs=0.1)
    assert row["lost_percent"] == 0
    assert row["force_gain"] <= 0.5 * row["stable_gain"]
    assert 0 < row["control_ms"] <= row["control_p95_ms"]
    assert row["stopped"] == ""


@pytest.mark.long
def test_controller_without_a_task_has_no_position_error(rows):
    row = rows[1]
    assert row["body_rms_mm"] is row["map_p95_mm"] is row["finished_s"] is row["energy_minimum_J"] is None
    assert row["force_rms_N"] < 0.1


@pytest.mark.long
def test_figures_show_controllers_sensors_and_cost(rows):
    places, cost = figures(rows)
    assert places.title == "Place and force", "one sensor is not compared"
    by_wrench = {**rows[0], "sensor": "wrench", "body_p95_mm": 1.0}
    places, sensors, cost = figures([*rows, by_wrench])
    (panel,) = places.panels
    assert panel.title == "arm, line"
    assert panel.curves == {"hybrid": [(rows[0]["force_rms_N"], rows[0]["body_p95_mm"])]}
    expected = {"arm, line, skin": rows[0]["body_p95_mm"], "arm, line, wrench": 1.0}
    assert sensors.amounts == expected, "no run of the figure of eight"
    assert cost.amounts == {"hybrid": rows[0]["control_ms"]}
    again = [{**row, "path": SECOND_CONTACT} for row in (*rows, by_wrench, {**rows[0], "body_p95_mm": None})]
    assert figures(again)[1].amounts == {name.replace("line", SECOND_CONTACT): size for name, size in expected.items()}
    assert STUDY.name == "controller-accuracy"


@pytest.mark.long
def test_skin_separates_two_contacts_and_the_wrench_stops_the_arm():
    skin, wrench = (
        run_path(setup_for("arm", sensor, 0, touched=True), settings_for("hybrid", SECOND_CONTACT), 6.0)
        for sensor in ("skin", "wrench")
    )
    assert skin.force.max() > GOAL + 0.5 * FINGER_FORCE, "both press"
    assert not skin.stopped
    assert np.nanmax(skin.body_error) < 5e-3
    assert wrench.stopped.startswith("stopped: one wrench from several contacts")


@pytest.mark.long
def test_replay_presses_as_in_its_row():
    case = {"robot": "arm", "path": "line", "controller": "hybrid", "sensor": "skin", "seed": 0}
    (row,) = measure(case)
    replay = STUDY.replay({**case, **row})
    forces = []
    with replay.session.watched(lambda frame: forces.append(replay.session.total_normal_force)):
        replay.play()
    moving = np.array(forces[min(replay.inputs) :]) - GOAL
    assert len(moving) == round(row["finished_s"] / replay.session.prepared.scene.tick)
    assert np.sqrt(np.mean(moving**2)) == pytest.approx(row["force_rms_N"])
    with pytest.raises(UsageError, match="does not belong to a case of this study"):
        STUDY.replay({**case, **row, "path": "nowhere"})
