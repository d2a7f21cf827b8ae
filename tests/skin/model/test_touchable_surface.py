"""The surface of rigidly joined shapes that can be touched, by shapes made in code."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.skin.model.touchable_surface import touchable_surfaces
from tests.hard_cases.meshes import joined
from tests.support.surfaces import box, solid


def tube(inner, outer, height):
    return solid(trimesh.creation.annulus(inner, outer, height, sections=32))


def rod(radius, height):
    return solid(trimesh.creation.cylinder(radius, height, sections=32))


def centres(mesh):
    assert mesh is not None
    return mesh.face_centres


@pytest.mark.parametrize("depth", [0.0002, 0.001, 0.004, 0.02])
def test_core_inside_a_pad_cannot_be_touched_and_the_pad_is_unchanged(depth):
    core = box(0.04, 0.04, 0.04)
    pad = box(*[0.04 + 2 * depth] * 3)
    inner, outer = touchable_surfaces([core, pad])
    assert inner is None
    assert outer is pad


def test_inside_out_shape_also_hides_others():
    pad = box(0.06, 0.06, 0.06)
    inner, outer = touchable_surfaces([box(0.04, 0.04, 0.04), Mesh(pad.vertices, pad.faces[:, ::-1])])
    assert inner is None
    assert outer is not None


def test_separate_and_adjacent_shapes_are_unchanged():
    meshes = [
        box(0.04, 0.04, 0.04),
        box(0.04, 0.04, 0.04, centre=(0.045, 0, 0)),
        box(0.01, 0.01, 0.01, centre=(1, 0, 0)),
    ]
    assert all(surface is mesh for surface, mesh in zip(touchable_surfaces(meshes), meshes, strict=True))


def test_protruding_part_of_a_core_can_be_touched():
    core = box(0.02, 0.02, 0.07, centre=(0, 0, 0.025))
    pad = box(0.04, 0.04, 0.04)
    inner, outer = touchable_surfaces([core, pad])
    assert centres(inner)[:, 2].min() > 0.02 - 1e-3
    assert inner.area == pytest.approx(0.02**2 + 4 * 0.02 * 0.04, rel=0.05)
    assert outer.area == pytest.approx(6 * 0.04**2 - 0.02**2, rel=0.05)


def test_faces_pressed_together_cannot_be_touched():
    base = box(0.04, 0.04, 0.04)
    plate = box(0.04, 0.04, 0.002, centre=(0, 0, 0.021))
    lower, upper = touchable_surfaces([base, plate])
    assert lower.area == pytest.approx(5 * 0.04**2, rel=0.05)
    assert centres(lower)[:, 2].max() < 0.02
    assert upper.area == pytest.approx(0.04**2 + 4 * 0.04 * 0.002, rel=0.05)
    assert centres(upper)[:, 2].min() > 0.02


def test_core_in_the_cavity_of_a_hollow_pad_cannot_be_touched():
    cavity = box(0.05, 0.05, 0.05)
    hollow = joined(box(0.06, 0.06, 0.06), Mesh(cavity.vertices, cavity.faces[:, ::-1]))
    inner, outer = touchable_surfaces([box(0.04, 0.04, 0.04), hollow])
    assert inner is None
    assert outer is not None


@pytest.mark.parametrize("gap", [pytest.param(0.0, marks=pytest.mark.long), 0.0003])
def test_rod_in_a_sleeve_can_be_touched_where_it_protrudes(gap):
    inner, outer = touchable_surfaces([rod(0.01, 0.06), tube(0.01 + gap, 0.013, 0.03)])
    assert np.abs(centres(inner)[:, 2]).min() > 0.015 - 1e-3
    bore = np.linalg.norm(centres(outer)[:, :2], axis=1) < 0.0105
    ends = np.abs(centres(outer)[:, 2]) > 0.015 - 1e-3
    assert not (bore & ~ends).any()
    assert (np.linalg.norm(centres(outer)[:, :2], axis=1) > 0.0125).any()


def test_duplicated_shape_can_be_touched():
    both = touchable_surfaces([box(0.04, 0.04, 0.04), box(0.04, 0.04, 0.04)])
    assert [surface.area for surface in both] == pytest.approx([6 * 0.04**2] * 2)


def test_open_sheet_does_not_hide_other_shapes():
    sheet = Mesh(np.array([[-0.05, -0.05, 0], [0.05, -0.05, 0], [0.05, 0.05, 0], [-0.05, 0.05, 0]]),
                 np.array([[0, 1, 2], [0, 2, 3]]))  # fmt: skip
    core = box(0.04, 0.04, 0.04)
    assert touchable_surfaces([core, sheet])[0] is core
