"""Prepared scenes, and errors of scene files with their line."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import SceneError, TactileMapsError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepare import check_shapes, check_stimuli, findings_of, open_scene, prepare
from tactile_maps.session.session import Session
from tactile_maps.skin.fitting.cover import CoverSpec
from tests.support.hollows import hollow
from tests.support.touch import arm


@pytest.mark.long
def test_objects_are_made_in_the_order_of_the_scene():
    scene = load_scene("arm")
    specs = (ObjectSpec("floor", "plane"), ObjectSpec("ball", "sphere", size=(0.05,), mass=1.0))
    prepared = prepare(replace(scene, cover=CoverSpec(links=("hand",), taxels=20), objects=specs, stimuli=()))
    assert [body.spec for body in prepared.objects] == list(specs)
    assert prepared.objects[1].mesh.size == pytest.approx(0.1 * 3**0.5, rel=0.01)
    assert Session(prepared).frame.objects.shape == (2, 4, 4)


@pytest.mark.long
def test_pickled_scene_runs_identically():
    copy = pickle.loads(pickle.dumps(arm()))
    assert copy.scene == arm().scene
    assert np.array_equal(copy.map.taxel_points, arm().map.taxel_points)
    assert np.array_equal(Session(copy).tick().posture, Session(arm()).tick().posture)


@pytest.mark.long
def test_progress_increases_and_may_cancel():
    scene = load_scene("arm")
    scene = replace(scene, cover=replace(scene.cover, links=("hand",), taxels=30))
    reported = []
    prepare(scene, progress=lambda text, done: reported.append((text, done)))
    done = [fraction for _, fraction in reported]
    assert done == sorted(done)
    assert (done[0], done[-1]) == (0.0, 1.0)
    assert all(text for text, _ in reported)

    class StoppedError(Exception):
        """The person closed the window."""

    def stop(text, fraction):
        if fraction > 0.2:
            raise StoppedError

    with pytest.raises(StoppedError):
        prepare(scene, progress=stop)


@pytest.mark.long
@pytest.mark.parametrize(
    "scene",
    [
        Scene(name="s", robot="no such robot"),
        Scene(name="s", robot="arm", cover=CoverSpec(links=("no such link",))),
        Scene(name="s", robot="arm", taxel_files=("no such file.txt",)),
        Scene(name="s", robot="arm", objects=(ObjectSpec("mug", "mesh", file="no such file.stl"),)),
    ],
)
def test_missing_robot_link_or_file_is_named(scene):
    with pytest.raises(TactileMapsError, match="no such"):
        prepare(scene)


@pytest.mark.long
@pytest.mark.sampled(6)
@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ("robot = 'armm'", "line 2, robot.*Did you mean arm"),
        ("robot = 'gone.urdf'", "line 2, robot.*no such file.*gone.urdf"),
        ("robot = 'arm'\n[home]\nelbow_ptch = 1", "line 4, home.elbow_ptch.*Did you mean elbow_pitch"),
        ("robot = 'arm'\n[home]\n\nelbow_pitch = 9", "line 5, home.elbow_pitch.*out of range.*-2.35 to 2.35"),
        ("robot = 'arm'\n[home]\nelbow_pitch = 'bent'", "line 4, home.elbow_pitch.*a number"),
        ("robot = 'arm'\ntaxel_file = 'gone.txt'", "line 3, taxel_file.*gone.txt"),
        ("robot = 'arm'\n[cover]\nlinks = [\n'hand',\n'wing']", "line 6, cover.links.*wing"),
        ("robot = 'arm'\n[control]\n\nstiff_ness = 3", "line 5, control.stiff_ness.*stiffness"),
        ("robot = 'arm'\n[control]\ncontroller = 'magic'", "line 4, control.controller.*magic"),
        ("robot = 'arm'\n[control]\nstiffness = 1e9", "line 4, control.stiffness"),
        ("robot = 'arm'\n[contacts]\nestimator = 'tikonov'", "line 4, contacts.estimator.*Did you mean tikhonov"),
        ("robot = 'arm'\n[contacts]\n\nthreshold = -1", "line 5, contacts.threshold.*Choose 1 to"),
        ("robot = 'arm'\n[contacts]\nthreshold_pa = 1", "line 4, contacts.threshold_pa.*Did you mean threshold"),
        ("robot = 'arm'\n[contacts]\nthreshold = [1]", "line 4, contacts.threshold.*a number or a word"),
        (
            "robot = 'arm'\n[[motion]]\nposture = {}\n[[motion]]\nposture = { elbow_ptch = 1 }",
            "line 6.*Did you mean elbow_pitch",
        ),
        (
            "robot = 'arm'\n[[motion]]\nposture = { elbow_pitch = 9 }",
            "line 4, motion.posture.elbow_pitch.*-2.35 to 2.35",
        ),
        (
            "robot = 'arm'\n[[objects]]\nname = 'm'\nkind = 'mesh'\nfile = 'gone.stl'",
            "line 6, objects.file.*no such file.*gone.stl",
        ),
    ],
)
def test_invalid_entry_of_a_scene_file_is_reported_with_its_line(tmp_path, lines, words):
    path = tmp_path / "own.toml"
    path.write_text(f"# my own\n{lines}\n")
    with pytest.raises(SceneError, match=f"own.toml, {words}"):
        open_scene(str(path))


def test_unknown_patch_of_a_stimulus_is_named_with_its_line(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text("robot = 'arm'\n[[stimuli]]\nkind = 'poke'\n[[stimuli]]\nkind = 'poke'\npatch = 'nose'\n")
    prepared = replace(arm(), scene=load_scene(str(path)))
    with pytest.raises(SceneError, match=r"own.toml, line 6, stimuli.patch: unknown patch.*nose.*Choose one of: "):
        check_stimuli(prepared, str(path))


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (["patch = 'nose'", "points = [[0, 9, 9, 9], [1, 9, 9, 9]]"], "line 4, stimuli.patch: unknown patch"),
        (
            ["points = [[0, 9, 9, 9], [1, 9, 9, 9]]", "patches = [", "'forearm',", "'nose']"],
            r"line 7, stimuli.patches: unknown patch .found: nose",
        ),
        (["points = [[0, 9, 9, 9], [1, 9, 9, 9]]"], r"line 4, stimuli.points: this place is not on the skin"),
        (["at = [9, 9, 9]"], r"line 4, stimuli.at: .*not on the skin.*The patch \w+ is \d+ mm away"),
        (["start = [0.5, 0.2]", "end = [9, 9, 9]"], "line 5, stimuli.end: this place is not on the skin"),
    ],
)
def test_invalid_stimulus_is_located_at_its_key(tmp_path, lines, said):
    path = tmp_path / "own.toml"
    kind = {"p": "path", "a": "poke", "s": "stroke"}[lines[0][0]]
    path.write_text("\n".join(["robot = 'arm'", "[[stimuli]]", f"kind = '{kind}'", *lines, ""]))
    prepared = replace(arm(), scene=load_scene(str(path)))
    with pytest.raises(SceneError, match=f"own.toml, {said}"):
        check_stimuli(prepared, str(path))


@pytest.mark.long
def test_scene_states_the_home_of_its_robot(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text("robot = 'arm'\n[home]\nelbow_pitch = 1.0\n[cover]\nlinks = ['hand']\ntaxels = 20")
    session = Session(prepare(open_scene(str(path))))
    usual = arm().robot.home
    assert session.frame.posture[3] == 1.0
    assert np.delete(session.frame.posture, 3).tolist() == np.delete(usual, 3).tolist()


def test_home_of_a_skin_without_robot_is_rejected(tmp_path):
    taxels = tmp_path / "pad.csv"
    rows = [f"{x},{y},0,0,0,1" for x in (0, 0.01, 0.02, 0.03) for y in (0, 0.01, 0.02, 0.03)]
    taxels.write_text("x,y,z,nx,ny,nz\n" + "\n".join(rows))
    with pytest.raises(TactileMapsError, match="home.elbow: the robot has no such joint"):
        prepare(Scene(name="pad", robot="none", taxel_files=(str(taxels),), home={"elbow": 1.0}))


@pytest.mark.long
def test_valid_scene_opens(tmp_path):
    assert open_scene("slide") == load_scene("slide")
    path = tmp_path / "own.toml"
    path.write_text("robot = 'arm'\n[control]\nstiffness = 9\n[[motion]]\nposture = { elbow_pitch = 1 }")
    assert open_scene(str(path)) == load_scene(str(path))


@pytest.mark.long
@pytest.mark.parametrize(
    ("objects", "kinds"), [((), []), ((ObjectSpec("ball", "sphere", (0.01,)),), ["bare-part-open"])]
)
def test_shapes_that_omit_touchable_parts_are_reported(objects, kinds):
    """The mesh of the link has no area to wrap, so that only its skin, a bowl, collides."""
    robot, skin = hollow("bowl")
    degenerate = Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]]))
    robot = replace(robot, links=(replace(robot.links[0], mesh=degenerate),))
    scene = Scene("bowl", robot="arm", objects=objects)
    assert [finding.kind for finding in check_shapes(scene, robot, skin)] == kinds


@pytest.mark.parametrize(
    ("effects", "kinds"),
    [({}, ["sparse-pads"]), ({"area_averaging": "off"}, []), ({"area_averaging": {"radius": 0.01}}, [])],
)
def test_sparse_pads_are_reported_where_a_scene_averages_over_them(effects, kinds):
    scene = replace(arm().scene, outputs=("readings",), overrides=effects)
    found = [finding.kind for finding in findings_of(replace(arm(), scene=scene))]
    assert [kind for kind in found if kind == "sparse-pads"] == kinds


def test_touch_sensors_that_a_cover_replaces_are_reported(tmp_path):
    file = tmp_path / "finger.xml"
    file.write_text(
        """<mujoco><worldbody><body name="finger"><joint name="bend"/><geom type="box" size="0.02 0.02 0.05"/>
        <site name="pad" pos="0.02 0 0" size="0.005"/></body></worldbody>
        <sensor><touch name="pad" site="pad"/></sensor></mujoco>"""
    )
    covered = Scene("covered", robot=str(file), cover=CoverSpec(links=("finger",), taxels=20))
    (finding,) = (one for one in findings_of(prepare(covered)) if one.kind == "touch-sensors")
    assert "import the file as taxels" in finding.action
    imported = replace(covered, taxel_files=(str(file),), cover=CoverSpec())
    assert not [one for one in findings_of(prepare(imported)) if one.kind == "touch-sensors"]
