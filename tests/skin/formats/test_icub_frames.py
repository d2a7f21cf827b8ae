"""Frames of iCub's positions files, and folders of them on the robot; real files where they are at hand."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tactile_maps.cli.shared.scenes import scene_from_arguments
from tactile_maps.core.errors import SkinError
from tactile_maps.robots.files.mesh_files import box_mesh
from tactile_maps.robots.library import icub_folder, load_robot
from tactile_maps.scene.scene_file import load_scene, scene_for_taxels
from tactile_maps.skin.fitting.frame_match import carrying_link, match_frame
from tactile_maps.skin.formats.icub.frames import _FRAMES, icub_frames
from tactile_maps.skin.formats.icub.positions import read_icub_positions
from tactile_maps.skin.formats.import_skin import TaxelFile
from tests.skin.formats.test_icub_positions import module, positions_file
from tests.support.example_robots import two_rods
from tests.support.findings import by_kind, kinds
from tests.support.real_icub import POSITIONS, needs_files, needs_icub

OLDER = ("left_forearm_mesh", "left_forearm_nomesh", "right_forearm_mesh", "right_forearm_nomesh")
"""Robot with a forearm whose cover differs from that of the model."""


FILES = {
    "upper_arm": "arm",
    "forearm": "forearm_V2",
    "hand": "hand_V2_1",
    "upper_leg": "leg_upper",
    "lower_leg": "leg_lower",
    "foot": "foot",
}
"""File with the closest fit to each link, without its side."""


@pytest.fixture(scope="module")
def whole():
    if icub_folder() is None:
        pytest.skip("the wheel icub-models is not installed")
    return load_robot("icub_whole")


@needs_files
@needs_icub
@pytest.mark.parametrize(("file", "count"), [("left_arm.txt", 350), ("left_forearm_V2.txt", 148)])
def test_icub_is_covered_with_its_real_taxels(file, count):
    skin = TaxelFile(POSITIONS / file).skin(load_robot("icub"))
    assert len(skin) == count
    for patch in skin.patches:
        assert (patch.taxels.areas > 0).all()
        assert patch.taxels.areas.sum() <= patch.surface.area
    assert max(len(patch.taxels) for patch in skin.patches) > 100
    assert ("taxel-frame" in kinds(skin.findings)) == (file == "left_forearm_V2.txt")


def test_folder_covers_each_link_with_the_closest_file(tmp_path):
    far = [" ".join([f"{1.1 * float(row.split()[0]):.5f}", *row.split()[1:]]) for row in module(1)]
    for name, rows, link in (("near", module(), "upper"), ("far", far, "upper"), ("lost", module(), "tail")):
        positions_file(tmp_path, rows, header=f"name {link}\n").rename(tmp_path / f"{name}.txt")
    (tmp_path / "README.md").write_text("not a positions file")
    skin = TaxelFile(tmp_path).skin(two_rods(), thickness=0.002)
    assert [(patch.link, len(patch.taxels)) for patch in skin.patches] == [("upper", 10)]
    found = {(f.kind, f.where): f.count for f in skin.findings}
    assert found["other-calibration", "far.txt"] == 10
    assert ("link-missing", "lost.txt") in found


def test_first_file_of_a_folder_is_used_where_the_mesh_of_its_link_is_missing(tmp_path):
    for name in ("second", "first"):
        positions_file(tmp_path, module(), header="name upper\n").rename(tmp_path / f"{name}.txt")
    robot = two_rods()
    links = tuple(replace(link, mesh=box_mesh(0.02), missing=("rod",)) for link in robot.links)
    skin = TaxelFile(tmp_path).skin(replace(robot, links=links))
    found = by_kind(skin.findings)
    assert found["stated-places"].count == len(skin) == 10
    assert found["other-calibration"].where == "second.txt"
    assert "the mesh of the link upper is missing, and first.txt is the first file" in found["other-calibration"].action


def test_folder_without_a_file_for_the_robot_is_rejected(tmp_path):
    with pytest.raises(SkinError, match="no file in the folder.*found: 0.*base, upper"):
        TaxelFile(tmp_path).skin(two_rods())
    with pytest.raises(SkinError, match="needs a robot"):
        TaxelFile(tmp_path).skin()


def test_robot_without_icub_links_has_no_icub_frames():
    assert icub_frames(two_rods(), "upper") == {}


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.robots
@needs_icub
@pytest.mark.parametrize(
    ("link", "frame"),
    [("chest", "torso (third DH link)"), ("r_upper_arm", "elbow (DH)"), ("l_upper_arm", "elbow (DH)")],
)
def test_positions_in_a_documented_frame_are_moved_onto_the_link(whole, link, frame):
    frames = icub_frames(whole, link)
    mesh = whole.link(link).mesh
    assert mesh is not None
    stated = frames[frame].inverse.points(mesh.vertices[::37])
    match = match_frame(whole, link, stated, frames=frames)
    assert (match.name, np.quantile(match.away, 0.95) < 1e-6) == (frame, True), "some vertices are inside the shoulder"
    assert match_frame(whole, link, stated).median > 0.005, "they are not stated in a frame of the URDF"


@pytest.mark.long
@pytest.mark.robots
@needs_icub
def test_elbows_are_mirror_images(whole):
    """The documented chains of both arms, checked against each other and against the wrist of the URDF."""
    left, right = (icub_frames(whole, f"{side}_upper_arm")["elbow (DH)"] for side in "lr")
    assert np.linalg.det(left.rotation) == pytest.approx(1)
    np.testing.assert_allclose(left.translation * [1, -1, 1], right.translation, atol=3e-4)


@needs_files
@needs_icub
@pytest.mark.parametrize("file", sorted(POSITIONS.glob("*.txt")) or [Path("none")], ids=lambda file: file.stem)
def test_every_real_file_is_close_to_its_link(whole, file):
    taxels = read_icub_positions(file)
    link = carrying_link(whole, taxels.link, file)
    match = match_frame(whole, link, taxels.positions, frames=icub_frames(whole, link))
    limit = 0.0075 if file.stem in OLDER or "foot" in file.stem else 0.002  # the feet's skin is inside their sole
    assert match.median < limit
    assert np.quantile(match.away, 0.95) < 2 * limit + 0.002


@pytest.mark.long
@needs_files
@needs_icub
def test_whole_real_skin_keeps_its_ids(whole):
    skin = TaxelFile(POSITIONS).skin(whole)
    assert len(skin) == 4077
    assert len({patch.link for patch in skin.patches}) == 13
    for link, file in (
        *((f"{side[0]}_{link}", f"{side}_{file}") for side in ("left", "right") for link, file in FILES.items()),
        ("chest", "torso"),
    ):
        ids = [patch.taxels.identity.ids for patch in skin.patches if patch.link == link]
        stated = read_icub_positions(POSITIONS / f"{file}.txt").ids
        assert stated is not None
        assert sorted(np.concatenate(ids)) == sorted(stated)


@needs_files
@needs_icub
def test_real_torso_file_uses_the_documented_frame():
    skin = TaxelFile(POSITIONS / "torso.txt").skin(load_robot("icub"))
    assert len(skin) == 373
    found = {finding.kind: finding.action for finding in skin.findings}
    assert "third DH link" in found["taxel-frame"]
    assert found["taxel-distance"].startswith("moved onto the cover from 0.7 mm")


@pytest.mark.parametrize(
    ("file", "link", "robot"),
    [
        ("left_arm", "l_upper_arm", "icub"),
        ("left_arm", "upper_arm", "icub"),
        ("torso", "chest", "icub"),
        ("right_arm", "upper_arm", "icub_whole"),
        ("x", "r_hand", "icub_whole"),
        ("left_foot", "l_foot", "icub_whole"),
        ("left_leg", "lower_leg", "icub_whole"),
    ],
)
def test_only_links_of_the_model_get_their_icub_files(tmp_path, file, link, robot):
    path = positions_file(tmp_path, module(), header=f"name {link}\n").rename(tmp_path / f"{file}.txt")
    assert scene_for_taxels(str(path)).robot == robot
    assert scene_for_taxels(str(tmp_path)).robot == "icub_whole"


def test_elbow_frames_of_both_arms_have_mirrored_origins():
    left = _FRAMES["l_upper_arm"]["elbow (DH)"].translation
    right = _FRAMES["r_upper_arm"]["elbow (DH)"].translation
    assert left * [1, -1, 1] == pytest.approx(right, abs=1e-9)


def test_folder_of_files_replaces_the_cover_of_the_whole_icub(tmp_path):
    scene = scene_from_arguments(argparse.Namespace(scene="icub_whole", skin=[str(tmp_path)]))
    assert (scene.robot, scene.taxel_files, scene.cover.links) == ("icub_whole", (str(tmp_path),), ())
    with pytest.raises(SkinError, match="does not exist"):
        scene_from_arguments(argparse.Namespace(scene="icub_whole", skin=[str(tmp_path / "gone")]))


def test_scene_may_name_a_folder_next_to_it(tmp_path):
    (tmp_path / "positions").mkdir()
    (tmp_path / "arm").mkdir()
    (tmp_path / "own.toml").write_text("robot = 'arm'\ntaxel_file = 'positions'\n")
    scene = load_scene(str(tmp_path / "own.toml"))
    assert (scene.robot, scene.taxel_files) == ("arm", (str(tmp_path / "positions"),))
