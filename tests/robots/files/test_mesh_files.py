"""Mesh files of every format, and the meshes of one robot gathered."""

from __future__ import annotations

import base64
import json
import re
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh

from tactile_maps.core.errors import Finding, MeshError, RobotError, TactileMapsError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.files import mesh_files
from tactile_maps.robots.files.mesh_files import (
    MESH_SUFFIXES,
    AssetStore,
    box_mesh,
    parse_mesh,
    placeholder,
    read_mesh,
    read_mesh_in_metres,
    split_scale,
    to_metres,
    to_msh,
)


def _gltf(box: trimesh.Trimesh, path: Path, *, inside: bool) -> None:
    files = trimesh.exchange.gltf.export_gltf(trimesh.Scene(box))
    tree = json.loads(files.pop("model.gltf"))
    for number, (buffer, data) in enumerate(zip(tree["buffers"], files.values(), strict=True)):
        if inside:
            buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
        else:
            (path.parent / f"part {number}.bin").write_bytes(data)
            buffer["uri"] = f"part%20{number}.bin"
    path.write_text(json.dumps(tree))


def _big_endian_ply(box: trimesh.Trimesh, path: Path) -> None:
    header = "ply\nformat binary_big_endian 1.0\nelement vertex 8\nproperty double x\nproperty double y\n"
    header += "property double z\nelement face 12\nproperty list uchar int vertex_indices\nend_header\n"
    rows = b"".join(struct.pack(">B3i", 3, *face) for face in box.faces.tolist())
    path.write_bytes(header.encode() + box.vertices.astype(">f8").tobytes() + rows)


def _quads(_box: trimesh.Trimesh, path: Path) -> None:
    """Write polygons with negative indices, normals and texture coordinates, as modelling programs do."""
    corners = [(x, y, z) for x in (0, 1) for y in (0, 2) for z in (0, 3)]
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    lines = ["# comment", "mtllib none.mtl", "o box", *(f"v {x} {y} {z}" for x, y, z in corners), "vt 0 0", "vn 0 0 1"]
    lines += ["usemtl red", *("f " + " ".join(f"{k - 8}/1/1" for k in side) for side in sides)]
    path.write_text("\n".join(lines))


FORMATS = {
    "plain.obj": lambda box, path: box.export(path),
    "quads.obj": _quads,
    "binary.stl": lambda box, path: box.export(path),
    "ascii.stl": lambda box, path: box.export(path, file_type="stl_ascii"),
    "binary.ply": lambda box, path: box.export(path),
    "ascii.ply": lambda box, path: box.export(path, encoding="ascii"),
    "big.ply": _big_endian_ply,
    "plain.off": lambda box, path: box.export(path),
    "scene.glb": lambda box, path: box.export(path),
    "separate.gltf": lambda box, path: _gltf(box, path, inside=False),
    "inside.gltf": lambda box, path: _gltf(box, path, inside=True),
    "scene.dae": lambda box, path: box.export(path),
    "CAPITALS.STL": lambda box, path: path.write_bytes(box.export(file_type="stl")),
    "mujoco.msh": lambda box, path: path.write_bytes(to_msh(Mesh(box.vertices, box.faces))),
}


@pytest.mark.parametrize("name", FORMATS)
def test_formats_agree_and_corners_are_shared(tmp_path, name):
    path = tmp_path / name
    FORMATS[name](trimesh.creation.box((1, 2, 3)), path)
    mesh = read_mesh(path)
    assert (len(mesh.vertices), len(mesh.faces)) == (8, 12)
    assert mesh.area == pytest.approx(22)
    corners = mesh.vertices[mesh.faces] - mesh.bounds.mean(axis=0)
    assert np.linalg.det(corners).sum() / 6 == pytest.approx(6), "and its faces look outward"


def test_every_format_is_tested():
    assert {Path(name).suffix.lower() for name in FORMATS} == set(MESH_SUFFIXES)


