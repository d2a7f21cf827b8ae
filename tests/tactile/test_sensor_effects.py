"""Each effect of the sensor by itself, in the order of the signal."""

from __future__ import annotations

from dataclasses import asdict, fields

import numpy as np
import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.tactile.sensors.sensor_effects import (
    ALIVE,
    DEAD,
    SENSOR_KEYS,
    STUCK,
    AreaAveraging,
    Crosstalk,
    DeadTaxels,
    GainSpread,
    Hysteresis,
    Noise,
    OffsetDrift,
    Quantisation,
    Readout,
    Sampling,
    Saturation,
    SensorEffects,
    Threshold,
    check_range,
)
from tests.support.sensors import ALL_ON, readings, refuses, row, stage


@pytest.mark.parametrize("value", [0, 0.0, 1, 0.5, 1.0, np.float32(0.5), np.int64(1)])
def test_both_ends_and_any_real_number_between_are_in_range(value):
    check_range("noise.sd", value, 0.0, 1.0)


@pytest.mark.parametrize("value", [-1e-9, 1.0001, float("nan"), float("inf"), "0.5", None, True, 1j, [0.5]])
def test_all_else_is_refused_with_its_place_and_what_to_choose(value):
    with pytest.raises(SimulationError, match=r"sensor\.noise\.sd: .*Choose 0 to 1") as error:
        check_range("noise.sd", value, 0.0, 1.0)
    assert error.value.value is value


def test_every_effect_has_a_stream_of_its_own_that_begins_anew():
    readout = Readout(row(1), 0.01, 7)
    first = readout.stream("noise").random(4).tolist()
    assert readout.stream("noise").random(4).tolist() == first
    assert readout.stream("offset_drift").random(4).tolist() != first
    assert Readout(row(1), 0.01, 8).stream("noise").random(4).tolist() != first


@pytest.mark.parametrize("tick", [0.0, -0.01, float("nan"), float("inf")])
def test_a_tick_that_is_none_is_refused(tick):
    with pytest.raises(SimulationError, match="tick.*found"):
        Readout(row(1), tick, 0)


def test_a_negative_seed_is_refused():
    with pytest.raises(SimulationError, match="seed.*-1"):
        Readout(row(1), 0.01, -1)


def test_a_pad_is_that_of_roboskin_unless_told():
    assert AreaAveraging().radius == 0.0019


def test_a_radius_out_of_range_is_refused():
    refuses(AreaAveraging, "radius", 0.0, -0.001, 0.06)


def test_a_taxel_gives_its_share_to_its_neighbours_in_equal_parts():
    at_work = stage(Crosstalk(share=0.1), 5)
    assert readings(at_work, [[0, 0, 1000, 0, 0]])[0] == pytest.approx([0, 50, 900, 50, 0])
    assert readings(at_work, [[1000, 0, 0, 0, 0]])[0] == pytest.approx([900, 100, 0, 0, 0])


def test_it_is_force_that_is_given_so_a_taxel_twice_as_large_reads_half_of_it():
    at_work = stage(Crosstalk(share=0.1), skin=row(2, areas=[1e-4, 2e-4]))
    assert readings(at_work, [[1000, 0]])[0] == pytest.approx([900, 50])


def test_a_taxel_without_neighbours_keeps_all():
    at_work = stage(Crosstalk(share=0.9), skin=row(3, neighbours=[(0, 1)]))
    assert readings(at_work, [[0, 0, 1000]])[0].tolist() == [0, 0, 1000]
    assert readings(stage(Crosstalk()), [[1000]])[0].tolist() == [1000]


def test_crosstalk_remembers_nothing():
    at_work = stage(Crosstalk(), 5)
    first = readings(at_work, [[0, 0, 1000, 0, 0]])
    assert at_work.state().shape == (0,)
    at_work.reset()
    assert np.array_equal(readings(at_work, [[0, 0, 1000, 0, 0]]), first)


def test_a_share_out_of_range_is_refused():
    refuses(Crosstalk, "share", -0.01, 0.91)


