"""Runners that advance a session: by the wall clock on a thread, or by time that a test passes."""

from __future__ import annotations

import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tactile_maps.core.errors import SimulationError, TactileMapsError, describe_unexpected_error
from tactile_maps.session.frame import Frame
from tactile_maps.session.inputs import SessionInput
from tactile_maps.session.running_session import RunningSession
from tactile_maps.tactile.poke import PokeInput
from tactile_widgets.session.stroke import StrokePlan

BATCH_SECONDS = 0.010
"""Seconds between two batches of ticks: longer than Python's thread switch interval, shorter than a drawn frame."""
SWITCH_SECONDS = 0.5e-3
"""Python's thread switch interval: a thread waits at most this long for the interpreter lock [s]. The window releases
the lock with each Qt call; with the default of 5 ms, a hundred calls would block the window for half a second."""
LONGEST_GAP = 0.1
"""Wall seconds that one batch catches up at most; the rest of a longer gap is dropped."""
UNREAD_SECONDS = 0.2
"""Wall seconds for which a session continues while the window takes no frames; then it waits for the window. Both share
Python's interpreter lock, and building the views of another scene, or planning a path, would block the window for
twice as long."""
MAX_TICKS = 20
"""Maximum number of ticks in a batch; the rest of the wall time is dropped, so that a slow machine runs slower."""
_SMOOTH = 0.1
_MOST_RECENT = 1000
"""Maximum number of frames kept for a window that is late; then the oldest are dropped."""


class FairLock:
    """A lock for two threads that neither can acquire twice while the other waits. Not reentrant.

    A ``threading.Lock`` can be acquired again by the thread that has just released it, so that a thread that ticks
    without pause would block the other one for its whole batch.
    """

    def __init__(self) -> None:
        self._turn = threading.Lock()
        self._held = threading.Lock()

    def __enter__(self) -> None:
        with self._turn:
            self._held.acquire()

    def __exit__(self, *_error: object) -> None:
        self._held.release()

    @contextmanager
    def taken_within(self, seconds: float) -> Iterator[bool]:
        """Acquire the lock for the block; yield False if that takes longer than ``seconds``."""
        taken = False
        if self._turn.acquire(timeout=seconds):
            taken = self._held.acquire(timeout=seconds)
            self._turn.release()
        try:
            yield taken
        finally:
            if taken:
                self._held.release()


class SessionRunner:
    """Runs a session and passes its frames on. Mutable; one lock guards everything and is held for one tick at most.

    Args:
        session: The session to run.
        each: Receives the frame of every tick, under the lock; it must be fast.
        speed: Requested simulated seconds per wall second.

    Attributes:
        lock: Guards the session; not reentrant.
        paused: True while simulated time does not advance.
        speed: Requested simulated seconds per wall second.
        real_time_factor: Reached simulated seconds per wall second, smoothed over about a second.
        failure: Reason why the session stopped, or rejected an input; the reader resets it to None.
        halted: True if the session stopped by itself; it does not continue before its reset.
        strokes: Finger motion of the next ticks.
    """

    def __init__(self, session: RunningSession, each: Callable[[Frame], None], *, speed: float = 1.0) -> None:
        self.session = session
        self._each = each
        self.lock = FairLock()
        self.paused = False
        self.speed = speed
        self.real_time_factor = 0.0
        self.failure: TactileMapsError | None = None
        self.halted = False
        self.strokes = StrokePlan(session.prepared.skin, session.prepared.scene.tick)
        self._inputs: deque[SessionInput] = deque()
        self._recent: deque[Frame] = deque(maxlen=_MOST_RECENT)

    def start(self) -> None:
        """Start running; called once, when the views exist."""

    def take_recent(self) -> tuple[Frame, ...]:
        """Return the frames since the previous call, the oldest first; requires the lock."""
        recent = tuple(self._recent)
        self._recent.clear()
        return recent

    def _keep(self, frame: Frame) -> None:
        self._recent.append(frame)
        self._each(frame)

    def submit(self, *acts: SessionInput) -> None:
        """Apply inputs at the same next tick; ``failure`` reports an input that the session rejects.

        A large move of a finger is spread over the next ticks (``StrokePlan``).
        """
        self._inputs.extend(acts)
        with self.lock:
            self._apply_inputs()

    def _apply_inputs(self) -> None:
        """Pass all waiting inputs to the session, in order; requires the lock."""
        while self._inputs:
            act = self._inputs.popleft()
            try:
                for now in self.strokes.take(act, self.session.frame.tick) if isinstance(act, PokeInput) else (act,):
                    self.session.submit(now)
            except TactileMapsError as error:
                self.failure = error

    def step(self) -> None:
        """Simulate one tick while paused."""
        with self.lock:
            self._apply_inputs()
            self._tick()

    def reset(self) -> None:
        """Start the session again."""
        self._inputs.clear()
        with self.lock:
            self.strokes.clear()
            self.session.reset()
            self._recent.clear()
            self.failure = None
            self.halted = False

    def stop(self) -> None:
        """Stop for good; the session does not change."""

    def _tick(self) -> None:
        """Advance by one tick; store a failure. A rejected input does not stop the session."""
        try:
            for act in self.strokes.due(self.session.frame.tick):
                self.session.submit(act)
            self._keep(self.session.tick())
        except TactileMapsError as error:
            self.failure = error
            if self.session.failure is not None:
                self._halt()

    def _halt(self) -> None:
        self.halted = self.paused = True


