"""The shipped arm: its script gives the committed files, and its links are what skins need them to be."""

from __future__ import annotations

import runpy
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from app.robots.compile import compile_spec, robot_spec
from app.robots.configuration import Configuration
from app.robots.library import find_robot
from app.robots.robot import Link, Robot
from assets import asset

LINKS = ("base", "turret", "shoulder", "upper_arm", "elbow", "forearm", "wrist", "hand")


@pytest.fixture(scope="module")
def arm() -> Robot:
    return find_robot("arm")


def solid(link: Link) -> trimesh.Trimesh:
    assert link.mesh is not None
    return trimesh.Trimesh(link.mesh.vertices, link.mesh.faces, process=False)


def test_the_script_writes_the_committed_files_byte_for_byte(tmp_path: Path) -> None:
    folder = asset("robots", "arm")
    runpy.run_path(str(folder / "build_arm.py"))["build"](tmp_path)
    written = sorted(path.relative_to(tmp_path) for path in tmp_path.rglob("*") if path.is_file())
    assert len(written) == 9
    for path in written:
        assert (tmp_path / path).read_bytes() == (folder / path).read_bytes(), path


@pytest.mark.parametrize("name", LINKS)
def test_links_are_closed_and_agree_with_their_hulls_to_a_millimetre(arm: Robot, name: str) -> None:
    link = solid(arm.link(name))
    hull = link.convex_hull
    assert link.is_watertight
    assert link.is_winding_consistent
    assert link.euler_number == 2
    assert 0 < link.volume <= hull.volume * (1 + 1e-9)
    inside = -(link.vertices @ hull.face_normals.T - (hull.face_normals * hull.triangles[:, 0]).sum(1)).max(axis=1)
    assert inside.max() < 1e-3


@pytest.mark.parametrize("name", LINKS)
def test_triangles_are_well_shaped(arm: Robot, name: str) -> None:
    link = solid(arm.link(name))
    edges = np.linalg.norm(np.roll(link.triangles, -1, axis=1) - link.triangles, axis=2)
    quality = 4 * np.sqrt(3) * link.area_faces / (edges**2).sum(axis=1)
    assert quality.min() > 0.6


def test_neighbours_touch_by_a_few_millimetres_at_any_posture(arm: Robot) -> None:
    spec = robot_spec(arm)
    for exclude in list(spec.excludes):
        spec.delete(exclude)
    model = compile_spec(spec, source="arm")
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_FILTERPARENT
    data = mujoco.MjData(model)
    rng = np.random.default_rng(0)
    for _ in range(20):
        data.qpos[:] = rng.uniform(model.jnt_range[:, 0], model.jnt_range[:, 1])
        mujoco.mj_forward(model, data)
        bodies = np.sort(model.geom_bodyid[data.contact.geom], axis=1)
        joined = {(int(a), int(b)): float(d) for (a, b), d in zip(bodies, data.contact.dist, strict=True) if b == a + 1}
        assert set(joined) == {(i, i + 1) for i in range(1, 8)}
        assert min(joined.values()) > -0.006


def test_reach_and_mass_are_those_of_a_real_arm(arm: Robot) -> None:
    configuration = Configuration(arm)
    configuration.update(np.zeros(7))
    hand = arm.link("hand").mesh
    assert hand is not None
    tip = configuration.pose("hand").points(hand.vertices)[:, 2].max()
    assert 0.85 < tip - configuration.pose("shoulder").translation[2] < 1.0
    mass = compile_spec(robot_spec(arm), source="arm").body_mass.sum()
    assert 15 < mass < 30


def test_committed_files_stay_small() -> None:
    assert (
        sum(path.stat().st_size for path in asset("robots", "arm").rglob("*") if path.suffix in (".obj", ".xml")) < 1e6
    )
