"""Panels in windows of their own: they live on there, come back where they were, and layouts are kept."""

from __future__ import annotations

import gc
import weakref
from pathlib import Path

import pytest
from PySide6.QtCore import QEvent, QPoint, Qt
from PySide6.QtGui import QAction, QContextMenuEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QApplication,
    QDockWidget,
    QInputDialog,
    QLabel,
    QMenu,
    QMessageBox,
    QPushButton,
    QToolButton,
)

from tactile_widgets.common.guide_window import GuidePlace
from tactile_widgets.common.mode import Mode
from tactile_widgets.common.number_field import NumberField
from tactile_widgets.common.settings import Settings
from tactile_widgets.panels.control.posture_panel import PosturePanel
from tactile_widgets.panels.model.accuracy_panel import AccuracyPanel
from tactile_widgets.panels.registry import PANELS
from tactile_widgets.panels.touch.contacts_panel import ContactsPanel
from tactile_widgets.session.backends import INLINE
from tests.widgets.support.mouse import left_click, left_release
from tests.widgets.support.window_driver import close_window, open_window, press_map, run

pytestmark = pytest.mark.qt_log_ignore("This plugin does not support")


@pytest.fixture
def window(window_again):
    """The module's window, with all panels in their column again."""
    yield window_again
    window_again.panel_docks.reset()
    window_again.settings.delete_layout("poking")
    QApplication.processEvents()


def undock(panel):
    """Undock a panel with the menu of its heading."""
    heading = panel._heading
    QApplication.sendEvent(
        heading, QContextMenuEvent(QContextMenuEvent.Reason.Mouse, QPoint(5, 5), heading.mapToGlobal(QPoint(5, 5)))
    )
    menu = panel.findChildren(QMenu)[-1]
    menu.findChild(QAction, "undock").trigger()
    menu.close()
    QApplication.processEvents()


def dock_of(window, panel):
    return window.findChild(QDockWidget, f"dock-{panel.objectName()}")


def order(window):
    QApplication.processEvents()
    return [panel.objectName() for panel in sorted(window.column, key=lambda panel: panel.y()) if panel.isVisible()]


def test_enlarged_plot_remains_after_its_panel_window_is_closed(window):
    panel = window.column.get(AccuracyPanel)
    undock(panel)
    panel.findChild(QPushButton, "accuracy-enlarge").click()
    window.panel_docks.reset()
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
    QApplication.processEvents()
    assert panel.board.isVisible()
    assert panel.board.window().objectName() == "accuracy-window"
    panel.board.window().close()
    assert panel.isAncestorOf(panel.board)


@pytest.mark.long
def test_undocked_panel_works_and_returns_to_its_place(window):
    panel = window.column.get(ContactsPanel)
    before = order(window)
    undock(panel)
    dock = dock_of(window, panel)
    assert dock.isFloating()
    assert panel.isVisible()
    pixel = press_map(window, 70)
    run(window, 0.3)
    assert "1 contact" in panel.findChild(QLabel, "contacts-summary").text()
    left_release(window.map_view.viewport(), pixel)
    dock.close()
    assert order(window) == before


def test_window_is_released_after_its_panels_returned(qapp, tmp_path, own_files):
    window = open_window(tmp_path, INLINE)
    for panel in window.column:
        window.panel_docks.toggle(panel)
        window.panel_docks.toggle(panel)
    kept = weakref.ref(window)
    close_window(window)
    del window, panel
    qapp.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
    gc.collect()
    assert kept() is None


def test_window_is_released_when_it_is_closed_before_its_next_layout(qapp, tmp_path, own_files):
    """Calls after the pending events are due: the height of the dock, and the place of a panel on its page."""
    window = open_window(tmp_path, INLINE)
    window.plots.board.enlarge(window.plots.board._shown[0])
    window.column.reveal(window.column.get(PosturePanel))
    kept = weakref.ref(window)
    close_window(window)
    del window
    qapp.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
    gc.collect()
    assert kept() is None


def test_layout_is_saved_and_applied_by_name(window):
    panel = window.column.get(ContactsPanel)
    undock(panel)
    window.panel_docks._save("poking")
    window.action("reset_layout").trigger()
    assert not panel.undocked
    menu = window.findChild(QMenu, "layouts")
    menu.aboutToShow.emit()
    (entry,) = menu.actions()
    assert entry.text() == "poking"
    entry.trigger()
    assert panel.undocked
    window.settings.delete_layout("poking")
    menu.aboutToShow.emit()
    assert [(item.text(), item.isEnabled()) for item in menu.actions()] == [("No saved layouts", False)]


