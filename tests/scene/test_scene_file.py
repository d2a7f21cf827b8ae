"""Scenes as TOML, by name or file: what is written reads as an equal scene, and every mistake is named."""

from __future__ import annotations

from dataclasses import fields, replace

import pytest

from tactile_maps.core.assets import asset
from tactile_maps.core.errors import SceneError
from tactile_maps.scene.motion import Waypoint
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_file import (
    load_scene,
    scene_for,
    scene_from_toml,
    scene_in_folder,
    scene_names,
    scene_to_toml,
    with_grid,
    with_link,
    with_taxels,
    without_link,
)
from tactile_maps.skin.fitting.cover import CoverSpec
from tactile_maps.skin.fitting.grid import GridSpec
from tactile_maps.stimuli.stimulus_kinds import Babble, Stroke
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer

FULL = Scene(
    name='a "quoted"\tname \\ \x7f µ',
    robot="C:\\robots\\x.urdf",
    title="Ünï\n",
    home={"elbow": 1 / 3, "odd joint": -1.0},
    package_roots=("C:\\packages", "/more"),
    task="self-touch",
    outputs=("readings", "joint_torque"),
    cover=CoverSpec(
        links=("a", "b"),
        taxels=50,
        thickness=0.002,
        seed=3,
        pitch=1 / 300,
        pattern="hexagonal",
        margin=0.02,
        axes=3,
        bare=("b",),
    ),
    more_covers=(CoverSpec(links=("c",), taxels=5), CoverSpec(links=("d",), pitch=1 / 300)),
    layer=ElasticLayer(stiffness=1e5 / 3, modulus=2e5, poisson=0.1, thickness=0.005, depth=0.001, friction=1.0),
    description='What it "shows".',
    suggestion="What to try.",
    taxel_files=("t.txt",),
    grids=(
        GridSpec("arm", 3, 4, (0.0, 1 / 3, -1.0), (0.1, 0.2, 0.3), aspect=0.5, mirrored=True, axes=3),
        GridSpec("arm", 3, 4, (0.0, 1 / 3, -1.0), (0.1, 0.2, 0.3)),
    ),
    objects=(
        ObjectSpec("box", "box", size=(0.1, 0.2, 0.3), at=(1.0, 2.0, 1 / 3), turn=(10.0, 0.0, -90.0), mass=0.1),
        ObjectSpec("probe 2", "probe", size=(0.01,), path=((0.0, 1.0, 2.0, 3.0), (1.5, 0.1, 0.2, 0.3)), max_force=3.0),
        ObjectSpec("mesh", "mesh", size=(2.0,), file="a b.stl", friction=0.1, stiffness=7.0, damping=0.2),
    ),
    overrides={"gravity": "on", "timestep": 0.0005, "noise": {"sd": 1 / 3}, "sampling": "off", "friction": "on"},
    control={
        "controller": "hold_force",
        "integral_time": float("inf"),
        "odd key": 1.0,
        "path": ((0.1, 1 / 3), (-1.0, 0.0)),
    },
    reading={"estimator": "tikhonov", "threshold": 1 / 3},
    behaviours=(
        {"on": "tap", "where": "upper_arm", "above": 0.5, "then": {"task": "retreat", "force_goal": 1 / 3}},
        {"on": "press", "until_released": True, "then": {"controller": "hybrid"}},
    ),
    motion=(Waypoint({"elbow 1": 0.1, "x": -2.0}, seconds=1 / 3, rest=0.5, unit="deg"), Waypoint((0.1, 0.2))),
    stimuli=(Stroke(), Stroke(patch="x", start=(0.0, 1.0), force=1.5), Babble(touches=3, begin=0.5)),
    tick=0.01,
    repeat_stimuli=False,
    seed=7,
)


