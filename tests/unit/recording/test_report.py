"""What stopped a session can be kept, and stops again wherever it is replayed."""

from __future__ import annotations

import pytest

from app.control.command import ControlSettings
from app.errors import RecordingError, SimulationError
from app.recording.player import Player
from app.recording.recorder import Recorder
from app.recording.recover import recover
from app.recording.report import save_report
from app.recording.verify import verify
from app.session.session import Session
from app.touch.poke import Finger, PokePressed
from tests.touch import prepared_bar

UNSTEADY = prepared_bar(tick=0.01, wishes={"integrator": "euler", "timestep": 0.01, "gravity": "on"})
STIFF = ControlSettings(stiffness=40.0, damping_ratio=3.0)


def stopped(*, path=None) -> Session:
    """A session that went on until it diverged; recorded from its first tick where there is a path."""
    session = Session(UNSTEADY, settings=STIFF)
    session.submit(PokePressed(1, UNSTEADY.skin.taxel_point(30), Finger(stiffness=10.0)))
    recorder = Recorder(path, UNSTEADY) if path else None
    with pytest.raises(SimulationError, match="diverged"):
        until_it_stops(session, recorder)
    if recorder:
        recorder.fail(session.failure)
        recorder.close()
    return session


def until_it_stops(session, recorder) -> None:
    while session.frame.tick < 400:
        frame = session.tick()
        if recorder:
            recorder.write(frame, session.inputs)


def test_a_report_stops_again_at_the_same_tick_with_the_same_words(tmp_path):
    session = stopped()
    path = save_report(session, tmp_path / "report.mcap")
    player = Player(path)
    tick, error = player.failure
    assert (tick, str(error)) == (session.failure.tick, session.failure.problem)
    outcome = verify(player)
    assert outcome.identical
    assert outcome.frames == 1
    assert outcome.stopped == session.failure.problem


def test_a_recording_of_the_whole_run_ends_so_too(tmp_path):
    session = stopped(path=tmp_path / "run.mcap")
    outcome = verify(Player(tmp_path / "run.mcap"))
    assert (outcome.identical, outcome.frames) == (True, session.frame.tick)
    assert outcome.stopped == session.failure.problem


def test_a_recovered_report_still_stops(tmp_path):
    save_report(stopped(), tmp_path / "report.mcap")
    recover(tmp_path / "report.mcap", tmp_path / "again.mcap")
    assert verify(Player(tmp_path / "again.mcap")).stopped


@pytest.mark.parametrize("later", [-1, 1])
def test_stopping_at_another_tick_is_noticed(tmp_path, later):
    save_report(stopped(), tmp_path / "report.mcap")
    player = Player(tmp_path / "report.mcap")
    tick, error = player.failure
    player.failure = (tick + later, error)
    outcome = verify(player)
    assert not outcome.identical
    assert outcome.stopped is None
    assert outcome.first_difference == tick + min(later, 0)


def test_other_words_are_noticed_and_so_is_a_stop_that_was_not_recorded(tmp_path):
    session = stopped(path=tmp_path / "run.mcap")
    player = Player(tmp_path / "run.mcap")
    tick, _ = player.failure
    player.failure = (tick, SimulationError("the moon fell down"))
    assert verify(player).first_difference == tick == session.failure.tick
    player.inputs = [item for item in player.inputs if item[0] == 0]
    player.failure = None
    assert not verify(player).identical, "without the finger it does not move as recorded"


def test_a_session_that_goes_on_has_nothing_to_report(tmp_path):
    with pytest.raises(RecordingError, match="nothing to report"):
        save_report(Session(UNSTEADY), tmp_path / "report.mcap")
    assert not (tmp_path / "report.mcap").exists()
