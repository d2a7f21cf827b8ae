"""The runners: one by hand, one by the wall clock; whatever fails in the session, the window hears of it."""

from __future__ import annotations

import threading
from dataclasses import replace
from itertools import accumulate, chain, repeat

import pytest

from tactile_maps.session.inputs import ControlChanged, EffectsChanged, MapEdited, ReadingChanged
from tactile_maps.session.session import Session
from tactile_maps.studies.testbeds.reference_bodies import flat_map
from tactile_widgets.session.session_runner import UNREAD_SECONDS, InlineRunner, ThreadRunner


class FailingSession(Session):
    """A session whose next ticks fail with an unexpected exception."""

    broken: Exception | None = None

    def tick(self):
        """Fail if ``broken`` is set."""
        if self.broken is not None:
            raise self.broken
        return super().tick()


def diverge(session):
    """Let the physics run away at the next tick."""
    session._simulation._data.qvel[:] = 1e9


@pytest.fixture
def session(prepared):
    """A session that can be made to fail."""
    return FailingSession(prepared)


@pytest.fixture
def thread(session):
    """A runner on a thread that is gone after the test."""
    ticks = []
    runner = ThreadRunner(session, ticks.append)
    runner.ticks = ticks
    runner.start()
    yield runner
    runner.stop()
    assert not runner._thread.is_alive()


def test_runner_has_no_tick_before_its_start_and_can_stop_before(session):
    runner = ThreadRunner(session, lambda _frame: None)
    assert not runner._thread.is_alive()
    runner.stop()
    assert session.frame.tick == 0


def test_input_rejected_at_once_is_reported_and_the_session_continues(session):
    runner = InlineRunner(session, lambda _frame: None)
    runner.submit(MapEdited("Other", flat_map(30)))
    assert "another skin" in str(runner.failure)
    runner.run_for(0.05)
    assert session.frame.tick == 10
    assert not runner.halted


def test_inline_runner_advances_only_on_request(session):
    ticks = []
    runner = InlineRunner(session, ticks.append)
    runner.run_for(0.25)
    assert session.frame.time == pytest.approx(0.25)
    assert [frame.tick for frame in ticks] == list(range(1, 51)), "every tick is reported, not only drawn frames"
    runner.paused = True
    runner.run_for(1.0)
    assert session.frame.time == pytest.approx(0.25)
    runner.step()
    assert session.frame.tick == 51


@pytest.mark.long
def test_equal_durations_give_equal_frames(prepared):
    ends = []
    for _ in range(2):
        runner = InlineRunner(Session(prepared), lambda _frame: None)
        runner.run_for(0.5)
        ends.append(runner.session.frame)
    assert (ends[0].posture == ends[1].posture).all()
    assert (ends[0].pressures == ends[1].pressures).all()


def test_diverged_session_pauses_with_a_reason(session):
    runner = InlineRunner(session, lambda _frame: None)
    diverge(session)
    runner.run_for(0.1)
    assert runner.paused
    assert runner.halted
    assert "diverged" in str(runner.failure)
    runner.reset()
    assert runner.failure is None
    assert not runner.halted
    assert session.frame.tick == 0


def test_rejected_input_is_reported_and_time_continues(session):
    runner = InlineRunner(session, lambda _frame: None)
    runner.submit(EffectsChanged(replace(session.effects, timestep=0.003)))
    runner.run_for(0.1)
    assert "whole number" in str(runner.failure)
    assert not runner.paused
    assert not runner.halted
    assert session.frame.tick == 19, "the requested tick is skipped"


def test_session_thread_follows_the_clock_and_can_be_stopped(thread, qtbot):
    def ran():
        with thread.lock:
            thread.take_recent()  # as a window does: on a busy machine 0.2 s of wall time are not enough
            return thread.session.frame.time > 0.1

    qtbot.waitUntil(ran)
    with thread.lock:
        assert len(thread.ticks) == thread.session.frame.tick
    assert thread.real_time_factor > 0
    thread.paused = True
    with thread.lock:
        tick = thread.session.frame.tick
    thread.stop()
    assert thread.session.frame.tick == tick


class GatedSession(Session):
    """A real session whose ticks are slow: each waits for a turn of ``gate``."""

    def __init__(self, prepared):
        super().__init__(prepared)
        self.gate = threading.Semaphore(0)
        self.entered = threading.Event()

    def tick(self):
        """Wait for a turn."""
        self.entered.set()
        self.gate.acquire()
        return super().tick()


def test_lock_is_released_after_each_tick(prepared, qtbot):
    session = GatedSession(prepared)
    seen = []
    runner = ThreadRunner(session, lambda _frame: None, clock=accumulate(repeat(0.1)).__next__)
    runner.start()
    assert session.entered.wait(10)

    def ask():
        with runner.lock:
            seen.append(session.frame.tick)

    asking = threading.Thread(target=ask)
    asking.start()
    qtbot.waitUntil(lambda: runner.lock._turn.locked())
    session.gate.release(1000)
    asking.join()
    runner.stop()
    assert seen == [1], "a batch is twenty ticks"


def looks(*gaps):
    """Return a clock with these gaps [s] between calls that then stops, and an event that is set at its end."""
    ended = threading.Event()
    shown = chain(accumulate(gaps, initial=0.0), repeat(sum(gaps)))
    count = iter(range(10**9))

    def clock():
        if next(count) > len(gaps):
            ended.set()
        return next(shown)

    return clock, ended


