"""Curves of taxels are recovered from logs within their uncertainty, and applied to live readings."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import LiveError
from tactile_maps.live.calibration.calibration import load_calibration, save_calibration
from tactile_maps.live.calibration.calibration_log import CalibrationLog
from tactile_maps.live.calibration.force_calibration import fit_force
from tactile_maps.live.calibration.force_curves import CurveKind
from tactile_maps.live.prepare import as_measured
from tactile_maps.live.readings.arrival import Arrived
from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.scene.scene import Scene
from tactile_maps.session.prepare import PreparedScene
from tests.support.touch import bar, bar_map, bar_skin

SKIN = bar_skin(12)
AREAS = SKIN.areas
RAMP = np.concatenate([np.zeros(20), np.linspace(0.05, 2, 30), np.linspace(2, 0.05, 30)])
"""Force on one taxel, up and down [N]."""


def one_by_one(reading_of, taxels, *, noise=0.3, seed=0, force=RAMP):
    """Return a log in which each taxel is loaded alone; ``reading_of(taxel, pressure)`` without noise."""
    random = np.random.default_rng(seed)
    blocks = []
    for taxel in taxels:
        block = np.full((len(force), len(SKIN)), np.nan)
        block[:, taxel] = reading_of(taxel, force / AREAS[taxel]) + random.normal(0, noise, len(force))
        blocks.append(block)
    return CalibrationLog(np.tile(force, len(blocks)), np.concatenate(blocks))


EXPONENTS = np.where(np.arange(12) % 2, 1.6, 1.0)
GAINS = np.linspace(5, 15, 12)


def bent(taxel, pressure):
    """Reading of a taxel whose pressure is a power of the change, which is 100 at gain x 100 [Pa]."""
    return 500 + 100 * (pressure / GAINS[taxel] / 100) ** (1 / EXPONENTS[taxel])


def test_curves_of_taxels_are_recovered_within_their_uncertainty():
    found = fit_force(one_by_one(bent, range(12)), SKIN)
    assert [kind is CurveKind.LINEAR for kind in found.kinds] == (EXPONENTS == 1).tolist()
    middle = found.calibration.curve[:, 0, -1] / 2
    true = 100 * GAINS * (middle / 100) ** EXPONENTS
    away = np.abs(found.calibration.pressures(middle) / true - 1) / found.uncertainty
    assert found.uncertainty.max() < 0.03
    assert (away < 3.5).all()
    assert np.median(away) < 1.5
    assert np.allclose(found.calibration.offset, 500, atol=0.4)
    assert found.error < 0.3 * found.errors[CurveKind.LINEAR]
    assert 0.5 * found.error < np.sqrt(np.mean((found.calibration.deviation * AREAS) ** 2)) < 2 * found.error
    assert not len(found.pooled)


def test_forces_shared_by_several_taxels_determine_the_curve_of_each():
    random = np.random.default_rng(2)
    places = SKIN.patches[0].taxels.positions
    loads = np.where(np.arange(240) % 10, random.uniform(0.3, 3, 240), 0.0)
    readings = np.empty((240, 12))
    for row, load in enumerate(loads):
        weights = np.exp(-((places - places[random.integers(12)] - random.normal(0, 0.02, 3)) ** 2).sum(1) / 0.002)
        pressure = load * weights / (weights @ AREAS)
        readings[row] = 100 + np.where(weights > 0.02, 100 * pressure / GAINS / 100, 0) + random.normal(0, 0.3, 12)
    found = fit_force(CalibrationLog(loads, readings), SKIN)
    assert set(found.kinds) == {CurveKind.LINEAR}
    assert found.error < 0.1
    assert (np.abs(found.calibration.gain / GAINS - 1) < 4 * found.uncertainty + 0.02).all()


def test_sensor_with_a_knee_gets_a_piecewise_curve():
    def knee(_taxel, pressure):
        return np.where(pressure < 300, pressure / 2, 150 + (pressure - 300) / 20)

    found = fit_force(one_by_one(knee, [3]), SKIN)
    assert found.kinds[3] is CurveKind.PIECEWISE
    assert found.error < 0.3 * min(found.errors[CurveKind.LINEAR], found.errors[CurveKind.POWER])


def test_taxels_with_too_few_rows_get_the_common_curve():
    found = fit_force(one_by_one(lambda _taxel, pressure: -pressure / 8, range(11)), SKIN)
    assert found.pooled.tolist() == [11]
    assert found.rows[11] == 0
    assert np.isnan(found.uncertainty[11])
    assert np.allclose(found.calibration.gain, -8, rtol=0.02), "readings fall under pressure"


def test_hysteresis_is_measured_between_rising_and_falling_load():
    falling = np.arange(len(RAMP)) >= 50

    def lagging(_taxel, pressure):
        return pressure / 10 * np.where(falling, 1.1, 0.9)

    found = fit_force(one_by_one(lagging, [0, 1]), SKIN)
    assert np.allclose(found.hysteresis[:2], 0.18, atol=0.04)
    assert (found.branch_gain[:2] > 0.5).all()
    none = fit_force(one_by_one(lambda _taxel, pressure: pressure / 10, [0], force=RAMP[:50]), SKIN)
    assert np.isnan(none.hysteresis[0])


def test_pressure_log_calibrates_all_taxels_at_once():
    loads = np.repeat(np.linspace(0, 30e3, 16), 3)
    readings = 40 + loads[:, None] / np.linspace(50, 80, 12)
    found = fit_force(CalibrationLog(loads, readings, pressure=True), SKIN)
    assert np.allclose(found.calibration.gain, np.linspace(50, 80, 12))
    assert found.error < 1e-6


def test_insufficient_log_is_rejected():
    log = one_by_one(bent, [0])
    with pytest.raises(LiveError, match="folds is out of range"):
        fit_force(log, SKIN, folds=1)
    with pytest.raises(LiveError, match="another skin .found: 12 taxels for 60"):
        fit_force(log, bar_skin())
    with pytest.raises(LiveError, match="no reading at zero load .found: taxel 0.. Log a row at load 0 .*--changes"):
        fit_force(CalibrationLog(log.loads[20:], log.readings[20:]), SKIN)
    with pytest.raises(LiveError, match="no taxel has enough rows .found: at most 5"):
        fit_force(CalibrationLog(log.loads[:25], log.readings[:25]), SKIN)
    raised = CalibrationLog(log.loads[20:], log.readings[20:] - 500)
    assert fit_force(raised, SKIN, changes=True).kinds[1] is fit_force(log, SKIN).kinds[1]


def test_repeated_rows_of_a_load_are_held_out_together():
    """Each load has an error of its own, which its repeated rows share: they do not make the gain more certain."""
    force = np.concatenate([[0.0] * 20, np.repeat(np.linspace(0.2, 2, 12), 20)])
    off = 1 + 0.1 * np.repeat(np.random.default_rng(4).normal(size=13), 20)
    found = fit_force(one_by_one(lambda _taxel, pressure: pressure / 10 * off, [0], force=force, noise=0.01), SKIN)
    assert 0.01 < found.uncertainty[0] < 0.1


def test_fit_repeats_with_its_seed():
    log = one_by_one(bent, [1])
    first = fit_force(log, SKIN, seed=3)
    assert fit_force(log, SKIN, seed=3).uncertainty[1] == first.uncertainty[1]
    assert fit_force(log, SKIN, seed=4).uncertainty[1] != first.uncertainty[1]


def test_saved_calibration_shows_newtons_of_live_readings(tmp_path):
    path = tmp_path / "curves.csv"
    prepared = as_measured(PreparedScene(Scene(name="bar", robot="bar"), bar(), SKIN, bar_map(12)))
    assert np.array_equal(prepared.skin.areas, AREAS)
    save_calibration(fit_force(one_by_one(bent, range(12), noise=0.05), SKIN).calibration, path)
    session = MeasuredSession(prepared, calibration=load_calibration(path, SKIN))
    values = np.full(12, 500.0)
    values[5] = bent(5, 1.2 / AREAS[5])
    frame = session.show(Arrived(Reading(0.0, values, Unit.COUNTS), 0.0))
    assert abs(frame.pressures @ AREAS - 1.2) < 0.02
    assert session.facts.calibrated
