"""Drives a tool on a real map view: presses, moves and keys as real events, at places of the map; and the path tool's
settings.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_maps.editing.document import MapDocument
from tactile_maps.flattening.bijectivity import flipped
from tactile_maps.maps.build import build_map
from tactile_widgets.common.colours import DARK, PressureScale
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.tools.registry import PINS
from tests.support.surfaces import cap, frustum, sheet, skin_of
from tests.widgets.support.layered_map_view import layered_map_view

LEFT = Qt.MouseButton.LeftButton
NONE = Qt.KeyboardModifier.NoModifier
ALT = Qt.KeyboardModifier.AltModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier
TUBE = 0
SHEET = 1
CAP = 2
ROWS = 7  # vertices of a column of the sheet, which is 9 columns wide


def small_document() -> MapDocument:
    """A tube, a sheet and a cap."""
    surfaces = (frustum(around=16, along=6), sheet(8, 6), cap(1.2, rings=8))
    return MapDocument.of(build_map(skin_of(*surfaces, taxels=12)))


def open_editor(jobs, document) -> MapEditor:
    """An editor that takes edits, and remembers what it said in ``heard`` and all documents shown in ``seen``."""
    made = MapEditor(jobs)
    made.open(document)
    made.set_enabled(enabled=True)
    made.heard = []
    made.seen = []
    made.failed.connect(lambda text: made.heard.append(("failed", text)))
    made.notified.connect(lambda text: made.heard.append(("notified", text)))
    made.shown.connect(made.seen.append)
    return made


class MapViewDriver:
    """Shows what the editor shows; the left button is held from ``press`` to ``release``."""

    def __init__(self, qtbot, editor, tool, *, kind=PINS):
        self.editor = editor
        self.tool = tool
        self.view = layered_map_view(DARK, PressureScale())
        qtbot.addWidget(self.view)
        self.view.resize(900, 700)
        self.view.show_document(editor.document)
        self.view.show()
        qtbot.waitExposed(self.view)
        self.view.set_tool(kind)
        self.view.set_view_tool(tool)
        editor.shown.connect(lambda document: self.view.show_document(document, in_gesture=editor.gesture))
        self.view.setFocus()
        self.move(QPoint(1, 1))  # wherever another test left the pointer, the next move is one

    def pixel(self, point) -> QPoint:
        """The pixel of a map point (2,) [m]."""
        return QPoint(*self.view.map_to_pixels(np.asarray(point, float)[None])[0].round().astype(int).tolist())

    def point(self, pixel) -> np.ndarray:
        """The map point (2,) [m] of a pixel."""
        scene = self.view.scene_point(pixel.toPointF())
        return self.view.picture.shapes.frame.to_map(np.array([scene.x(), scene.y()]))

    def press(self, point, keys=NONE):
        """The left button down at a map point, the pointer already there."""
        self.move(point)
        QTest.mousePress(self.view.viewport(), LEFT, keys, self.pixel(point))

    def move(self, point):
        """The pointer to a map point, or to a pixel."""
        QTest.mouseMove(self.view.viewport(), point if isinstance(point, QPoint) else self.pixel(point))
        QApplication.processEvents()

    def release(self, point, keys=NONE):
        """The left button up."""
        pixel = point if isinstance(point, QPoint) else self.pixel(point)
        QTest.mouseRelease(self.view.viewport(), LEFT, keys, pixel)

    def click(self, point, keys=NONE):
        """Down and up at a map point."""
        self.press(point, keys)
        self.release(point, keys)

    def drag(self, start, end, *, steps=4):
        """A stroke from map point to map point."""
        self.press(start)
        for share in np.linspace(0, 1, steps + 1)[1:]:
            self.move(np.asarray(start) + share * (np.asarray(end) - start))
        self.release(end)

    def key(self, key, keys=NONE):
        """A key pressed in the view."""
        QTest.keyClick(self.view, key, keys)

    def picture(self):
        """Return a picture of the view."""
        return self.view.grab().toImage()


def middle(document, number) -> np.ndarray:
    """(2,) the middle of a patch's box on the map [m]."""
    return document.map.boxes[number].mean(axis=0)


def corner(document, vertex, number=SHEET) -> np.ndarray:
    """Return the position (2,) of a vertex of a patch's surface on the map [m]; the first of several."""
    return document.map.uv[number][document.charts[number].vertex_of == vertex][0]


def sheet_vertex(column, row) -> int:
    """A vertex of the sheet."""
    return column * ROWS + row


def flips(document) -> int:
    """Return the number of flipped triangles."""
    return sum(int(flipped(chart.plane, chart.faces).sum()) for chart in document.charts)


PIXEL = 1.5e-3
"""A little more than half a pixel of the view, across [m]."""


def set_path_kind(lead, kind):
    lead.show_settings(replace(lead.settings, path_kind=kind))


def path_in_force(lead):
    return np.array(lead.settings.path)