class InlineRunner(SessionRunner):
    """Runs on request: deterministic, for tests and pictures."""

    def run_for(self, seconds: float) -> None:
        """Simulate a number of seconds at once, unless paused."""
        for _ in range(round(seconds / self.session.prepared.scene.tick)):
            if not self.paused:
                with self.lock:
                    self._tick()
        self.real_time_factor = 0.0 if self.paused else 1.0


class ThreadRunner(SessionRunner):
    """Runs by the wall clock on its own thread, while the window takes its frames.

    Time that it cannot keep up with, or during which it waits for the window, is dropped and lowers the real-time
    factor.

    Args:
        session: The session to run.
        each: Receives the frame of every tick, under the lock; it must be fast.
        speed: Requested simulated seconds per wall second.
        clock: Returns wall time [s].
    """

    def __init__(
        self,
        session: RunningSession,
        each: Callable[[Frame], None],
        *,
        speed: float = 1.0,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        super().__init__(session, each, speed=speed)
        self._clock = clock
        self._ended = threading.Event()
        self._remainder = 0.0
        self._taken = 0.0
        self._thread = threading.Thread(target=self._loop, name="session", daemon=True)

    def start(self) -> None:
        sys.setswitchinterval(SWITCH_SECONDS)
        self._thread.start()

    def submit(self, *acts: SessionInput) -> None:
        """Let the thread apply the inputs, because some inputs take 0.2 s, such as the first path.

        While paused, they are applied at once, so that the user sees their effect.
        """
        # In one call, so that the thread cannot tick between them.
        self._inputs.extend(acts)
        if self.paused:
            with self.lock:
                self._apply_inputs()

    def take_recent(self) -> tuple[Frame, ...]:
        """Return the frames since the previous call, and let a session continue that waits for the window."""
        self._taken = self._clock()
        return super().take_recent()

    def stop(self) -> None:
        """End the thread and wait for it."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join()

    def _loop(self) -> None:
        last = self._taken = self._clock()
        while not self._ended.wait(BATCH_SECONDS):
            now = self._clock()
            elapsed = now - last
            last = now
            simulated = 0.0
            try:
                if self._inputs:
                    with self.lock:
                        self._apply_inputs()
                waits = self._recent and now - self._taken > UNREAD_SECONDS
                for _ in range(0 if waits else self._ticks_due(elapsed)):
                    with self.lock:  # for one tick: the window never waits for longer
                        if self.paused or self._ended.is_set():
                            break
                        before = self.session.frame.time
                        self._tick()
                        simulated += self.session.frame.time - before
            except Exception as error:  # an error that ended the thread would leave the session frozen without notice
                self.failure = SimulationError(describe_unexpected_error(error), remedy="Reset starts the scene again")
                self._halt()
            share = min(_SMOOTH * elapsed / BATCH_SECONDS / 10, 1.0)
            self.real_time_factor += share * (simulated / max(elapsed, 1e-9) - self.real_time_factor)

    def _ticks_due(self, elapsed: float) -> int:
        """Return the whole ticks due after ``elapsed`` wall seconds; the remainder is kept for the next call."""
        tick = self.session.prepared.scene.tick
        self._remainder += min(elapsed, LONGEST_GAP) * self.speed
        count = int(self._remainder / tick + 1e-9)
        self._remainder = max(self._remainder - count * tick, 0.0)
        return min(count, MAX_TICKS)
