"""Files made to hurt are refused by name within bounds, open nothing that is not theirs, and run nothing."""

from __future__ import annotations

import importlib
import os
import pkgutil
import re
from pathlib import Path

import pytest
import trimesh

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.robots.load import load_robot_file
from tests.files import hostile_files
from tests.files.hostile_files import BODY, LONG, OPENERS, PATHS, RECORDED, ROBOTS, mjcf, spiked_sphere

LIBRARY = tuple(
    module.name
    for folder in ("editing", "maps", "recording", "robots", "scene", "skin", "stimuli")
    for module in pkgutil.walk_packages(
        importlib.import_module(f"tactile_maps.{folder}").__path__, f"tactile_maps.{folder}."
    )
)
SECRET = "root-of-all-secrets"


def refused(outcome, words):
    return outcome.startswith("refused: ") and re.search(words, outcome) is not None


def test_pipes_devices_and_folders_are_rejected_by_every_function(tmp_path, call_all):
    """A pipe without a writer, an endless device, a link to one, a folder: refused at once, and closed again."""
    cases = []
    for number, (name, ending) in enumerate(PATHS):
        pipe = tmp_path / f"{number} pipe{ending}"
        os.mkfifo(pipe)
        (device := tmp_path / f"{number} device{ending}").symlink_to("/dev/zero")
        (link := tmp_path / f"{number} link{ending}").symlink_to(pipe)
        (folder := tmp_path / f"{number} folder{ending}").mkdir()
        cases += [(name, str(path)) for path in (pipe, device, link, folder)]
    for case, outcome in zip(cases, call_all(hostile_files.read, cases, cpu=5), strict=True):
        assert refused(outcome, "not a file|no folder|a folder"), (case, outcome)


def test_functions_of_the_library_that_open_files_are_listed():
    modules = [importlib.import_module(name) for name in LIBRARY]
    opens = re.compile(r"(load|open|read)_(map|document|obj|skin|taxel_sets|scene|stimuli|recording|mesh|robot_file)$")
    found = {name for module in modules for name in vars(module) if opens.match(name)}
    assert len(found) >= 9
    assert found <= {opener.__name__ for opener, _ in OPENERS.values()}


def test_meshes_and_includes_that_are_pipes_are_rejected(tmp_path, call_all):
    os.mkfifo(tmp_path / "m.stl")
    os.mkfifo(tmp_path / "part.xml")
    os.mkfifo(tmp_path / "b.bin")
    (tmp_path / "mesh.xml").write_text(mjcf(BODY, '<asset><mesh file="m.stl"/></asset>'))
    (tmp_path / "include.xml").write_text('<mujoco><include file="part.xml"/></mujoco>')
    (tmp_path / "mesh.urdf").write_text(
        '<robot name="r"><link name="a"><visual><geometry><mesh filename="m.stl"/></geometry></visual></link></robot>'
    )
    (tmp_path / "mesh.gltf").write_text('{"asset":{"version":"2.0"},"buffers":[{"uri":"b.bin","byteLength":4}]}')
    names = ("mesh.xml", "include.xml", "mesh.urdf", "mesh.gltf")
    for outcome in call_all(hostile_files.robot, [(str(tmp_path / name),) for name in names], cpu=5):
        assert refused(outcome, "not a file.*a pipe"), outcome


@pytest.mark.parametrize(
    "names", [ROBOTS.keys() - LONG, pytest.param(LONG, marks=pytest.mark.long)], ids=["short", "long"]
)
def test_hostile_robots_are_rejected_quickly(tmp_path, call_all, names):
    for name in names:
        (tmp_path / name).write_text(ROBOTS[name][0])
    outcomes = call_all(hostile_files.robot, [(str(tmp_path / name),) for name in names])
    for name, outcome in zip(names, outcomes, strict=True):
        words = ROBOTS[name][1]
        assert refused(outcome, words) if words else outcome == "ok", (name, outcome)
        assert words is None or f"/{name}" in outcome, outcome


