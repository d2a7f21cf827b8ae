"""URDF files and the package addresses in them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tactile_maps.core.errors import RobotError
from tactile_maps.robots.formats.urdf import load_urdf
from tactile_maps.robots.kinematics import Configuration

Write = Callable[[str], Path]

DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.001"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="12">0 0 0 100 0 0 0 100 0 0 0 100</float_array><technique_common>
<accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><translate>0 0 50</translate><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene>
</COLLADA>
"""


def test_links_keep_their_names_and_joints_their_limits(urdf: Write) -> None:
    robot = load_urdf(urdf("rod.stl"))
    assert [link.name for link in robot.links] == ["base", "rod"]
    assert [(j.name, j.lower, j.upper, j.slide) for j in robot.joints] == [("hinge", -1.0, 0.5, False)]
    assert robot.link("rod").mesh is not None
    assert np.ptp(robot.link("rod").mesh.vertices, axis=0) == pytest.approx([0.05, 0.05, 0.4])


def test_missing_armature_and_damping_are_set_and_reported(urdf: Write) -> None:
    robot = load_urdf(urdf("rod.stl"))
    assert {"armature", "damping"} <= {finding.kind for finding in robot.findings}
    assert Configuration(robot).inertia()[0] > 0.01


def test_missing_mesh_is_replaced_by_a_small_box(urdf: Write) -> None:
    robot = load_urdf(urdf("absent.stl"))
    assert robot.link("rod").mesh is not None
    assert any(f.kind == "missing-mesh" and f.where.endswith("absent.stl") for f in robot.findings)
    assert robot.link("rod").missing == ("absent",)
    assert load_urdf(urdf("rod.stl")).link("rod").missing == ()


def test_package_is_found_in_a_root_and_above_the_file(urdf: Write, tmp_path: Path, rod: bytes) -> None:
    path = urdf("package://two/urdf/rod.stl")
    assert "missing-mesh" not in {finding.kind for finding in load_urdf(path).findings}
    (tmp_path / "elsewhere" / "kit").mkdir(parents=True)
    (tmp_path / "elsewhere" / "kit" / "rod.stl").write_bytes(rod)
    path = urdf("package://kit/rod.stl")
    assert "missing-mesh" in {finding.kind for finding in load_urdf(path).findings}
    found = load_urdf(path, package_roots=[tmp_path / "elsewhere"])
    assert "missing-mesh" not in {finding.kind for finding in found.findings}


def test_collada_mesh_is_in_metres_and_at_its_node(urdf: Write, tmp_path: Path) -> None:
    path = urdf("part.dae")
    (path.parent / "part.dae").write_text(DAE)
    mesh = load_urdf(path).link("rod").mesh
    assert mesh is not None
    assert mesh.bounds == pytest.approx(np.array([[0, 0, 0.05], [0.1, 0.1, 0.15]]), abs=1e-6)


def test_scaled_and_mirrored_mesh_keeps_its_outside(urdf: Write) -> None:
    path = urdf("rod.stl")
    path.write_text(path.read_text().replace('filename="rod.stl"', 'filename="rod.stl" scale="-2 1 1"'))
    mesh = load_urdf(path).link("rod").mesh
    assert mesh is not None
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx([0.1, 0.05, 0.4])
    centroids = mesh.vertices[mesh.faces].mean(axis=1)
    assert ((centroids * mesh.face_normals).sum(axis=1) > 0).all()


def test_mimic_joint_is_coupled_to_its_leader(urdf: Write) -> None:
    path = urdf("rod.stl")
    follower = """<link name="tip"><inertial><mass value="1"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="second" type="revolute"><parent link="rod"/><child link="tip"/><axis xyz="0 1 0"/>
      <limit lower="-1" upper="1" effort="1" velocity="1"/><mimic joint="LEADER" multiplier="2"/></joint></robot>"""
    text = path.read_text()
    path.write_text(text.replace("</robot>", follower.replace("LEADER", "hinge")))
    robot = load_urdf(path)
    assert "mimic-joints" in {finding.kind for finding in robot.findings}
    assert 'joint1="second"' in robot.mjcf
    assert 'joint2="hinge"' in robot.mjcf
    for leader in ("nobody", "second"):
        path.write_text(text.replace("</robot>", follower.replace("LEADER", leader)))
        robot = load_urdf(path)
        (left,) = [finding for finding in robot.findings if finding.kind == "mimic-left-out"]
        assert left.where == f"second of {leader}"
        assert "joint1" not in robot.mjcf


def test_repeated_element_is_ignored_and_reported(urdf: Write) -> None:
    path = urdf("rod.stl")
    again = '<inertial><mass value="7"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    text = path.read_text()
    path.write_text(again.join(text.rsplit("</link>", 1)))
    robot = load_urdf(path)
    assert [finding.where for finding in robot.findings if finding.kind == "repeated"] == ["inertial of link rod"]
    assert 'mass="7"' not in robot.mjcf


