"""Widgets that show a PyVista plotter, with and without OpenGL, and the scheduler of their pictures.

Decision: ``pyvistaqt.QtInteractor`` alone does not suffice. Without a display it crashes the process, and on software
OpenGL it draws each picture twice. ``ImageCanvas`` renders off screen and paints the pixels: it works without an X
server and is faster on software OpenGL. ``OpenGLCanvas`` needs no read-back on graphics hardware.

``RenderScheduler`` draws after pending events, at most half of the time, and once more at a higher resolution when the
picture stays.
"""

from __future__ import annotations

import logging
import os
import sys
import time
from collections.abc import Callable
from typing import Any, Protocol

import pyvista as pv
from PySide6.QtCore import QObject, Qt, QTimer, Signal
from PySide6.QtGui import QGuiApplication, QImage, QOffscreenSurface, QOpenGLContext, QPainter, QPaintEvent
from PySide6.QtWidgets import QWidget
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

from tactile_maps.core.errors import DisplayError

# Mesa writes its shader cache through a memory map: on a full disk, the system ends the process with SIGBUS, at the
# start or later. Without the cache, the start takes the same time within 0.5 s.
os.environ.setdefault("MESA_SHADER_CACHE_DISABLE", "true")
# PyVista imports matplotlib, which warns on the terminal where it cannot store its list of fonts.
for name in ("matplotlib", "matplotlib.font_manager"):
    logging.getLogger(name).setLevel(logging.ERROR)
if sys.platform == "linux":
    # Off-screen windows use EGL, which does not look for an X server and warn without one.
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

pv.global_theme.multi_samples = 1  # 4 samples cost four to five times the frame on software OpenGL


class Canvas(Protocol):
    """Widget with a plotter.

    Attributes:
        plotter: The plotter.
        widget: Widget that shows it.
        in_software: Whether rendering is done in software, so that the time depends on the number of triangles.
    """

    plotter: Any
    widget: QWidget
    in_software: bool

    def draw(self, *, quality: float = 1.0) -> None:
        """Render now, at ``quality`` times the display's resolution if the canvas can."""

    def close_plotter(self) -> None:
        """Release the render window; the widget draws nothing after this."""


class ImageCanvas(QWidget):
    """Canvas that renders off screen and paints the picture; works on every platform of Qt."""

    in_software = True

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.plotter: Any = pv.Plotter(off_screen=True, window_size=(64, 64), lighting="none")
        self.widget: QWidget = self
        self._pixels = vtkUnsignedCharArray()
        self._image: QImage | None = None
        self._closed = False
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setMouseTracking(True)

    def draw(self, *, quality: float = 1.0) -> None:
        """Render at ``quality`` times the widget's size in device pixels, and repaint."""
        if self._closed:
            return
        ratio = self.devicePixelRatioF() * quality
        width = max(round(self.width() * ratio), 1)
        height = max(round(self.height() * ratio), 1)
        window = self.plotter.render_window
        if tuple(window.GetSize()) != (width, height):
            window.SetSize(width, height)
        window.Render()
        window.GetRGBACharPixelData(0, 0, width - 1, height - 1, 0, self._pixels)
        rows = vtk_to_numpy(self._pixels).reshape(height, width, 4)
        self._rows = rows[::-1].tobytes()  # upper row first; kept, because the image only points to it
        self._image = QImage(self._rows, width, height, 4 * width, QImage.Format.Format_RGBX8888)
        self.update()

    def close_plotter(self) -> None:
        """Release the render window."""
        if not self._closed:
            self._closed = True
            self.plotter.close()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint the latest picture, or a plain background."""
        painter = QPainter(self)
        if self._image is None:
            painter.fillRect(self.rect(), self.palette().base())
        else:
            painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
            painter.drawImage(self.rect(), self._image)
        painter.end()


class OpenGLCanvas:
    """Canvas with ``pyvistaqt.QtInteractor`` on a display with OpenGL; its mouse handling is not used."""

    in_software = False

    def __init__(self, parent: QWidget | None = None) -> None:
        from pyvistaqt import QtInteractor

        self.plotter: Any = QtInteractor(parent, auto_update=False, lighting="none", multi_samples=1)
        self.widget: QWidget = self.plotter
        self.widget.setMouseTracking(True)
        self.widget.setAcceptDrops(False)  # it would load dropped files itself

    def draw(self, *, quality: float = 1.0) -> None:
        """Request one paint at the display's resolution; ``render`` would render twice."""
        self.plotter.update()

    def close_plotter(self) -> None:
        """Release the render window."""
        self.plotter.close()


def make_canvas(parent: QWidget | None = None) -> Canvas:
    """Make the canvas for this display; ``TACTILE_MAPS_CANVAS`` = ``image`` or ``opengl`` overrides the choice.

    Raises:
        DisplayError: The variable has another value.
    """
    choice = os.environ.get("TACTILE_MAPS_CANVAS", "")
    if choice not in ("", "image", "opengl"):
        raise DisplayError(
            "unknown canvas",
            place="TACTILE_MAPS_CANVAS",
            value=choice,
            remedy="Set it to image or opengl, or unset it",
        )
    if choice == "opengl" or (choice != "image" and _has_hardware_opengl()):
        return OpenGLCanvas(parent)
    return ImageCanvas(parent)


