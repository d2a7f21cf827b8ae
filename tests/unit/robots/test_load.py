"""One door: the reader is chosen by what the file is."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from app.errors import RobotError
from app.robots.load import load_robot


def test_each_kind_of_file_finds_its_reader(tiny: Path, urdf: Callable[[str], Path]) -> None:
    assert load_robot(tiny).name == "tiny"
    assert load_robot(str(urdf("rod.stl"))).name == "two"
    assert load_robot(tiny.parent / "meshes" / "rod.stl").links[0].name == "mesh"


def test_urdf_under_the_name_of_xml_is_still_urdf(urdf: Callable[[str], Path]) -> None:
    path = urdf("rod.stl").rename(urdf("rod.stl").with_name("two.xml"))
    assert load_robot(path).name == "two"


@pytest.mark.parametrize(("name", "problem"), [("absent.xml", "no such file"), ("absent.stl", "no such file"),
                                               ("", "folder, not a file"), ("notes.txt", "no robot file")])  # fmt: skip
def test_what_is_no_robot_file_is_said(tmp_path: Path, name: str, problem: str) -> None:
    (tmp_path / "notes.txt").write_text("notes")
    with pytest.raises(RobotError, match=problem) as caught:
        load_robot(tmp_path / name)
    assert str(tmp_path / name) in str(caught.value)


def test_a_robot_crosses_to_another_process_unchanged(tiny: Path) -> None:
    robot = load_robot(tiny)
    again = pickle.loads(pickle.dumps(robot))
    assert (again.mjcf, again.assets, again.joints) == (robot.mjcf, robot.assets, robot.joints)
    assert np.array_equal(again.home, robot.home)
    assert all(np.array_equal(a.mesh.vertices, b.mesh.vertices) for a, b in zip(again.links, robot.links, strict=True))


def test_reading_twice_gives_the_same_robot(tiny: Path) -> None:
    first, second = load_robot(tiny), load_robot(tiny)
    assert (first.mjcf, first.assets) == (second.mjcf, second.assets)
