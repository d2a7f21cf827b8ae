"""A known weight calibrates by the mean of what is read under it, on some taxels or all, and can be taken back."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import LiveError
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.live.calibration.calibration import GRAVITY, Calibration, ValueMode
from tactile_maps.live.calibration.weighing import RecentReadings, Weighing
from tactile_maps.live.prepare import as_measured
from tactile_maps.live.readings.arrival import Arrived
from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.tactile.press import press_skin
from tests.support.touch import bar_skin, prepared_bar

SKIN = bar_skin()
COUNTS = 0.01 * press_skin(SKIN, SKIN.taxel_point(30), force=2.0)
UNDER = np.flatnonzero(COUNTS > 0.5)
MASS = 2.0 / GRAVITY


def tared(**options):
    session = MeasuredSession(as_measured(prepared_bar()), **options)
    session.tare(1)
    session.show(at(0.0, np.zeros(60)))
    return session


def at(time, above):
    return Arrived(Reading(time, 20 + above, Unit.COUNTS), time)


def test_mean_of_readings_is_used_instead_of_a_single_one():
    session = tared()
    random = np.random.default_rng(1)
    session.weights.begin(MASS, 1.0)
    for number in range(1, 102):
        assert (session.facts.weighing.left is None) == (number > 100)
        session.show(at(0.01 * number, COUNTS * (1 + 0.3 * random.normal())))
    state = session.facts.weighing
    assert state.undoable
    assert state.problem is None
    np.testing.assert_allclose(session.readings.calibration.gain, 100.0, rtol=0.1)
    frame = session.show(at(2.0, COUNTS))
    assert frame.units is ReadingUnits.CALIBRATED
    assert abs(frame.regions[0].force - 2.0) < 0.2


def test_weighing_of_chosen_taxels_sums_and_changes_only_them():
    known = Calibration(np.full(60, 50.0), np.full(60, 20.0))
    session = tared(calibration=known)
    drifted = COUNTS + np.where(np.isin(np.arange(60), UNDER), 0.0, 40.0)
    session.weights.begin(MASS, 0.5, taxels=UNDER)
    session.show(at(1.0, drifted))
    gain = session.readings.calibration.gain
    share = COUNTS[UNDER] @ SKIN.areas[UNDER] / (COUNTS @ SKIN.areas)
    np.testing.assert_allclose(gain[UNDER], 100.0 / share, rtol=0.02)
    assert (np.delete(gain, UNDER) == 50.0).all()
    assert np.isclose(session.facts.weighing.factor, gain[UNDER[0]] / 50.0)
    session.weights.undo()
    assert (session.readings.calibration.gain == 50.0).all()
    assert not session.facts.weighing.undoable


def test_invalid_weighing_is_reported_without_changes():
    session = MeasuredSession(as_measured(prepared_bar()))
    with pytest.raises(LiveError, match="not tared"):
        session.weights.begin(MASS, 1.0)
    session = tared()
    session.weights.begin(MASS, 0.1)
    frame = session.show(at(1.0, -COUNTS))
    assert "readings fall under the weight" in session.facts.weighing.problem
    assert frame.units is ReadingUnits.COUNTS
    session.weights.begin(MASS, 10.0)
    session.weights.undo()
    assert session.facts.weighing.left is None


def test_negative_gain_is_applied_if_readings_decrease_under_the_weight():
    session = tared()
    session.weights.begin(MASS, 0.1)
    session.show(at(1.0, -COUNTS))
    assert session.facts.weighing.falling
    session.weights.apply_negative_gain()
    np.testing.assert_allclose(session.readings.calibration.gain, -100.0, rtol=0.02)
    frame = session.show(at(2.0, -COUNTS))
    assert abs(frame.regions[0].force - 2.0) < 0.2
    session.weights.undo()
    assert (session.readings.calibration.gain == Calibration.plain(60, Unit.COUNTS).gain).all()


def test_contact_of_an_inverted_sensor_is_found_in_counts_before_a_weight():
    for inverted in (False, True):
        session = tared(inverted=inverted)
        assert bool(session.show(at(1.0, -COUNTS)).regions) == inverted
    session.weights.weigh(MASS)
    np.testing.assert_allclose(session.readings.calibration.gain, -100.0, rtol=0.02)


@pytest.mark.parametrize(("mass", "seconds", "taxels"), [(0, 1, None), (1, 0, None), (1, 61, None), (1, 1, [])])
def test_weight_time_and_contact_are_required(mass, seconds, taxels):
    with pytest.raises(LiveError) as refused:
        Weighing(mass, seconds, taxels, 0.0)
    assert refused.value.remedy


def test_last_seconds_are_averaged_and_must_be_steady():
    recent = RecentReadings(0.5)
    noise = np.random.default_rng(0).normal(0, 1, (200, 4))
    with pytest.raises(LiveError, match="no reading"):
        recent.mean(np.ones(4))
    for number, extra in enumerate(noise):
        recent.add((0.0 if number < 100 else 50.0) + extra, 0.01 * number)
        if number == 120:
            with pytest.raises(LiveError, match="is not at rest"):
                recent.mean(np.ones(4))
    assert recent.mean(np.ones(4)) == pytest.approx(50 + noise[-51:].mean(axis=0), abs=1e-9)


class NoisySkin:
    """A tared skin with offsets of 8,000 counts and a noise of 0.6 counts, sampled at 100 Hz."""

    def __init__(self):
        self.session = MeasuredSession(as_measured(prepared_bar()), tare_first=True)
        self._random = np.random.default_rng(3)
        self._time = 0.0
        self.session.tare(50)
        self.show(np.zeros(60), 50)

    def show(self, above, count=1):
        """Return the frames of ``count`` readings with these counts above the untouched skin."""
        frames = []
        for _ in range(count):
            self._time += 0.01
            values = 8000.0 + above + self._random.normal(0.0, 0.6, 60)
            frames.append(self.session.show(Arrived(Reading(self._time, values, Unit.COUNTS), self._time)))
        return frames

    def weigh(self, above, mass):
        """Calibrate with a weight [kg] under which the skin reads ``above``."""
        self.session.weights.begin(mass, 0.5)
        self.show(above, 52)
        assert self.session.facts.weighing.problem is None


def forces(frames):
    """Return the force of the only contact in each frame, which must keep its id."""
    assert {tuple(region.id for region in frame.regions) for frame in frames} == {(1,)}
    return [frame.regions[0].force for frame in frames]


@pytest.mark.parametrize("factor", [1, 10, 100])
def test_contact_continues_in_newtons_after_a_weight_and_in_counts_after_undo(factor):
    """A threshold kept in counts would hide it in newtons; one kept in newtons would hide it in some frames later."""
    skin = NoisySkin()
    pressed = 3 * COUNTS
    before = np.mean(forces(skin.show(pressed, 50)))
    skin.weigh(pressed, 3 * factor * MASS)
    assert np.mean(forces(skin.show(pressed, 50))) == pytest.approx(6.0 * factor, rel=0.02)
    skin.session.weights.undo()
    assert np.mean(forces(skin.show(pressed, 50))) == pytest.approx(before, rel=0.02)


def test_contact_continues_while_the_displayed_values_change():
    skin = NoisySkin()
    skin.weigh(3 * COUNTS, 3 * MASS)
    for mode in (ValueMode.BASELINE, ValueMode.PRESSURE):
        skin.session.readings.request_mode(mode)
        forces(skin.show(3 * COUNTS, 20))
    skin.session.readings.request_mode(ValueMode.RAW)
    skin.show(3 * COUNTS, 20)
    skin.session.readings.request_mode(ValueMode.PRESSURE)
    assert skin.show(3 * COUNTS)[0].regions[0].force == pytest.approx(6.0, rel=0.05)


def test_residual_pressure_of_creep_is_no_contact_in_another_unit():
    skin = NoisySkin()
    skin.weigh(50 * COUNTS, 50 * MASS)
    skin.show(np.zeros(60), 20)
    skin.show(50 * COUNTS, 10)
    left = 2.5 * COUNTS
    assert all(frame.regions == () for frame in skin.show(left, 20))
    for mode in (ValueMode.BASELINE, ValueMode.PRESSURE):
        skin.session.readings.request_mode(mode)
        assert all(frame.regions == () for frame in skin.show(left, 20))


def test_largest_force_of_a_contact_is_not_that_in_counts():
    skin = NoisySkin()
    skin.show(3 * COUNTS, 10)
    skin.weigh(3 * COUNTS, 3 * MASS)
    skin.show(3 * COUNTS, 10)
    frame = skin.show(np.zeros(60), 10)[-1]
    released = next(event for event in frame.recent if event.kind == "release")
    assert released.force == pytest.approx(6.0, rel=0.1)


@pytest.mark.parametrize("taxels", [None, UNDER])
@pytest.mark.parametrize("mode", list(ValueMode)[:2])
def test_empty_skin_is_not_taken_for_the_weight(mode, taxels):
    """Its mean is as often below as above zero."""
    skin = NoisySkin()
    skin.session.readings.request_mode(mode)
    for _ in range(20):
        skin.session.weights.begin(MASS, 0.5, taxels=taxels)
        skin.show(np.zeros(60), 52)
        state = skin.session.facts.weighing
        assert "nothing seems to rest on the skin" in state.problem
        assert "of the 6 standard deviations" in state.problem
        assert "Put the weight on the skin" in state.problem
        assert not state.falling
        assert not state.undoable
    with pytest.raises(LiveError, match="nothing seems to rest"):
        skin.session.weights.weigh(MASS)
    assert not skin.session.readings.calibration.known


def test_light_weight_is_measured_on_the_taxels_under_it():
    """It reads 8 counts on two taxels, whose noise is 0.6; the noise of all 60 is 4.6."""
    skin = NoisySkin()
    light = np.where(np.isin(np.arange(60), UNDER[:2]), 8.0, 0.0)
    skin.session.weights.begin(MASS, 0.5)
    skin.show(light, 52)
    assert "select the taxels under a light weight" in skin.session.facts.weighing.problem
    skin.session.weights.begin(MASS, 0.5, taxels=UNDER[:2])
    skin.show(light, 52)
    gain = skin.session.readings.calibration.gain
    assert gain[0] == pytest.approx(2.0 / (8.0 * SKIN.areas[UNDER[:2]].sum()), rel=0.05)


@pytest.mark.parametrize("mode", [ValueMode.RAW, ValueMode.BASELINE])
def test_weight_shows_pressures_and_undo_the_values_before(mode):
    skin = NoisySkin()
    skin.session.readings.request_mode(mode)
    skin.show(3 * COUNTS, 10)
    skin.weigh(3 * COUNTS, 3 * MASS)
    facts = skin.session.facts
    assert (facts.mode, facts.calibrated, facts.known) == (ValueMode.PRESSURE, True, True)
    assert skin.show(3 * COUNTS)[0].regions[0].force == pytest.approx(6.0, rel=0.05)
    skin.session.readings.request_mode(ValueMode.BASELINE)
    facts = skin.session.facts
    assert (facts.mode, facts.calibrated, facts.known) == (ValueMode.BASELINE, False, True)
    skin.session.weights.undo()
    facts = skin.session.facts
    assert (facts.mode, facts.calibrated, facts.known) == (mode, False, False)
