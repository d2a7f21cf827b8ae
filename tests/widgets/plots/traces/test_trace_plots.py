"""Traces of selected taxels and regions, with their past, in one colour in all widgets."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pyqtgraph as pg
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QPainter, QPicture
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QPushButton

from tactile_widgets.common.colours import DARK
from tactile_widgets.common.tool_kinds import SelectionMode
from tactile_widgets.document.taxel_selection import (
    REGION_COLOURS,
    TAXEL_COLOURS,
    SelectionUpdate,
    TaxelSelection,
    region_colour,
)
from tactile_widgets.panels.touch.contacts_panel import ContactsPanel
from tactile_widgets.plots.live_plots import LivePlots
from tactile_widgets.plots.traces.trace_plots import TracePlot, legend_entry
from tests.widgets.support.mouse import left_click
from tests.widgets.support.samples import touched

NEAR = 10
OTHER = 70


@pytest.fixture
def selection(prepared):
    selection = TaxelSelection()
    selection.reset(len(prepared.skin))
    return selection


@pytest.fixture
def plots(qtbot, selection):
    plots = LivePlots(DARK)
    qtbot.addWidget(plots)
    plots.resize(1200, 180)
    plots.follow(selection)
    plots.show()
    qtbot.waitExposed(plots)
    return plots


@pytest.fixture
def panel(qtbot, selection):
    panel = ContactsPanel()
    qtbot.addWidget(panel)
    panel.resize(300, 200)
    panel.follow(selection)
    panel.show()
    qtbot.waitExposed(panel)
    return panel


def choose(selection, *taxels, change=SelectionMode.REPLACE):
    selection.take(SelectionUpdate(np.array(taxels, int), change))


def ids(frame, *numbers):
    """The same frame with these region ids."""
    regions = tuple(replace(region, id=number) for region, number in zip(frame.regions, numbers, strict=True))
    return replace(frame, regions=regions)


def play(plots, prepared, count=30, *, start=0):
    """The first region presses ever harder."""
    for k in range(start, start + count):
        plots.show_frame(ids(touched(prepared.map, [NEAR, OTHER], tick=k, time=0.02 * k, kilopascals=1.0 + k), 3, 4))


def redraw(plots):
    """Draw the samples stored since the last drawing."""
    plots.hide()
    plots.show()


def curves(plots, number):
    """Return the curves with samples of plot ``number`` by colour."""
    item = plots.findChildren(pg.PlotWidget)[number].getPlotItem()
    found = [
        curve for curve in item.listDataItems() if curve.isVisible() and curve.xData is not None and len(curve.xData)
    ]
    return {QColor(pg.mkPen(curve.opts["pen"]).color()).name(): curve for curve in found}


def legend(plots, number):
    return plots.findChildren(TracePlot)[number].heading.replace("&nbsp;", " ")


def rows(panel):
    return [panel.findChild(QPushButton, f"contact-{number}") for number in (1, 2, 3)]


@pytest.mark.long
def test_each_region_has_a_named_trace_in_its_colour(plots, prepared):
    play(plots, prepared)
    redraw(plots)
    drawn = curves(plots, 0)
    assert {region_colour(3), region_colour(4), QColor(DARK.text).name()} == set(drawn)
    both = drawn[region_colour(3)].yData + drawn[region_colour(4)].yData
    np.testing.assert_allclose(both, drawn[QColor(DARK.text).name()].yData)
    assert both[-1] > both[0] > 0
    link = prepared.skin.link(prepared.skin.taxel_point(NEAR))
    assert f'color:{region_colour(3)}">●</span> {link}' in legend(plots, 0)


@pytest.mark.long
def test_trace_ends_with_its_region_and_is_removed_when_out_of_range(plots, selection, prepared, qtbot):
    play(plots, prepared)
    selection.select_region(4)
    plots.show_frame(ids(touched(prepared.map, [NEAR], tick=40, time=0.8), 3))
    redraw(plots)
    assert np.isnan(curves(plots, 0)[region_colour(4)].yData[-1])
    assert selection.region == 4, "its past can still be seen"
    with qtbot.waitSignal(plots.region_forgotten) as forgotten:
        for k in range(1, 23):
            plots.show_frame(ids(touched(prepared.map, [NEAR], tick=40, time=0.8 + 0.5 * k), 3))
    assert forgotten.args == [4]
    redraw(plots)
    assert region_colour(4) not in curves(plots, 0)
    assert selection.region is None


@pytest.mark.long
def test_restart_discards_regions_whose_ids_start_again(plots, selection, prepared):
    play(plots, prepared)
    selection.select_region(3)
    plots.show_frame(touched(prepared.map, [], time=0.0))
    assert selection.region is None


@pytest.mark.long
def test_newly_selected_taxels_show_their_past(plots, selection, prepared):
    play(plots, prepared)
    choose(selection, NEAR, OTHER)
    drawn = curves(plots, 1)
    first, second = (drawn[ink] for ink in TAXEL_COLOURS[:2])
    expected = [touched(prepared.map, [NEAR, OTHER], kilopascals=1.0 + k).pressures[NEAR] / 1e3 for k in range(30)]
    np.testing.assert_allclose(first.yData, expected, rtol=1e-6)
    assert first.xData[-1] == 0.0
    assert len(second.xData) == 30
    assert f'color:{TAXEL_COLOURS[0]}">○</span> {NEAR}' in legend(plots, 1)
    assert f'color:{TAXEL_COLOURS[1]}">○</span> {OTHER}' in legend(plots, 1)


@pytest.mark.long
def test_trace_keeps_its_colour_when_another_taxel_is_added(plots, selection, prepared):
    play(plots, prepared)
    choose(selection, NEAR)
    felt = curves(plots, 1)[TAXEL_COLOURS[0]].yData
    choose(selection, 3, change=SelectionMode.ADD)
    assert selection.taxels.tolist() == [3, NEAR]
    np.testing.assert_array_equal(curves(plots, 1)[TAXEL_COLOURS[0]].yData, felt)
    assert f'color:{TAXEL_COLOURS[0]}">○</span> {NEAR}' in legend(plots, 1)


@pytest.mark.long
def test_many_taxels_are_drawn_as_mean_and_maximum_with_a_band(plots, selection, prepared):
    play(plots, prepared)
    many = np.arange(5, 25)
    choose(selection, *many.tolist())
    play(plots, prepared, 10, start=30)
    redraw(plots)
    item = plots.findChildren(pg.PlotWidget)[1].getPlotItem()
    found = [curve.yData for curve in item.listDataItems() if curve.xData is not None and len(curve.xData)]
    felt = touched(prepared.map, [NEAR, OTHER], kilopascals=40.0).pressures / 1e3
    ends = sorted(values[-1] for values in found)
    assert {len(values) for values in found} == {40}, "what they felt before they were selected, and since"
    assert ends == pytest.approx(sorted([felt.max(), felt[many].mean(), felt[many].max()]), rel=1e-6)
    band = next(thing for thing in item.items if isinstance(thing, pg.FillBetweenItem))
    assert band.isVisible()
    assert not band.path().isEmpty()
    assert "mean of 20" in legend(plots, 1)
    choose(selection, NEAR)
    assert not band.isVisible()


@pytest.mark.long
def test_empty_selection_restores_the_plain_plot(plots, selection, prepared):
    play(plots, prepared)
    choose(selection, NEAR)
    selection.clear()
    assert set(curves(plots, 1)) == {QColor(DARK.text).name()}
    assert "Peak pressure (kPa)" in legend(plots, 1)


@pytest.mark.long
def test_click_on_a_row_selects_its_region_and_a_second_click_clears_it(panel, plots, selection, prepared):
    play(plots, prepared)
    redraw(plots)
    panel.show_frame(ids(touched(prepared.map, [NEAR, OTHER]), 3, 4))
    heard = []
    panel.region_selected.connect(heard.append)
    left_click(rows(panel)[1])
    assert selection.region == 4
    assert [row.isChecked() for row in rows(panel)] == [False, True, False]
    drawn = curves(plots, 0)
    assert drawn[region_colour(4)].opts["pen"].widthF() > drawn[region_colour(3)].opts["pen"].widthF()
    assert drawn[region_colour(4)].opts["pen"].color().alpha() > drawn[region_colour(3)].opts["pen"].color().alpha()
    link = prepared.skin.link(prepared.skin.taxel_point(OTHER))
    assert f'color:{region_colour(4)}">●</span> <b>{link}</b>' in legend(plots, 0)
    QTest.keyClick(rows(panel)[1], Qt.Key.Key_Space)
    assert heard == [4, None]
    assert not any(row.isChecked() for row in rows(panel))
    assert curves(plots, 0)[region_colour(3)].opts["pen"].color().alpha() == 255


def test_rows_keep_their_region_independent_of_force(panel, prepared):
    frame = ids(touched(prepared.map, [NEAR, OTHER]), 3, 4)
    for regions in (frame.regions, frame.regions[::-1]):
        panel.show_frame(replace(frame, regions=regions))
        marks = [label.text() for label in panel.findChildren(QLabel) if "●" in label.text()]
        assert [ink in mark for ink, mark in zip((region_colour(3), region_colour(4)), marks, strict=True)] == [
            True,
            True,
        ]


def test_selected_region_keeps_a_row_among_stronger_ones(panel, selection, prepared):
    frame = ids(touched(prepared.map, [10, 30, 70, 90, 110]), 1, 2, 3, 4, 5)
    selection.select_region(5)
    panel.show_frame(frame)
    assert [row.isChecked() for row in rows(panel)] == [False, False, True]
    selection.clear()
    assert not any(row.isChecked() for row in rows(panel))


def test_empty_row_cannot_be_selected(panel, selection, prepared):
    panel.show_frame(ids(touched(prepared.map, [NEAR]), 3))
    left_click(rows(panel)[2])
    assert selection.region is None
    assert not rows(panel)[2].isChecked()


@pytest.mark.long
def test_traces_are_removed_after_thousands_of_touches(plots, prepared):
    for k in range(600):
        plots.show_frame(ids(touched(prepared.map, [NEAR], tick=k, time=0.5 * k), k))
    redraw(plots)
    item = plots.findChildren(pg.PlotWidget)[0].getPlotItem()
    assert len(item.listDataItems()) <= 23, "the last ten seconds' twenty-one, and all together"


def test_contacts_of_one_colour_are_one_curve_with_a_gap(plots, prepared):
    other = 3 + len(REGION_COLOURS)
    for k, number in enumerate((3, 3, other, other)):
        plots.show_frame(ids(touched(prepared.map, [NEAR], tick=k, time=0.25 * k, kilopascals=1.0 + k), number))
    redraw(plots)
    curve = curves(plots, 0)[region_colour(3)]
    assert curve.xData[[0, 1, -2, -1]].tolist() == [-0.75, -0.5, -0.25, 0.0]
    total = curves(plots, 0)[QColor(DARK.text).name()].yData
    assert curve.yData[np.isfinite(curve.yData)].tolist() == total.tolist()
    assert np.isnan(curve.yData[2:-2]).all()
    assert len(curve.yData) > 4
    assert len(plots.findChildren(pg.PlotWidget)[0].getPlotItem().listDataItems()) == len(REGION_COLOURS) + 3


def test_new_contacts_use_the_curves_of_old_ones_and_leave_the_axes(plots, prepared, monkeypatch):
    plots.show_frame(ids(touched(prepared.map, [NEAR, OTHER], time=0.0), 3, 4))
    redraw(plots)
    (canvas, *_) = plots.findChildren(pg.PlotWidget)
    before = canvas.getPlotItem().listDataItems()
    pens = []
    monkeypatch.setattr(pg.AxisItem, "setTextPen", lambda axis, *_pen: pens.append(axis))
    plots.show_frame(ids(touched(prepared.map, [NEAR, OTHER], time=20.0), 7, 8))
    redraw(plots)
    assert canvas.getPlotItem().listDataItems() == before
    assert curves(plots, 0).keys() >= {region_colour(7), region_colour(8)}
    assert not {canvas.getAxis(side) for side in ("left", "bottom")} & set(pens), "the theme is the same"


@pytest.mark.parametrize(("height", "highest"), [(150, 0.02), (150, 0.01), (80, 0.01), (80, 1000.0)])
def test_axis_numbers_and_label_now_are_not_clipped_in_a_narrow_plot(qtbot, height, highest):
    plot = TracePlot("Error (mm)", highest, None)
    qtbot.addWidget(plot)
    plot.resize(150, height)
    plot.show()
    QApplication.processEvents()
    picture = QPicture()
    for side, texts in (("left", {"0", f"{highest / 2:g}", f"{highest:g}"}), ("bottom", {"−10\u202fs", "now"})):
        axis = plot.plot.getAxis(side)
        painter = QPainter(picture)
        *_, labels = axis.generateDrawSpecs(painter)
        painter.end()
        assert texts <= {text for *_, text in labels}
        assert all(box.right() <= axis.size().width() for box, *_ in labels)


@pytest.mark.parametrize("highest", [1.0, 900.0, 4e3, 5.2e3, 2e6, 1e10])
def test_axis_of_large_values_has_numbers_above_zero(qtbot, highest):
    plot = TracePlot("Contact strength (relative)", 5.0, None)
    qtbot.addWidget(plot)
    plot.resize(280, 150)
    plot.show()
    plot.reach(highest)
    QApplication.processEvents()
    axis = plot.plot.getAxis("left")
    picture = QPicture()
    painter = QPainter(picture)
    *_, labels = axis.generateDrawSpecs(painter)
    painter.end()
    numbers = [float(text) for *_, text in labels]
    assert len(numbers) >= 3
    assert max(numbers) >= 0.8 * max(highest, 5.0)


@pytest.mark.parametrize("entries", [4, 9])
def test_labels_of_both_ends_stay_under_a_heading_of_several_lines(qtbot, entries):
    plot = TracePlot("Contact strength", 1.0, None)
    qtbot.addWidget(plot)
    plot.resize(200, 118)
    plot.update_style(DARK)
    plot.reach(130.0)
    plot.show()
    qtbot.waitExposed(plot)
    legend = "".join(legend_entry("●", "#ff0000", f"upper_arm_{number}") for number in range(entries))
    before = plot.plot.height()
    plot.update_style(DARK, after_title=legend)
    QApplication.processEvents()
    assert plot.plot.height() < before
    picture = QPicture()
    painter = QPainter(picture)
    *_, labels = plot.plot.getAxis("left").generateDrawSpecs(painter)
    painter.end()
    assert {"0", "200"} <= {text for *_, text in labels}
    boxes = [box for box, *_ in labels]
    assert not any(one.intersects(other) for one, other in itertools.combinations(boxes, 2))
