"""Shear of a bed of springs and sliders, against the closed forms of Cattaneo and Mindlin for such a bed.

A ball of radius R at the depth d presses a bed with normal stiffness K: a² = 2 R d, p0 = K d, P = pi a² p0 / 2.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq

from tactile_maps.tactile.mechanics.coulomb_bed import Shear, shear_bed
from tests.support.examples import examples

RADIUS = 0.01
DEPTH = 5e-4
NORMAL = 3e7
TANGENTIAL = 1e7
FRICTION = 0.5
EDGE = np.sqrt(2 * RADIUS * DEPTH)


class Bed:
    """A square bed of ``count`` times ``count`` points under a ball, or under a flat punch, all pressed."""

    def __init__(self, count: int = 60, *, flat: bool = False) -> None:
        middle = EDGE * (2 * (np.arange(count) + 0.5) / count - 1)
        x, y = np.meshgrid(middle, middle)
        depth = np.where(x**2 + y**2 < EDGE**2, DEPTH, 0.0) if flat else DEPTH - (x**2 + y**2) / (2 * RADIUS)
        under = depth > 0
        area = (2 * EDGE / count) ** 2
        self.places = x[under] + 1j * y[under]
        self.limits = FRICTION * NORMAL * area * depth[under]
        self.stiffness = np.full(len(self.places), TANGENTIAL * area)
        self.most = float(self.limits.sum())
        self.forces = np.zeros(len(self.places), dtype=np.complex128)

    def load(self, share: complex, torque: float = 0.0) -> Shear:
        """Bring the total to a share of the friction limit, and remember the springs."""
        found = shear_bed(self.forces, self.limits, self.stiffness, self.places, share * self.most, torque)
        self.forces = found.forces
        return found

    def moved(self) -> float:
        """The way of the body along x since the springs were free [m], from the springs that never slid."""
        middle = np.abs(self.places).argmin()
        return float(self.forces[middle].real / self.stiffness[middle])

    def torque(self) -> float:
        return float(np.vdot(self.places, self.forces).imag)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 0.99])
def test_stick_circle_follows_the_closed_form(share):
    """c / a = (1 - Q / (mu P))^(1/4); the half-space of Cattaneo has the exponent 1/3."""
    bed = Bed(20)
    found = bed.load(share)
    stuck = np.abs(bed.forces) < bed.limits * (1 - 1e-9)
    circle = np.sqrt(stuck.mean())
    assert found.matched
    assert circle == pytest.approx((1 - share) ** 0.25, abs=0.02)


@pytest.mark.parametrize("share", [0.2, 0.6, 0.95])
def test_displacement_follows_the_closed_form(share):
    """Q / (mu P) = 1 - (1 - k s / (mu p0))²."""
    bed = Bed(100)
    bed.load(share)
    expected = FRICTION * NORMAL * DEPTH / TANGENTIAL * (1 - np.sqrt(1 - share))
    assert bed.moved() == pytest.approx(expected, rel=1e-3)


def test_unloading_follows_masings_rule():
    """Masing's rule: from a peak, the way back by s is twice the way that half the change needs from rest."""
    bed = Bed(100)
    bed.load(0.8)
    peak = bed.moved()
    for share in (0.4, 0.0, -0.6):
        bed.load(share)
        fresh = Bed(100)
        fresh.load((0.8 - share) / 2)
        assert peak - bed.moved() == pytest.approx(2 * fresh.moved(), rel=1e-9)


def test_loading_in_steps_equals_loading_at_once():
    steps, once = Bed(), Bed()
    for share in np.linspace(0.02, 0.7, 18):
        steps.load(share)
    once.load(0.7)
    np.testing.assert_allclose(steps.forces, once.forces, atol=1e-12 * once.most)


@pytest.mark.parametrize("share", [1 - 1e-9, 1.0, 1 + 1e-9])
def test_all_points_slide_along_the_force_at_the_limit(share):
    bed = Bed()
    bed.load(0.3j)
    found = bed.load(share)
    assert found.matched
    assert found.stuck == 0.0
    np.testing.assert_allclose(bed.forces, share * bed.limits, rtol=1e-12)


def test_force_beyond_the_limit_is_reported_and_not_exceeded():
    bed = Bed()
    found = bed.load(1.2)
    assert not found.matched
    assert bed.forces.sum() == pytest.approx(bed.most)
    assert (np.abs(bed.forces) <= bed.limits * (1 + 1e-12)).all()


