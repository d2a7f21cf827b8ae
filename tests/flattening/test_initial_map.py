"""The first map of slender and of flat patches: what is ever so long is neither pressed together nor folded."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.flattening.cut import SeamPlan, cut_to_disk, planned_cuts
from tactile_maps.flattening.flatten import flatten
from tactile_maps.flattening.initial_map import Disk, projection
from tactile_maps.geometry.remesh.refine import subdivide
from tactile_maps.geometry.surface.mesh import Mesh
from tests.hard_cases.meshes import spiked
from tests.support.surfaces import cap, frustum, sheet, sphere


def needle() -> Mesh:
    """A ball with a needle, fine enough along it to buckle."""
    coarse = spiked(1000)
    return subdivide(coarse, longest=coarse.size / 4000).mesh


def disk_of(surface: Mesh) -> Disk:
    return Disk.of(surface, cut_to_disk(surface))


def turned(mesh: Mesh, by: float) -> Mesh:
    turn = np.array([[1, 0, 0], [0, np.cos(by), -np.sin(by)], [0, np.sin(by), np.cos(by)]])
    return Mesh(mesh.vertices @ turn.T, mesh.faces)


@pytest.mark.long
def test_needle_shaped_patch_becomes_straight_without_overlap() -> None:
    surface = needle()
    chart = flatten(surface)
    assert "overlap-avoided" not in {finding.kind for finding in chart.findings}
    assert chart.energies[-1] < 4.01
    assert len(chart.energies) < 60
    # Cut lengthwise twice and opened, it is twice as long as on the body; folded it would be shorter.
    assert np.ptp(chart.plane, axis=0).max() > 1.9 * np.ptp(surface.vertices, axis=0).max()


def test_slender_patch_starts_as_wide_as_its_border_is_long() -> None:
    surface = needle()
    cuts = planned_cuts(surface, SeamPlan())
    next(cuts)
    disk = Disk.of(surface, next(cuts))
    border = disk.positions[disk.loop]
    length = np.linalg.norm(border - np.roll(border, 1, axis=0), axis=1).sum()
    assert np.ptp(disk.taut, axis=0).max() == pytest.approx(length)
    np.testing.assert_allclose(disk.taut / np.ptp(disk.taut), disk.start / np.ptp(disk.start), atol=1e-12)


@pytest.mark.parametrize("surface", [sheet(), cap(2.8), sphere(), frustum()], ids=["sheet", "cap", "ball", "tube"])
def test_patches_that_are_not_slender_start_with_the_unscaled_initial_map(surface: Mesh) -> None:
    disk = disk_of(surface)
    assert disk.taut is disk.start


def test_extremely_long_flat_strip_has_an_exact_initial_map() -> None:
    long = sheet(6, 5)
    surface = Mesh(long.vertices * [7e4, 1, 1], long.faces)
    chart = flatten(turned(subdivide(surface, longest=surface.size / 1000).mesh, 0.3))
    assert chart.energies[0] == pytest.approx(4, abs=1e-6)
    assert not chart.findings


def test_projection_faces_the_front_and_has_true_size() -> None:
    surface = turned(sheet(), 0.3)
    disk = disk_of(surface)
    plane = projection(disk.rest)
    assert disk.area(plane) == pytest.approx(1)
    assert disk.energy.energy(plane) == pytest.approx(4)


def test_surface_without_mean_normal_projects_to_the_origin() -> None:
    ball = sphere()
    assert np.ptp(projection(ball)) < 2.1 * 0.05
    both = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 1]])
    assert not projection(both).any()
