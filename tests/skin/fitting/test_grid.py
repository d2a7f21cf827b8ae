from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from tactile_maps.core.errors import RobotError, SkinError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.skin.fitting.grid import GridSpec, add_grids, grid_skin
from tactile_maps.skin.fitting.measured_taxels import place_taxels
from tactile_maps.skin.model.taxel_set import TaxelSet
from tests.hard_cases.meshes import one_link
from tests.support.example_robots import two_rods
from tests.support.findings import kinds, only
from tests.support.surfaces import solid


def cover_of_rod(robot):
    angle, height = (grid.ravel() for grid in np.meshgrid(np.arange(0, 2 * np.pi, 0.15), np.arange(0.05, 0.2, 0.006)))
    positions = np.stack([0.04 * np.cos(angle), 0.04 * np.sin(angle), height], axis=1)
    taxels = TaxelSet("hand", "upper", np.arange(len(positions)), positions)
    return place_taxels(robot, "upper", taxels, thickness=0.002, file="hand.txt")


def at(angle, height):
    return float(0.04 * np.cos(angle)), float(0.04 * np.sin(angle)), height


GRID = GridSpec("upper", 6, 5, at(0.2, 0.08), at(1.4, 0.2))


def test_grid_is_placed_around_the_rod_in_rows_and_columns():
    skin = grid_skin(two_rods(), GRID, thickness=0.002)
    (patch,) = skin.patches
    assert (patch.link, patch.taxels.identity.ids.tolist()) == ("upper", list(range(30)))
    positions = patch.taxels.positions.reshape(6, 5, 3)
    radius = np.linalg.norm(positions[..., :2], axis=-1)
    np.testing.assert_allclose(radius, 0.042, atol=4e-4)  # on the cover
    flat = np.stack([radius.mean() * np.arctan2(positions[..., 1], positions[..., 0]), positions[..., 2]], axis=-1)
    sides = [np.linalg.norm(np.diff(flat, axis=axis), axis=-1) for axis in (0, 1)]
    pitch = only(skin.findings, "grid-pitch")
    assert f"6 x 5 taxels, {1e3 * sides[0].mean():.1f}" in pitch.action
    for gaps in sides:
        np.testing.assert_allclose(gaps, sides[0].mean(), rtol=0.02)
    np.testing.assert_allclose(flat[0, 0], [0.042 * 0.2, 0.08], atol=1e-3)
    np.testing.assert_allclose(flat[-1, -1], [0.042 * 1.4, 0.2], atol=1e-3)
    assert not [finding for finding in skin.findings if finding.kind in ("taxel-off-surface", "uneven-spacing")]


def test_taxels_beyond_an_edge_are_omitted_and_named():
    box = trimesh.creation.box((0.1, 0.1, 0.004))
    plate = one_link(Mesh(np.asarray(box.vertices), np.asarray(box.faces)))
    corner = 0.045, 0.045, 0.002
    wide = GridSpec(plate.links[0].name, 4, 9, (-corner[0], -corner[1], corner[2]), corner)  # turned, two corners off
    cut = grid_skin(plate, wide, thickness=0.002)
    assert np.concatenate([patch.taxels.positions for patch in cut.patches])[:, 2].min() > 0
    off = only(cut.findings, "taxel-off-surface")
    assert 0 < off.count == 36 - len(cut)
    assert "beyond an edge of the link, in rows" in off.action
    assert cut.coverage == pytest.approx(len(cut) / 36, abs=0.1)
    warning = only(cut.findings, "low-coverage")
    assert f"{off.count} of 36 taxels are beyond an edge" in warning.action
    assert len(np.unique(cut.identity.ids)) == len(cut)


PAD = one_link(solid(trimesh.creation.box((0.026, 0.003, 0.067))), name="pad")
LONG = GridSpec("pad", 6, 16, (-0.01, -0.0015, -0.03), (0.01, -0.0015, 0.03))
"""A grid on a flat pad when mirrored; not mirrored, its rows go around the long edges of the pad."""


