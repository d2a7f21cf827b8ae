"""Live plots: they store every sample, draw only when visible, and show their units."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial
from itertools import count
from unittest.mock import Mock

import numpy as np
import pyqtgraph as pg
import pytest
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication, QLabel

from tactile_maps.contacts.detection.contact_shear import ContactShear, Slip
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.session.frame import MeasuredValues
from tactile_widgets.common.colours import DARK, LIGHT
from tactile_widgets.plots.choice.plot_choice import OF_SHEAR
from tactile_widgets.plots.live_plots import MAX_REST_MS, REDRAW_MS, REST, LivePlots
from tactile_widgets.plots.traces.trace_plots import nice_ceiling
from tests.widgets.support.samples import touched


@pytest.fixture
def plots(qtbot):
    plots = LivePlots(DARK)
    qtbot.addWidget(plots)
    plots.resize(1200, 180)
    return plots


def drawn(plots, number):
    """Samples in each curve of plot ``number``."""
    item = plots.findChildren(pg.PlotWidget)[number].getPlotItem()
    return [0 if curve.xData is None else len(curve.xData) for curve in item.listDataItems() if curve.isVisible()]


def words(plots):
    return " ".join(label.text() for label in plots.findChildren(QLabel)).replace("&nbsp;", " ")


def play(plots, prepared, count):
    for k in range(count):
        plots.show_frame(touched(prepared.map, [10] if k % 2 else [], tick=k, time=0.02 * k))


def test_hidden_plots_keep_samples_but_draw_nothing(plots, prepared, qtbot):
    play(plots, prepared, 30)
    assert drawn(plots, 0) == [0]
    plots.show()
    qtbot.waitExposed(plots)
    assert drawn(plots, 0) == [30, 29], "all together, and the 15 touches of one region with gaps between them"
    assert drawn(plots, 2) == [30] * 4


def test_plots_are_not_redrawn_for_every_frame(plots, prepared, qtbot):
    plots.show()
    qtbot.waitExposed(plots)
    play(plots, prepared, 30)
    assert 1 <= drawn(plots, 0)[0] < 30


@pytest.mark.long
def test_slow_plots_are_drawn_less_often_but_always_the_last_frame(plots, prepared, qtbot, monkeypatch):
    plots.show()
    qtbot.waitExposed(plots)
    part = plots._parts[plots.shown_keys[0]]
    draw = part.draw

    def take_long():
        end = time.perf_counter() + 0.05
        while time.perf_counter() < end:
            draw()

    monkeypatch.setattr(part, "draw", take_long)
    plots._redraw()
    assert plots._rest_ms >= 50 * REST > REDRAW_MS
    plots._since_drawn.start()
    plots.show_frame(touched(prepared.map, [10], tick=1, time=0.02))
    assert drawn(plots, 0) == [0]
    assert plots._late.remainingTime() > REDRAW_MS
    qtbot.waitUntil(lambda: drawn(plots, 0) == [1, 1])


def test_frames_in_quick_succession_do_not_postpone_paced_plots(prepared, qtbot, monkeypatch):
    plots = LivePlots(DARK, paced=True)
    qtbot.addWidget(plots)
    plots.show()
    qtbot.waitExposed(plots)
    plots._since_drawn = Mock(elapsed=Mock(return_value=MAX_REST_MS), nsecsElapsed=Mock(return_value=0))
    starts = Mock(wraps=plots._late.start)
    monkeypatch.setattr(plots._late, "start", starts)
    play(plots, prepared, 20)
    starts.assert_called_once()
    qtbot.waitUntil(lambda: drawn(plots, 0) == [20, 19])


def test_window_responds_between_two_paced_plots(prepared, qtbot, monkeypatch):
    plots = LivePlots(DARK, paced=True)
    qtbot.addWidget(plots)
    plots.show()
    qtbot.waitExposed(plots)
    happened = []
    for key in plots.shown_keys:
        monkeypatch.setattr(plots._parts[key], "draw", partial(happened.append, key))
    timer = QTimer(plots)
    timer.timeout.connect(lambda: happened.append("other"))
    timer.start(0)
    play(plots, prepared, 1)
    qtbot.waitUntil(lambda: plots.shown_keys[-1] in happened)
    drawn_at = [happened.index(key) for key in plots.shown_keys]
    assert len(drawn_at) == 2
    assert "other" in happened[drawn_at[0] : drawn_at[1]]
    assert happened.count(plots.shown_keys[0]) == 1


def test_plots_are_drawn_every_second_even_with_slow_updates(plots, monkeypatch):
    monkeypatch.setattr(plots, "_since_drawn", Mock(nsecsElapsed=Mock(side_effect=count(0, 5 * 10**9))))
    plots._redraw()
    assert plots._rest_ms == MAX_REST_MS == 1000


def test_restart_starts_new_plots(plots, prepared, qtbot):
    play(plots, prepared, 30)
    plots.show_frame(touched(prepared.map, [], time=0.0))
    plots.show()
    qtbot.waitExposed(plots)
    assert drawn(plots, 0) == [1]


def test_units_and_goal_are_displayed(plots):
    text = words(plots)
    assert all(unit in text for unit in ("(N)", "(kPa)", "(ms)"))
    assert "goal" not in text
    plots.show_settings(ControlSettings(controller="hold_force", force_goal=3.0))
    assert "goal 3.0" in words(plots)
    plots.show_settings(ControlSettings())
    assert "goal" not in words(plots)


def test_goal_in_newtons_is_not_drawn_among_readings_in_counts(plots, prepared, qtbot):
    plots.show()
    qtbot.waitExposed(plots)
    plots.show_settings(ControlSettings(controller="hold_force", force_goal=3.0))
    frame = touched(prepared.map, [3])
    counts = MeasuredValues(frame.pressures, "counts", 0.0, 0, ReadingUnits.COUNTS)
    plots.show_frame(replace(frame, measured=counts))
    plots._force.draw()
    assert "Contact strength" in words(plots)
    assert "goal" not in words(plots)
    assert [series.name for series in plots._force.series()][:2] == ["all contacts", "contact 0"]
    plots.show_frame(frame)
    assert "goal 3.0" in words(plots)
    assert "goal" in [series.name for series in plots._force.series()]


def test_clear_discards_samples(plots, prepared, qtbot):
    plots.show()
    qtbot.waitExposed(plots)
    play(plots, prepared, 10)
    plots.clear()
    assert drawn(plots, 0) == [0]
    assert drawn(plots, 2) == []


def test_plots_are_stacked_in_a_tall_widget(plots, qtbot):
    plots.show()
    qtbot.waitExposed(plots)
    first, second = plots.findChildren(pg.PlotWidget)[:2]
    assert first.mapTo(plots, first.pos()).x() < second.mapTo(plots, second.pos()).x()
    plots.resize(300, 700)
    QApplication.processEvents()
    assert first.mapTo(plots, first.pos()).y() < second.mapTo(plots, second.pos()).y()


def test_theme_is_applied(plots, prepared):
    play(plots, prepared, 5)
    dark = plots.grab().toImage()
    plots.set_theme(LIGHT)
    assert plots.grab().toImage() != dark


@pytest.mark.parametrize(("value", "top"), [(0.3, 0.5), (1.0, 1.0), (1.01, 2.0), (7.4, 10.0), (480.0, 500.0)])
def test_axis_maxima_are_round(value, top):
    assert nice_ceiling(value) == pytest.approx(top)


def test_shear_and_friction_are_summed_over_contacts_and_missing_without_shear(plots, prepared):
    for key in OF_SHEAR:
        plots.add_plot(key)
    frame = touched(prepared.map, [10, 100])
    states = [
        ContactShear((3.0, 0.0, 4.0), 0.0, 0.4, 1.0, Slip.STICKING, 0.5, estimated=False),
        ContactShear((0.0, 2.0, 0.0), 0.0, 0.9, 0.2, Slip.INCIPIENT, 0.5, estimated=False),
    ]
    regions = tuple(replace(region, shear=state) for region, state in zip(frame.regions, states, strict=False))
    expected = sum(np.linalg.norm(state.force) for state in states[: len(regions)])
    shear = np.zeros((len(prepared.skin), 2))
    plots.show_frame(replace(frame, tick=0, time=0.0))
    plots.show_frame(replace(frame, tick=1, time=0.02, regions=regions, shear=shear))
    plots.show_frame(replace(frame, tick=2, time=0.04, regions=(), shear=shear))
    force, friction = (plots._parts[key].series()[0] for key in OF_SHEAR)
    np.testing.assert_allclose(force.values, [np.nan, expected, 0.0])
    np.testing.assert_allclose(friction.values, [np.nan, 100 * max(one.usage for one in states[: len(regions)]), 0.0])
    assert (force.unit, friction.unit) == ("N", "%")
    plots.show_prepared(prepared)
    plots.draw()
    assert "these taxels do not measure shear" in words(plots)
