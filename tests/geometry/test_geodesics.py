"""Distances over the body, exact where that is safe, and honest where it is not."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.geometry.geodesics import (
    Geodesics,
    all_path_lengths,
    distances_from,
    edge_graph,
    nearest_sources,
    path_in_tree,
    shortest_path_tree,
)
from tactile_maps.geometry.surface.mesh import Mesh
from tests.support.surfaces import cap, frustum, named, sheet


def test_distance_on_a_flat_sheet_is_the_straight_line():
    surface = sheet()
    everywhere = np.arange(len(surface.vertices))
    expected = np.linalg.norm(surface.vertices - surface.vertices[17], axis=1)
    np.testing.assert_allclose(Geodesics(surface).from_vertex(17, everywhere), expected, atol=1e-12)


def test_distance_around_a_tube_is_that_of_a_helix():
    surface = frustum(0.05, 0.05, length=0.2, around=60, along=30)
    everywhere = np.arange(len(surface.vertices))
    turn = np.abs(np.angle(np.exp(1j * np.arctan2(surface.vertices[:, 1], surface.vertices[:, 0]))))
    side = 2 * 0.05 * np.sin(np.pi / 60) * 60 / (2 * np.pi)
    expected = np.hypot(side * turn, surface.vertices[:, 2])
    np.testing.assert_allclose(Geodesics(surface).from_vertex(0, everywhere), expected, rtol=1e-3, atol=1e-9)


def test_approximate_distance_is_close_to_the_exact_one():
    surface = cap(1.2, rings=20)
    everywhere = np.arange(1, len(surface.vertices))
    geodesics = Geodesics(surface)
    exact = geodesics.from_vertex(0, everywhere)
    quick = geodesics.approximate_from_vertex(0, everywhere)
    assert np.abs(quick / exact - 1).mean() < 0.03


def test_targets_may_repeat_and_come_in_any_order():
    geodesics = Geodesics(sheet())
    found = geodesics.from_vertex(5, np.array([9, 5, 9, 0]))
    assert found[0] == found[2]
    assert found[1] == 0


@pytest.mark.parametrize("name", ["thin faces", "one triangle"])
def test_surface_unsafe_for_exact_geodesics_is_measured_along_edges(name):
    surface = named("thin faces") if name == "thin faces" else Mesh(np.eye(3) * [1, 1, 0], [[0, 1, 2]])
    geodesics = Geodesics(surface)
    assert geodesics.exact is (name == "one triangle")
    found = geodesics.approximate_from_vertex(int(surface.faces[0, 0]), surface.faces[0])
    expected = np.linalg.norm(surface.vertices[surface.faces[0]] - surface.vertices[surface.faces[0, 0]], axis=1)
    np.testing.assert_allclose(found, expected, rtol=0.35, atol=1e-12)


@pytest.mark.parametrize(("sides", "exact"), [(50, True), (100, False)])
def test_many_thin_faces_are_measured_along_edges(sides, exact):
    """A needle of 1 m: faces a thousandth as wide as long take the exact method minutes once taxels divide them."""
    angles = 2 * np.pi * np.arange(sides) / sides
    width = 0.0015 * sides / (2 * np.pi)
    rim = width * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(sides)])
    faces = [(k, (k + 1) % sides, sides) for k in range(sides)]
    needle = Geodesics(Mesh(np.vstack([rim, [0, 0, 1.0]]), np.array(faces)))
    assert needle.exact is exact
    assert needle.from_vertex(sides, np.array([0]))[0] == pytest.approx(np.hypot(1.0, width))


def test_geodesics_ignore_unreferenced_vertices():
    surface = named("loose vertices")
    assert Geodesics(surface).from_vertex(3, np.array([3, 4])).tolist() == pytest.approx([0, 0.01])


@pytest.mark.parametrize("name", ["saddle", "bumpy tube", "sieve", "hemisphere", "torus"])
def test_near_distances_are_exact_within_the_reach(name):
    surface = named(name)
    geodesics = Geodesics(surface)
    everywhere = np.arange(len(surface.vertices))
    reach = 0.2 * surface.size
    for source in (0, len(surface.vertices) // 2):
        exact = geodesics.from_vertex(source, everywhere)
        near = geodesics.from_vertex_within(source, everywhere, reach)
        within = exact <= reach
        assert 2 < within.sum() < len(within), "the reach must cut the surface"
        np.testing.assert_allclose(near[within], exact[within], atol=1e-12)
        assert np.isinf(near[exact > reach * (1 + 1e-9)]).all()


def test_near_distances_along_edges_are_limited_by_the_reach():
    surface = named("thin faces")
    near = Geodesics(surface).from_vertex_within(0, np.arange(len(surface.vertices)), 0.03)
    assert 2 < np.isfinite(near).sum() < len(near)
    assert near[np.isfinite(near)].max() <= 0.03


LADDER = edge_graph(np.array([[0, 1], [1, 2], [0, 3], [3, 4], [2, 4], [5, 6]]), np.array([1.0, 1, 1, 5, 1, 1]), 7)
"""0 - 1 - 2 - 4 is shorter than 0 - 3 - 4; 5 and 6 are on their own."""


def test_shortest_path_is_found_and_traversed():
    distances, before = shortest_path_tree(LADDER, 0)
    assert distances.tolist() == [0, 1, 2, 1, 3, np.inf, np.inf]
    assert path_in_tree(before, 4).tolist() == [0, 1, 2, 4]
    assert path_in_tree(before, 6).tolist() == [6], "no way leads there"


def test_nearest_of_several_sources_is_found():
    sources = np.array([3, 4])
    distances, nearest = nearest_sources(LADDER, sources, limit=1.5)
    assert distances.tolist() == [1, np.inf, 1, 0, 0, np.inf, np.inf]
    assert nearest[[0, 2, 3, 4]].tolist() == [3, 4, 3, 4]
    assert (nearest[[1, 5, 6]] < 0).all()
    assert distances_from(LADDER, sources).tolist() == [1, 2, 1, 0, 0, np.inf, np.inf]


def test_all_path_lengths_are_symmetric_and_agree_with_those_from_one_node():
    every = all_path_lengths(LADDER)
    np.testing.assert_array_equal(every, every.T)
    for node, lengths in enumerate(every):
        np.testing.assert_array_equal(lengths, distances_from(LADDER, np.array([node])))
