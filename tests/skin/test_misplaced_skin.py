"""Effect of misplaced taxels on the Jacobian of the map at 8 mm pitch, against the table of the theory page (5.2)."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.jacobian import MapJacobian, affine_fit
from tactile_maps.skin.calibration_error import with_calibration_error
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.skin.reconstruction.reconstruct import skin_from_taxels
from tests.support.pressed_arm import forearm, pressed_by_ball

pytestmark = pytest.mark.long

PITCH = 0.008
SIDE = 15
SEEDS = range(6)
UP = np.array([0.0, 0.0, 1.0])


@cache
def lattice():
    """15 x 15 taxels of a hexagonal lattice, flat, 8 mm apart; each a corner of the surface."""
    column, row = np.meshgrid(np.arange(SIDE), np.arange(SIDE))
    x = PITCH * (column + 0.5 * (row % 2))
    y = PITCH * np.sqrt(0.75) * row
    positions = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    return skin_from_taxels(TaxelSet("lattice", "plate", np.arange(x.size), positions, np.tile(UP, (x.size, 1))))


@cache
def map_jacobian():
    return MapJacobian(build_map(lattice()))


def inner():
    """Taxels with two whole rings."""
    return np.array([taxel for taxel in range(len(lattice())) if len(map_jacobian().two_rings(taxel)) == 19])


def triangles():
    """(m, 3) taxels that are neighbours of each other, counter-clockwise."""
    near = [set() for _ in range(len(lattice()))]
    for i, j in lattice().neighbours:
        near[i].add(int(j))
        near[j].add(int(i))
    found = np.array([(i, j, k) for i in range(len(near)) for j in near[i] for k in near[i] & near[j] if i < j < k])
    a, b, c = (lattice().patches[0].taxels.positions[found[:, k], :2] for k in range(3))
    turned = np.cross(np.column_stack([b - a, 0 * a[:, 0]]), np.column_stack([c - a, 0 * a[:, 0]]))[:, 2] < 0
    found[turned] = found[turned][:, ::-1]
    return found


def anisotropy(jacobians):
    singular = np.linalg.svd(jacobians, compute_uv=False)
    return singular[:, 0] / singular[:, 1]


def turned(jacobians):
    """(m,) by how much each turns [degrees]: the rotation of its polar decomposition."""
    u, _, vt = np.linalg.svd(jacobians)
    rotation = u @ vt
    return np.degrees(np.abs(np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0])))


def believed_over_true(sd, *, by="taxel"):
    """(m, 2, 2) of all triangles between taxels, and (k, 2, 2) of the fits over two rings, in the plane."""
    true = lattice().patches[0].taxels.positions
    raw = []
    smooth = []
    for seed in SEEDS:
        said = with_calibration_error(lattice(), sd, seed=seed, by=by).patches[0].taxels.positions
        sides, moved = (x[triangles()][:, 1:, :2] - x[triangles()][:, :1, :2] for x in (true, said))
        raw.append(np.swapaxes(np.linalg.solve(sides, moved), 1, 2))
        for taxel in inner():
            ring = map_jacobian().two_rings(taxel)
            smooth.append(affine_fit(true[ring] - true[taxel], said[ring, :2], UP)[:, :2])
    return np.concatenate(raw), np.array(smooth)


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("sd", "kappa", "inverted", "kappa_95", "turn_95"),
    [
        (0.5, 1.16, 0.0, 1.05, 1.1),
        (1, 1.36, 0.0, 1.10, 2.0),
        (2, 1.80, 0.9, 1.19, 4.3),
        (3, 2.4, 8.5, 1.32, 5.8),
        (7, 3.6, 36.0, 2.1, 13.0),
    ],
)
def test_single_triangle_jacobians_flip_while_two_ring_fits_do_not(sd, kappa, inverted, kappa_95, turn_95):
    """Median anisotropy and share turned over of triangles; 95 % of anisotropy and turn of the fits of 19 taxels."""
    raw, smooth = believed_over_true(1e-3 * sd)
    assert np.median(anisotropy(raw)) == pytest.approx(kappa, rel=0.12)
    assert 100 * (np.linalg.det(raw) < 0).mean() == pytest.approx(inverted, rel=0.3, abs=0.6)
    assert np.percentile(anisotropy(smooth), 95) == pytest.approx(kappa_95, rel=0.15)
    assert np.percentile(turned(smooth), 95) == pytest.approx(turn_95, rel=0.35)
    assert (np.linalg.det(smooth) > 0).all()


@pytest.mark.long
def test_module_errors_flip_fewer_triangles():
    """They are worst at the modules' borders, and nothing between them."""
    alone, together = (believed_over_true(0.003, by=by)[0] for by in ("taxel", "module"))
    assert (np.linalg.det(together) < 0).mean() < 0.5 * (np.linalg.det(alone) < 0).mean()
    assert np.median(anisotropy(together)) < np.median(anisotropy(alone))


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("by", "sd", "share"),
    [("taxel", 0.003, 0.7), ("taxel", 0.007, 0.7), ("module", 0.003, 0.9), ("module", 0.007, 0.9)],
)
def test_map_of_a_misplaced_skin_is_valid_and_its_smoothed_jacobian_more_accurate(by, sd, share):
    """Steps along the skin on the map are compared with the lattice in the plane; modules are smooth inside."""
    map_ = build_map(with_calibration_error(lattice(), sd, seed=1, by=by))
    a, b, c = (map_.uv[0][map_.charts[0].faces[:, k]] for k in range(3))
    assert (np.linalg.det(np.stack([b - a, c - a], axis=1)) > 0).all(), "nothing is turned over on the map"
    jacobian = MapJacobian(map_)
    errors = {"smoothed": [], "raw": []}
    body = lattice().patches[0].taxels.positions
    plane = map_.taxel_points
    for taxel in inner():
        ring = jacobian.two_rings(taxel)
        if len(ring) < 10:
            continue  # taken for parted by a seam
        true = affine_fit(body[ring] - body[taxel], plane[ring], UP)[:, :2]
        for kind, found in errors.items():
            said = jacobian.at(map_.skin.taxel_point(int(taxel)), kind=kind)[:, :2]
            found.append(np.linalg.norm(said - true, 2))
    assert len(errors["raw"]) > 50
    assert np.median(errors["smoothed"]) < share * np.median(errors["raw"])


def test_session_simulates_the_true_skin_and_controls_with_the_assumed_one():
    """Pressures are the true skin's, bit for bit; the contact is put where the calibration says its taxels are."""
    prepared = forearm()
    believed = build_map(with_calibration_error(prepared.skin, 0.004, seed=5))
    true, said = (pressed_by_ball(ControlSettings(controller="hybrid"), believed=map_) for map_ in (None, believed))
    frames = [session.frame for session in (true, said)]
    assert np.array_equal(frames[0].pressures, frames[1].pressures)
    (here,), (there,) = (frame.regions for frame in frames)
    assert there.force == pytest.approx(here.force, rel=1e-12), "areas are known from how it was made"
    apart = np.linalg.norm(there.link_position - here.link_position)
    share = frames[0].pressures * prepared.skin.areas / here.force
    shift = share @ (believed.skin.patches[0].taxels.positions - prepared.skin.patches[0].taxels.positions)
    assert apart == pytest.approx(np.linalg.norm(shift), abs=0.0015)
    assert apart > 0.0005
