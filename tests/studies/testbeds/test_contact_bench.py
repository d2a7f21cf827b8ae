"""Skins and bodies for the table of contacts: their geometry is what statics assumes."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.studies.testbeds.contact_bench import (
    BODIES,
    CONCAVE,
    CONVEX,
    LINK,
    PITCH,
    SKINS,
    bench,
    lay,
)


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("skin", SKINS)
def test_skin_is_the_upper_side_of_a_closed_block(skin):
    made = bench(skin)
    mesh = made.robot.link(LINK).mesh
    assert mesh.connectivity.is_closed_manifold
    (patch,) = made.points.patches
    assert (patch.surface.face_normals[:, 2] > 0).all()
    assert made.points.areas.sum() == pytest.approx(made.taxels.areas.sum())
    if skin in ("flat", "convex", "concave"):
        x, y, z = patch.surface.vertices.T
        expected = {
            "flat": 0 * x,
            "convex": np.sqrt(CONVEX**2 - x**2) - CONVEX,
            "concave": CONCAVE - np.sqrt(CONCAVE**2 - x**2 - y**2),
        }[skin]
        assert z == pytest.approx(expected, abs=1e-12)


def test_points_and_taxels_are_their_own_mirror_images():
    made = bench("flat")
    for skin in (made.points, made.taxels):
        places = {tuple(place) for place in np.round(skin.patches[0].taxels.positions[:, :2], 9).tolist()}
        for sign in ((-1, 1), (1, -1)):
            assert places == {(sign[0] * x + 0.0, sign[1] * y + 0.0) for x, y in places}
    assert made.taxels.areas == pytest.approx(PITCH**2)


@pytest.mark.parametrize("shape", BODIES)
@pytest.mark.parametrize("slope", [0.0, 0.3])
def test_bodies_touch_the_block_with_their_lowest_point(shape, slope):
    thing = lay(shape, (0.01, 0.02, 0.0), slope=slope)
    up = np.array([np.sin(slope), 0.0, np.cos(slope)])
    heights = thing.spec.pose.points(thing.mesh.vertices) @ up
    assert heights.min() == pytest.approx(0.0, abs=2e-4 if shape == "sphere" else 1e-9)
    lowest = thing.spec.pose.points(thing.mesh.vertices[heights < heights.min() + 1e-6])
    middle = (lowest.max(axis=0) + lowest.min(axis=0)) / 2
    expected = np.array([np.cos(slope) * 0.01, 0.02, -np.sin(slope) * 0.01])
    assert middle == pytest.approx(expected, abs=2e-3 if shape == "sphere" else 1e-9)


def test_centre_of_mass_of_the_leaning_block():
    mesh = lay("mesh", (0.0, 0.0, 0.0)).mesh
    corners = mesh.vertices[mesh.faces]
    volumes = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volumes.sum() > 0
    centre = volumes @ corners.sum(axis=1) / 4 / volumes.sum()
    assert centre[0] == pytest.approx(BODIES["mesh"].aside)
    assert BODIES["mesh"].aside > 0.002
