"""Readings in place of a simulation: connected, shown, recorded, disconnected; on threads and without."""

from __future__ import annotations

import itertools
import json
import os
import signal
import socket
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import LiveError, TactileMapsError, UsageError
from tactile_maps.live.calibration.calibration import ValueMode
from tactile_maps.live.motion.motion_sender import MotionLimits
from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.readings.wire_format import encode_binary
from tactile_maps.live.sources.open import SourceOptions
from tactile_maps.recording.player import open_recording
from tactile_maps.tactile.poke import PokePressed
from tactile_maps.tactile.press import press_skin
from tactile_widgets.common.mode import Mode
from tactile_widgets.session.backends import INLINE
from tactile_widgets.session.live_input import LiveInputSettings, ThreadReadingsRunner
from tactile_widgets.session.session_host import SessionHost
from tactile_widgets.window.ending_signals import end_at_once
from tests.support.simulated_clock import SimulatedClock
from tests.support.touch import bar_skin, prepared_bar


@pytest.fixture
def live(qtbot, prepared):
    made = SessionHost(backends=INLINE)
    made.show_prepared(prepared)
    yield made
    made.close()
    made.deleteLater()


@pytest.fixture
def readings(prepared, tmp_path):
    """A file of two seconds: nothing, then a press on the hand, while a joint moves."""
    skin = prepared.skin
    joint = prepared.robot.joints[1].name
    pressed = press_skin(skin, skin.taxel_point(30), force=3.0)
    rows = [f"time,{','.join(map(str, range(len(skin))))},joint:{joint}"]
    for number in range(20):
        values = pressed if number >= 10 else 0 * pressed
        rows.append(f"{0.1 * number},{','.join(map(str, values))},{0.01 * number}")
    path = tmp_path / "readings.csv"
    path.write_text("# unit: Pa\n" + "\n".join(rows) + "\n")
    return LiveInputSettings(str(path), replace(LiveInputSettings("").options, speed=None))


def test_recorded_readings_give_contacts_and_postures(live, prepared, readings):
    changes = []
    frames = []
    live.connection.changed.connect(changes.append)
    live.frame_ready.connect(frames.append)
    live.connection.open(readings)
    assert changes == [live.live_input]
    live.runner.run_for(3.0)
    live.pump()
    assert live.mode is Mode.RUNNING
    (region,) = frames[-1].regions
    assert abs(region.force - 3.0) < 0.1
    assert np.isclose(frames[-1].posture[1], 0.19)
    facts, silent = live.live_input.facts()
    assert (facts.readings, facts.calibrated, silent) == (20, True, ())


def test_failed_connection_keeps_the_session(live, tmp_path):
    runner = live.runner
    for settings in (
        LiveInputSettings("carrier pigeon"),
        LiveInputSettings(str(tmp_path / "none.csv")),
        LiveInputSettings("udp://0.0.0.0:9870"),
        LiveInputSettings("udp:", calibration=tmp_path / "none.csv"),
    ):
        with pytest.raises(TactileMapsError):
            live.connection.open(settings)
    assert live.runner is runner
    assert live.live_input is None


def test_connecting_without_a_scene_is_rejected(qtbot):
    live = SessionHost(backends=INLINE)
    with pytest.raises(LiveError, match="Open a robot"):
        live.connection.open(LiveInputSettings("udp:"))
    live.close()
    live.deleteLater()


def test_disconnecting_simulates_again(live, prepared, readings):
    live.connection.open(readings)
    live.runner.run_for(0.2)
    live.connection.close()
    assert live.live_input is None
    assert live.prepared.scene == prepared.scene
    live.runner.run_for(0.1)
    assert live.runner.session.frame.tick == 20
    live.connection.close()


def test_simulation_after_readings_starts_with_the_map_edited_meanwhile(live, prepared, readings):
    live.connection.open(readings)
    edited = replace(prepared.map)
    live.edit_map(edited, "Move")
    live.connection.close()
    assert live.run.settings.map is edited
    assert live.runner.session.map is edited


def test_second_source_replaces_the_first_and_keeps_the_original_scene(live, prepared, readings):
    live.connection.open(readings)
    first = live.live_input
    live.connection.open(readings)
    assert live.live_input is not first
    assert first.connection.status.state == "closed"
    live.connection.close()
    assert live.prepared.scene == prepared.scene


