"""Objects as a scene file says them: what cannot be is refused, by name."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SceneError
from tactile_maps.scene.objects import OBJECT_KINDS, ObjectSpec

SIZES = {
    "probe": (0.01,),
    "sphere": (0.1,),
    "cylinder": (0.1, 0.2),
    "box": (0.1, 0.2, 0.3),
    "plate": (0.1, 0.2, 0.01),
    "plane": (1.0, 2.0),
    "mesh": (0.5,),
}


@pytest.mark.parametrize("kind", OBJECT_KINDS)
def test_size_must_fit_the_kind(kind):
    file = "x.stl" if kind == "mesh" else ""
    spec = ObjectSpec("x", kind, size=SIZES[kind], file=file)
    assert spec.size == SIZES[kind]
    with pytest.raises(SceneError, match=f"size of a {kind}") as caught:
        ObjectSpec("x", kind, size=(0.1, 0.1, 0.1, 0.1), file=file)
    assert ("in metres" in str(caught.value)) == (kind != "mesh")


@pytest.mark.parametrize(
    ("kind", "file", "words"),
    [
        ("mesh", "", "an object of kind mesh needs a mesh file"),
        ("box", "x.stl", 'a box has no file .*x.stl.*Remove file, or write kind = "mesh"'),
    ],
)
def test_rejected_mesh_file_names_the_error_and_the_remedy(kind, file, words):
    with pytest.raises(SceneError, match=words):
        ObjectSpec("x", kind, size=SIZES[kind], file=file)


def test_plane_and_mesh_need_no_size():
    assert ObjectSpec("x", "plane").size == ()
    assert ObjectSpec("x", "mesh", file="x.stl").size == ()
    with pytest.raises(SceneError, match="size of a box"):
        ObjectSpec("x", "box")


def test_pose_is_rotated_about_x_then_y_then_z():
    spec = ObjectSpec("x", "sphere", size=(0.1,), at=(1.0, 2.0, 3.0), turn=(90.0, 0.0, 90.0))
    assert spec.pose.points(np.array([0.0, 0.0, 1.0])) == pytest.approx([2.0, 2.0, 3.0])


@pytest.mark.parametrize(
    "bad",
    [
        {"name": ""},
        {"mass": -1.0},
        {"mass": float("nan")},
        {"friction": -0.1},
        {"stiffness": 0.0},
        {"damping": -1.0},
        {"max_force": float("inf")},
        {"at": (0.0, 0.0, float("nan"))},
        {"at": (0.0, 0.0, 1e6)},
        {"turn": (0.0, float("inf"), 0.0)},
        {"size": (0.0,)},
        {"size": (1e3,)},
        {"file": "x.stl"},
        {"path": ((0.0, float("nan"), 0.0, 0.0),)},
        {"path": ((1.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))},
        {"path": ((-1.0, 0.0, 0.0, 0.0),)},
        {"kind": "mesh"},
        {"kind": "sphere", "path": ((0.0, 0.0, 0.0, 0.0),)},
    ],
)
def test_invalid_value_is_rejected_with_its_key(bad):
    values = {"name": "x", "kind": "probe", "size": (0.01,)} | bad
    with pytest.raises(SceneError) as caught:
        ObjectSpec(**values)
    keys = {"kind": ("file", "path")}.get(next(iter(bad)), (next(iter(bad)),))
    assert str(caught.value.place).removeprefix("objects.") in keys


def test_range_of_lengths_is_stated_in_metres_and_path_times_with_a_remedy():
    for bad, words in (
        ({"size": (500.0,)}, r"found: 500 metres\). Choose 0.0001 to 100 metres"),
        ({"at": (0.0, 2e3, 0.0)}, "Choose -1000 to 1000 metres"),
        ({"path": ((-1.0, 0.0, 0.0, 0.0),)}, "Choose 0 to 3600 seconds"),
        ({"path": ((0, 0, 0, 1), (1, 0, 0, 2), (0.5, 0, 0, 1))}, "must rise .*each with a later time"),
    ):
        with pytest.raises(SceneError, match=words):
            ObjectSpec(**{"name": "x", "kind": "probe", "size": (0.01,)} | bad)


def test_only_free_bodies_can_be_guided():
    assert ObjectSpec("x", "cylinder", size=(0.1, 0.2), mass=0.1, guided=True).guided
    for kind, mass in (("cylinder", 0.0), ("plate", 1.0), ("probe", 1.0), ("plane", 1.0)):
        with pytest.raises(SceneError, match=r"objects\.guided"):
            ObjectSpec("x", kind, size=SIZES[kind], mass=mass, guided=True)
