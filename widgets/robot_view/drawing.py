"""When to draw: after what waits in the event loop, never so often that the rest starves, once more when it rests."""

from __future__ import annotations

import time
from collections.abc import Callable

from PySide6.QtCore import QObject, QTimer, Signal

from widgets.robot_view.canvas import Canvas

SHORTEST_WAIT_MS = 15.0
REST_MS = 150
"""A picture that stays this long is drawn again at twice the resolution, which smooths its edges."""
HASTY_FROM_MS = 25.0
"""While the view is turned, pictures that take longer than this are drawn at half the resolution."""
STILL_UP_TO_MS = 60.0
"""Pictures that take longer than this are not drawn again at rest."""


class Drawing(QObject):
    """Draws a canvas when asked to, but not at once: many requests become one picture.

    The next picture waits for as long as the last one took, so that at most half the time goes into drawing.

    Args:
        canvas: What is drawn.
        parent: Qt parent.
        clock: Seconds.
    """

    due = Signal()
    """A picture is about to be drawn: bring the scene up to date."""
    drawn = Signal(float)
    """A picture was drawn: its milliseconds, with bringing the scene up to date."""

    def __init__(self, canvas: Canvas, parent: QObject, *, clock: Callable[[], float] = time.perf_counter) -> None:
        super().__init__(parent)
        self._canvas, self._clock = canvas, clock
        self._last_ms, self._moving = 0.0, False
        self._soon, self._rest = QTimer(self), QTimer(self)
        for timer, slot in ((self._soon, self._on_soon), (self._rest, self._on_rest)):
            timer.setSingleShot(True)
            timer.timeout.connect(slot)

    @property
    def waiting(self) -> bool:
        """Whether a picture is still to come."""
        return self._soon.isActive() or self._rest.isActive()

    def request(self, *, moving: bool = False) -> None:
        """Draw soon; ``moving`` while the hand turns the view, where speed matters more than sharpness."""
        self._moving = moving
        self._rest.stop()
        if not self._soon.isActive():
            self._soon.start(round(max(SHORTEST_WAIT_MS, self._last_ms)))

    def now(self, *, quality: float = 1.0) -> None:
        """Draw without waiting."""
        self._soon.stop()
        self._draw(quality)

    def stop(self) -> None:
        """Forget what was requested."""
        self._soon.stop()
        self._rest.stop()

    def _on_soon(self) -> None:
        hasty = self._moving and self._last_ms > HASTY_FROM_MS
        self._draw(0.5 if hasty else 1.0)
        if hasty or self._last_ms <= STILL_UP_TO_MS:
            self._rest.start(REST_MS)

    def _on_rest(self) -> None:
        self._moving = False
        self._draw(2.0 if self._last_ms <= STILL_UP_TO_MS else 1.0)

    def _draw(self, quality: float) -> None:
        start = self._clock()
        self.due.emit()
        self._canvas.draw(quality=quality)
        elapsed = 1e3 * (self._clock() - start)
        if quality <= 1.0:
            # A hasty picture says what a whole one would take, or speed would switch quality back and forth.
            self._last_ms = elapsed / quality**2
        self.drawn.emit(elapsed)