def test_of_a_step_the_late_share_is_missing_at_first_and_arrives():
    read = readings(stage(Hysteresis(share=0.25, seconds=0.1), tick=0.01), [[1000.0]] * 500)[:, 0]
    assert read[0] == 750.0
    assert (np.diff(read) >= 0).all()
    assert read[-1] == pytest.approx(1000.0)


def test_after_release_the_late_share_remains_and_goes():
    at_work = stage(Hysteresis(share=0.25, seconds=0.1), tick=0.01)
    readings(at_work, [[1000.0]] * 500)
    read = readings(at_work, [[0.0]] * 6000)[:, 0]
    assert read[0] == pytest.approx(250.0)
    assert read[-1] == 0.0
    assert not at_work.state().any(), "what is left must not linger as a subnormal number"


def test_reset_forgets_and_the_state_is_its_own():
    at_work = stage(Hysteresis(), 2)
    readings(at_work, [[1000.0, 0.0]] * 3)
    state = at_work.state()
    assert state[0] > 0
    assert state[1] == 0
    state[:] = 5.0
    assert not np.array_equal(at_work.state(), state)
    at_work.reset()
    assert not at_work.state().any()


def test_hysteresis_out_of_range_is_refused():
    refuses(Hysteresis, "share", -0.01, 1.01)
    refuses(Hysteresis, "seconds", 0.0, -1.0, 1.1e4)


def test_every_taxel_has_a_gain_of_its_own_that_stays():
    at_work = stage(GainSpread(sd=0.2), 4)
    once, twice, double = readings(at_work, [np.full(4, 100.0), np.full(4, 100.0), np.full(4, 200.0)])
    assert len(set(once)) == 4
    assert np.array_equal(once, twice)
    assert np.array_equal(double, 2 * once)
    at_work.reset()
    assert np.array_equal(readings(at_work, [np.full(4, 100.0)])[0], once)
    assert at_work.state().shape == (0,)


def test_without_spread_nothing_changes():
    assert readings(stage(GainSpread(sd=0.0), 3), [[1.0, -2.0, 3.0]]).tolist() == [[1.0, -2.0, 3.0]]


def test_no_gain_is_negative_however_wide_they_spread():
    assert readings(stage(GainSpread(sd=1.0), 10_000), [np.ones(10_000)]).min() > 0


def test_a_gain_deviation_out_of_range_is_refused():
    refuses(GainSpread, "sd", -0.01, 1.01)


def test_an_offset_is_added_whatever_presses():
    pressed, free = (stage(OffsetDrift(), 3) for _ in range(2))
    assert np.allclose(readings(pressed, [[1e4, 0, 50]] * 9) - readings(free, [[0, 0, 0]] * 9), [1e4, 0, 50])


def test_without_walk_the_offsets_stay():
    read = readings(stage(OffsetDrift(sd=50.0, walk=0.0), 3), np.zeros((5, 3)))
    assert read[0].any()
    assert (read == read[0]).all()


def test_reset_starts_the_same_walk_again():
    at_work = stage(OffsetDrift(), 3)
    start = at_work.state()
    first = readings(at_work, np.zeros((5, 3)))
    assert at_work.state()[0] == 5
    assert not np.array_equal(at_work.state()[1:], start[1:])
    at_work.reset()
    assert np.array_equal(at_work.state(), start)
    assert np.array_equal(readings(at_work, np.zeros((5, 3))), first)


def test_offset_drift_out_of_range_is_refused():
    refuses(OffsetDrift, "sd", -1.0, 1.1e6)
    refuses(OffsetDrift, "walk", -1.0, 1.1e6)


def test_it_is_new_at_every_taxel_and_every_reading():
    read = readings(stage(Noise(), 4), np.zeros((5, 4)))
    assert len(set(read.ravel())) == 20


def test_a_seed_makes_its_own_noise_and_reset_the_same_again():
    at_work = stage(Noise(), 4)
    other = stage(Noise(), 4, seed=1)
    first = readings(at_work, np.zeros((5, 4)))
    assert not np.array_equal(readings(other, np.zeros((5, 4))), first)
    assert at_work.state().tolist() == [5.0]
    at_work.reset()
    assert np.array_equal(readings(at_work, np.zeros((5, 4))), first)


