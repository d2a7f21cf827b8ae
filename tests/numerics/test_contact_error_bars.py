"""The error bars of contact regions against chance: many noisy, miscalibrated, oddly placed readings of one contact."""

from __future__ import annotations

import numpy as np
import pytest

from app.contacts.accuracy import ReadingErrors, uncertainty
from app.contacts.reader import ContactReader
from app.touch.load import ball_load
from app.touch.models.water_fill import WaterFill
from tests.touch import prepared_bar

BAR = prepared_bar()
SKIN = BAR.skin
TRIES = 600
UP = np.array([0.0, 0.0, 1.0])


def wide() -> np.ndarray:
    """Six or so taxels pressed well above the threshold."""
    return WaterFill(SKIN).pressures([ball_load("bar", np.array([0.2, 0.0, 0.02]), UP, 200.0, 0.08)])


def scatter(changed, errors: ReadingErrors) -> tuple[float, float, float, float]:
    """Scatter of centre (radial) and force over readings changed by chance; what error bars say, without spacing."""
    random, exact = np.random.default_rng(0), wide()
    found = []
    for _ in range(TRIES):
        own = changed(random, exact)
        region, trusted = (ContactReader(BAR.map, errors=e).read(own)[0] for e in (errors, ReadingErrors()))
        place = np.sqrt(region.place_error**2 - trusted.place_error**2)
        found.append([*region.point, region.force, place, region.force_error])
    points, force, place_error, force_error = np.split(np.array(found), [3, 4, 5], axis=1)
    return float(np.sqrt(points.var(axis=0).sum())), float(force.std()), place_error.mean(), force_error.mean()


@pytest.mark.parametrize("noise", [100.0, 800.0])
def test_noise_scatters_place_and_force_as_the_error_bars_say(noise):
    centre, force, said, force_said = scatter(
        lambda random, exact: exact + random.normal(0, noise, len(exact)), ReadingErrors(noise=noise)
    )
    assert force == pytest.approx(force_said, rel=0.1)
    assert centre == pytest.approx(said, rel=0.1)


def test_unequal_gains_scatter_place_and_force_as_the_error_bars_say():
    centre, force, said, force_said = scatter(
        lambda random, exact: exact * random.normal(1, 0.1, len(exact)), ReadingErrors(gain=0.1)
    )
    assert force == pytest.approx(force_said, rel=0.1)
    assert centre == pytest.approx(said, rel=0.1)


def test_misplaced_taxels_scatter_the_centre_as_the_error_bars_say():
    """The centre of pressure of taxels that sit elsewhere than they are said to, independently."""
    random, sd = np.random.default_rng(0), 0.002
    (region,) = ContactReader(BAR.map, errors=ReadingErrors(calibration=sd)).read(wide())
    forces = wide()[region.taxels] * SKIN.areas[region.taxels]
    shifts = random.normal(0, sd, (20 * TRIES, len(forces), 2))
    centres = np.einsum("k,nkc->nc", forces / forces.sum(), shifts)
    (trusted,) = ContactReader(BAR.map).read(wide())
    said = np.sqrt(region.place_error**2 - trusted.place_error**2)
    assert np.sqrt(centres.var(axis=0).sum()) == pytest.approx(said, rel=0.03)


@pytest.mark.parametrize(("radius", "force", "at_most"), [(0.001, 1.0, 1.3), (0.004, 2.0, 1.3), (0.08, 200.0, 8.0)])
def test_a_contact_lies_as_near_as_its_error_bar_says(radius, force, at_most):
    """Smaller than a taxel's area the bar is true; wider ones are known better, never worse."""
    random, felt = np.random.default_rng(0), WaterFill(SKIN)
    missed, said = [], []
    for _ in range(150):
        point = np.array([random.uniform(0.06, 0.34), random.uniform(-0.02, 0.02), 0.02])
        for region in ContactReader(BAR.map).read(felt.pressures([ball_load("bar", point, UP, force, radius)])):
            missed.append(np.linalg.norm(region.point - point))
            said.append(region.place_error)
    assert len(missed) > 130
    ratio = np.sqrt(np.mean(np.square(said)) / np.mean(np.square(missed)))
    assert 0.9 <= ratio <= at_most


def test_both_are_what_the_formula_says_for_two_equal_taxels():
    """By hand: 1 N on each of two taxels of 1 cm², 2 cm apart."""
    errors = ReadingErrors(noise=100.0, gain=0.1, calibration=0.003)
    place, force = uncertainty(errors, np.ones(2), np.full(2, 1e-4), np.full(2, 1e-4))
    assert force == pytest.approx(np.sqrt(100**2 * 2e-8 + 0.01 * 2))
    lines = (100 / 2) ** 2 * 2 * 1e-8 * 1e-4, 0.01 * 0.5 * 1e-4, 2 * 0.003**2 * 0.5, 0.5 * 1e-4 / 6
    assert place == pytest.approx(np.sqrt(sum(lines)))