def _normals(skin):
    return np.concatenate([patch.taxels.normals for patch in skin.patches])


@pytest.mark.parametrize("turned", [False, True])
def test_flatter_of_two_grids_is_used(turned):
    spec = replace(LONG, first=LONG.last, last=LONG.first) if turned else LONG
    skin = grid_skin(PAD, spec, thickness=0.002)
    assert len(skin) == 96
    assert _normals(skin)[:, 1].max() < -0.99
    chosen = only(skin.findings, "grid-mirrored")
    assert chosen.where == "pad grid"
    assert 10 < chosen.count < 96
    assert chosen.action.startswith("mirrored, which is flat; not mirrored, this number of taxels")


@pytest.mark.parametrize("rows", [2, 8])
def test_grid_corners_far_from_the_link_are_rejected(rows):
    far = replace(LONG, rows=rows, columns=rows, first=(-25.0, 0.0, -25.0), last=(25.0, 0.0, 25.0))
    with pytest.raises(
        SkinError, match=r"grid on pad: the first corner.*35\d\d\d mm from it, at -25000, 0, -25000 mm"
    ) as found:
        grid_skin(PAD, far, thickness=0.002)
    assert "frame of the link pad" in str(found.value)


def test_corners_of_a_grid_off_the_cover_are_reported():
    lifted = replace(LONG, first=(-0.01, -0.0095, -0.03))
    moved = only(grid_skin(PAD, lifted, thickness=0.002).findings, "grid-corner")
    assert (moved.where, moved.count) == ("pad grid", 1)
    assert "8.0 mm off" in moved.action
    assert "grid-corner" not in kinds(grid_skin(PAD, LONG, thickness=0.002).findings)


def test_stated_grid_is_kept_and_the_flatter_one_suggested():
    around = grid_skin(PAD, replace(LONG, mirrored=False), thickness=0.002)
    assert _normals(around)[:, 1].max() > 0.5
    found = only(around.findings, "grid-around-edge")
    assert found.action == "kept as stated; mirrored it is flat"
    flat = grid_skin(PAD, replace(LONG, mirrored=True), thickness=0.002)
    assert not [finding for finding in flat.findings if "grid-" in finding.kind and finding.kind != "grid-pitch"]


def test_grid_is_kept_if_its_mirror_image_is_not_flatter():
    square = replace(LONG, rows=6, columns=6, first=(-0.02, -0.0015, -0.02), last=(0.02, -0.0015, 0.02))
    kinds = {finding.kind for finding in grid_skin(PAD, square, thickness=0.002).findings}
    assert not kinds & {"grid-mirrored", "grid-around-edge"}


@pytest.mark.long
def test_grids_are_added_and_replace_patches_below_them():
    robot = two_rods()
    cover = cover_of_rod(robot)
    both = add_grids(robot, cover, [GRID, replace(GRID, first=at(3.2, 0.08), last=at(4.4, 0.2))], thickness=0.002)
    assert [patch.name for patch in both.patches] == ["upper grid", "upper grid 2"]
    gone = only(both.findings, "patch-under-grid")
    assert (gone.where, gone.count) == ("upper", len(cover))
    apart = add_grids(robot, cover, [replace(GRID, first=at(0.2, 0.24), last=at(0.8, 0.28))], thickness=0.002)
    assert [patch.name for patch in apart.patches] == ["upper", "upper grid"]
    alone = add_grids(robot, None, [GRID])
    assert len(alone) == 30
    assert add_grids(robot, cover, []) is cover


def test_impossible_grids_are_rejected():
    with pytest.raises(RobotError, match="wing"):
        grid_skin(two_rods(), replace(GRID, link="wing"))
    with pytest.raises(SkinError, match=r"grid on upper.*too close for so many taxels.*0\.5 mm"):
        grid_skin(two_rods(), replace(GRID, last=GRID.first))
    with pytest.raises(SkinError, match="rows is out of range.*1 to 256"):
        replace(GRID, rows=1000)
