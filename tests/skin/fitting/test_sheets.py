"""Findings about covers that go around open surfaces."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.load import load_bare_mesh
from tactile_maps.scene.scene_file import scene_for_taxels
from tactile_maps.session.prepare import load_robot_and_skin
from tactile_maps.skin.fitting.cover import CoverSpec, cover_robot
from tactile_maps.skin.fitting.sheets import BOTH_SIDES
from tactile_widgets.__main__ import main
from tests.hard_cases.meshes import HARD_MESHES, joined, moved, one_link
from tests.support.findings import kinds, only

SQUARE = "v 0 0 0\nv 0.1 0 0\nv 0.1 0.1 0\nv 0 0.1 0\nf 1 2 3 4\n"


@pytest.fixture
def square(tmp_path):
    """File of a flat mesh of one square."""
    path = tmp_path / "square.obj"
    path.write_text(SQUARE)
    return path


def test_cover_of_a_flat_square_reports_taxels_on_both_sides(square):
    robot = load_bare_mesh(square)
    skin = cover_robot(robot, CoverSpec(taxels=60))
    up = np.concatenate([patch.taxels.normals for patch in skin.patches])[:, 2]
    assert (up > 0.9).sum() > 20
    assert (up < -0.9).sum() > 20
    finding = only(skin.findings, BOTH_SIDES)
    assert finding.where == robot.links[0].name
    assert "tactile-maps map MESH -o skin.csv" in finding.action
    flat = only(robot.findings, "flat-mesh")
    assert "can be touched" in flat.action


def test_remedy_gives_taxels_on_one_side(square, tmp_path):
    assert main(["map", str(square), "--taxels", "60", "-o", str(tmp_path / "skin.csv")]) == 0
    _, skin = load_robot_and_skin(scene_for_taxels(str(tmp_path / "skin.csv")))
    normals = np.concatenate([patch.taxels.normals for patch in skin.patches])
    assert len(normals) == 60
    np.testing.assert_allclose(normals, np.tile([0.0, 0.0, 1.0], (60, 1)), atol=1e-6)
    assert BOTH_SIDES not in kinds(skin.findings)


@pytest.mark.parametrize("name", ["moebius", "one triangle"])
def test_other_sheets_are_reported(name):
    skin = cover_robot(one_link(HARD_MESHES[name]), CoverSpec(taxels=60))
    assert only(skin.findings, BOTH_SIDES).where == "part"


@pytest.mark.parametrize("name", ["cube", "open tube", "soup", "hole", "fin", "slivers"])
def test_solids_and_shells_with_skin_outside_are_not_reported(name):
    skin = cover_robot(one_link(HARD_MESHES[name]), CoverSpec(taxels=60))
    assert BOTH_SIDES not in kinds(skin.findings)


def test_small_sheet_at_a_solid_is_not_reported(square):
    sheet = load_bare_mesh(square).links[0].mesh
    fin = moved(Mesh(sheet.vertices / 2, sheet.faces), (0.08, 0.0, 0.0))
    skin = cover_robot(one_link(joined(HARD_MESHES["sphere"], fin)), CoverSpec(taxels=200))
    assert BOTH_SIDES not in kinds(skin.findings)


def test_turned_triangles_of_an_open_shell_are_not_a_second_side():
    tube = HARD_MESHES["open tube"]
    faces = np.where((np.arange(len(tube.faces)) % 2 == 0)[:, None], tube.faces, tube.faces[:, ::-1])
    skin = cover_robot(one_link(Mesh(tube.vertices, faces)), CoverSpec(taxels=60))
    assert BOTH_SIDES not in kinds(skin.findings)
