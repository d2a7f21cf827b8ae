"""What drives a session: wall time in batches on a thread, or time handed in by a test."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from app.core.errors import SimulationError, TactileMapsError, describe_unexpected_error
from app.session.frame import Frame
from app.session.inputs import SessionInput
from app.session.session import Session

BATCH_SECONDS = 0.010
"""Seconds between two batches: longer than Python's thread switch, shorter than a drawn frame."""
_LONGEST = 0.1
_SMOOTH = 0.1


class SessionRunner:
    """A session and whether, how fast and for whom it runs. Mutable; one lock guards it all.

    Args:
        session: What to run.
        each: Told every tick's frame, under the lock: the recorder.

    Attributes:
        paused: Whether time stands still.
        speed: Simulated seconds per wall second asked for.
        real_time_factor: And reached, smoothed over about a second.
        failure: Why the session stopped, or refused an input; None again once somebody has asked.
        halted: Whether it stopped by itself, and stands still until its reset.
    """

    def __init__(self, session: Session, each: Callable[[Frame], None]) -> None:
        self.session, self._each = session, each
        self.lock = threading.RLock()
        self.paused, self.speed, self.real_time_factor = False, 1.0, 0.0
        self.failure: TactileMapsError | None = None
        self.halted = False

    def submit(self, act: SessionInput) -> None:
        """Let a person act at the next tick."""
        with self.lock:
            self.session.submit(act)

    def step(self) -> None:
        """One tick while paused."""
        with self.lock:
            self._run(self.session.prepared.scene.tick)

    def reset(self) -> None:
        """Start the session again."""
        with self.lock:
            self.session.reset()
            self.failure, self.halted = None, False

    def stop(self) -> None:
        """End for good; the session stays as it is."""

    def _run(self, seconds: float) -> None:
        """Advance. Why it did not is kept for whoever asks; an input that was refused does not stop the session."""
        try:
            self.session.advance(seconds, each=self._each)
        except TactileMapsError as error:
            self.failure = error
            if self.session.failure is not None:
                self._halt()

    def _halt(self) -> None:
        self.halted = self.paused = True


class InlineRunner(SessionRunner):
    """Runs only when told to: deterministic, for tests and pictures."""

    def run_for(self, seconds: float) -> None:
        """Simulate so many seconds now, unless paused."""
        tick = self.session.prepared.scene.tick
        for _ in range(round(seconds / tick)):
            if not self.paused:
                self._run(tick)
        self.real_time_factor = 0.0 if self.paused else 1.0


class ThreadRunner(SessionRunner):
    """Runs by the wall clock on a thread of its own. Time it cannot keep up with is dropped; the factor tells."""

    def __init__(
        self, session: Session, each: Callable[[Frame], None], *, clock: Callable[[], float] = time.perf_counter
    ) -> None:
        super().__init__(session, each)
        self._clock, self._ended = clock, threading.Event()
        self._thread = threading.Thread(target=self._loop, name="session", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the thread and wait for it."""
        self._ended.set()
        self._thread.join()

    def _loop(self) -> None:
        last = self._clock()
        while not self._ended.wait(BATCH_SECONDS):
            now = self._clock()
            elapsed, last = now - last, now
            with self.lock:
                before = self.session.frame.time
                if not self.paused:
                    self._run_guarded(min(elapsed, _LONGEST) * self.speed)
                self._measure(self.session.frame.time - before, elapsed)

    def _run_guarded(self, seconds: float) -> None:
        try:
            self._run(seconds)
        except Exception as error:  # the thread's last door: beyond it nobody would notice that time stands still
            self.failure = SimulationError(describe_unexpected_error(error), remedy="Reset starts the scene again")
            self._halt()

    def _measure(self, simulated: float, elapsed: float) -> None:
        share = min(_SMOOTH * elapsed / BATCH_SECONDS / 10, 1.0)
        self.real_time_factor += share * (simulated / max(elapsed, 1e-9) - self.real_time_factor)
