"""The figures of a trace, of traces made so that they are known."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.session.law_figures import law_figures, limit_name, trace_csv
from app.session.law_trace import NUMBERS, LawTrace, TraceRows

TICKS = 1000
TIME = 0.005 * np.arange(1, TICKS + 1)


def trace(*, name="A", law="qp", touched=True, limits=((),) * TICKS, **columns) -> LawTrace:
    nothing = dict.fromkeys(NUMBERS, np.full(TICKS, np.nan))
    nothing |= {"time": TIME, "force": np.zeros(TICKS), "joint_speed": np.zeros(TICKS), "control_ms": np.ones(TICKS)}
    columns = {key: np.broadcast_to(value, TICKS) for key, value in (nothing | columns).items()}
    return LawTrace(name, ControlSettings(law=law), **columns, touched=np.broadcast_to(touched, TICKS), limits=limits)


def test_errors_are_in_millimetres_rms_and_p95():
    ramp = np.linspace(0, 0.01, TICKS)
    found = law_figures(trace(map_error=ramp, body_error=2 * ramp))
    assert found.map_rms_mm == pytest.approx(10 / np.sqrt(3), rel=1e-2)
    assert found.map_p95_mm == pytest.approx(9.5, rel=1e-2)
    assert found.body_rms_mm == pytest.approx(2 * found.map_rms_mm)
    assert found.body_p95_mm == pytest.approx(2 * found.map_p95_mm)


def test_force_is_measured_against_its_goal_while_there_is_one():
    goal = np.where(TIME > 1.0, 3.0, np.nan)
    found = law_figures(trace(force=3.2 + 0.1 * np.sin(40 * TIME) + 9.0 * (TIME < 0.5), force_goal=goal))
    assert found.force_rms_N == pytest.approx(np.hypot(0.2, 0.1 / np.sqrt(2)), rel=1e-2)
    assert found.force_std_N == pytest.approx(0.1 / np.sqrt(2), rel=1e-2)
    assert found.force_max_N == pytest.approx(12.2, rel=1e-2)


def test_lost_is_time_under_a_finger_without_contact_after_the_first():
    force = np.where((TIME > 1) & ((TIME < 2) | (TIME > 2.5)), 3.0, 0.0)
    assert law_figures(trace(force=force)).lost == pytest.approx(0.5 / 4.0, abs=0.005)
    assert law_figures(trace(force=force, touched=TIME < 2)).lost == pytest.approx(0, abs=0.006), "it was lifted"
    assert np.isnan(law_figures(trace(force=force, touched=False)).lost), "nobody was there to lose"
    assert np.isnan(law_figures(trace()).lost), "never felt"


def test_the_limit_said_most_often_is_named_without_its_numbers():
    limits = tuple(
        ("joint limit", f"energy given, {k} J") if k < 300 else ("joint speed",) * (k < 500) for k in range(1000)
    )
    found = law_figures(trace(limits=limits))
    assert found.limited == 0.5
    assert found.limit in ("joint limit", "energy given")
    assert law_figures(trace()).limit == ""
    assert law_figures(trace()).limited == 0


@pytest.mark.parametrize(
    ("said", "name"),
    [
        ("energy given to the contact, 1.2 J", "energy given to the contact"),
        ("stopped: 41 N of force, more than 40 N; lift what touches to go on", "stopped"),
        ("joint limit", "joint limit"),
    ],
)
def test_a_limit_keeps_its_name_while_its_numbers_change(said, name):
    assert limit_name(said) == name


def test_time_speed_and_energy():
    ms = np.where(np.arange(TICKS) < 940, 0.2, 5.0)
    found = law_figures(trace(control_ms=ms, joint_speed=np.sin(TIME), energy=0.5 - TIME))
    assert (found.control_ms, found.control_p95_ms) == (0.2, 5.0)
    assert found.joint_speed_max == pytest.approx(1.0, rel=1e-3)
    assert found.energy_J == pytest.approx(0.495)
    assert found.seconds == 5.0


def test_one_without_a_tick_measures_nothing():
    found = law_figures(TraceRows().trace("A", ControlSettings(), "stopped"))
    assert np.isnan([found.map_rms_mm, found.force_rms_N, found.force_max_N, found.control_ms, found.limited]).all()
    assert found.seconds == 0


def test_a_table_of_all_has_a_row_a_tick_and_an_empty_cell_for_what_there_was_not():
    limits = (("joint limit", "joint speed"),) * TICKS
    text = trace_csv([trace(force=1.5), trace(name="B", law="hybrid", limits=limits)]).decode()
    rows = list(csv.DictReader(text.splitlines()))
    assert len(rows) == 2 * TICKS
    assert (rows[0]["name"], rows[0]["law"], float(rows[0]["force_N"])) == ("A", "qp", 1.5)
    assert (rows[-1]["name"], rows[-1]["map_error_m"]) == ("B", "")
    assert rows[-1]["limits"] == "joint limit; joint speed"
    assert float(rows[7]["time_s"]) == TIME[7], "as exact as it was"
