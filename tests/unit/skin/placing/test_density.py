"""Curvature against shapes whose curvature is known, and the density made of it."""

from __future__ import annotations

import numpy as np
import pytest

from app.errors import SkinError
from app.geometry.mesh import Mesh
from app.skin.placement_spec import PlacementSpec
from app.skin.placing.density import MOST, bending_density, curvature, face_density
from tests.numerics.map_surfaces import cup, frustum, sheet, sphere


def test_curvature_of_a_ball_a_tube_and_a_plane():
    assert curvature(sphere(radius=0.05, subdivisions=4)) * 0.05 == pytest.approx(np.sqrt(2), rel=0.07)
    assert curvature(frustum(0.04, 0.04, around=72)) * 0.04 == pytest.approx(1, rel=0.01)
    assert curvature(sheet()) == pytest.approx(0)


def test_density_does_not_depend_on_size():
    small = cup(2)
    large = Mesh(10 * small.vertices, small.faces)
    assert bending_density(large, over=0.1) == pytest.approx(bending_density(small, over=0.01))


def test_the_rim_of_a_cup_is_denser_than_its_flat_bottom():
    surface = cup(3)
    density = bending_density(surface, over=0.004)
    radius = np.linalg.norm(surface.vertices[:, :2], axis=1)
    assert density.min() >= 1
    assert density.max() < MOST
    on_rim = (radius > 0.0199) & (surface.vertices[:, 2] > -1e-9)
    assert density[on_rim].min() > 1.5 * density[(radius < 0.01) & (surface.vertices[:, 2] > -1e-9)].max()


@pytest.mark.parametrize("surface", [sheet(), Mesh(0.01 * np.eye(3), np.array([[0, 1, 2]]))], ids=["sheet", "triangle"])
def test_what_is_flat_is_even(surface):
    assert bending_density(surface, over=0.01) == pytest.approx(1)


def test_paint_is_averaged_over_faces_and_must_fit():
    surface = sheet()
    painted = 1.0 + np.arange(len(surface.vertices))
    found = face_density(surface, PlacementSpec(taxels=5, density=painted), pitch=0.01)
    assert found[7] == pytest.approx(painted[surface.faces[7]].mean())
    assert face_density(surface, PlacementSpec(taxels=5), pitch=0.01).tolist() == [1.0] * len(surface.faces)
    with pytest.raises(SkinError, match="one value for each vertex"):
        face_density(surface, PlacementSpec(taxels=5, density=painted[1:]), pitch=0.01)
