"""Changes while a session runs: effects, behaviours, contact detection, maps and postures, also in recordings."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import get_args

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
    SessionInput,
)
from tactile_maps.session.runtime_settings import CHANGES, RuntimeSettings, runtime_settings_at
from tactile_maps.session.session import Session
from tactile_maps.skin.calibration_error import with_area_error, with_calibration_error, with_sleeve_displaced
from tactile_maps.skin.model.skin import Skin
from tactile_maps.stimuli.stimulus_kinds import Poke, Stroke
from tactile_maps.tactile.poke import Finger, PokePressed, PokeReleased
from tactile_maps.tactile.sensors.sensor_effects import Noise, Sampling, SensorEffects
from tests.support.pressed_arm import forearm
from tests.support.scene_objects import thing
from tests.support.sessions import record, run, same
from tests.support.touch import arm, bar_map, bar_skin, prepared_bar, taxel_near

BAR = prepared_bar()
AT = BAR.skin.taxel_point(30)
EDGE = BAR.skin.taxel_point(taxel_near(BAR.skin, 0, (0.3, 0.0, 0.02)))
NOISY = replace(BAR.scene.effects, sensor=SensorEffects(noise=Noise()))
DOUBLE = Behaviour("tap", times=2, then={"controller": "hybrid", "task": "retreat"})
PRESSED = Behaviour("press", until_released=True, then={"force_goal": 1.0})
FORCE = Finger(max_force=5.0, speed=1.0)


# Runtime settings


START = RuntimeSettings.of_scene(prepared_bar(control={"controller": "hybrid"}, reading={"estimator": "tikhonov"}))
CHANGED = {
    "settings": ControlChanged(ControlSettings(stiffness=12.0)),
    "effects": EffectsChanged(Effects(gravity="on")),
    "behaviours": BehavioursChanged((Behaviour("tap", then={"task": "guide"}),)),
    "reading": ReadingChanged(ReadingSettings("lumped")),
    "map": MapEdited("Earlier edits", bar_map(40)),
}


@pytest.mark.parametrize("name", CHANGED)
def test_input_changes_one_part_of_the_settings_and_can_be_derived_from_them(name):
    after = START.after(CHANGED[name])
    assert [part for part in CHANGED if getattr(after, part) is not getattr(START, part)] == [name]
    [found] = after.since(START)
    assert vars(found) == vars(CHANGED[name])


def test_other_inputs_do_not_change_the_settings():
    assert set(CHANGES) == {type(each) for each in CHANGED.values()} < set(get_args(SessionInput))
    assert START.since(replace(START)) == []
    assert START.after(PokeReleased(1)) is START


@pytest.mark.parametrize(("tick", "stiffness"), [(4, 8.0), (5, 12.0), (8, 12.0), (9, 3.0), (100, 3.0)])
def test_settings_at_a_tick_include_its_inputs(tick, stiffness):
    changes = [(at, ControlChanged(ControlSettings(stiffness=value))) for at, value in ((5, 12.0), (9, 3.0))]
    inputs = [changes[0], (6, PokeReleased(1)), changes[1]]
    assert runtime_settings_at(START, inputs, tick).settings.stiffness == stiffness


def test_scene_states_settings_of_controller_and_contact_detection():
    scene = replace(BAR.scene, control={"force_goal": 5.0}, reading={"estimator": "lumped", "threshold": 3000})
    stated = Session(replace(BAR, scene=scene))
    assert stated.settings.force_goal == 5.0
    assert stated.runtime_settings.reading == ReadingSettings("lumped", 3000.0)
    assert stated.runtime_settings.since(RuntimeSettings.of_scene(stated.prepared)) == []
    assert Session(stated.prepared, reading=ReadingSettings()).runtime_settings.reading == ReadingSettings()
    for wrong, words in (
        ({"control": {"magic": 1.0}}, r"control\.magic: there is no such key"),
        ({"reading": {"estimator": "guess"}}, "contacts.estimator"),
    ):
        with pytest.raises(SceneError, match=words):
            Session(replace(BAR, scene=replace(BAR.scene, **wrong)))


# Effects, motion and objects


def test_timings_list_the_simulated_stages():
    session = Session(BAR)
    stages = [
        [*run(session, 1, {0: [EffectsChanged(effects)]})[0].timings.ms]
        for effects in (BAR.scene.effects, NOISY, replace(NOISY, skin="off"))
    ]
    touch = ["physics", "touch", "contacts", "control"]
    assert stages == [touch, [*touch[:2], "noise", *touch[2:]], ["physics", "control"]]
    assert not session.frame.pressures.any()


def test_effects_change_at_the_next_tick_and_survive_a_reset():
    session = Session(BAR)
    other = Session(BAR)
    for each in (session, other):
        run(each, 30, {0: [PokePressed(1, AT)]})
    session.submit(EffectsChanged(NOISY))
    assert session.effects == BAR.scene.effects
    frame = session.tick()
    plain = other.tick()
    assert session.effects == NOISY
    assert session.inputs[-1] == (31, EffectsChanged(NOISY))
    assert np.array_equal(frame.posture, plain.posture)
    assert [poke.force for poke in frame.pokes] == [poke.force for poke in plain.pokes]
    assert not np.array_equal(frame.pressures, plain.pressures)
    session.reset()
    assert session.inputs[1:] == [(0, EffectsChanged(NOISY))]


def test_finer_time_step_takes_more_steps_per_tick():
    session = Session(BAR)
    run(session, 20, {0: [EffectsChanged(replace(session.effects, timestep=0.0005))]})
    assert session._simulation.time == pytest.approx(session.frame.time)


@pytest.mark.long
def test_script_continues_without_contact_while_fingers_are_off():
    session = Session(prepared_bar(stimuli=(Stroke(hold=0.1),)))
    assert session.tick().pokes
    off = replace(session.effects, fingers=False)
    assert not any(frame.pokes for frame in run(session, 300, {0: [EffectsChanged(off)]}))
    session.submit(EffectsChanged(replace(off, fingers=True)))
    assert any(session.tick().pokes for _ in range(2000))


def test_fingers_can_be_switched_off_at_any_tick_of_the_script():
    session = Session(prepared_bar(stimuli=(Poke(hold=0.01, rest=0.005),)))
    switched = {tick: [EffectsChanged(replace(session.effects, fingers=tick % 4 < 2))] for tick in range(60)}
    assert sum(len(frame.pokes) for frame in run(session, 60, switched)) > 5


@pytest.mark.long
def test_motion_moves_the_rest_posture_from_the_start_after_a_reset():
    session = Session(prepared_bar(motion=(Waypoint(posture=(0.5,), seconds=1.0, rest=5.0),)))
    assert session.frame.command.posture == [0.0]
    frames = run(session, 500)
    assert frames[99].command.posture == pytest.approx([0.25]), "half way after half the time"
    assert frames[-1].posture == pytest.approx([0.5], abs=0.01)
    session.reset()
    assert session.frame.command.posture == [0.0]


def test_frames_contain_the_poses_of_falling_objects():
    ball = ObjectSpec("ball", "sphere", size=(0.05,), at=(1.0, 2.0, 3.0), mass=0.1)
    prepared = prepared_bar(objects=(ball,), task="push", overrides={"gravity": "on"})
    session = Session(replace(prepared, objects=make_objects(prepared.scene)))
    assert session.frame.objects.shape == (1, 4, 4)
    assert session.frame.objects[0, :3, 3] == pytest.approx([1, 2, 3])
    assert run(session, 20)[-1].objects[0, 2, 3] == pytest.approx(3 - 0.5 * 9.81 * 0.1**2, abs=1e-3)


def test_rejected_input_of_the_script_ends_the_script_but_not_the_session():
    session = Session(prepared_bar(stimuli=(Stroke(start=(0.95, 0.5), end=(0.9, 0.5), stiffness=1e6),)))
    with pytest.raises(SimulationError, match="too stiff"):
        session.tick()
    assert not session.scripted
    assert [frame.tick for frame in run(session, 3)] == [1, 2, 3]


# Behaviours


def session_with(*behaviours: Behaviour, **options) -> Session:
    return Session(prepared_bar(control={"controller": "hybrid"}, behaviours=tuple(map(asdict, behaviours))), **options)


def tap(session: Session) -> None:
    frames = run(session, 60, {0: [PokePressed(1, EDGE, Finger(speed=0.05))], 20: [PokeReleased(1)]})
    assert frames[19].regions
    assert not frames[-1].regions


def triggers(session: Session) -> list[str]:
    return [trigger_text(each.by) for _, each in session.inputs if isinstance(each, ControlChanged) and each.by]


@pytest.mark.long
def test_double_tap_triggers_a_behaviour_that_was_added_before_a_reset():
    session = session_with()
    run(session, 1, {0: [BehavioursChanged((DOUBLE,))]})
    session.reset()
    assert session.runtime_settings.behaviours == (DOUBLE,)
    assert (0, BehavioursChanged((DOUBLE,))) in session.inputs
    tap(session)
    assert session.settings.task == "keep_force"
    tap(session)
    assert session.settings.task == "retreat"
    assert triggers(session) == ["double tap"]


def pressed_session(**options) -> Session:
    session = session_with(PRESSED, **options)
    run(session, 100, {0: [PokePressed(1, EDGE, Finger(speed=0.1))]})
    assert session.settings.force_goal == 1.0
    return session


@pytest.mark.long
def test_behaviour_applies_until_the_release():
    session = pressed_session()
    run(session, 100, {0: [PokeReleased(1)]})
    assert session.settings.force_goal == ControlSettings().force_goal
    assert triggers(session) == ["press", "released"]


@pytest.mark.long
def test_contact_missed_in_one_sample_of_a_slow_skin_is_not_a_release():
    session = pressed_session(effects=Effects(sensor=SensorEffects(sampling=Sampling(10.0))))
    frames = run(session, 85, {0: [PokeReleased(1)], 25: [PokePressed(1, EDGE, Finger(speed=0.5))]})
    assert session.settings.force_goal == 1.0
    assert 0 < sum(not frame.regions for frame in frames) <= 30
    assert frames[-1].regions
    assert triggers(session) == ["press"]


def test_reset_restores_the_settings_from_before_the_press():
    session = pressed_session()
    session.reset()
    assert session.settings.force_goal == ControlSettings().force_goal
    assert session.inputs[0] == (0, ControlChanged(session.settings))


def test_invalid_behaviours_and_triggered_changes_from_outside_are_ignored():
    session = session_with(DOUBLE)
    session.submit(BehavioursChanged((Behaviour("tap", "elbow", then={"task": "guide"}),)))
    with pytest.raises(SceneError, match="elbow"):
        session.tick()
    run(session, 1, {0: [ControlChanged(ControlSettings(controller="qp"), by=DOUBLE)]})
    assert session.runtime_settings.behaviours == (DOUBLE,)
    assert session.settings.controller == "hybrid"


@pytest.mark.long
def test_recording_reproduces_behaviours(tmp_path):
    prepared = arm()
    scene = replace(prepared.scene, stimuli=(), control={"controller": "hybrid"}, behaviours=(asdict(PRESSED),))
    session = Session(replace(prepared, scene=scene))
    inputs = {
        10: [PokePressed(1, prepared.skin.taxel_point(40))],
        160: [BehavioursChanged((PRESSED, DOUBLE)), PokeReleased(1)],
    }
    player = record(session, tmp_path / "r.mcap", 360, inputs)
    assert triggers(session) == ["press", "released"]
    assert player.runtime_settings_at(0).behaviours == (PRESSED,)
    assert player.runtime_settings_at(200).behaviours == (PRESSED, DOUBLE)
    assert player.inputs == session.inputs
    assert verify(player).identical


# Contact detection


def pressed(prepared=BAR, *, taxels=(30,), ticks=60, **options) -> Session:
    """Return a session in which fingers press these taxels."""
    session = Session(prepared, scripted=False, **options)
    fingers = [PokePressed(number, prepared.skin.taxel_point(taxel), FORCE) for number, taxel in enumerate(taxels)]
    run(session, ticks, {0: fingers})
    return session


@pytest.mark.parametrize("name", ESTIMATORS)
def test_regions_have_the_force_of_the_estimator(name):
    frame = pressed(reading=ReadingSettings(name)).frame
    (region,), (poke,) = frame.regions, frame.pokes
    assert bool(frame.estimates) == (name != "area-sum")
    if frame.estimates:
        assert frame.estimates[region.id].refused is None
        assert region.force == frame.estimates[region.id].force
    assert region.force == pytest.approx(poke.force, rel=0.25)
    if name == "lumped":
        assert region.force == pytest.approx(poke.force, rel=1e-12)
        assert region.link_position == pytest.approx(BAR.skin.position(poke.at), abs=1e-9)


def test_link_sensor_reads_the_impulse_of_an_impact_with_time_averaging():
    mass = 0.2
    speed = 0.4
    ball = thing("sphere", at=(0.15, 0.0, 0.041), mass=mass, guided=True)
    effects = Effects(contact="environment", gravity="off", timestep=5e-4, time_averaging=True)
    reading = ReadingSettings("lumped", threshold=1.0)
    session = Session(replace(prepared_bar(hinged=False), objects=(ball,)), effects=effects, reading=reading)
    session._simulation._data.qvel[0] = -speed
    session._simulation._physics.forward()
    impulse = sum(region.force for frame in run(session, 10) for region in frame.regions) * 0.005
    assert impulse == pytest.approx(mass * (session._simulation._data.qvel[0] + speed), rel=0.02)


@pytest.mark.long
def test_link_sensor_reads_two_contacts_of_its_link_as_one():
    along = BAR.skin.patches[0].taxels.positions[:, 0]
    taxels = (int(along.argmin()), int(along.argmax()))
    assert len(pressed(taxels=taxels).frame.regions) == 2
    frame = pressed(taxels=taxels, reading=ReadingSettings("lumped")).frame
    (region,) = frame.regions
    assert region.force == pytest.approx(sum(poke.force for poke in frame.pokes))
    assert 0.1 < region.link_position[0] < 0.3, "between them, where nothing touches"


def test_changed_estimator_keeps_the_identifier_of_a_contact():
    session = pressed()
    before = session.frame
    assert not before.estimates
    (frame,) = run(session, 1, {0: [ReadingChanged(ReadingSettings("tikhonov", threshold=2000.0))]})
    assert session.runtime_settings.reading == ReadingSettings("tikhonov", 2000.0)
    assert frame.estimates.keys() == {before.regions[0].id}
    assert not frame.events
    assert session.inputs[-1][0] == frame.tick


@pytest.mark.long
def test_contact_ends_below_half_of_its_threshold():
    session = pressed()
    peak = session.frame.regions[0].peak
    assert [len(pressed(reading=ReadingSettings(threshold=share * peak)).frame.regions) for share in (0.9, 1.1)] == [
        1,
        0,
    ]
    changes = {tick: [ReadingChanged(ReadingSettings(threshold=share * peak))] for tick, share in enumerate((1.9, 2.1))}
    assert [len(frame.regions) for frame in run(session, 2, changes)] == [1, 0]


@pytest.mark.long
def test_threshold_follows_the_current_noise():
    session = Session(BAR)
    loud = replace(session.effects, sensor=SensorEffects(noise=Noise(5000.0)))
    assert not any(frame.regions for frame in run(session, 200, {0: [EffectsChanged(loud)]}))
    low = Session(BAR, effects=loud, reading=ReadingSettings(threshold=1000.0))
    assert all((frame.pressures > 1000.0).any() for frame in run(low, 50)), "the noise exceeds the usual threshold"


@pytest.mark.long
def test_noise_of_the_link_sensor_follows_the_seed_of_the_scene():
    reading = ReadingSettings("lumped", wrench_noise=0.1)
    other = replace(BAR, scene=replace(BAR.scene, seed=1))
    forces = [pressed(prepared, reading=reading).frame.regions[0].force for prepared in (BAR, BAR, other)]
    assert forces[0] == forces[1] != forces[2]


@pytest.mark.long
def test_recording_after_a_reset_reproduces_the_estimates(tmp_path):
    session = Session(BAR)
    lumped = ReadingSettings("lumped", wrench_noise=0.1)
    run(session, 1, {0: [ReadingChanged(lumped)]})
    session.reset()
    inputs = {0: [PokePressed(1, AT, FORCE)], 60: [ReadingChanged(ReadingSettings("local-nnls"))]}
    player = record(session, tmp_path / "lumped.mcap", 80, inputs)
    assert player.runtime_settings_at(0).reading == lumped
    assert player.runtime_settings_at(80).reading == ReadingSettings("local-nnls")
    assert player.frame(50).estimates
    assert verify(player).identical
    player.inputs = [(tick, each) for tick, each in player.inputs if not isinstance(each, ReadingChanged)]
    assert not verify(player).identical, "other estimates are detected"


# Maps


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ESTIMATORS)
def test_contacts_are_located_at_the_assumed_positions_of_the_taxels(name):
    prepared = arm()
    assumed = with_calibration_error(prepared.skin, 0.003, seed=1)
    options = {"taxels": (int(prepared.skin.first[1]) + 20,), "reading": ReadingSettings(name), "ticks": 40}
    true = pressed(prepared, **options).frame
    frame = pressed(prepared, **options, map_=build_map(assumed)).frame
    assert np.array_equal(frame.pressures, true.pressures), "readings are those of the true skin"
    (region,), (other,) = frame.regions, true.regions
    assert np.array_equal(region.taxels, other.taxels)
    assert region.link_position == pytest.approx(assumed.position(region.at), abs=1e-9)
    assert 1e-4 < np.linalg.norm(region.link_position - other.link_position) < 0.015
    if name == "area-sum":
        assert region.force == other.force, "areas are known"


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "error",
    [
        lambda skin: with_calibration_error(skin, 0.003, seed=1),
        lambda skin: with_area_error(skin, 0.8),
        lambda skin: with_sleeve_displaced(skin, shift=0.002),
    ],
    ids=["misplaced", "areas", "sleeve"],
)
def test_recording_reproduces_a_map_with_other_assumed_positions(error, tmp_path):
    prepared = arm()
    assumed = error(prepared.skin)
    session = Session(prepared, scripted=False, map_=build_map(assumed))
    press = PokePressed(1, prepared.skin.taxel_point(int(prepared.skin.first[1]) + 20), FORCE)
    player = record(session, tmp_path / "assumed.mcap", 40, {0: [press]})
    assert session.frame.regions
    assert verify(player).identical
    held = player.runtime_settings_at(0).map.skin
    assert np.array_equal(held.areas, assumed.areas)
    for one, other in zip(held.patches, assumed.patches, strict=True):
        assert np.array_equal(one.taxels.positions, other.taxels.positions)
    without = RecordingPlayer(tmp_path / "assumed.mcap")
    without.inputs = [(tick, each) for tick, each in without.inputs if not isinstance(each, MapEdited)]
    assert not verify(without).identical


def test_learned_map_cannot_be_recorded(tmp_path):
    (patch,) = BAR.skin.patches
    learned = LearnedMap(patch.taxels.positions[:, :2], np.ones(len(BAR.skin), bool), "by hand", 0.0, None)
    session = Session(BAR, map_=learned_tactile_map(BAR.skin, learned))
    rejected = pytest.raises(RecordingError, match="a map whose triangles are not the skin's")
    with Recorder(BAR, tmp_path / "learned.mcap") as recorder, rejected:
        recorder.write(session.tick(), session.inputs)


OTHER_SKINS = {
    "more taxels": lambda _patch: bar_skin(80),
    "another link": lambda patch: Skin((replace(patch, link="tip"),)),
    "one more patch": lambda patch: Skin((patch, patch)),
}


@pytest.mark.long
@pytest.mark.parametrize("skin", OTHER_SKINS)
def test_map_of_another_skin_is_rejected_and_leaves_the_session_unchanged(skin):
    (patch,) = bar_skin().patches
    map_ = build_map(OTHER_SKINS[skin](patch))
    session = pressed(ticks=1, settings=ControlSettings(stiffness=40.0))
    other = pressed(ticks=1, settings=ControlSettings(stiffness=40.0))
    before = session.map
    with pytest.raises(MapError, match=r"the map is of another skin.*60 taxels on 1 patch"):
        session.submit(MapEdited("Other", map_))
    assert session.inputs == other.inputs
    frames = run(session, 80)
    assert any(frame.regions for frame in frames)
    assert all(map(same, frames, run(other, 80)))
    session.reset()
    assert session.map is before
    with pytest.raises(MapError, match="another skin"):
        Session(BAR, map_=map_)


def test_edited_map_is_logged_without_its_caches():
    session = Session(BAR)
    edited = TactileMap(session.map.skin, session.map.charts, session.map.layout)
    run(session, 1, {0: [MapEdited("Move", edited)]})
    assert session.map is edited
    assert edited.uv
    (kept,) = (each for _, each in session.inputs if isinstance(each, MapEdited))
    assert "uv" not in vars(kept.map)


# Postures


@pytest.mark.long
def test_robot_moves_to_another_rest_posture_until_a_reset():
    session = Session(forearm())
    home = session.prepared.robot.home
    session.submit(RestChanged(tuple(home + 0.1)))
    reached = session.run_for(2.0).posture
    assert np.abs(reached - session.frame.command.posture).max() < 0.05
    assert np.allclose(session.frame.command.posture, home + 0.1)
    session.reset()
    assert not any(isinstance(each, RestChanged) for _, each in session.inputs)
    assert np.allclose(session.tick().command.posture, home)


def test_joints_of_a_rest_posture_with_speed_arrive_together():
    session = Session(forearm())
    home = session.prepared.robot.home
    away = np.array([0.3, 0.0, -0.1, 0.0, 0.2, 0.0, 0.0])
    session.submit(RestChanged(tuple(home + away), 0.6))
    assert np.allclose(session.run_for(0.25).command.posture, home + 0.5 * away)
    assert np.allclose(session.run_for(0.3).command.posture, home + away, atol=1e-12)
    run(session, 1, {0: [RestChanged(tuple(home), 0.6)]})
    session.reset()
    assert np.allclose(session.run_for(0.1).command.posture, home)


@pytest.mark.parametrize("controller", ["impedance", "hold_force", "hybrid"])
def test_placed_robot_is_at_rest_and_stays(controller):
    session = Session(forearm(), settings=ControlSettings(controller=controller))
    home = session.prepared.robot.home
    session.run_for(0.1)
    session.submit(PosturePlaced(tuple(home + 0.3)))
    assert np.abs(session.tick().posture - home - 0.3).max() < 1e-3  # a tick of gravity
    assert np.abs(session.run_for(0.5).posture - home - 0.3).max() < 0.05
    session.reset()
    assert np.allclose(session.tick().posture, home, atol=1e-3)


def test_robot_cannot_be_placed_in_contact_with_an_object():
    at = (0.25 * float(np.cos(1.0)), 0.0, -0.25 * float(np.sin(1.0)))
    block = ObjectSpec("block", "box", (0.1, 0.1, 0.1), at=at)
    prepared = prepared_bar(objects=(block,), task="push", overrides={"gravity": "off"})
    session = Session(replace(prepared, objects=make_objects(prepared.scene)))
    with pytest.raises(SimulationError, match=r"something touches it there \(found: bar on block\)"):
        session.submit(PosturePlaced((1.0,)))
    assert abs(session.tick().posture[0]) < 0.1
    session.submit(PosturePlaced((-0.5,)))
    assert session.tick().posture[0] == pytest.approx(-0.5, abs=1e-3)


HOME = tuple(forearm().robot.home)


@pytest.mark.parametrize(
    ("rejected", "changes", "words"),
    [
        *((RestChanged(HOME, speed), {}, "speed of the rest posture") for speed in (0.0, -1.0, np.nan, np.inf)),
        *((RestChanged(posture), {}, "7 positions within") for posture in ((), (99.0,) * 7, (np.nan,) * 7)),
        (RestChanged(HOME), {"motion": (Waypoint({"hand_roll": 0.1}),)}, "moves the robot"),
        (PosturePlaced(HOME), {}, "a finger presses"),
    ],
)
def test_rejected_posture_leaves_the_session_unchanged(rejected, changes, words):
    prepared = forearm()
    session = Session(replace(prepared, scene=replace(prepared.scene, **changes)))
    session.press(prepared.skin.taxel_point(30), force=3.0)
    before = session.run_for(0.2)
    inputs = list(session.inputs)
    with pytest.raises(SimulationError, match=words):
        session.submit(rejected)
    assert session.frame is before
    session.tick()
    assert session.inputs == inputs
