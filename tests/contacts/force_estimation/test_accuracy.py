"""Force from taxels below a cover: what breaks, by how much, and what does not.

Taxels on a hexagonal lattice, 15 x 15, 7 mm apart, under a half-space; each feels a disc of 1.9 mm, a contact is
Hertz's ellipsoid of pressure. The figures of the design's theory (section 4.2) are laws here.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import scipy  # loads its parts when they are used: signal and stats take half a second
from scipy.optimize import nnls
from scipy.spatial import cKDTree

from tactile_maps.contacts.detection.detection import ContactDetector
from tactile_maps.contacts.force_estimation.deconvolution import BlurMatrix, tikhonov_inverse
from tactile_maps.contacts.force_estimation.estimate import ContactReading, numerical_rank
from tactile_maps.contacts.force_estimation.estimation import build_estimator
from tactile_maps.maps.build import build_map
from tactile_maps.studies.testbeds.covered_lattice import (
    APART,
    AREA,
    PITCH,
    TAXELS,
    area_blur,
    contact_region,
    exact_readings,
)
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.half_space_stress import point_stress
from tactile_maps.tactile.mechanics.loads import sphere_load
from tactile_maps.tactile.models.half_space import HalfSpaceModel
from tests.support.touch import arm, bar_skin


@cache
def points_matrix(depth: float) -> np.ndarray:
    return point_stress(APART, depth)


def noisy(radius: float, depth: float, share: float = 0.05):
    """(readings, noise) of contacts in places, with noise of a share of the peak."""
    random = np.random.default_rng(1)
    for own in exact_readings(radius, depth):
        noise = share * own.max()
        yield own + random.normal(0, noise, len(own)), noise


@pytest.mark.parametrize(
    ("depth", "condition"),
    [
        (0.125, 1.0),
        (0.25, 1.01),
        (0.5, 1.18),
        (0.75, 1.9),
        (1, 4.1),
        (1.5, 22),
        (2, 130),
        (3, 4.9e3),
        (4, 1.9e5),
    ],
)
def test_condition_number_grows_with_depth_as_predicted(depth, condition):
    values = np.linalg.svd(points_matrix(depth * PITCH), compute_uv=False)
    rank = numerical_rank(values, np.ones(len(TAXELS)), 0.0, unknowns=len(TAXELS))
    assert rank.condition == pytest.approx(condition, rel=0.2)
    assert rank.effective == len(TAXELS)


@pytest.mark.parametrize(("depth", "lost"), [(0.25, 0.85), (0.5, 0.47)])
def test_point_forces_above_shallow_taxels_are_well_conditioned_but_inaccurate(depth, lost):
    matrix = points_matrix(depth * PITCH)
    assert np.linalg.cond(matrix) < 1.3
    found = [np.linalg.solve(matrix, own).sum() for own in exact_readings(6e-3, depth * PITCH, points=True)]
    assert np.mean(found) == pytest.approx(1 - lost, abs=0.05)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize(("depth", "off"), [(0.25, 0.05), (0.5, 0.02)])
def test_patches_averaged_over_taxels_are_accurate(depth, off):
    matrix = area_blur(depth * PITCH)
    found = np.array([np.linalg.solve(matrix, own).sum() * AREA for own in exact_readings(6e-3, depth * PITCH)])
    assert np.abs(found - 1).mean() == pytest.approx(off, abs=0.02)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("depth", [0.5, 1.0])
def test_thresholding_loses_force_and_the_ring_recovers_it(depth):
    parts = [
        [1 - AREA * own[part].sum() for part in contact_region(own, 0.0)] for own in exact_readings(8e-3, depth * PITCH)
    ]
    core, whole = np.mean(parts, axis=0)
    assert 0.08 <= core <= 0.20
    assert abs(whole) <= 0.06


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("depth", [0.25, 0.5, 1.0])
def test_noise_becomes_force_in_least_squares_over_the_map_but_not_over_segments(depth):
    matrix = area_blur(depth * PITCH)
    everywhere = []
    segmented = []
    for own, noise in noisy(8e-3, depth * PITCH):
        everywhere.append(nnls(matrix, own)[0].sum() * AREA - 1)
        part = contact_region(own, noise)[1]
        segmented.append(nnls(matrix[np.ix_(part, part)], own[part])[0].sum() * AREA - 1)
    assert np.mean(everywhere) > 0.2
    assert 0 < np.mean(segmented) <= 0.12


@pytest.mark.long
def test_deep_skin_conserves_total_force_and_loses_its_distribution():
    """A depth of twice the pitch: least squares oscillate, Tikhonov and NNLS do not; every method keeps the sum."""
    matrix = area_blur(2 * PITCH)
    sizes = []
    totals = []
    for own, noise in noisy(8e-3, 2 * PITCH):
        plain = np.linalg.solve(matrix, own)
        tikhonov = tikhonov_inverse(BlurMatrix.of(matrix), own, noise) @ own
        sizes.append([AREA * np.abs(x).sum() for x in (plain, tikhonov, nnls(matrix, own)[0])])
        totals.append(AREA * tikhonov.sum() - 1)
        values = np.linalg.svd(matrix, compute_uv=False)
        assert numerical_rank(values, own, noise, unknowns=len(own)).refusal, "no distribution is reported"
    plain, tikhonov, nonnegative = np.mean(sizes, axis=0)
    assert plain > 20
    assert tikhonov == pytest.approx(2.3, rel=0.2)
    assert nonnegative == pytest.approx(1.2, rel=0.1)
    assert abs(np.mean(totals)) < 0.09


CELL = 5e-4
"""Side of the cells on which the exact stress below a flat skin is integrated [m]."""


def random_ball(random: np.random.Generator) -> tuple[float, float]:
    """Force [N] and radius [m]."""
    return float(np.exp(random.uniform(*np.log((1.0, 20.0))))), float(np.exp(random.uniform(*np.log((3e-3, 30e-3)))))


def flat_touches(skin, depth: float, count: int):
    """(force, readings) of balls on the flat bar, by Boussinesq's stress on a grid, none of it the product's code."""
    x = 0.01 + (np.arange(760) + 0.5) * CELL
    y = -0.05 + (np.arange(200) + 0.5) * CELL
    across, along = np.meshgrid(x, y)
    (patch,) = skin.patches
    owner = cKDTree(patch.taxels.positions[:, :2]).query(np.stack([across.ravel(), along.ravel()], axis=1))[1]
    cells = np.bincount(owner, minlength=len(skin))
    reach = CELL * np.arange(-120, 121)
    kernel = 1.5 / np.pi * depth**3 / (np.add.outer(reach**2, reach**2) + depth**2) ** 2.5
    random = np.random.default_rng(0)
    for _ in range(count):
        force, radius = random_ball(random)
        x = random.uniform(0.06, 0.34)
        y = random.uniform(-0.03, 0.03)
        contact = (4 * force * radius / (np.pi * ElasticLayer().foundation)) ** 0.25
        forces = np.maximum(0, 1 - ((across - x) ** 2 + (along - y) ** 2) / contact**2)
        stress = scipy.signal.fftconvolve(force * forces / forces.sum(), kernel, mode="same")
        yield force, np.bincount(owner, stress.ravel(), len(skin)) / cells


def arm_touches(skin, depth: float, count: int):
    """(force, readings) of balls on the arm, by the half-space model, whose total is exact."""
    model = HalfSpaceModel(skin, layer=ElasticLayer(depth=depth))
    random = np.random.default_rng(0)
    for _ in range(count):
        (force, radius), at = random_ball(random), skin.taxel_point(int(random.integers(len(skin))))
        load = sphere_load(skin.link(at), skin.position(at), skin.normal(at), force, radius, depth=force / 2e4)
        yield force, model.pressures([load])


LONG = pytest.mark.long


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("name", "taxels", "depth", "count"),
    [
        ("flat", 1000, 4e-3, 40),
        ("arm", 300, 2e-3, 40),
        *(pytest.param("flat", n, d, 300, marks=LONG) for n in (400, 1000) for d in (1e-3, 2e-3, 4e-3)),
        *(pytest.param("flat", 4000, d, 40, marks=LONG) for d in (1e-3, 2e-3, 4e-3)),
        *(pytest.param("arm", 300, d, 300, marks=LONG) for d in (1e-3, 2e-3, 4e-3)),
    ],
)
def test_totals_below_a_cover_have_no_bias(name, taxels, depth, count):
    """No noise, any ratio of depth to pitch. Pressure times area loses the force beyond the ring of taxels."""
    if name == "arm":
        skin = arm().skin
        map_ = arm().map
        touches = arm_touches
    else:
        skin = bar_skin(taxels, finer=round(np.sqrt(taxels / 400)))
        touches = flat_touches
        map_ = build_map(skin)
    estimators = {one: build_estimator(one, skin, depth=depth) for one in ("area-sum", "local-nnls", "tikhonov")}
    off = {one: [] for one in estimators}
    for force, readings in touches(skin, depth, count):
        regions = ContactDetector(map_).read(readings)
        for one, estimator in estimators.items() if regions else ():
            found = estimator.estimate(ContactReading(regions[0], readings))
            assert found.refused is None
            off[one].append(found.force / force - 1)
    assert len(off["local-nnls"]) >= 0.95 * count
    assert abs(np.median(off["local-nnls"])) < 0.01
    assert abs(np.median(off["tikhonov"])) < 0.01
    assert -0.03 < np.median(off["area-sum"]) < 0.001
    assert np.percentile(np.abs(off["local-nnls"]), 95) < 0.04
