"""The taxels' triangles: neighbours know each other, gaps stay open, and beyond the border its value holds on."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from app.maps.interpolation.triangles import TaxelTriangles, in_parts, merged, sparse_rows, stacked
from tests.numerics.taxel_fields import horseshoe, jittered


@pytest.fixture(scope="module", params=[jittered, horseshoe])
def triangles(request):
    return TaxelTriangles(request.param())


def test_corners_run_counter_clockwise(triangles):
    a, b, c = np.swapaxes(triangles.sites[triangles.faces], 0, 1)
    u, v = b - a, c - a
    assert (u[:, 0] * v[:, 1] > u[:, 1] * v[:, 0]).all()


def test_beyond_a_side_is_the_triangle_that_has_it_too(triangles):
    assert (triangles.beyond < 0).any()
    for face, side in np.argwhere(triangles.beyond >= 0):
        other = triangles.beyond[face, side]
        assert set(np.delete(triangles.faces[face], side)) < set(triangles.faces[other])
        assert face in triangles.beyond[other]


def test_a_gap_stays_open():
    triangles = TaxelTriangles(horseshoe())
    corners = triangles.sites[triangles.faces]
    assert np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max() < 0.026
    assert triangles.locate(np.array([[0.1, 0.045]]))[0] == -1


def test_located_points_are_their_corners_weighted(triangles):
    points = np.random.default_rng(0).uniform(0, 0.09, (500, 2))
    face, weights = triangles.locate(points)
    held = face >= 0
    assert held.sum() > 200
    back = np.einsum("kc,kcd->kd", weights[held], triangles.sites[triangles.faces[face[held]]])
    np.testing.assert_allclose(back, points[held], atol=1e-15)


def test_beside_is_the_nearest_place_of_the_border(triangles):
    """Against very many points along every border side."""
    points = triangles.sites.mean(axis=0) + 0.11 * np.array([[1, 0.2], [-1, 0.3], [0.1, 1], [0.3, -1], [-1, -1]])
    assert (triangles.locate(points)[0] < 0).all()
    found = triangles.beside(points) @ triangles.sites
    face, side = np.nonzero(triangles.beyond < 0)
    start, end = (triangles.sites[triangles.faces[face, (side + turn) % 3]] for turn in (1, 2))
    places = (start + np.linspace(0, 1, 2001)[:, None, None] * (end - start)).reshape(-1, 2)
    nearest = places[np.linalg.norm(places - points[:, None], axis=2).argmin(axis=1)]
    np.testing.assert_allclose(found, nearest, atol=1e-4)


@pytest.mark.parametrize("sites", [[[0, 0]], [[0, 0], [1, 1]], [[0, 0], [1, 0], [2, 0]], [[0, 0]] * 4])
def test_too_few_taxels_or_all_in_line_have_no_triangles_but_still_a_border(sites):
    triangles = TaxelTriangles(0.01 * np.array(sites, dtype=float))
    assert len(triangles.faces) == 0
    np.testing.assert_allclose(triangles.beside(np.array([[0.003, 0.004], [5, 5]])).sum(axis=1), 1)


def test_coincident_taxels_do_no_harm():
    sites = np.concatenate([jittered(), jittered()[:3]])
    weights = TaxelTriangles(sites).beside(np.array([[-0.01, -0.01]]))
    assert weights.sum() == pytest.approx(1)


def test_sparse_rows_adds_what_comes_twice():
    rows = sparse_rows(np.array([[2, 0], [1, 1]]), np.array([[0.3, 0.7], [0.4, 0.6]]), 3)
    np.testing.assert_allclose(rows.toarray(), [[0.7, 0, 0.3], [0, 1, 0]])


@pytest.mark.parametrize("count", [0, 5, 32768, 70_000])
def test_parts_hold_every_held_point_once(count):
    held = np.tile([True, False, True], count)
    found = in_parts(held)
    assert max(map(len, found)) <= 32768
    np.testing.assert_array_equal(np.concatenate(found), np.flatnonzero(held))


def test_blocks_are_stacked_and_merged_in_order():
    one, two = csr_matrix([[1.0, 0], [0, 2.0]]), csr_matrix([[3.0, 4.0]])
    np.testing.assert_array_equal(stacked([one, two]).toarray(), [[1, 0], [0, 2], [3, 4]])
    np.testing.assert_array_equal(merged(np.array([5, -1, 7]), one, two).toarray(), [[1, 0], [3, 4], [0, 2]])