def test_invalid_numbers_shapes_without_size_and_impossible_inertias_are_repaired(urdf: Write) -> None:
    path = urdf("rod.stl")
    text = path.read_text().replace('xyz="0 0 0.3"', 'xyz="0, 0, 0.3 7"').replace('ixy="0"', 'ixy="0.02"')
    sphere = '<visual><geometry><sphere radius="0.0"/></geometry></visual>'
    path.write_text(text.replace('<link name="rod">', f'<link name="rod">{sphere}'))
    robot = load_urdf(path)
    kinds = {finding.kind: finding.where for finding in robot.findings}
    assert (kinds["numbers"], kinds["no-size"], kinds["inertia"]) == (
        "xyz of origin: 0, 0, 0.3 7",
        "visual of link rod",
        "rod",
    )
    assert Configuration(robot).pose("rod").points(np.zeros(3)) == pytest.approx([0, 0, 0.3])


def test_mesh_with_a_broken_material_keeps_its_triangles(urdf: Write) -> None:
    path = urdf("part.dae")
    common = '<technique_common><instance_material symbol="m" target="#nothing"/></technique_common>'
    broken = DAE.replace('<triangles count="4">', '<triangles count="4" material="m">').replace(
        '<instance_geometry url="#g"/>',
        f'<instance_geometry url="#g"><bind_material>{common}</bind_material></instance_geometry>',
    )
    (path.parent / "part.dae").write_text(broken)
    assert len(load_urdf(path).link("rod").mesh.faces) == 4


def test_remaining_expression_of_xacro_is_evaluated(urdf: Write) -> None:
    path = urdf("rod.stl")
    path.write_text(path.read_text().replace('xyz="0 0 0.3"', 'xyz="$(optenv ROD_XYZ 0 0 0.4)"'))
    assert Configuration(load_urdf(path)).pose("rod").points(np.zeros(3)) == pytest.approx([0, 0, 0.4])


def test_link_with_a_missing_mesh_has_its_other_shapes(urdf: Write) -> None:
    path = urdf("absent.stl")
    box = '<collision><geometry><box size="0.1 0.1 0.3"/></geometry></collision><visual>'
    head, tail = path.read_text().rsplit("<visual>", 1)
    path.write_text(
        head + box + tail.replace('filename="absent.stl"', 'filename="absent.stl" scale="0.001 0.001 0.001"')
    )
    robot = load_urdf(path)
    assert np.ptp(robot.link("rod").mesh.vertices, axis=0) == pytest.approx([0.1, 0.1, 0.3])
    (missing,) = [finding for finding in robot.findings if finding.kind == "missing-mesh"]
    assert "(link rod); left out" in missing.action
    (left_out,) = robot.link("rod").left_out
    assert np.ptp(left_out.vertices, axis=0) == pytest.approx([0.02] * 3)
    path.write_text(path.read_text().replace(box, "<visual>"))
    robot = load_urdf(path)
    assert np.ptp(robot.link("rod").mesh.vertices, axis=0) == pytest.approx([0.02] * 3), "whatever the mesh's scale"
    (missing,) = [finding for finding in robot.findings if finding.kind == "missing-mesh"]
    assert "small box" in missing.action
    assert robot.link("rod").left_out == ()


def test_default_namespace_is_removed_and_document_repaired(urdf: Write) -> None:
    path = urdf("rod.stl")
    path.write_bytes(path.read_bytes().replace(b"<robot ", b'<robot xmlns="http://example.org/urdf" ') + b"\0")
    robot = load_urdf(path)
    assert [link.name for link in robot.links] == ["base", "rod"]
    assert "xml-repaired" in {finding.kind for finding in robot.findings}


def test_xacro_is_expanded_and_other_xml_is_rejected(urdf: Write) -> None:
    path = urdf("rod.stl")
    text = path.read_text().replace('<robot name="two">', '<robot name="two" xmlns:xacro="http://ros.org/wiki/xacro">'
                                    '<xacro:property name="half" value="0.25"/>')  # fmt: skip
    path.write_text(text.replace('upper="0.5"', 'upper="${2 * half}"'))
    robot = load_urdf(path)
    assert [(joint.lower, joint.upper) for joint in robot.joints] == [(-1.0, 0.5)]
    assert "xacro" in {finding.kind for finding in robot.findings}
    path.write_text("<mujoco/>")
    with pytest.raises(RobotError, match="not URDF"):
        load_urdf(path)


def test_mesh_without_a_file_is_rejected(urdf: Write) -> None:
    with pytest.raises(RobotError, match="names no file"):
        load_urdf(urdf(""))


@pytest.mark.parametrize("address", ["../../../../../etc/passwd", "package://two/../../../etc/passwd",
                                     "package://../etc/passwd", "file:///etc/passwd", "/etc/passwd"])  # fmt: skip
def test_addresses_out_of_the_package_are_rejected(urdf: Write, address: str) -> None:
    with pytest.raises(RobotError) as caught:
        load_urdf(urdf(address))
    assert address in str(caught.value)
