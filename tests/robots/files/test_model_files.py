"""Allowed locations of the files of a model: its tree, packages and given roots only."""

from __future__ import annotations

from pathlib import Path

import pytest

from tactile_maps.core.errors import RobotError
from tactile_maps.robots.files import model_files
from tactile_maps.robots.files.model_files import ModelFiles, PackageResolver, model_tree
from tactile_maps.robots.load import load_robot_file

SECRET = "root-of-all-secrets"


@pytest.fixture
def package(tmp_path: Path) -> Path:
    folder = tmp_path / "kit"
    (folder / "urdf").mkdir(parents=True)
    (folder / "meshes").mkdir()
    (folder / "meshes" / "a b.stl").write_bytes(b"")
    return folder


def test_other_folder_of_the_same_package_may_be_named(package):
    file = package / "urdf" / "robot.urdf"
    with pytest.raises(RobotError, match="leaves the robot"):
        PackageResolver(file).resolve("../meshes/a b.stl")
    (package / "package.xml").write_text("<package/>")
    assert PackageResolver(file).resolve("../meshes/a b.stl") == package / "meshes" / "a b.stl"
    assert PackageResolver(file).resolve("..\\meshes\\a%20b.stl") == package / "meshes" / "a b.stl"


@pytest.mark.parametrize(
    "address", ["package://kit", "package:///etc/passwd", "package:///", "package://", "https://example.org/a.stl"]
)
def test_invalid_addresses_are_rejected(package, address):
    with pytest.raises(RobotError):
        PackageResolver(package / "robot.urdf").resolve(address)


def make(path: Path, text: str = "") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


@pytest.mark.parametrize("mark", ["package.xml", "pyproject.toml", "setup.py", ".git/HEAD"])
def test_tree_is_the_nearest_package_or_repository(tmp_path, mark):
    file = make(tmp_path / "outer" / "kit" / "robots" / "hand" / "hand.xml")
    make(tmp_path / "outer" / "setup.cfg")
    make(tmp_path / "outer" / "kit" / mark)
    assert model_tree(file) == tmp_path / "outer" / "kit"


def test_tree_of_a_python_package_is_its_top_but_never_site_packages(tmp_path):
    site = tmp_path / "lib" / "site-packages"
    file = make(site / "gym" / "envs" / "data" / "hand" / "hand.xml")
    make(site / "gym" / "__init__.py")
    make(site / "gym" / "envs" / "__init__.py")
    make(site / "__init__.py")
    assert model_tree(file) == site / "gym"
    assert model_tree(make(site / "hand.xml")) == site, "its own folder"
    (site / "gym" / "__init__.py").unlink()
    (site / "gym" / "envs" / "__init__.py").unlink()
    assert model_tree(file) == site / "gym" / "envs" / "data" / "hand"


def test_tree_without_a_mark_is_a_folder_of_a_usual_name_or_that_of_the_file(tmp_path):
    assert model_tree(make(tmp_path / "a" / "hand" / "hand.xml")) == tmp_path / "a" / "hand"
    assert model_tree(make(tmp_path / "assets" / "hand" / "hand.xml")) == tmp_path / "assets"
    assert model_tree(make(tmp_path / "x_description" / "urdf" / "x.urdf")) == tmp_path / "x_description"


@pytest.mark.parametrize("mark", ["package.xml", ".git/HEAD", "__init__.py", "pyproject.toml"])
def test_home_folders_and_those_above_are_never_a_tree(tmp_path, monkeypatch, mark):
    home = tmp_path / "people" / "me"
    file = make(home / "robots" / "hand" / "hand.xml")
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setenv("USERPROFILE", str(home))
    for folder in (home, home.parent, home.parent.parent):
        make(folder / mark)
    assert model_tree(file) == home / "robots" / "hand"
    other = make(tmp_path / "people" / "other" / "hand" / "hand.xml")
    make(tmp_path / "people" / "other" / mark)
    assert model_tree(other) == other.parent, "another person's home"


def test_tree_of_a_linked_model_is_that_of_its_target(tmp_path):
    make(tmp_path / "kit" / "package.xml")
    file = make(tmp_path / "elsewhere" / "hand.xml")
    (tmp_path / "kit" / "hand.xml").symlink_to(file)
    assert model_tree(tmp_path / "kit" / "hand.xml") == tmp_path / "elsewhere"


@pytest.fixture
def kit(tmp_path: Path) -> Path:
    """A package with a folder for models, one for meshes, and secrets inside and outside the package."""
    make(tmp_path / "kit" / "package.xml", "<package><name>real_name</name></package>")
    make(tmp_path / "kit" / "robots" / "hand.xml", "<mujoco/>")
    for folder in (tmp_path, tmp_path / "kit"):
        for name in ("id_rsa", "secret.xml", "secret.obj", "secret.txt"):
            make(folder / name, f"{SECRET} {SECRET}\n")
    return tmp_path / "kit"


@pytest.mark.parametrize("name", ["id_rsa", "secret.txt", "package.xml/../id_rsa"])
def test_outside_the_models_folder_only_models_and_meshes_are_read(kit, name):
    files = ModelFiles(kit / "robots" / "hand.xml")
    with pytest.raises(RobotError, match="only models and meshes"):
        files.place(Path("..") / name, named=name)
    assert files.place(Path("../meshes/a.stl"), named="a") == kit / "meshes" / "a.stl"


def test_link_out_of_the_tree_or_to_another_kind_is_rejected(kit):
    files = ModelFiles(kit / "robots" / "hand.xml")
    (kit / "out.stl").symlink_to(kit.parent / "secret.obj")
    (kit / "key.stl").symlink_to(kit / "id_rsa")
    with pytest.raises(RobotError, match="leaves the robot"):
        files.place(Path("../out.stl"), named="out")
    with pytest.raises(RobotError, match="only models and meshes"):
        files.place(Path("../key.stl"), named="key")


