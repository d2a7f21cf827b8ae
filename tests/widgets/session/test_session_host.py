"""The live session without a window: intents in, facts out, and nothing that was good is lost."""

from __future__ import annotations

import gc
from dataclasses import replace

import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.files import FOLDER_VARIABLE
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.inputs import MapEdited
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.skin.fitting.cover import CoverSpec
from tactile_maps.tactile.poke import PokePressed, PokeReleased
from tactile_widgets.common.mode import Mode
from tactile_widgets.jobs.executor import ProcessExecutor
from tactile_widgets.session.backends import INLINE
from tactile_widgets.session.session_host import SessionHost
from tests.widgets.support.executors import in_process
from tests.widgets.support.samples import shifted
from tests.widgets.support.window_driver import blow_up


@pytest.fixture
def live(qtbot, prepared):
    """A session host with the small arm that runs on request."""
    made = SessionHost(backends=INLINE)
    made.show_prepared(prepared)
    yield made
    made.close()
    made.deleteLater()


@pytest.fixture
def emitted(live):
    """All signals of the session as (name, argument)."""
    facts = []
    signals = {name: getattr(live, name) for name in ("failed", "halted", "settings_changed", "frame_ready")}
    recording = live.recording
    signals |= {"saved": recording.saved, "recording_changed": recording.changed, "not_recorded": recording.failed}
    for name, signal in signals.items():
        signal.connect(lambda content, name=name: facts.append((name, content)))
    return facts


def arguments_of(emitted, name):
    """Return the arguments of a signal."""
    return [content for fact, content in emitted if fact == name]


def recorded(live, path, seconds=0.3):
    """Record so many seconds to a file."""
    live.recording.start(path)
    live.runner.run_for(seconds)
    live.recording.stop()
    return path


def test_inputs_before_the_first_scene_have_no_effect(qtbot):
    live = SessionHost(backends=INLINE)
    assert live.mode is Mode.EMPTY
    assert not live.submit(PokeReleased(1))
    live.set_paused(paused=True)
    live.step()
    live.reset()
    live.recording.stop()
    live.recording.start("never.mcap")
    live.replay.leave()
    live.replay.seek(1.0)
    live.pump()
    assert live.mode is Mode.EMPTY
    live.close()
    live.deleteLater()


def test_each_frame_is_reported_once(live, emitted):
    live.runner.run_for(0.1)
    live.pump()
    live.pump()
    (frame,) = arguments_of(emitted, "frame_ready")
    assert frame.tick == 20


def test_press_takes_effect_at_the_next_tick(live, prepared):
    live.submit(PokePressed(1, prepared.skin.taxel_point(70)))
    live.runner.run_for(0.1)
    (press,) = [(tick, act) for tick, act in live.runner.session.inputs if isinstance(act, PokePressed) and act.id == 1]
    assert press[0] == 1
    assert live.runner.session.frame.pokes[-1].force > 0


def test_window_continues_during_a_long_tick(live, emitted):
    """The runner holds its lock during the whole tick, as when other effects are compiled."""
    with live.runner.lock:
        live.runner.session.tick()
        live.pump()  # here it would wait for ever
    assert not arguments_of(emitted, "frame_ready")
    live.pump()
    assert arguments_of(emitted, "frame_ready") == [live.runner.session.frame]


def test_speed_is_kept_for_the_next_scene(live, prepared):
    live.set_speed(2.0)
    live.show_prepared(prepared)
    assert live.runner.speed == 2.0


@pytest.mark.long
def test_every_tick_is_recorded_not_every_drawn_frame(live, emitted, tmp_path):
    path = recorded(live, tmp_path / "all.mcap")
    assert len(RecordingPlayer(path)) == 61, "with the tick it begins at"
    assert arguments_of(emitted, "saved") == [str(path)]
    assert arguments_of(emitted, "recording_changed") == [str(path), None]


@pytest.mark.long
def test_recording_made_while_paused_contains_the_shown_tick(live, emitted, tmp_path):
    live.runner.run_for(0.1)
    live.set_paused(paused=True)
    path = recorded(live, tmp_path / "paused.mcap")
    assert arguments_of(emitted, "saved") == [str(path)]
    player = RecordingPlayer(path)
    assert [player.frame(number).tick for number in range(len(player))] == [20]


