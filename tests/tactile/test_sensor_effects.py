"""Each effect of the sensor by itself, in the order of the signal."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.tactile.sensors.sensor_effects import (
    ALIVE,
    DEAD,
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
    Threshold,
    check_setting,
)
from tests.support.sensors import readings, refuses, row, stage


@pytest.mark.parametrize("value", [0, 0.0, 1, 0.5, 1.0, np.float32(0.5), np.int64(1)])
def test_both_ends_and_any_real_number_between_are_in_range(value):
    check_setting("noise.sd", value, 0.0, 1.0)


@pytest.mark.parametrize("value", [-1e-9, 1.0001, float("nan"), float("inf"), "0.5", None, True, 1j, [0.5]])
def test_number_out_of_range_is_rejected_with_place_and_range(value):
    with pytest.raises(SimulationError, match=r"sensor\.noise\.sd: .*Choose 0 to 1") as error:
        check_setting("noise.sd", value, 0.0, 1.0)
    assert error.value.value is value


def test_every_effect_has_its_own_random_stream():
    readout = Readout(row(1), 0.01, 7)
    first = readout.stream("noise").random(4).tolist()
    assert readout.stream("noise").random(4).tolist() == first
    assert readout.stream("offset_drift").random(4).tolist() != first
    assert Readout(row(1), 0.01, 8).stream("noise").random(4).tolist() != first


@pytest.mark.parametrize("tick", [0.0, -0.01, float("nan"), float("inf")])
def test_invalid_tick_is_rejected(tick):
    with pytest.raises(SimulationError, match="tick.*found"):
        Readout(row(1), tick, 0)


def test_negative_seed_is_rejected():
    with pytest.raises(SimulationError, match="seed.*-1"):
        Readout(row(1), 0.01, -1)


def test_isolated_taxel_keeps_its_whole_reading_under_crosstalk():
    at_work = stage(Crosstalk(share=0.9), skin=row(3, neighbours=[(0, 1)]))
    assert readings(at_work, [[0, 0, 1000]])[0].tolist() == [0, 0, 1000]
    assert readings(stage(Crosstalk()), [[1000]])[0].tolist() == [1000]


def test_reading_is_not_overwritten_by_the_next():
    at_work = stage(Noise(), 4)
    first = at_work.read(np.zeros(4))
    kept = first.copy()
    at_work.read(np.zeros(4))
    assert np.array_equal(first, kept)


def test_readings_above_saturation_are_clipped():
    at_work = stage(Saturation(at=100.0), 4)
    assert readings(at_work, [[-5.0, np.nextafter(100, 0), 100.0, 1e9]]).tolist() == [
        [-5.0, np.nextafter(100, 0), 100.0, 100.0]
    ]
    assert readings(at_work, [[0.0, 0, 0, 200]])[0].tolist() == [0, 0, 0, 100]


def test_readings_are_never_negative_zero():
    assert not np.signbit(readings(stage(Quantisation(step=200.0), 2), [[-30.0, -0.0]])).any()


def test_dead_taxels_read_zero_stuck_taxels_a_constant_and_others_their_pressure():
    at_work = stage(DeadTaxels(dead=0.3, stuck=0.2, stuck_at=7.0), 10)
    (read,) = readings(at_work, [np.full(10, 1000.0)])
    assert (read[at_work.codes == DEAD] == 0).all()
    assert (read[at_work.codes == STUCK] == 7.0).all()
    assert (read[at_work.codes == ALIVE] == 1000.0).all()
    assert [np.count_nonzero(at_work.codes == code) for code in (ALIVE, DEAD, STUCK)] == [5, 3, 2]


def test_larger_share_breaks_the_same_taxels_and_more():
    fewer, more = (stage(DeadTaxels(dead=s, stuck=s), 100).codes for s in (0.1, 0.4))
    for code in (DEAD, STUCK):
        assert (more[fewer == code] == code).all()


def test_sample_is_kept_unchanged_and_read_only():
    at_work = stage(Sampling(10.0, 0.0))
    pressures = np.array([5.0])
    read = at_work.read(pressures)
    pressures[:] = 9.0
    assert at_work.read(pressures).tolist() == read.tolist() == [5.0]
    assert not read.flags.writeable


@pytest.mark.parametrize(("rate", "delay"), [(100.0, 0.07), (33.0, 0.1), (7.3, 1.0), (1e4, 0.0)])
def test_state_has_constant_length_and_reset_restores_the_first(rate, delay):
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


@pytest.mark.parametrize(
    ("effect", "field", "values"),
    [
        (AreaAveraging, "radius", (0.0, -0.001, 0.06)),
        (Crosstalk, "share", (-0.01, 0.91)),
        (Hysteresis, "share", (-0.01, 1.01)),
        (Hysteresis, "seconds", (0.0, -1.0, 1.1e4)),
        (GainSpread, "sd", (-0.01, 1.01)),
        (OffsetDrift, "sd", (-1.0, 1.1e6)),
        (OffsetDrift, "walk", (-1.0, 1.1e6)),
        (Noise, "sd", (-1.0, 1.1e6)),
        (Saturation, "at", (0.0, 0.5, 1.1e9)),
        (Threshold, "at", (-1.0, 1.1e6)),
        (Quantisation, "step", (0.0, -1.0, 1.1e6)),
        (DeadTaxels, "dead", (-0.01, 1.01)),
        (DeadTaxels, "stuck", (-0.01, 1.01)),
        (DeadTaxels, "stuck_at", (-1.0, 1.1e9)),
        (Sampling, "rate", (0.0, -1.0, 1.1e4)),
        (Sampling, "delay", (-0.01, 1.01)),
    ],
)
def test_setting_out_of_range_is_rejected(effect, field, values):
    refuses(effect, field, *values)


def test_shares_of_dead_and_stuck_taxels_above_one_in_sum_are_rejected():
    with pytest.raises(SimulationError, match="dead and stuck together"):
        DeadTaxels(dead=0.6, stuck=0.5)