def test_poke_of_a_measured_skin_is_rejected_with_a_message(live, prepared, readings):
    said = []
    live.failed.connect(said.append)
    live.connection.open(readings)
    live.submit(PokePressed(1, prepared.skin.taxel_point(3)))
    live.pump()
    assert "cannot be poked" in said[0]
    live.runner.run_for(3.0)
    assert live.live_input.session.facts.readings == 20


def test_recording_of_readings_is_replayed(live, readings, tmp_path):
    live.connection.open(readings)
    live.recording.start(tmp_path / "felt.mcap")
    live.runner.run_for(3.0)
    live.recording.stop()
    player = open_recording(tmp_path / "felt.mcap")
    assert player.complete
    assert player.measured == readings.address
    assert len(player) == 21  # and the one that was shown when it began
    live.show_player(player)
    live.replay.seek(player.duration)
    assert live._shown.regions[0].force > 2.9
    live.replay.leave()
    assert live.live_input is not None


@pytest.mark.long
def test_threads_turn_packets_into_frames_and_end(qtbot, prepared):
    live = SessionHost(backends=replace(INLINE, readings_runner=ThreadReadingsRunner))
    live.show_prepared(prepared)
    live.connection.open(LiveInputSettings("udp://127.0.0.1:0"))
    port = live.live_input.connection.source.port
    taxels = len(prepared.skin)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for number in range(30):
            reading = Reading(0.01 * number, np.full(taxels, float(number)), Unit.PASCAL, sequence=number)
            sender.sendto(encode_binary(reading), ("127.0.0.1", port))
        session = live.live_input.session
        qtbot.waitUntil(lambda: session.facts.readings == 30)
        live.runner.paused = True
        sender.sendto(encode_binary(Reading(1.0, np.zeros(taxels), Unit.PASCAL, sequence=30)), ("127.0.0.1", port))
    live.live_input.tare()
    live.live_input.request_mode(ValueMode.RAW)
    assert live.live_input.session.readings.mode is ValueMode.RAW
    live.close()
    assert live.live_input.connection.status.state == "closed"
    assert not live.runner._thread.is_alive()
    live.deleteLater()


TOKEN = "a token of ours"


@pytest.mark.long
def test_threads_send_motion_and_stop_without_waiting_for_readings(qtbot):
    live = SessionHost(backends=replace(INLINE, readings_runner=ThreadReadingsRunner))
    live.show_prepared(prepared_bar())
    clock = SimulatedClock()
    live.connection.open(LiveInputSettings("udp://127.0.0.1:0", SourceOptions(token=TOKEN, clock=clock)))
    values = press_skin(bar_skin(), bar_skin().taxel_point(30), force=2.0)
    packets = []
    number = itertools.count()
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as skin,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as driver,
    ):
        skin.connect(("127.0.0.1", live.live_input.connection.source.port))
        driver.bind(("127.0.0.1", 0))
        driver.setblocking(False)
        live.live_input.use_controller("hold_force")
        live.live_input.send_motion(f"udp://127.0.0.1:{driver.getsockname()[1]}", MotionLimits())

        def received(*, held: bool = False) -> int:
            """Send a reading, and read what reached the driver."""
            reading = Reading(clock.now, values, Unit.PASCAL, joints={"hinge": 0.3}, sequence=next(number))
            skin.send(encode_binary(reading, token=TOKEN))
            if not held:
                clock.advance(0.01)
            with suppress(BlockingIOError):
                while True:
                    packets.append(json.loads(driver.recv(4096)))
            return len(packets)

        assert live.live_input.motion().sending.waiting is not None
        qtbot.waitUntil(lambda: received() >= 7)
        assert [packet["state"] for packet in packets[:2]] == ["stopped"] * 2
        assert {packet["state"] for packet in packets[2:]} == {"moving"}
        assert {packet["token"] for packet in packets} == {TOKEN}
        assert live.live_input.motion().latency.median > 0
        with live.runner.lock:  # as of a controller that takes long
            live.live_input._motion.halt()
            qtbot.waitUntil(lambda: received(held=True) and packets[-1]["state"] == "stopped")
        live.live_input.stop_motion()
        assert live.live_input.motion().sending.stopped == "switched off"
        count = received()
        assert received() == count
    live.close()
    live.deleteLater()


