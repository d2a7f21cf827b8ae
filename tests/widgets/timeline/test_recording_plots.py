"""Curves of a whole recording with real mouse events: no peak is lost at any zoom, a drag selects a range."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QImage, QPalette
from PySide6.QtTest import QTest

from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.recording.overview.curves import CURVES, Curves, FrameQuantity, QuantityKind
from tactile_widgets.common.colours import DARK
from tactile_widgets.plots.choice.plot_choice import PlotKey, PlotKind
from tactile_widgets.plots.timeline.lane_painter import Overlaid
from tactile_widgets.plots.timeline.lanes import AddedLane
from tactile_widgets.plots.timeline.playhead import Span
from tactile_widgets.plots.timeline.recording_plots import RecordingPlots
from tests.widgets.support.mouse import left_click, left_double_click, left_drag, turn_wheel

NONE = Qt.KeyboardModifier.NoModifier
SECONDS = 600.0
TICK = 0.005
SPIKE = 300.0
JOINT = PlotKey(PlotKind.JOINT, "elbow")


def values_with(force):
    """(n, curves) with this force, no pressure and no error."""
    values = np.zeros((len(force), len(CURVES)))
    values[:, CURVES.index("force")] = force
    values[:, CURVES.index("error")] = np.nan
    return values


@pytest.fixture
def plots(qtbot):
    """Ten minutes of nothing, but for one tick of 6.4 N in the middle."""
    plots = RecordingPlots(DARK)
    qtbot.addWidget(plots)
    dark = plots.palette()
    dark.setColor(QPalette.ColorRole.Window, QColor(DARK.panel))
    plots.setPalette(dark)
    plots.setAutoFillBackground(True)
    plots.resize(900, 140)
    plots.show_recording(SECONDS, TICK, ReadingUnits.CALIBRATED)
    times = np.arange(round(SECONDS / TICK)) * TICK
    force = np.zeros(len(times))
    force[round(SPIKE / TICK)] = 6.4
    plots.show_curves(times, values_with(force))
    plots.show()
    qtbot.waitExposed(plots)
    return plots


def seen(plots):
    """(rows, columns) how bright the upper lane is, below its title."""
    picture = plots.grab().toImage().convertToFormat(QImage.Format.Format_Grayscale8)
    rows = np.frombuffer(picture.constBits(), np.uint8).reshape(picture.height(), picture.bytesPerLine())
    return rows[20:62, : picture.width()].astype(int)


def turn(plots, x, turns):
    """The wheel over ``x`` [px]."""
    turn_wheel(plots, QPointF(x, 40), turns)


def test_peak_of_one_tick_in_ten_minutes_is_drawn_at_full_height(plots):
    bright = seen(plots)[:30] > 150
    x = round(plots.x_of(SPIKE))
    top = 20 + int(np.argmax(bright[:, x - 2 : x + 3].any(axis=1)))
    # of the upper lane, for 10 N
    floor = 61
    height = 55 - 14
    assert top == pytest.approx(floor - 0.64 * height, abs=2)
    bright[:, x - 4 : x + 5] = False
    assert not bright[:, 60:].any(), "and nothing else is"


def test_wheel_zooms_at_the_pointer_and_double_click_shows_all(plots):
    x = round(plots.x_of(SPIKE))
    turn(plots, x, 10)
    assert plots.view.length == pytest.approx(SECONDS / 1.25**10)
    assert plots.x_of(SPIKE) == pytest.approx(x, abs=1)
    turn(plots, x, 100)
    assert plots.view.length == pytest.approx(20 * TICK)
    assert plots.view.start <= SPIKE <= plots.view.end
    left_double_click(plots, QPoint(400, 40))
    assert plots.view == Span(0.0, SECONDS)
    turn(plots, x, -5)
    assert plots.view == Span(0.0, SECONDS)


def test_click_seeks_and_drag_selects_a_range(plots):
    went = []
    ranges = []
    plots.time_chosen.connect(went.append)
    plots.range_dragged.connect(ranges.append)
    left_click(plots, QPoint(400, 40))
    assert went == [pytest.approx(plots.time_at(400))]
    left_drag(plots, QPoint(300, 40), QPoint(500, 50))
    assert ranges[-1] == Span(pytest.approx(plots.time_at(300)), pytest.approx(plots.time_at(500)))
    assert len(went) == 1


def test_zoomed_view_follows_the_cursor(plots):
    turn(plots, plots.x_of(100.0), 20)
    plots.show_time(500.0)
    assert plots.view.start < 500.0 < plots.view.end


def test_second_recording_is_dashed_and_shifted_by_its_offset(plots):
    ticks = np.arange(1000)
    force = np.full(1000, 5.0)
    other = Overlaid(Curves(ticks + 50, values_with(force)), 50, TICK, 100.0, "second")
    assert other.times()[0] == 100.0
    turn(plots, plots.x_of(102.5), 20)
    before = seen(plots)
    plots.show_overlaid(other)
    new = np.abs(seen(plots) - before) > 30
    row = new[np.argmax(new.sum(axis=1))]
    dashes = np.flatnonzero(row)
    assert plots.x_of(100.0) - 2 <= dashes.min()
    assert dashes.max() <= plots.x_of(105.0) + 2
    assert len(dashes) > 50
    assert (np.diff(dashes) > 1).sum() > 5, "dashed"
    plots.show_overlaid(None)
    assert (seen(plots) == before).all()


def test_lanes_show_the_available_quantities(plots):
    assert plots.lanes == ("Contact force (N)", "Peak pressure (kPa)")
    values = values_with(np.zeros(10))
    values[3, CURVES.index("error")] = 0.004
    plots.show_curves(np.arange(10) * TICK, values)
    assert plots.lanes[-1] == "Error on the map (mm)"
    plots.set_units(ReadingUnits.COUNTS)
    assert "Contact strength (relative)" in plots.lanes


def test_added_plot_is_a_lane_below(plots):
    joint = AddedLane(JOINT, FrameQuantity(QuantityKind.JOINT_POSITION, (0,)), "rad", signed=True)
    heights = []
    plots.lanes_changed.connect(lambda: heights.append(plots.preferred_height(140)))
    plots.show_added((joint,))
    assert heights == [174]
    plots.resize(900, 174)
    times = np.arange(1000) * TICK
    values = np.column_stack([values_with(np.zeros(1000)), np.linspace(-1.25, -1.05, 1000)])
    plots.show_curves(times, values)
    assert plots.lanes[-1] == "Joint elbow (rad)"
    turn(plots, plots.x_of(2.5), 30)
    picture = plots.grab().toImage().convertToFormat(QImage.Format.Format_Grayscale8)
    rows = np.frombuffer(picture.constBits(), np.uint8).reshape(picture.height(), picture.bytesPerLine())
    lane = rows[105:156, round(plots.x_of(0.2)) : round(plots.x_of(4.8))] > 150
    places = [np.flatnonzero(column).max() for column in lane.T if column.any()]
    assert len(places) > 100
    assert places[0] > places[-1] + 15, "it rises, though it is below zero"
    QTest.mouseMove(plots, QPoint(round(plots.x_of(2.5)), 40))
    plots.grab()


def test_second_recording_is_drawn_only_in_the_standard_lanes(plots):
    plots.show_added((AddedLane(JOINT, FrameQuantity(QuantityKind.JOINT_POSITION, (0,)), "rad", signed=True),))
    plots.show_curves(np.arange(10) * TICK, np.column_stack([values_with(np.zeros(10)), np.full(10, 0.5)]))
    plots.show_overlaid(Overlaid(Curves(np.arange(10), values_with(np.ones(10))), 0, TICK, 0.0, "second"))
    plots.grab()
    assert len(plots.lanes) == 3


def test_no_curve_crosses_a_title_of_many_low_lanes(plots):
    """A force, a pressure and an error at the end of their axes in lanes of 34 px."""
    values = np.full((100, len(CURVES)), np.nan)
    pictures = []
    for level in (0.6, 1.0):
        values[:, [CURVES.index(name) for name in ("force", "peak", "error")]] = level * np.array([5.0, 5e3, 5e-3])
        plots.show_curves(np.linspace(0, SECONDS, 100), values)
        picture = plots.grab().toImage().convertToFormat(QImage.Format.Format_Grayscale8)
        rows = np.frombuffer(picture.constBits(), np.uint8).reshape(picture.height(), picture.bytesPerLine())
        pictures.append(rows.astype(int))
    assert len(plots.lanes) == 3
    low, high = pictures
    left = round(plots.x_of(0.0))
    height = (140 - 6 - 18 - 2 * 6) / 3
    for number in range(3):
        top = round(6 + number * (height + 6))
        title = np.s_[top : top + 12, left + 4 : left + 150]
        np.testing.assert_array_equal(high[title], low[title])
        curve = np.s_[top + 12 : top + 18, left + 4 : left + 150]
        assert (high[curve] != low[curve]).any()
