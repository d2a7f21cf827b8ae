"""A process beside the window that measures one stage for its work-precision diagram, and ends when it has."""

from __future__ import annotations

import multiprocessing as mp
import signal
from multiprocessing.connection import Connection
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal

from app.errors import TactileMapsError
from app.experiments.work_precision import Subject, Trial

_POLL_MS = 25
_UNFORESEEN = (MemoryError, OSError, ArithmeticError, ValueError, LookupError, RuntimeError, TypeError)


def _work(connection: Connection) -> None:
    """The process: a stage's name and a subject in; progress and trials, or a failure, out."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C in a terminal reaches us too; the window ends us
    from app.experiments.stages.table import STAGES
    from app.experiments.work_precision import measured

    try:
        # Only now the subject is sent: a pipe holds little, and the window would wait until we read it.
        connection.send(("ready", None))
        name, subject = connection.recv()
        for trial in measured(STAGES[name], subject, progress=lambda *how: connection.send(("progress", how))):
            connection.send(("tried", trial))
        connection.send(("finished", None))
    except (BrokenPipeError, EOFError):
        return  # the window has gone, and with it whoever wanted to know
    except TactileMapsError as error:
        connection.send(("failed", str(error)))
    except _UNFORESEEN as error:
        # Whatever else goes wrong in there, the window must hear of it and live on.
        connection.send(("failed", f"An unexpected problem while measuring: {type(error).__name__}: {error}."))


class AccuracyProcess(QObject):
    """Measures one stage at a time in a process of its own, so that nothing of the window disturbs its clock."""

    progressed = Signal(str, float)
    """What is being tried, and how far it is, 0 to 1."""
    tried = Signal(tuple)
    """The Trials that are there since the last time."""
    finished = Signal()
    """All of them are."""
    failed = Signal(str)
    """Why not all could be."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._process: Any = None
        self._connection: Connection | None = None
        self._request: tuple[str, Subject] | None = None
        self._trials: list[Trial] = []
        self._timer = QTimer(self)
        self._timer.setInterval(_POLL_MS)
        self._timer.timeout.connect(self._on_timer)

    @property
    def busy(self) -> bool:
        """Whether something is being measured."""
        return self._process is not None

    def measure(self, stage: str, subject: Subject) -> None:
        """Measure a stage of ``stages.table``; what was being measured is dropped."""
        self.close()
        self._request = (stage, subject)
        context = mp.get_context("spawn")
        self._connection, theirs = context.Pipe()
        process = context.Process(target=_work, args=(theirs,), daemon=True, name="accuracy")
        process.start()
        self._process = process
        theirs.close()
        self._timer.start()
        self.progressed.emit("starting", 0.0)

    def close(self) -> None:
        """End the process, whatever it does."""
        self._timer.stop()
        self._request, self._trials = None, []
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process.close()
            self._process = None
        if self._connection is not None:
            self._connection.close()
            self._connection = None

    def _on_timer(self) -> None:
        try:
            while self._connection is not None and self._connection.poll():
                self._take(*self._connection.recv())
            self._tell()
        except (EOFError, ConnectionResetError, BrokenPipeError):
            self.close()
            self.failed.emit("Measuring ended unexpectedly; the diagram before it is kept. Measure again.")

    def _take(self, kind: str, content: Any) -> None:
        if kind == "ready":
            assert self._connection is not None
            self._connection.send(self._request)
        elif kind == "progress":
            self.progressed.emit(*content)
        elif kind == "tried":
            self._trials.append(content)
        else:
            self._tell()
            self.close()
            self.finished.emit() if kind == "finished" else self.failed.emit(content)

    def _tell(self) -> None:
        """Rounds come in bursts; they are told, and drawn, at once."""
        if self._trials:
            trials, self._trials = tuple(self._trials), []
            self.tried.emit(trials)
