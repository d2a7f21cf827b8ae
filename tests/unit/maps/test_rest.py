"""The shapes to keep: true for every face with an area, and fit to be compared with for one without."""

from __future__ import annotations

import numpy as np
import pytest

from app.maps.rest import rest_triangles
from tests.numerics.map_surfaces import named


def _sides(rest):
    second = np.hypot(rest.along - rest.base, rest.across)
    return np.stack([rest.base, second, np.hypot(rest.along, rest.across)], axis=1)


def test_sides_and_areas_are_those_of_the_surface():
    surface = named("bumpy tube")
    rest = rest_triangles(surface.vertices, surface.faces)
    corners = surface.vertices[surface.faces]
    expected = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
    np.testing.assert_allclose(_sides(rest), expected, rtol=1e-12)
    np.testing.assert_allclose(rest.areas, surface.face_areas, rtol=1e-12)
    assert rest.mollified == 0


@pytest.mark.parametrize(
    "corners",
    [
        [[0, 0, 0], [1, 0, 0], [2, 0, 0]],
        [[0, 0, 0], [0, 0, 0], [1, 0, 0]],
        [[0, 0, 0], [1, 0, 0], [0, 0, 0]],
        [[1, 0, 0], [0, 0, 0], [0, 0, 0]],
        [[2, 2, 2], [2, 2, 2], [2, 2, 2]],
        [[0, 0, 0], [1, 0, 0], [0.5, 1e-9, 0]],
    ],
)
def test_a_face_without_area_gets_a_little(corners):
    good = np.array([[0, 0, 1.0], [1, 0, 1], [0, 1, 1]])
    positions = np.concatenate([good, np.array(corners, dtype=float)])
    rest = rest_triangles(positions, np.array([[0, 1, 2], [3, 4, 5]]))
    assert rest.mollified == 1
    assert rest.areas[0] == 0.5, "its neighbours keep their shape"
    assert 0 < rest.areas[1] < 0.02
    assert np.isfinite([rest.base, rest.along, rest.across]).all()
