"""A real editor on a small real map, shown in the real view with a tool in the hand, and a mouse that holds keys."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QApplication

from tactile_maps.editing.document import MapDocument
from tactile_widgets.common.colours import DARK, PressureScale
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.jobs.executor import ProcessExecutor
from tactile_widgets.jobs.scene_jobs import SceneJobs
from tactile_widgets.tools.map_editing.arrange_tool import ArrangeTool
from tactile_widgets.tools.map_editing.transform_box import TransformBox
from tactile_widgets.tools.registry import ARRANGE
from tests.widgets.support.layered_map_view import layered_map_view

LEFT = Qt.MouseButton.LeftButton
NO_BUTTON = Qt.MouseButton.NoButton
NONE = Qt.KeyboardModifier.NoModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier
CONTROL = Qt.KeyboardModifier.ControlModifier


class Bench:
    """View, editor and tool, connected as in the window."""

    def __init__(self, qtbot, map_):
        self.view = layered_map_view(DARK, PressureScale(20.0))
        qtbot.addWidget(self.view)
        self.view.resize(640, 560)
        self.editor = MapEditor(SceneJobs(ProcessExecutor("prepare"), self.view), self.view)
        self.editor.shown.connect(self._on_shown)
        self.editor.open(MapDocument.of(map_))
        self.editor.set_enabled(enabled=True)
        self.tool = ArrangeTool(self.editor, self.view)
        self.view.set_tool(ARRANGE)
        self.view.set_view_tool(self.tool)
        self.failures = []
        self.editor.failed.connect(self.failures.append)
        self.view.show()
        qtbot.waitExposed(self.view)

    def _on_shown(self, document):
        self.view.show_document(document, in_gesture=self.editor.gesture)

    @property
    def document(self):
        return self.editor.document

    @property
    def steps(self):
        return self.editor.history.names[1:]

    def placement(self, number):
        return self.document.layout.placements[number]

    def pixels(self, points):
        """(k, 2) of map points [px]."""
        return self.view.map_to_pixels(np.atleast_2d(points))

    def middle(self, number):
        """Return the centre of a patch's box on the map [m]; it is inside the patch for the leaves."""
        return self.document.map.boxes[number].mean(axis=0)

    def over(self, number):
        """A pixel of a patch."""
        return self.pixels(self.middle(number))[0]

    def handle(self, number):
        """Return the position of a handle of the frame [px]."""
        frame = TransformBox.around(self.document, self.editor.selected)
        return self.pixels(frame.handles(self.view._pixel_size(self.view.picture.shapes.frame)))[number]

    def mouse(self, kind, pixel, keys=NONE):
        held = NO_BUTTON if kind is QEvent.Type.MouseButtonRelease else LEFT
        button = NO_BUTTON if kind is QEvent.Type.MouseMove else LEFT
        at = QPointF(*map(float, pixel))
        viewport = self.view.viewport()
        QApplication.sendEvent(viewport, QMouseEvent(kind, at, viewport.mapToGlobal(at), button, held, keys))

    def press(self, pixel, keys=NONE):
        self.mouse(QEvent.Type.MouseButtonPress, pixel, keys)

    def move(self, pixel, keys=NONE):
        self.mouse(QEvent.Type.MouseMove, pixel, keys)

    def release(self, pixel, keys=NONE):
        self.mouse(QEvent.Type.MouseButtonRelease, pixel, keys)

    def click(self, pixel, keys=NONE):
        self.press(pixel, keys)
        self.release(pixel, keys)

    def drag(self, start, by, keys=NONE):
        """Press, move in three steps; the button is still held."""
        self.press(start, NONE)
        for share in (0.3, 0.7, 1.0):
            self.move(np.asarray(start) + share * np.asarray(by), keys)
        return np.asarray(start) + by

    def picture(self):
        return self.view.grab().toImage()


def bent(document, number=0, share=0.1):
    """Another chart for a patch: sheared, so that no placement could do it."""
    charts = list(document.charts)
    chart = document.charts[number]
    charts[number] = replace(chart, plane=chart.plane @ np.array([[1.0, share], [0.0, 1.0]]))
    return replace(document, map=replace(document.map, charts=tuple(charts)))
