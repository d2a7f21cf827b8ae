"""Bare points of links with skin, on shapes whose bare area is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.model.robot import Link, Robot
from tactile_maps.skin.mesh_skin import skin_of_mesh
from tactile_maps.skin.model.bare_surface import with_bare_points
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.placement import PlacementSpec
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tests.hard_cases.meshes import joined
from tests.support.surfaces import box, solid
from tests.support.touch import bar, bar_skin


def robot_of(mesh, **said):
    return Robot("block", "by hand", "", {}, (Link("block", mesh, **said),), (), np.zeros(0))


def skin_of(*surfaces, taxels=100):
    patches = (
        Patch(f"patch {k}", "block", mesh, place_evenly(mesh, taxels, seed=0)) for k, mesh in enumerate(surfaces)
    )
    return Skin(tuple(patches))


def plate(x, y, z, *, edge=2e-3):
    """Return a horizontal plate that faces up."""
    m, n = (round((high - low) / edge) for low, high in (x, y))
    i, j = (k.ravel() for k in np.meshgrid(np.linspace(*x, m + 1), np.linspace(*y, n + 1), indexing="ij"))
    a = (np.arange(m)[:, None] * (n + 1) + np.arange(n)).ravel()
    faces = np.concatenate([np.stack([a, a + n + 1, a + n + 2], 1), np.stack([a, a + n + 2, a + 1], 1)])
    return Mesh(np.stack([i, j, np.full(len(i), z)], axis=1), faces)


def bare_points(mesh, skin):
    (part,) = with_bare_points(robot_of(mesh), skin).bare_points
    return part


def area_facing(part, *direction):
    return float(part.areas[part.normals @ np.array(direction) > 0.9].sum())


@pytest.mark.parametrize("finer", [1, 2])
def test_bare_points_have_the_area_not_covered_by_skin(finer):
    skin = bar_skin(60, finer=finer)
    (part,) = with_bare_points(bar(), skin).bare_points
    assert part.link == "bar"
    assert area_facing(part, 0, 0, -1) == pytest.approx(0.4 * 0.1, rel=1e-9)
    assert area_facing(part, 0, 1, 0) == pytest.approx(0.4 * 0.04, rel=1e-9)
    assert area_facing(part, 0, -1, 0) == pytest.approx(0.4 * 0.04, rel=1e-9)
    assert area_facing(part, 0, 0, 1) == pytest.approx(2 * 0.01 * 0.1, rel=0.02), "both ends of the top"
    top = part.positions[part.normals[:, 2] > 0.9]
    pitch = np.sqrt(np.median(skin.patches[0].taxels.quadrature.areas))
    assert (np.abs(top[:, 0] - 0.2) > 0.19 - 1e-3).all()
    assert np.sqrt(part.areas.sum() / len(part.areas)) == pytest.approx(pitch, rel=0.4), "as dense as the skin"


def test_skin_around_the_whole_link_leaves_no_bare_points():
    ball, cover = (solid(trimesh.creation.icosphere(4, radius)) for radius in (0.05, 0.053))
    skin = skin_of(cover)
    assert with_bare_points(robot_of(ball), skin) is skin


def test_bare_points_are_updated_for_a_displaced_skin():
    link = box(0.04, 0.04, 0.04)
    (patch,) = skin_of(plate((-0.01, 0.01), (-0.01, 0.01), 0.02)).patches
    moved = replace(patch, surface=Mesh(patch.surface.vertices + [0.005, 0.0, 0.0], patch.surface.faces))
    for surface, middle in ((patch, 0.0), (moved, 0.005)):
        part = bare_points(link, Skin((surface,)))
        top = part.normals[:, 2] > 0.9
        bare = float(part.areas[top] @ part.positions[top, 0])
        assert bare == pytest.approx(-0.02 * 0.02 * middle, rel=0.01, abs=1e-8), "the whole top is centred"


@pytest.mark.long
def test_links_without_a_mesh_have_no_bare_points():
    skin = skin_of(plate((-0.02, 0.02), (-0.02, 0.02), 0.02))
    for robot in (robot_of(None), robot_of(box(0.04, 0.04, 0.04), missing=("block.stl",))):
        assert with_bare_points(robot, skin) is skin
    assert with_bare_points(robot_of(box(0.04, 0.04, 0.04)), skin) is not skin


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("height", [-0.004, 0.0, 0.003, 0.02])
def test_mesh_under_or_slightly_above_skin_is_not_bare(height):
    part = bare_points(box(0.1, 0.1, 0.04), skin_of(plate((-0.05, 0.01), (-0.05, 0.05), 0.02 + height)))
    assert area_facing(part, 0, 0, 1) == pytest.approx(0.04 * 0.1, rel=0.02)
    assert area_facing(part, 1, 0, 0) == pytest.approx(0.1 * 0.04, rel=1e-9)


@pytest.mark.long
def test_seam_between_patches_is_not_a_border():
    whole = skin_of(plate((-0.04, 0.04), (-0.04, 0.04), 0.02))
    halves = skin_of(plate((-0.04, 0.0), (-0.04, 0.04), 0.02), plate((0.0, 0.04), (-0.04, 0.04), 0.02))
    one, two = (area_facing(bare_points(box(0.1, 0.1, 0.04), skin), 0, 0, 1) for skin in (whole, halves))
    assert one == pytest.approx(0.1**2 - 0.08**2, rel=0.02)
    assert two == pytest.approx(one, rel=0.01)


def test_face_across_a_seam_is_covered():
    """Its middle is on the seam."""
    vertices = np.array([[-0.006, -0.006, 0.02], [0.006, -0.006, 0.02], [0.0, 0.006, 0.02], [0.0, 0.0, 0.01]])
    pyramid = Mesh(vertices, np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]))
    halves = (plate((-0.02, 0), (-0.02, 0.02), 0.02), plate((0, 0.02), (-0.02, 0.02), 0.02))
    assert area_facing(bare_points(pyramid, skin_of(*halves)), 0, 0, 1) == 0


@pytest.mark.sampled(2)
@pytest.mark.parametrize("end", [0.0, 0.001, 0.002, 0.003, 0.004, 0.005])
def test_bare_area_ends_at_the_skin_at_any_mesh_resolution(end):
    skin = skin_of(plate((-0.05, end), (-0.05, 0.05), 0.02, edge=1e-2), taxels=20)
    area = area_facing(bare_points(box(0.1, 0.1, 0.04), skin), 0, 0, 1)
    assert area == pytest.approx((0.05 - end) * 0.1, rel=1.5e-3)


def test_faces_of_a_patch_without_a_taxel_are_bare():
    surface = plate((-0.05, 0.05), (-0.05, 0.05), 0.02)
    kept_out = (np.abs(surface.face_centres[:, :2]) < 0.01).all(axis=1)
    taxels = place_evenly(surface, 50, seed=0, allowed=~kept_out)
    loaded = with_bare_points(robot_of(None), Skin((Patch("top", "block", surface, taxels),)))
    (part,) = loaded.bare_points
    assert part.areas.sum() == pytest.approx(0.02**2, rel=1e-9)
    assert (np.abs(part.positions[:, :2]) < 0.01).all()
    assert part.areas.sum() + loaded.areas.sum() == pytest.approx(surface.area, rel=1e-12)


def test_gaps_between_modules_are_bare():
    surface = plate((-0.05, 0.05), (-0.05, 0.05), 0.02)
    skin = skin_of_mesh(surface, PlacementSpec(pitch=0.008, pattern="modules"), name="block")
    unread = skin.patches[0].surface.area - skin.areas.sum()
    assert unread > 0.01 * surface.area
    (part,) = with_bare_points(robot_of(None), skin).bare_points
    assert part.areas.sum() == pytest.approx(unread, rel=1e-6)


def test_parts_inside_the_link_have_no_points():
    shell = box(0.1, 0.1, 0.04)
    inside = joined(box(0.09, 0.09, 0.036), box(0.02, 0.02, 0.02), box(0.01, 0.01, 0.01, centre=(0.03, 0, 0)))
    skin = skin_of(plate((-0.05, 0.0), (-0.05, 0.05), 0.02))
    bare = bare_points(shell, skin)
    with_parts = bare_points(joined(shell, inside), skin)
    assert with_parts.areas.sum() == pytest.approx(bare.areas.sum(), rel=1e-3)
    assert (np.abs(with_parts.positions).max(axis=0) > [0.049, 0.049, 0.019]).all()
    assert (np.abs(with_parts.positions / [0.05, 0.05, 0.02]).max(axis=1) > 0.99).all(), "on the outside"


@pytest.mark.long
def test_ledge_below_skin_that_overhangs_is_bare():
    bracket = joined(
        box(0.1, 0.1, 0.01), box(0.01, 0.1, 0.1, centre=(-0.045, 0, 0.045)), box(0.1, 0.1, 0.01, centre=(0, 0, 0.09))
    )
    part = bare_points(bracket, skin_of(plate((-0.05, 0.05), (-0.05, 0.05), 0.095)))
    ledge = part.areas[(part.normals[:, 2] > 0.9) & (np.abs(part.positions[:, 2] - 0.005) < 1e-9)]
    assert ledge.sum() > 0.08 * 0.1


@pytest.mark.long
def test_number_of_points_of_a_large_link_is_limited():
    skin = skin_of(plate((-0.01, 0.01), (-0.01, 0.01), 0.5, edge=5e-4))
    part = bare_points(box(1.0, 1.0, 1.0), skin)
    assert len(part.areas) < 60_000
    assert part.areas.sum() == pytest.approx(6.0, rel=0.01)


def test_readings_depend_only_on_patches_and_taxels():
    skin = bar_skin()
    loaded = with_bare_points(bar(), skin)
    assert loaded.patches is skin.patches
    assert replace(loaded, bare_points=()).bare_area == skin.bare_area
    assert with_bare_points(bar(), skin) is loaded, "computed once"
