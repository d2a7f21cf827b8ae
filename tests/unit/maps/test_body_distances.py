"""What maps are compared with: exact where promised, the same for every map."""

from __future__ import annotations

import numpy as np
import pytest

from app.maps import body_distances
from app.maps.body_distances import BodyDistances
from app.maps.geodesics import Geodesics
from app.maps.insert import insert_points
from tests.numerics.map_surfaces import frustum, named, sheet, skin_of


def test_on_a_sheet_they_are_straight():
    skin = skin_of(sheet(24, 16), taxels=30)
    (patch,) = BodyDistances(skin).patches
    positions = skin.patches[0].taxels.positions
    expected = np.linalg.norm(positions[:, None] - positions[None], axis=2)
    np.testing.assert_allclose(patch.exact, expected, atol=2e-5)
    np.testing.assert_allclose(patch.near, expected, atol=2e-5)
    assert patch.sources.tolist() == patch.rows.tolist() == list(range(30))


@pytest.fixture
def no_budget(monkeypatch):
    """As on a large skin."""
    monkeypatch.setattr(body_distances, "_ALL_EXACT", 0)


@pytest.mark.usefixtures("no_budget")
def test_on_a_large_skin_near_ones_stay_exact_and_far_ones_come_close():
    skin = skin_of(named("hemisphere"), taxels=50)
    (patch,) = BodyDistances(skin, sources=7).patches
    assert (len(patch.sources), patch.exact.shape, patch.near.shape) == (7, (7, 50), (50, 50))
    exact = _exact(skin)
    close = exact <= 1.19 * np.median(np.sort(exact, axis=1)[:, 1])
    i, j = skin.neighbours.T
    close[i, j] = close[j, i] = True
    assert close.sum() > 5 * 50
    np.testing.assert_allclose(patch.near[close], exact[close], atol=1e-12)
    far = exact > 0
    assert np.abs(patch.near[far] / exact[far] - 1).mean() < 0.03


@pytest.mark.usefixtures("no_budget")
def test_every_patch_gets_its_share_of_sources_and_two_at_least():
    skin = skin_of(sheet(), named("saddle"), taxels=40)
    assert [len(patch.sources) for patch in BodyDistances(skin, sources=10).patches] == [5, 5]
    assert [len(patch.sources) for patch in BodyDistances(skin, sources=1).patches] == [2, 2]


@pytest.mark.usefixtures("no_budget")
def test_the_same_seed_asks_the_same_taxels():
    skin = skin_of(named("saddle"), taxels=40)
    one, same, other = (BodyDistances(skin, sources=4, seed=seed).patches[0] for seed in (3, 3, 4))
    np.testing.assert_array_equal(one.exact, same.exact)
    assert one.sources.tolist() != other.sources.tolist()


def test_too_many_taxels_are_asked_in_part(monkeypatch):
    monkeypatch.setattr(body_distances, "_ALL_EXACT", 0)
    monkeypatch.setattr(body_distances, "_MOST", 400)
    (patch,) = BodyDistances(skin_of(sheet(), taxels=40)).patches
    assert patch.near.shape == (10, 40)
    assert np.take_along_axis(patch.near, patch.rows[:, None], axis=1).max() == 0


def _exact(skin):
    taxels = skin.patches[0].taxels
    mesh, vertices = insert_points(skin.patches[0].surface, taxels.faces, taxels.weights)
    return np.array([Geodesics(mesh).from_vertex(int(v), vertices) for v in vertices])


@pytest.mark.usefixtures("no_budget")
@pytest.mark.parametrize("name", ["tube", "saddle"])
def test_neighbours_are_exactly_apart_however_far(name, monkeypatch):
    monkeypatch.setattr(body_distances, "_REACH", 0.5)
    tube = frustum(0.03, 0.03, length=0.06, around=30, along=12)
    skin = skin_of(tube if name == "tube" else named("saddle"), taxels=40)
    body = BodyDistances(skin)
    np.testing.assert_array_equal(body.pairs, skin.neighbours)
    np.testing.assert_allclose(body.lengths, _exact(skin)[tuple(body.pairs.T)], atol=1e-12)


def test_where_distances_are_not_exact_neighbours_are_an_arc_apart():
    skin = skin_of(named("thin faces"), taxels=40)
    body = BodyDistances(skin)
    i, j = body.pairs.T
    positions = skin.patches[0].taxels.positions
    straight = np.linalg.norm(positions[i] - positions[j], axis=1)
    assert (body.lengths >= straight * (1 - 1e-12)).all()
    assert (body.lengths < 1.05 * straight).all()
    assert body.lengths.sum() < body.patches[0].exact[i, j].sum()


def test_what_cannot_be_exact_is_said():
    (note,) = BodyDistances(skin_of(named("thin faces"))).findings
    assert note.kind == "inexact-distance"


def test_a_lone_taxel_has_no_neighbours():
    body = BodyDistances(skin_of(sheet(), taxels=1))
    assert body.pairs.shape == (0, 2)
    assert body.patches[0].exact.tolist() == [[0.0]]


def test_taxels_alone_are_measured_through_space():
    positions = np.random.default_rng(0).uniform(0, 0.03, (20, 3))
    body = BodyDistances.straight(positions, first=[0, 12, 20], pair=0.01)
    assert [patch.near.shape for patch in body.patches] == [(12, 12), (8, 8)]
    assert body.patches[1].exact[2, 5] == pytest.approx(np.linalg.norm(positions[14] - positions[17]))
    expected = {
        (i, j)
        for j in range(20)
        for i in range(j)
        if (i < 12) == (j < 12) and np.linalg.norm(positions[i] - positions[j]) < 0.01
    }
    assert {tuple(pair) for pair in body.pairs.tolist()} == expected
    assert len(expected) > 3
    np.testing.assert_allclose(body.lengths, np.linalg.norm(np.diff(positions[body.pairs], axis=1)[:, 0], axis=1))


def test_no_taxels_have_no_distances():
    body = BodyDistances.straight(np.zeros((0, 3)))
    assert body.pairs.shape == (0, 2)