@pytest.mark.parametrize("share", [0.3, 0.8, 0.97])
def test_torsion_of_a_flat_punch_follows_the_closed_form(share):
    """tau(r) = min(k phi r, mu p): the outside slides first; the angle follows from the integral."""
    bed = Bed(200, flat=True)
    limit = FRICTION * NORMAL * DEPTH
    most = 2 * np.pi * limit * EDGE**3 / 3

    def moment(angle: float) -> float:
        return 2 * np.pi * quad(lambda r: min(TANGENTIAL * angle * r, limit) * r**2, 0, EDGE, points=[EDGE / 2])[0]

    angle = brentq(lambda angle: moment(angle) - share * most, 0.0, 1e3)
    found = bed.load(0.0, share * most)
    assert found.matched
    assert bed.torque() == pytest.approx(share * most, rel=1e-12)
    sides = np.abs(bed.forces) / bed.stiffness * TANGENTIAL
    expected = np.minimum(TANGENTIAL * angle * np.abs(bed.places), limit)
    np.testing.assert_allclose(sides, expected, atol=0.01 * limit)


@given(st.integers(0, 10**6))
@examples(200)
def test_totals_hold_and_no_point_exceeds_its_limit_in_any_bed(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 200))
    normal = rng.random(count) ** rng.integers(1, 6) * 10.0 ** rng.uniform(-4, 2)
    places = 0.01 * (rng.normal(size=count) + 1j * rng.normal(size=count))
    places -= normal @ places / normal.sum()
    limits = FRICTION * normal
    most = limits.sum()
    size = np.sqrt(limits @ np.abs(places) ** 2 / most)
    before = limits * rng.random(count) * np.exp(1j * rng.uniform(0, 7, count))
    share = rng.random()
    force = share * most * np.exp(1j * rng.uniform(0, 7))
    torque = 0.3 * (1 - share) * most * size * rng.uniform(-1, 1)
    stiffness = 10.0 ** rng.uniform(-1, 1, count) * most / count / 1e-4
    found = shear_bed(before, limits, stiffness, places, complex(force), torque)
    assert (np.abs(found.forces) <= limits * (1 + 1e-12)).all()
    if found.matched:
        assert abs(found.forces.sum() - force) <= 2e-12 * most
        assert abs(np.vdot(places, found.forces).imag - torque) <= 2e-12 * most * size
    assert found.matched or share > 0.5, "the limit for force and torque together is below both"


@given(st.integers(0, 10**6), st.sampled_from([1.0, 3.0, 30.0]), st.sampled_from([2, 4, 60]))
@examples(100)
def test_force_below_the_limit_is_exact_after_limits_have_fallen(seed, fallen, most_points):
    """Springs beyond the limits of their points: a bed that slides as a whole has no stiffness along its forces."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, most_points + 1))
    limits = rng.random(count) ** rng.integers(1, 6)
    places = 0.01 * (rng.normal(size=count) + 1j * rng.normal(size=count))
    places -= limits @ places / limits.sum()
    before = fallen * limits * rng.random(count) * np.exp(1j * (rng.uniform(0, 7) + 0.3 * rng.normal(size=count)))
    force = 0.99 * rng.random() * limits.sum() * np.exp(1j * rng.uniform(0, 7))
    stiffness = 10.0 ** rng.uniform(-1, 1, count) * 1e4
    found = shear_bed(before, limits, stiffness, places, complex(force), 0.0)
    assert found.matched
    assert abs(found.forces.sum() - force) <= 2e-12 * limits.sum()
    assert (np.abs(found.forces) <= limits * (1 + 1e-12)).all()


@pytest.mark.parametrize("share", [0.0, 0.5, 0.99])
def test_torque_beyond_the_limit_is_reported_and_leaves_the_force_exact(share):
    """And the torque is nearly the largest one: that of a bed that turns without a force."""
    bed = Bed(100, flat=True)
    most = bed.limits @ np.abs(bed.places)
    found = bed.load(share, 1.5 * most)
    assert not found.matched
    assert abs(bed.forces.sum() - share * bed.most) <= 2e-12 * bed.most
    assert (np.abs(bed.forces) <= bed.limits * (1 + 1e-12)).all()
    if not share:
        assert bed.torque() == pytest.approx(most, rel=0.005)
    assert bed.torque() <= most * (1 + 1e-12)


def test_bed_without_friction_carries_no_shear():
    found = shear_bed(np.ones(3, dtype=complex), np.zeros(3), np.ones(3), np.arange(3) * 1e-3 + 0j, 0j)
    assert found.matched
    assert not found.forces.any()


def test_points_at_one_place_carry_no_torque():
    found = shear_bed(np.zeros(2, dtype=complex), np.ones(2), np.ones(2), np.zeros(2, dtype=complex), 0.5j, 0.0)
    np.testing.assert_allclose(found.forces, 0.25j)
