"""A session's way of reading contacts: from the scene, live, replayed; and by a skin believed to lie elsewhere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.contacts.estimators.names import ESTIMATORS
from app.contacts.reading_settings import ReadingSettings
from app.errors import RecordingError, SceneError
from app.maps.build import build_map
from app.recording.player import Player
from app.recording.recorder import Recorder
from app.recording.verify import verify
from app.session.inputs import EffectsChanged, ReadingChanged
from app.session.session import Session
from app.skin.misplace import misplaced
from app.touch.poke import Finger, PokePressed
from app.touch.sensor.effects import SensorEffects
from app.touch.sensor.noise import Noise
from tests.touch import arm, prepared_bar

BAR = prepared_bar()
FORCE = Finger(max_force=5.0, speed=1.0)


def pressed(prepared=BAR, *, taxels=(30,), ticks=60, **said) -> Session:
    """Fingers press above these taxels."""
    session = Session(prepared, scripted=False, **said)
    for number, taxel in enumerate(taxels, start=1):
        session.submit(PokePressed(number, prepared.skin.taxel_point(taxel), FORCE))
    for _ in range(ticks):
        session.tick()
    return session


def test_the_scene_says_how_contacts_are_read():
    said = replace(BAR, scene=replace(BAR.scene, reading={"estimator": "lumped", "threshold": 3000}))
    assert Session(said).rules.reading == ReadingSettings("lumped", 3000.0)
    assert Session(said, reading=ReadingSettings()).rules.reading == ReadingSettings()
    assert Session(BAR).rules.reading == ReadingSettings()


def test_a_scene_that_says_it_wrongly_is_refused():
    with pytest.raises(SceneError, match="contacts.estimator"):
        Session(replace(BAR, scene=replace(BAR.scene, reading={"estimator": "guess"})))


@pytest.mark.parametrize("name", ESTIMATORS)
def test_control_sees_what_the_estimator_found(name):
    frame = pressed(reading=ReadingSettings(name)).frame
    (region,), (poke,) = frame.regions, frame.pokes
    assert bool(frame.estimates) == (name != "area-sum")
    if frame.estimates:
        told = frame.estimates[region.id]
        assert told.refused == ""
        assert region.force == told.force
    assert region.force == pytest.approx(poke.force, rel=0.25)
    if name == "lumped":
        assert region.force == pytest.approx(poke.force, rel=1e-12)
        assert region.point == pytest.approx(BAR.skin.position(poke.at), abs=1e-9)


def test_two_contacts_of_a_link_are_one_to_a_sensor_in_it():
    taxels = (
        int(BAR.skin.patches[0].taxels.positions[:, 0].argmin()),
        int(BAR.skin.patches[0].taxels.positions[:, 0].argmax()),
    )
    assert len(pressed(taxels=taxels).frame.regions) == 2
    frame = pressed(taxels=taxels, reading=ReadingSettings("lumped")).frame
    (region,) = frame.regions
    assert region.force == pytest.approx(sum(poke.force for poke in frame.pokes))
    assert 0.1 < region.point[0] < 0.3, "between them, where nothing touches"


def test_it_changes_live_and_who_is_touched_stays():
    session = pressed()
    session.submit(ReadingChanged(ReadingSettings("tikhonov", threshold=2000.0)))
    before = session.frame.regions[0]
    assert not session.frame.estimates
    frame = session.tick()
    assert session.rules.reading == ReadingSettings("tikhonov", 2000.0)
    assert frame.estimates.keys() == {before.id}
    assert not frame.events
    assert session.inputs[-1][0] == frame.tick


def test_a_higher_threshold_reads_less():
    peak = pressed().frame.regions[0].peak
    assert len(pressed(reading=ReadingSettings(threshold=0.9 * peak)).frame.regions) == 1
    assert pressed(reading=ReadingSettings(threshold=1.1 * peak)).frame.regions == ()


def test_a_higher_threshold_lets_go_live():
    session = pressed()
    session.submit(ReadingChanged(ReadingSettings(threshold=1.9 * session.frame.regions[0].peak)))
    assert len(session.tick().regions) == 1, "what is touched stays so down to half of it"
    session.submit(ReadingChanged(ReadingSettings(threshold=2.1 * session.frame.regions[0].peak)))
    assert session.tick().regions == ()


def test_the_sensors_noise_has_the_scenes_seed():
    reading, other = ReadingSettings("lumped", wrench_noise=0.1), replace(BAR, scene=replace(BAR.scene, seed=1))
    forces = [pressed(prepared, reading=reading).frame.regions[0].force for prepared in (BAR, BAR, other)]
    assert forces[0] == forces[1] != forces[2]


def test_the_threshold_follows_the_noise_in_force():
    session = Session(BAR, scripted=False)
    loud = replace(session.effects, sensor=SensorEffects(noise=Noise(5000.0)))
    session.submit(EffectsChanged(loud))
    assert [session.tick().regions for _ in range(200)] == [()] * 200
    below = Session(BAR, scripted=False, effects=loud, reading=ReadingSettings(threshold=1000.0))
    touched = [len(below.tick().pressures[below.frame.pressures > 1000.0]) for _ in range(50)]
    assert min(touched) > 0, "the noise does reach the usual threshold"


def test_a_reset_keeps_it_and_a_replay_knows_it(tmp_path):
    session = Session(BAR, scripted=False)
    session.submit(ReadingChanged(ReadingSettings("lumped", wrench_noise=0.1)))
    session.tick()
    session.reset()
    assert session.rules.reading.estimator == "lumped"
    session.submit(PokePressed(1, BAR.skin.taxel_point(30), FORCE))
    with Recorder(tmp_path / "lumped.mcap", BAR) as recorder:
        for tick in range(80):
            if tick == 60:
                session.submit(ReadingChanged(ReadingSettings("local-nnls")))
            recorder.write(session.tick(), session.inputs)
    player = Player(tmp_path / "lumped.mcap")
    assert player.rules_at(0).reading == ReadingSettings("lumped", wrench_noise=0.1)
    assert player.rules_at(80).reading == ReadingSettings("local-nnls")
    assert player.frame(50).estimates, "what is compared"
    assert verify(player).identical


def test_an_estimate_that_differs_is_noticed(tmp_path):
    session = Session(BAR, scripted=False, reading=ReadingSettings("lumped"))
    session.submit(PokePressed(1, BAR.skin.taxel_point(30), FORCE))
    with Recorder(tmp_path / "one.mcap", BAR) as recorder:
        for _ in range(40):
            recorder.write(session.tick(), session.inputs)
    player = Player(tmp_path / "one.mcap")
    player.inputs = [(tick, act) for tick, act in player.inputs if not isinstance(act, ReadingChanged)]
    assert not verify(player).identical


@pytest.mark.parametrize("name", ESTIMATORS)
def test_a_skin_that_is_believed_to_lie_elsewhere_places_contacts_there(name):
    prepared, reading = arm(), ReadingSettings(name)
    believed = misplaced(prepared.skin, 0.003, seed=1)
    taxel = int(prepared.skin.first[1]) + 20
    true = pressed(prepared, taxels=(taxel,), reading=reading, ticks=40).frame
    frame = pressed(prepared, taxels=(taxel,), reading=reading, ticks=40, map_=build_map(believed)).frame
    assert np.array_equal(frame.pressures, true.pressures), "what is felt is the true skin's"
    (region,), (other,) = frame.regions, true.regions
    assert np.array_equal(region.taxels, other.taxels)
    assert region.point == pytest.approx(believed.position(region.at), abs=1e-9)
    assert 1e-4 < np.linalg.norm(region.point - other.point) < 0.015
    if name == "area-sum":
        assert region.force == other.force, "areas are known"


def test_a_recording_does_not_pretend_to_hold_another_skin(tmp_path):
    session = Session(BAR, map_=build_map(misplaced(BAR.skin, 0.003)))
    refused = pytest.raises(RecordingError, match="believed to lie elsewhere")
    with Recorder(tmp_path / "believed.mcap", BAR) as recorder, refused:
        recorder.write(session.tick(), session.inputs)
