"""Objects made real: closed surfaces of the right size, and meshes from files that strangers wrote."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from tactile_maps.core.errors import SceneError
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.scene import Scene

PRIMITIVES = (
    (ObjectSpec("p", "probe", size=(0.01,)), (0.02, 0.02, 0.02), 4 / 3 * np.pi * 0.01**3),
    (ObjectSpec("s", "sphere", size=(0.1,)), (0.2, 0.2, 0.2), 4 / 3 * np.pi * 0.1**3),
    (ObjectSpec("c", "cylinder", size=(0.1, 0.3)), (0.2, 0.2, 0.3), np.pi * 0.1**2 * 0.3),
    (ObjectSpec("b", "box", size=(0.1, 0.2, 0.3)), (0.1, 0.2, 0.3), 0.006),
    (ObjectSpec("l", "plate", size=(0.1, 0.2, 0.01)), (0.1, 0.2, 0.01), 0.0002),
)


def scene_of(*objects):
    return Scene(name="s", robot="arm", objects=objects)


@pytest.mark.parametrize(("spec", "extents", "volume"), PRIMITIVES, ids=[spec.kind for spec, *_ in PRIMITIVES])
def test_primitives_are_closed_and_of_the_right_size(spec, extents, volume):
    (body,) = make_objects(scene_of(spec))
    assert body.spec is spec
    assert body.mesh.connectivity.is_closed_manifold
    assert np.ptp(body.mesh.vertices, axis=0) == pytest.approx(extents, rel=2e-3)
    solid = trimesh.Trimesh(body.mesh.vertices, body.mesh.faces, process=False)
    assert solid.volume == pytest.approx(volume, rel=0.02), "and its outside is outside"
    assert not body.findings


def test_plane_is_a_rectangle_with_upward_normal():
    (body,) = make_objects(scene_of(ObjectSpec("f", "plane", size=(1.0, 3.0))))
    assert np.ptp(body.mesh.vertices, axis=0) == pytest.approx([1.0, 3.0, 0.0])
    assert body.mesh.face_normals == pytest.approx(np.array([[0, 0, 1], [0, 0, 1]]))
    (usual,) = make_objects(scene_of(ObjectSpec("f", "plane")))
    assert usual.mesh.area > 0


def test_mesh_is_read_and_scaled(tmp_path):
    trimesh.creation.box((0.1, 0.2, 0.3)).export(tmp_path / "block.stl")
    (body,) = make_objects(scene_of(ObjectSpec("m", "mesh", file=str(tmp_path / "block.stl"), size=(2.0,))))
    assert np.ptp(body.mesh.vertices, axis=0) == pytest.approx([0.2, 0.4, 0.6])
    assert not body.findings


@pytest.mark.parametrize(
    ("kind", "given", "words"),
    [
        ("box", {"size": (50.0, 50.0, 50.0)}, "it is 50 m in size; lengths in a scene are in metres"),
        ("probe", {"size": (20.0,)}, "it is 40 m in size"),
        ("sphere", {"size": (0.1,), "at": (400.0, 0.0, 300.0)}, "it is 500 m from the origin"),
        ("probe", {"size": (0.01,), "path": ((0.0, 0.0, 0.0, 200.0),)}, "it is 200 m from the origin"),
        ("plane", {"size": (90.0, 90.0)}, None),
        ("box", {"size": (8.0, 5.0, 3.0), "at": (0.0, 0.0, 2.0)}, None),
    ],
)
def test_numbers_that_are_probably_in_millimetres_are_reported(kind, given, words):
    (body,) = make_objects(scene_of(ObjectSpec("crate", kind, **given)))
    assert len(body.findings) == (words is not None)
    for finding in body.findings:
        assert (finding.kind, finding.where) == ("object-units", "crate")
        assert words in finding.action


def test_open_mesh_is_reported(tmp_path):
    box = trimesh.creation.box((0.1, 0.2, 0.3))
    box.update_faces(np.arange(len(box.faces)) > 0)
    box.export(tmp_path / "open.stl")
    (body,) = make_objects(scene_of(ObjectSpec("m", "mesh", file=str(tmp_path / "open.stl"))))
    assert [(finding.kind, finding.where) for finding in body.findings] == [("open-mesh", "m")]


def test_assumed_millimetres_are_reported(tmp_path):
    trimesh.creation.box((100, 200, 300)).export(tmp_path / "mm.stl")
    (body,) = make_objects(scene_of(ObjectSpec("m", "mesh", file=str(tmp_path / "mm.stl"))))
    assert np.ptp(body.mesh.vertices, axis=0) == pytest.approx([0.1, 0.2, 0.3])
    assert [finding.kind for finding in body.findings] == ["units"]


@pytest.mark.parametrize(("name", "content"), [("gone.stl", None), ("bad.stl", b"\0\1"), ("block.txt", b"x")])
def test_invalid_mesh_file_is_rejected(tmp_path, name, content):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(SceneError, match=rf"{name}.*objects.0.file"):
        make_objects(scene_of(ObjectSpec("m", "mesh", file=str(tmp_path / name))))
