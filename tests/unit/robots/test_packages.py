"""Package addresses lead into their package and nowhere else."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.errors import RobotError
from app.robots.packages import Packages


@pytest.fixture
def package(tmp_path: Path) -> Path:
    folder = tmp_path / "kit"
    (folder / "urdf").mkdir(parents=True)
    (folder / "meshes").mkdir()
    (folder / "meshes" / "a b.stl").write_bytes(b"")
    return folder


def test_a_neighbouring_folder_of_the_same_package_may_be_named(package: Path) -> None:
    file = package / "urdf" / "robot.urdf"
    with pytest.raises(RobotError, match="climbs out"):
        Packages(file).resolve("../meshes/a b.stl")
    (package / "package.xml").write_text("<package/>")
    assert Packages(file).resolve("../meshes/a b.stl") == package / "meshes" / "a b.stl"
    assert Packages(file).resolve("..\\meshes\\a%20b.stl") == package / "meshes" / "a b.stl"


def test_ros_package_path_is_searched(package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "alone").mkdir()
    file = tmp_path / "alone" / "robot.urdf"
    (tmp_path / "alone" / "deep").mkdir()
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "kit"))
    assert Packages(file).resolve("package://kit/meshes/a b.stl") == package / "meshes" / "a b.stl"


@pytest.mark.parametrize("address", ["package://kit", "package:///etc/passwd", "https://example.org/a.stl"])
def test_addresses_of_other_kinds_are_refused(package: Path, address: str) -> None:
    with pytest.raises(RobotError):
        Packages(package / "robot.urdf").resolve(address)