def test_hostile_robots_in_recordings_are_rejected_quickly(call_all):
    outcomes = call_all(hostile_files.recorded, [(text, {}) for text, _ in RECORDED.values()])
    for (name, (_, words)), outcome in zip(RECORDED.items(), outcomes, strict=True):
        assert refused(outcome, words), (name, outcome)
        assert "hostile.mcap" in outcome


@pytest.mark.long
def test_spike_of_100_radii_is_mapped_or_rejected_quickly(tmp_path, call_all):
    path = spiked_sphere(tmp_path / "spike.stl", 100.0)
    (outcome,) = call_all(hostile_files.mapped, [(str(path),)])
    assert outcome == "ok" or outcome.startswith("refused: "), outcome


@pytest.mark.long
def test_spike_of_a_thousand_radii_is_mapped_in_seconds(tmp_path, call_all):
    """Nearly all taxels are on the needle, which would otherwise buckle and overlap itself while it grows."""
    path = spiked_sphere(tmp_path / "spike.stl", 1000.0, 3)
    assert call_all(hostile_files.mapped, [(str(path),)], cpu=20.0) == ["ok"]


@pytest.mark.long
@pytest.mark.parametrize(
    ("radii", "subdivisions", "cpu"), [(300, 4, 20), (1000, 4, 20), (1000, 5, 30), (10_000, 3, 20), (10_000, 4, 40)]
)
def test_larger_spikes_are_mapped_in_half_a_minute(tmp_path, call_all, radii, subdivisions, cpu):
    path = spiked_sphere(tmp_path / "spike.stl", radii, subdivisions)
    assert call_all(hostile_files.mapped, [(str(path),)], cpu=cpu) == ["ok"]


def test_spike_of_100000_radii_is_rejected_by_name(tmp_path, call_all):
    path = spiked_sphere(tmp_path / "spike.stl", 100_000.0, 3)
    (outcome,) = call_all(hostile_files.mapped, [(str(path),)], cpu=10.0)
    assert refused(outcome, "too long and thin to be flattened.*needles"), outcome


def test_mesh_of_a_billion_metres_is_rejected_quickly(tmp_path, call_all):
    path = tmp_path / "huge.stl"
    trimesh.creation.icosphere(4, radius=1e9).export(path)
    outcomes = call_all(hostile_files.mapped, [(str(path),)]) + call_all(hostile_files.robot, [(str(path),)])
    assert all(refused(outcome, "implausibly large.*metres") for outcome in outcomes), outcomes


@pytest.fixture
def secret(tmp_path):
    """A file outside the model's folder, which the model must not read."""
    (tmp_path / "model").mkdir()
    for name in ("secret.xml", "secret.obj", "secret.stl", "secret.bin"):
        (tmp_path / name).write_text(f"{SECRET} {SECRET}\n")
    return tmp_path


@pytest.mark.parametrize("how", ["..", "absolute", "link"])
@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("m.xml", '<mujoco><include file="{}.xml"/></mujoco>'),
        ("m.xml", '<mujoco><asset><mesh file="{}.obj"/></asset></mujoco>'),
        ("m.xml", '<mujoco><compiler meshdir=".."/><asset><mesh file="{}.stl"/></asset></mujoco>'),
        ("m.urdf", '<robot><link><visual><geometry><mesh filename="{}.obj"/></geometry></visual></link></robot>'),
        ("m.gltf", '{{"asset":{{"version":"2.0"}},"buffers":[{{"uri":"{}.bin","byteLength":4}}]}}'),
    ],
)
def test_model_opens_only_files_of_its_own_tree(secret, name, text, how):
    model = secret / "model"
    if how == "link":
        for ending in ("xml", "obj", "stl", "bin"):
            (model / f"inside.{ending}").symlink_to(secret / f"secret.{ending}")
    named = {"..": "../secret", "absolute": str(secret / "secret"), "link": "inside"}[how]
    (model / name).write_text(text.format(named).replace(' meshdir=".."', "" if how == "link" else ' meshdir=".."'))
    with pytest.raises(TactileMapsError, match="leaves the robot's folder") as found:
        load_robot_file(model / name)
    assert SECRET not in str(found.value)