def test_recording_is_never_overwritten(live, emitted, tmp_path):
    path = tmp_path / "kept.mcap"
    path.write_bytes(b"mine")
    live.recording.start(path)
    assert live.recording.recorder is None
    assert str(path) in arguments_of(emitted, "not_recorded")[0]
    assert path.read_bytes() == b"mine"


@pytest.mark.long
def test_failed_simulation_keeps_the_recording_and_continues_after_a_reset(live, emitted, tmp_path, prepared):
    path = tmp_path / "failed.mcap"
    live.recording.start(path)
    live.runner.run_for(0.2)
    blow_up(live)
    assert "diverged" in arguments_of(emitted, "halted")[0]
    assert live.mode is Mode.PAUSED
    assert live.recording.recorder is None
    assert RecordingPlayer(path).complete
    assert len(RecordingPlayer(path)) == 41
    live.reset()
    assert live.mode is Mode.RUNNING
    assert arguments_of(emitted, "halted") == arguments_of(emitted, "halted")[:1], "it is said once"
    live.runner.run_for(0.1)
    assert live.runner.session.frame.tick == 20


def test_paused_session_stays_paused_after_a_reset(live):
    live.set_paused(paused=True)
    live.reset()
    assert live.mode is Mode.PAUSED


def test_settings_requested_while_paused_are_kept_after_a_reset(live, emitted):
    live.set_paused(paused=True)
    live.set_settings(ControlSettings(controller="hold_force"))
    live.reset()
    live.step()
    assert live.runner.session.settings.controller == "hold_force"
    assert arguments_of(emitted, "settings_changed")[-1].controller == "hold_force"


def test_map_edited_while_paused_controls_the_arm_after_a_reset(live, prepared):
    live.set_paused(paused=True)
    edited = shifted(prepared.map, (0.1, 0.0))
    live.edit_map(edited, "Move")
    live.reset()
    live.set_paused(paused=False)
    live.runner.run_for(0.05)
    assert live.runner.session.map is edited
    (kept,) = (act.map for _, act in live.runner.session.inputs if isinstance(act, MapEdited))
    assert (kept.charts, kept.layout) == (edited.charts, edited.layout)


@pytest.mark.long
def test_replay_shows_the_recorded_settings(live, emitted, tmp_path):
    path = tmp_path / "controllers.mcap"
    live.recording.start(path)
    live.runner.run_for(0.2)
    live.set_settings(ControlSettings(controller="hold_force"))
    live.runner.run_for(0.2)
    live.set_settings(ControlSettings(stiffness=20.0))
    live.runner.run_for(0.2)
    live.recording.stop()
    live.open_recording(path)
    seen = []
    for seconds in (0.1, 0.3, 0.5):
        live.replay.seek(seconds)
        seen.append(arguments_of(emitted, "settings_changed")[-1])
    assert [settings.controller for settings in seen] == ["impedance", "hold_force", "impedance"]
    assert seen[-1].stiffness == 20.0
    live.replay.seek(0.3)
    live.replay.leave()
    assert arguments_of(emitted, "settings_changed")[-1].stiffness == 20.0, "the live session's own again"


@pytest.mark.long
@pytest.mark.parametrize("paused", [False, True])
def test_leaving_a_replay_restores_running_or_paused(live, tmp_path, paused):
    path = recorded(live, tmp_path / "replay.mcap")
    live.set_paused(paused=paused)
    live.open_recording(path)
    live.open_recording(path)  # a second replay must not take the first one's pause for the person's
    assert live.mode is Mode.REPLAYING
    live.replay.leave()
    assert live.mode is (Mode.PAUSED if paused else Mode.RUNNING)


@pytest.mark.long
def test_replay_starts_with_its_first_frame_even_at_an_equal_tick(live, emitted, tmp_path):
    path = recorded(live, tmp_path / "same.mcap", seconds=0.0)
    live.pump()
    tick = live.runner.session.frame.tick
    emitted.clear()
    live.open_recording(path)
    (frame,) = arguments_of(emitted, "frame_ready")
    assert frame.tick == tick
    assert frame is not live.runner.session.frame


