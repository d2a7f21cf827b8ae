"""URDF files and the package addresses in them."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

from tactile_maps.core.errors import RobotError, SkinError
from tactile_maps.robots.formats.urdf import load_urdf
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.skin.fitting.cover import cover_robot

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


def test_links_keep_their_names_and_joints_their_limits(urdf):
    robot = load_urdf(urdf("rod.stl"))
    assert [link.name for link in robot.links] == ["base", "rod"]
    assert [(j.name, j.lower, j.upper, j.slide) for j in robot.joints] == [("hinge", -1.0, 0.5, False)]
    assert robot.link("rod").mesh is not None
    assert np.ptp(robot.link("rod").mesh.vertices, axis=0) == pytest.approx([0.05, 0.05, 0.4])


def test_missing_mesh_is_replaced_by_a_small_box(urdf):
    robot = load_urdf(urdf("absent.stl"))
    assert robot.link("rod").mesh is not None
    assert any(f.kind == "missing-mesh" and f.where.endswith("absent.stl") for f in robot.findings)
    assert robot.link("rod").missing == ("absent",)
    assert load_urdf(urdf("rod.stl")).link("rod").missing == ()


def test_package_is_found_in_a_root_and_above_the_file(urdf, tmp_path, rod):
    path = urdf("package://two/urdf/rod.stl")
    assert "missing-mesh" not in {finding.kind for finding in load_urdf(path).findings}
    (tmp_path / "elsewhere" / "kit").mkdir(parents=True)
    (tmp_path / "elsewhere" / "kit" / "rod.stl").write_bytes(rod)
    path = urdf("package://kit/rod.stl")
    assert "missing-mesh" in {finding.kind for finding in load_urdf(path).findings}
    found = load_urdf(path, package_roots=[tmp_path / "elsewhere"])
    assert "missing-mesh" not in {finding.kind for finding in found.findings}


def test_collada_mesh_is_in_metres_and_at_its_node(urdf, tmp_path):
    path = urdf("part.dae")
    (path.parent / "part.dae").write_text(DAE)
    mesh = load_urdf(path).link("rod").mesh
    assert mesh is not None
    assert mesh.bounds == pytest.approx(np.array([[0, 0, 0.05], [0.1, 0.1, 0.15]]), abs=1e-6)


def test_scaled_and_mirrored_mesh_keeps_its_outside(urdf):
    path = urdf("rod.stl")
    path.write_text(path.read_text().replace('filename="rod.stl"', 'filename="rod.stl" scale="-2 1 1"'))
    mesh = load_urdf(path).link("rod").mesh
    assert mesh is not None
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx([0.1, 0.05, 0.4])
    centroids = mesh.vertices[mesh.faces].mean(axis=1)
    assert ((centroids * mesh.face_normals).sum(axis=1) > 0).all()


def test_mimic_joint_is_coupled_to_its_leader(urdf):
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


AGAIN = '<inertial><mass value="7"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
SPHERE = '<visual><geometry><sphere radius="0.0"/></geometry></visual>'
XACRO = ' xmlns:xacro="http://ros.org/wiki/xacro"><xacro:property name="half" value="0.25"/>'


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("old", "new", "kind", "where"),
    [
        ("</inertial>", f"</inertial>{AGAIN}", "repeated", "inertial of link rod"),
        ('xyz="0 0 0.3"', 'xyz="0, 0, 0.3 7"', "numbers", "xyz of origin: 0, 0, 0.3 7"),
        ("<robot ", '\0<robot xmlns="http://example.org/urdf" ', "xml-repaired", "two.urdf"),
        ('ixy="0"', 'ixy="0.02"', "inertia", "rod"),
        ('<link name="rod">', f'<link name="rod">{SPHERE}', "no-size", "visual of link rod"),
        ('name="two">', f'name="two"{XACRO}', "xacro", "two.urdf"),
        ('xyz="0 0 0.3"', 'xyz="$(optenv ROD_XYZ 0 0 0.3)"', "xacro", "two.urdf"),
        ("", "", "armature", "joints"),
        ("", "", "damping", "joints"),
    ],
)
def test_repaired_file_is_the_same_robot_with_a_finding(urdf, old, new, kind, where):
    path = urdf("rod.stl")
    usual = load_urdf(path)
    path.write_text(path.read_text().replace(old, new, 1) if old else path.read_text())
    robot = load_urdf(path)
    assert (robot.joints, [link.name for link in robot.links]) == (usual.joints, ["base", "rod"])
    assert Configuration(robot).poses() == pytest.approx(Configuration(usual).poses())
    assert 'mass="7"' not in robot.mjcf
    assert [finding.where.removeprefix(f"{path.parent}/") for finding in robot.findings if finding.kind == kind] == [
        where
    ]


def test_expressions_of_a_xacro_are_evaluated(urdf):
    path = urdf("rod.stl")
    text = path.read_text().replace('name="two">', f'name="two"{XACRO}').replace('upper="0.5"', 'upper="${3 * half}"')
    path.write_text(text)
    assert load_urdf(path).joints[0].upper == 0.75


@pytest.mark.parametrize(("text", "words"), [("<mujoco/>", "not URDF"), (None, "names no file")])
def test_other_xml_and_a_mesh_without_file_are_rejected(urdf, text, words):
    path = urdf("")
    if text:
        path.write_text(text)
    with pytest.raises(RobotError, match=words):
        load_urdf(path)


def test_mesh_with_a_broken_material_keeps_its_triangles(urdf):
    path = urdf("part.dae")
    common = '<technique_common><instance_material symbol="m" target="#nothing"/></technique_common>'
    broken = DAE.replace('<triangles count="4">', '<triangles count="4" material="m">').replace(
        '<instance_geometry url="#g"/>',
        f'<instance_geometry url="#g"><bind_material>{common}</bind_material></instance_geometry>',
    )
    (path.parent / "part.dae").write_text(broken)
    assert len(load_urdf(path).link("rod").mesh.faces) == 4


def test_link_with_a_missing_mesh_has_its_other_shapes(urdf):
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


@pytest.mark.parametrize(
    "address",
    [
        "../../../../../etc/passwd",
        "package://two/../../../etc/passwd",
        "package://../etc/passwd",
        "file:///etc/passwd",
        "/etc/passwd",
    ],
)
def test_addresses_out_of_the_package_are_rejected(urdf, address):
    with pytest.raises(RobotError) as caught:
        load_urdf(urdf(address))
    assert address in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('<mass value="1"/>', '<mass value="nan"/>', r"link rod, <mass> value: a value is not a number \(found: nan\)"),
        ('lower="-1"', 'lower="NaN"', r"joint hinge, <limit> lower: .*not a number \(found: NaN\).*finite number"),
        (
            '<axis xyz="0 1 0"/>',
            '<axis xyz="0 0 0"/>',
            r"joint hinge, axis: .*no direction \(found: 0 0 0\). Write a unit vector",
        ),
        ('<link name="base">', '<link name="rod"/><link name="base">', r"link rod: 2 links have the same name.*Rename"),
        ('<child link="rod"', '<child link="rodd"', r"joint hinge, child: .*not a link.*rodd.*Did you mean rod[?]"),
    ],
)
def test_invalid_number_axis_and_repeated_link_are_rejected_with_place_and_remedy(urdf, old, new, message):
    path = urdf("rod.stl")
    path.write_text(path.read_text().replace(old, new, 1))
    with pytest.raises(RobotError, match=rf"\.urdf, {message}"):
        load_urdf(path)


def test_oversized_mesh_is_reported_with_size_and_scale_and_is_not_covered(urdf, tmp_path):
    path = urdf("large.stl")
    trimesh.creation.box((50, 50, 400)).export(path.parent / "large.stl")
    robot = load_urdf(path)
    (finding,) = [finding for finding in robot.findings if finding.kind == "mesh-size"]
    assert finding.where == "rod"
    assert "mesh large is 406 m across; the joints of the robot span 0.3 m" in finding.action
    assert 'scale="0.001 0.001 0.001"' in finding.action
    with pytest.raises(SkinError, match=r'link rod: .*too large.*scale="0\.001 0\.001 0\.001"'):
        cover_robot(robot)
    path.write_text(path.read_text().replace('large.stl"', 'large.stl" scale="0.001 0.001 0.001"'))
    assert "mesh-size" not in {finding.kind for finding in load_urdf(path).findings}


@pytest.mark.parametrize(
    ("lower", "upper", "reported"), [("-90", "90", True), ("-6.2832", "6.2832", False), ("-90.5", "90", False)]
)
def test_range_of_several_turns_in_whole_numbers_is_reported_as_degrees(urdf, lower, upper, reported):
    path = urdf("rod.stl")
    path.write_text(re.sub(r'lower="[^"]*" upper="[^"]*"', f'lower="{lower}" upper="{upper}"', path.read_text()))
    found = [finding for finding in load_urdf(path).findings if finding.kind == "joint-range"]
    assert [finding.where for finding in found] == ["hinge (-90 to 90 rad)"] * reported
    assert all("If they are in degrees, state them in radians" in finding.action for finding in found)


@pytest.mark.parametrize(
    ("kinds", "units"),
    [
        (["revolute"], ["0.01 kg m²", "0.3 N m s/rad"]),
        (["prismatic"], ["0.01 kg", "0.3 N s/m"]),
        (["revolute", "prismatic"], ["0.01 kg m², and 0.01 kg for slides", "0.3 N m s/rad, and 0.3 N s/m for slides"]),
    ],
)
def test_units_of_added_dynamics_match_the_joints(urdf, kinds, units):
    path = urdf("rod.stl")
    text = path.read_text()
    joint = text[text.index("<joint") : text.index("</robot>")]
    link = '<link name="tip"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    further = (
        joint.replace("rod", "tip").replace("base", "rod").replace("hinge", "second").replace("revolute", kinds[-1])
    )
    text = text.replace("revolute", kinds[0])
    if len(kinds) > 1:
        text = text.replace("</robot>", f"{link}</inertial></link>{further}</robot>")
    path.write_text(text)
    notes = {finding.kind: finding.action for finding in load_urdf(path).findings}
    assert [
        notes["armature"].removeprefix("set to an armature of "),
        notes["damping"][len("set to a damping of ") :],
    ] == units


def test_gap_between_base_and_its_child_is_not_reported_as_overlap(urdf):
    path = urdf("rod.stl")
    path.write_text(path.read_text().replace('xyz="0 0 0.3"', 'xyz="0 0 0.5"'))
    assert "touching-links" not in {finding.kind for finding in load_urdf(path).findings}