def test_every_field_is_written_and_read():
    plain = Scene(name="n", robot="arm")
    same = [field.name for field in fields(Scene) if getattr(FULL, field.name) == getattr(plain, field.name)]
    assert not same, "each field must differ from its usual value here"
    assert scene_from_toml(scene_to_toml(FULL), name="n") == FULL
    assert scene_from_toml(scene_to_toml(plain), name="other") == plain


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("robot = ", "line 1.*not valid TOML|not valid TOML"),
        ("", "missing.*robot.*Write robot"),
        ("robot = 5", "line 1, robot.*word in quotes"),
        ("robt = 'arm'", "line 1, robt.*Did you mean robot"),
        ("robot = 'arm'\nrobot = 'arm'", "line 2"),
        ("robot = 'arm'\ntaxel_fil = 't.csv'", "line 2, taxel_fil: .*Did you mean taxel_file[?]"),
        ("robot = 'arm'\ntaxel_files = ['t.csv']", "line 2, taxel_files.*Did you mean taxel_file[?]"),
        ("robot = 'arm'\n[reading]\nthreshold = 'x'", "line 2, reading.*Choose one of:.* effects, control, contacts,"),
        ("robot = 'arm'\n[overrides]\ntimestep = 0.001", "line 2, overrides.*no such key"),
        ("robot = 'arm'\n[effectz]\ngravity = 'on'", "line 2, effectz.*Did you mean effects[?]"),
        ("robot = 'arm'\ntask = 'slied'", "line 2, task.*Did you mean slide.*view, touch"),
        ("robot = 'arm'\noutputs = ['pressures']", "line 2, outputs.*Did you mean pressure"),
        ("robot = 'arm'\noutputs = 'pressure'", "line 2, outputs.*list"),
        ("robot = 'arm'\n\n[effects]\ngravty = 'on'", "line 4, effects.gravty.*unknown effect.*Did you mean gravity"),
        ("robot = 'arm'\n[effects]\nzzz = 'on'", "line 3, effects.zzz.*Choose one of: dynamics"),
        ("robot = 'arm'\n[effects]\ngravity = 'sideways'", "line 3, effects.gravity.*sideways.*off, on, compensated"),
        ("robot = 'arm'\n[effects]\njoint_limits = 1", "line 3, effects.joint_limits.*auto, off, on"),
        ("robot = 'arm'\n[effects]\ntimestep = true", "line 3, effects.timestep"),
        ("robot = 'arm'\n[effects]\ntimestep = '1 ms'", "line 3, effects.timestep.*seconds: write 0.001"),
        ("robot = 'arm'\n[effects.noise]\nds = 1", "line 3, effects.noise.ds.*unknown option.*sd"),
        ("robot = 'arm'\n[effects]\nnoise = { sd = -1 }", "line 3, effects.noise.sd"),
        ("robot = 'arm'\neffects = 3", "line 2, effects.*must be a table"),
        ("robot = 'arm'\n[cover]\ntaxels = 10000000", "line 3, cover.taxels.*10000000"),
        ("robot = 'arm'\n[cover]\ntaxels = 1.5", "line 3, cover.taxels.*whole"),
        ("robot = 'arm'\n[cover]\nthickness = '3 mm'", "line 3, cover.thickness.*metres: write 0.003"),
        ("robot = 'arm'\n[cover]\npattern = 'hexagon'", "line 3, cover.pattern.*hexagonal"),
        ("robot = 'arm'\n[cover]\naxes = 2", "line 3, cover.axes.*number of axes.*2.*Choose 1"),
        ("robot = 'arm'\n[cover]\naxes = true", "line 3, cover.axes.*whole"),
        ("robot = 'arm'\n[cover]\nlinks = [1]", "line 3, cover.links.*word in quotes"),
        ("robot = 'arm'\n[cover]\ntask = 'view'", "line 3, cover.task.*at the top"),
        ("robot = 'arm'\n[layer]\npoisson = 0.5", "line 3, layer.poisson.*0 to 0.49"),
        ("robot = 'arm'\n[control]\ncontroller = [1]", "line 3, control.controller"),
        ("robot = 'arm'\n[control]\npath = 3", "line 3, control.path.*must be a list"),
        ("robot = 'arm'\n[control]\npath = [[0, 1],\n[0.2]]", "line 4, control.path.*list of 2, but it has 1"),
        ("robot = 'arm'\n[control]\npath = [[0, 1],\n\n[0.2, '1 mm']]", "line 5, control.path.*metres: write 0.001"),
        ("robot = 'arm'\n[control]\npath = [[0, inf]]", "line 3, control.path.*finite"),
        ("robot = 'arm'\n[control]\nstiffness = nan", "line 3, control.stiffness"),
        ("robot = 'arm'\n[control]\nstiffness = true", "line 3, control.stiffness"),
        ("robot = 'arm'\nobjects = 5", "line 2, objects.*tables.*objects"),
        ("robot = 'arm'\n[[objects]]\nkind = 'box'", "line 2, objects.*missing.*name"),
        (
            "robot = 'arm'\n[[objects]]\nname = 'b'\nkind = 'boxx'",
            "line 4, objects.kind.*Did you mean box.*probe, plane",
        ),
        ("robot = 'arm'\n[[objects]]\nname = 'b'\nkind = 'box'\nsize = [1]", "line 5, objects.size.*x, y, z"),
        (
            "robot = 'arm'\n[[objects]]\nname = 'b'\nkind = 'sphere'\nsize = ['5 mm']",
            "line 5, objects.size.*write 0.005",
        ),
        (
            "robot = 'arm'\n[[objects]]\nname = 'b'\nkind = 'sphere'\nsize = [1]\nmass = -1",
            "line 6, objects.mass.*0 to",
        ),
        ("robot = 'arm'\n" + "[[objects]]\nname = 'b'\nkind = 'plane'\n" * 2, "line 6, objects.name.*same name.*b"),
        ("robot = 'arm'\n[[motion]]\nposture = [1, 'x']", "line 3, motion.posture.*number"),
        (
            "robot = 'arm'\n[[motion]]\nposture = { elbow = '90 deg' }",
            "line 3, motion.posture.elbow.*radians: write 1.57",
        ),
        ("robot = 'arm'\n[[motion]]\nseconds = 0", "line 3, motion.seconds"),
        ("robot = 'arm'\n[[motion]]\nunit = 'degrees'", "line 3, motion.unit.*Did you mean deg"),
        ("robot = 'arm'\nstimuli = 5", "line 2, stimuli.*tables"),
        ("robot = 'arm'\n[[stimuli]]\nkind = 'strok'", "line 3, stimuli.kind.*Did you mean stroke"),
        ("robot = 'arm'\n[[stimuli]]\nkind = 'stroke'\nspeed = 0", "line 4, stimuli.speed"),
        ("robot = 'arm'\ntick = 0.00001", "line 2, tick"),
        ("robot = 'arm'\nseed = -1", "line 2, seed.*out of range.*-1"),
    ],
)
def test_invalid_entry_is_reported_with_its_line(text, words):
    with pytest.raises(SceneError, match=rf"(?s)^my file.*{words}") as caught:
        scene_from_toml(text, name="s", file="my file")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", scene_names())
