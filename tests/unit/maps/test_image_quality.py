"""What the image keeps of place and force, against plain counting."""

from __future__ import annotations

import numpy as np
import pytest

from app.maps.image_quality import force_error, round_trip_mm, surface_positions
from app.maps.layout import MapLayout, Placement
from app.maps.tactile_image import TactileImage
from app.maps.tactile_map import TactileMap


def test_the_round_trip_is_that_of_the_images_own_table(three_patches):
    image, skin = TactileImage(three_patches, width=200), three_patches.skin
    found = round_trip_mm(three_patches, image)
    for taxel in range(0, len(skin), 7):
        at = image.back_project(*image.pixel(three_patches.taxel_points[taxel]))
        if at is None or at.patch != skin.patch_of[taxel]:
            assert not found[taxel] < 1e9
        else:
            away = np.linalg.norm(skin.position(at) - skin.position(skin.taxel_point(taxel)))
            assert found[taxel] == pytest.approx(1e3 * away, abs=1e-9)
    assert np.isfinite(found).mean() > 0.9


def test_a_taxel_whose_pixel_shows_another_patch_does_not_come_back(three_patches):
    places = (*three_patches.layout.placements[:2], three_patches.layout.placements[0])
    covered = TactileMap(three_patches.skin, three_patches.charts, MapLayout(places))
    image = TactileImage(covered, width=200)
    shown = [image.back_project(*image.pixel(point)) for point in covered.taxel_points]
    other = np.array(
        [at is not None and at.patch != patch for at, patch in zip(shown, covered.skin.patch_of, strict=True)]
    )
    assert other.any()
    assert np.isinf(round_trip_mm(covered, image)[other]).all()


def test_finer_pixels_lead_back_closer(three_patches):
    coarse, fine = (np.nanmedian(round_trip_mm(three_patches, TactileImage(three_patches, width=w))) for w in (40, 300))
    assert fine < 0.2 * coarse


def test_a_mirrored_patch_leads_back_too(three_patches):
    places = (Placement(offset=(-1.0, 0.0), mirrored=True), *three_patches.layout.placements[1:])
    mirrored = TactileMap(three_patches.skin, three_patches.charts, MapLayout(places))
    found = round_trip_mm(mirrored, TactileImage(mirrored, width=600))
    assert np.nanmedian(found[:40]) < 3


def test_the_force_of_every_taxel_is_kept(three_patches):
    image = TactileImage(three_patches, width=150)
    errors = force_error(image)
    assert errors.shape == (len(three_patches.skin),)
    assert np.abs(errors).max() < 1e-12
    pressures = np.random.default_rng(0).uniform(0, 1e4, len(three_patches.skin))
    shown = image.weights.astype(np.float64) @ pressures @ image.pixel_areas.ravel()
    assert shown == pytest.approx(pressures @ three_patches.skin.areas, rel=1e-12)


def test_what_no_pixel_shows_is_lost(three_patches):
    lost = force_error(TactileImage(three_patches, width=6)) == -1
    assert lost.any()


def test_places_off_the_skin_are_unknown(three_patches):
    patch, face = np.array([0, -1, 2]), np.array([3, -1, 5])
    places = surface_positions(three_patches.skin, patch, face, np.full((3, 3), 1 / 3))
    surfaces = [worn.surface for worn in three_patches.skin.patches]
    np.testing.assert_allclose(places[0], surfaces[0].vertices[surfaces[0].faces[3]].mean(axis=0))
    np.testing.assert_allclose(places[2], surfaces[2].vertices[surfaces[2].faces[5]].mean(axis=0))
    assert np.isnan(places[1]).all()