def _has_hardware_opengl() -> bool:
    """Whether Qt can make an OpenGL context on graphics hardware here."""
    if QGuiApplication.platformName() not in ("xcb", "wayland", "windows", "cocoa"):
        return False
    surface = QOffscreenSurface()
    context = QOpenGLContext()
    surface.create()
    if not (surface.isValid() and context.create() and context.makeCurrent(surface)):
        return False
    renderer = _renderer_name(context)
    context.doneCurrent()
    return not any(word in renderer.lower() for word in ("llvmpipe", "softpipe", "swrast", "software"))


def _renderer_name(context: QOpenGLContext) -> str:
    functions = context.functions()
    return str(functions.glGetString(0x1F01)) if functions is not None else "software"  # GL_RENDERER


SHORTEST_WAIT_MS = 15.0
REST_MS = 150
"""Time after the pause between two pictures from which an unchanged picture is drawn again at twice the resolution,
which smooths its edges."""
HALF_RESOLUTION_FROM_MS = 25.0
"""Drawing time above which pictures are drawn at half the resolution while the view is turned."""
HALF_RESOLUTION_IN_A_ROW_FROM_MS = 40.0
"""Drawing time above which pictures that follow each other are drawn at half the resolution, until nothing changes."""
_IN_A_ROW = 3
"""Number of pictures from which they follow each other."""
_ROW_MS = 500.0
"""Longest time between two pictures that follow each other, while a picture at rest is not due [ms]."""
REDRAW_UP_TO_MS = 60.0
"""Drawing time above which pictures are not drawn again at rest."""


class RenderScheduler(QObject):
    """Draws a canvas soon after requests; many requests become one picture.

    The next picture waits for as long as the previous one took, so that drawing uses at most half of the time.

    Args:
        canvas: Canvas to draw.
        parent: Qt parent.
        clock: Clock [s].

    Attributes:
        shortest_ms: Minimum time between two pictures [ms].
    """

    due = Signal(float)
    """A picture is about to be drawn, at this multiple of the display's resolution: update the actors."""
    drawn = Signal(float)
    """A picture was drawn; the time for it and for the update of the actors [ms]."""

    def __init__(self, canvas: Canvas, parent: QObject, *, clock: Callable[[], float] = time.perf_counter) -> None:
        super().__init__(parent)
        self._canvas = canvas
        self._clock = clock
        self.shortest_ms = SHORTEST_WAIT_MS
        self._last_ms = 0.0  # at full resolution
        self._taken_ms = 0.0
        self._moving = False
        self._in_a_row = 0
        self._ended = -1e9
        self._soon = QTimer(self)
        self._rest = QTimer(self)
        for timer, slot in ((self._soon, self._on_soon), (self._rest, self._on_rest)):
            timer.setSingleShot(True)
            timer.timeout.connect(slot)

    @property
    def waiting(self) -> bool:
        """Whether a picture is pending."""
        return self._soon.isActive() or self._rest.isActive()

    def rest_ms(self, ahead_ms: float = 0.0) -> float:
        """Return the remaining pause before the next picture [ms]; with it drawing takes at most half of the time.

        Args:
            ahead_ms: Time by which the pause may end early [ms], at most half of the pause.
        """
        if self._soon.isActive():
            return self.shortest_ms
        pause = self._pause_ms
        return max(self._ended + pause - min(ahead_ms, pause / 2) - 1e3 * self._clock(), 0.0)

    @property
    def _pause_ms(self) -> float:
        """Time between the end of a picture and the next one [ms]."""
        return max(self.shortest_ms, self._taken_ms)

    def request(self, *, moving: bool = False) -> None:
        """Draw soon; ``moving`` while the user turns the view, where speed matters more than sharpness."""
        self._moving = moving
        self._rest.stop()
        if 1e3 * self._clock() - self._ended > _ROW_MS:
            self._in_a_row = 0
        if not self._soon.isActive():
            self._soon.start(round(self._pause_ms))

    def hurry(self) -> None:
        """Draw a requested picture without further waiting."""
        if self._soon.isActive():
            self._soon.start(0)

    def now(self, *, quality: float = 1.0) -> None:
        """Draw without waiting."""
        self._soon.stop()
        self._draw(quality)

    def stop(self) -> None:
        """Cancel requested pictures."""
        self._soon.stop()
        self._rest.stop()

    def _on_soon(self) -> None:
        self._in_a_row += 1
        hasty = self._moving and self._last_ms > HALF_RESOLUTION_FROM_MS
        hasty |= self._in_a_row >= _IN_A_ROW and self._last_ms > HALF_RESOLUTION_IN_A_ROW_FROM_MS
        self._draw(0.5 if hasty else 1.0)
        if hasty or self._last_ms <= REDRAW_UP_TO_MS:
            self._rest.start(round(REST_MS + self._pause_ms))  # the next picture of a row is due before

    def _on_rest(self) -> None:
        self._moving = False
        self._in_a_row = 0
        self._draw(2.0 if self._last_ms <= REDRAW_UP_TO_MS else 1.0)

    def _draw(self, quality: float) -> None:
        start = self._clock()
        self.due.emit(quality)
        update = 1e3 * (self._clock() - start)
        self._canvas.draw(quality=quality)
        self._ended = 1e3 * self._clock()
        elapsed = self._ended - 1e3 * start
        if quality <= 1.0:
            # Scaled to full resolution; otherwise the quality would alternate with the speed.
            self._last_ms = update + (elapsed - update) / quality**2
            self._taken_ms = elapsed
        self.drawn.emit(elapsed)
