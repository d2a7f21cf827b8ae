"""Parts of the uncertainty of force and place, against sums by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.centre_of_pressure import SensorUncertainty
from tactile_maps.contacts.detection.error_budget import (
    LeftOut,
    Motion,
    Readings,
    Uncertainty,
    combine_parts,
    coverage_interval,
    propagate_uncertainty,
)
from tactile_maps.contacts.detection.taxel_noise import TaxelNoise
from tactile_maps.tactile.sensors.sensor_effects import (
    AreaAveraging,
    Crosstalk,
    DeadTaxels,
    GainSpread,
    Hysteresis,
    Noise,
    OffsetDrift,
    Quantisation,
    Sampling,
    Saturation,
    SensorEffects,
    Threshold,
)

AREA = 1e-4
ONE = Readings(np.array([1.0, 0.0, 0.0]), np.full(3, AREA), np.arange(3), np.array([0]))
"""1 N on one taxel of 1 cm², with a ring of two that read nothing."""
TWO = Readings(np.ones(2), np.full(2, AREA), np.arange(2), np.arange(2))
"""1 N on each of two taxels."""


def budget(readings: Readings = ONE, elapsed: float = 0.0, **effects) -> Uncertainty:
    errors = replace(SensorUncertainty.of_sensor(SensorEffects(**effects)), elapsed=elapsed)
    return propagate_uncertainty(errors, readings, np.zeros(len(readings.forces)))


def parts(readings: Readings = ONE, elapsed: float = 0.0, **effects) -> dict[str, float]:
    return dict(budget(readings, elapsed, **effects).parts)


def limits(readings: Readings = ONE, **effects) -> dict[str, float]:
    return dict(budget(readings, **effects).limits)


def test_force_of_a_perfect_sensor_is_exact_and_its_position_within_a_taxel():
    found = propagate_uncertainty(SensorUncertainty(), ONE, np.zeros(3))
    assert (found.force, found.parts) == (0.0, {})
    assert found.place == pytest.approx(math.sqrt(AREA / 6), rel=0.06), "a lump anywhere in a square"


def test_position_of_a_line_of_taxels_is_less_certain_than_that_of_a_round_contact():
    """Six taxels with 1 N each, 1 cm apart in a row, and as far from the centre as those of a paraboloid."""
    six = Readings(np.ones(6), np.full(6, AREA), np.arange(6), np.arange(6))
    line = ((np.arange(6) - 2.5) * 0.01) ** 2
    round_ = np.full(6, 4 / (9 * math.pi) * 6 * AREA)
    found, alike, between = (
        propagate_uncertainty(SensorUncertainty(), six, squared).place ** 2 for squared in (line, round_, 1.65 * round_)
    )
    assert found - alike == pytest.approx(AREA / 24 / 6)
    assert between - alike == pytest.approx(AREA / 24 / 6 / 2)


def test_uncertainty_of_two_equal_taxels_matches_hand_calculation():
    """1 N on each of two taxels, each 1 cm from the centre."""
    errors = SensorUncertainty(noise=100.0, gain=0.1, calibration=0.003)
    found = propagate_uncertainty(errors, TWO, np.full(2, 1e-4))
    assert found.force == pytest.approx(math.sqrt(100**2 * 2 * AREA**2 + 0.01 * 2))
    inner = AREA / 6 * (0.7 * math.exp(-1.5) + 0.15 / 8 + 0.045 / 2) + AREA / 24 / 2
    lines = (100 / 2) ** 2 * 2 * AREA**2 * 1e-4, 0.01 * 0.5 * 1e-4, 2 * 0.003**2 * 0.5, inner
    assert found.place == pytest.approx(math.sqrt(sum(lines)))


@pytest.mark.parametrize(
    ("effects", "expected"),
    [
        ({"noise": Noise(300.0)}, {"noise": 300 * AREA * math.sqrt(3)}),
        ({"offset_drift": OffsetDrift(30.0, 20.0)}, {"offset_drift": 50 * AREA * math.sqrt(3)}),
        ({"gain_spread": GainSpread(0.2)}, {"gain_spread": 0.2}),
        ({"quantisation": Quantisation(120.0)}, {"quantisation": 1.18 * 120 / math.sqrt(12) * AREA}),
        ({"hysteresis": Hysteresis(0.3)}, {"hysteresis": 0.39 * 0.3 / (1 - 0.39 * 0.3)}),
        ({"area_averaging": AreaAveraging(0.001)}, {"area_averaging": 0.75}),
        ({"dead_taxels": DeadTaxels(0.1)}, {"dead_taxels": math.sqrt(0.1 + 0.01)}),
        ({"dead_taxels": DeadTaxels(0.0, 0.04, 1e4)}, {"dead_taxels": 0.2 * math.sqrt(1 + 3)}),
        ({"saturation": Saturation(1e4)}, {"saturation": 1.16 * AREA * 1e4}),
        ({"saturation": Saturation(2e4)}, {"saturation": 0.0}),
    ],
)
def test_each_effect_has_its_part_of_the_uncertainty(effects, expected):
    assert parts(elapsed=4.0, **effects) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("effects", "expected"),
    [
        ({"noise": Noise(300.0)}, {"noise": 600 * AREA * math.sqrt(3)}),
        ({"quantisation": Quantisation(120.0)}, {"quantisation": 1.645 * 120 / math.sqrt(12) * AREA}),
        ({"hysteresis": Hysteresis(0.3)}, {"hysteresis": 0.88 * 0.3 / (1 - 0.88 * 0.3)}),
        ({"area_averaging": AreaAveraging(0.001)}, {"area_averaging": 4.4}),
        ({"saturation": Saturation(1e4)}, {"saturation": 2.57 * AREA * 1e4}),
    ],
)
def test_interval_uses_a_specific_width_for_each_effect(effects, expected):
    assert limits(**effects) == pytest.approx(expected)


def test_sum_of_uniformly_distributed_errors_is_nearly_normal():
    sd = 120 / math.sqrt(12) * AREA * math.sqrt(2)
    found = budget(TWO, quantisation=Quantisation(120.0))
    assert found.parts["quantisation"] == pytest.approx(1.064 * sd, rel=1e-3)
    assert found.limits["quantisation"] == pytest.approx(1.933 * sd, rel=1e-3)


def test_losses_do_not_lower_the_interval():
    limits = {"noise": 0.3, "saturation": 2.0, "ring": 0.1}
    low, high = coverage_interval(1.0, limits)
    assert low == pytest.approx(0.7)
    assert high == pytest.approx(1.0 + combine_parts(limits))
    assert coverage_interval(1.0, {"noise": 3.0}) == pytest.approx((0.0, 4.0)), "contact cannot pull"
    assert coverage_interval(1.0, {"contact_model": math.inf}) == (0.0, math.inf)


def test_tails_beyond_the_ring_widen_forces_of_taxels_below_the_surface():
    """Pi R² = 3 AREA is 6 depths of 2 mm squared."""
    deep = SensorUncertainty(depth=0.002)
    found = propagate_uncertainty(deep, ONE, np.zeros(3))
    tail = (1 + 3 * AREA / math.pi / 0.002**2) ** -1.5
    assert found.parts == pytest.approx({"ring": 0.5 * tail**2 / 0.01})
    assert found.limits == pytest.approx({"ring": tail**2 / 0.01})
    coarse = replace(SensorUncertainty.of_sensor(SensorEffects(quantisation=Quantisation(1e4))), depth=0.002)
    dark = 0.32 * 2 * 0.002 * math.sqrt(AREA) * 1e4
    rounded = propagate_uncertainty(coarse, ONE, np.zeros(3))
    assert rounded.parts["ring"] == pytest.approx(math.hypot(0.5 * tail**2 / 0.01, dark))
    assert rounded.limits["ring"] == pytest.approx(math.hypot(tail**2 / 0.01, 2 * dark))
    unfelt = replace(SensorUncertainty.of_sensor(SensorEffects(threshold=Threshold(100.0))), depth=0.002)
    more = (
        propagate_uncertainty(unfelt, ONE, np.zeros(3)).parts["threshold"]
        - parts(threshold=Threshold(100.0))["threshold"]
    )
    assert more == pytest.approx(0.01 * dark)


@pytest.mark.parametrize(("model", "share"), [("water-fill", 0.0), ("foundation", 0.019), ("depth", math.inf)])
def test_contact_model_may_not_conserve_force(model, share):
    found = propagate_uncertainty(SensorUncertainty.of_sensor(SensorEffects(), model=model), TWO, np.zeros(2))
    assert found.parts.get("contact_model", 0.0) == found.force == 2 * share
    assert found.limits.get("contact_model", 0.0) == pytest.approx(2.3 * 2 * share)


def test_threshold_loses_the_rim_but_no_more_than_taxels_reading_zero():
    lost = 2 * math.pi * math.pi**-0.75 * math.sqrt(100 / 1e4)
    assert parts(threshold=Threshold(100.0))["threshold"] == pytest.approx(100 * AREA * 0.41 * lost)
    assert limits(threshold=Threshold(100.0))["threshold"] == pytest.approx(
        100 * AREA * 2 * math.sqrt(lost**2 / 9 + lost / 5)
    )
    assert parts(threshold=Threshold(9e3))["threshold"] == pytest.approx(9e3 * AREA * 0.41 * 0.015 / math.sqrt(AREA))
    wide = ONE._replace(areas=np.full(3, 0.03**2))
    assert parts(wide, threshold=Threshold(800.0))["threshold"] == pytest.approx(800 * 0.03**2 * (0.5 * 0.5 - 0.12))
    assert limits(wide, threshold=Threshold(800.0))["threshold"] == pytest.approx(800 * 0.03**2 * (1.3 - 0.23 / 0.5))
    two = ONE._replace(areas=np.full(3, AREA / 9))
    assert parts(two, threshold=Threshold(8e4))["threshold"] == pytest.approx(8e4 * AREA / 9 * 0.41 * 2)
    assert parts(TWO, threshold=Threshold(100.0))["threshold"] == 0, "no dark taxel, nothing lost"


def test_threshold_of_more_touched_taxels_loses_the_rim_of_a_wide_contact():
    """The rim of one taxel is at most 15 mm long, that of two in most cases, and that of three is not limited."""
    narrow = 0.015 / math.sqrt(AREA)
    for count in (1, 2, 3):
        whole = 2 * math.pi * (count / math.pi) ** 0.75 * math.sqrt(0.5)
        usual = whole if count == 3 else narrow
        most = narrow if count == 1 else whole
        forces = np.concatenate([np.ones(count), np.zeros(9)])
        readings = Readings(forces, np.full(count + 9, AREA), np.arange(count + 9), np.arange(count))
        threshold = Threshold(0.5 / AREA)
        assert parts(readings, threshold=threshold)["threshold"] == pytest.approx(
            0.5 * min(0.41 * usual, 0.5 * usual - 0.12 if count < 3 else math.inf)
        )
        assert limits(readings, threshold=threshold)["threshold"] == pytest.approx(
            0.5 * max(2 * math.sqrt(most**2 / 9 + most / 5), 1.3 - 0.23 / narrow if count < 3 else 0.0)
        )


def test_readings_below_a_threshold_have_no_noise():
    with_noise = {"noise": Noise(300.0), "offset_drift": OffsetDrift(50.0, 0.0)}
    found = parts(threshold=Threshold(2000.0), **with_noise)
    assert found["noise"] == pytest.approx(300 * AREA), "of the one that reads"
    assert found["offset_drift"] == pytest.approx(50 * AREA)


def test_converter_adds_uncertainty_to_unpressed_taxels_only_if_noise_reaches_it():
    one = 120 / math.sqrt(12) * AREA
    assert parts(quantisation=Quantisation(120.0))["quantisation"] == pytest.approx(1.18 * one)
    assert parts(quantisation=Quantisation(120.0), noise=Noise(100.0))["quantisation"] == pytest.approx(
        (1 + 0.18 * 3**-1.5) * one * math.sqrt(3)
    )


def test_noise_and_converter_are_separate_parts():
    noise = {"noise": Noise(100.0)}
    assert parts(quantisation=Quantisation(120.0), **noise)["noise"] == pytest.approx(parts(**noise)["noise"])


def test_force_in_the_ring_indicates_force_beyond_it():
    readings = Readings(np.array([0.9, 0.1]), np.full(2, AREA), np.arange(2), np.array([0]))
    assert parts(readings) == {"ring": 0.0}
    assert limits(readings) == pytest.approx({"ring": 0.001})
    own = 0.1 - 0.05 / 0.95 * 0.9
    assert parts(readings, crosstalk=Crosstalk(0.05)) == {"ring": 0.0}, "what crosstalk passes beyond is known"
    assert limits(readings, crosstalk=Crosstalk(0.05)) == pytest.approx({"ring": own**3})


def test_omitted_force_next_to_a_contact_is_limited_by_its_row():
    readings = Readings(np.array([0.9, 0.1]), np.full(2, AREA), np.arange(2), np.array([0]))
    peak = 0.9 / AREA
    for left_out, limit in (
        (LeftOut(most=4e-4), 4e-4),
        (LeftOut(most=4e-4, seen=0.2), 0.2),
        (LeftOut(most=4e-4, level=0.3 * peak), 0.09),
        (LeftOut(most=0.2, level=0.01 * peak), 0.001),
    ):
        assert limits(readings._replace(left_out=left_out)) == pytest.approx({"ring": limit})
    cut = limits(readings._replace(left_out=LeftOut(level=0.3 * peak)), threshold=Threshold(100.0))
    assert cut["ring"] == pytest.approx(0.001), "the part of the threshold is that of the rim"
    offset = limits(readings._replace(left_out=LeftOut(most=0.0, offset=200.0)))
    assert offset == pytest.approx({"offset_drift": 400 * AREA})
    deep = propagate_uncertainty(
        SensorUncertainty(depth=0.002), readings._replace(left_out=LeftOut(most=3e-6)), np.zeros(2)
    )
    assert deep.limits["ring"] == pytest.approx(math.hypot(3e-6, 4e-6))


def test_coarse_pad_alone_is_more_uncertain():
    """Contacts of up to 16 mm are small between pads that are 32 mm apart."""
    area = math.sqrt(0.75) * 0.032**2
    coarse = Readings(np.array([1.0]), np.array([area]), np.arange(1), np.arange(1))
    found = parts(coarse, area_averaging=AreaAveraging(0.001))
    assert found["area_averaging"] == pytest.approx(1 - 0.25 * (0.42 - 0.17 * 0.25))


def test_pad_reads_a_point_completely_or_not_at_all():
    errors = SensorUncertainty.of_sensor(SensorEffects(area_averaging=AreaAveraging(0.001)), model="point")
    found = propagate_uncertainty(errors, ONE, np.zeros(3))
    assert found.parts["area_averaging"] == pytest.approx(1 - math.pi * 1e-2)


def test_displaced_pads_are_less_certain_in_force_and_place():
    pads = SensorUncertainty.of_sensor(SensorEffects(area_averaging=AreaAveraging(0.002)))
    displaced = replace(pads, displaced=np.full(9, 0.002**2))
    nine = Readings(np.ones(9), np.full(9, AREA), np.arange(9), np.arange(9))
    known, found = (propagate_uncertainty(errors, nine, np.zeros(9)) for errors in (pads, displaced))
    assert found.place**2 - known.place**2 == pytest.approx(0.002**2 / 9)
    sampled = 9 * 0.5 * 9**-0.75 * math.exp(-1.8 * math.pi * 0.04)
    expected = math.hypot(sampled, math.sqrt(7 * (0.07**2 + 0.2**2)))
    assert found.force == pytest.approx(expected)


@pytest.mark.parametrize(
    ("forces", "factor", "power"),
    [
        (np.linspace(0, 2, 402)[1:-1] ** 1.1, 0.29, -1.25),
        (1 - np.linspace(-1, 1, 402)[1:-1] ** 2, 0.5, -0.75),
        (np.ones(400), 0.5, -0.75),
    ],
    ids=["round", "line", "face"],
)
def test_edges_make_pads_less_certain(forces, factor, power):
    """Pressures of a paraboloid are evenly distributed up to its peak; these are a little lower."""
    pads = SensorUncertainty.of_sensor(SensorEffects(area_averaging=AreaAveraging(0.002)))
    many = Readings(forces, np.full(400, AREA), np.arange(400), np.arange(400))
    effective = forces.sum() ** 2 / (forces @ forces)
    found = propagate_uncertainty(pads, many, np.zeros(400)).force / forces.sum()
    spectrum = factor * effective**power * math.exp(-1.8 * math.pi * 0.04)
    assert found == pytest.approx(math.hypot(spectrum, math.sqrt(7) * 0.09 / effective))


@pytest.mark.parametrize(("squared", "variance"), [(0.0, 1 / 12 / 3), (1.0, 1 / 7)], ids=["face", "line"])
def test_place_of_a_contact_with_edges_on_pads(squared, variance):
    pads = SensorUncertainty.of_sensor(SensorEffects(area_averaging=AreaAveraging(0.002)))
    nine = Readings(np.ones(9), np.full(9, AREA), np.arange(9), np.arange(9))
    found = propagate_uncertainty(pads, nine, np.full(9, squared * 10 * AREA)).place
    assert found**2 == pytest.approx(variance * AREA, rel=1e-6)


@pytest.mark.parametrize(
    ("readings", "standard", "limit"),
    [
        (ONE, 0.363, 1.0),
        (TWO, 2 * 0.00117 * 19**2, 2 * 0.16 * 19),
    ],
)
def test_pads_below_the_surface_read_contacts_between_them_through_their_tails(readings, standard, limit):
    """Pads of 1 mm on taxels of 1 cm² that are 2 mm below the surface: a / d² is 25."""
    pads = SensorUncertainty.of_sensor(SensorEffects(area_averaging=AreaAveraging(0.001)))
    deep = propagate_uncertainty(replace(pads, depth=0.002), readings, np.zeros(len(readings.forces)))
    assert deep.parts["area_averaging"] == pytest.approx(standard, rel=1e-3)
    assert deep.limits["area_averaging"] == pytest.approx(limit)
    count = len(readings.inside)
    assert deep.place**2 == pytest.approx(AREA * max(0.125 * count**-2, 0.22 * math.exp(-0.75 * count)))
    deeper = propagate_uncertainty(replace(pads, depth=0.001), ONE, np.zeros(3))
    assert deeper.parts["area_averaging"] == pytest.approx(0.75)
    assert deeper.limits["area_averaging"] == pytest.approx(0.066 * 85)


def test_errors_of_the_same_sign_add_up_in_part():
    assert combine_parts({"noise": 3.0, "hysteresis": 4.0}) == pytest.approx(5.0)
    found = combine_parts({"noise": 3.0, "hysteresis": 4.0, "contact_model": 2.0})
    assert found**2 == pytest.approx(9 + 16 + 4 + 2 * 0.8 * 8)
    assert combine_parts({"hysteresis": 4.0, "contact_model": math.inf}) == math.inf


@pytest.mark.parametrize(("model", "share"), [("water-fill", 0.25 * math.sqrt(3) / math.pi * 4), ("point", 1.4)])
def test_taxel_wider_than_the_contact_loses_less_to_saturation(model, share):
    area = math.pi / 2 * 0.016**2
    wide = Readings(np.array([1e4 * area]), np.array([area]), np.arange(1), np.arange(1))
    errors = SensorUncertainty.of_sensor(SensorEffects(saturation=Saturation(1e4)), model=model)
    assert propagate_uncertainty(errors, wide, np.zeros(1)).force == pytest.approx(1.16 * area * 1e4 * share)


def test_force_at_a_turning_point_keeps_the_uncertainty_of_its_recent_rate():
    errors = SensorUncertainty.of_sensor(SensorEffects(sampling=Sampling()))
    motion = Motion.begin(0.0, 1.0, np.zeros(3), errors.lag)
    for step in range(1, 30):
        motion = motion.next(0.02 * step, 1 + 0.1 * step, np.zeros(3))
    turned = motion.next(0.6, motion.force - motion.rate * 0.02 * 0.4 / 0.6, np.zeros(3))
    assert turned.rate == pytest.approx(0.0, abs=1e-9)
    found = propagate_uncertainty(errors, ONE, np.zeros(3), motion=turned)
    assert found.parts["sampling"] == pytest.approx(math.sqrt(0.6) * motion.rate * errors.lag)


def test_crosstalk_does_not_make_a_narrow_contact_count_as_wide():
    lump = Readings(np.array([0.8, *[0.2 / 6] * 6]), np.full(7, AREA), np.arange(7), np.array([0]))
    places = [
        propagate_uncertainty(SensorUncertainty.of_sensor(effects), lump, np.zeros(7)).place
        for effects in (SensorEffects(), SensorEffects(crosstalk=Crosstalk(0.2)))
    ]
    assert places[1] > 1.2 * places[0]


def test_measured_noise_counts_for_each_taxel():
    noise = TaxelNoise(np.array([100.0, 0.0, 300.0]), np.full(3, 1e9))
    found = propagate_uncertainty(SensorUncertainty.measured(noise), ONE, np.array([0.0, 0.0, 1e-4]))
    assert found.parts == pytest.approx({"noise": AREA * math.hypot(100, 300)})


def test_age_of_a_sample_counts_by_the_rate_of_force_and_position():
    errors = SensorUncertainty.of_sensor(SensorEffects(sampling=Sampling(50.0, 0.03)))
    assert errors.lag == pytest.approx(math.sqrt(0.03**2 + 0.03 * 0.02 + 0.02**2 / 3))
    motion = Motion.begin(0.0, 1.0, np.zeros(3), errors.lag)
    assert motion.rate == pytest.approx(1 / errors.lag), "it began within the age of a sample"
    for step in range(1, 40):
        motion = motion.next(0.02 * step, 1 + 0.1 * step, np.array([0.001 * step, 0, 0]))
    assert motion.rate == pytest.approx(5.0)
    found = propagate_uncertainty(errors, ONE, np.zeros(3), motion=motion)
    still = propagate_uncertainty(errors, ONE, np.zeros(3))
    assert found.parts["sampling"] == pytest.approx(5.0 * errors.lag)
    assert found.place == pytest.approx(math.hypot(still.place, 0.05 * errors.lag))


def test_noise_does_not_count_as_motion():
    random = np.random.default_rng(0)
    effects = SensorEffects(noise=Noise(1000.0), sampling=Sampling())
    errors = SensorUncertainty.of_sensor(effects)
    sd = 1000 * AREA * math.sqrt(3)
    motion = Motion.begin(0.0, 1.0, np.zeros(3), errors.lag)
    squares = []
    for step in range(1, 2000):
        motion = motion.next(0.02 * step, 1 + random.normal(0, sd), np.zeros(3))
        squares.append(propagate_uncertainty(errors, ONE, np.zeros(3), motion=motion).parts["sampling"] ** 2)
    assert math.sqrt(np.mean(squares)) < 0.8 * sd


@pytest.mark.parametrize(
    ("sampling", "averaged", "delay", "period"),
    [
        (None, 0.0, 0.0, 0.0),
        (None, 0.01, 0.005, 0.0),
        (Sampling(50.0, 0.0), 0.005, 0.01, 0.02),
        (Sampling(50.0, 0.0), 0.0, 0.0, 0.02),
    ],
)
def test_age_of_a_time_average_is_that_of_the_middle_of_its_interval(sampling, averaged, delay, period):
    errors = SensorUncertainty.of_sensor(SensorEffects(sampling=sampling), averaged=averaged)
    assert errors.lag == pytest.approx(math.sqrt(delay**2 + delay * period + period**2 / 3))