def name_layout(window, text):
    """Save the layout under a name that is typed."""
    window.action("save_layout").trigger()
    box = window.findChild(QInputDialog, "layout-name")
    box.setTextValue(text)
    box.accept()
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)


def test_layout_is_replaced_only_after_a_question(window):
    window.action("delete_layout").trigger()
    assert "No layout is saved" in window.notification_bar.text
    name_layout(window, "  ")
    assert "its name is blank" in window.notification_bar.text
    assert not window.settings.layouts
    name_layout(window, "poking")
    undock(window.column.get(ContactsPanel))
    for answer, undocked in (("Cancel", ()), ("Replace", ("contacts-panel",))):
        name_layout(window, " poking ")
        (box,) = window.findChildren(QMessageBox, "layout-replaced")
        next(button for button in box.buttons() if button.text().strip("&") == answer).click()
        QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
        assert window.settings.layouts["poking"].undocked == undocked


def test_undocked_panel_keeps_its_keys_and_returns_the_focus(window, qtbot):
    def focus(control):
        dock.activateWindow()
        control.setFocus()
        qtbot.waitUntil(lambda: QApplication.focusWidget() is control)

    def view_has_keys():
        return QApplication.focusWidget() is window.map_view

    window.map_view.setFocus()
    panel = window.column["controller"]
    undock(panel)
    dock = dock_of(window, panel)
    focus(panel._buttons["hold_force"])
    left_click(panel._buttons["hold_force"])
    qtbot.waitUntil(view_has_keys)
    QTest.keyClick(QApplication.focusWidget(), Qt.Key.Key_Space)
    assert window.live.mode is Mode.PAUSED
    window.action("pause").trigger()
    run(window, 0.1)
    tick = window.live.runner.session.frame.tick
    slider = next(one._slider for one in panel.sliders.by_name.values() if one._slider.isVisible())
    focus(slider)
    QTest.keyClick(slider, Qt.Key.Key_Backspace)
    assert window.live.runner.session.frame.tick >= tick, "the scene is not reset"
    QTest.keyClick(slider, Qt.Key.Key_Escape)
    qtbot.waitUntil(view_has_keys)


def test_layout_stores_the_optional_views(window):
    window.action("contact_inset").trigger()
    window.action("second_view").trigger()
    window.panel_docks._save("poking")
    window.action("reset_layout").trigger()
    assert window.more_views.added == ()
    assert not window.action("contact_inset").isChecked()
    kept = Settings(Path(window.settings._store.fileName())).layouts["poking"]
    window.panel_docks.arrange(kept)
    QApplication.processEvents()
    assert window.more_views.added == ("second", "inset")
    assert window.more_views.second.isVisible()
    assert window.action("second_view").isChecked()


def test_layout_hides_docks_and_unchecks_their_actions(window):
    window.action("plots").trigger()
    hidden = window.panel_docks.layout
    window.action("plots").trigger()
    assert window.action("plots").isChecked()
    window.panel_docks.arrange(hidden)
    assert not window.action("plots").isChecked()
    window.action("plots").trigger()
    assert not window.bottom.isHidden()


@pytest.mark.long
def test_every_panel_has_a_guide_heading(window):
    asked = []
    window.column.help_requested.connect(asked.append)
    window.column["quality"].findChild(QToolButton, "quality-panel-help").click()
    assert asked == [GuidePlace("maps", "Map quality")]
    guide = window._commands._guide
    for spec in PANELS:
        window._commands.show_panel_guide(spec.guide)
        assert guide.source().fileName() == f"{spec.guide.page}.md"
        if spec.guide.heading:
            block = guide.document().begin()
            while block.isValid() and block.text() != spec.guide.heading:
                block = block.next()
            assert block.isValid(), spec.guide
    window._commands.show_panel_guide(GuidePlace("maps", "Map quality"))
    assert guide.verticalScrollBar().value() > 0
    guide.close()
    guide.deleteLater()
    window._commands._guide = None


def test_text_in_an_undocked_panel_is_applied_before_closing(new_window):
    panel = new_window.column.get(PosturePanel)
    panel.set_folded(False)
    undock(panel)
    panel.window().activateWindow()
    slider = panel.sliders[0]
    values = []
    slider.value_changed.connect(values.append)
    field = slider.findChild(NumberField)
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, "12")
    assert not values
    new_window.close()
    assert values == [12.0]