def test_urdf_does_not_accept_any_folder_as_a_package(secret):
    """The name alone does not make a sibling of a parent folder a package."""
    (secret / "private").mkdir()
    (secret / "private" / "secret.obj").write_text(SECRET)
    (secret / "model" / "m.urdf").write_text(
        '<robot name="r"><link name="a"><visual><geometry><mesh filename="package://private/secret.obj"/></geometry>'
        "</visual></link></robot>"
    )
    robot = load_robot_file(secret / "model" / "m.urdf")
    assert [finding.kind for finding in robot.findings if "mesh" in finding.kind] == ["missing-mesh"]
    assert "no such file" in str(robot.findings)
    (secret / "private" / "package.xml").write_text("<package/>")
    assert "no triangles" in str(load_robot_file(secret / "model" / "m.urdf").findings)


@pytest.mark.parametrize(
    "text",
    [
        '<mujoco><asset><mesh name="a" file="{}/secret.obj"/></asset><worldbody>{}</worldbody></mujoco>',
        '<mujoco><compiler meshdir="{}"/><asset><mesh file="m.msh"/></asset><worldbody>{}</worldbody></mujoco>',
        '<mujoco><include file="{}/secret.xml"/><worldbody>{}</worldbody></mujoco>',
        '<mujoco><asset><texture name="t" type="2d" file="{}/secret.png"/></asset><worldbody>{}</worldbody></mujoco>',
        '<mujoco><worldbody><attach model="{}/secret.xml"/>{}</worldbody></mujoco>',
    ],
)
def test_recorded_robot_opens_no_file(secret, text):
    """MuJoCo would search the disk for files that are not in the recording."""
    mesh = trimesh.creation.box()
    from tactile_maps.robots.files.mesh_files import Mesh, to_msh

    files = {"m.msh": to_msh(Mesh(mesh.vertices, mesh.faces))}
    with pytest.raises(TactileMapsError, match="not allowed in a robot|not its own|may not name folders") as found:
        hostile_files.recorded(text.format(secret, BODY), files)
    assert SECRET not in str(found.value)


@pytest.mark.parametrize(
    ("name", "data"), [("a.obj", b"mtllib /etc/passwd"), ("a.msh", b"\x7f" * 40), ("a.dll", b"MZ")]
)
def test_recorded_robot_contains_only_meshes(name, data):
    with pytest.raises(TactileMapsError, match="not a mesh|cannot be read"):
        hostile_files.recorded(mjcf(BODY), {name: data})


@pytest.mark.long
def test_plugins_of_a_model_are_omitted_with_a_finding(tmp_path):
    path = tmp_path / "m.xml"
    path.write_text(
        mjcf(
            '<body><joint/><geom size="1"/><plugin plugin="evil.b"/></body>',
            '<extension><plugin plugin="evil.a"><instance name="i"/></plugin></extension>',
        )
    )
    robot = load_robot_file(path)
    assert "evil" not in robot.mjcf
    assert [finding.where for finding in robot.findings if finding.kind == "plug-in"] == ["evil.a, evil.b"]


def test_no_code_unpickles_or_evaluates():
    """Neither recordings nor maps can run code: nothing in the program that reads files calls what could."""
    never = re.compile(
        r"\bpickle\.loads?\b|allow_pickle=True|(?<![.\w])(?:eval|exec)\(|yaml\.load|marshal\.|shelve\.|os\.system"
    )
    root = Path(hostile_files.__file__).resolve().parents[2]
    files = [path for folder in ("app", "widgets") for path in (root / folder).rglob("*.py")]
    assert len(files) > 200
    found = [f"{path.relative_to(root)}: {text}" for path in files for text in never.findall(path.read_text())]
    assert not found
