"""The shipped pair of arms: its script gives the committed file, it shares the arm's meshes, and nothing touches."""

from __future__ import annotations

import runpy
from pathlib import Path

import mujoco
import numpy as np

from app.robots.compile import compile_spec, robot_spec
from app.robots.configuration import Configuration
from app.robots.library import find_robot
from assets import asset


def test_the_script_writes_the_committed_file_byte_for_byte(tmp_path: Path) -> None:
    folder = asset("robots", "two_arms")
    runpy.run_path(str(folder / "build_two_arms.py"))["build"](tmp_path)
    assert (tmp_path / "two_arms.xml").read_bytes() == (folder / "two_arms.xml").read_bytes()
    assert sorted(path.name for path in folder.iterdir() if path.is_file()) == ["build_two_arms.py", "two_arms.xml"]


def test_each_arm_is_the_single_arm() -> None:
    one, two = find_robot("arm"), find_robot("two_arms")
    assert two.assets.keys() == one.assets.keys()
    assert not two.findings
    for side in ("left", "right"):
        assert [joint.name for joint in two.joints if joint.name.startswith(side)] == [
            f"{side}_{joint.name}" for joint in one.joints
        ]
        for link in one.links:
            mine = two.link(f"{side}_{link.name}").mesh
            assert mine is not None
            assert link.mesh is not None
            assert np.array_equal(mine.vertices, link.mesh.vertices)
    alone, pair = Configuration(one), Configuration(two)
    pair.update(np.tile(one.home, 2))
    apart = pair.pose("left_hand").translation - alone.pose("hand").translation
    assert np.allclose(apart, [0.0, 0.25, 0.01], atol=1e-6)


def test_nothing_touches_at_home() -> None:
    robot = find_robot("two_arms")
    model = compile_spec(robot_spec(robot), source="two_arms")
    data = mujoco.MjData(model)
    data.qpos[:] = robot.home
    mujoco.mj_forward(model, data)
    assert model.ngeom > 16
    assert not (data.contact.dist < 0).any()