@pytest.mark.parametrize(
    "text",
    [
        '<mujoco><include file="../secret.xml"/></mujoco>',
        '<mujoco><include file="../id_rsa"/></mujoco>',
        '<mujoco><compiler meshdir=".."/><asset><mesh file="secret.txt"/></asset></mujoco>',
    ],
)
def test_errors_do_not_quote_files_of_the_tree(kit, text):
    model = make(kit / "robots" / "m.xml", text)
    with pytest.raises(Exception, match="secret|id_rsa") as found:
        load_robot_file(model)
    assert SECRET not in str(found.value)


def test_findings_do_not_quote_files_of_the_tree(kit):
    body = '<body name="a"><geom size="0.1"/></body>'
    text = f'<mujoco><asset><mesh file="../secret.obj"/></asset><worldbody>{body}</worldbody></mujoco>'
    findings = load_robot_file(make(kit / "robots" / "m.xml", text)).findings
    assert any(finding.where.endswith("secret.obj") for finding in findings)
    assert SECRET not in str(findings)


def test_files_with_the_name_of_a_missing_one_are_similar(kit, tmp_path):
    near = [make(kit / "robots" / place) for place in ("Shell.STL", "meshes/shell.obj", "meshes/other.stl")]
    outside = make(kit / "meshes" / "shell.stl")
    root = make(tmp_path / "root" / "deep" / "SHELL.dae")
    make(kit / "meshes" / "shell.txt")
    make(tmp_path / "elsewhere" / "shell.stl")
    files = ModelFiles(kit / "robots" / "hand.xml", [tmp_path / "root"])
    missing = near[0].with_name("shell.stl")
    assert files.similar_meshes([missing, kit / "no.stl"]) == {
        missing: ["Shell.STL", str(outside), "meshes/shell.obj"],
        kit / "no.stl": [],
    }
    near[0].unlink()
    outside.unlink()
    assert files.similar_meshes([missing])[missing] == ["meshes/shell.obj", str(root)]


def test_search_for_similar_files_is_limited(kit, monkeypatch):
    make(kit / "robots" / "meshes" / "shell.obj")
    files = ModelFiles(kit / "robots" / "hand.xml")
    missing = kit / "robots" / "shell.stl"
    assert files.similar_meshes([missing])[missing]
    monkeypatch.setattr(model_files, "_LOOKED_AT", 1)
    assert files.similar_meshes([missing]) == {missing: []}


def test_files_opened_outside_the_models_folder_are_reported(kit):
    make(kit / "meshes" / "a.stl")
    files = ModelFiles(kit / "robots" / "hand.xml")
    files.place(Path("hand.xml"), named="own")
    assert files.findings() == []
    files.place(Path("../meshes/a.stl"), named="a")
    files.place(Path("../meshes/missing.stl"), named="b")
    (finding,) = files.findings()
    assert (finding.kind, finding.where, finding.count) == ("files-beside", str(kit), 1)


def test_path_out_of_the_tree_is_rejected_with_the_package_root_to_give(tmp_path):
    file = make(tmp_path / "deep" / "hand" / "hand.xml")
    make(tmp_path / "deep" / "stls" / "a.stl")
    with pytest.raises(RobotError, match="leaves the robot") as found:
        ModelFiles(file).place(Path("../stls/a.stl"), named="../stls/a.stl")
    assert f"give {tmp_path / 'deep'} as a package root (--package-root DIR)" in str(found.value)
    files = ModelFiles(file, [tmp_path / "deep"])
    assert files.place(Path("../stls/a.stl"), named="a") == tmp_path / "deep" / "stls" / "a.stl"
    with pytest.raises(RobotError, match="leaves the robot") as found:
        ModelFiles(file).place(Path("/etc/passwd"), named="/etc/passwd")
    assert "give / " not in str(found.value)


@pytest.mark.parametrize(
    "address",
    [
        "package://real_name/meshes/a.stl",
        "package:///real_name/meshes/a.stl",
        "package:///kit/meshes/a.stl",
        "$(find real_name)/meshes/a.stl",
        "file://$(find kit)/meshes/a.stl",
    ],
)
def test_package_is_found_by_its_folder_and_by_its_stated_name(kit, address):
    make(kit / "meshes" / "a.stl")
    assert PackageResolver(kit / "robots" / "hand.xml").resolve(address) == kit / "meshes" / "a.stl"


def test_packages_are_found_where_ros_installs_them_and_in_workspaces(kit, tmp_path, monkeypatch):
    file = make(tmp_path / "alone" / "hand.urdf")
    mesh = make(tmp_path / "install" / "share" / "fingers" / "a.stl")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "install"))
    assert PackageResolver(file).resolve("package://fingers/a.stl") == mesh
    nested = make(tmp_path / "ws" / "repository" / "thumb" / "a.stl")
    make(nested.parent / "package.xml")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ws"))
    assert PackageResolver(file).resolve("package://thumb/a.stl") == nested
    with pytest.raises(RobotError, match="leaves"):
        PackageResolver(file).resolve("package://thumb/../../a.stl")


def test_part_of_a_model_names_the_files_that_include_it(tmp_path):
    part = make(tmp_path / "part.xml", "<mujoco><body/></mujoco>")
    make(tmp_path / "whole.xml", '<mujoco><worldbody><include file="part.xml"></include></worldbody></mujoco>')
    make(tmp_path / "other.xml", '<mujoco><include file="my_part.xml"/></mujoco>')
    with pytest.raises(RobotError, match=r"part of other files: open whole\.xml\."):
        load_robot_file(part)
    assert model_files.files_that_include(tmp_path / "other.xml").startswith("Open the file that includes it")
