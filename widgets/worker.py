"""One process beside the window that prepares scenes: slow, native, and allowed to crash without the window."""

from __future__ import annotations

import multiprocessing as mp
import signal
from multiprocessing.connection import Connection
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal

from app.arrays import refreeze
from app.errors import TactileMapsError
from app.maps.tactile_map import TactileMap
from app.simulation.scene import Scene

_POLL_MS = 25
_UNFORESEEN = (MemoryError, OSError, ArithmeticError, ValueError, LookupError, RuntimeError, TypeError)


def _work(connection: Connection) -> None:
    """The process: scenes or maps in; progress, a prepared scene and a map's quality, or a failure, out."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C in a terminal reaches us too; the window ends us
    from app.maps.quality import measure
    from app.session.prepare import prepare

    while True:
        try:
            request = connection.recv()
        except EOFError:
            return
        try:
            map_ = request
            if isinstance(request, Scene):
                made = prepare(request, progress=lambda text, done: connection.send(("progress", (text, done))))
                connection.send(("prepared", made))
                map_ = made.map
            connection.send(("measured", measure(map_)))
        except BrokenPipeError:
            return  # the window has gone, and with it whoever wanted to know
        except TactileMapsError as error:
            connection.send(("failed", str(error)))
        except _UNFORESEEN as error:
            # Whatever else goes wrong in there, the window must hear of it and live on.
            connection.send(("failed", f"An unexpected problem while preparing: {type(error).__name__}: {error}."))


class Worker(QObject):
    """Prepares scenes in one process; the newest request wins. ``close`` ends the process."""

    progressed = Signal(str, float)
    """What is being done, and how far it is, 0 to 1."""
    prepared = Signal(object)
    """A Prepared."""
    measured = Signal(object)
    """The MapQuality of the last Prepared, or of the map asked for."""
    failed = Signal(str)
    """Why there is none."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._process: Any = None
        self._connection: Connection | None = None
        self._busy = False
        self._timer = QTimer(self)
        self._timer.setInterval(_POLL_MS)
        self._timer.timeout.connect(self._on_timer)

    @property
    def busy(self) -> bool:
        """Whether a scene is being prepared."""
        return self._busy

    def warm(self) -> None:
        """Start the process now, so that the next request need not wait for it."""
        if self._process is not None and not self._process.is_alive():
            self.close()
        if self._process is None:
            self._start()

    def prepare(self, scene: Scene) -> None:
        """Prepare ``scene``; one that is being prepared or measured is dropped."""
        self._request(scene, busy=True)

    def measure(self, map_: TactileMap) -> None:
        """Measure a map; a scene that is being prepared goes first, and brings its own quality."""
        if not self._busy:
            self._request(map_, busy=False)

    def _request(self, content: Scene | TactileMap, *, busy: bool) -> None:
        if self._timer.isActive():
            self.close()
        self.warm()
        assert self._connection is not None
        self._busy = busy
        self._timer.start()
        try:
            self._connection.send(content)
        except (BrokenPipeError, ConnectionResetError):
            self._on_ended()

    def cancel(self) -> None:
        """Drop what is being prepared, and be ready for the next request."""
        if self._busy:
            self.close()
            self.warm()

    def close(self) -> None:
        """End the process, whatever it does."""
        self._timer.stop()
        self._busy = False
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process.close()
            self._process = None
        if self._connection is not None:
            self._connection.close()
            self._connection = None

    def _start(self) -> None:
        context = mp.get_context("spawn")
        ours, theirs = context.Pipe()
        self._process = context.Process(target=_work, args=(theirs,), daemon=True, name="prepare")
        self._process.start()
        theirs.close()
        self._connection = ours

    def _on_timer(self) -> None:
        assert self._connection is not None
        try:
            while self._connection is not None and self._connection.poll():
                self._take(*self._connection.recv())
        except (EOFError, ConnectionResetError):
            self._on_ended()

    def _on_ended(self) -> None:
        """The process died: killed, out of memory, or a native library crashed in it."""
        preparing = self._busy
        self.close()
        self.failed.emit(
            "Preparing the scene ended unexpectedly; the scene before it is kept. Try fewer taxels, or another link."
            if preparing
            else "Measuring the map ended unexpectedly; its quality stays unknown. Open the scene again to measure it."
        )

    def _take(self, kind: str, content: Any) -> None:
        refreeze(content)
        if kind == "progress":
            self.progressed.emit(*content)
        elif kind == "measured":
            self._timer.stop()
            self.measured.emit(content)
        else:
            self._busy = False
            if kind == "failed":
                self._timer.stop()
            (self.prepared if kind == "prepared" else self.failed).emit(content)