@pytest.fixture
def driven_host(qtbot):
    """A host with a live input of the bar on threads, its clock, its board and its driver."""
    clock = SimulatedClock()
    live = SessionHost(backends=replace(INLINE, readings_runner=ThreadReadingsRunner))
    live.show_prepared(prepared_bar())
    live.connection.open(LiveInputSettings("udp://127.0.0.1:0", SourceOptions(token=TOKEN, clock=clock)))
    live.live_input.use_controller("hold_force")
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as board,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as driver,
    ):
        board.connect(("127.0.0.1", live.live_input.connection.source.port))
        driver.bind(("127.0.0.1", 0))
        yield live, clock, board, driver
    live.close()
    live.deleteLater()


@pytest.fixture
def driven(driven_host):
    """The live input of ``driven_host``, its clock, its board and its driver."""
    host, *rest = driven_host
    return host.live_input, *rest


def send_reading(board, force, sequence, clock):
    values = press_skin(bar_skin(), bar_skin().taxel_point(30), force=force)
    reading = Reading(clock.now, values, Unit.PASCAL, joints={"hinge": 0.3}, sequence=next(sequence))
    board.send(encode_binary(reading, token=TOKEN))
    clock.advance(0.01)


@pytest.mark.long
def test_second_sender_is_rejected_while_motion_is_sent(qtbot, driven):
    live, clock, board, driver = driven
    sequence = itertools.count()
    live.send_motion(f"udp://127.0.0.1:{driver.getsockname()[1]}", MotionLimits())
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as second:
        second.connect(board.getpeername())

        def moved():
            send_reading(board, 2.0, sequence, clock)
            if live.motion().sending.sending:
                send_reading(second, 60.0, sequence, clock)
            return live.motion().sending.sent > 20

        qtbot.waitUntil(moved, timeout=20_000)
        name = f"127.0.0.1:{second.getsockname()[1]}"
    assert live.motion().sending.sending
    assert live.motion().requested.force < 5
    assert live.status.refused[name] > 0


def test_sending_ends_when_the_driver_disappears(qtbot, driven):
    live, clock, board, driver = driven
    sequence = itertools.count()
    live.send_motion(f"udp://127.0.0.1:{driver.getsockname()[1]}", MotionLimits())

    def moved():
        send_reading(board, 2.0, sequence, clock)
        if live.motion().sending.sent > 5:
            driver.close()
        return live.motion().sending.stopped is not None

    qtbot.waitUntil(moved, timeout=20_000)
    assert live.motion().sending.stopped == "no program receives at the driver's address"


def test_ending_the_process_stops_the_robot(qtbot, driven_host, monkeypatch):
    host, clock, board, driver = driven_host
    sequence = itertools.count()
    codes = []
    monkeypatch.setattr(os, "_exit", codes.append)
    host.live_input.send_motion(f"udp://127.0.0.1:{driver.getsockname()[1]}", MotionLimits())

    def moved():
        send_reading(board, 2.0, sequence, clock)
        return host.live_input.motion().sending.sent > 5

    qtbot.waitUntil(moved, timeout=20_000)
    motion = host.live_input.motion
    end_at_once(host, signal.SIGTERM)
    assert motion().sending.stopped == "switched off"
    assert codes == [128 + signal.SIGTERM]
    assert json.loads(driver.recv(4096))["token"] == TOKEN


def test_motion_needs_a_token_for_packets(qtbot, live):
    live.show_prepared(prepared_bar())
    live.connection.open(LiveInputSettings("udp://127.0.0.1:0"))
    with pytest.raises(UsageError, match="readings need a token.*File > Connect"):
        live.live_input.send_motion("udp://127.0.0.1:9", MotionLimits())
    assert not live.live_input.motion().sending.active


@pytest.mark.parametrize("end", [pytest.param("silence", marks=pytest.mark.long), "controller"])
def test_silence_and_another_controller_end_sending(qtbot, driven, end):
    live, clock, board, driver = driven
    sequence = itertools.count()
    live.send_motion(f"udp://127.0.0.1:{driver.getsockname()[1]}", MotionLimits())

    def moved():
        send_reading(board, 2.0, sequence, clock)
        return live.motion().sending.sent > 5

    qtbot.waitUntil(moved, timeout=20_000)
    if end == "controller":
        live.use_controller("hybrid")
        assert live.motion().sending.stopped == "switched off"
    else:

        def stopped():
            clock.advance(0.01)
            return live.motion().sending.stopped is not None

        qtbot.waitUntil(stopped, timeout=20_000)
        assert live.motion().sending.stopped in ("no reading came in time", "the readings are too old")
