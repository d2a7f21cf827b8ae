"""The timeline and the curves of a recording share a time axis in the window."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_widgets.plots.timeline.playhead import Span
from tactile_widgets.plots.timeline.scrub_bar import ScrubBar
from tests.widgets.support.window_driver import run

NONE = Qt.KeyboardModifier.NoModifier
LEFT = Qt.MouseButton.LeftButton


@pytest.mark.long
def test_zooming_the_curves_zooms_the_timeline(window_again, tmp_path):
    window = window_again
    path = tmp_path / "short.mcap"
    window.live.recording.start(path)
    run(window, 0.6)
    window.live.recording.stop()
    window.live.open_recording(path)
    QApplication.processEvents()
    bar = window.timeline.findChild(ScrubBar)
    curves = window.recording_plots
    duration = window.live.replay.player.duration
    assert (bar.time_at(0), bar.time_at(bar.width())) == pytest.approx((0.0, duration))
    place = QPointF(curves.x_of(0.4), 40.0)
    for _ in range(4):
        wheel = QWheelEvent(
            place,
            curves.mapToGlobal(place),
            QPoint(),
            QPoint(0, 120),
            Qt.MouseButton.NoButton,
            NONE,
            Qt.ScrollPhase.NoScrollPhase,
            False,
        )
        QApplication.sendEvent(curves, wheel)
    assert curves.view.length < 0.5 * duration
    assert Span(bar.time_at(0), bar.time_at(bar.width())) == curves.view
    for time in (curves.view.start, 0.4, curves.view.end):
        assert bar.mapTo(window, QPointF(bar.x_of(time), 0.0)).x() == pytest.approx(
            curves.mapTo(window, QPointF(curves.x_of(time), 0.0)).x(), abs=1.0
        )
    QTest.mouseClick(bar, LEFT, NONE, QPoint(round(bar.x_of(0.4)), 20))
    assert window.timeline.playhead.time == pytest.approx(0.4, abs=0.01)
    QTest.mouseDClick(curves, LEFT, NONE, QPoint(round(curves.x_of(0.4)), 40))
    assert bar.time_at(bar.width()) == pytest.approx(duration)
    window.live.replay.leave()
