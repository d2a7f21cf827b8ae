"""What the window's tests do to it: open it, begin again, let time pass, find skin to press, press it."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMessageBox

from tactile_maps.editing.document import MapDocument
from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.common.colours import DARK
from tactile_widgets.common.settings import Settings
from tactile_widgets.common.tool_kinds import BRUSH, POKE, SELECT_BOX
from tactile_widgets.plots.choice.plot_choice import PlotChoice
from tactile_widgets.views.layers import LAYERS, at_first
from tactile_widgets.window.main_window import MainWindow

SIZE = (1400, 900)


def open_window(folder, backends):
    """A window on the screen with nothing in it, whose settings are kept in ``folder``."""
    apply_theme(QApplication.instance(), DARK)
    made = MainWindow(Settings(folder / "window.ini"), backends=backends)
    made.resize(*SIZE)
    made.show()
    assert QTest.qWaitForWindowExposed(made)
    return made


def close_window(window):
    """Close it, whatever was edited."""
    window.presenters.map_files.give_up()
    window.close()
    window.deleteLater()


def begin_again(window, prepared, *, folded):
    """Show ``prepared`` from its start, with tool, brush, layers, theme, size and ``folded`` panels of a new window."""
    views = window.views
    for tool in (SELECT_BOX, POKE):  # another tool gives up what a hand still holds
        window.presenters.view.set_tool(tool)
    views.set_overlays(at_first(LAYERS))
    views.brush = BRUSH
    views.resize_brush(0)
    if window.theme is not DARK:
        window.set_theme("dark")
    window.resize(*SIZE)
    window.column.set_folded(folded)
    window.plots.choose(PlotChoice())
    if window.live.prepared.skin is prepared.skin:  # the window would go on with what was edited
        window.editor.open(MapDocument.of(prepared.map))
    window.live.show_prepared(prepared)
    window.presenters.map_files.end()
    window.presenters.map_files.begin(prepared, window.editor.document)
    window.activateWindow()  # a test may have made a window of its own, which took the keys
    window.notification_bar.hide()  # a recording that the scene ended was said to be saved
    QApplication.processEvents()


def window_facts(window):
    """What a test may leave behind in a window, by name."""
    views = window.views
    return {
        "state": window.presenters.state.state,
        "document": window.editor.history.names,
        "taxels": views.selection.taxels.tolist(),
        "overlays": views.overlays,
        "brush": views.brush,
        "scale": views.scale.maximum,
        "flat": views.robot.morph.share,
        "viewpoint": views.robot.display.actors.viewpoint.eye.tolist(),
        "size": window.size().toTuple(),
        "views": views.geometry().getRect(),
        "folded": window.column.folded,
        "plots": window.plots.choice,
        "windows": sum(widget.isVisible() for widget in QApplication.topLevelWidgets()),
        "message": window.notification_bar.isVisible(),
    }


def answer(window, button, question="leave"):
    """Answer a question, by default the one about unsaved edits, with a click."""
    (box,) = [box for box in window.findChildren(QMessageBox) if box.objectName() == question and box.isVisible()]
    QTest.mouseClick(box.button(button), Qt.MouseButton.LeftButton)
    QApplication.processEvents()


def run(window, seconds):
    """Let simulated time pass, and the window show it."""
    for _ in range(max(round(seconds / 0.2), 1)):
        window.live.runner.run_for(min(seconds, 0.2))
        window.live.pump()
        QApplication.processEvents()


def blow_up(live):
    """Let the physics diverge at the next tick, as real as it gets: the joints are as fast as no joint can be."""
    with live.runner.lock:
        live.runner.session._simulation._data.qvel[:] = 1e9
    live.runner.run_for(0.01)
    live.pump()
    assert live.runner.session.failure is not None


def visible_skin(window):
    """A place on the skin that the robot view shows unhidden, and its pixel there."""
    view = window.robot_view
    skin = window.live.prepared.skin
    for taxel in range(len(skin)):
        at = skin.taxel_point(taxel)
        pixel = view.pixel_of(at)
        near = [view.point_at(pixel + QPointF(x, y)) for x in (-4, 4) for y in (-4, 4)]
        # One that faces the eye, so that a pixel aside is little aside on the skin.
        if all(hit is not None and np.linalg.norm(skin.position(hit) - skin.position(at)) < 0.02 for hit in near):
            return at, pixel.toPoint()
    raise AssertionError("no taxel can be seen")


def press_map(window, taxel):
    view = window.map_view
    pixel = view.pixel_of(window.live.prepared.skin.taxel_point(taxel)).toPoint()
    QTest.mousePress(view.viewport(), Qt.MouseButton.LeftButton, pos=pixel)
    return pixel
