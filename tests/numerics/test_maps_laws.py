"""Laws that hold for every surface in the catalogue, easy or hard."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from app.geometry.mesh import Mesh
from app.geometry.topology import boundary_loops
from app.maps.bijective import crossings, flipped, signed_areas
from app.maps.build import build_map
from app.maps.flatten import flatten
from app.maps.map_file import map_from_bytes, map_to_bytes
from app.maps.quality import measure
from app.maps.tactile_image import TactileImage
from tests.numerics.map_surfaces import SURFACES, named, skin_of

EVERY = sorted(SURFACES)
SMALL = [name for name in EVERY if name not in ("deep cup", "loose vertices", "one triangle")]


@cache
def _chart(name):
    return flatten(named(name))


@cache
def _map(name):
    return build_map(skin_of(named(name), taxels=30))


@pytest.mark.parametrize("name", EVERY)
def test_the_map_is_finite_one_to_one_and_better_than_the_first(name):
    chart, surface = _chart(name), named(name)
    assert np.isfinite(chart.plane).all()
    assert not flipped(chart.plane, chart.faces).any()
    assert crossings(chart.plane[boundary_loops(chart.faces)[0]]) == 0
    assert chart.energies[-1] <= chart.energies[0]
    assert 4 - 1e-9 <= chart.energies[-1] < 4.7
    np.testing.assert_array_equal(chart.vertex_of[chart.faces], surface.faces)
    assert signed_areas(chart.plane, chart.faces).sum() == pytest.approx(surface.area, rel=1e-9)


@pytest.mark.parametrize("name", EVERY)
def test_what_was_done_besides_is_told(name):
    told = {finding.kind for finding in _chart(name).findings}
    expected = {
        "deep cup": {"seam-added"}, "cup": {"seam-added"}, "nearly closed": {"seam-added"},
        "sphere": {"seam-added"},
        "sieve": {"overlap-avoided"}, "spiral": {"overlap-avoided"}, "thin faces": {"thin-face"},
    }  # fmt: skip
    assert told == expected.get(name, set())


@pytest.mark.parametrize("name", ["saddle", "bumpy tube", "sieve", "cap"])
@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_size_does_not_matter(name, scale):
    surface = named(name)
    chart = flatten(Mesh(scale * surface.vertices, surface.faces))
    assert chart.energies[-1] == pytest.approx(_chart(name).energies[-1], rel=1e-6)
    assert np.ptp(chart.plane, axis=0) / scale == pytest.approx(np.ptp(_chart(name).plane, axis=0), rel=1e-3)


@pytest.mark.parametrize("name", ["saddle", "bumpy tube", "sieve", "cap"])
def test_neither_does_place_nor_direction(name):
    surface = named(name)
    turn, _ = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    moved = flatten(Mesh(surface.vertices @ turn.T + [40.0, -30.0, 20.0], surface.faces))
    assert moved.energies[-1] == pytest.approx(_chart(name).energies[-1], rel=1e-6)


@pytest.mark.parametrize("name", ["saddle", "cap", "sieve"])
def test_a_jitter_of_rounding_size_changes_nothing_visible(name):
    surface = named(name)
    noise = np.random.default_rng(0).normal(size=surface.vertices.shape) * 1e-12 * surface.size
    jittered = flatten(Mesh(surface.vertices + noise, surface.faces))
    assert jittered.energies[-1] == pytest.approx(_chart(name).energies[-1], rel=1e-5)


@pytest.mark.parametrize("name", SMALL)
def test_round_trips_of_the_map_are_exact(name):
    map_, rng = _map(name), np.random.default_rng(0)
    faces = rng.integers(len(map_.charts[0].faces), size=500)
    faces = faces[map_.skin.patches[0].surface.face_areas[faces] > 0]
    weights = rng.dirichlet([1, 1, 1], len(faces))
    patch, face, back = map_.to_body_many(map_.to_map_many(np.zeros(len(faces), int), faces, weights))
    assert (patch == 0).all()
    surface = map_.skin.patches[0].surface
    away = np.linalg.norm(surface.points(face, back) - surface.points(faces, weights), axis=1)
    assert away.max() < 1e-9


@pytest.mark.parametrize("name", SMALL)
def test_every_taxel_lies_in_its_patch(name):
    map_ = _map(name)
    assert (map_.to_body_many(map_.taxel_points)[0] == map_.skin.patch_of).all()


@pytest.mark.parametrize("name", SMALL)
def test_even_pressure_makes_an_even_image(name):
    map_ = _map(name)
    image = TactileImage(map_, width=96)
    sums = np.asarray(image.weights.sum(axis=1)).reshape(image.shape)
    assert image.inside.any()
    np.testing.assert_allclose(sums[image.shown], 1, atol=1e-6)
    assert (sums[~image.shown] == 0).all()


@pytest.mark.parametrize("name", SMALL)
def test_every_map_can_be_judged(name):
    quality = measure(_map(name), sources=2)
    assert quality.bijective
    assert quality.flips == 0
    assert quality.angle.median >= 1
    assert 0 <= quality.stress < 1
    assert 0.9 < quality.trustworthiness <= 1


@pytest.mark.parametrize("name", [name for name in SMALL if name != "thin faces"])
def test_every_map_survives_its_file(name):
    data = map_to_bytes(_map(name))
    assert map_to_bytes(map_from_bytes(data)) == data
