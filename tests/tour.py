"""Film of the tour for the guide: scripted mouse events on the real widgets.

``python -m tests.tour assets/tour.gif`` makes the film without a display; on the same machine it is always the same.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
from PIL import Image
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPen, QPolygonF
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget

from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepare import prepare
from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.common.colours import THEMES
from tactile_widgets.common.settings import BaseLayer
from tactile_widgets.common.tool_kinds import POKE
from tactile_widgets.tools.registry import ARRANGE, PINS
from tactile_widgets.window.application import make_application, picture_window
from tactile_widgets.window.main_window import MainWindow

SIZE = (1280, 800)
WIDTH = 880
FRAME_MS = 90
_LEFT = Qt.MouseButton.LeftButton
_ARROW = [(0, 0), (0, 17), (4, 13.5), (7, 20), (9.6, 18.8), (6.8, 12.6), (12, 12.4)]


class Film:
    """Film of a window with the mouse pointer drawn in. Mutable: frames are appended."""

    def __init__(self, window: MainWindow) -> None:
        self.window = window
        self.frames: list[Image.Image] = []
        self._hand = QPointF(0.6 * SIZE[0], 0.6 * SIZE[1])

    def pass_time(self, frames: int) -> None:
        """Record this number of frames of simulated time."""
        for _ in range(frames):
            self._shoot()

    def _shoot(self) -> None:
        window = self.window
        window.live.runner.run_for(1e-3 * FRAME_MS)  # type: ignore[union-attr]
        window.live.pump()
        window.robot_view.display.draw_now()
        QApplication.processEvents()
        image = window.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
        painter = QPainter(image)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.translate(self._hand)
        painter.setPen(QPen(QColor("#111418"), 1.2))
        painter.setBrush(QColor("white"))
        painter.drawPolygon(QPolygonF([QPointF(x, y) for x, y in _ARROW]))
        painter.end()
        rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), image.bytesPerLine())
        pixels = rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3)
        height = round(WIDTH * image.height() / image.width())
        self.frames.append(Image.fromarray(pixels).resize((WIDTH, height), Image.Resampling.LANCZOS))

    def go(self, widget: QWidget, pixel: QPoint, *, frames: int = 6, held: bool = False) -> None:
        """Move the pointer smoothly to a pixel of ``widget``; ``held`` with the button down."""
        goal = QPointF(widget.mapTo(self.window, pixel))
        for at in _eased(self._hand, goal, frames):
            self._hand = at
            if held:
                QTest.mouseMove(widget, widget.mapFrom(self.window, at.toPoint()))
            self._shoot()

    def drag(self, widget: QWidget, start: QPoint, *path: QPoint, frames: int = 10) -> None:
        """Press at ``start``, drag along ``path`` and release."""
        self.go(widget, start)
        QTest.mousePress(widget, _LEFT, pos=start)
        for pixel in path:
            self.go(widget, pixel, frames=frames, held=True)
        QTest.mouseRelease(widget, _LEFT, pos=path[-1])
        self.pass_time(3)

    def save(self, path: Path) -> None:
        """Write the film with one palette for all frames, so that unchanged parts do not flicker."""
        some = self.frames[:: max(len(self.frames) // 8, 1)]
        strip = Image.new("RGB", (WIDTH, sum(frame.height for frame in some)))
        for number, frame in enumerate(some):
            strip.paste(frame, (0, number * frame.height))
        palette = strip.quantize(255, method=Image.Quantize.MEDIANCUT)
        still = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in self.frames]
        still[0].save(path, save_all=True, append_images=still[1:], duration=FRAME_MS, loop=0, optimize=True)


def _eased(start: QPointF, end: QPointF, frames: int) -> Iterator[QPointF]:
    for share in np.linspace(0, 1, frames + 1)[1:]:
        yield start + (end - start) * float(share * share * (3 - 2 * share))


def play(film: Film) -> None:
    """Run all steps of the tour."""
    window = film.window
    # type: ignore[union-attr]
    skin = window.live.prepared.skin
    view = window.map_view
    viewport = view.viewport()

    def on_map(taxel: int, dx: int = 0, dy: int = 0) -> QPoint:
        return view.pixel_of(skin.taxel_point(taxel)).toPoint() + QPoint(dx, dy)

    def on_patch(patch: int, share: float) -> int:
        first = skin.first[patch]
        last = skin.first[patch + 1]
        return int(first + share * (last - first - 1))

    film.pass_time(4)
    film.drag(viewport, on_map(on_patch(1, 0.3)), on_map(on_patch(1, 0.3), 30, 30), on_map(on_patch(1, 0.3), 60, -10))
    window.presenters.view.set_tool(ARRANGE)
    film.drag(viewport, on_map(on_patch(2, 0.5)), on_map(on_patch(2, 0.5), 150, 20))
    window.presenters.view.set_tool(PINS)
    for share in (0.05, 0.5):
        film.go(viewport, on_map(on_patch(0, share)))
        QTest.mouseClick(viewport, _LEFT, pos=on_map(on_patch(0, share)))
    film.drag(viewport, on_map(on_patch(0, 0.9)), on_map(on_patch(0, 0.9), -30, -50))
    window.editor.select([1])
    window.action("propose_seam").trigger()
    film.pass_time(10)
    window.editor.accept()
    film.pass_time(6)
    window.editor.select(())
    window.action("repack").trigger()
    view.frame_all()
    film.pass_time(8)
    window.presenters.view.set_base_layer(BaseLayer.AREA)
    film.pass_time(10)
    window.presenters.view.set_base_layer(BaseLayer.CHECKER)
    film.pass_time(6)
    slider = window.robot_view.morph.slider
    for share in (*np.linspace(0, 1, 12), *[1.0] * 6, *np.linspace(1, 0, 12)):
        slider.setValue(round(slider.minimum() + float(share) * (slider.maximum() - slider.minimum())))
        film.pass_time(1)
    window.presenters.view.set_base_layer(BaseLayer.PRESSURE)
    for _ in range(len(window.editor.history.names) - 1):  # type: ignore[union-attr]
        window.action("undo").trigger()
        film.pass_time(3)
    view.frame_all()
    film.pass_time(6)


def main() -> None:
    """Film the tour into the file named on the command line."""
    application = make_application()
    apply_theme(application, THEMES["dark"])
    window = picture_window("dark", SIZE)
    try:
        window.live.show_prepared(prepare(load_scene("arm")))
        window.hint_bar.hide()
        window.presenters.view.set_tool(POKE)
        QApplication.processEvents()
        film = Film(window)
        play(film)
        film.save(Path(sys.argv[1]))
    finally:
        window.presenters.map_files.give_up()
        window.close()


if __name__ == "__main__":
    main()