@pytest.mark.long
def test_recording_cannot_be_poked(live, tmp_path, prepared):
    live.open_recording(recorded(live, tmp_path / "look.mcap"))
    before = list(live.runner.session.inputs)
    live.submit(PokePressed(1, prepared.skin.taxel_point(70)))
    live.set_settings(ControlSettings(stiffness=3.0))
    live.reset()
    live.replay.leave()
    live.runner.run_for(0.05)
    hand = [act for _, act in live.runner.session.inputs[len(before) :] if getattr(act, "id", 0) == 1]
    assert not hand
    assert live.runner.session.settings.stiffness != 3.0
    assert live.runner.session.frame.tick == 70


def test_damaged_recording_leaves_the_session_running(live, emitted, tmp_path):
    path = tmp_path / "bad.mcap"
    path.write_bytes(b"nothing of the sort")
    live.open_recording(path)
    assert live.mode is Mode.RUNNING
    assert str(path) in arguments_of(emitted, "failed")[0]


@pytest.mark.long
def test_edit_in_progress_is_cancelled_before_another_scene_is_shown(live, emitted, tmp_path):
    path = recorded(live, tmp_path / "order.mcap")
    order = []
    live.mode_changed.connect(order.append)
    live.prepared_changed.connect(lambda _prepared: order.append("another scene"))
    live.open_recording(path)
    assert order == [Mode.REPLAYING, "another scene"]
    live.replay.leave()
    assert order[2:] == ["another scene", Mode.RUNNING]


@pytest.mark.long
def test_measurements_of_the_previous_scene_are_dropped_for_a_recording(qtbot, prepared, tmp_path):
    live = SessionHost(backends=replace(INLINE, executor=ProcessExecutor))
    live.show_prepared(prepared)
    path = recorded(live, tmp_path / "other.mcap")
    heard = []
    measurements = live.measurements
    measurements.cost_seconds = 60.0  # longer than opening the recording on a busy machine
    measurements.priced.connect(heard.append)
    measurements.price(prepared, prepared.scene.effects)
    measurements.weigh(prepared, prepared.scene.effects)
    with qtbot.waitSignal(measurements.weighing_changed, check_params_cb=lambda weighing: not weighing):
        live.open_recording(path)
    assert not measurements.cost_executor.busy
    live.close()
    live.deleteLater()
    assert heard == []


def test_scene_that_cannot_run_leaves_the_previous_one(live, emitted, prepared):
    stroke = replace(prepared.scene.stimuli[0], patch="no such patch")
    live.show_prepared(replace(prepared, scene=replace(prepared.scene, stimuli=(stroke,))))
    assert live.prepared is prepared
    assert "no such patch" in arguments_of(emitted, "failed")[0]
    live.runner.run_for(0.05)
    assert live.runner.session.frame.tick == 10


def test_default_runner_is_a_thread_that_ends(qtbot, prepared):
    live = SessionHost()
    live.show_prepared(prepared)
    qtbot.waitUntil(lambda: live.runner.session.frame.tick > 5)
    thread = live.runner._thread
    live.close()
    assert not thread.is_alive()
    live.deleteLater()
    gc.collect()


@pytest.mark.long
def test_cached_scene_is_shown_without_a_process(qtbot, tmp_path, monkeypatch):
    """A worker that is busy with another scene, or an edit, gives way."""
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    scene = replace(load_scene("view"), cover=CoverSpec(links=("hand",), taxels=20))
    prepare_cached(scene)
    live = SessionHost(backends=replace(INLINE, executor=in_process("prepare")))
    shown = []
    live.prepared_changed.connect(shown.append)
    live.scene_jobs.prepare(replace(scene, cover=replace(scene.cover, taxels=21)))
    live.open_scene(scene)
    assert [len(each.skin) for each in shown] == [20]
    assert not live.scene_jobs.busy
    live.close()
    live.deleteLater()