def test_shipped_scenes_load_and_read_back(name):
    scene = load_scene(name)
    assert scene.name == name
    assert scene.title
    pulled = any(spec.path for spec in scene.objects)
    assert scene.stimuli or scene.motion or pulled or "task" in scene.control, "something must happen in it"
    assert scene_from_toml(scene_to_toml(scene), name="other") == scene
    assert not scene.decision.warnings
    assert asset("scenes", f"{name}.toml").read_text().startswith("# "), "its first line says what it is for"


def test_file_names_are_relative_to_the_folder_of_the_scene(tmp_path):
    (tmp_path / "own.urdf").write_text("x")
    (tmp_path / "own.stl").write_text("x")
    path = tmp_path / "own.toml"
    path.write_text("robot = 'own.urdf'\n[[objects]]\nname = 'm'\nkind = 'mesh'\nfile = 'own.stl'\n")
    scene = load_scene(str(path))
    assert scene.robot == str(tmp_path / "own.urdf")
    assert scene.objects[0].file == str(tmp_path / "own.stl")
    path.write_text("robot = 'arm'\n")
    assert load_scene(str(path)) == replace(Scene(name="own", robot="arm"))


@pytest.mark.parametrize("content", [None, b"\xff\xfe", b"#" * 1_000_001])
def test_unreadable_file_is_rejected(tmp_path, content):
    path = tmp_path / "bad.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(SceneError, match="bad.toml"):
        load_scene(str(path))


def test_scene_with_its_files_can_be_moved_to_another_folder(tmp_path, monkeypatch):
    folder = tmp_path / "project"
    (folder / "parts").mkdir(parents=True)
    outside = tmp_path / "shared.csv"
    for file in (folder / "rod.xml", folder / "parts" / "ball.stl", folder / "arm", outside):
        file.touch()
    monkeypatch.chdir(folder)
    scene = replace(
        scene_for("rod.xml"),
        package_roots=(str(folder / "parts"),),
        taxel_files=(str(outside),),
        objects=(ObjectSpec("ball", "mesh", size=(1.0,), file=str(folder / "parts" / "ball.stl")),),
    )
    (folder / "s.toml").write_text(scene_to_toml(scene_in_folder(scene, folder)))
    assert scene_in_folder(scene_for("arm"), folder).robot == "arm", "the robot of the program, not the file"
    monkeypatch.chdir(tmp_path)
    moved = folder.rename(tmp_path / "moved")
    read = load_scene(str(moved / "s.toml"))
    assert read.robot == str(moved / "rod.xml")
    assert read.package_roots == (str(moved / "parts"),)
    assert read.taxel_files == (str(outside),)
    assert [spec.file for spec in read.objects] == [str(moved / "parts" / "ball.stl")]


def test_unknown_name_is_rejected_with_the_nearest_one():
    with pytest.raises(SceneError, match="self_tuch.*Did you mean self_touch"):
        load_scene("self_tuch")


