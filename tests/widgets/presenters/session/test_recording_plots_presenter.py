"""Curves of a whole recording in the window: read in the background, linked to the timeline, and cancellable."""

from __future__ import annotations

from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.recording.overview.curves import CURVES
from tactile_maps.session.inputs import PokePressed
from tactile_maps.session.session import Session
from tactile_widgets.jobs.executor import Job, ProcessExecutor
from tactile_widgets.jobs.recording_jobs import send_curves
from tactile_widgets.plots.choice.plot_choice import PlotKey, PlotKind
from tactile_widgets.plots.timeline.playhead import Span
from tests.support.sessions import record
from tests.widgets.support.mouse import left_click, left_drag

pytestmark = pytest.mark.long

NONE = Qt.KeyboardModifier.NoModifier


@pytest.fixture(scope="module")
def path(prepared, tmp_path_factory) -> Path:
    """A second, pressed from 0.25 s on."""
    path = tmp_path_factory.mktemp("plots") / "press.mcap"
    pressed = PokePressed(0, prepared.skin.taxel_point(20))
    record(Session(prepared, scripted=False), path, 200, {50: [pressed]})
    return path


def test_curves_of_the_whole_recording_follow_the_timeline(window_again, path):
    window = window_again
    plots = window.recording_plots
    timeline = window.timeline
    assert not plots.isVisible()
    window.live.open_recording(path)
    assert plots.isVisible()
    assert not window.plots.isVisible()
    forces = plots._values[:, CURVES.index("force")]
    assert len(forces) == 200
    assert forces[:40].max() == 0 < forces[-1]
    left_click(plots, QPoint(round(plots.x_of(0.5025)), 40))  # between two ticks
    assert timeline.playhead.time == pytest.approx(0.5, abs=0.01)
    assert window.live.shown.tick == 101
    left_drag(plots, QPoint(round(plots.x_of(0.3)), 40), QPoint(round(plots.x_of(0.6)), 40))
    assert timeline.range == Span(pytest.approx(0.3, abs=0.01), pytest.approx(0.6, abs=0.01))
    window.action("mark").trigger()
    assert len(plots._notes.marks) == 1
    window.context.notes.undo()
    QTest.keyClick(window, Qt.Key.Key_F6)
    assert window.plots.isVisible()
    assert not plots.isVisible()
    QTest.keyClick(window, Qt.Key.Key_F6)
    window.live.replay.leave()
    assert window.plots.isVisible()
    path.with_suffix(".notes.json").unlink(missing_ok=True)


def test_added_plots_are_shown_for_the_whole_recording(window_again, path, qtbot):
    window = window_again
    plots = window.recording_plots
    joint = window.live.prepared.robot.joints[1].name
    window.live.open_recording(path)
    low = plots.height()
    window.presenters.plots.plot(PlotKey(PlotKind.JOINT, joint))
    assert plots.isVisible(), "they stay where they are"
    QApplication.processEvents()
    assert plots.lanes[-1] == f"Joint {joint.replace('_', ' ')} (rad)"
    assert plots.height() > low
    position = plots.values[:, len(CURVES)]
    assert position[-1] == pytest.approx(window.live.replay.player.frame(199).posture[1])
    window.presenters.plots.plot(PlotKey(PlotKind.LIMIT, LimitKind.JOINT_LIMIT.value))
    assert not plots.isVisible(), "a limit has no curve: the last seconds show it"
    window.action("whole_recording").trigger()
    assert plots.lanes[-1].startswith("Joint")
    window.plots.remove_plot(PlotKey(PlotKind.JOINT, joint))
    assert plots.values.shape[1] == len(CURVES)
    qtbot.waitUntil(lambda: plots.height() == low, timeout=5000)
    window.live.replay.leave()
    path.with_suffix(".notes.json").unlink(missing_ok=True)


@pytest.mark.long
def test_curves_are_read_in_pieces_by_a_process(qtbot, path):
    executor = ProcessExecutor("test")
    pieces = []
    failures = []
    for file in (path, path.with_name("gone.mcap")):
        executor.start(Job(send_curves, file, (), died=""), failed=failures.append, received=pieces.append)
    qtbot.waitUntil(lambda: not executor.busy, timeout=60_000)
    assert sum(len(piece.ticks) for _, piece in pieces) == 200
    assert "gone.mcap" in failures[0]
    executor.close()
