"""A process beside the window: requests go in, answers come out as a signal; it can be ended at any time."""

from __future__ import annotations

import multiprocessing as mp
import signal
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from typing import Any, Generic, TypeVar

from PySide6.QtCore import QObject, QTimer, Signal

from tactile_maps.core.arrays import refreeze
from tactile_maps.core.errors import TactileMapsError

POLL_MS = 5
_UNFORESEEN = (MemoryError, OSError, EOFError, ArithmeticError, ValueError, LookupError, RuntimeError, TypeError)

T = TypeVar("T")


@dataclass(frozen=True)
class SourceToken:
    """Which scene or document something is computed for; another one as soon as that is no longer shown.

    Attributes:
        owner: Who numbers them, so that tokens of two owners never match.
        number: Rises with each scene, or document, that the owner shows.
    """

    owner: str
    number: int = 0

    def next(self) -> SourceToken:
        """Of what is shown after this."""
        return replace(self, number=self.number + 1)


@dataclass(frozen=True, eq=False)
class Result(Generic[T]):
    """What was computed, and what for: whoever receives it drops it where that is no longer shown.

    Attributes:
        token: As it was asked with.
        value: What came out, or a sentence on why nothing did.
    """

    token: SourceToken
    value: T


Reply = Callable[[str, object], None]
"""Send an answer: its kind and its content."""
RequestHandler = Callable[[object, Reply], None]
"""Do what a request asks for, and tell."""


def _work(connection: Connection, make: Callable[[], RequestHandler]) -> None:
    """The process: serve requests until the window closes its end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C in a terminal reaches us too; the window ends us
    serve = make()
    with suppress(EOFError, BrokenPipeError, ConnectionResetError):  # the window has gone, and whoever wanted to know
        _serve(connection, serve)


def _serve(connection: Connection, serve: RequestHandler) -> None:
    connection.send(("ready", None))
    while True:
        request = connection.recv()
        try:
            serve(request, lambda kind, content: connection.send((kind, content)))
        except BrokenPipeError:
            raise
        except TactileMapsError as error:
            connection.send(("failed", str(error)))
        except _UNFORESEEN as error:
            # Whatever else goes wrong in there, the window must hear of it and live on.
            connection.send(("failed", f"An unexpected problem: {type(error).__name__}: {error}."))
        connection.send(("done", None))


class WorkerProcess(QObject):
    """One process, started when it is needed. Answers come in the order of the requests; ``close`` ends it.

    A request is handed over only when the process waits for one: a pipe holds little, and whoever writes more into it
    waits until it is read. The window never does. To read a large answer takes some tenths, and so does what is made of
    it: between the two the event loop turns.

    Args:
        name: For people who list processes.
        make: Called in the process, gives what serves its requests; must be importable.
        parent: Qt parent.
    """

    answered = Signal(int, str, object)
    """Which request, as ``send`` numbered it, the kind of an answer to it, and the Result with its content.

    Kind ``failed`` has a sentence, ``done`` ends each request's answers.
    """
    ended = Signal(object)
    """It died by itself: killed, out of memory, or a native library crashed in it. The next request starts another.

    With the SourceToken of the request that it was to answer next.
    """

    def __init__(self, name: str, make: Callable[[], RequestHandler], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._name = name
        self._make = make
        self._process: Any = None
        self._connection: Connection | None = None
        self._queue: list[tuple[int, SourceToken, object]] = []
        self._read: list[tuple[str, Any]] = []  # and not told yet
        self._sent = self._current = 0
        self._token: SourceToken | None = None  # of the request being answered
        self._ready = self._busy = False
        self._timer = QTimer(self)
        self._timer.setInterval(POLL_MS)
        self._timer.timeout.connect(self._on_timer)

    @property
    def waiting(self) -> int:
        """How many requests are not done yet."""
        return len(self._queue) + self._busy

    @property
    def ready(self) -> bool:
        """Whether the process is there and has nothing to do."""
        return self._ready and not self._busy

    @property
    def pid(self) -> int | None:
        """Of the process; None while there is none."""
        return None if self._process is None else self._process.pid

    def warm(self) -> None:
        """Start the process now, so that the next request need not wait for it."""
        if self._process is not None and not self._process.is_alive():
            self.close()
        if self._process is None:
            self._start()

    def send(self, request: object, token: SourceToken) -> int:
        """Ask for something; it is done after what was asked for before. Its number.

        Its answers carry number and ``token``.
        """
        self.warm()
        self._sent += 1
        self._queue.append((self._sent, token, request))
        self._timer.start()
        self._hand_over()
        return self._sent

    def close(self) -> None:
        """End the process, whatever it does; nothing is answered any more."""
        self._timer.stop()
        self._queue.clear()
        self._read.clear()
        self._ready = self._busy = False
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
        self._process = context.Process(target=_work, args=(theirs, self._make), daemon=True, name=self._name)
        self._process.start()
        theirs.close()
        self._connection = ours
        self._timer.start()

    def _hand_over(self) -> None:
        """The next request, if the process waits for one."""
        if not self.ready or not self._queue or self._connection is None:
            return
        self._busy = True
        self._current, self._token, request = self._queue.pop(0)
        try:
            self._connection.send(request)
        except (BrokenPipeError, ConnectionResetError):
            self._on_ended()

    def _on_timer(self) -> None:
        if self._read:
            self._tell()
            return
        try:
            while self._connection is not None and self._connection.poll():
                self._read.append(self._connection.recv())
        except (EOFError, ConnectionResetError):
            self._tell()
            self._on_ended()

    def _tell(self) -> None:
        while self._read:  # whoever is told may close
            self._take(*self._read.pop(0))

    def _take(self, kind: str, content: Any) -> None:
        if kind == "ready":
            self._ready = True
        elif self._token is not None:
            self._busy = self._busy and kind != "done"
            refreeze(content)
            self.answered.emit(self._current, kind, Result(self._token, content))
        self._hand_over()
        if self.ready and not self._queue:
            self._timer.stop()

    def _on_ended(self) -> None:
        token = self._token if self._busy else self._queue[0][1] if self._queue else None
        self.close()
        if token is not None:
            self.ended.emit(token)
