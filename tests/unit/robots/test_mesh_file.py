"""Mesh files: every format gives the same checked triangles, every broken one a named error."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh

from app.errors import MeshError
from app.geometry.mesh import Mesh
from app.robots import mesh_file
from app.robots.mesh_file import box_mesh, parse_mesh, read_mesh, to_msh


@pytest.mark.parametrize("suffix", ["obj", "stl", "ply", "off", "glb"])
def test_formats_agree_and_corners_are_shared(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"box.{suffix}"
    trimesh.creation.box((1, 2, 3)).export(path)
    mesh = read_mesh(path)
    assert (len(mesh.vertices), len(mesh.faces)) == (8, 12)
    assert mesh.area == pytest.approx(22)


def test_mujocos_format_round_trips_with_indices_in_order() -> None:
    mesh = box_mesh(0.5)
    again = parse_mesh(to_msh(mesh), Path("box.msh"))
    assert np.array_equal(again.faces, mesh.faces)
    assert np.array_equal(again.vertices, mesh.vertices)


def test_minus_zero_and_zero_are_one_place() -> None:
    text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv -0.0 0 0\nv 0 0 1\nf 1 2 3\nf 4 2 5\n"
    assert len(parse_mesh(text, Path("a.obj")).vertices) == 4


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
    "short.off": b"OFF\n3 1 0\n0 0 0\n",
    "noise.glb": b"glTF" + bytes(20),
    "plain.dae": b"<COLLADA/>",
    "bomb.dae": b'<!DOCTYPE a [<!ENTITY x "y">]><COLLADA>&x;</COLLADA>',
    "unit.dae": b'<COLLADA><asset><unit meter="nan"/></asset></COLLADA>',
    "absurd.msh": struct.pack("<4i", 2**30, 0, 0, 2**30),
    "negative.msh": struct.pack("<4i", -1, 0, 0, 1),
    "outside.msh": struct.pack("<4i", 1, 0, 0, 1) + bytes(12) + struct.pack("<3i", 0, 0, 7),
    "model.step": b"ISO-10303-21;",
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_are_refused_by_name(name: str) -> None:
    with pytest.raises(Exception, match=name.replace(".", r"\.")) as caught:
        parse_mesh(BROKEN[name], Path(name))
    assert type(caught.value).__name__ in ("MeshError", "RobotError")


def test_too_many_triangles_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mesh_file, "MAX_FACES", 11)
    with pytest.raises(MeshError, match="5 million"):
        parse_mesh(to_msh(box_mesh(1.0)), Path("box.msh"))


def test_the_order_of_the_files_vertices_is_kept() -> None:
    mesh = Mesh(np.array([[3.0, 0, 0], [1, 0, 0], [2, 5, 0]]), np.array([[0, 1, 2]]))
    assert np.array_equal(parse_mesh(to_msh(mesh), Path("a.msh")).vertices, mesh.vertices)