def test_collada_states_its_unit(tmp_path):
    path = tmp_path / "box.dae"
    trimesh.creation.box((100, 200, 300)).export(path)
    text = path.read_text()
    assert "<asset>" in text
    path.write_text(text.replace("<asset>", '<asset><unit name="millimeter" meter="0.001"/>', 1))
    assert np.ptp(read_mesh(path).vertices, axis=0) == pytest.approx([0.1, 0.2, 0.3])


def test_scene_with_several_parts_is_one_mesh(tmp_path):
    scene = trimesh.Scene()
    for number in range(3):
        scene.add_geometry(
            trimesh.creation.box((1, 1, 1)), transform=trimesh.transformations.translation_matrix([2 * number, 0, 0])
        )
    scene.export(tmp_path / "row.glb")
    mesh = read_mesh(tmp_path / "row.glb")
    assert len(mesh.faces) == 36
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx([5, 1, 1])


@pytest.mark.parametrize("named", ["../outside.bin", "/etc/hostname", "missing.bin"])
def test_gltf_buffers_outside_the_folder_are_rejected(tmp_path, named):
    (tmp_path / "outside.bin").write_bytes(bytes(1000))
    inner = tmp_path / "inner"
    inner.mkdir()
    _gltf(trimesh.creation.box((1, 2, 3)), inner / "box.gltf", inside=False)
    tree = json.loads((inner / "box.gltf").read_text())
    tree["buffers"][0]["uri"] = named
    (inner / "box.gltf").write_text(json.dumps(tree))
    with pytest.raises(TactileMapsError, match="leaves the robot|no such file"):
        read_mesh(inner / "box.gltf")


@pytest.mark.parametrize(("scale", "kinds"), [(1.0, []), (300.0, ["units"]), (1e-5, ["units"])])
def test_unit_is_assumed_from_the_size_and_reported(scale, kinds):
    mesh = box_mesh(scale)
    metres, findings = to_metres(mesh, where="box.stl")
    assert [(finding.kind, finding.where) for finding in findings] == [(kind, "box.stl") for kind in kinds]
    assert metres.size == pytest.approx(mesh.size * (1e-3 if scale > 10 else 1.0))
    assert (metres is mesh) == (scale <= 10)


def test_box_is_closed_with_outward_faces():
    corners = box_mesh(0.5).corners
    volumes = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    np.testing.assert_allclose(volumes, 0.5**3 / 12)


def test_body_far_from_the_origin_is_reported():
    mesh = box_mesh(1.0)
    there = Mesh(mesh.vertices + [1e6, 0, 0], mesh.faces)
    same, findings = to_metres(there, where="box.stl")
    assert same is there
    assert [finding.kind for finding in findings] == ["far-away"]


TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"


@pytest.mark.parametrize(
    ("lines", "count", "line"),
    [
        ("f 1 2", 1, 9),
        ("f\n\nf 3", 2, 9),
        ("vt 0 0\nf 1/1 2/1", 1, 10),
        ("f 1 2 # 3", 1, 9),
        ("\tf 1 2", 1, 9),
        ("f 1 2 \\\n3 4\nf 1 \\\n2", 1, 11),
        ("f 1 2 3 4\r\nf 1 2\r\n", 1, 10),
        ("l 1 2\nf 1 2 3 4", 0, 0),
    ],
)
def test_faces_with_fewer_than_three_corners_are_findings(tmp_path, lines, count, line):
    path = _made(tmp_path / "pad.obj", (TETRAHEDRON + lines + "\n").encode())
    store = AssetStore()
    store.add(path)
    for findings, where in ((read_mesh_in_metres(path, where="pad")[1], "pad"), (store.findings, str(path))):
        action = f"fewer than three corners, dropped; the first is in line {line}"
        assert list(findings) == [Finding("short-face", where, action, count)][:count]


