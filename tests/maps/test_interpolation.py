"""Interpolation between taxels: their triangles, the four methods, and all of them over a whole map."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator, RBFInterpolator
from scipy.sparse import csr_matrix

from tactile_maps.core.errors import MapError
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.interpolation import (
    INTERPOLATIONS,
    STENCIL,
    TaxelTriangles,
    barycentric,
    in_chunks,
    interpolation_weights,
    merge_rows,
    natural_neighbour,
    nearest,
    sparse_rows,
    stack_rows,
    thin_plate,
)
from tests.support.references import held, horseshoe, jittered
from tests.support.surfaces import named, sheet, skin_of


@pytest.fixture(scope="module", params=[jittered, horseshoe])
def triangles(request):
    return TaxelTriangles(request.param())


def test_triangle_corners_are_counter_clockwise(triangles):
    a, b, c = np.swapaxes(triangles.sites[triangles.faces], 0, 1)
    u = b - a
    v = c - a
    assert (u[:, 0] * v[:, 1] > u[:, 1] * v[:, 0]).all()


def test_neighbour_across_a_side_shares_the_side(triangles):
    assert (triangles.beyond < 0).any()
    for face, side in np.argwhere(triangles.beyond >= 0):
        other = triangles.beyond[face, side]
        assert set(np.delete(triangles.faces[face], side)) < set(triangles.faces[other])
        assert face in triangles.beyond[other]


def test_gap_has_no_triangles():
    triangles = TaxelTriangles(horseshoe())
    corners = triangles.sites[triangles.faces]
    assert np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max() < 0.026
    assert triangles.locate(np.array([[0.1, 0.045]]))[0] == -1


def test_located_points_equal_their_weighted_corners(triangles):
    points = np.random.default_rng(0).uniform(0, 0.09, (500, 2))
    face, weights = triangles.locate(points)
    held = face >= 0
    assert held.sum() > 200
    back = np.einsum("kc,kcd->kd", weights[held], triangles.sites[triangles.faces[face[held]]])
    np.testing.assert_allclose(back, points[held], atol=1e-15)


def test_weights_beyond_the_border_equal_those_of_the_closest_border_point(triangles):
    """Against very many points along every border side."""
    points = triangles.sites.mean(axis=0) + 0.11 * np.array([[1, 0.2], [-1, 0.3], [0.1, 1], [0.3, -1], [-1, -1]])
    assert (triangles.locate(points)[0] < 0).all()
    found = triangles.beyond_border(points) @ triangles.sites
    face, side = np.nonzero(triangles.beyond < 0)
    start, end = (triangles.sites[triangles.faces[face, (side + turn) % 3]] for turn in (1, 2))
    places = (start + np.linspace(0, 1, 2001)[:, None, None] * (end - start)).reshape(-1, 2)
    nearest = places[np.linalg.norm(places - points[:, None], axis=2).argmin(axis=1)]
    np.testing.assert_allclose(found, nearest, atol=1e-4)


@pytest.mark.parametrize("sites", [[[0, 0]], [[0, 0], [1, 1]], [[0, 0], [1, 0], [2, 0]], [[0, 0]] * 4])
def test_too_few_or_collinear_taxels_have_no_triangles_but_a_border(sites):
    triangles = TaxelTriangles(0.01 * np.array(sites, dtype=float))
    assert len(triangles.faces) == 0
    np.testing.assert_allclose(triangles.beyond_border(np.array([[0.003, 0.004], [5, 5]])).sum(axis=1), 1)


def test_coincident_taxels_keep_weights_valid():
    sites = np.concatenate([jittered(), jittered()[:3]])
    weights = TaxelTriangles(sites).beyond_border(np.array([[-0.01, -0.01]]))
    assert weights.sum() == pytest.approx(1)


def test_sparse_rows_adds_repeated_entries():
    rows = sparse_rows(np.array([[2, 0], [1, 1]]), np.array([[0.3, 0.7], [0.4, 0.6]]), 3)
    np.testing.assert_allclose(rows.toarray(), [[0.7, 0, 0.3], [0, 1, 0]])


@pytest.mark.parametrize("count", [0, 5, 32768, 70_000])
def test_parts_contain_every_point_once(count):
    held = np.tile([True, False, True], count)
    found = in_chunks(held)
    assert max(map(len, found)) <= 32768
    np.testing.assert_array_equal(np.concatenate(found), np.flatnonzero(held))


def test_blocks_are_stacked_and_merged_in_order():
    one = csr_matrix([[1.0, 0], [0, 2.0]])
    two = csr_matrix([[3.0, 4.0]])
    np.testing.assert_array_equal(stack_rows([one, two]).toarray(), [[1, 0], [0, 2], [3, 4]])
    np.testing.assert_array_equal(merge_rows(np.array([5, -1, 7]), one, two).toarray(), [[1, 0], [3, 4], [0, 2]])


def test_interpolation_agrees_with_scipy_between_the_taxels():
    triangles = TaxelTriangles(jittered())
    points = held(triangles)
    values = np.random.default_rng(2).random(len(triangles.sites))
    expected = LinearNDInterpolator(triangles.sites, values)(points)
    np.testing.assert_allclose(barycentric(triangles, points) @ values, expected, atol=1e-12)


def test_nearest_interpolation_uses_the_nearest_taxel():
    triangles = TaxelTriangles(jittered())
    points = np.random.default_rng(2).uniform(-0.02, 0.11, (800, 2))
    expected = np.linalg.norm(points[:, None] - triangles.sites, axis=2).argmin(axis=1)
    np.testing.assert_array_equal(nearest(triangles, points).indices, expected)


def _cell_area(sites, number):
    """Area of the Voronoi cell of one site within a large square: the square cut along each bisector."""
    cell = 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    site = sites[number]
    for other in np.delete(sites, number, axis=0):
        side = (cell - 0.5 * (site + other)) @ (other - site)
        kept = []
        for k in range(len(cell)):
            if side[k] <= 0:
                kept.append(cell[k])
            if (side[k] <= 0) != (side[k - 1] <= 0):
                share = side[k - 1] / (side[k - 1] - side[k])
                # Between the corner before and this one; put before this one where it is kept.
                kept.insert(len(kept) - (side[k] <= 0), cell[k - 1] + share * (cell[k] - cell[k - 1]))
        cell = np.array(kept)
    x, y = (cell - site).T
    return 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()


@pytest.mark.long
def test_each_weight_is_the_share_of_the_overlapped_area():
    sites = jittered(7)
    middle = sites.mean(axis=0)
    points = middle + np.random.default_rng(3).uniform(-0.008, 0.008, (12, 2))
    before = np.array([_cell_area(sites, k) for k in range(len(sites))])
    for point, weights in zip(points, natural_neighbour(TaxelTriangles(sites), points).toarray(), strict=True):
        both = np.concatenate([sites, [point]])
        taken = before - [_cell_area(both, k) for k in range(len(sites))]
        assert taken.sum() == pytest.approx(_cell_area(both, len(sites)), rel=1e-6)
        np.testing.assert_allclose(weights, taken / taken.sum(), atol=1e-6)


def test_regular_grid_with_four_taxels_on_each_circle_is_interpolated():
    x, y = np.meshgrid(np.arange(6.0), np.arange(6.0))
    sites = 0.01 * np.stack([x, y], axis=-1).reshape(-1, 2)
    middles = 0.01 * np.array([[2.5, 2.5], [2.5, 2.0], [2.0, 2.0]])
    weights = natural_neighbour(TaxelTriangles(sites), middles).toarray()
    square = np.isin(np.arange(36), [14, 15, 20, 21])
    np.testing.assert_allclose(weights[0], 0.25 * square, atol=1e-12)
    assert weights[1, 14] == pytest.approx(weights[1, 15])
    np.testing.assert_allclose(weights[2], np.arange(36) == 14, atol=1e-12)


def _creases(triangles, line, values):
    """Largest change of slope along a line of points, between one step and the next."""
    shown = natural_neighbour(triangles, line) @ values
    return np.abs(np.diff(shown, 2)).max() / np.linalg.norm(line[1] - line[0])


def test_interpolated_field_is_smooth():
    """The change of slope over a step falls with the step; at a crease it would stay."""
    triangles = TaxelTriangles(jittered())
    values = np.random.default_rng(2).random(len(triangles.sites))
    ends = triangles.sites.mean(axis=0) + [[-0.02, -0.011], [0.02, 0.013]]
    coarse, fine = (_creases(triangles, np.linspace(*ends, count), values) for count in (400, 6400))
    assert coarse > 0
    assert fine < 0.15 * coarse


@pytest.mark.parametrize("sites", [jittered(), horseshoe()], ids=["square", "horseshoe"])
def test_weights_near_a_border_or_gap_are_positive_and_exact(sites):
    triangles = TaxelTriangles(sites)
    face, side = np.nonzero(triangles.beyond < 0)
    start, end = (triangles.sites[triangles.faces[face, (side + turn) % 3]] for turn in (1, 2))
    inward = np.stack([start[:, 1] - end[:, 1], end[:, 0] - start[:, 0]], axis=1)
    for depth in (1e-12, 1e-8, 2e-7, 1e-6, 1e-3, 0.05):
        points = 0.7 * start + 0.3 * end + depth * inward
        points = points[triangles.locate(points)[0] >= 0]
        assert len(points) > 20
        weights = natural_neighbour(triangles, points)
        assert weights.data.min() > -1e-7
        np.testing.assert_allclose(weights @ triangles.sites, points, atol=1e-9)


def test_walk_ends_at_a_taxel_whose_weight_dominates():
    triangles = TaxelTriangles(jittered())
    site = 40
    for away in (0, 1e-16, 1e-12, 1e-9, 1e-8, 1e-6):
        around = triangles.sites[site] + away * np.array([[1, 0], [0, 1], [-1, 1], [-0.3, -1]])
        weights = natural_neighbour(triangles, around)
        assert weights[:, [site]].toarray().min() > 1 - 1e3 * away - 1e-9


def test_natural_neighbour_properties_hold_at_any_size():
    for size in (1e-6, 1e6):
        triangles = TaxelTriangles(size * jittered())
        points = held(triangles)
        weights = natural_neighbour(triangles, points)
        np.testing.assert_allclose(weights @ triangles.sites, points, atol=1e-13 * size)


def _needles(kind, generator):
    """(40, 2) taxels nearly in rows, nearly in pairs, nearly on one circle, or in a very thin strip."""
    places = generator.random((40, 2))
    if kind == "rows":
        return np.round(6 * places) / 6 + 1e-9 * generator.normal(size=(40, 2))
    if kind == "pairs":
        return np.concatenate([places[:20], places[:20] + 1e-8 * generator.normal(size=(20, 2))])
    if kind == "circle":
        turn = 2 * np.pi * places[:, 0]
        return np.stack([np.cos(turn), np.sin(turn)], axis=1) * np.minimum(np.arange(40), 1)[:, None]
    return places * [1, 1e-6]


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("kind", ["rows", "pairs", "circle", "strip"])
def test_walk_ends_among_thin_triangles_with_valid_weights(kind, monkeypatch):
    monkeypatch.setattr("tactile_maps.maps.model.interpolation.LONGEST_SIDE", 1e9)
    generator = np.random.default_rng(0)
    asked = 0
    for _ in range(25):
        sites = _needles(kind, generator)
        triangles = TaxelTriangles(sites)
        size = np.ptp(sites, axis=0)
        around = 10.0 ** generator.uniform(-12, -1, (300, 1)) * generator.normal(size=(300, 2))
        points = sites[generator.integers(0, 40, 300)] + size * around
        points = points[triangles.locate(points)[0] >= 0]
        asked += len(points)
        weights = natural_neighbour(triangles, points)
        np.testing.assert_allclose(np.asarray(weights.sum(axis=1)).ravel(), 1, rtol=1e-12)
        assert weights.data.min(initial=0.0) > -2e-6
        np.testing.assert_allclose((weights @ sites - points) / size, 0, atol=1e-5)
    assert (asked > 1000) == (kind != "strip")


def test_interpolation_with_few_taxels_equals_scipy_thin_plate_spline():
    sites = jittered(3, jitter=0.15)
    triangles = TaxelTriangles(sites)
    values = np.random.default_rng(2).random(9)
    points = held(triangles)
    assert len(sites) <= STENCIL
    assert (np.diff(thin_plate(triangles, points).indptr) == 9).all(), "each plate holds all"
    expected = RBFInterpolator(sites, values, kernel="thin_plate_spline", degree=1)(points)
    np.testing.assert_allclose(thin_plate(triangles, points) @ values, expected, atol=1e-10)


def test_interpolation_with_many_taxels_is_close_to_the_spline():
    triangles = TaxelTriangles(jittered(12))
    values = np.sin(60 * triangles.sites[:, 0]) * np.cos(50 * triangles.sites[:, 1])
    points = held(triangles)
    whole = RBFInterpolator(triangles.sites, values, kernel="thin_plate_spline", degree=1)(points)
    apart = np.abs(thin_plate(triangles, points) @ values - whole)
    linear = np.abs(barycentric(triangles, points) @ values - whole)
    assert np.sqrt((apart**2).mean()) < 0.25 * np.sqrt((linear**2).mean())


def test_thin_plate_interpolation_does_not_cross_a_gap():
    triangles = TaxelTriangles(horseshoe())
    points = held(triangles)
    lower = points[(points[:, 0] > 0.09) & (points[:, 1] < 0.03)]
    assert len(lower) > 50
    asked = triangles.sites[np.unique(thin_plate(triangles, lower).indices)]
    assert asked[:, 1].max() < 0.045


def test_nearly_collinear_or_coincident_taxels_fall_back_to_linear():
    line = np.stack([0.01 * np.arange(12), 5e-6 * (np.arange(12) % 2)], axis=1)
    twins = np.concatenate([jittered(5), jittered(5)[12:13] + 1e-9])
    for sites in (line, twins):
        triangles = TaxelTriangles(sites)
        assert len(triangles.faces) > 5
        points = triangles.sites[triangles.faces].mean(axis=1)
        weights = thin_plate(triangles, points)
        np.testing.assert_allclose(np.asarray(weights.sum(axis=1)).ravel(), 1, rtol=1e-9)
        assert np.abs(weights.data).max() < 2


def test_thin_plate_properties_hold_at_any_size():
    for size in (1e-6, 1e6):
        triangles = TaxelTriangles(size * jittered())
        points = held(triangles)
        np.testing.assert_allclose(thin_plate(triangles, points) @ triangles.sites, points, atol=1e-12 * size)


def test_regular_grid_is_interpolated():
    x, y = np.meshgrid(np.arange(6.0), np.arange(6.0))
    triangles = TaxelTriangles(0.01 * np.stack([x, y], axis=-1).reshape(-1, 2))
    points = held(triangles)
    np.testing.assert_allclose(thin_plate(triangles, points) @ triangles.sites, points, atol=1e-12)
    np.testing.assert_allclose(thin_plate(triangles, triangles.sites).toarray(), np.eye(36), atol=1e-12)


EVERY = pytest.mark.parametrize("method", INTERPOLATIONS)
CONTINUOUS = pytest.mark.parametrize("method", [name for name in INTERPOLATIONS if name != "nearest"])


@pytest.fixture(scope="module")
def field(three_patches):
    """Places spread over all patches: patch and map point."""
    points = np.random.default_rng(0).uniform(*three_patches.bounds, (6000, 2))
    return three_patches.to_body_many(points)[0], points


def test_four_interpolation_methods_are_offered():
    assert list(INTERPOLATIONS) == ["barycentric", "nearest", "natural-neighbour", "thin-plate"]


def test_unknown_method_is_rejected_by_name(three_patches, field):
    with pytest.raises(MapError, match=r"cubic.*natural-neighbour"):
        interpolation_weights(three_patches, *field, interpolation="cubic")


@EVERY
def test_rows_sum_to_one_on_the_skin_and_are_empty_elsewhere(three_patches, field, method):
    weights = interpolation_weights(three_patches, *field, interpolation=method)
    sums = np.asarray(weights.sum(axis=1)).ravel()
    on = field[0] >= 0
    assert 1000 < on.sum() < 5500
    np.testing.assert_allclose(sums[on], 1, rtol=1e-12)
    assert (np.diff(weights.indptr)[~on] == 0).all()


@pytest.mark.parametrize(
    ("method", "most"), [("barycentric", 3), ("nearest", 1), ("natural-neighbour", 12), ("thin-plate", 48)]
)
def test_only_few_taxels_near_the_point_are_used(three_patches, field, method, most):
    weights = interpolation_weights(three_patches, *field, interpolation=method)
    assert np.diff(weights.indptr).max() <= most
    asked = weights.tocoo()
    away = np.linalg.norm(field[1][asked.row] - three_patches.taxel_points[asked.col], axis=1)
    assert away.max() < 0.7 * np.ptp(three_patches.uv[0], axis=0).max()


@pytest.mark.parametrize("method", ["barycentric", "nearest", "natural-neighbour"])
def test_values_are_not_extrapolated(three_patches, field, method):
    assert interpolation_weights(three_patches, *field, interpolation=method).data.min() > -1e-12


@EVERY
def test_patches_are_interpolated_independently(three_patches, field, method):
    weights = interpolation_weights(three_patches, *field, interpolation=method).tocoo()
    np.testing.assert_array_equal(three_patches.skin.patch_of[weights.col], field[0][weights.row])


@CONTINUOUS
def test_linear_field_is_reproduced_between_taxels(three_patches, field, method):
    patch, points = field
    inner = np.diff(interpolation_weights(three_patches, patch, points).indptr) == 3
    assert inner.sum() > 500
    weights = interpolation_weights(three_patches, patch, points, interpolation=method)
    shown = weights @ (three_patches.taxel_points @ [3.0, -2.0] + 1)
    np.testing.assert_allclose(shown[inner], points[inner] @ [3.0, -2.0] + 1, atol=1e-12)


@pytest.mark.long
@pytest.mark.sampled(2)
@EVERY
def test_gap_is_not_bridged(method):
    """Across the mouth of a horseshoe the taxels of the far arm are the only ones there, and still not asked."""
    map_ = build_map(skin_of(named("spiral"), taxels=60))
    points = map_.uv[0]
    weights = interpolation_weights(map_, np.zeros(len(points), dtype=int), points, interpolation=method).tocoo()
    away = np.linalg.norm(points[weights.row] - map_.taxel_points[weights.col], axis=1)
    pitch = np.sqrt(map_.skin.patches[0].surface.area / 60)
    assert np.ptp(points, axis=0).min() > 8 * pitch
    assert away.max() < (6 if method == "thin-plate" else 2.5) * pitch


@EVERY
def test_value_at_a_taxel_is_its_reading(three_patches, method):
    skin = three_patches.skin
    weights = interpolation_weights(three_patches, skin.patch_of, three_patches.taxel_points, interpolation=method)
    np.testing.assert_allclose(weights.toarray(), np.eye(len(skin)), atol=1e-9)


@CONTINUOUS
def test_field_is_continuous_at_the_border_of_triangles(three_patches, method):
    step = 1e-7
    patch = np.zeros(4000, dtype=int)
    low = three_patches.uv[0].min(axis=0)
    high = three_patches.uv[0].max(axis=0)
    line = np.linspace(low, high, 4000)
    values = np.random.default_rng(0).random(len(three_patches.skin))
    here, there = (
        interpolation_weights(three_patches, patch, line + move, interpolation=method) @ values
        for move in ([0, 0], [step, -step])
    )
    assert np.ptp(here) > 0.1
    # A jump would be of the order of the values' differences, whatever the step.
    assert np.quantile(np.abs(here - there), 0.99) < 1e-3


@pytest.mark.sampled(6)
@EVERY
@pytest.mark.parametrize("taxels", [1, 2, 3])
def test_patch_with_few_taxels_is_interpolated(taxels, method):
    map_ = build_map(skin_of(sheet(), taxels=taxels))
    points = map_.uv[0]
    weights = interpolation_weights(map_, np.zeros(len(points), dtype=int), points, interpolation=method)
    np.testing.assert_allclose(np.asarray(weights.sum(axis=1)).ravel(), 1, rtol=1e-12)


@EVERY
def test_collinear_taxels_are_interpolated_along_their_line(method):
    map_ = build_map(skin_of(sheet(30, 1, width=0.3, height=0.01), taxels=8))
    weights = interpolation_weights(map_, np.zeros(1, dtype=int), map_.taxel_points[[3]], interpolation=method)
    assert weights[0, 3] == pytest.approx(1)


@EVERY
def test_interpolation_without_points_is_empty(three_patches, method):
    weights = interpolation_weights(three_patches, np.zeros(0, dtype=int), np.zeros((0, 2)), interpolation=method)
    assert weights.shape == (0, 120)


@pytest.mark.long
@pytest.mark.sampled(2)
@EVERY
def test_weights_do_not_depend_on_the_number_of_points(method):
    """They are worked off in parts."""
    triangles = TaxelTriangles(jittered())
    points = np.random.default_rng(0).uniform(-0.01, 0.1, (90_000, 2))
    assert (triangles.locate(points)[0] >= 0).sum() > 2**15
    every = INTERPOLATIONS[method](triangles, points)
    for few in (slice(0, 200), slice(50_000, 50_200), slice(-200, None)):
        alone = INTERPOLATIONS[method](triangles, points[few])
        assert abs(every[few] - alone).max() < 1e-12
