"""The tactile image: its pixels, the force it keeps, and what it keeps of the map."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from tactile_maps.core.errors import MapError
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.interpolation import INTERPOLATIONS
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_image import (
    TactileImage,
    body_area_of_pixels,
    force_areas,
    force_error,
    round_trip_mm,
    surface_positions,
    vertex_weights,
)
from tactile_maps.maps.model.tactile_map import TactileMap
from tests.support.surfaces import sheet, skin_of


@pytest.mark.long
def test_pixel_areas_add_up_to_face_areas(three_patches):
    """Many small pixels in one face add up to that face's area on the body."""
    image = TactileImage(three_patches, resolution=2.5e-4)
    patch, face, _ = three_patches.to_body_many(image.centres())
    areas = body_area_of_pixels(three_patches, patch, face, image.resolution)
    assert (areas[face < 0] == 0).all()
    for number, worn in enumerate(three_patches.skin.patches):
        here = patch == number
        total = np.bincount(face[here], areas[here], minlength=len(worn.surface.faces))
        largest = worn.surface.face_areas.argsort()[-20:]
        np.testing.assert_allclose(total[largest], worn.surface.face_areas[largest], rtol=0.1)
        assert total.sum() == pytest.approx(worn.surface.area, rel=5e-3)


def test_force_of_every_taxel_is_conserved():
    generator = np.random.default_rng(0)
    weights = csr_matrix(generator.dirichlet(np.ones(5), 60))
    areas = generator.uniform(0.5, 1.5, 60)
    requested = 60 * generator.dirichlet(np.full(5, 20))
    np.testing.assert_allclose(weights.T @ force_areas(weights, areas, requested), requested, rtol=1e-12)


def test_pixel_areas_change_least_while_keeping_the_sum():
    """Against the weighted least-norm solution by a dense pseudo-inverse."""
    generator = np.random.default_rng(1)
    weights = csr_matrix(generator.dirichlet(np.ones(5), 60))
    areas = generator.uniform(0.5, 1.5, 60)
    requested = 60 * generator.dirichlet(np.full(5, 20))
    root = np.sqrt(areas)
    missing = requested - weights.T @ areas
    expected = areas + root * (np.linalg.pinv(weights.T.toarray() * root) @ missing)
    np.testing.assert_allclose(force_areas(weights, areas, requested), expected, rtol=1e-9)


def test_correct_pixel_areas_are_unchanged():
    weights = csr_matrix(np.kron(np.eye(4), np.ones((3, 1))))
    areas = np.random.default_rng(0).uniform(0.5, 1.5, 12)
    np.testing.assert_allclose(force_areas(weights, areas, weights.T @ areas), areas, rtol=1e-12)


def test_taxel_without_a_pixel_does_not_affect_others():
    weights = csr_matrix(np.kron(np.eye(4), np.ones((3, 1))))
    weights = csr_matrix((weights.data, weights.indices, weights.indptr), shape=(12, 5))
    areas = force_areas(weights, np.ones(12), np.array([3.0, 6, 3, 3, 7]))
    np.testing.assert_allclose(weights.T @ areas, [3, 6, 3, 3, 0])


def test_image_without_skin_has_no_force():
    assert (force_areas(csr_matrix((4, 2)), np.zeros(4), np.ones(2)) == 0).all()


@pytest.fixture(scope="module")
def image(three_patches):
    return TactileImage(three_patches, width=200)


def test_image_has_the_requested_width_and_contains_the_map(three_patches, image):
    low, high = three_patches.bounds
    assert max(image.shape) == 200
    assert (image.extent[0] <= low + 1e-12).all()
    assert (image.extent[1] >= high - 1e-12).all()
    np.testing.assert_allclose(np.ptp(image.extent, axis=0), image.resolution * np.array(image.shape[::-1]))


def test_resolution_can_be_requested(three_patches):
    assert TactileImage(three_patches, resolution=0.002).resolution == 0.002


@pytest.mark.parametrize("resolution", [0.0, -1.0, np.nan, np.inf, 1e-7])
def test_implausible_resolution_raises_a_clear_error(three_patches, resolution):
    with pytest.raises(MapError, match="resolution"):
        TactileImage(three_patches, resolution=resolution)


def test_narrow_map_does_not_create_a_huge_image():
    narrow = build_map(skin_of(sheet(40, 1, width=1.0, height=0.001), taxels=20))
    assert min(np.ptp(narrow.bounds, axis=0)) < 0.01
    assert max(TactileImage(narrow, width=100).shape) == 100