@pytest.mark.parametrize("face", ["f 1 2 3 # top", "\tf 1 2 3", " f 1 2 3", "f\t1\t2\t3", "f 1 2 3 4 # top"])
def test_faces_with_comments_tabs_and_indents_are_read(tmp_path, face):
    path = _made(tmp_path / "pad.obj", f"{TETRAHEDRON}{face}\n".encode())
    assert len(read_mesh(path).faces) == 4 + face.count(" 4") + 1


def test_format_of_mujoco_keeps_vertices_and_faces():
    mesh = box_mesh(0.5)
    again = parse_mesh(to_msh(mesh), Path("box.msh"))
    assert np.array_equal(again.faces, mesh.faces)
    assert np.array_equal(again.vertices, mesh.vertices)


NAN_STL = bytes(80) + struct.pack("<I", 1) + struct.pack("<12f", 0, 0, 1, np.nan, 0, 0, 1, 0, 0, 0, 1, 0) + bytes(2)
BROKEN = {
    "nan.stl": NAN_STL,
    "empty.stl": bytes(80) + struct.pack("<I", 0),
    "nothing.stl": b"",
    "liar.stl": bytes(80) + struct.pack("<I", 2**31),
    "points.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\n",
    "outside.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
    "nan.obj": b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "huge.obj": b"v 1e300 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "words.obj": b"v a b c\nf 1 2 3\n",
    "absurd.ply": b"ply\nformat binary_little_endian 1.0\nelement vertex 999999999999\nproperty float x\n"
    b"property float y\nproperty float z\nend_header\n",
    "text.ply": b"not a ply",
    "list.ply": b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    b"element face 1\nproperty list uchar int corners\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    "columns.ply": b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
    b"property uchar red\nend_header\n0 0 0\n",
    "points.ply": b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
    b"end_header\n0 0 0\n",
    "short.off": b"OFF\n3 1 0\n0 0 0\n",
    "noise.glb": b"glTF" + bytes(20),
    "noise.gltf": bytes(range(256)),
    "list.gltf": b"[1, 2]",
    "cut.gltf": b"{",
    "no positions.gltf": b'{"asset": {"version": "2.0"}, "meshes": [{"primitives": [{"attributes": {}}]}], '
    b'"nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}]}',
    "liar.gltf": b'{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 9e18}], "meshes": [{}]}',
    "plain.dae": b"<COLLADA/>",
    "bomb.dae": b'<!DOCTYPE a [<!ENTITY x "y">]><COLLADA>&x;</COLLADA>',
    "unit.dae": b'<COLLADA><asset><unit meter="nan"/></asset></COLLADA>',
    "absurd.msh": struct.pack("<4i", 2**30, 0, 0, 2**30),
    "negative.msh": struct.pack("<4i", -1, 0, 0, 1),
    "outside.msh": struct.pack("<4i", 1, 0, 0, 1) + bytes(12) + struct.pack("<3i", 0, 0, 7),
    "model.step": b"ISO-10303-21;",
}


POINTER = b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 123456\n"


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_are_rejected_by_name(name):
    with pytest.raises(Exception, match=name.replace(".", r"\.")) as caught:
        parse_mesh(BROKEN[name], Path(name))
    assert type(caught.value).__name__ in ("MeshError", "RobotError")
    assert not re.search(r"Error\b|object has no|local variable", str(caught.value)), "nothing of the parser's own"


def test_unreadable_mesh_states_the_possible_reasons():
    with pytest.raises(MeshError, match=r"link\.stl: .*Git LFS pointer.*git lfs pull"):
        parse_mesh(POINTER, Path("link.stl"))
    with pytest.raises(MeshError, match=r"list\.ply: .*has no triangles.*PLY.*with its triangles"):
        parse_mesh(BROKEN["list.ply"], Path("list.ply"))
    with pytest.raises(MeshError, match=r"cut\.gltf, line 1: "):
        parse_mesh(BROKEN["cut.gltf"], Path("cut.gltf"))


def test_too_many_triangles_are_rejected(monkeypatch):
    monkeypatch.setattr(mesh_files, "MAX_FACES", 11)
    with pytest.raises(MeshError, match="5 million"):
        parse_mesh(to_msh(box_mesh(1.0)), Path("box.msh"))


