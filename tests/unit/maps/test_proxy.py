"""A stand-in: one disk without flips, exact for its own map, and apart at slits."""

from __future__ import annotations

import numpy as np
import pytest

from app.errors import MapError
from app.geometry.topology import boundary_loops, euler_characteristic
from app.maps.bijective import flipped
from app.maps.chart import Chart
from app.maps.flatten import flatten
from app.maps.proxy import build_proxy
from app.maps.seams import SeamPlan, path_along_edges
from tests.numerics.map_surfaces import cap, frustum, sheet, torus

SURFACES = {
    "wavy sheet": lambda: sheet(50, 40, shape=lambda x, y: 0.01 * np.sin(60 * x) * np.cos(50 * y)),
    "tube": lambda: frustum(around=60, along=40),
    "deep cap": lambda: cap(2.4, rings=24),
    "torus": lambda: torus(around=60, across=30),
}


@pytest.fixture(scope="module", params=SURFACES)
def made(request):
    surface = SURFACES[request.param]()
    chart = flatten(surface)
    return surface, chart, build_proxy(surface, chart, faces=400, name=request.param)


def test_it_is_a_coarse_disk_without_flips(made):
    _, chart, proxy = made
    assert 200 < len(proxy.surface.faces) < 600 < len(chart.faces)
    assert euler_characteristic(proxy.surface.faces) == len(boundary_loops(proxy.surface.faces)) == 1
    assert not flipped(proxy.plane, proxy.surface.faces).any()


def test_it_carries_its_own_map_exactly_and_any_affine_one(made):
    _, chart, proxy = made
    size = np.abs(chart.plane).max()
    np.testing.assert_allclose(proxy.carried @ proxy.plane, chart.plane, atol=1e-12 * size)
    np.testing.assert_array_equal(proxy.plane, chart.plane[proxy.chosen])
    affine = np.array([[1.2, 0.3], [-0.4, 0.8]])
    np.testing.assert_allclose(
        proxy.carried @ (proxy.plane @ affine + 1.0), chart.plane @ affine + 1.0, atol=1e-12 * (1 + size)
    )


def test_its_vertices_are_those_of_the_patch(made):
    surface, chart, proxy = made
    np.testing.assert_array_equal(proxy.surface.vertices, surface.vertices[chart.vertex_of[proxy.chosen]])
    np.testing.assert_array_equal(proxy.owners[proxy.chosen], np.arange(len(proxy.chosen)))


def test_a_pins_place_is_the_same_in_coarse_faces(made):
    _, chart, proxy = made
    rng = np.random.default_rng(0)
    corners, weights = chart.faces[rng.integers(len(chart.faces), size=50)], rng.dirichlet(np.ones(3), 50)
    coarse, shares = proxy.held(corners, weights)
    there = np.einsum("qc,qcd->qd", shares, proxy.plane[coarse])
    here = np.einsum("qc,qcd->qd", weights, chart.plane[corners])
    np.testing.assert_allclose(there, here, atol=1e-12)
    assert proxy.held(corners[:0], weights[:0])[0].shape == (0, 3)


def test_the_two_sides_of_a_slit_are_carried_apart():
    flat = sheet(40, 30)
    path = path_along_edges(flat, [int(np.argmin(np.linalg.norm(flat.vertices - p, axis=1))) for p in _SLIT])
    chart = flatten(flat, seams=SeamPlan(extra=0, drawn=path))
    doubled = np.flatnonzero(np.bincount(chart.vertex_of) == 2)
    assert len(doubled) > 10, "the slit has two sides"
    proxy = build_proxy(flat, chart, faces=300)
    owners = proxy.owners[np.array([np.flatnonzero(chart.vertex_of == v) for v in doubled])]
    assert len(np.unique(owners[:, 0])) > 2
    assert not np.isin(owners[:, 0], owners[:, 1]).any()


_SLIT = ((0.06, 0.0, 0.0), (0.06, 0.05, 0.0))


def test_what_cannot_be_thinned_out_is_refused():
    strip = sheet(300, 1, width=1.0, height=0.001)
    chart = Chart(strip.faces, strip.vertices[:, :2], np.arange(len(strip.vertices)), np.zeros((0, 2)), "by hand")
    with pytest.raises(MapError, match="no coarse stand-in"):
        build_proxy(strip, chart, faces=50, name="strip")
