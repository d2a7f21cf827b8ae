"""Background work: a job is a function with its arguments, an executor runs it.

``ProcessExecutor`` runs jobs in one separate process, so that the window never waits; ``InlineExecutor`` runs them in
the caller, for tests and pictures. Both call the same functions and report through the same callbacks: progress,
partial results, and at last either the result or the reason for failure.
"""

from __future__ import annotations

import multiprocessing as mp
import signal
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import count
from multiprocessing.connection import Connection
from typing import Any, Generic, TypeAlias, TypeVar, TypeVarTuple

from PySide6.QtCore import QObject, QTimer

from tactile_maps.core.arrays import refreeze
from tactile_maps.core.errors import TactileMapsError
from tactile_maps.core.progress import Progress, no_progress

POLL_MS = 5

R = TypeVar("R")
S = TypeVar("S")
Ts = TypeVarTuple("Ts")

_Send: TypeAlias = Callable[[str, object], None]


class Report:
    """Last argument of a job's function. Calling it with a text and a share, 0 to 1, reports progress."""

    def __init__(self, send: _Send) -> None:
        self._send = send

    def __call__(self, text: str, share: float) -> None:
        self._send("progress", (text, share))

    def part(self, value: object) -> None:
        """Send a partial result."""
        self._send("part", value)


@dataclass(eq=False)
class Kept(Generic[S]):
    """An argument of several jobs that is sent to the process and made there once. Mutable: its value.

    The process keeps the last one only. A job fails if the process has ended by itself since it was sent.

    Attributes:
        make: Makes the value; can be pickled.
        number: Identifies it in the process.
    """

    make: Callable[[], S]
    number: int = field(default_factory=partial(next, count()))

    @cached_property
    def value(self) -> S:
        """The value, made at first use."""
        return self.make()


def keep(value: S) -> Kept[S]:
    """Return a value that is sent to the process once."""
    return Kept(partial(_itself, value))


def _itself(value: S) -> S:
    return value


@dataclass(frozen=True)
class _Known:
    """Placeholder for a ``Kept`` that the process has."""

    number: int


class Job(Generic[R]):
    """A function to call in the background. It does not change.

    Args:
        function: Function of a module, so that a process can import it. It receives the arguments and a ``Report``.
        arguments: Its other arguments; they can be pickled.
        died: Message, with a remedy, if the process ends while the job runs.
        deferrable: Whether an inline executor keeps the job until ``run_waiting``: it is slow, and no one waits for it.
    """

    def __init__(
        self, function: Callable[[*Ts, Report], R], *arguments: *Ts, died: str, deferrable: bool = False
    ) -> None:
        self.function: Callable[..., R] = function
        self.arguments: tuple[Any, ...] = arguments
        self.died = died
        self.deferrable = deferrable


class Running(Generic[R]):
    """A job that was started.

    Attributes:
        job: The job.
        begun: Whether its function has been called; until then it waits for the jobs before it.
        done: Whether it has finished, failed or been cancelled; nothing is reported from then on.
    """

    def __init__(
        self,
        executor: Executor,
        job: Job[R],
        finished: Callable[[R], None],
        failed: Callable[[str], None],
        progressed: Progress,
        received: Callable[[Any], None],
    ) -> None:
        self.job = job
        self.begun = False
        self.done = False
        self._executor = executor
        self._ends: dict[str, Callable[[Any], None]] = {"result": finished, "failed": failed}
        self._reports: dict[str, Callable[[Any], None]] = {"progress": lambda how: progressed(*how), "part": received}

    def cancel(self) -> None:
        """End it: nothing more is reported, and a process that runs it is ended."""
        if not self.done:
            self.done = True
            self._executor.drop(self, end=True)

    def ignore(self) -> None:
        """Report nothing more. If it has begun, it runs to its end, which costs less than another process."""
        if not self.done:
            self.done = True
            self._executor.drop(self, end=False)

    def deliver(self, kind: str, content: Any) -> None:
        """Pass on what its function sent; called by the executor."""
        if not self.done:
            self.done = kind in self._ends
            (self._ends if self.done else self._reports)[kind](content)


def _ignored(_content: object) -> None:
    """Receive a result that is not used."""