def test_file_is_read_once_and_a_variant_has_its_own_name(tmp_path, rod):
    (tmp_path / "rod.stl").write_bytes(rod)
    store = AssetStore()
    names = [store.add(tmp_path / "rod.stl"), store.add(tmp_path / "rod.stl")]
    assert names == ["rod.msh", "rod.msh"]
    assert store.add(tmp_path / "rod.stl", variant="2 2 2") == "rod_2.msh"
    assert store.files["rod.msh"] == store.files["rod_2.msh"]
    assert store.findings == []


COLLADA = b'<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset/>%b</COLLADA>'
NO_MESH = {
    "pointer.stl": (POINTER, "Git LFS pointer", "git lfs pull"),
    "pointer.obj": (POINTER, "Git LFS pointer", "git lfs pull"),
    "pointer.dae": (POINTER, "Git LFS pointer", "git lfs pull"),
    "nothing.obj": (b" \n", "empty", "export it again"),
    "empty.stl": (bytes(80) + struct.pack("<I", 0), "no triangles", "export it again"),
    "cut.stl": (
        bytes(80) + struct.pack("<I", 9) + bytes(100),
        "9 triangles (534 bytes), and it has 184",
        "export it again",
    ),
    "empty_text.stl": (b"solid a\nendsolid a\n", "no triangles", "export it again"),
    "no_scene.dae": (COLLADA % b"", "no triangles", "export it again"),
    "empty_scene.dae": (
        COLLADA % b'<library_visual_scenes><visual_scene id="s"/></library_visual_scenes>'
        b'<scene><instance_visual_scene url="#s"/></scene>',
        "no triangles",
        "export it again",
    ),
    "flat.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n", "no triangles", "export it again"),
    "few.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no triangles", "export it again"),
}


@pytest.mark.parametrize("suffix", sorted(MESH_SUFFIXES))
def test_empty_file_of_any_format_is_reported_as_empty(tmp_path, suffix):
    with pytest.raises(MeshError, match="the file is empty"):
        read_mesh(_made(tmp_path / f"nothing{suffix}", b" \n"))


@pytest.mark.parametrize("name", NO_MESH)
def test_file_without_mesh_counts_as_missing(tmp_path, name):
    data, reason, remedy = NO_MESH[name]
    store = AssetStore()
    made = store.add(_made(tmp_path / name, data))
    assert reason in store.missing[made].reason
    assert remedy in store.missing[made].remedy
    assert store.files[made] == placeholder()
    assert not store.findings


@pytest.mark.parametrize("mirror", [(1.0, 1.0, 1.0), (-1.0, 1.0, 1.0)])
def test_points_without_triangles_become_their_convex_hull(tmp_path, mirror):
    corners = [(x, y, z) for x in (0, 1) for y in (0, 2) for z in (0, 3)]
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in [*corners, (0.5, 1, 1)])
    store = AssetStore()
    name = store.add(_made(tmp_path / "points.obj", text.encode()), mirror=mirror)
    mesh = parse_mesh(store.files[name], Path(name))
    assert len(mesh.vertices) == 9, "MuJoCo may use each point as a taxel"
    assert mesh.area == pytest.approx(2 * (2 + 3 + 6))
    middle = np.array([0.5, 1, 1.5]) * mirror
    outward = (mesh.face_normals * (mesh.vertices[mesh.faces].mean(axis=1) - middle)).sum(axis=1)
    assert (outward > 0).all()
    assert [finding.kind for finding in store.findings] == ["points-only"]
    assert not store.missing