def test_row_zero_is_at_the_top(three_patches, image):
    highest = int(three_patches.taxel_points[:, 1].argmax())
    pressures = np.zeros(len(three_patches.skin))
    pressures[highest] = 1000.0
    rows = np.nonzero(image.render(pressures))[0]
    assert rows.mean() < 0.25 * image.shape[0]


def test_pressure_appears_at_its_taxel_in_kilopascals(three_patches, image):
    for taxel in range(0, len(three_patches.skin), 11):
        pressures = np.zeros(len(three_patches.skin))
        pressures[taxel] = 5000.0
        shown = image.render(pressures)
        row, column = image.pixel(three_patches.taxel_points[taxel])
        assert shown.dtype == np.float32
        assert shown[row, column] > 2.5
        assert shown.max() <= 5.0 + 1e-4


def test_uniform_pressure_is_uniform_inside_and_zero_outside(three_patches, image):
    shown = image.render(np.full(len(three_patches.skin), 2000.0))
    np.testing.assert_allclose(shown[image.inside], 2.0, rtol=1e-5)
    assert (shown[~image.shown] == 0).all()
    assert (~image.shown).any()


def test_rim_of_the_image_is_one_pixel_wide(image):
    assert (image.shown | ~image.inside).all(), "what is inside is shown"
    rim = image.shown & ~image.inside
    padded = np.pad(image.inside, 1)
    near = np.zeros_like(image.inside)
    for row in range(3):
        for column in range(3):
            near |= padded[row : row + image.shape[0], column : column + image.shape[1]]
    assert rim.any()
    np.testing.assert_array_equal(image.shown, near)


def test_pixel_maps_to_the_body_and_back_to_itself(three_patches, image):
    for row, column in np.argwhere(image.inside)[::97]:
        at = image.back_project(int(row), int(column))
        assert image.pixel(three_patches.to_map(at)) == (row, column)


def test_pixel_off_the_skin_or_image_has_no_place(image):
    row, column = np.argwhere(~image.inside)[0]
    assert image.back_project(int(row), int(column)) is None
    for outside in ((-1, 0), (0, -1), (image.shape[0], 0), (0, image.shape[1])):
        assert image.back_project(*outside) is None


def test_pixel_centres_are_correct(image):
    centres = image.centres()
    for number in range(0, len(centres), 1501):
        assert image.pixel(centres[number]) == divmod(number, image.shape[1])


@pytest.mark.sampled(2)
@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_force_of_any_touch_is_conserved(three_patches, interpolation):
    """The force is kept to rounding: in double precision, and in the displayed image to that of its pixels."""
    image = TactileImage(three_patches, width=160, interpolation=interpolation)
    areas = image.pixel_areas.ravel()
    kept = image.weights.astype(np.float64).T @ areas
    np.testing.assert_allclose(kept, three_patches.skin.areas, rtol=1e-12)
    pressures = np.random.default_rng(0).uniform(0, 5e4, len(three_patches.skin))
    force = float(pressures @ image.taxel_areas)
    exact = (image.weights.astype(np.float64) @ (1e-3 * pressures)).reshape(image.shape)
    assert image.force(exact) == pytest.approx(force, rel=1e-12)
    assert image.force(image.render(pressures)) == pytest.approx(force, rel=1e-6)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_pixel_areas_are_close_to_those_on_the_body(three_patches, interpolation):
    image = TactileImage(three_patches, width=160, interpolation=interpolation)
    true = np.array([patch.surface.area for patch in three_patches.skin.patches]).sum()
    assert image.pixel_areas.sum() == pytest.approx(true, rel=1e-9)
    assert (image.pixel_areas[~image.inside] == 0).all()
    assert np.quantile(image.pixel_areas[image.inside], 0.01) > 0.2 * np.median(image.pixel_areas[image.inside])


def test_force_of_a_patch_equals_that_of_its_part_of_the_image(three_patches, image):
    pressures = np.full(len(three_patches.skin), 2000.0)
    shown = image.render(pressures)
    patch = three_patches.to_body_many(image.centres())[0].reshape(image.shape)
    for number, worn in enumerate(three_patches.skin.patches):
        part = np.where(patch == number, shown, 0)
        assert image.force(part) == pytest.approx(2000 * worn.taxels.areas.sum(), rel=1e-6)