def test_any_robot_has_a_default_scene():
    assert scene_for("arm") == load_scene("arm")
    scene = scene_for("/somewhere/my_robot.urdf")
    assert (scene.name, scene.title, scene.robot) == ("my_robot", "my_robot.urdf", "/somewhere/my_robot.urdf")
    assert scene.cover.links == ()
    assert len(scene.stimuli) == 1


def test_grid_replaces_the_cover_of_its_link():
    scene = scene_for("arm")
    grid = GridSpec("hand", 2, 2, (0.0, 0.0, 0.0), (0.1, 0.0, 0.0))
    added = with_grid(scene, grid, ("forearm", "hand", "forearm"))
    assert (added.grids, added.cover.links, added.cover.bare) == ((grid,), scene.cover.links, ("hand",))
    again = with_grid(added, grid, ("forearm", "hand"))
    assert len(again.grids) == 2
    on_taxels = with_grid(with_taxels(scene, ("t.csv",), links=("hand",)), grid, ("hand",))
    assert on_taxels.cover.links == ("hand",)  # there, it says which link carries the file's taxels


def test_covering_and_clearing_a_link_does_not_change_other_covers():
    scene = Scene("rods", "arm", cover=CoverSpec(("forearm", "hand"), taxels=90), stimuli=(Stroke(patch="hand 2"),))
    more = with_link(scene, CoverSpec(("wrist",), taxels=9))
    assert more == replace(scene, more_covers=(CoverSpec(("wrist",), taxels=9),))
    assert without_link(more, "wrist", ("forearm", "hand", "wrist")) == scene
    less = without_link(scene, "hand", ("forearm", "hand"))
    assert less.cover == replace(scene.cover, bare=("hand",))
    assert less.stimuli == (Stroke(),)
    assert with_link(less, CoverSpec(("hand",), taxels=9)).cover == scene.cover
    alone = without_link(without_link(more, "hand", ("forearm", "hand", "wrist")), "forearm", ("forearm", "wrist"))
    assert (alone.cover, alone.more_covers) == (CoverSpec(("wrist",), taxels=9), ())


def test_automatic_cover_lists_its_links_after_one_is_cleared():
    scene = scene_for("/somewhere/my_robot.urdf")
    less = without_link(scene, "a", ("b", "a", "a"))
    assert (less.cover.links, less.cover.bare) == (("b", "a"), ("a",))


def test_invalid_further_cover_is_rejected():
    with pytest.raises(SceneError, match=r"line 2, more_covers.*names no links"):
        scene_from_toml("robot = 'arm'\n[[more_covers]]\ntaxels = 9", name="n")
    with pytest.raises(SceneError, match=r"line 4, cover\.bare.*not a link of the cover.*x.*Choose among.*: a, b"):
        scene_from_toml("robot = 'arm'\n[cover]\nlinks = ['a', 'b']\nbare = ['x']", name="n")


@pytest.mark.parametrize(
    ("lines", "problem"),
    [
        ("link = 'hand'\nrows = 0\ncolumns = 3\nfirst = [0, 0, 0]\nlast = [0, 0, 1]", "line 4, grids.rows.*1 to 256"),
        ("link = 'hand'\nrows = 1\ncolumns = 1\nfirst = [0, 0, 0]\nlast = [0, 0, 1]", "at least two taxels"),
        ("link = 'hand'\nrows = 2\ncolumns = 3\nfirst = [0, 0]\nlast = [0, 0, 1]", "line 6, grids.first"),
        ("link = 'hand'\nrows = 2\ncolumns = 3\nfirst = [0, 0, 0]\nlast = [0, 0, 1]\naspect = 99", "grids.aspect"),
    ],
)
def test_invalid_entry_of_a_grid_is_reported_with_its_line(lines, problem):
    with pytest.raises(SceneError, match=problem):
        scene_from_toml(f"robot = 'arm'\n[[grids]]\n{lines}", name="n")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("robot = 'arm'\ntaxel_file = 'gone.csv'\n", "line 2, taxel_file: there is no such file .found: gone.csv"),
        (
            "robot = 'arm'\n[[objects]]\nname = 'm'\nkind = 'mesh'\nfile = 'gone.stl'\n",
            "line 5, objects.file: there is no such file .found: gone.stl.. Name a file relative to the scene's folder",
        ),
    ],
)
def test_missing_file_is_rejected_at_its_line(tmp_path, text, words):
    (tmp_path / "own.toml").write_text(text)
    with pytest.raises(SceneError, match=words):
        load_scene(str(tmp_path / "own.toml"))
