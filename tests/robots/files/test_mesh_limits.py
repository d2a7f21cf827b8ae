"""Parts of mesh files that are removed before decoding do not change the shape."""

from __future__ import annotations

import json
import re
import struct

import numpy as np
import pytest
import trimesh
from trimesh.visual import TextureVisuals

from tactile_maps.core.errors import MeshError
from tactile_maps.robots.files import mesh_limits
from tactile_maps.robots.files.mesh_files import parse_mesh, read_mesh
from tactile_maps.robots.files.mesh_limits import reduced_glb, reduced_obj, reduced_stl
from tests.files.small_bombs import dae


def textured_scene():
    """Two boxes, one with a picture, at different places."""
    scene = trimesh.Scene()
    box = trimesh.creation.box()
    picture = TextureVisuals(uv=np.zeros((len(box.vertices), 2)))
    scene.add_geometry(trimesh.Trimesh(box.vertices, box.faces, visual=picture, process=False))
    scene.add_geometry(trimesh.creation.icosphere(1), transform=trimesh.transformations.translation_matrix([3, 0, 0]))
    return scene


def tree_of(data):
    (length,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20 : 20 + length])


def test_reduced_glb_contains_only_the_shape(tmp_path):
    data = textured_scene().export(file_type="glb")
    path = tmp_path / "a.glb"
    before = trimesh.load(trimesh.util.wrap_as_stream(data), file_type="glb", process=False).to_mesh()
    after = parse_mesh(data, path, weld=False)
    assert np.array_equal(after.faces, before.faces)
    assert np.allclose(after.vertices, before.vertices)
    whole = tree_of(data)
    tree = tree_of(reduced_glb(data, path))
    assert {"materials", "TEXCOORD_0"} <= {*whole, *whole["meshes"][0]["primitives"][0]["attributes"]}
    assert "materials" not in tree
    assert all(set(one["attributes"]) == {"POSITION"} for mesh in tree["meshes"] for one in mesh["primitives"])
    assert len(tree["accessors"]) == 4


def test_groups_beyond_the_limit_are_read_as_one(monkeypatch, tmp_path):
    monkeypatch.setattr(mesh_limits, "MAX_GROUPS", 2)
    corners = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    parts = b"".join(b"usemtl %d\nf 1 2 %d\n" % (n, 3 + n % 2) for n in range(4))
    path = tmp_path / "a.obj"
    assert reduced_obj(corners + parts[:24], path) == corners + parts[:24]
    assert b"usemtl" not in reduced_obj(corners + parts, path)
    assert len(parse_mesh(corners + parts, path).faces) == 4
    solid = (
        b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 %d\nendloop\n"
        b"endfacet\nendsolid a\n"
    )
    many = b"".join(solid % n for n in range(5))
    assert reduced_stl(many, path).count(b"endsolid") == 1
    assert len(parse_mesh(many, tmp_path / "a.stl").faces) == 5


def test_nodes_of_a_collada_file_count_each_time_they_are_shown(monkeypatch, tmp_path):
    twice = '<node id="a"><instance_geometry url="#g"/><instance_geometry url="#g"/></node>'
    data = dae('<node><instance_node url="#a"/></node><node><instance_node url="#a"/></node>', library=twice)
    assert len(parse_mesh(data, tmp_path / "a.dae", weld=False).faces) == 4
    monkeypatch.setattr(mesh_limits, "MAX_PARTS", 3)
    with pytest.raises(MeshError, match=r"a\.dae, parts: .*more than 3 parts \(found: 4\)"):
        parse_mesh(data, tmp_path / "a.dae")


@pytest.mark.parametrize(
    ("children", "rejected"),
    [
        ([[k + 1] for k in range(150)] + [[]], False),
        ([[k + 1] for k in range(300)] + [[]], True),
        ([[]] * 5000, False),
        ([[1], [0]], True),
        ([[0]], True),
        ([[1, 2], [2], []], False),
    ],
    ids=["deep", "too deep", "many", "in a ring", "in itself", "shown twice"],
)
def test_depth_of_nodes_is_limited(children, rejected, tmp_path):
    tree = {"asset": {"version": "2.0"}, "nodes": [{"children": numbers} for numbers in children], "meshes": []}
    if rejected:
        with pytest.raises(MeshError, match="contain themselves, or are more than 200 deep"):
            mesh_limits.reduced_gltf(json.dumps(tree).encode(), tmp_path / "a.gltf")
    else:
        assert mesh_limits.reduced_gltf(json.dumps(tree).encode(), tmp_path / "a.gltf")


@pytest.mark.parametrize(
    ("face", "line", "value"),
    [
        ("f 0 2 1", 5, "0"),
        ("f 0/1/1 2/1/1 1/1/1", 5, "0/1/1"),
        ("f 1 2 5", 5, "5"),
        ("f 1 2 -5", 5, "-5"),
        ("f 1 2 3 0", 5, "0"),
        ("f 1 2 \\\n  3 0", 6, "0"),
        ("f 1.5 2 1", 5, "1.5"),
    ],
)
def test_unknown_vertex_of_an_obj_file_is_named_with_its_line(tmp_path, face, line, value):
    path = tmp_path / "a.obj"
    path.write_text(f"{CORNERS}{face}\nf 1 2 4\n")
    with pytest.raises(MeshError, match=r"a face names a vertex that is not among the 4 of the file") as caught:
        read_mesh(path)
    assert (caught.value.file, caught.value.place, caught.value.value) == (path, f"line {line}", value)
    assert "Number vertices from 1" in caught.value.remedy


@pytest.mark.parametrize("face", ["f 1 2 -1", "f 1 2 \\\n  3", "f 1//1 2//1 3//1 4//1"])
def test_negative_vertex_numbers_and_continued_lines_are_read(tmp_path, face):
    path = tmp_path / "a.obj"
    path.write_text(f"{CORNERS}vn 0 0 1\n{face}\n")
    assert len(read_mesh(path).faces) == 1 + (face.count("//") == 4)


CORNERS = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"


@pytest.mark.parametrize("corner", ["0", "4", "4/1", "-4", "x", "1.0"])
def test_unknown_vertex_is_named_in_faces_of_all_notations(tmp_path, corner):
    path = tmp_path / "a.obj"
    for first in ("f 1/1 2//1 3/1/1", "f -3 -2 -1"):
        text = f"v 0 0 0\nv 1 0 0\nv 0 1 0\n{first}\nf 1 2 "
        assert reduced_obj(f"{text}3\n".encode(), path)
        with pytest.raises(MeshError, match=rf"line 5: .*found: {re.escape(corner)}"):
            reduced_obj(f"{text}{corner}\n".encode(), path)
