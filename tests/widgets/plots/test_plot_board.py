"""Plots chosen by the user: added, dragged, enlarged, in separate windows, and written as a table."""

from __future__ import annotations

import csv
import io
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_widgets.common.colours import DARK, LIGHT
from tactile_widgets.plots.choice.plot_choice import STANDARD, PlotChoice, PlotKey, PlotKind
from tactile_widgets.plots.live_plots import USUAL_HEIGHT, LivePlots
from tactile_widgets.plots.plot_board import PlotWindow
from tests.widgets.support.mouse import left_double_click, left_press, left_release
from tests.widgets.support.samples import touched

FORCE = STANDARD[0]
PRESSURE = STANDARD[4]
TAXEL = PlotKey(PlotKind.TAXEL, "10")


@pytest.fixture
def plots(qtbot, prepared):
    plots = LivePlots(DARK)
    qtbot.addWidget(plots)
    plots.resize(1300, 180)
    plots.show_prepared(prepared)
    plots.show()
    qtbot.waitExposed(plots)
    QApplication.processEvents()
    yield plots
    plots.choose(PlotChoice())


def joint(prepared, number):
    return PlotKey(PlotKind.JOINT, prepared.robot.joints[number].name)


def play(plots, prepared, count=40):
    for k in range(count):
        frame = touched(prepared.map, [10] if k % 8 < 4 else [], tick=4 * k, time=0.02 * k)
        sway = np.full(len(prepared.robot.joints), -0.3 + 0.01 * k)
        plots.show_frame(replace(frame, posture=sway, velocity=0.5 + 0 * sway))
    plots._redraw()


def content(plots, key):
    return plots.board.cell(key).content


def curve(plots, key):
    return content(plots, key).plot.getPlotItem().listDataItems()[0]


def test_low_row_of_plots_does_not_scroll_for_long_legends_and_has_few_ticks(plots):
    force = content(plots, FORCE)
    force.update_style(LIGHT, after_title=" &nbsp;a legend that needs more than a single line of a narrow plot")
    for height, few in ((260, False), (118, True)):
        plots.resize(560, height)
        QApplication.processEvents()
        assert force._heading.height() > 1.5 * force._heading.fontMetrics().lineSpacing()
        assert plots.board.widget().heightForWidth(560) == -1, "a legend does not make the row higher than the board"
        assert plots.board.widget().height() == plots.board.viewport().height()
        assert (force.plot.getAxis("left")._tickLevels is not None) == few


@pytest.mark.long
def test_added_plot_shows_its_past_in_its_unit(plots, prepared):
    play(plots, prepared)
    elbow = joint(prepared, 3)
    link = PlotKey(PlotKind.LINK, prepared.skin.link(prepared.skin.taxel_point(10)))
    for key in (elbow, replace(elbow, kind=PlotKind.JOINT_SPEED), TAXEL, link):
        plots.add_plot(key)
    assert plots.shown[-4:] == (elbow.text, f"joint-speed:{elbow.of}", "taxel:10", link.text)
    assert curve(plots, elbow).yData == pytest.approx(-0.3 + 0.01 * np.arange(40))
    assert "(rad)" in content(plots, elbow).heading
    low, high = content(plots, elbow).plot.viewRange()[1]
    assert low <= -0.3 < 0.09 <= high < 0.5, "signed, and about what there is"
    assert curve(plots, TAXEL).yData.max() == pytest.approx(12.0, rel=0.2)
    assert curve(plots, link).yData.max() > 0.1
    play(plots, prepared)
    assert curve(plots, link).yData[-1] == 0.0, "nothing touches it now"
    plots.remove_plot(TAXEL)
    assert plots.board.cell(TAXEL) is None


@pytest.mark.long
def test_plot_without_data_of_another_robot_shows_why(plots):
    plots.add_plot(PlotKey(PlotKind.JOINT, "tail"))
    plots.add_plot(PlotKey(PlotKind.TAXEL, "99999"))
    assert "this robot has no such joint" in content(plots, PlotKey(PlotKind.JOINT, "tail")).heading
    assert "this skin has no such taxel" in content(plots, PlotKey(PlotKind.TAXEL, "99999")).heading
    plots._redraw()


