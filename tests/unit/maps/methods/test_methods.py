"""Every method on surfaces with a known answer, on ones it was not made for, and on ones that break native code."""

from __future__ import annotations

import numpy as np
import pytest

from app.errors import MapError
from app.geometry.mesh import Mesh
from app.maps.bijective import crossings, flipped
from app.maps.cut import cut_to_disk
from app.maps.flatten import flatten
from app.maps.methods.disk import Disk
from app.maps.methods.table import METHODS, find_method
from tests.numerics.map_surfaces import cap, cup, frustum, sheet, sphere, torus

SURFACES = {
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


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("method", METHODS)
def test_every_method_gives_a_one_to_one_map_of_everything(method, surface):
    chart = flatten(SURFACES[surface], method=method)
    disk = Disk.of(SURFACES[surface], cut_to_disk(SURFACES[surface]))
    assert np.isfinite(chart.plane).all()
    assert not flipped(chart.plane, chart.faces).any()
    if method != "symmetric-dirichlet":
        assert crossings(chart.plane[disk.loop]) == 0


@pytest.mark.parametrize("surface", ["sheet", "tube", "cone"])
@pytest.mark.parametrize("method", ["symmetric-dirichlet", "lscm", "arap", "slim", "unroll"])
def test_a_developable_surface_is_laid_flat_without_distortion(method, surface):
    chart = flatten(SURFACES[surface], method=method)
    assert chart.energies[-1] == pytest.approx(4, abs=2e-5)
    assert "flips-mended" not in _kinds(chart)


@pytest.mark.parametrize("turned_out", [False, True])
def test_a_cone_is_rolled_off_seen_from_either_side(turned_out):
    cone = frustum(0.02, 0.05)
    seen = Mesh(cone.vertices[:, [2, 0, 1]] + 3, cone.faces[:, ::-1] if turned_out else cone.faces)
    chart = flatten(seen, method="unroll")
    assert chart.findings == ()
    assert chart.energies[-1] == pytest.approx(4, abs=2e-5)


def test_slim_and_ours_agree_on_the_optimum():
    surface = frustum(bump=0.3)
    energies = [flatten(surface, method=method).energies[-1] for method in ("symmetric-dirichlet", "slim")]
    assert energies[0] == pytest.approx(energies[1], rel=1e-4)


def test_methods_are_what_their_titles_say():
    surface = cap(np.pi / 2, rings=12)
    angles = {name: _angle(surface, flatten(surface, method=name)) for name in ("tutte", "lscm", "arap")}
    assert angles["lscm"] < 1.06
    assert angles["lscm"] < angles["arap"] < angles["tutte"]


def _angle(surface, chart):
    """Mean s1 / s2."""
    disk = Disk(surface.vertices[chart.vertex_of], chart.faces)
    values = np.linalg.svd(disk.energy.jacobians(chart.plane))[1]
    return float((values[:, 0] / values[:, 1]).mean())


def test_the_slider_trades_lengths_for_angles_all_the_way():
    surface = cap(2.0, rings=12)
    charts = [flatten(surface, lengths=place) for place in (1.0, 0.6, 0.3, 0.1, 0.0)]
    assert all(len(chart.seams) == len(charts[0].seams) for chart in charts)
    angles = [_angle(surface, chart) for chart in charts]
    energies = [chart.energies[-1] for chart in charts]
    assert angles == sorted(angles, reverse=True)
    assert energies == sorted(energies)
    assert angles[-1] < 1.1 < 1.3 < angles[0]


def test_a_place_beyond_the_slider_is_refused():
    with pytest.raises(MapError, match="0 to 1"):
        flatten(sheet(), lengths=1.5)


def test_a_method_that_turns_triangles_over_is_mended_and_says_so():
    chart = flatten(cap(2.8, rings=10), method="unroll")
    assert _kinds(chart) == {"flips-mended"}


def test_an_unknown_method_is_refused_with_the_known_ones():
    with pytest.raises(MapError, match=r"magic.*tutte"):
        find_method("magic")
