"""Maps whose best energy is known from elsewhere: theory, a one-dimensional computation, another program."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from scipy.optimize import minimize

from app.geometry.mesh import Mesh
from app.maps.cut import cut_to_disk
from app.maps.flatten import flatten
from app.maps.methods.tutte import tutte
from app.maps.symmetric_dirichlet import SymmetricDirichlet, rotation_svd
from tests.numerics.map_surfaces import cap, frustum, named, sheet, spiral


@pytest.mark.parametrize(
    "surface",
    [frustum(), frustum(0.05, 0.02), frustum(0.02, 0.05, length=0.05), sheet(), named("needles")],
    ids=["cylinder", "cone", "steep cone", "sheet", "needles"],
)
def test_what_can_be_unrolled_is_unrolled_without_loss(surface):
    assert flatten(surface).energies[-1] - 4 < 1e-6


@pytest.mark.parametrize(("angle", "energy"), [(0.5, 4.00131), (1.0, 4.02164), (np.pi / 2, 4.14051)])
def test_a_cap_of_a_sphere_reaches_the_optimum_known_for_it(angle, energy):
    assert flatten(cap(angle, rings=32)).energies[-1] == pytest.approx(energy, abs=5e-3 * (energy - 4) + 2e-5)


def _best_ring_map(angle, count=200):
    """The least energy among maps that keep circles circles: one radius for each distance from the pole."""
    down = np.linspace(0, angle, count + 1)
    middle, width = 0.5 * (down[1:] + down[:-1]), np.diff(down)

    def energy(steps):
        radius = np.concatenate([[0.0], np.cumsum(np.exp(steps) * width)])
        along = np.exp(steps)
        across = 0.5 * (radius[1:] + radius[:-1]) / np.sin(middle)
        weight = np.sin(middle) * width
        density = along**2 + along**-2.0 + across**2 + across**-2.0
        return (density * weight).sum() / weight.sum()

    return minimize(energy, np.zeros(count), method="L-BFGS-B", options={"maxfun": 10**6}).fun


@pytest.mark.parametrize("angle", [0.8, 1.3])
def test_a_cap_is_as_good_as_the_best_map_of_rings(angle):
    expected = _best_ring_map(angle)
    found = flatten(cap(angle, rings=32)).energies[-1]
    assert found - 4 == pytest.approx(expected - 4, rel=0.01)


def test_no_map_of_a_hemisphere_beats_milnors_bound():
    """Largest over smallest stretch of a cap of angle a is at least a / sin a (Milnor 1969)."""
    surface = cap(np.pi / 2, rings=32)
    chart = flatten(surface)
    problem = SymmetricDirichlet(surface.vertices[chart.vertex_of], chart.faces)
    stretch = rotation_svd(problem.jacobians(chart.plane))[1]
    assert np.pi / 2 * 0.995 < stretch.max() / stretch.min() < 1.75


def test_a_spiral_laid_flat_without_a_border_guard_would_be_free_of_loss():
    """So what the guard costs is all that is lost."""
    assert 4 < flatten(spiral()).energies[-1] < 4.02


@pytest.mark.parametrize("name", ["bumpy tube", "hemisphere", "two handles"])
def test_slim_finds_the_same_optimum(name):
    """libigl's SLIM from the same start; it is slower, and only ever sees checked input."""
    surface = named(name)
    cut = cut_to_disk(surface)
    positions = np.ascontiguousarray(surface.vertices[cut.vertex_of] / np.sqrt(surface.area))
    faces = np.ascontiguousarray(cut.faces)
    assert faces.min() >= 0
    assert faces.max() == len(positions) - 1
    assert Mesh(positions, faces).face_areas.min() > 1e-9
    start = tutte(positions, faces) / np.sqrt(np.pi)
    energy = igl.MappingEnergyType.SYMMETRIC_DIRICHLET
    data = igl.slim_precompute(positions, faces, start, energy, np.array([0]), start[:1], 0.0)
    plane = np.asarray(igl.slim_solve(data, 100))[:, :2]
    slim = SymmetricDirichlet(positions, faces).energy(plane)
    ours = flatten(surface).energies[-1]
    assert np.isfinite(slim)
    assert ours - 4 < 1.01 * (slim - 4)
    assert ours == pytest.approx(slim, rel=0.01)
