"""A prepared scene that is kept is the one that would be made now, or it is not used."""

from __future__ import annotations

import os
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.core.files import FOLDER_VARIABLE, unpack_arrays
from tactile_maps.maps.formats.map_file import map_to_bytes
from tactile_maps.maps.model.taxel_frames import taxel_frames
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session import prepared_cache
from tactile_maps.session.bundle import pack_scene, unpack_scene
from tactile_maps.session.prepare import PreparedScene, prepare
from tactile_maps.session.prepared_cache import (
    cache_content,
    clear_cache,
    find_prepared,
    load_robot_cached,
    prepare_cached,
)
from tactile_maps.session.session import Session
from tactile_maps.skin.fitting.cover import CoverSpec
from tactile_maps.skin.formats.vendors.mapping_file import mapping_path

BAR = """<mujoco model="bar"><compiler angle="radian"/><asset><mesh name="m" file="bar.obj"/></asset><worldbody>
<body name="bar"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="hinge" range="-1 1"/>
<geom type="mesh" mesh="m"/></body></worldbody></mujoco>"""
CUBE = """v 0 0 0\nv {x} 0 0\nv {x} .1 0\nv 0 .1 0\nv 0 0 .1\nv {x} 0 .1\nv {x} .1 .1\nv 0 .1 .1
f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """Cache folder of this test."""
    folder = tmp_path / "kept"
    monkeypatch.setenv(FOLDER_VARIABLE, str(folder))
    return folder


@pytest.fixture
def bar(tmp_path) -> Scene:
    """A cube on a hinge, of two files."""
    (tmp_path / "bar.xml").write_text(BAR)
    (tmp_path / "bar.obj").write_text(CUBE.format(x=0.1))
    cover = CoverSpec(links=("bar",), taxels=12, thickness=0.01)
    return replace(load_scene("view"), robot=str(tmp_path / "bar.xml"), cover=cover, stimuli=(), control={}, motion=())


def _content(prepared: PreparedScene) -> tuple[object, ...]:
    """All of robot, skin and map but how long the map took to make."""
    robot = prepared.robot
    meshes = [link.mesh and (link.mesh.vertices.tobytes(), link.mesh.faces.tobytes()) for link in robot.links]
    header, arrays = unpack_arrays(map_to_bytes(prepared.map), error=MapError)
    members = {name: values.tobytes() for name, values in arrays.items() if not name.endswith("_seconds")}
    rest = replace(robot, links=tuple(replace(link, mesh=None) for link in robot.links), home=np.zeros(0))
    return repr(rest), robot.home.tobytes(), meshes, header, members


@pytest.mark.long
def test_cached_scene_equals_a_newly_prepared_one():
    scene = load_scene("poke")
    scene = replace(scene, cover=replace(scene.cover, links=("forearm",), taxels=40))
    assert find_prepared(scene) is None
    made = prepare_cached(scene)
    kept = find_prepared(scene)
    assert kept is not None
    assert kept.scene == scene
    assert _content(kept) == _content(made) == _content(prepare(scene))
    one = Session(made)
    other = Session(kept)
    for _ in range(60):
        ours = one.tick()
        theirs = other.tick()
    assert ours.pressures.any()
    assert np.array_equal(ours.posture, theirs.posture)
    assert np.array_equal(ours.pressures, theirs.pressures)


@pytest.mark.long
def test_cached_scene_has_the_objects_of_the_requested_scene(bar):
    prepare_cached(bar)
    other = replace(bar, name="other", objects=(ObjectSpec("ball", "sphere", size=(0.05,), mass=1.0),))
    kept = find_prepared(other)
    assert kept is not None
    assert (kept.scene.name, [body.spec.name for body in kept.objects]) == ("other", ["ball"])


@pytest.mark.long
def test_axes_of_a_cover_are_kept_by_the_cache_and_by_the_attachments_of_a_recording(bar):
    prepare_cached(bar)
    three = replace(bar, cover=replace(bar.cover, axes=3))
    assert find_prepared(three) is None
    assert prepare_cached(three).skin.three_axis.all()
    kept = find_prepared(three)
    assert kept is not None
    assert kept.skin.three_axis.all()
    replayed = unpack_scene(pack_scene(kept), file="touch.mcap")
    assert replayed.scene.cover.axes == 3
    assert replayed.skin.three_axis.all()
    np.testing.assert_array_equal(taxel_frames(replayed.map), taxel_frames(kept.map))


COVER = CoverSpec(links=("bar",), taxels=13, thickness=0.01)


@pytest.mark.parametrize("change", [{"cover": COVER}, {"package_roots": ("/",)}, {"home": {"hinge": 0.5}}])
def test_entry_is_not_used_for_another_scene(bar, change):
    prepare_cached(bar)
    assert find_prepared(bar) is not None
    assert find_prepared(replace(bar, **change)) is None


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("bar.obj", CUBE.format(x=0.2)),
        ("bar.xml", BAR.replace("-1 1", "-2 2")),
        ("bar.obj", None),
    ],
)
def test_entry_is_not_used_after_a_change_of_a_file(bar, file, text):
    prepare_cached(bar)
    path = Path(bar.robot).with_name(file)
    path.unlink() if text is None else path.write_text(text)
    assert find_prepared(bar) is None


def test_entry_is_not_used_after_a_mapping_file_is_added(bar, tmp_path):
    table = tmp_path / "taxels.csv"
    places = [(x, y) for x in range(6) for y in range(6)]
    table.write_text("x_mm,y_mm,z_mm\n" + "".join(f"{16 * x},{16 * y},100\n" for x, y in places))
    scene = replace(bar, taxel_files=(str(table),))
    prepare_cached(scene)
    assert find_prepared(scene) is not None
    mapping_path(table).write_text('position = ["y_mm", "x_mm", "z_mm"]\nunit = "mm"\n')
    assert find_prepared(scene) is None


@pytest.mark.long
def test_entry_of_another_program_is_not_used(bar, monkeypatch):
    prepare_cached(bar)
    monkeypatch.setattr(prepared_cache, "program_digest", lambda: "another")
    assert find_prepared(bar) is None


@pytest.mark.long
def test_robot_with_a_missing_mesh_is_not_cached(bar, folder):
    mesh = Path(bar.robot).with_name("bar.obj")
    mesh.unlink()
    assert prepare_cached(bar).robot.links[0].missing
    assert cache_content().entries == 0
    mesh.write_text(CUBE.format(x=0.1))
    assert not prepare_cached(bar).robot.links[0].missing
    assert cache_content().entries == 1


def test_robot_with_an_omitted_mesh_is_not_cached(bar, folder):
    model = Path(bar.robot)
    model.with_name("bar.obj").unlink()
    model.write_text(BAR.replace("</body>", '<geom type="box" size=".1 .1 .1"/></body>'))
    (link,) = prepare_cached(bar).robot.links
    assert link.left_out
    assert not link.missing
    assert cache_content().entries == 0


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("keep", [0.5, 0.97])
def test_damaged_entry_is_replaced(bar, folder, keep):
    prepare_cached(bar)
    [entry] = folder.iterdir()
    data = entry.read_bytes()
    entry.write_bytes(data[: int(keep * len(data))])
    assert find_prepared(bar) is None
    prepare_cached(bar)
    assert find_prepared(bar) is not None


def test_entry_with_an_invalid_member_is_not_used(bar, folder):
    prepare_cached(bar)
    [entry] = folder.iterdir()
    with zipfile.ZipFile(entry) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(entry, "w") as archive:
        for name, data in members.items():
            archive.writestr(name, b"[]" if name == "robot.zip" else data)
    assert find_prepared(bar) is None
    assert load_robot_cached(bar).joints[0].name == "hinge"


def test_entries_unused_for_the_longest_time_are_deleted_first(bar, folder, monkeypatch):
    prepare_cached(bar)
    [first] = folder.iterdir()
    monkeypatch.setattr(prepared_cache, "MOST_BYTES", int(2.5 * first.stat().st_size))
    second = replace(bar, cover=COVER)
    prepare_cached(second)
    for age, path in enumerate([first, *(path for path in folder.iterdir() if path != first)]):
        os.utime(path, (1000 - age, 1000 - age))
    find_prepared(second)  # which makes it the one used last
    prepare_cached(replace(bar, cover=replace(bar.cover, taxels=14)))
    assert find_prepared(bar) is None
    assert find_prepared(second) is not None


@pytest.mark.long
def test_cache_can_be_disabled(bar, folder, monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, "off")
    prepare_cached(bar)
    assert find_prepared(bar) is None
    assert not folder.exists()
    assert cache_content().folder is None


@pytest.mark.long
def test_scene_is_prepared_without_a_writable_folder(bar, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "file" / "below"))
    assert prepare_cached(bar).robot.joints[0].name == "hinge"
    assert find_prepared(bar) is None


@pytest.mark.long
def test_clearing_keeps_other_files(bar, folder):
    prepare_cached(bar)
    (folder / "mine.txt").write_text("kept")
    assert clear_cache().entries == 1
    assert cache_content().entries == 0
    assert [path.name for path in folder.iterdir()] == ["mine.txt"]