def test_a_reading_is_not_overwritten_by_the_next():
    at_work = stage(Noise(), 4)
    first = at_work.read(np.zeros(4))
    kept = first.copy()
    at_work.read(np.zeros(4))
    assert np.array_equal(first, kept)


def test_a_noise_deviation_out_of_range_is_refused():
    refuses(Noise, "sd", -1.0, 1.1e6)


def test_what_presses_harder_reads_the_highest_and_is_told():
    at_work = stage(Saturation(at=100.0), 4)
    assert not at_work.saturated.any()
    assert readings(at_work, [[-5.0, np.nextafter(100, 0), 100.0, 1e9]]).tolist() == [
        [-5.0, np.nextafter(100, 0), 100.0, 100.0]
    ]
    assert at_work.saturated.tolist() == [False, False, True, True]
    assert readings(at_work, [[0.0, 0, 0, 200]])[0].tolist() == [0, 0, 0, 100]
    assert at_work.saturated.tolist() == [False, False, False, True]


def test_reset_forgets_which_were():
    at_work = stage(Saturation(at=100.0), 2)
    readings(at_work, [[200.0, 0.0]])
    at_work.reset()
    assert not at_work.saturated.any()
    assert at_work.state().shape == (0,)


def test_a_saturation_pressure_out_of_range_is_refused():
    refuses(Saturation, "at", 0.0, 0.5, 1.1e9)


def test_what_is_below_reads_nothing_and_what_is_not_reads_in_full():
    at_work = stage(Threshold(at=100.0), 5)
    read = readings(at_work, [[-5.0, 0.0, np.nextafter(100, 0), 100.0, 1e6]])
    assert read.tolist() == [[0.0, 0.0, 0.0, 100.0, 1e6]]


def test_it_has_no_hysteresis():
    at_work = stage(Threshold(at=100.0))
    assert readings(at_work, [[99.0], [101.0], [99.0], [101.0]]).ravel().tolist() == [0, 101, 0, 101]
    at_work.reset()
    assert at_work.state().shape == (0,)


def test_at_nought_only_what_is_negative_is_lost():
    assert readings(stage(Threshold(at=0.0), 3), [[-1.0, 0.0, 1e-9]]).tolist() == [[0.0, 0.0, 1e-9]]


def test_a_threshold_pressure_out_of_range_is_refused():
    refuses(Threshold, "at", -1.0, 1.1e6)


def test_a_reading_is_the_nearest_whole_number_of_steps_and_a_half_goes_to_the_even():
    at_work = stage(Quantisation(step=200.0), 7)
    read = readings(at_work, [[-130.0, 0, 99, 100, 101, 300, 1e4]])
    assert read.tolist() == [[-200.0, 0, 0, 0, 200, 400, 1e4]]


def test_no_reading_is_minus_nought():
    assert not np.signbit(readings(stage(Quantisation(step=200.0), 2), [[-30.0, -0.0]])).any()


def test_quantisation_remembers_nothing():
    at_work = stage(Quantisation())
    at_work.reset()
    assert at_work.state().shape == (0,)


def test_a_step_out_of_range_is_refused():
    refuses(Quantisation, "step", 0.0, -1.0, 1.1e6)


def test_the_dead_read_nothing_the_stuck_always_the_same_the_others_what_they_feel():
    at_work = stage(DeadTaxels(dead=0.3, stuck=0.2, stuck_at=7.0), 10)
    (read,) = readings(at_work, [np.full(10, 1000.0)])
    assert (read[at_work.codes == DEAD] == 0).all()
    assert (read[at_work.codes == STUCK] == 7.0).all()
    assert (read[at_work.codes == ALIVE] == 1000.0).all()
    assert [np.count_nonzero(at_work.codes == code) for code in (ALIVE, DEAD, STUCK)] == [5, 3, 2]