def test_unsupported_format_is_rejected_unopened_with_a_remedy(tmp_path):
    with pytest.raises(MeshError, match=r"found: \.fbx.*Blender"):
        AssetStore().add(_made(tmp_path / "hand.fbx", b"secret"))
    with pytest.raises(MeshError, match="Convert it to one of"):
        AssetStore().add(_made(tmp_path / "hand.weird", b"secret"))


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("hand.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf one two password\n"),
        ("hand.off", b"OFF\n3 1 0\n0 0 password\n1 0 0\n0 1 0\n3 0 1 2\n"),
    ],
)
def test_error_does_not_quote_the_file(tmp_path, name, data):
    with pytest.raises(MeshError, match=name) as found:
        AssetStore().add(_made(tmp_path / name, data))
    assert "password" not in str(found.value)


@pytest.mark.parametrize(
    ("scale", "size", "signs"),
    [
        ("1 2 3", "1 2 3", (1, 1, 1)),
        ("-0.001 0.001 -2", "0.001 0.001 2.0", (-1, 1, -1)),
        ("", "", (1, 1, 1)),
        ("a b c", "a b c", (1, 1, 1)),
        ("-1", "-1", (1, 1, 1)),
        ("nan -1 1", "nan -1 1", (1, 1, 1)),
    ],
)
def test_scale_is_split_into_size_and_signs(scale, size, signs):
    assert split_scale(scale) == (size, signs)


@pytest.mark.parametrize("signs", [(-1.0, 1.0, 1.0), (-1.0, -1.0, 1.0), (-1.0, -1.0, -1.0)])
def test_mirrored_mesh_keeps_its_outside(tmp_path, rod, signs):
    store = AssetStore()
    path = _made(tmp_path / "rod.stl", rod)
    assert store.add(path) != store.add(path, mirror=signs), "both are kept"
    mesh = parse_mesh(store.files["rod_2.msh"], Path("rod_2.msh"))
    assert (((mesh.vertices[mesh.faces].mean(axis=1)) * mesh.face_normals).sum(axis=1) > 0).all()


def _made(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


def test_triangles_of_all_meshes_are_limited(tmp_path, rod, monkeypatch):
    monkeypatch.setattr(mesh_files, "MAX_FACES", 20)
    (tmp_path / "rod.stl").write_bytes(rod)
    store = AssetStore()
    store.add(tmp_path / "rod.stl")
    with pytest.raises(RobotError, match="together"):
        store.add(tmp_path / "rod.stl", variant="again")


@pytest.mark.parametrize("most", [12, 11])
def test_repeated_use_of_a_file_is_limited(tmp_path, rod, monkeypatch, most):
    monkeypatch.setattr(mesh_files, "MAX_REPEATED_FACES", most)
    path = _made(tmp_path / "rod.stl", rod)
    store = AssetStore()
    name = store.add(path)
    assert store.add(path) == name, "the same mesh is shared"
    store.add(path, variant="2 2 2")
    if most == 12:
        store.repeat(name, path)
    with pytest.raises(RobotError, match=r"rod\.stl: mesh files are used under too many names or scales"):
        store.repeat(name, path)


def test_corners_at_one_place_share_a_vertex_in_the_order_of_the_file():
    rng = np.random.default_rng(5)
    corners = 0.25 * rng.integers(-3, 4, (300, 3)) + np.where(rng.random((300, 3)) < 0.5, 0.0, -0.0)
    faces = rng.permutation(300).reshape(100, 3)
    welded = read_obj(corners, faces)
    assert [tuple(row) for row in welded.vertices.tolist()] == list(dict.fromkeys(map(tuple, corners.tolist())))
    np.testing.assert_array_equal(welded.vertices[welded.faces], corners[faces])


def test_places_with_the_same_hash_remain_different_vertices(monkeypatch):
    monkeypatch.setattr(mesh_files, "_hashes", lambda rows: np.zeros(len(rows), np.uint64))
    corners = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    welded = read_obj(corners, np.arange(6).reshape(2, 3))
    np.testing.assert_array_equal(welded.vertices, corners[[0, 1, 2, 5]])


def read_obj(corners, faces):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in corners.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces.tolist()]
    return parse_mesh("\n".join(lines).encode(), Path("soup.obj"))