@pytest.mark.parametrize(
    ("speed", "gaps", "ticks"),
    [
        (1.0, [0.010] * 10, 20),
        (0.5, [0.010] * 10, 10),
        (2.0, [0.010] * 10, 40),
        (1.0, [0.007] * 10, 14),
        (0.5, [3600.0], 10),
        (0.5, [0.15, 0.010], 11),
    ],
)
def test_session_runs_at_the_requested_speed_and_catches_up_a_tenth_of_a_second(session, speed, gaps, ticks):
    clock, ended = looks(*gaps)
    reported = []
    runner = ThreadRunner(session, reported.append, speed=speed, clock=clock)
    runner.start()
    assert ended.wait(10)
    runner.stop()
    assert len(reported) == ticks


def test_session_pauses_while_the_window_reads_no_frames(session):
    """Half a second of looks a hundredth apart, and the frames are taken once: after two tenths the session waits."""
    clock, ended = looks(*[0.010] * 50)
    ticks_when_taken = 25
    reported = []

    def each(frame):
        reported.append(frame.tick)
        if frame.tick == ticks_when_taken:
            runner.take_recent()

    runner = ThreadRunner(session, each, clock=clock)
    runner.start()
    assert ended.wait(10)
    runner.stop()
    unread = UNREAD_SECONDS / session.prepared.scene.tick
    assert ticks_when_taken + unread <= len(reported) <= ticks_when_taken + unread + 4, "and 2 ticks are due a look"


def test_time_beyond_the_speed_of_the_machine_is_dropped(session):
    """A clock that jumps an hour a look: the session does a bounded batch, not an hour's worth."""
    looks = iter(range(10**6))
    runner = ThreadRunner(session, lambda _frame: None, clock=lambda: 3600.0 * next(looks))
    runner.start()
    runner.stop()
    assert session.frame.time < 60.0
    assert runner.real_time_factor < 0.01


class SlowToAsk(FailingSession):
    """A real session that takes an input only when ``gate`` opens, as one that builds shapes for a first path."""

    def __init__(self, prepared):
        super().__init__(prepared)
        self.gate = threading.Event()
        self.asked_by = []

    def submit(self, session_input):
        """Wait for the gate."""
        self.asked_by.append(threading.current_thread().name)
        assert self.gate.wait(10)
        super().submit(session_input)


def test_submit_does_not_wait_for_the_session(prepared, qtbot):
    session = SlowToAsk(prepared)
    runner = ThreadRunner(session, lambda _frame: None)
    runner.start()
    requested = replace(session.effects, timestep=0.0025)
    runner.submit(EffectsChanged(replace(session.effects, timestep=0.003)))
    runner.submit(EffectsChanged(requested))
    session.gate.set()
    qtbot.waitUntil(lambda: session.effects == requested)
    runner.stop()
    assert set(session.asked_by) == {"session"}
    assert "whole number" in str(runner.failure), "the first request was applied first and rejected"


def test_inputs_while_paused_are_applied_at_once_and_in_order(session):
    runner = ThreadRunner(session, lambda _frame: None)
    requested = [replace(session.effects, timestep=step) for step in (0.0025, 0.00125)]
    runner.submit(EffectsChanged(requested[0]))
    runner.paused = True
    runner.submit(EffectsChanged(requested[1]))
    runner.step()
    assert session.effects == requested[1]
    runner.paused = False
    runner.submit(EffectsChanged(requested[0]))
    runner.step()
    assert session.effects == requested[0], "a step takes what still waits"
    runner.submit(EffectsChanged(requested[1]))
    runner.reset()
    runner.step()
    assert session.effects == requested[0], "and a reset forgets it"


def test_inputs_of_one_call_take_effect_in_the_same_tick(thread, qtbot):
    inputs = thread.session.inputs
    first = thread.session.settings
    reading = thread.session.runtime_settings.reading
    for number in range(1, 21):
        thread.submit(ControlChanged(replace(first, starts=number)), ReadingChanged(reading))
    qtbot.waitUntil(lambda: sum(isinstance(one, ReadingChanged) for _, one in tuple(inputs)) == 20, timeout=20_000)
    given = [(tick, one.settings.starts) for tick, one in inputs if isinstance(one, ControlChanged)][-20:]
    assert [number for _, number in given] == list(range(1, 21))
    assert [tick for tick, _ in given] == [tick for tick, one in inputs if isinstance(one, ReadingChanged)]


def test_unexpected_error_of_an_input_is_reported(thread, qtbot, monkeypatch):
    monkeypatch.setattr(thread.session, "submit", lambda _input: 1 / 0)
    thread.submit(EffectsChanged(thread.session.effects))
    qtbot.waitUntil(lambda: thread.failure is not None)
    assert thread.halted
    assert thread._thread.is_alive()


@pytest.mark.parametrize("why", ["diverged", "unexpected failure"])
def test_failure_on_the_thread_is_stored_for_the_window(thread, qtbot, monkeypatch, tmp_path, why):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    with thread.lock:
        if why == "diverged":
            diverge(thread.session)
        else:
            thread.session.broken = ZeroDivisionError(why)
    qtbot.waitUntil(lambda: thread.failure is not None)
    assert thread.paused
    assert thread.halted
    assert thread._thread.is_alive(), "the thread lives on, so that a reset can help"
    assert why in str(thread.failure)
