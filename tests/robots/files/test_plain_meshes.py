"""Plain OBJ and STL files: the same as by trimesh to the bit, and everything else left to it."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh

from tactile_maps.robots.files import mesh_files
from tactile_maps.robots.files.mesh_files import parse_mesh
from tactile_maps.robots.files.plain_meshes import read_binary_stl, read_plain_obj

V = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"


def soup(corner: str, *, ending: str = "\n", first: str = "") -> bytes:
    """300 random corners, some twice, in 100 faces written as ``corner`` says; one corner is in no face."""
    rng = np.random.default_rng(7)
    places = rng.normal(size=(300, 3)).round(6)
    places[100:200] = places[:100]
    lines = [first, "# soup", "mtllib none.mtl", *(f"v {x} {y} {z:e}" for x, y, z in places.tolist()), "v 9 9 9"]
    lines += [f"vn 0 0 {number}" for number in range(301)] + [f"vt 0 {number}" for number in range(301)]
    lines += ["g part", "usemtl grey", "s off"]
    for face in 1 + rng.permutation(300).reshape(100, 3):
        lines.append("f " + " ".join(corner.format(place=place, other=301 - place) for place in face.tolist()))
    return ending.join(lines).encode()


@pytest.mark.parametrize("corner", ["{place}", "{place}/{other}", "{place}//{other}", "{place}/{place}/{other}"])
@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_obj_file_reads_as_by_trimesh(monkeypatch, corner, ending):
    data = soup(corner, ending=ending)
    assert read_plain_obj(data) is not None, "else trimesh is compared with itself"
    ours = parse_mesh(data, Path("soup.obj"))
    monkeypatch.setattr(mesh_files, "_PLAIN_READERS", {})
    theirs = parse_mesh(data, Path("soup.obj"))
    assert 100 < len(ours.vertices) < 300, "some corners are at one place"
    np.testing.assert_array_equal(ours.vertices, theirs.vertices)
    np.testing.assert_array_equal(ours.faces, theirs.faces)


def test_colours_of_vertices_are_ignored():
    found = read_plain_obj(b"v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3")
    assert found is not None
    np.testing.assert_array_equal(found[0], [[0, 0, 0], [1, 0, 0], [0, 1, 0]])


@pytest.mark.parametrize(
    "data",
    [
        b"",
        V,
        b"f 1 2 3\n",
        V + b"f 1 2 3 4\n",
        V + b"f 1 2 3\nf 1 2 3 4\n",
        V + b"f 1 2\n",
        V + b"f -1 -2 -3\n",
        V + b"f 0 1 2\n",
        V + b"f 1 2 9\n",
        V + b"f 1 2 one\n",
        V + b"f 1 2 99999999999999999999\n",
        V + b"foo 1 2 3\n",
        V + b"f 1 2 \\\n3\n",
        V + b"usemtl a\nf 1 2 3\nusemtl b\nf 1 2 4\n",
        V + b"v nan 0 0\nf 1 2 3\n",
        V + b"v a b c\nf 1 2 3\n",
        V + b"v 1 2\nf 1 2 3\n",
    ],
)
def test_other_obj_files_are_left_to_trimesh(data):
    assert read_plain_obj(data) is None


def test_binary_stl_file_reads_as_by_trimesh(monkeypatch):
    data = trimesh.creation.icosphere(2, 0.3).export(file_type="stl")
    assert read_binary_stl(data) is not None
    ours = parse_mesh(data, Path("ball.stl"))
    monkeypatch.setattr(mesh_files, "_PLAIN_READERS", {})
    theirs = parse_mesh(data, Path("ball.stl"))
    np.testing.assert_array_equal(ours.vertices, theirs.vertices)
    np.testing.assert_array_equal(ours.faces, theirs.faces)


@pytest.mark.parametrize(
    "data", [b"", b"solid text", b"solid" + b" " * 100, bytes(80) + struct.pack("<I", 2) + bytes(50)]
)
def test_stl_files_in_text_or_of_wrong_length_are_left_to_trimesh(data):
    assert read_binary_stl(data) is None


@pytest.mark.parametrize("size", [84, 200, 4096])
def test_stl_file_that_states_no_faces_has_none(size):
    found = read_binary_stl(bytes(size))
    assert found is not None
    assert [len(part) for part in found] == [0, 0]
