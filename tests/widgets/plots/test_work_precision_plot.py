"""Work-precision plot with real mouse and keyboard events: a click on a point chooses its setting."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pyqtgraph as pg
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QApplication, QLabel

from tactile_maps.studies.study.work_precision import Curve, Diagram, LimitLine, Point, Setting
from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.common.colours import DARK, LIGHT
from tactile_widgets.plots.curve_legend import SYMBOLS, CurveLegend, curve_colour
from tactile_widgets.plots.work_precision_plot import WorkPrecisionPlot, format_number, log_ticks
from tests.widgets.support.snapshots import pixels, shared_share


def point(method, at, milliseconds, error, **more):
    return Point(milliseconds, error, Setting("flatten", method, {"at": at}, (0,)), f"at {at}", **more)


DIAGRAM = Diagram(
    "flatten",
    "Flatten",
    "Distortion",
    "%",
    (
        Curve("tutte", (point("tutte", 0, 3.0, 40.0, usable=False), point("tutte", 1, 10.0, 20.0)), 1),
        Curve("lscm", (point("lscm", 0, 30.0, 9.0), point("lscm", 1, 200.0, 2.0), point("lscm", 2, 250.0, 0.0)), 3),
    ),
    1e-3,
)
TUTTE, FIRST, SECOND, EXACT = [p for p in DIAGRAM.points if p.usable]


@pytest.fixture(params=[DARK, LIGHT], ids=["dark", "light"])
def plot(qtbot, request):
    apply_theme(QApplication.instance(), request.param)
    made = WorkPrecisionPlot(request.param)
    qtbot.addWidget(made)
    made.resize(276, 340)
    made.show_diagram(DIAGRAM, FIRST.setting)
    made.show()
    qtbot.waitExposed(made)
    QApplication.processEvents()
    return made


def place(plot, point) -> QPoint:
    return next(at for known, at in plot.places() if known == point).toPoint()


def click(plot, qtbot, at, *, to=None):
    view = plot.canvas.viewport()
    qtbot.mousePress(view, Qt.MouseButton.LeftButton, pos=at)
    qtbot.mouseMove(view, to or at)
    qtbot.mouseRelease(view, Qt.MouseButton.LeftButton, pos=to or at)


def detail(plot) -> str:
    return plot.findChild(QLabel, "work-precision-detail").text()


@pytest.mark.long
def test_points_are_at_their_logarithms_within_the_canvas(plot):
    a, b, c = (place(plot, p) for p in (TUTTE, FIRST, SECOND))
    assert a.x() < b.x() < c.x()
    assert a.y() < b.y() < c.y(), "less error is further down"
    # From 10 to 30 ms is as far as from 30 to 90 ms.
    assert (b.x() - a.x()) / (c.x() - b.x()) == pytest.approx(0.477 / 0.824, abs=0.05)
    inside = plot.canvas.viewport().rect().adjusted(52, 0, 0, -34)
    assert all(inside.contains(at.toPoint()) for _, at in plot.places())


@pytest.mark.long
def test_zero_error_is_drawn_lowest_and_labelled_zero(plot):
    assert place(plot, EXACT).y() > place(plot, SECOND).y()
    low = plot.canvas.left_axis.zero
    assert plot.canvas.left_axis.tickStrings([low, 1.0], 1, 1) == ["0", "10"]


@pytest.mark.long
def test_click_on_a_point_chooses_its_setting(plot, qtbot):
    with qtbot.waitSignal(plot.chosen) as got:
        click(plot, qtbot, place(plot, SECOND) + QPoint(4, 3))
    assert got.args == [SECOND.setting]


@pytest.mark.long
def test_click_off_points_or_on_the_current_setting_or_an_iteration_has_no_effect(plot, qtbot):
    on_the_way = DIAGRAM.points[0]
    with qtbot.assertNotEmitted(plot.chosen):
        click(plot, qtbot, place(plot, SECOND) + QPoint(-30, -30))
        click(plot, qtbot, place(plot, FIRST))
        click(plot, qtbot, place(plot, on_the_way))
    assert "Intermediate iteration, not a setting" in detail(plot)


@pytest.mark.long
def test_press_that_moved_is_not_a_click(plot, qtbot):
    with qtbot.assertNotEmitted(plot.chosen):
        click(plot, qtbot, place(plot, TUTTE), to=place(plot, SECOND))


@pytest.mark.long
def test_hover_names_the_point_and_leaving_names_the_current_setting(plot, qtbot):
    assert detail(plot) == "Present: Conformal (LSCM), at 0: 9\u202f%, 30\u202fms"
    qtbot.mouseMove(plot.canvas.viewport(), place(plot, TUTTE))
    assert plot.held == TUTTE
    assert detail(plot) == "Tutte, at 1: 20\u202f%, 10\u202fms. Click or Enter to apply it."
    assert plot.canvas.cursor().shape() == Qt.CursorShape.PointingHandCursor
    qtbot.mouseMove(plot.canvas.viewport(), place(plot, TUTTE) + QPoint(25, 40))
    assert plot.held is None
    assert detail(plot).startswith("Present:")


@pytest.mark.long
def test_points_with_many_runs_show_the_95th_percentile_as_a_bar(plot, qtbot):
    spread = replace(TUTTE, p95_ms=14.0)
    curves = tuple(
        replace(curve, points=tuple(spread if known == TUTTE else known for known in curve.points))
        for curve in DIAGRAM.curves
    )
    plot.show_diagram(replace(DIAGRAM, curves=curves), FIRST.setting)
    for away in (QPoint(40, 40), QPoint(0, 0)):  # where it was before is no move
        qtbot.mouseMove(plot.canvas.viewport(), place(plot, spread) + away)
    assert detail(plot).startswith("Tutte, at 1: 20\u202f%, 10\u202fms (95\u202f% within 14\u202fms)")
    bars = [item.getData() for item in plot.canvas.getPlotItem().listDataItems() if item.opts.get("connect") == "pairs"]
    ((x, y),) = bars
    assert 10**x == pytest.approx([10.0, 14.0])
    assert 10**y == pytest.approx([20.0, 20.0])


@pytest.mark.long
def test_error_interval_is_a_vertical_bar(plot, qtbot):
    sure = replace(TUTTE, interval=(18.0, 23.0))
    curves = tuple(
        replace(curve, points=tuple(sure if known == TUTTE else known for known in curve.points))
        for curve in DIAGRAM.curves
    )
    plot.show_diagram(replace(DIAGRAM, curves=curves), FIRST.setting)
    bars = [item.getData() for item in plot.canvas.getPlotItem().listDataItems() if item.opts.get("connect") == "pairs"]
    ((x, y),) = bars
    assert 10**x == pytest.approx([10.0, 10.0])
    assert 10**y == pytest.approx([18.0, 23.0])
    top = replace(TUTTE, interval=(18.0, 400.0))
    plot.show_diagram(replace(DIAGRAM, curves=(Curve("tutte", (top,)),)), FIRST.setting)
    assert plot.canvas.getPlotItem().getViewBox().viewRange()[1][1] > np.log10(400.0), "there is room for it"
    plot.show_diagram(replace(DIAGRAM, curves=curves), FIRST.setting)
    for away in (QPoint(40, 40), QPoint(0, 0)):
        qtbot.mouseMove(plot.canvas.viewport(), place(plot, sure) + away)
    assert detail(plot).startswith("Tutte, at 1: 20\u202f% (18 to 23\u202f%), 10\u202fms")


def test_arrows_move_along_points_and_enter_applies(plot, qtbot):
    def press(key):
        qtbot.keyClick(plot.canvas, key)
        return plot.held

    assert press(Qt.Key.Key_Right) == FIRST, "from the present setting"
    assert press(Qt.Key.Key_Right) == SECOND
    assert press(Qt.Key.Key_Right) == EXACT
    assert press(Qt.Key.Key_Right) == EXACT, "there is no slower one"
    assert press(Qt.Key.Key_Up) == SECOND
    with qtbot.waitSignal(plot.chosen) as got:
        press(Qt.Key.Key_Return)
    assert got.args == [SECOND.setting]
    assert press(Qt.Key.Key_Left) == FIRST
    assert press(Qt.Key.Key_Left) == TUTTE, "not the round on the way"
    assert press(Qt.Key.Key_Down) == FIRST
    assert press(Qt.Key.Key_Escape) is None


@pytest.mark.long
def test_ring_is_at_the_current_setting(plot):
    before = pixels(plot.grab().toImage())
    plot.show_diagram(DIAGRAM, SECOND.setting)
    assert shared_share(before, pixels(plot.grab().toImage()), tolerance=8) < 1
    assert detail(plot).startswith("Present: Conformal (LSCM), at 1")
    plot.show_diagram(DIAGRAM, Setting("flatten", "slim"))
    assert detail(plot) == "Click a point to apply its setting."


@pytest.mark.long
def test_diagram_with_one_or_no_point_is_drawn(plot):
    one = Diagram("flatten", "Flatten", "Distortion", "%", (Curve("tutte", (TUTTE,), 1),))
    plot.show_diagram(one)
    assert len(plot.places()) == 1
    exact = Diagram("flatten", "Flatten", "Distortion", "%", (Curve("lscm", (EXACT,), 3),))
    plot.show_diagram(exact)
    plot.show_diagram(Diagram("flatten", "Flatten", "Distortion", "%", ()))
    assert plot.places() == []


@pytest.mark.long
def test_legend_names_every_curve_and_fits_the_width(plot, qtbot):
    names = [label.text() for label in plot.findChild(CurveLegend).findChildren(QLabel)]
    assert names == ["Tutte", "Conformal (LSCM)", "Pareto front", "Current setting"]
    legend = plot.findChild(CurveLegend)
    narrow = legend.sizeHint().height()
    plot.resize(820, 500)
    QApplication.processEvents()
    assert legend.sizeHint().height() < narrow


def test_curves_differ_with_and_without_colour():
    assert len(set(SYMBOLS)) == len(SYMBOLS) >= 7
    for theme in (DARK, LIGHT):
        assert len({curve_colour(theme, k).name() for k in range(len(SYMBOLS))}) == len(SYMBOLS)


@pytest.mark.parametrize(
    ("value", "text"),
    [(0, "0"), (0.0123456, "0.0123"), (1.5, "1.5"), (12.34, "12.3"), (639.4, "639"), (20000, "20000"), (1e-7, "1e-07")],
)
def test_readout_numbers_have_three_digits(value, text):
    assert format_number(value) == text


@pytest.mark.parametrize(("low", "high"), [(-3, 2), (0.7, 1.7), (1.02, 1.34), (1.30, 1.31), (-8, 9)])
@pytest.mark.parametrize("share", [0.05, 0.15, 0.4])
def test_axis_labels_are_round_and_do_not_overlap(low, high, share):
    room = share * (high - low)
    ticks = log_ticks(low, high, room)
    assert len(ticks) >= 2
    assert (ticks >= low).all()
    assert (ticks <= high).all()
    assert np.diff(ticks).min() >= room
    if high - low > 1:
        assert all(len(format_number(10**tick).strip("0.").replace(".", "")) <= 2 or abs(tick) > 4 for tick in ticks)


def test_nearer_of_two_points_in_reach_is_picked(plot, qtbot):
    near = (point("lscm", 0, 100.0, 9.0), point("lscm", 1, 104.0, 9.0), point("lscm", 2, 300.0, 1.0))
    plot.show_diagram(Diagram("flatten", "Flatten", "Distortion", "%", (Curve("lscm", near, 3),)))
    assert 2 < place(plot, near[1]).x() - place(plot, near[0]).x() < 12, "each is within the other's reach"
    for expected in near[:2]:
        qtbot.mouseMove(plot.canvas.viewport(), place(plot, expected))
        assert plot.held == expected


@pytest.mark.long
def test_stability_limits_are_vertical_lines_in_the_colour_of_their_method(plot):
    lines = (LimitLine("Stability limit", "h < 0.83 / sqrt(k)", 20.0, 1), LimitLine("Stability limit", "h", 2.0, 3))
    plot.show_diagram(replace(DIAGRAM, limits=lines), FIRST.setting)
    drawn = [item for item in plot.canvas.getPlotItem().items if isinstance(item, pg.InfiniteLine)]
    assert [item.value() for item in drawn] == pytest.approx(np.log10([20.0, 2.0]))
    theme = plot._theme
    assert [item.pen.color() for item in drawn] == [curve_colour(theme, 1), curve_colour(theme, 3)]
    low, high = plot.canvas.getPlotItem().getViewBox().viewRange()[0]
    assert low < np.log10(2.0) < high, "there is room for a limit beyond all points"
    legend = plot.findChild(CurveLegend)
    assert [label.text() for label in legend.findChildren(QLabel)].count("Stability limit") == 1
    assert "h < 0.83 / sqrt(k)" in legend.toolTip()
