"""What a person may change while a session runs: effects, behaviours, the reading of contacts."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest

from tactile_maps.contacts.force_estimation.estimate import ESTIMATORS
from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.behaviours import Behaviour, trigger_text
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import MapError, RecordingError, SceneError, SimulationError
from tactile_maps.maps.build import build_map
from tactile_maps.maps.learned.as_tactile_map import learned_tactile_map
from tactile_maps.maps.learned.learned_map import LearnedMap
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import Recorder
from tactile_maps.recording.verify import verify
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.motion import Waypoint
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.session.inputs import (
    BehavioursChanged,
    ControlChanged,
    EffectsChanged,
    MapEdited,
    PosturePlaced,
    ReadingChanged,
    RestChanged,
)
from tactile_maps.session.session import Session
from tactile_maps.skin.calibration_error import with_area_error, with_calibration_error, with_sleeve_displaced
from tactile_maps.skin.model.skin import Skin
from tactile_maps.stimuli.stimulus_kinds import Poke, Stroke
from tactile_maps.tactile.poke import Finger, PokePressed, PokeReleased
from tactile_maps.tactile.sensors.sensor_effects import Noise, Sampling, SensorEffects
from tests.support.pressed_arm import forearm
from tests.support.scene_objects import thing
from tests.support.touch import arm, bar_skin, prepared_bar, taxel_near

STROKED_BAR = prepared_bar(stimuli=(Stroke(hold=0.1),))
AT = STROKED_BAR.skin.taxel_point(30)


def quiet(prepared=STROKED_BAR) -> Session:
    return Session(prepared, scripted=False)


def test_every_stage_is_timed_and_there_is_none_without_its_effect():
    session = quiet()
    assert list(session.tick().timings.ms) == ["physics", "touch", "contacts", "control"]
    noisy = replace(session.effects, sensor=SensorEffects(noise=Noise()))
    session.submit(EffectsChanged(noisy))
    assert list(session.tick().timings.ms) == ["physics", "touch", "noise", "contacts", "control"]
    session.submit(EffectsChanged(replace(noisy, skin="off")))
    frame = session.tick()
    assert list(frame.timings.ms) == ["physics", "control"]
    assert not frame.pressures.any()


def test_effects_change_at_the_next_tick_and_only_them():
    session = quiet()
    other = quiet()
    for run in (session, other):
        run.submit(PokePressed(1, AT))
        for _ in range(30):
            run.tick()
    wanted = replace(session.effects, sensor=SensorEffects(noise=Noise()))
    session.submit(EffectsChanged(wanted))
    assert session.effects == STROKED_BAR.scene.effects, "at the next tick, not now"
    frame = session.tick()
    plain = other.tick()
    assert session.effects == wanted
    assert session.inputs[-1] == (31, EffectsChanged(wanted))
    assert np.array_equal(frame.posture, plain.posture), "the state stays"
    assert [poke.force for poke in frame.pokes] == [poke.force for poke in plain.pokes]
    assert not np.array_equal(frame.pressures, plain.pressures)
    session.reset()
    assert session.inputs[1:] == [(0, EffectsChanged(wanted))], "effects in force stay, and a replay knows them"


def test_a_finer_time_step_is_stepped_as_often_as_a_tick_needs():
    session = quiet()
    session.submit(EffectsChanged(replace(session.effects, timestep=0.0005)))
    for _ in range(20):
        session.tick()
    assert session._simulation.time == pytest.approx(session.frame.time)


def test_fingers_that_are_off_keep_the_scripted_hand_away():
    session = Session(STROKED_BAR)
    assert session.tick().pokes
    off = replace(session.effects, fingers=False)
    session.submit(EffectsChanged(off))
    assert all(not session.tick().pokes for _ in range(300))
    session.submit(EffectsChanged(replace(off, fingers=True)))
    assert any(session.tick().pokes for _ in range(2000)), "the script went on meanwhile"


def test_fingers_switched_off_just_when_the_script_presses_are_no_failure():
    session = Session(prepared_bar(stimuli=(Poke(hold=0.01, rest=0.005),)))
    on = session.effects
    felt = 0
    for number in range(60):
        session.submit(EffectsChanged(replace(on, fingers=number % 4 < 2)))
        felt += len(session.tick().pokes)
    assert felt > 5


def test_a_motion_moves_what_the_controller_holds():
    session = Session(prepared_bar(motion=(Waypoint(posture=(0.5,), seconds=1.0, rest=5.0),)))
    assert session.frame.command.posture == [0.0]
    for _ in range(100):
        session.tick()
    assert session.frame.command.posture == pytest.approx([0.25]), "half way after half the time"
    for _ in range(400):
        session.tick()
    assert session.frame.posture == pytest.approx([0.5], abs=0.01)
    session.reset()
    assert session.frame.command.posture == [0.0]


def test_objects_have_poses_in_every_frame():
    ball = ObjectSpec("ball", "sphere", size=(0.05,), at=(1.0, 2.0, 3.0), mass=0.1)
    prepared = prepared_bar(objects=(ball,), task="push", overrides={"gravity": "on"})
    session = quiet(replace(prepared, objects=make_objects(prepared.scene)))
    assert session.frame.objects.shape == (1, 4, 4)
    assert session.frame.objects[0, :3, 3] == pytest.approx([1, 2, 3])
    for _ in range(20):
        session.tick()
    assert session.frame.objects[0, 2, 3] == pytest.approx(3 - 0.5 * 9.81 * 0.1**2, abs=1e-3), "it falls"


def test_a_scripted_finger_that_is_refused_ends_the_show_and_time_goes_on():
    stiff = Stroke(start=(0.95, 0.5), end=(0.9, 0.5), stiffness=1e6)
    session = Session(prepared_bar(stimuli=(stiff,)))
    with pytest.raises(SimulationError, match="too stiff"):
        session.tick()
    assert not session.scripted
    assert [session.tick().tick for _ in range(3)] == [1, 2, 3]


PLACE = prepared_bar().skin.taxel_point(taxel_near(prepared_bar().skin, 0, (0.3, 0.0, 0.02)))
DOUBLE = Behaviour("tap", times=2, then={"controller": "hybrid", "task": "retreat"})
PRESSED = Behaviour("press", until_released=True, then={"force_goal": 1.0})


def session_with(*behaviours: Behaviour) -> Session:
    return Session(prepared_bar(control={"controller": "hybrid"}, behaviours=tuple(map(asdict, behaviours))))


def tap(session: Session, *, ticks: int = 20) -> None:
    taxel = taxel_near(session.prepared.skin, 0, (0.3, 0.0, 0.02))
    session.submit(PokePressed(1, session.prepared.skin.taxel_point(taxel), Finger(speed=0.05)))
    for _ in range(ticks):
        session.tick()
    assert session.frame.regions, "it was felt"
    session.submit(PokeReleased(1))
    for _ in range(40):
        session.tick()
    assert not session.frame.regions


def derived(session: Session) -> list[str]:
    return [trigger_text(act.by) for _, act in session.inputs if isinstance(act, ControlChanged) and act.by]


def test_a_double_tap_makes_the_arm_retreat():
    session = session_with(DOUBLE)
    tap(session)
    assert session.settings.task == "keep_force"
    tap(session)
    assert session.settings.task == "retreat"
    assert derived(session) == ["double tap"]


def test_while_pressed_another_goal_holds():
    session = session_with(PRESSED)
    skin = session.prepared.skin
    session.submit(PokePressed(1, skin.taxel_point(taxel_near(skin, 0, (0.3, 0.0, 0.02)))))
    for _ in range(100):
        session.tick()
    assert session.settings.force_goal == 1.0
    session.submit(PokeReleased(1))
    for _ in range(100):
        session.tick()
    assert session.settings.force_goal == ControlSettings().force_goal
    assert derived(session) == ["press", "released"]


def pressed_session(sampling: Sampling | None = None) -> Session:
    """Pressed for half a second, so that another goal holds until the release."""
    effects = Effects(sensor=SensorEffects(sampling=sampling))
    prepared = prepared_bar(control={"controller": "hybrid"}, behaviours=(asdict(PRESSED),))
    session = Session(prepared, effects=effects)
    session.submit(PokePressed(1, PLACE, Finger(speed=0.1)))
    for _ in range(100):
        session.tick()
    assert session.settings.force_goal == 1.0
    return session


def test_one_sample_that_a_slow_skin_missed_is_no_release():
    session = pressed_session(Sampling(10.0))
    session.submit(PokeReleased(1))
    missed = 0
    for _ in range(25):
        missed += not session.tick().regions
    session.submit(PokePressed(1, PLACE, Finger(speed=0.5)))
    for _ in range(60):
        missed += not session.tick().regions
        assert session.settings.force_goal == 1.0
    assert 0 < missed <= 30, "in a sample or so nothing was felt"
    assert session.frame.regions
    assert derived(session) == ["press"]


def test_a_reset_brings_back_what_a_release_would_have():
    session = pressed_session()
    session.reset()
    assert session.settings.force_goal == ControlSettings().force_goal
    assert session.inputs[0] == (0, ControlChanged(session.settings)), "and a replay starts with that"


def test_behaviours_can_be_changed_while_it_runs_and_outlive_a_reset():
    session = session_with()
    session.submit(BehavioursChanged((DOUBLE,)))
    session.tick()
    session.reset()
    assert session.runtime_settings.behaviours == (DOUBLE,)
    assert (0, BehavioursChanged((DOUBLE,))) in session.inputs
    tap(session)
    tap(session)
    assert session.settings.task == "retreat"


def test_behaviours_for_other_skin_are_refused_and_the_old_ones_stay():
    session = session_with(DOUBLE)
    session.submit(BehavioursChanged((Behaviour("tap", "elbow", then={"task": "guide"}),)))
    with pytest.raises(SceneError, match="elbow"):
        session.tick()
    session.tick()
    assert session.runtime_settings.behaviours == (DOUBLE,)


def test_what_a_behaviour_did_is_not_taken_from_outside():
    session = session_with(DOUBLE)
    session.submit(ControlChanged(ControlSettings(controller="qp"), by=DOUBLE))
    session.tick()
    assert session.settings.controller == "hybrid"


def test_a_recording_replays_what_behaviours_did(tmp_path):
    prepared = arm()
    scene = replace(prepared.scene, stimuli=(), control={"controller": "hybrid"}, behaviours=(asdict(PRESSED),))
    prepared = replace(prepared, scene=scene)
    session = Session(prepared)
    with Recorder(prepared, tmp_path / "r.mcap") as recorder:
        for tick in range(360):
            if tick == 10:
                session.submit(PokePressed(1, prepared.skin.taxel_point(40)))
            if tick == 160:
                session.submit(BehavioursChanged((PRESSED, DOUBLE)))
                session.submit(PokeReleased(1))
            recorder.write(session.tick(), session.inputs)
    assert derived(session) == ["press", "released"]
    player = RecordingPlayer(tmp_path / "r.mcap")
    assert player.runtime_settings_at(0).behaviours == (PRESSED,)
    assert player.runtime_settings_at(200).behaviours == (PRESSED, DOUBLE)
    assert player.inputs == session.inputs
    assert verify(player).identical


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
    assert Session(said).runtime_settings.reading == ReadingSettings("lumped", 3000.0)
    assert Session(said, reading=ReadingSettings()).runtime_settings.reading == ReadingSettings()
    assert Session(BAR).runtime_settings.reading == ReadingSettings()


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
        assert told.refused is None
        assert region.force == told.force
    assert region.force == pytest.approx(poke.force, rel=0.25)
    if name == "lumped":
        assert region.force == pytest.approx(poke.force, rel=1e-12)
        assert region.link_position == pytest.approx(BAR.skin.position(poke.at), abs=1e-9)


def test_a_sensor_in_the_link_reads_the_impulse_of_an_impact():
    """Over the whole tick where time averaging is on, as the skin does."""
    mass = 0.2
    speed = 0.4
    ball = thing("sphere", at=(0.15, 0.0, 0.041), mass=mass, guided=True)
    effects = Effects(contact="environment", gravity="off", timestep=5e-4, time_averaging=True)
    reading = ReadingSettings("lumped", threshold=1.0)
    session = Session(replace(prepared_bar(hinged=False), objects=(ball,)), effects=effects, reading=reading)
    session._simulation._data.qvel[0] = -speed
    session._simulation._physics.forward()
    frames = [session.tick() for _ in range(10)]
    impulse = sum(region.force for frame in frames for region in frame.regions) * 0.005
    assert impulse == pytest.approx(mass * (session._simulation._data.qvel[0] + speed), rel=0.02)


def test_two_contacts_of_a_link_are_one_to_a_sensor_in_it():
    taxels = (
        int(BAR.skin.patches[0].taxels.positions[:, 0].argmin()),
        int(BAR.skin.patches[0].taxels.positions[:, 0].argmax()),
    )
    assert len(pressed(taxels=taxels).frame.regions) == 2
    frame = pressed(taxels=taxels, reading=ReadingSettings("lumped")).frame
    (region,) = frame.regions
    assert region.force == pytest.approx(sum(poke.force for poke in frame.pokes))
    assert 0.1 < region.link_position[0] < 0.3, "between them, where nothing touches"


def test_it_changes_live_and_who_is_touched_stays():
    session = pressed()
    session.submit(ReadingChanged(ReadingSettings("tikhonov", threshold=2000.0)))
    before = session.frame.regions[0]
    assert not session.frame.estimates
    frame = session.tick()
    assert session.runtime_settings.reading == ReadingSettings("tikhonov", 2000.0)
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
    reading = ReadingSettings("lumped", wrench_noise=0.1)
    other = replace(BAR, scene=replace(BAR.scene, seed=1))
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
    assert session.runtime_settings.reading.estimator == "lumped"
    session.submit(PokePressed(1, BAR.skin.taxel_point(30), FORCE))
    with Recorder(BAR, tmp_path / "lumped.mcap") as recorder:
        for tick in range(80):
            if tick == 60:
                session.submit(ReadingChanged(ReadingSettings("local-nnls")))
            recorder.write(session.tick(), session.inputs)
    player = RecordingPlayer(tmp_path / "lumped.mcap")
    assert player.runtime_settings_at(0).reading == ReadingSettings("lumped", wrench_noise=0.1)
    assert player.runtime_settings_at(80).reading == ReadingSettings("local-nnls")
    assert player.frame(50).estimates, "what is compared"
    assert verify(player).identical


def test_an_estimate_that_differs_is_noticed(tmp_path):
    session = Session(BAR, scripted=False, reading=ReadingSettings("lumped"))
    session.submit(PokePressed(1, BAR.skin.taxel_point(30), FORCE))
    with Recorder(BAR, tmp_path / "one.mcap") as recorder:
        for _ in range(40):
            recorder.write(session.tick(), session.inputs)
    player = RecordingPlayer(tmp_path / "one.mcap")
    player.inputs = [(tick, act) for tick, act in player.inputs if not isinstance(act, ReadingChanged)]
    assert not verify(player).identical


@pytest.mark.parametrize("name", ESTIMATORS)
def test_a_skin_that_is_believed_to_lie_elsewhere_places_contacts_there(name):
    prepared = arm()
    reading = ReadingSettings(name)
    believed = with_calibration_error(prepared.skin, 0.003, seed=1)
    taxel = int(prepared.skin.first[1]) + 20
    true = pressed(prepared, taxels=(taxel,), reading=reading, ticks=40).frame
    frame = pressed(prepared, taxels=(taxel,), reading=reading, ticks=40, map_=build_map(believed)).frame
    assert np.array_equal(frame.pressures, true.pressures), "what is felt is the true skin's"
    (region,), (other,) = frame.regions, true.regions
    assert np.array_equal(region.taxels, other.taxels)
    assert region.link_position == pytest.approx(believed.position(region.at), abs=1e-9)
    assert 1e-4 < np.linalg.norm(region.link_position - other.link_position) < 0.015
    if name == "area-sum":
        assert region.force == other.force, "areas are known"


@pytest.mark.parametrize("error", [
    lambda skin: with_calibration_error(skin, 0.003, seed=1), lambda skin: with_area_error(skin, 0.8),
    lambda skin: with_sleeve_displaced(skin, shift=0.002),
], ids=["misplaced", "areas", "sleeve"])  # fmt: skip
def test_a_skin_that_is_believed_to_lie_elsewhere_is_recorded_and_simulated_again(error, tmp_path):
    prepared = arm()
    believed = error(prepared.skin)
    session = Session(prepared, scripted=False, map_=build_map(believed))
    session.submit(PokePressed(1, prepared.skin.taxel_point(int(prepared.skin.first[1]) + 20), FORCE))
    with Recorder(prepared, tmp_path / "believed.mcap") as recorder:
        for _ in range(40):
            recorder.write(session.tick(), session.inputs)
    player = RecordingPlayer(tmp_path / "believed.mcap")
    assert verify(player).identical
    assert session.frame.regions
    held = player.runtime_settings_at(0).map.skin
    assert np.array_equal(held.areas, believed.areas)
    for one, other in zip(held.patches, believed.patches, strict=True):
        assert np.array_equal(one.taxels.positions, other.taxels.positions)
    without = RecordingPlayer(tmp_path / "believed.mcap")
    without.inputs = [(tick, act) for tick, act in without.inputs if not isinstance(act, MapEdited)]
    assert not verify(without).identical


def test_a_recording_does_not_pretend_to_hold_a_learned_map(tmp_path):
    (patch,) = BAR.skin.patches
    learned = LearnedMap(patch.taxels.positions[:, :2], np.ones(len(BAR.skin), bool), "by hand", 0.0, None)
    session = Session(BAR, map_=learned_tactile_map(BAR.skin, learned))
    refused = pytest.raises(RecordingError, match="a map whose triangles are not the skin's")
    with Recorder(BAR, tmp_path / "learned.mcap") as recorder, refused:
        recorder.write(session.tick(), session.inputs)


def other_maps():
    """Maps of other skins: more taxels on the same link, as many on another link, a patch more."""
    more = Skin(bar_skin(80).patches)
    (patch,) = bar_skin().patches
    return [build_map(skin) for skin in (more, Skin((replace(patch, link="tip"),)), Skin((patch, patch)))]


@pytest.mark.parametrize("map_", other_maps(), ids=["more taxels", "another link", "a patch more"])
def test_the_map_of_another_skin_is_refused_and_the_session_is_as_if_it_had_not_come(map_):
    session, other = (Session(STROKED_BAR, scripted=False, settings=ControlSettings(stiffness=40.0)) for _ in range(2))
    for run in (session, other):
        run.submit(PokePressed(1, AT))
        run.tick()
    before = session.map
    with pytest.raises(MapError, match=r"the map is of another skin.*60 taxels on 1 patches"):
        session.submit(MapEdited("Other", map_))
    assert session.map is before
    assert session.inputs == other.inputs
    pairs = [(session.tick(), other.tick()) for _ in range(80)]
    assert any(frame.regions for frame, _ in pairs)
    for one, two in pairs:
        for region, as_before in zip(one.regions, two.regions, strict=True):
            assert region.map_point.tolist() == as_before.map_point.tolist()
    session.reset()
    assert session.map is before
    with pytest.raises(MapError, match="another skin"):
        Session(STROKED_BAR, map_=map_)


def test_an_edited_map_is_kept_without_what_follows_from_it():
    session = Session(STROKED_BAR, scripted=False)
    edited = TactileMap(session.map.skin, session.map.charts, session.map.layout)
    session.submit(MapEdited("Move", edited))
    session.tick()
    assert session.map is edited
    assert edited.uv
    (kept,) = (act for _, act in session.inputs if isinstance(act, MapEdited))
    assert "uv" not in vars(kept.map)


def test_the_arm_goes_to_another_rest_posture_and_a_reset_forgets_it():
    session = Session(forearm())
    home = session.prepared.robot.home
    session.submit(RestChanged(tuple(home + 0.1)))
    reached = session.run_for(2.0).posture
    assert np.abs(reached - session.frame.command.posture).max() < 0.05
    assert np.allclose(session.frame.command.posture, home + 0.1)
    session.reset()
    assert not any(isinstance(act, RestChanged) for _, act in session.inputs)
    assert np.allclose(session.tick().command.posture, home)


def test_with_a_speed_the_rest_posture_goes_there_and_all_joints_arrive_together():
    session = Session(forearm())
    home = session.prepared.robot.home
    away = np.array([0.3, 0.0, -0.1, 0.0, 0.2, 0.0, 0.0])
    session.submit(RestChanged(tuple(home + away), 0.6))
    assert np.allclose(session.run_for(0.25).command.posture, home + 0.5 * away)
    assert np.allclose(session.run_for(0.3).command.posture, home + away, atol=1e-12)
    session.submit(RestChanged(tuple(home), 0.6))
    session.tick()
    session.reset()
    assert np.allclose(session.run_for(0.1).command.posture, home)


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan"), float("inf")])
def test_a_rest_posture_wants_a_speed_that_there_is(speed):
    session = Session(forearm())
    with pytest.raises(SimulationError, match="no such speed"):
        session.submit(RestChanged(tuple(session.prepared.robot.home), speed))


@pytest.mark.parametrize("controller", ["impedance", "hold_force", "hybrid"])
def test_a_robot_that_is_placed_stands_still_there_and_stays(controller):
    session = Session(forearm(), settings=ControlSettings(controller=controller))
    home = session.prepared.robot.home
    session.run_for(0.1)
    session.submit(PosturePlaced(tuple(home + 0.3)))
    placed = session.tick()
    assert np.abs(placed.posture - home - 0.3).max() < 1e-3  # a tick of gravity
    assert np.abs(session.run_for(0.5).posture - home - 0.3).max() < 0.05
    session.reset()
    assert np.allclose(session.tick().posture, home, atol=1e-3)


def test_a_robot_is_not_placed_where_something_touches_it():
    at = (0.25 * float(np.cos(1.0)), 0.0, -0.25 * float(np.sin(1.0)))
    block = ObjectSpec("block", "box", (0.1, 0.1, 0.1), at=at)
    prepared = prepared_bar(objects=(block,), task="push", overrides={"gravity": "off"})
    session = Session(replace(prepared, objects=make_objects(prepared.scene)))
    assert session.effects.contact != "off"
    with pytest.raises(SimulationError, match=r"something touches it there \(found: bar on block\)"):
        session.submit(PosturePlaced((1.0,)))
    session.tick()
    assert abs(session.frame.posture[0]) < 0.1
    session.submit(PosturePlaced((-0.5,)))
    assert session.tick().posture[0] == pytest.approx(-0.5, abs=1e-3)


def test_a_robot_is_not_placed_while_a_finger_presses_it():
    session = Session(forearm())
    session.press(session.prepared.skin.taxel_point(30), force=3.0)
    before = session.run_for(0.2)
    with pytest.raises(SimulationError, match="a finger presses"):
        session.submit(PosturePlaced(tuple(session.prepared.robot.home)))
    assert session.frame is before
    assert not any(isinstance(act, PosturePlaced) for _, act in session.inputs)


@pytest.mark.parametrize("posture", [(), (99.0,) * 7, (float("nan"),) * 7])
def test_a_rest_posture_that_the_robot_cannot_have_is_refused_and_nothing_changes(posture):
    session = Session(forearm())
    with pytest.raises(SimulationError, match="7 positions within"):
        session.submit(RestChanged(posture))
    session.tick()
    assert np.allclose(session.tick().command.posture, session.prepared.robot.home)


def test_a_rest_posture_is_refused_where_the_scene_moves_the_robot():
    moved = forearm()
    moved = replace(moved, scene=replace(moved.scene, motion=(Waypoint({"hand_roll": 0.1}),)))
    with pytest.raises(SimulationError, match="moves the robot"):
        Session(moved).submit(RestChanged(tuple(moved.robot.home)))
