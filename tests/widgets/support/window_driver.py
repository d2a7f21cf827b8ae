"""Steps of tests with a window: open it, reset it, advance the simulation, find visible skin, press it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from PySide6.QtCore import QMimeData, QPointF, Qt, QUrl
from PySide6.QtGui import QDropEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMessageBox, QToolButton, QWidget

from tactile_maps.editing.document import MapDocument
from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.common.colours import DARK
from tactile_widgets.common.settings import Settings
from tactile_widgets.common.tool_kinds import BRUSH, POKE, SELECT_BOX
from tactile_widgets.panels.registry import PanelTab
from tactile_widgets.plots.choice.plot_choice import PlotChoice
from tactile_widgets.views.layers import LAYERS, at_first
from tactile_widgets.window.main_window import MainWindow
from tests.widgets.support.mouse import left_click, left_press

SIZE = (1400, 900)


def open_window(folder, backends):
    """Return an empty visible window with its settings in ``folder``."""
    apply_theme(QApplication.instance(), DARK)
    made = MainWindow(Settings(folder / "window.ini"), backends=backends)
    made.resize(*SIZE)
    made.show()
    assert QTest.qWaitForWindowExposed(made)
    return made


def close_window(window):
    """Close a window and discard its unsaved edits."""
    window.presenters.map_files.give_up()
    window.close()
    window.deleteLater()


def begin_again(window, prepared, *, folded):
    """Restart ``prepared`` with tool, brush, layers, theme, size, settings and ``folded`` panels of a new window."""
    window.context.dialogs.remember_saved()  # files of the previous test
    window.settings._store.clear()
    views = window.views
    for tool in (SELECT_BOX, POKE):  # a change of the tool cancels what the previous one had begun
        window.presenters.view.set_tool(tool)
    views.set_overlays(at_first(LAYERS))
    views.brush = BRUSH
    views.resize_brush(0)
    if window.theme is not DARK:
        window.set_theme("dark")
    window.resize(*SIZE)
    window.column.set_folded(folded)
    window.column.show_tab(PanelTab.TOUCH)
    window.plots.choose(PlotChoice())
    if window.live.prepared.skin is prepared.skin:  # the window keeps edits of the same skin
        window.editor.open(MapDocument.of(prepared.map))
    window.live.show_prepared(prepared)
    window.presenters.map_files.end()
    window.presenters.map_files.begin(prepared, window.editor.document)
    activate(window)
    window.notification_bar.clear()  # it may report that the end of the scene completed a recording
    QApplication.processEvents()  # hides the row of the timeline
    window.resizeDocks([window.bottom], [1], Qt.Orientation.Vertical)  # as low as its content; a layout keeps it high
    QApplication.processEvents()


def activate(window):
    """Make a visible window the active one."""
    if QApplication.activeWindow() is None:
        # After a floating window was deleted, Qt has no active window but keeps the focus window, so that activating
        # that one does nothing: activate another one first.
        other = QWidget()
        other.show()
        other.activateWindow()
        QApplication.processEvents()
        other.close()
        other.deleteLater()
    window.activateWindow()
    QApplication.processEvents()


def window_facts(window):
    """Return properties that a test may leave changed in a window, by name."""
    views = window.views
    return {
        "state": replace(window.presenters.state.state, has_script=False),  # modules have scenes with and without
        "document": window.editor.history.names,
        "taxels": views.selection.taxels.tolist(),
        "overlays": views.overlays,
        "brush": views.brush,
        "scale": views.scale.maximum,
        "flat": views.robot.morph.share,
        "framed": views.robot.display.framed,
        "size": window.size().toTuple(),
        "views": views.geometry().getRect(),
        "folded": window.column.folded,
        "tab": window.column.tab,
        "plots": window.plots.choice,
        "windows": sum(widget.isVisible() for widget in QApplication.topLevelWidgets()),
        "message": window.notification_bar.isVisible(),
    }


def answer(window, button, question="leave"):
    """Click a button of a question, by default of the one about unsaved edits."""
    (box,) = [box for box in window.findChildren(QMessageBox) if box.objectName() == question and box.isVisible()]
    left_click(box.button(button))
    QApplication.processEvents()


def kept_documents(window):
    """Return the documents that were left by changes of the skin, and that Undo or Redo shows again."""
    return [step.kept for step in window.presenters.tools.skin_steps._steps if step.kept is not None]


def run(window, seconds):
    """Advance the simulation, and show the result."""
    for _ in range(max(round(seconds / 0.2), 1)):
        window.live.runner.run_for(min(seconds, 0.2))
        window.live.pump()
        QApplication.processEvents()


def cancel(window):
    """Press Cancel next to the progress in the status line."""
    left_click(window.loading_bar.findChild(QToolButton, "loading-cancel"))


def record_run(window, path, seconds):
    """Record the next ``seconds`` of the session."""
    window.live.recording.start(path)
    run(window, seconds)
    window.live.recording.stop()


def replay_run(window, path, seconds):
    """Record the next ``seconds`` of the session, and replay them."""
    record_run(window, path, seconds)
    window.live.open_recording(path)


def drop(window, *paths):
    """Drop files on the window."""
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
    left = Qt.MouseButton.LeftButton
    none = Qt.KeyboardModifier.NoModifier
    window.dropEvent(QDropEvent(QPointF(5, 5), Qt.DropAction.CopyAction, data, left, none))


def choose_effect(window, key, value):
    """Choose an effect in the panel."""
    box = window.column["effects"].lines[key].box
    box.activated.emit(next(k for k in range(box.count()) if box.itemData(k) == value))


def click_remedy(window, text):
    """Click the button of the message with this text."""
    buttons = window.notification_bar.findChildren(QToolButton)
    (button,) = [button for button in buttons if button.text() == text and button.isVisible()]
    left_click(button)


def blow_up(live):
    """Make the physics diverge at the next tick, by impossibly fast joints."""
    with live.runner.lock:
        live.runner.session._simulation._data.qvel[:] = 1e9
    live.runner.run_for(0.01)
    live.pump()
    assert live.runner.session.failure is not None


def visible_skin(window):
    """Return a skin location that is visible in the robot view, and its pixel."""
    view = window.robot_view
    skin = window.live.prepared.skin
    for taxel in range(len(skin)):
        at = skin.taxel_point(taxel)
        pixel = view.pixel_of(at)
        near = [view.point_at(pixel + QPointF(x, y)) for x in (-4, 4) for y in (-4, 4)]
        # One that faces the camera, so that neighbouring pixels are close on the skin.
        if all(hit is not None and np.linalg.norm(skin.position(hit) - skin.position(at)) < 0.02 for hit in near):
            return at, pixel.toPoint()
    raise AssertionError("no taxel is visible")


def press_map(window, taxel):
    view = window.map_view
    pixel = view.pixel_of(window.live.prepared.skin.taxel_point(taxel)).toPoint()
    left_press(view.viewport(), pixel)
    return pixel
