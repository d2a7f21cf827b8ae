"""What the image keeps of the force: all of it, with pixel areas that stay near the true ones."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from app.maps.image_force import behind, force_areas
from app.maps.tactile_image import TactileImage


def test_the_areas_behind_the_pixels_are_those_of_their_faces(three_patches):
    """Many small pixels in one face add up to that face's area on the body."""
    image = TactileImage(three_patches, resolution=2e-4)
    patch, face, _ = three_patches.to_body_many(image.centres())
    areas = behind(three_patches, patch, face, image.resolution)
    assert (areas[face < 0] == 0).all()
    for number, worn in enumerate(three_patches.skin.patches):
        here = patch == number
        total = np.bincount(face[here], areas[here], minlength=len(worn.surface.faces))
        largest = worn.surface.face_areas.argsort()[-20:]
        np.testing.assert_allclose(total[largest], worn.surface.face_areas[largest], rtol=0.1)
        assert total.sum() == pytest.approx(worn.surface.area, rel=5e-3)


def test_every_taxels_force_is_kept():
    generator = np.random.default_rng(0)
    weights = csr_matrix(generator.dirichlet(np.ones(5), 60))
    areas, wanted = generator.uniform(0.5, 1.5, 60), 60 * generator.dirichlet(np.full(5, 20))
    np.testing.assert_allclose(weights.T @ force_areas(weights, areas, wanted), wanted, rtol=1e-12)


def test_of_all_such_areas_they_are_the_nearest():
    """Against the weighted least-norm solution by a dense pseudo-inverse."""
    generator = np.random.default_rng(1)
    weights = csr_matrix(generator.dirichlet(np.ones(5), 60))
    areas, wanted = generator.uniform(0.5, 1.5, 60), 60 * generator.dirichlet(np.full(5, 20))
    root = np.sqrt(areas)
    missing = wanted - weights.T @ areas
    expected = areas + root * (np.linalg.pinv(weights.T.toarray() * root) @ missing)
    np.testing.assert_allclose(force_areas(weights, areas, wanted), expected, rtol=1e-9)


def test_areas_that_are_right_stay_as_they_are():
    weights = csr_matrix(np.kron(np.eye(4), np.ones((3, 1))))
    areas = np.random.default_rng(0).uniform(0.5, 1.5, 12)
    np.testing.assert_allclose(force_areas(weights, areas, weights.T @ areas), areas, rtol=1e-12)


def test_a_taxel_without_a_pixel_has_no_part_and_spoils_nothing():
    weights = csr_matrix(np.kron(np.eye(4), np.ones((3, 1))))
    weights = csr_matrix((weights.data, weights.indices, weights.indptr), shape=(12, 5))
    areas = force_areas(weights, np.ones(12), np.array([3.0, 6, 3, 3, 7]))
    np.testing.assert_allclose(weights.T @ areas, [3, 6, 3, 3, 0])


def test_an_image_without_skin_has_no_force():
    assert (force_areas(csr_matrix((4, 2)), np.zeros(4), np.ones(2)) == 0).all()
