"""Every method lays a disk flat as it promises; Tutte's map is always valid."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.flattening.bijectivity import crossings, flipped
from tactile_maps.flattening.cut import cut_to_disk
from tactile_maps.flattening.flatten import flatten
from tactile_maps.flattening.initial_map import Disk, tutte
from tactile_maps.flattening.methods import METHODS, find_method
from tactile_maps.geometry.surface.mesh import Mesh
from tests.support.surfaces import SURFACES, cap, cup, frustum, named, sheet, sphere, torus


@pytest.mark.sampled(14)
@pytest.mark.parametrize("name", [name for name in SURFACES if name != "deep cup"])
def test_no_triangle_flips_and_the_border_is_the_unit_circle(name):
    surface = named(name)
    cut = cut_to_disk(surface)
    plane = tutte(Mesh(surface.vertices[cut.vertex_of], cut.faces))
    border = plane[cut.connectivity.boundary_loops[0]]
    assert not flipped(plane, cut.faces).any()
    assert crossings(border) == 0
    np.testing.assert_allclose(np.linalg.norm(border, axis=1), 1.0, rtol=1e-12)


def test_arcs_on_the_circle_are_as_long_as_on_the_body():
    surface = sheet(6, 3)
    cut = cut_to_disk(surface)
    (loop,) = cut.connectivity.boundary_loops
    plane = tutte(Mesh(surface.vertices, cut.faces))[loop]
    arcs = np.angle((plane @ [1, 1j])[np.r_[1 : len(loop), 0]] / (plane @ [1, 1j]))
    sides = np.linalg.norm(surface.vertices[np.roll(loop, -1)] - surface.vertices[loop], axis=1)
    np.testing.assert_allclose(arcs / (2 * np.pi), sides / sides.sum(), rtol=1e-9)


def test_inner_vertex_is_the_mean_of_its_neighbours():
    surface = sheet(4, 4)
    plane = tutte(surface)
    around = np.unique(surface.edges[(surface.edges == 12).any(axis=1)])
    around = around[around != 12]
    assert len(around) == 6
    np.testing.assert_allclose(plane[12], plane[around].mean(axis=0), atol=1e-12)


METHOD_SURFACES = {
    "sheet": sheet(),
    "tube": frustum(),
    "cone": frustum(0.05, 0.02),
    "waved tube": frustum(bump=0.3),
    "hemisphere": cap(np.pi / 2, rings=12),
    "deep cup": cup(4, rings=4),
    "ball": sphere(),
    "ring": torus(around=24, across=12),
    "one triangle": Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
    "two triangles": Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 1]], [[0, 1, 2], [0, 2, 3]]),
    "a sliver": Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0.5, 1e-12, 0]], [[0, 3, 2], [3, 1, 2], [0, 1, 3]]),
}


def _kinds(chart):
    return {finding.kind for finding in chart.findings}


@pytest.mark.rotating
@pytest.mark.parametrize("surface", METHOD_SURFACES)
@pytest.mark.parametrize("method", METHODS)
def test_every_method_gives_a_one_to_one_map_of_everything(method, surface):
    chart = flatten(METHOD_SURFACES[surface], method=method)
    disk = Disk.of(METHOD_SURFACES[surface], cut_to_disk(METHOD_SURFACES[surface]))
    assert np.isfinite(chart.plane).all()
    assert not flipped(chart.plane, chart.faces).any()
    if method != "symmetric-dirichlet":
        assert crossings(chart.plane[disk.loop]) == 0


@pytest.mark.long
@pytest.mark.parametrize("surface", ["sheet", "tube", "cone"])
@pytest.mark.parametrize("method", ["symmetric-dirichlet", "lscm", "arap", "slim", "unroll"])
def test_developable_surface_is_flattened_without_distortion(method, surface):
    chart = flatten(METHOD_SURFACES[surface], method=method)
    assert chart.energies[-1] == pytest.approx(4, abs=2e-5)
    assert "flips-mended" not in _kinds(chart)


@pytest.mark.parametrize("turned_out", [False, True])
def test_cone_is_unrolled_for_either_orientation(turned_out):
    cone = frustum(0.02, 0.05)
    seen = Mesh(cone.vertices[:, [2, 0, 1]] + 3, cone.faces[:, ::-1] if turned_out else cone.faces)
    chart = flatten(seen, method="unroll")
    assert chart.findings == ()
    assert chart.energies[-1] == pytest.approx(4, abs=2e-5)


def test_slim_and_our_method_reach_the_same_optimum():
    surface = frustum(bump=0.3)
    energies = [flatten(surface, method=method).energies[-1] for method in ("symmetric-dirichlet", "slim")]
    assert energies[0] == pytest.approx(energies[1], rel=1e-4)


def test_methods_have_the_properties_in_their_titles():
    surface = cap(np.pi / 2, rings=12)
    angles = {name: _angle(surface, flatten(surface, method=name)) for name in ("tutte", "lscm", "arap")}
    assert angles["lscm"] < 1.06
    assert angles["lscm"] < angles["arap"] < angles["tutte"]


def _angle(surface, chart):
    """Mean s1 / s2."""
    disk = Disk(Mesh(surface.vertices[chart.vertex_of], chart.faces))
    values = np.linalg.svd(disk.energy.jacobians(chart.plane))[1]
    return float((values[:, 0] / values[:, 1]).mean())


def test_slider_trades_lengths_for_angles_over_its_whole_range():
    surface = cap(2.0, rings=12)
    charts = [flatten(surface, lengths=place) for place in (1.0, 0.6, 0.3, 0.1, 0.0)]
    assert all(len(chart.seams) == len(charts[0].seams) for chart in charts)
    angles = [_angle(surface, chart) for chart in charts]
    energies = [chart.energies[-1] for chart in charts]
    assert angles == sorted(angles, reverse=True)
    assert energies == sorted(energies)
    assert angles[-1] < 1.1 < 1.3 < angles[0]


def test_value_beyond_the_slider_is_rejected():
    with pytest.raises(MapError, match="0 to 1"):
        flatten(sheet(), lengths=1.5)


def test_method_with_flips_is_repaired_with_a_finding():
    chart = flatten(cap(2.8, rings=10), method="unroll")
    assert _kinds(chart) == {"flips-mended"}


def test_unknown_method_is_rejected_with_the_known_ones():
    with pytest.raises(MapError, match=r"magic.*tutte"):
        find_method("magic")
