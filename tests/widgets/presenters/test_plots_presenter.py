"""Plots in the real window: list, context menu, clicks on events, and stored choices."""

from __future__ import annotations

from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QContextMenuEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_maps.recording.player import open_recording
from tactile_widgets.common.settings import Settings
from tactile_widgets.panels.touch.events_panel import EventsPanel
from tactile_widgets.plots.choice.plot_choice import STANDARD, PlotChoice, PlotKey, PlotKind
from tests.widgets.support.mouse import left_click, left_release
from tests.widgets.support.window_driver import press_map, run

FORCE = STANDARD[0]
EVENTS = STANDARD[-1]
pytestmark = pytest.mark.qt_log_ignore("This plugin does not support")


@pytest.fixture
def window(window_again):
    """Window with the standard plots of the controller, restored afterwards."""
    yield window_again
    if window_again.presenters.plots.chooser is not None:
        window_again.presenters.plots.chooser.close()
    window_again.plots.choose(PlotChoice())
    window_again.live.replay.leave()
    if not window_again.action("whole_recording").isChecked():
        window_again.action("whole_recording").trigger()
    QApplication.processEvents()


def row(chooser, words):
    return next(item for item in chooser.list.findItems(words, Qt.MatchFlag.MatchExactly) if item.data(256))


def toggle(chooser, words, *, on_text=False):
    """Click the check box of a plot, or its text."""
    item = row(chooser, words)
    chooser.list.scrollToItem(item)
    box = chooser.list.visualItemRect(item)
    left_click(chooser.list.viewport(), QPoint(box.left() + (60 if on_text else 10), box.center().y()))