class Executor(QObject):
    """Runs jobs one after the other.

    Args:
        name: Name of the process, for people who list processes.
        parent: Qt parent.

    Attributes:
        name: Its name.
        background: Whether the caller continues while jobs run.
    """

    background = False

    def __init__(self, name: str, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.name = name
        self._waiting: list[Running[Any]] = []
        self._current: Running[Any] | None = None

    @property
    def busy(self) -> bool:
        """Whether a job runs or waits."""
        return self._current is not None or bool(self._waiting)

    def start(
        self,
        job: Job[R],
        finished: Callable[[R], None] = _ignored,
        failed: Callable[[str], None] = _ignored,
        *,
        progressed: Progress = no_progress,
        received: Callable[[Any], None] = _ignored,
    ) -> Running[R]:
        """Run a job after those that were started before.

        Args:
            job: The job.
            finished: Receives the result.
            failed: Receives the reason, with a remedy, if there is no result.
            progressed: Receives the current stage and the completed share, 0 to 1.
            received: Receives each partial result.
        """
        running = Running(self, job, finished, failed, progressed, received)
        self._waiting.append(running)
        self._begin(running)
        return running

    def warm(self, *functions: Callable[..., object]) -> None:
        """Start the process and import the modules of these functions, so that the first job does not wait for it."""

    def run_waiting(self) -> None:
        """Run jobs that an inline executor has kept."""

    def ignore_all(self) -> None:
        """Ignore all jobs."""
        for running in (*self._waiting, self._current):
            if running is not None:
                running.ignore()

    def close(self) -> None:
        """Cancel all jobs and end the process."""
        self.ignore_all()

    def drop(self, running: Running[Any], *, end: bool) -> None:
        """Remove a job that waits; with ``end``, end the one that runs."""
        if running in self._waiting:
            self._waiting.remove(running)

    def _begin(self, running: Running[Any]) -> None:
        raise NotImplementedError


class InlineExecutor(Executor):
    """Runs jobs while the caller waits, deterministically, for tests and pictures.

    Args:
        name: Its name.
        parent: Qt parent.
        hold: Whether all jobs, not only deferrable ones, wait for ``run_waiting``.
    """

    def __init__(self, name: str, parent: QObject | None = None, *, hold: bool = False) -> None:
        super().__init__(name, parent)
        self.hold = hold

    def run_waiting(self) -> None:
        while self._waiting:
            self._run(self._waiting[0])

    def _begin(self, running: Running[Any]) -> None:
        if not (self.hold or running.job.deferrable):
            self._run(running)

    def _run(self, running: Running[Any]) -> None:
        self._waiting.remove(running)
        self._current = running
        running.begun = True
        kind = "result"
        try:
            content = running.job.function(*running.job.arguments, Report(running.deliver))
        except TactileMapsError as error:
            kind = "failed"
            content = str(error)
        finally:
            self._current = None
        running.deliver(kind, content)


def _work(connection: Connection, _imported: tuple[Callable[..., object], ...]) -> None:
    """Run in the process: do jobs until the window closes its end of the connection."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C in a terminal reaches this process too; the window ends it
    with suppress(EOFError, BrokenPipeError, ConnectionResetError):  # the window has gone
        connection.send(("ready", None))
        kept: Kept[Any] | None = None
        while True:
            function, arguments = connection.recv()
            kept = next((one for one in arguments if isinstance(one, Kept)), kept)
            _call(connection, function, [kept if isinstance(one, _Known) else one for one in arguments])


def _call(connection: Connection, function: Callable[..., object], arguments: list[object]) -> None:
    def send(kind: str, content: object) -> None:
        connection.send((kind, content))

    try:
        send("result", function(*arguments, Report(send)))
    except BrokenPipeError:
        raise
    except TactileMapsError as error:
        send("failed", str(error))
    except Exception as error:  # whatever goes wrong, the window is notified and continues
        send("failed", f"An unexpected problem: {type(error).__name__}: {error}.")


class ProcessExecutor(Executor):
    """Runs jobs in one process, started when it is first needed.

    A job is sent only when the process waits for one: a pipe buffers little, and writing more blocks until it is
    read. Reading a large result takes some tenths of a second, and so does using it, so the event loop runs
    between the two. A process that ends by itself (killed, out of memory, crashed in a native library) fails its jobs;
    the next job starts another.
    """

    background = True

    def __init__(self, name: str, parent: QObject | None = None) -> None:
        super().__init__(name, parent)
        self._process: Any = None
        self._connection: Connection | None = None
        self._kept: set[int] = set()  # sent to the process
        self._read: list[tuple[str, Any]] = []  # and not delivered yet
        self._ready = False
        self._timer = QTimer(self)
        self._timer.setInterval(POLL_MS)
        self._timer.timeout.connect(self._on_timer)

    @property
    def ready(self) -> bool:
        """Whether the process has started and has nothing to do."""
        return self._ready and self._current is None

    @property
    def pid(self) -> int | None:
        """Identifier of the process; None if there is none."""
        return None if self._process is None else self._process.pid

    def warm(self, *functions: Callable[..., object]) -> None:
        if self._current is None and self._has_died():
            self._end_process()
        if self._process is None:
            context = mp.get_context("spawn")
            ours, theirs = context.Pipe()
            self._process = context.Process(target=_work, args=(theirs, functions), daemon=True, name=self.name)
            self._process.start()
            theirs.close()
            self._connection = ours
            self._timer.start()

    def close(self) -> None:
        super().close()
        self._end_process()

    def drop(self, running: Running[Any], *, end: bool) -> None:
        super().drop(running, end=end)
        if end and running is self._current:
            self._end_process()
            self._start_waiting()

    def _begin(self, running: Running[Any]) -> None:
        if self._current is None and self._has_died() and self._needs_kept(running):
            self._on_ended()
        else:
            self._start_waiting()

    def _has_died(self) -> bool:
        return self._process is not None and not self._process.is_alive()

    def _start_waiting(self) -> None:
        if self._waiting:
            self.warm(self._waiting[0].job.function)
            self._timer.start()
            self._hand_over()

    @staticmethod
    def _numbers(running: Running[Any]) -> set[int]:
        return {one.number for one in running.job.arguments if isinstance(one, Kept)}

    def _needs_kept(self, running: Running[Any]) -> bool:
        return bool(self._numbers(running) & self._kept)

    def _hand_over(self) -> None:
        """Send the next job, if the process waits for one."""
        if not self.ready or not self._waiting or self._connection is None:
            return
        self._current = self._waiting.pop(0)
        self._current.begun = True
        job = self._current.job
        arguments = tuple(
            _Known(one.number) if isinstance(one, Kept) and one.number in self._kept else one for one in job.arguments
        )
        self._kept = self._numbers(self._current) or self._kept
        try:
            self._connection.send((job.function, arguments))
        except (BrokenPipeError, ConnectionResetError):
            self._on_ended()

    def _on_timer(self) -> None:
        if self._read:
            self._deliver()
            return
        try:
            while self._connection is not None and self._connection.poll():
                self._read.append(self._connection.recv())
        except (EOFError, ConnectionResetError):
            self._deliver()
            self._on_ended()

    def _deliver(self) -> None:
        while self._read:  # a callback may close
            kind, content = self._read.pop(0)
            running = self._current
            if kind == "ready":
                self._ready = True
            elif running is not None:
                if kind in ("result", "failed"):
                    self._current = None
                refreeze(content)
                running.deliver(kind, content)
            self._hand_over()
        if self.ready and not self._waiting:
            self._timer.stop()

    def _on_ended(self) -> None:
        """Fail the job that ran, or else the next one, and those whose kept value the ended process had."""
        failed = [self._current or self._waiting[0]] if self.busy else []
        failed += [one for one in self._waiting if one not in failed and self._needs_kept(one)]
        self._waiting = [one for one in self._waiting if one not in failed]
        self._end_process()
        for one in failed:
            one.deliver("failed", one.job.died)
        self._start_waiting()

    def _end_process(self) -> None:
        self._timer.stop()
        self._read.clear()
        self._kept.clear()
        self._current = None
        self._ready = False
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process.close()
            self._process = None
        if self._connection is not None:
            self._connection.close()
            self._connection = None
