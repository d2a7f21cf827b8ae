"""The timeline and the curves of a recording share a time axis in the window."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtWidgets import QApplication

from tactile_widgets.plots.timeline.playhead import Span
from tactile_widgets.plots.timeline.scrub_bar import ScrubBar
from tests.widgets.support.mouse import left_click, left_double_click, turn_wheel
from tests.widgets.support.window_driver import replay_run

NONE = Qt.KeyboardModifier.NoModifier


@pytest.mark.long
def test_zooming_the_curves_zooms_the_timeline(window_again, tmp_path):
    window = window_again
    path = tmp_path / "short.mcap"
    replay_run(window, path, 0.6)
    QApplication.processEvents()
    bar = window.timeline.findChild(ScrubBar)
    curves = window.recording_plots
    duration = window.live.replay.player.duration
    assert (bar.time_at(0), bar.time_at(bar.width())) == pytest.approx((0.0, duration))
    place = QPointF(curves.x_of(0.4), 40.0)
    for _ in range(4):
        turn_wheel(curves, place)
    assert curves.view.length < 0.5 * duration
    assert Span(bar.time_at(0), bar.time_at(bar.width())) == curves.view
    for time in (curves.view.start, 0.4, curves.view.end):
        assert bar.mapTo(window, QPointF(bar.x_of(time), 0.0)).x() == pytest.approx(
            curves.mapTo(window, QPointF(curves.x_of(time), 0.0)).x(), abs=1.0
        )
    left_click(bar, QPoint(round(bar.x_of(0.4)), 20))
    assert window.timeline.playhead.time == pytest.approx(0.4, abs=0.01)
    left_double_click(curves, QPoint(round(curves.x_of(0.4)), 40))
    assert bar.time_at(bar.width()) == pytest.approx(duration)
    window.live.replay.leave()