def test_plot_is_found_by_letters_and_shown(window):
    window.action("choose_plots").trigger()
    chooser = window.presenters.plots.chooser
    name = window.live.prepared.robot.joints[2].name.replace("_", " ")
    QTest.keyClicks(chooser.field, f"joint {name}")
    toggle(chooser, f"Joint {name}")
    chooser.field.clear()
    QTest.keyClicks(chooser.field, "17")
    toggle(chooser, "Taxel 17")
    chooser.field.clear()
    toggle(chooser, "Contact events")
    assert set(window.plots.shown) >= {PlotKey(PlotKind.JOINT, name.replace(" ", "_")).text, "taxel:17", "events"}
    assert not chooser.automatic.isChecked(), "a standard one was chosen"
    left_click(chooser.automatic, QPoint(8, chooser.automatic.height() // 2))
    assert "events" not in window.plots.shown
    toggle(chooser, "Taxel 17")
    assert "taxel:17" not in window.plots.shown
    again = PlotChoice.from_text(Settings(Path(window.settings._store.fileName())).plots)
    assert again == window.plots.choice, "kept at once"


def test_group_of_taxels_is_listed_and_can_be_removed(window):
    window.presenters.plots._plot_group((69, 70, 71), "palm")
    key = "group-force:palm=69-71"
    assert key in window.plots.shown
    window.action("choose_plots").trigger()
    chooser = window.presenters.plots.chooser
    assert row(chooser, "Force on palm").checkState() is Qt.CheckState.Checked
    toggle(chooser, "Force on palm")
    assert key not in window.plots.shown


def test_click_on_the_text_of_a_plot_shows_or_hides_it_once(window):
    window.action("choose_plots").trigger()
    chooser = window.presenters.plots.chooser
    name = window.live.prepared.robot.joints[2].name.replace("_", " ")
    key = PlotKey(PlotKind.JOINT, name.replace(" ", "_")).text
    for on_text, shown in ((True, True), (False, False), (False, True), (True, False)):
        toggle(chooser, f"Joint {name}", on_text=on_text)
        assert (key in window.plots.shown) == shown
        assert (row(chooser, f"Joint {name}").checkState() is Qt.CheckState.Checked) == shown
    before = window.plots.shown
    (heading,) = chooser.list.findItems("Joints", Qt.MatchFlag.MatchExactly)
    chooser.list.scrollToItem(heading)
    left_click(chooser.list.viewport(), chooser.list.visualItemRect(heading).center())
    assert window.plots.shown == before


def plot_menu(window, key):
    """Return the context menu of a plot."""
    surface = window.plots.board.cell(key).content.plot.viewport()
    place = surface.rect().center()
    event = QContextMenuEvent(QContextMenuEvent.Reason.Mouse, place, surface.mapToGlobal(place))
    QApplication.sendEvent(surface, event)
    return window.presenters.pointing.menu


def choose(menu, name):
    entry = menu.findChild(object, f"pointed-{name}")
    menu.close()
    entry.trigger()
    QApplication.processEvents()


def test_context_menu_of_a_plot_moves_enlarges_copies_and_hides_it(window):
    run(window, 0.1)
    names = [entry.objectName().removeprefix("pointed-") for entry in plot_menu(window, FORCE).actions()]
    assert names == ["enlarge", "pop-out", "later", "hide-plot", "save-plot", "figure", "copy"]
    choose(plot_menu(window, FORCE), "later")
    assert window.plots.shown[:2] == ("pressure", "force")
    choose(plot_menu(window, FORCE), "earlier")
    height = window.plots.height()
    choose(plot_menu(window, FORCE), "enlarge")
    assert window.plots.height() > 1.5 * height
    choose(plot_menu(window, FORCE), "enlarge")
    choose(plot_menu(window, FORCE), "copy")
    assert QApplication.clipboard().text().startswith("plot,series,unit,time_s,value\nForce,all contacts,N,")
    choose(plot_menu(window, FORCE), "pop-out")
    assert FORCE in window.plots.board.windows
    choose(plot_menu(window, FORCE), "pop-out")
    choose(plot_menu(window, FORCE), "hide-plot")
    assert "force" not in window.plots.shown


def test_layout_stores_the_shown_plots(window):
    window.plots.add_plot(EVENTS)
    window.panel_docks._save("events")
    window.action("reset_layout").trigger()
    assert "events" not in window.plots.shown
    window.panel_docks._take("events")
    assert "events" in window.plots.shown
    window.settings.delete_layout("events")


@pytest.mark.long
def test_click_on_an_event_shows_its_time_in_a_recording(window, tmp_path):
    window.live.recording.start(tmp_path / "touch.mcap")
    run(window, 0.2)
    pixel = press_map(window, 70)
    run(window, 0.6)
    left_release(window.map_view.viewport(), pixel)
    run(window, 0.4)
    window.live.recording.stop()
    window.live.show_player(open_recording(tmp_path / "touch.mcap"))
    assert not window.plots.isVisible(), "the curves of the whole recording are in their place"
    window.presenters.plots.plot(EVENTS)
    window.presenters.plots._plot_group((69, 70, 71), "palm")
    assert window.plots.isVisible()
    QApplication.processEvents()
    window.timeline.set_time(1.15)
    window.live.replay.seek(1.15)
    began = next(event.time for event in window.live.shown.recent if event.kind == "touch")
    past = window.live.replay.current.frames(range(0, window.live.replay.current.number + 1))
    window.plots.show_past(past)
    QApplication.processEvents()
    (force,) = window.plots._parts[PlotKey.parse("group-force:palm=69-71")].series()
    areas = window.live.prepared.skin.areas[69:72]
    assert max(force.values) > 0
    felt = [float(frame.pressures[69:72] @ areas) for frame in past]
    assert (force.values[-1], max(force.values)) == pytest.approx((felt[-1], max(felt)), rel=1e-5)
    strip = window.plots.board.cell(EVENTS).content
    x = strip._rows._x(began - window.live.shown.time)
    surface = strip._rows
    left_click(surface, QPointF(x, 16).toPoint())
    assert window.live.shown.time == pytest.approx(began, abs=0.011)
    assert window.timeline.playhead.time == pytest.approx(
        window.live.shown.time - window.live.replay.player.times[0], abs=0.011
    )
    window.timeline.go_to(1.1)
    events = window.column.get(EventsPanel)
    number = next(k for k, line in enumerate(events.events.items) if line.began == began)
    events.list.scrollTo(events.events.index(number))
    left_click(events.list.viewport(), events.list.visualRect(events.events.index(number)).center())
    assert window.live.shown.time == pytest.approx(began, abs=0.011)
