"""The reference run in the window: on by a switch, off while hidden, and for the shown session."""

from __future__ import annotations

import os
import signal
from dataclasses import replace

import pytest
from PySide6.QtCore import QObject, QPoint
from PySide6.QtWidgets import QApplication, QLabel

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.session.reference_run import ReferenceDifference
from tactile_maps.session.session import Session
from tactile_widgets.jobs.executor import ProcessExecutor
from tactile_widgets.panels.model.accuracy_panel import AccuracyPanel
from tactile_widgets.panels.model.reference_section import SECONDS, ReferenceSection
from tactile_widgets.session.backends import INLINE
from tactile_widgets.session.reference_comparison import ReferenceComparison
from tests.support.touch import prepared_bar
from tests.widgets.support.mouse import left_click
from tests.widgets.support.window_driver import press_map, run

LONG = 60_000


@pytest.fixture
def section(window_again):
    panel = window_again.column.get(AccuracyPanel)
    window_again.column.reveal(panel)
    QApplication.processEvents()
    yield panel.reference
    panel.reference.switch.setChecked(False)
    panel.set_folded(True)


def switch_on(section):
    """Or off again."""
    place = QPoint(8, section.switch.height() // 2)
    left_click(section.switch, place)


def text(section, name):
    return section.findChild(QLabel, f"reference-{name}").text()


def test_reference_runs_only_when_on_and_shows_differences_and_times(window_again, section):
    following = window_again.live.reference
    comparisons = []
    following.compared.connect(comparisons.append)
    run(window_again, 0.1)
    assert not comparisons
    switch_on(section)
    assert section.switch.isChecked()
    press_map(window_again, 30)
    run(window_again, 0.4)
    assert comparisons[-1].time == window_again.live.shown.time
    assert text(section, "contact-force-now").endswith("\u202fN")
    assert text(section, "contact-place-now").endswith("\u202fmm")
    assert text(section, "cost").startswith("A tick takes ")
    assert "in the reference" in text(section, "cost")


@pytest.mark.long
def test_reference_run_follows_resets_and_control_changes(window_again, section):
    live = window_again.live
    comparisons = []
    refused = []
    live.reference.compared.connect(comparisons.append)
    live.reference.failed.connect(refused.append)
    switch_on(section)
    run(window_again, 0.2)
    live.set_settings(ControlSettings(controller="hybrid", task="hold_point", force_goal=2.0))
    run(window_again, 0.2)
    live.reset()
    run(window_again, 0.2)
    assert comparisons[-1].time == live.shown.time < 0.35
    assert not refused
    live.set_settings(ControlSettings())


@pytest.mark.long
def test_reference_run_ends_when_folded_or_switched_off(window_again, section):
    following = window_again.live.reference
    comparisons = []
    following.compared.connect(comparisons.append)
    switch_on(section)
    run(window_again, 0.1)
    assert comparisons
    panel = window_again.column.get(AccuracyPanel)
    panel.set_folded(True)
    QApplication.processEvents()
    comparisons.clear()
    run(window_again, 0.1)
    assert not comparisons
    panel.set_folded(False)
    QApplication.processEvents()
    run(window_again, 0.1)
    assert comparisons
    switch_on(section)  # off
    comparisons.clear()
    run(window_again, 0.1)
    assert not comparisons


def difference(time, force, *, unmatched=0):
    return ReferenceDifference(time, None, unmatched, force, 0.0, None, 0.2, 0.4)


def test_table_covers_the_last_seconds_and_is_cleared_for_another_session(qtbot):
    section = ReferenceSection()
    qtbot.addWidget(section)
    section.show()
    section.switch.setChecked(True)
    for number in range(100):
        section.show_difference(difference(0.2 * number, float(number)))
    assert text(section, "contact-force-now") == "99\u202fN"
    assert text(section, "contact-force-p95") == f"{99 - 0.05 * SECONDS / 0.2:.3g}\u202fN"
    assert text(section, "contact-place-now") == "–"
    section.show_difference(difference(0.1, 5.0, unmatched=2))
    assert text(section, "contact-force-p95") == "5\u202fN"
    assert text(section, "note") == "2 contacts that the other does not have."
    section.show_behind(3.21)
    assert text(section, "note") == "Catching up: 3.2\u202fs behind."
    section.show_refusal("It cannot be simulated.")
    assert text(section, "note") == "It cannot be simulated."


@pytest.fixture(scope="module")
def pressed():
    session = Session(prepared_bar(), scripted=False)
    session.press(session.prepared.skin.taxel_point(20))
    return session, [session.tick() for _ in range(40)]


@pytest.mark.long
def test_reference_process_follows_each_frame_and_its_crash_is_reported(qtbot, pressed):
    session, frames = pressed
    parent = QObject()
    reference = ReferenceComparison(replace(INLINE, executor=ProcessExecutor), parent)
    reference.set_enabled(True)
    for frame in (frames[19], frames[39]):
        with qtbot.waitSignal(reference.compared, timeout=LONG) as compared:
            reference.show_frame(session, frame)
        assert compared.args[0].time == frame.time
    os.kill(reference.executor.pid, signal.SIGKILL)
    with qtbot.waitSignal(reference.failed, timeout=LONG) as died:
        reference.show_frame(session, frames[39])
    assert "ended unexpectedly" in died.args[0]
    reference.show_frame(session, frames[39])
    assert reference.executor.pid is None, "it is not tried again"