def drag(plots, key, target):
    """Drag the plot itself with the mouse."""
    surface = content(plots, key).plot.viewport()
    middle = surface.rect().center()
    left_press(surface, middle)
    for share in (0.3, 1.0):
        QTest.mouseMove(surface, middle + share * (surface.mapFromGlobal(target) - middle))
    assert plots.board._mark.isVisible(), "where it would go is marked"
    left_release(surface, surface.mapFromGlobal(target))
    assert not plots.board._mark.isVisible()
    QApplication.processEvents()


def test_plot_is_dragged_to_another_place(plots):
    assert plots.shown == ("force", "pressure", "ms")
    cell = plots.board.cell(PRESSURE)
    drag(plots, FORCE, cell.mapToGlobal(QPoint(cell.width() - 5, 20)))
    assert plots.shown == ("pressure", "force", "ms")
    assert cell.x() < plots.board.cell(FORCE).x()
    drag(plots, FORCE, plots.mapToGlobal(QPoint(plots.width() - 2, 20)))
    assert plots.shown == ("pressure", "ms", "force")
    cell = plots.board.cell(PRESSURE)
    drag(plots, FORCE, cell.mapToGlobal(QPoint(3, 20)))
    assert plots.shown == ("force", "pressure", "ms")


@pytest.mark.long
def test_double_click_enlarges_and_the_next_shows_all(plots, qtbot):
    surface = content(plots, FORCE).plot.viewport()
    with qtbot.waitSignal(plots.enlarged_changed):
        left_double_click(surface)
    assert plots.preferred_height(900, low=False) > 2 * USUAL_HEIGHT
    assert not plots.board.cell(PRESSURE).isVisible()
    left_double_click(surface)
    assert plots.board.cell(PRESSURE).isVisible()
    assert plots.board.enlarged is None


@pytest.mark.long
def test_separate_window_keeps_updating_while_the_others_are_hidden_and_returns(plots, prepared):
    plots.add_plot(TAXEL)
    plots.pop_out(TAXEL)
    (window,) = plots.findChildren(PlotWindow)
    window.setGeometry(40, 50, 400, 240)
    plots.hide()
    window.show()
    play(plots, prepared)
    assert len(curve(plots, TAXEL).xData) == 40
    kept = PlotChoice.from_text(plots.choice.to_text())
    assert kept.windows[TAXEL][2:] == (400, 240)
    plots.show()
    window.close()
    QApplication.processEvents()
    assert plots.board.cell(TAXEL).isVisible()
    assert not plots.board.windows
    assert plots.shown[-1] == "taxel:10"
    plots.choose(kept)
    assert plots.board.windows[TAXEL][2:] == (400, 240)


@pytest.mark.long
def test_plots_that_do_not_fit_scroll(plots, prepared):
    for number in range(7):
        plots.add_plot(joint(prepared, number))
    QApplication.processEvents()
    assert plots.board.horizontalScrollBar().maximum() > 0
    assert min(plots.board.cell(joint(prepared, number)).width() for number in range(7)) >= 140


@pytest.mark.long
def test_table_contains_the_shown_plots_with_simulated_time(plots, prepared):
    play(plots, prepared)
    plots.add_plot(joint(prepared, 3))
    rows = list(csv.DictReader(io.StringIO(plots.table())))
    assert {row["plot"] for row in rows} == {"Force", "Pressure", "Time per tick", joint(prepared, 3).title}
    mine = [row for row in rows if row["plot"] == joint(prepared, 3).title]
    assert [float(row["time_s"]) for row in mine] == pytest.approx(0.02 * np.arange(40))
    assert [float(row["value"]) for row in mine] == pytest.approx(-0.3 + 0.01 * np.arange(40))
    assert {row["unit"] for row in mine} == {"rad"}
    assert {row["plot"] for row in csv.DictReader(io.StringIO(plots.table((FORCE,))))} == {"Force"}


@pytest.mark.long
def test_theme_applies_to_added_plots(plots, prepared):
    plots.add_plot(joint(prepared, 3))
    plots.set_theme(LIGHT)
    assert LIGHT.quiet in content(plots, joint(prepared, 3)).heading