def test_unknown_interpolation_is_rejected_by_name(three_patches):
    with pytest.raises(MapError, match="interpolation"):
        TactileImage(three_patches, interpolation="cubic")


def test_body_has_the_colours_of_the_map(three_patches):
    for number, weights in enumerate(vertex_weights(three_patches)):
        surface = three_patches.skin.patches[number].surface
        assert weights.shape == (len(surface.vertices), len(three_patches.skin))
        np.testing.assert_allclose(np.asarray(weights.sum(axis=1)).ravel(), 1, rtol=1e-12)
        assert (three_patches.skin.patch_of[weights.indices] == number).all()


def test_seams_are_invisible_on_the_body(three_patches):
    """A seam's vertex takes the mean of its two places; without that one side would decide alone."""
    weights = vertex_weights(three_patches)[0]
    chart = three_patches.charts[0]
    vertex = int(chart.seams[len(chart.seams) // 2, 0])
    copies = np.flatnonzero(chart.vertex_of == vertex)
    assert len(copies) == 2
    x = three_patches.taxel_points[weights[vertex].indices, 0]
    middle = three_patches.uv[0][:, 0].mean()
    assert (x < middle).any()
    assert (x > middle).any()


def test_round_trip_agrees_with_the_table_of_the_image(three_patches):
    image = TactileImage(three_patches, width=200)
    skin = three_patches.skin
    found = round_trip_mm(three_patches, image)
    for taxel in range(0, len(skin), 7):
        at = image.back_project(*image.pixel(three_patches.taxel_points[taxel]))
        if at is None or at.patch != skin.patch_of[taxel]:
            assert not found[taxel] < 1e9
        else:
            away = np.linalg.norm(skin.position(at) - skin.position(skin.taxel_point(taxel)))
            assert found[taxel] == pytest.approx(1e3 * away, abs=1e-9)
    assert np.isfinite(found).mean() > 0.9


def test_taxel_whose_pixel_shows_another_patch_has_no_round_trip(three_patches):
    places = (*three_patches.layout.placements[:2], three_patches.layout.placements[0])
    covered = TactileMap(three_patches.skin, three_patches.charts, MapLayout(places))
    image = TactileImage(covered, width=200)
    shown = [image.back_project(*image.pixel(point)) for point in covered.taxel_points]
    other = np.array(
        [at is not None and at.patch != patch for at, patch in zip(shown, covered.skin.patch_of, strict=True)]
    )
    assert other.any()
    assert np.isinf(round_trip_mm(covered, image)[other]).all()


def test_finer_pixels_reduce_the_round_trip_error(three_patches):
    coarse, fine = (np.nanmedian(round_trip_mm(three_patches, TactileImage(three_patches, width=w))) for w in (40, 300))
    assert fine < 0.2 * coarse


def test_mirrored_patch_has_a_round_trip(three_patches):
    places = (Placement(offset=(-1.0, 0.0), mirrored=True), *three_patches.layout.placements[1:])
    mirrored = TactileMap(three_patches.skin, three_patches.charts, MapLayout(places))
    found = round_trip_mm(mirrored, TactileImage(mirrored, width=600))
    assert np.nanmedian(found[:40]) < 3


def test_force_of_every_taxel_is_conserved_in_the_image(three_patches):
    image = TactileImage(three_patches, width=150)
    errors = force_error(image)
    assert errors.shape == (len(three_patches.skin),)
    assert np.abs(errors).max() < 1e-12
    pressures = np.random.default_rng(0).uniform(0, 1e4, len(three_patches.skin))
    shown = image.weights.astype(np.float64) @ pressures @ image.pixel_areas.ravel()
    assert shown == pytest.approx(pressures @ three_patches.skin.areas, rel=1e-12)


def test_taxel_without_pixel_has_no_force(three_patches):
    lost = force_error(TactileImage(three_patches, width=6)) == -1
    assert lost.any()


def test_round_trip_of_places_off_the_skin_is_unknown(three_patches):
    patch = np.array([0, -1, 2])
    face = np.array([3, -1, 5])
    places = surface_positions(three_patches.skin, patch, face, np.full((3, 3), 1 / 3))
    surfaces = [worn.surface for worn in three_patches.skin.patches]
    np.testing.assert_allclose(places[0], surfaces[0].vertices[surfaces[0].faces[3]].mean(axis=0))
    np.testing.assert_allclose(places[2], surfaces[2].vertices[surfaces[2].faces[5]].mean(axis=0))
    assert np.isnan(places[1]).all()
