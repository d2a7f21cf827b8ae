"""Readings become frames with contacts, events and posture; a recording of them replays and is not simulated again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.core.errors import LiveError, RecordingError, SimulationError
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.live.calibration.calibration import Calibration, ValueMode, load_calibration, save_calibration
from tactile_maps.live.prepare import as_measured
from tactile_maps.live.readings.arrival import Arrived
from tactile_maps.live.readings.joint_range import MOST_TURNS
from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.readings.wire_format import decode, encode_json
from tactile_maps.live.session.facts import silent_text
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.live.sources.files import read_recording
from tactile_maps.maps.build import build_map
from tactile_maps.recording.player import open_recording
from tactile_maps.recording.recorder import Recorder
from tactile_maps.recording.verify import verify
from tactile_maps.robots.model.robot import Joint
from tactile_maps.session.inputs import CalibrationUsed, MapEdited, PokePressed, PokeReleased, ReadingChanged
from tactile_maps.skin.model.skin import Skin, TaxelIdentity
from tactile_maps.tactile.press import press_skin
from tests.support.touch import bar, bar_skin, prepared_bar


def session(**options):
    return MeasuredSession(as_measured(prepared_bar()), **options)


def touched(force=3.0, taxel=30):
    return press_skin(bar_skin(), bar_skin().taxel_point(taxel), force=force)


def at(time, values, **parts):
    return Arrived(Reading(time, values, parts.pop("unit", Unit.PASCAL), **parts), 100 + time)


def test_simulated_press_sent_as_readings_gives_the_same_contact():
    measured = session()
    frame = measured.show(at(5.0, touched()))
    assert frame.tick == 1
    assert frame.time == 0.0
    (region,) = frame.regions
    assert abs(region.force - 3.0) < 0.05
    assert [event.kind for event in frame.events] != []
    frame = measured.show(at(5.01, np.zeros(60)))
    assert frame.regions == ()
    assert np.isclose(frame.time, 0.01)
    assert frame.tick == 100
    assert np.isclose(measured.mean_rate, 100.0)


def test_packet_for_a_part_of_the_skin_leaves_the_rest_unchanged():
    measured = session()
    measured.show(at(0.0, np.arange(60.0)))
    frame = measured.show(at(0.01, [500.0], ids=[7]))
    assert (frame.pressures[6], frame.pressures[7]) == (6.0, 500.0)


def sheared_session(**options):
    """Return a session of the bar whose taxels have three axes, except the last."""
    axes = np.full(60, 3)
    axes[-1] = 1
    (patch,) = bar_skin().patches
    skin = Skin((replace(patch, taxels=replace(patch.taxels, axes=axes)),))
    prepared = prepared_bar()
    prepared = replace(prepared, skin=skin, map=build_map(skin))
    return MeasuredSession(as_measured(prepared), **options)


def sheared(pressures, usage=0.3):
    """Return shear along t1 by a share of the pressures."""
    shear = np.column_stack([usage * pressures, np.zeros(60)])
    shear[-1] = np.nan
    return shear


def test_three_axis_packets_give_frames_and_contacts_their_shear_after_a_tare():
    measured = sheared_session()
    measured.tare(2)
    rest = sheared(np.full(60, 100.0), 1.0)
    for number in range(2):
        measured.show(at(0.01 * number, np.full(60, 20.0), shear=rest))
    felt = touched()
    packet = encode_json(Reading(0.02, felt + 20, Unit.PASCAL, shear=sheared(felt) + rest))
    frame = measured.show(Arrived(decode(packet), 100.02))
    expected = np.column_stack([0.3 * felt, np.zeros(60)])
    expected[-1] = 0.0
    assert np.allclose(frame.shear, expected, rtol=1e-12, atol=1e-9)
    (region,) = frame.regions
    assert np.isclose(np.linalg.norm(region.shear.force), 0.3 * region.force, rtol=0.02)
    assert measured.facts.wrong_channels == ()


def test_friction_measured_in_other_values_is_not_used():
    measured = sheared_session()

    def slide(first, readings):
        for number in range(first, first + readings):
            share = 0.02 * number
            felt = (1 - share) * touched(taxel=30) + share * touched(taxel=38)
            frame = measured.show(at(0.01 * number, felt, shear=sheared(felt, 0.2)))
        return frame.regions[0].shear

    found = slide(0, 30)
    assert found.estimated
    assert found.friction == pytest.approx(0.2, rel=0.02)
    measured.readings.request_mode(ValueMode.BASELINE)
    assert not slide(30, 1).estimated


def test_single_values_of_a_three_axis_skin_have_no_shear():
    measured = sheared_session()
    frame = measured.show(at(0.0, touched()))
    assert frame.shear is None
    assert frame.regions[0].shear is None
    assert measured.facts.wrong_channel_values == 0


def test_missing_and_unknown_channels_are_counted_and_the_taxels_named():
    measured = sheared_session()
    good = sheared(np.full(60, 10.0))
    measured.show(at(0.0, np.full(60, 10.0), shear=good))
    wrong = good.copy()
    wrong[4, 1] = np.nan
    wrong[59] = 1.0
    for number in (1, 2):
        frame = measured.show(at(0.01 * number, np.full(60, 50.0), shear=5 * wrong))
    assert measured.facts.wrong_channels == (
        "taxel 4: t2 missing, send all three",
        "taxel 59: shear of a taxel with one axis",
    )
    assert measured.facts.wrong_channel_values == 4
    assert measured.facts.refused == 0
    assert frame.shear[4].tolist() == [3.0, 0.0]
    assert frame.shear[5].tolist() == [15.0, 0.0]
    assert frame.shear[59].tolist() == [0.0, 0.0]


def test_gain_of_the_pressure_scales_the_shear_without_its_sign():
    measured = sheared_session(calibration=Calibration(np.full(60, -2.0), np.zeros(60)))
    frame = measured.show(at(0.0, np.full(60, -10.0), unit=Unit.COUNTS, shear=sheared(np.full(60, 10.0))))
    assert np.allclose(frame.pressures, 20.0)
    assert frame.shear[0].tolist() == [6.0, 0.0]


def test_matrix_of_a_taxel_removes_the_cross_talk_live_and_on_replay(tmp_path):
    crosstalk = np.array([[0.5, 0.1, 0.0], [0.05, 0.4, -0.1], [0.0, 0.08, 0.6]])
    matrix = np.broadcast_to(np.linalg.inv(crosstalk), (60, 3, 3)).copy()
    matrix[-1] = np.eye(3)
    path = tmp_path / "gains.csv"
    save_calibration(Calibration(np.ones(60), np.full(60, 7.0), matrix=matrix), path)
    measured = sheared_session(calibration=load_calibration(path, sheared_session().prepared.skin))
    assert np.array_equal(measured.readings.calibration.matrix, matrix)
    measured.tare(1)
    felt = np.column_stack([touched(), 0.3 * touched(), -0.1 * touched()])
    felt[-1, 1:] = np.nan
    raw = np.vstack([felt[:-1] @ crosstalk.T, felt[-1:]])
    recording = tmp_path / "felt.mcap"
    with Recorder(measured.prepared, recording) as recorder:
        for number in range(2):
            sent = 20.0 + number * raw
            frame = measured.show(at(0.01 * number, sent[:, 0], unit=Unit.COUNTS, shear=sent[:, 1:]))
            recorder.write(frame, measured.inputs)
    assert np.allclose(frame.pressures, felt[:, 0], atol=1e-9)
    assert np.allclose(frame.shear[:-1], felt[:-1, 1:], atol=1e-9)
    again = sheared_session()
    for reading in read_recording(recording):
        replayed = again.show(Arrived(reading, 100 + reading.time))
    assert np.array_equal(replayed.pressures, frame.pressures)
    assert np.array_equal(replayed.shear, frame.shear)


def test_recorded_shear_is_replayed_as_sent(tmp_path):
    measured = sheared_session()
    measured.tare(1)
    path = tmp_path / "felt.mcap"
    frames = []
    with Recorder(measured.prepared, path) as recorder:
        for number in range(3):
            pressures = touched() * (number > 0)
            frames.append(measured.show(at(0.01 * number, pressures + 20, shear=sheared(pressures + 20))))
            recorder.write(frames[-1], measured.inputs)
    player = open_recording(path)
    assert all(np.array_equal(one.shear, other.shear) for one, other in zip(player, frames, strict=True))
    again = sheared_session()
    for reading in read_recording(path):
        frame = again.show(Arrived(reading, 100 + reading.time))
    assert np.array_equal(frame.shear, frames[-1].shear)
    assert frame.regions[0].shear == frames[-1].regions[0].shear


def test_joints_move_the_body_and_unknown_ones_are_named():
    measured = session()
    name = measured.prepared.robot.joints[0].name
    measured.show(at(0.0, np.zeros(60), joints={name: 0.1}))
    frame = measured.show(at(0.1, np.zeros(60), joints={name: 0.3, "tail": 1.0}))
    assert frame.posture[0] == 0.3
    assert np.isclose(frame.velocity[0], 2.0)
    assert measured.facts.unknown_joints == ("tail",)


def test_counts_are_shown_above_their_baseline_and_pressure_needs_a_calibration():
    measured = session()
    measured.tare(2)
    for number, level in enumerate((20.0, 22.0)):
        assert measured.facts.tared is False
        measured.show(at(0.01 * number, np.full(60, level), unit=Unit.COUNTS))
    assert measured.facts.tared
    assert measured.readings.mode is ValueMode.BASELINE
    frame = measured.show(at(0.03, np.full(60, 25.0), unit=Unit.COUNTS))
    assert np.allclose(frame.pressures, 4000.0)
    assert not measured.facts.calibrated
    assert frame.units is ReadingUnits.COUNTS
    with pytest.raises(LiveError, match="cannot be shown as pressure"):
        measured.readings.request_mode(ValueMode.PRESSURE)
    measured.readings.request_mode(ValueMode.RAW)
    assert np.allclose(measured.show(at(0.04, np.full(60, 25.0), unit=Unit.COUNTS)).pressures, 25_000.0)


def noisy_readings(random, count, pressed=0.0):
    """(count, 60) readings in counts: every sixth taxel is much noisier than the others; ``pressed`` at taxel 30."""
    sigma = np.where(np.arange(60) % 6 == 3, 300.0, 10.0)
    return 5000 + sigma * random.standard_normal((count, 60)) + pressed * touched() / touched().max()


@pytest.mark.parametrize("tare", [5, 50])
def test_noisy_taxel_neither_forms_nor_hides_a_contact(tare):
    random = np.random.default_rng(0)
    measured = session()
    measured.tare(tare)
    number = 0

    def felt(readings):
        nonlocal number
        counts = []
        for values in readings:
            number += 1
            counts.append(len(measured.show(at(0.01 * number, values, unit=Unit.COUNTS)).regions))
        return counts

    felt(noisy_readings(random, tare))
    assert set(felt(noisy_readings(random, 100))) == {0}
    pressed = felt(noisy_readings(random, 100, pressed=4000.0))
    assert pressed.count(1) == 100


def test_noise_is_restored_from_a_recorded_tare(tmp_path):
    random = np.random.default_rng(0)
    measured = session()
    path = tmp_path / "felt.mcap"
    measured.tare(20)
    sent = [*(5000 + 10 * random.laplace(size=(20, 60))), *noisy_readings(random, 20, pressed=3000.0)]
    with Recorder(measured.prepared, path, measured="a file") as recorder:
        for number, values in enumerate(sent):
            frame = measured.show(at(0.01 * number, values, unit=Unit.COUNTS))
            recorder.write(frame, measured.inputs)
    used = [act for _, act in open_recording(path).inputs if isinstance(act, CalibrationUsed)][-1]
    assert used.counts.tolist() == [20] * 60
    assert used.tail_heaviness > 0
    again = session()
    for reading, first in zip(read_recording(path), open_recording(path), strict=True):
        shown = again.show(Arrived(reading, reading.time))
        if first.tick > 40:
            assert [region.taxels.tolist() for region in shown.regions] == [r.taxels.tolist() for r in first.regions]
            assert [region.force_error for region in shown.regions] == [r.force_error for r in first.regions]
    assert shown.regions


def test_recorded_tare_of_another_skin_is_rejected():
    used = CalibrationUsed(np.ones(60), np.zeros(60), np.zeros(60), np.ones(60), False, "baseline", np.ones(59))
    with pytest.raises(LiveError, match="of another skin"):
        session().adopt(used)


def test_recorded_curves_reproduce_the_pressures(tmp_path):
    curve = np.tile([[0.0, 10.0, 30.0], [0.0, 100.0, 9000.0]], (60, 1, 1))
    measured = session(calibration=Calibration(np.ones(60), np.full(60, 20.0), curve=curve))
    path = tmp_path / "felt.mcap"
    with Recorder(measured.prepared, path, measured="a file") as recorder:
        frame = measured.show(at(0.1, np.linspace(20.0, 50.0, 60), unit=Unit.COUNTS))
        recorder.write(frame, measured.inputs)
    assert frame.pressures[[0, 59]].tolist() == [0.0, 9000.0]
    again = session()
    (reading,) = read_recording(path)
    assert np.array_equal(again.show(Arrived(reading, reading.time)).pressures, frame.pressures)


def test_known_weight_calibrates_forces_in_newtons():
    measured = session()
    with pytest.raises(LiveError, match="not tared"):
        measured.weights.weigh(0.1)
    measured.tare(1)
    measured.show(at(0.0, np.full(60, 20.0), unit=Unit.COUNTS))
    measured.show(at(0.1, 20 + 0.01 * touched(1.5), unit=Unit.COUNTS))
    calibration = measured.weights.weigh(1.5 / 9.80665)
    assert np.allclose(calibration.gain, 100.0, rtol=0.02)
    frame = measured.show(at(0.2, 20 + 0.01 * touched(3.0), unit=Unit.COUNTS))
    assert abs(frame.regions[0].force - 3.0) < 0.1
    assert measured.facts.calibrated
    assert frame.units is ReadingUnits.CALIBRATED


def test_events_of_an_uncalibrated_skin_state_no_force():
    measured = session()
    for number in range(5):
        frame = measured.show(at(0.1 * number, 0.01 * touched(), unit=Unit.COUNTS))
    assert [event.force for event in frame.recent] == [None, None]
    assert frame.recent[0].words.startswith("press on")
    assert " N" not in frame.recent[0].words.replace("\u202f", " ")


def test_pressures_with_an_unknown_offset_give_no_forces():
    measured = session(mode=ValueMode.RAW)
    assert measured.show(at(0.0, touched())).units is ReadingUnits.PRESSURE


def test_calibration_has_its_own_offsets_and_must_match_the_skin():
    measured = session(calibration=Calibration(np.full(60, 50.0), np.full(60, 10.0)))
    assert np.allclose(measured.show(at(0.0, np.full(60, 12.0), unit=Unit.COUNTS)).pressures, 100.0)
    with pytest.raises(LiveError, match="another skin"):
        session(calibration=Calibration([1.0], [0.0]))


def test_reading_of_wrong_size_is_counted_and_ignored():
    measured = session()
    before = measured.show(at(0.0, np.zeros(60)))
    assert measured.show(at(0.1, np.zeros(9))) is before
    assert measured.show(at(0.2, np.zeros(60), unit=Unit.COUNTS)) is before
    assert (measured.facts.readings, measured.facts.refused) == (1, 2)
    assert "unit" in measured.facts.problem


def test_restarted_sender_continues_in_session_time():
    measured = session()
    measured.show(at(1000.0, np.zeros(60)))
    frame = measured.show(Arrived(Reading(0.0, np.zeros(60), Unit.PASCAL), 1100.5))
    assert np.isclose(frame.time, 0.5)


def arrival(sent, arrived):
    return Arrived(Reading(sent, np.zeros(60), Unit.PASCAL), arrived)


@pytest.mark.parametrize("wild", [0.4, 1.5, 9.0, 500.0, -0.5, -9.0, -500.0])
@pytest.mark.parametrize("count", [1, 3])
def test_outlying_times_of_single_readings_do_not_advance_the_session(wild, count):
    measured = session()
    times = []
    for number in range(20):
        odd = number in range(5, 5 + 3 * count, 3)
        sent = 100 + 0.01 * number + (wild if odd else 0.0)
        times.append(measured.show(arrival(sent, 0.01 * number)).time)
    np.testing.assert_allclose(times, 0.01 * np.arange(20), atol=1e-9)
    assert measured.facts.mistimed == count


@pytest.mark.parametrize("jump", [8.0, -8.0, 3600.0])
def test_changed_clock_is_followed_from_the_second_reading_on(jump):
    measured = session()
    for number in range(20):
        sent = 100 + 0.01 * number + (jump if number >= 10 else 0.0)
        frame = measured.show(arrival(sent, 0.012 * number))
    assert frame.time == pytest.approx(0.09 + 2 * 0.012 + 8 * 0.01, abs=0.005)
    assert measured.facts.mistimed == 2


def test_pause_of_a_sender_is_not_an_outlier():
    measured = session()
    measured.show(arrival(100.0, 0.0))
    assert measured.show(arrival(107.0, 7.0)).time == pytest.approx(7.0)
    assert measured.show(arrival(107.7, 7.5)).time == pytest.approx(7.7), "some packets were late and others lost"
    assert measured.facts.mistimed == 0


def test_readings_of_a_file_have_their_own_times():
    measured = session(finite=True)
    times = [measured.show(arrival(sent, 0.0)).time for sent in (0.0, 2.0, 4.0, 13.0)]
    assert times == [0.0, 2.0, 4.0, 13.0]


def test_map_and_contact_detection_may_change_and_pokes_are_rejected():
    measured = session()
    other = measured.map
    measured.submit(MapEdited("Same", other))
    measured.submit(ReadingChanged(ReadingSettings(threshold=5e4)))
    assert measured.show(at(0.0, touched())).regions == ()
    with pytest.raises(SimulationError, match="cannot be poked"):
        measured.submit(PokePressed(1, bar_skin().taxel_point(3)))
    measured.submit(PokeReleased(1))
    kinds = [type(one) for _, one in measured.inputs if not isinstance(one, CalibrationUsed)]
    assert kinds == [MapEdited, ReadingChanged]


@pytest.mark.parametrize(("inverted", "shown"), [(True, 30e3), (False, 5e3)])
def test_taxel_with_two_ids_shows_the_one_with_more_pressure(inverted, shown):
    """Its values rise by 5 and fall by 30 counts from 100."""
    (patch,) = bar_skin().patches
    identity = TaxelIdentity(ids=np.arange(60), aliases=np.array([[70, 9]]))
    skin = Skin((replace(patch, taxels=replace(patch.taxels, identity=identity)),))
    measured = MeasuredSession(replace(as_measured(prepared_bar()), skin=skin), inverted=inverted)
    measured.tare(1)
    measured.show(at(0.0, [100.0, 100.0], ids=[9, 70], unit=Unit.COUNTS))
    frame = measured.show(at(0.1, [105.0, 70.0], ids=[9, 70], unit=Unit.COUNTS))
    assert frame.pressures[9] == shown


def test_silent_channels_are_named():
    measured = session(quiet_seconds=1.0)
    for number in range(200):
        values = np.random.default_rng(number).normal(size=60)
        values[12] = 0.0
        measured.show(at(0.02 * number, values))
    assert [silent_text(measured.prepared.skin, one) for one in measured.facts.silent] == ["taxel 12: dead at 0"]


WIDE = press_skin(bar_skin(), bar_skin().taxel_point(30), force=100.0, radius=0.04)
"""A contact that reaches the neighbours of taxel 30."""


def noisy(number, *, dead=30, values=None):
    read = np.random.default_rng(number).normal(size=60) + (0.0 if values is None else values)
    read[dead] = 0.0
    return read


@pytest.mark.long
def test_broken_channel_is_estimated_and_recorded(tmp_path):
    measured = session(quiet_seconds=1.0)
    path = tmp_path / "dead.mcap"
    with Recorder(measured.prepared, path, measured="udp://127.0.0.1:9870") as recorder:
        for number in range(200):
            recorder.write(measured.show(at(0.02 * number, noisy(number))), measured.inputs)
        frame = measured.show(at(4.0, noisy(200, values=WIDE)))
        recorder.write(frame, measured.inputs)
    assert frame.pressures[30] == 0, "the raw value is kept"
    (region,) = frame.regions
    assert region.force_parts["dead_taxels"] > 0
    used = [one for _, one in open_recording(path).inputs if isinstance(one, CalibrationUsed)][-1]
    assert used.broken.tolist() == [30]
    again = session()
    for reading in read_recording(path):
        replayed = again.show(Arrived(reading, 100 + reading.time))
    assert replayed.regions[0].force == region.force


def test_channel_that_changes_again_is_not_broken():
    measured = session(quiet_seconds=1.0)
    for number in range(200):
        measured.show(at(0.02 * number, noisy(number)))
    mended = noisy(200, values=WIDE)
    mended[30] = WIDE[30]
    (region,) = measured.show(at(4.0, mended)).regions
    assert "dead_taxels" not in region.force_parts


def test_stuck_channel_is_distinguished_from_a_dead_one_until_it_changes():
    measured = session(quiet_seconds=1.0)
    for number in range(200):
        values = noisy(number)
        values[10] = 20.0
        measured.show(at(0.02 * number, values))
    used = [one for _, one in measured.inputs if isinstance(one, CalibrationUsed)][-1]
    assert (used.broken.tolist(), used.stuck.tolist()) == ([10, 30], [10])
    again = session()
    again.adopt(used)
    assert np.flatnonzero(again.stuck_taxels).tolist() == [10]
    measured.show(at(4.0, noisy(200)))
    assert not measured.stuck_taxels.any()
    assert np.flatnonzero(measured.broken_taxels).tolist() == [30]


def test_quiet_channel_of_a_skin_without_noise_is_not_broken():
    """A working taxel next to a changing contact may read zero all the time."""
    measured = session(quiet_seconds=1.0)
    measured.show(at(0.0, touched(taxel=30)))
    for number in range(1, 200):
        values = noisy(number)
        measured.show(at(0.02 * number, values))
    assert measured.facts.silent
    used = [one for _, one in measured.inputs if isinstance(one, CalibrationUsed)][-1]
    assert used.broken.tolist() == []


def test_source_is_polled_at_each_tick():
    waiting = [at(0.0, np.zeros(60)), at(0.1, touched())]
    measured = session(source=lambda: waiting.pop(0) if waiting else None)
    assert [measured.tick().tick for _ in range(4)] == [1, 1000, 1000, 1000]
    measured.reset()
    assert (measured.frame.tick, measured.frame.regions) == (0, ())
    assert any(isinstance(one, CalibrationUsed) for _, one in measured.inputs), "a recording begins with it"


def test_recording_contains_every_reading_and_is_not_simulated_again(tmp_path):
    measured = session()
    path = tmp_path / "felt.mcap"
    frames = []
    with Recorder(measured.prepared, path, measured="udp://127.0.0.1:9870") as recorder:
        for number, time in enumerate((0.0, 0.011, 0.0111, 0.5, 0.52)):
            frame = measured.show(at(time, touched() if number % 2 else np.zeros(60)))
            recorder.write(frame, measured.inputs)
            frames.append(frame)
    player = open_recording(path)
    assert player.complete
    assert player.measured == "udp://127.0.0.1:9870"
    for back, frame in zip(player, frames, strict=True):
        assert np.array_equal(back.pressures, frame.pressures)
        assert (back.time, back.events) == (frame.time, frame.events)
    assert np.isclose(player.duration, 0.52, atol=2e-4)
    with pytest.raises(RecordingError, match="cannot be simulated again"):
        verify(player)


def test_recording_is_replayed_as_sent_and_can_be_shown_differently(tmp_path):
    """Recorded in counts before the weight was laid on, it is read again calibrated, or raw: nothing is lost."""
    path = tmp_path / "felt.mcap"
    sent = [np.full(60, 20.0), *(20 + 0.01 * touched(force) for force in (1.5, 3.0))]
    sent[2][5] = 21.0
    measured = session()
    measured.tare(1)
    with Recorder(measured.prepared, path, measured="udp://127.0.0.1:9870") as recorder:
        recorder.write(measured.frame, measured.inputs)
        for number, values in enumerate(sent):
            frame = measured.show(at(70 + 0.1 * number, values, unit=Unit.COUNTS, sequence=4 + number))
            recorder.write(frame, measured.inputs)
        measured.weights.weigh(3.0 / 9.80665)
        recorder.write(measured.show(at(70.5, sent[2], unit=Unit.COUNTS, sequence=8)), measured.inputs)
    readings = list(read_recording(path))
    assert [(one.time, one.sequence, one.unit) for one in readings] == [
        (70.0, 4, Unit.COUNTS),
        (70.1, 5, Unit.COUNTS),
        (70.2, 6, Unit.COUNTS),
        (70.5, 8, Unit.COUNTS),
    ]
    assert all(np.array_equal(one.values, values) for one, values in zip(readings, sent, strict=False))
    again = session()
    frames = [again.show(Arrived(one, one.time)) for one in readings]
    assert again.readings.tared
    assert [frame.units for frame in frames] == [ReadingUnits.CALIBRATED] * 4
    assert abs(frames[2].regions[0].force - 3.0) < 0.1
    raw = session(mode=ValueMode.RAW)
    assert np.allclose(raw.show(Arrived(readings[1], 0.0)).pressures, 1e3 * sent[1])
    given = session(calibration=Calibration(np.full(60, 7.0), np.zeros(60)))
    given.show(Arrived(readings[0], 0.0))
    assert given.readings.calibration.gain[0] == 7.0


def test_recording_contains_only_received_taxels(tmp_path):
    path = tmp_path / "felt.mcap"
    measured = session()
    with Recorder(measured.prepared, path, measured="a file") as recorder:
        recorder.write(measured.show(at(0.0, [500.0], ids=[7])), measured.inputs)
    (reading,) = read_recording(path)
    assert reading.values.tolist() == [500.0]
    assert reading.ids.tolist() == [7]


@pytest.mark.parametrize("position", [1e300, -1e300, 1.7, -1.7])
def test_position_beyond_the_joint_range_is_rejected_and_counted(position):
    measured = session()
    frame = measured.show(at(0.0, touched(), joints={"hinge": 0.3}))
    assert measured.show(at(0.01, np.zeros(60), joints={"hinge": position})) is frame
    facts = measured.facts
    assert (facts.readings, facts.refused, measured.implausible.count) == (1, 1, 1)
    assert "joint hinge: a joint's position is impossible" in facts.problem
    assert measured.show(at(0.02, touched(), joints={"hinge": 1.55})).posture[0] == 1.55  # within the tolerance


def test_position_of_a_joint_without_limits_is_bounded():
    robot = replace(bar(), joints=(Joint("hinge", -np.inf, np.inf),))
    measured = MeasuredSession(as_measured(replace(prepared_bar(), robot=robot)))
    measured.show(at(0.0, touched(), joints={"hinge": 500.0}))
    measured.show(at(0.01, touched(), joints={"hinge": 1.1 * MOST_TURNS}))
    assert measured.frame.posture[0] == 500.0
    assert measured.facts.refused == 1


@pytest.mark.parametrize(("unit", "most"), [(Unit.COUNTS, 2.0**32), (Unit.PASCAL, 1e7), (Unit.KILOPASCAL, 1e4)])
def test_implausible_value_is_rejected_with_the_name_of_the_taxel(unit, most):
    measured = session()
    values = np.zeros(60)
    values[4] = -most
    measured.show(at(0.0, values, unit=unit))
    values = values.copy()
    values[4] = 1.001 * most
    measured.show(at(0.01, values, unit=unit))
    assert measured.facts.refused == 1
    assert "taxel 4" in measured.facts.problem


def test_unreachable_position_is_shown_and_stored():
    measured = session()
    for time, position in ((0.0, 0.0), (0.1, 1.4), (0.2, -1.4), (0.21, -1.05)):
        measured.show(at(time, touched(), joints={"hinge": position}))
    assert measured.implausible.count == 0  # 28 rad/s, and 0.35 rad in one step of 10 ms
    measured.show(at(0.22, touched(), joints={"hinge": -0.5}))  # 0.55 rad
    assert measured.frame.posture[0] == -0.5
    assert measured.implausible.count == 1
    assert measured.implausible.text == "joint hinge: moved by 0.55 in 0.01 s"


def test_several_readings_make_one_frame():
    measured = session()
    frames = []
    with measured.watched(frames.append):
        for number in range(3):
            assert measured.apply(at(0.01 * number, [float(number)], ids=[number]))
        assert frames == []
        frame = measured.make_frame()
    assert frames == [frame]
    assert frame.pressures[:3].tolist() == [0.0, 1.0, 2.0]
    assert measured.facts.readings == 3


def test_older_readings_are_required_until_every_taxel_and_joint_has_reported():
    measured = session()
    first = at(0.0, np.zeros(60), joints={"hinge": 0.0}).reading
    assert measured.missing()(first)  # what will be heard is not known yet
    measured.apply(Arrived(first, 100.0))
    assert not measured.missing()(first)
    needed = measured.missing()
    assert needed(at(0.0, np.zeros(60)).reading)
    assert needed(at(0.0, [1.0, 2.0]).reading)  # does not fit
    assert not needed(at(0.0, [0.0], ids=[3], joints={"hinge": 0.0}).reading)
    assert measured.facts.unknown_values == 0


def test_received_values_have_their_times():
    measured = session()
    measured.apply(Arrived(at(0.0, np.zeros(60), joints={"hinge": 0.0}).reading, 100.0, 0.25))
    measured.apply(Arrived(at(0.01, [0.0], ids=[3]).reading, 101.0, 0.0))
    assert measured.heard.joints.tolist() == [99.75]
    assert measured.heard.taxels[2:5].tolist() == [99.75, 101.0, 99.75]
    measured.reset()
    assert measured.heard.joints.tolist() == [-np.inf]
    assert measured.facts.unheard_joints == 1


def test_velocity_uses_the_time_since_the_last_reading_of_the_joint():
    measured = session()
    measured.show(at(0.0, touched(), joints={"hinge": 0.0}))
    assert measured.frame.velocity[0] == 0.0
    measured.show(at(0.01, touched()))
    measured.show(at(0.02, [1.0], ids=[3], joints={"hinge": 0.02}))
    assert np.isclose(measured.frame.velocity[0], 1.0)
    measured.show(at(0.02, [1.0], ids=[4], joints={"hinge": 0.02}))  # another part at the same time
    assert np.isclose(measured.frame.velocity[0], 1.0)
