"""Live plots of a controller with a task: response, bounds, limits, and times of changed settings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pyqtgraph as pg
import pytest
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QApplication, QLabel

from tactile_maps.control.motion.command import ControlSettings, TaskReport
from tactile_maps.control.motion.joint_impedance import MAX_JOINT_SPEED
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.robots.model.robot import Joint
from tactile_widgets.common.colours import DARK, LIGHT
from tactile_widgets.common.tool_kinds import SelectionMode
from tactile_widgets.document.taxel_selection import SelectionUpdate, TaxelSelection
from tactile_widgets.plots.live_plots import MIN_PLOT_WIDTH, LivePlots
from tactile_widgets.plots.traces.trace_plots import AXIS_END, AXIS_START, TOLERANCE, TracePlot
from tests.widgets.support.samples import touched
from tests.widgets.support.snapshots import pixels

pytestmark = pytest.mark.long

FOLLOW = ControlSettings(controller="hybrid", task="follow_path")
KEEP = ControlSettings(controller="qp", task="keep_force")
NAMES = ("force", "pressure", "ms", "error", "speed")


@pytest.fixture
def plots(qtbot):
    plots = LivePlots(DARK)
    qtbot.addWidget(plots)
    plots.resize(1300, 180)
    plots.show()
    qtbot.waitExposed(plots)
    return plots


def plot(plots, name) -> pg.PlotItem:
    return plots.findChildren(pg.PlotWidget)[NAMES.index(name)].getPlotItem()


def curve(plots, name, ink):
    """The drawn curve of that ink."""
    for item in plot(plots, name).listDataItems():
        drawn = item.isVisible() and item.xData is not None and len(item.xData)
        if drawn and QColor(pg.mkPen(item.opts["pen"]).color()).name() == ink:
            return item
    return None


def level(plots, name):
    """Return the values of the dashed bounds."""
    return [line.value() for line in plot(plots, name).items if isinstance(line, pg.InfiniteLine) and line.angle == 0]


def marks(plots, name):
    lines = [line for line in plot(plots, name).items if isinstance(line, pg.InfiniteLine) and line.angle == 90]
    return sorted(line.value() for line in lines if line.isVisible())


JOINT_LIMIT = Limit(LimitKind.JOINT_LIMIT)


def frame_at(prepared, time, *, error=0.002, goal=3.0, speed=0.4, limits=()):
    report = TaskReport(error=error, force_goal=goal, energy=0.1, tank=0.9)
    frame = touched(prepared.map, [10], tick=round(200 * time), time=time)
    return replace(frame, velocity=np.array([0.1, -speed]), task=report, why_limited=limits)


def play(plots, prepared, times, **what):
    for time in times:
        plots.show_frame(frame_at(prepared, time, **what))
    plots._redraw()


@pytest.mark.parametrize(
    ("settings", "shown"),
    [
        (ControlSettings(), ("force", "pressure", "ms")),
        (ControlSettings(controller="hold_force"), ("force", "limits", "pressure", "ms")),
        (KEEP, ("force", "speed", "limits", "pressure", "ms")),
        (FOLLOW, ("force", "error", "speed", "limits", "ms")),
        (replace(FOLLOW, controller="parallel", task="retreat"), ("force", "speed", "limits", "pressure", "ms")),
    ],
)
def test_controller_determines_the_shown_plots(plots, settings, shown):
    plots.show_settings(settings)
    assert plots.shown == shown


def test_time_plot_is_hidden_first_if_there_is_no_room(plots):
    plots.show_settings(FOLLOW)
    plots.resize(5 * MIN_PLOT_WIDTH - 10, 150)
    assert plots.shown == ("force", "error", "speed", "limits")
    plots.resize(5 * MIN_PLOT_WIDTH + 10, 150)
    assert "ms" in plots.shown
    plots.resize(300, 900)
    assert "ms" in plots.shown, "one under the other there is room"


def test_pressure_plot_stays_while_taxels_are_selected(plots, prepared):
    selection = TaxelSelection()
    selection.reset(len(prepared.skin))
    plots.follow(selection)
    plots.show_settings(FOLLOW)
    assert "pressure" not in plots.shown
    selection.take(SelectionUpdate(np.array([10]), SelectionMode.REPLACE))
    assert "pressure" in plots.shown
    selection.clear()
    assert "pressure" not in plots.shown


def test_error_is_drawn_in_millimetres_with_its_tolerance(plots, prepared):
    plots.show_settings(FOLLOW)
    play(plots, prepared, np.arange(30) * 0.02, error=0.002)
    drawn = curve(plots, "error", QColor(DARK.text).name())
    assert drawn.yData == pytest.approx(2.0)
    assert level(plots, "error") == [pytest.approx(1e3 * TOLERANCE)]
    assert "tolerance 5" in plots.findChildren(TracePlot)[NAMES.index("error")].heading.replace("&nbsp;", " ")


def test_missing_error_leaves_a_gap(plots, prepared):
    plots.show_settings(FOLLOW)
    play(plots, prepared, [0.0, 0.1])
    play(plots, prepared, [0.2, 0.3], error=None)
    drawn = curve(plots, "error", QColor(DARK.text).name())
    assert list(np.isfinite(drawn.yData)) == [True, True, False, False]


def test_fastest_joint_is_drawn_with_its_limit(plots, prepared):
    plots.show_settings(KEEP)
    play(plots, prepared, [0.0, 0.1], speed=0.7)
    assert curve(plots, "speed", QColor(DARK.text).name()).yData == pytest.approx(0.7)
    assert level(plots, "speed") == [MAX_JOINT_SPEED]
    low, high = plot(plots, "speed").viewRange()[1]
    assert low <= 0 < MAX_JOINT_SPEED < high


def test_slides_and_hinges_are_drawn_relative_to_their_limits(plots, prepared):
    first = prepared.robot.joints[0]
    joints = (Joint("lift", 0.0, 0.4, slide=True, max_speed=0.07), Joint("rail", 0.0, 1.0, slide=True), first)
    plots.show_settings(KEEP)
    for count, speeds, unit, bound, value in (
        (3, [0.035, 0.05, -0.3], "% of limit", 100.0, 50.0),
        (1, [0.05], "m/s", 0.07, 0.05),
    ):
        robot = replace(prepared.robot, joints=joints[:count])
        plots.show_prepared(replace(prepared, robot=robot))
        for time in (0.0, 0.1):
            plots.show_frame(replace(frame_at(prepared, time), velocity=np.array(speeds)))
        plots._redraw()
        assert curve(plots, "speed", QColor(DARK.text).name()).yData == pytest.approx(value)
        assert level(plots, "speed") == [bound]
        assert f"Max joint speed ({unit})" in plots.findChildren(TracePlot)[NAMES.index("speed")].heading


def test_goal_of_the_task_is_drawn_including_steps(plots, prepared):
    plots.show_settings(KEEP)
    play(plots, prepared, [0.0, 0.1], goal=3.0)
    play(plots, prepared, [0.2, 0.3], goal=6.0)
    assert list(curve(plots, "force", QColor(DARK.intent).name()).yData) == [3, 3, 6, 6]
    plots.show_settings(replace(KEEP, controller="impedance"))
    play(plots, prepared, [0.4], goal=None)
    assert np.isnan(curve(plots, "force", QColor(DARK.intent).name()).yData[-1])


def test_changed_settings_are_marked_by_a_moving_line_in_every_plot(plots, prepared):
    plots.show_settings(FOLLOW)
    play(plots, prepared, [1.0, 2.0])
    assert marks(plots, "force") == []
    plots.show_settings(replace(FOLLOW, force_gain=0.02))
    play(plots, prepared, [3.5])
    for name in ("force", "error", "speed", "ms"):
        assert marks(plots, name) == pytest.approx([-1.5])
    plots.show_settings(replace(FOLLOW, force_gain=0.02))
    play(plots, prepared, [4.0])
    assert marks(plots, "force") == pytest.approx([-2.0]), "the same again is no change"
    play(plots, prepared, [8.0, 12.5])
    assert marks(plots, "force") == []


def limits_words(plots):
    return plots._strip.heading


def test_limits_are_listed_and_counted(plots, prepared):
    plots.show_settings(FOLLOW)
    play(plots, prepared, [0.0])
    assert limits_words(plots) == "Limits: none in the last 10\u202fs"
    play(plots, prepared, [0.1, 0.2], limits=(JOINT_LIMIT, Limit(LimitKind.JOINT_SPEED)))
    assert limits_words(plots) == "Limits, 2 now"
    play(plots, prepared, [0.3])
    assert limits_words(plots) == "Limits"
    assert "joint limit, joint speed" in plots._strip.accessibleName()
    assert plots._strip.toolTip() == "Joint limit\nJoint speed"


def test_current_limits_have_room_before_ended_ones(plots, prepared):
    ended = [Limit(kind) for kind in LimitKind if not kind.stops and kind is not LimitKind.JOINT_LIMIT]
    plots.show_settings(FOLLOW)
    play(plots, prepared, [0.1], limits=tuple(ended))
    play(plots, prepared, [0.2, 0.3], limits=(JOINT_LIMIT,))
    shown = [row.name for row in plots._strip._rows._with_room()]
    assert 1 < len(shown) < len(ended)
    assert "joint limit" in shown


def test_strip_draws_limits_at_their_times_and_counts_those_that_do_not_fit(plots, prepared):
    plots.show_settings(FOLLOW)
    play(plots, prepared, [0.0])
    QApplication.processEvents()
    empty = plots._strip.grab().toImage()
    for time in np.arange(0.1, 2.0, 0.1):
        play(plots, prepared, [time], limits=(JOINT_LIMIT,))
    QApplication.processEvents()
    one = plots._strip.grab().toImage()
    assert not amber(empty).any()
    across = np.flatnonzero(amber(one).any(axis=0))
    assert across[-1] - across[0] == pytest.approx(one.width() * 1.8 / (AXIS_END - AXIS_START), abs=6)
    assert across[-1] < one.width() - 5, "now is not at the very edge"
    many = tuple(Limit(kind) for kind in list(LimitKind)[:12])
    play(plots, prepared, [2.1], limits=many)
    QApplication.processEvents()
    assert plots._strip.grab().toImage() != one


def amber(image):
    """(h, w) which pixels have the colour of a limit."""
    colour = QColor(DARK.warning)
    return (pixels(image) == [colour.red(), colour.green(), colour.blue()]).all(axis=2)


def test_hidden_plots_are_not_drawn(plots, prepared):
    plots.show_settings(ControlSettings())
    play(plots, prepared, [0.0, 0.1])
    assert curve(plots, "error", QColor(DARK.text).name()) is None
    plots.show_settings(FOLLOW)
    assert len(curve(plots, "error", QColor(DARK.text).name()).yData) == 2, "but they have kept everything"


def test_clear_discards_the_response(plots, prepared):
    plots.show_settings(FOLLOW)
    play(plots, prepared, [0.0, 0.1], limits=(JOINT_LIMIT,))
    plots.show_settings(replace(FOLLOW, force_gain=0.02))
    plots.clear()
    assert curve(plots, "error", QColor(DARK.text).name()) is None
    assert marks(plots, "force") == []
    assert "none" in limits_words(plots)


def test_theme_is_applied(plots, prepared):
    plots.show_settings(FOLLOW)
    play(plots, prepared, [0.0, 0.1], limits=(JOINT_LIMIT,))
    dark = plots.grab().toImage()
    plots.set_theme(LIGHT)
    assert plots.grab().toImage() != dark
    assert curve(plots, "speed", QColor(LIGHT.text).name()) is not None
    said = [label.text() + label.styleSheet() for label in plots.findChildren(QLabel) if label.isVisible()]
    assert [words for words in said if LIGHT.quiet not in words] == []
