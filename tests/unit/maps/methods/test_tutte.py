"""The first map: valid whatever the triangles look like."""

from __future__ import annotations

import numpy as np
import pytest

from app.geometry.topology import boundary_loops
from app.maps.bijective import crossings, flipped
from app.maps.cut import cut_to_disk
from app.maps.methods.tutte import tutte
from tests.numerics.map_surfaces import SURFACES, named, sheet


@pytest.mark.parametrize("name", [name for name in SURFACES if name != "deep cup"])
def test_no_triangle_flips_and_the_border_is_the_unit_circle(name):
    surface = named(name)
    cut = cut_to_disk(surface)
    plane = tutte(surface.vertices[cut.vertex_of], cut.faces)
    border = plane[boundary_loops(cut.faces)[0]]
    assert not flipped(plane, cut.faces).any()
    assert crossings(border) == 0
    np.testing.assert_allclose(np.linalg.norm(border, axis=1), 1.0, rtol=1e-12)


def test_arcs_on_the_circle_are_as_long_as_on_the_body():
    surface = sheet(6, 3)
    cut = cut_to_disk(surface)
    (loop,) = boundary_loops(cut.faces)
    plane = tutte(surface.vertices, cut.faces)[loop]
    arcs = np.angle((plane @ [1, 1j])[np.r_[1 : len(loop), 0]] / (plane @ [1, 1j]))
    sides = np.linalg.norm(surface.vertices[np.roll(loop, -1)] - surface.vertices[loop], axis=1)
    np.testing.assert_allclose(arcs / (2 * np.pi), sides / sides.sum(), rtol=1e-9)


def test_an_inner_vertex_is_the_mean_of_its_neighbours():
    surface = sheet(4, 4)
    plane = tutte(surface.vertices, surface.faces)
    around = np.unique(surface.edges[(surface.edges == 12).any(axis=1)])
    around = around[around != 12]
    assert len(around) == 6
    np.testing.assert_allclose(plane[12], plane[around].mean(axis=0), atol=1e-12)
