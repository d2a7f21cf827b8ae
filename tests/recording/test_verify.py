"""A recording can be run again, bit for bit; and a changed one is caught."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.core.errors import RecordingError
from tactile_maps.editing.arrange import rotate
from tactile_maps.editing.document import MapDocument
from tactile_maps.recording.file.damage import DamageKind
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import Recorder, record
from tactile_maps.recording.recover import recover
from tactile_maps.recording.verify import Resimulation, verify
from tactile_maps.session.inputs import MapEdited, PosturePlaced, RestChanged
from tactile_maps.session.session import Session
from tactile_maps.stimuli.stimulus_kinds import Stroke
from tactile_maps.tactile.poke import Finger, PokePressed, PokeReleased
from tests.support.pressed_arm import forearm
from tests.support.recordings import small_arm


@pytest.mark.long
def test_same_inputs_reproduce_the_run(recording):
    outcome = verify(RecordingPlayer(recording))
    assert outcome.frames == 200
    assert outcome.identical
    assert outcome.max_difference == 0.0
    assert outcome.first_difference is None


@pytest.mark.parametrize("pressed", [False, True], ids=["script", "pressed by the user"])
def test_continued_recording_plays_the_script_unless_a_press_had_ended_it(tmp_path, pressed):
    arm = small_arm()
    stroke = Stroke(patch="forearm", start=(0.4, 0.3), end=(0.6, 0.3), speed=0.2, hold=0.4, rest=0.2)
    prepared = replace(arm, scene=replace(arm.scene, stimuli=(stroke,)))
    session = Session(prepared)
    with Recorder(prepared, tmp_path / "a.mcap") as recorder:
        for tick in range(60):
            if pressed and tick == 30:
                session.submit(PokePressed(1, prepared.skin.taxel_point(30)))
            recorder.write(session.tick(), session.inputs)
    again = Resimulation(RecordingPlayer(tmp_path / "a.mcap"))
    again.frame(60)
    continued = again.session
    assert continued.frame.pokes
    continued.continue_script()
    assert continued.scripted is not pressed
    lifts = 0
    for _ in range(150):  # the finger of the script lifts and presses again
        before = continued.frame.pokes
        assert continued.tick().pressures.tobytes() == session.tick().pressures.tobytes()
        lifts += bool(before) and not continued.frame.pokes
    assert (lifts > 0) is not pressed


@pytest.mark.long
def test_missing_input_is_detected(recording):
    player = RecordingPlayer(recording)
    kept = [(tick, act) for tick, act in player.inputs if not (isinstance(act, PokeReleased) and act.id == 1)]
    assert len(kept) == len(player.inputs) - 1
    player.inputs = kept
    outcome = verify(player)
    assert not outcome.identical
    assert outcome.first_difference == 201
    assert outcome.max_difference > 0


def with_stiffness(player, number, factor):
    """The inputs with the stiffness of one finger changed."""
    tick, press = player.inputs[number]
    finger = replace(press.finger, stiffness=press.finger.stiffness * factor)
    return [*player.inputs[:number], (tick, replace(press, finger=finger)), *player.inputs[number + 1 :]]


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("factor", [1.001, 1 + 1e-9, 1 + 2.3e-16])
def test_changed_digit_of_a_finger_stiffness_is_detected_at_its_tick(recording, factor):
    """Also in a finger that had let go before the first frame, and in the last bit."""
    player = RecordingPlayer(recording)
    presses = [number for number, (_, act) in enumerate(player.inputs) if isinstance(act, PokePressed)]
    assert len(presses) == 2
    whole = list(player.inputs)
    for number in presses:
        player.inputs = list(whole)
        player.inputs = with_stiffness(player, number, factor)
        outcome = verify(player)
        assert not outcome.identical
        assert outcome.first_difference == max(player.inputs[number][0], 51)


@pytest.mark.long
def test_finger_that_never_pressed_may_differ(prepared, tmp_path):
    """A finger that does not advance never pushes, so no frame depends on its spring and a change is not noticed."""
    session = Session(prepared, scripted=False)
    path = tmp_path / "still.mcap"
    with Recorder(prepared, path) as recorder:
        for tick in range(40):
            if tick == 10:
                session.submit(PokePressed(1, prepared.skin.taxel_point(3), Finger(speed=0.0)))
            recorder.write(session.tick(), session.inputs)
    player = RecordingPlayer(path)
    number = next(n for n, (_, act) in enumerate(player.inputs) if isinstance(act, PokePressed) and act.id == 1)
    player.inputs = with_stiffness(player, number, 2.0)
    assert verify(player).identical
    assert not any(poke.force for frame in player for poke in frame.pokes if poke.id == 1)


@pytest.mark.long
def test_nan_values_are_compared(recording):
    """A frame whose limits were changed, its state being the same."""
    player = RecordingPlayer(recording)
    frame = player.frame(150)
    decoded = player.frame
    changed = replace(frame, why_limited=(Limit(LimitKind.FORCE_CAP),))
    player.frame = lambda number: changed if number == 150 else decoded(number)
    outcome = verify(player)
    assert not outcome.identical
    assert outcome.first_difference == frame.tick
    assert outcome.max_difference == 0.0


@pytest.mark.long
def test_other_versions_are_reported(recording):
    player = RecordingPlayer(recording)
    player.versions = player.versions | {"mujoco": "3.0.0"}
    (changed,) = verify(player).other_versions
    assert "mujoco 3.0.0" in changed


@pytest.mark.long
def test_progress_may_cancel(recording):
    class Cancelled(Exception):
        pass

    def stop(_text, _fraction):
        raise Cancelled

    with pytest.raises(Cancelled):
        verify(RecordingPlayer(recording), progress=stop)


@pytest.mark.long
def test_recovered_recording_is_verified(recording, tmp_path):
    cut = tmp_path / "cut.mcap"
    data = recording.read_bytes()
    cut.write_bytes(data[: int(0.97 * len(data))])
    saved = recover(cut, tmp_path / "fixed.mcap")
    assert [damage.kind for damage in saved.damage] == [DamageKind.CUT_OFF]
    assert 0 < saved.frames <= 200
    assert verify(RecordingPlayer(tmp_path / "fixed.mcap")).identical


def test_recover_does_not_change_its_source(recording, tmp_path):
    with pytest.raises(RecordingError, match="into itself"):
        recover(recording, recording)
    taken = tmp_path / "taken.mcap"
    taken.write_text("mine")
    with pytest.raises(RecordingError, match="already exists"):
        recover(recording, taken)
    assert taken.read_text() == "mine"


def test_map_edit_is_replayed_at_its_tick(recording):
    player = RecordingPlayer(recording)
    ((tick, act),) = [(tick, act) for tick, act in player.inputs if isinstance(act, MapEdited)]
    assert player.runtime_settings_at(tick - 1).map is player.prepared.map
    assert player.runtime_settings_at(tick).map is act.map
    assert player.runtime_settings_at(10**6).map is act.map
    assert [name for _, name in player.edits()] == ["Move"]


@pytest.mark.long
def test_session_started_on_an_edited_map_is_replayed_on_it(prepared, tmp_path):
    session = Session(prepared)
    edited = rotate(MapDocument.of(prepared.map), [0, 1], 1.0).map
    session.submit(MapEdited("Rotate", edited))
    session.tick()
    session.reset()
    assert session.map is edited
    session.submit(PokePressed(1, prepared.skin.taxel_point(30)))
    with Recorder(prepared, tmp_path / "edited.mcap") as recorder:
        for _ in range(120):
            recorder.write(session.tick(), session.inputs)
    player = RecordingPlayer(tmp_path / "edited.mcap")
    assert player.runtime_settings_at(0).map.layout == edited.layout
    assert verify(player).identical
    region = player.frame(len(player) - 1).regions[0]
    assert np.allclose(region.map_point, edited.to_map(region.at), atol=1e-12)


@pytest.mark.long
def test_moved_rest_posture_is_reproduced_bit_for_bit(tmp_path):
    session = Session(forearm())
    path = tmp_path / "rest.mcap"
    with record(session, path):
        for number in range(20):
            posture = tuple(session.prepared.robot.home + 0.01 * number)
            session.submit(RestChanged(posture) if number % 5 else RestChanged(posture, 0.5))
            if number == 12:
                session.submit(PosturePlaced(posture))
            session.tick()
    player = RecordingPlayer(path)
    assert sum(isinstance(act, RestChanged) for _, act in player.inputs) == 20
    assert sum(isinstance(act, PosturePlaced) for _, act in player.inputs) == 1
    assert verify(player).identical
    player.inputs = [(tick, act) for tick, act in player.inputs if not (isinstance(act, RestChanged) and tick == 9)]
    assert not verify(player).identical