def test_what_enters_is_not_changed_and_what_broke_stays_broken():
    at_work = stage(DeadTaxels(dead=1.0), 4)
    pressures = np.ones(4)
    codes = at_work.codes.copy()
    assert not at_work.read(pressures).any()
    assert pressures.all()
    at_work.reset()
    assert np.array_equal(at_work.codes, codes)
    assert at_work.state().shape == (0,)
    assert not at_work.codes.flags.writeable


def test_a_larger_share_breaks_the_same_and_more():
    fewer, more = (stage(DeadTaxels(dead=s, stuck=s), 100).codes for s in (0.1, 0.4))
    for code in (DEAD, STUCK):
        assert (more[fewer == code] == code).all()


def test_no_taxel_is_both():
    assert stage(DeadTaxels(dead=0.5, stuck=0.5), 3).codes.tolist().count(ALIVE) == 0
    assert stage(DeadTaxels(dead=0.7, stuck=0.3), 1000).codes.tolist().count(DEAD) == 700


def test_shares_out_of_range_are_refused_also_together():
    refuses(DeadTaxels, "dead", -0.01, 1.01)
    refuses(DeadTaxels, "stuck", -0.01, 1.01)
    refuses(DeadTaxels, "stuck_at", -1.0, 1.1e9)
    with pytest.raises(SimulationError, match="dead and stuck together"):
        DeadTaxels(dead=0.6, stuck=0.5)


def _read(rate, delay, count, *, tick=0.01):
    """What arrives at each tick when tick k presses with k + 1."""
    return readings(stage(Sampling(rate, delay), tick=tick), np.arange(1.0, count + 1)[:, None])[:, 0].tolist()


def test_between_samples_the_last_one_holds():
    assert _read(50.0, 0.0, 7) == [1, 1, 3, 3, 5, 5, 7]


def test_samples_arrive_late_and_before_the_first_there_is_nothing():
    assert _read(50.0, 0.03, 8) == [0, 0, 0, 1, 1, 3, 3, 5]


def test_a_rate_above_the_ticks_samples_at_every_tick():
    assert _read(1e4, 0.0, 4) == [1, 2, 3, 4]
    assert _read(1e4, 0.02, 5) == [0, 0, 1, 2, 3]


def test_a_sample_is_kept_as_it_was_and_none_may_change_it():
    at_work = stage(Sampling(10.0, 0.0))
    pressures = np.array([5.0])
    read = at_work.read(pressures)
    pressures[:] = 9.0
    assert at_work.read(pressures).tolist() == read.tolist() == [5.0]
    assert not read.flags.writeable


@pytest.mark.parametrize(("rate", "delay"), [(100.0, 0.07), (33.0, 0.1), (7.3, 1.0), (1e4, 0.0)])
def test_the_state_has_one_length_and_reset_brings_back_the_first(rate, delay):
    at_work = stage(Sampling(rate, delay), 3)
    start = at_work.state()
    pressures = np.random.default_rng(0).random((300, 3))
    first = readings(at_work, pressures)
    for _ in range(100):
        at_work.read(np.ones(3))
        assert at_work.state().shape == start.shape
    at_work.reset()
    assert np.array_equal(at_work.state(), start)
    assert np.array_equal(readings(at_work, pressures), first)


def test_sampling_out_of_range_is_refused():
    refuses(Sampling, "rate", 0.0, -1.0, 1.1e4)
    refuses(Sampling, "delay", -0.01, 1.01)


def test_all_is_off_unless_told():
    assert set(asdict(SensorEffects()).values()) == {None, ()}


def test_the_fields_stand_in_the_order_of_the_signal():
    assert [field.name for field in fields(SensorEffects)] == [*SENSOR_KEYS, "plug_ins"]
    assert list(SENSOR_KEYS) == [
        "area_averaging", "crosstalk", "hysteresis", "gain_spread", "offset_drift", "noise", "saturation", "threshold",
        "quantisation", "dead_taxels", "sampling",
    ]  # fmt: skip


def test_equal_choices_are_equal():
    assert SensorEffects(**{f.name: getattr(ALL_ON, f.name) for f in fields(ALL_ON)}) == ALL_ON
