"""Raster of all taxels, over the last seconds and over a recording: no touch is lost, and a row selects its taxel."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF
from PySide6.QtWidgets import QApplication

from tactile_widgets.common.colours import DARK, PressureScale
from tactile_widgets.plots.choice.plot_choice import RASTER
from tactile_widgets.plots.live_plots import LivePlots
from tactile_widgets.plots.traces.history import TaxelHistory
from tactile_widgets.plots.traces.raster import columns, raster_image
from tactile_widgets.plots.traces.trace_plots import AXIS_END, AXIS_START
from tests.widgets.support.mouse import left_click
from tests.widgets.support.samples import touched
from tests.widgets.support.window_driver import press_map, run


def test_raster_without_samples_is_empty():
    picture = columns(np.zeros(0), np.zeros((0, 3)), np.linspace(0, 1, 5))
    assert picture.shape == (4, 3)
    assert np.isnan(picture).all()


def test_single_touch_of_5000_taxels_is_in_one_row_of_pixels():
    history = TaxelHistory(seconds=10.0)
    order = np.arange(5000)
    starts = np.arange(60) * 5000 // 60
    for frame in range(1500):
        pressures = np.zeros(5000)
        pressures[3210] = 8e3 * (frame == 700)
        history.add(0.01 * frame, pressures)
        if frame % 100 == 0:
            history.highest(order, starts)
    ages, values = history.highest(order, starts)
    picture = columns(ages, values, np.linspace(-10.0, 0.0, 201))
    assert np.argwhere(picture == 8.0).tolist() == [[40, 3210 * 60 // 5000]]
    image = raster_image(picture, PressureScale(8.0))
    assert (image.width(), image.height()) == (200, 60)
    reds = [(x, y) for x in range(200) for y in range(60) if image.pixelColor(x, y).green() < 100]
    assert reds == [(40, 38)]


@pytest.fixture
def plots(qtbot, prepared):
    plots = LivePlots(DARK)
    qtbot.addWidget(plots)
    plots.resize(1200, 180)
    plots.show_prepared(prepared)
    plots.add_plot(RASTER)
    for number in range(100):
        plots.show_frame(touched(prepared.map, [10] if number > 50 else [], tick=number, time=0.02 * number))
    plots.show()
    qtbot.waitExposed(plots)
    plots.draw()
    return plots


def test_row_shows_and_selects_its_taxel(plots):
    raster = plots.raster
    room = raster._canvas.room
    row = int(np.flatnonzero(raster._rows.order == 10)[0])
    count = raster._groups
    group = int(np.searchsorted(raster._rows.starts(count), row, side="right")) - 1
    top = room.top() + room.height() * (group + 0.5) / count
    at = room.left() + room.width() * 10.3 / (AXIS_END - AXIS_START)
    now = raster._canvas.mapTo(raster, QPoint(round(at), int(top)))
    taxel, age, pressure = raster.taxel_at(QPointF(now))
    assert (taxel, pressure > 0) == (10, True)
    assert -0.3 < age <= 0
    assert "taxel 10" in raster.words_at(QPointF(now))
    assert "kPa" in raster.words_at(QPointF(now))
    chosen = []
    plots.taxel_clicked.connect(chosen.append)
    left_click(raster._canvas, raster._canvas.mapFrom(raster, now))
    assert chosen == [10]
    assert {series.name for series in raster.series()} == {"taxel 10"}


@pytest.mark.long
def test_raster_of_a_recording_is_read_and_a_click_selects(window_again, tmp_path):
    window = window_again
    window.live.recording.start(tmp_path / "demo.mcap")
    press_map(window, 70)
    run(window, 0.3)
    window.live.recording.stop()
    window.presenters.touch.release()
    window.live.open_recording(tmp_path / "demo.mcap")
    window.plots.add_plot(RASTER)
    QApplication.processEvents()
    plots = window.recording_plots
    assert plots.lanes[-1] == "All taxels (kPa)"
    box = plots._raster_box
    places = [QPointF(box.right() - 3, y) for y in np.arange(box.top() + 0.5, box.bottom(), 1.0)]
    found = [taxel for taxel in map(plots.taxel_at, places) if taxel is not None]
    highest = max(found, key=lambda one: one[2])
    frame = window.live.replay.player.frame(len(window.live.replay.player) - 1)
    assert highest[0] == int(np.argmax(frame.pressures))
    assert highest[2] == pytest.approx(frame.pressures.max(), rel=1e-3)
    place = max(places, key=lambda at: (plots.taxel_at(at) or (0, 0, -1))[2])
    left_click(plots, place.toPoint())
    assert window.views.selection.taxels.tolist() == [highest[0]]
    window.plots.remove_plot(RASTER)
    assert plots.lanes[-1] != "All taxels (kPa)"
    window.live.replay.leave()
