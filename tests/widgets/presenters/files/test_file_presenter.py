"""Files in the window: recordings, robots, scenes, files dropped on it, and closing in the middle of it all."""

from __future__ import annotations

import json
import multiprocessing as mp
import shlex
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PySide6.QtGui import QAction, QDesktopServices, QGuiApplication
from PySide6.QtWidgets import QInputDialog, QMenu, QMessageBox

from tactile_maps.cli.parser import build_parser
from tactile_maps.cli.shared.scenes import scene_from_arguments
from tactile_maps.core.assets import asset
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.verify import verify
from tactile_maps.scene.scene_file import load_scene, scene_for, scene_for_taxels, scene_names
from tactile_maps.session.prepare import load_robot_and_skin
from tactile_maps.skin.formats.import_skin import NO_ROBOT
from tactile_maps.skin.formats.taxel_files import write_taxels
from tactile_widgets.common.file_dialogs import FileDialog
from tactile_widgets.common.mode import Mode
from tactile_widgets.dialogs.study_dialog import StudyDialog
from tactile_widgets.presenters.files.file_presenter import likely_link, scene_words
from tactile_widgets.session.backends import INLINE
from tactile_widgets.views.interaction.view_tool import PointedAt
from tests.support.taxel_formats import FORMATS, LINK, cylinder_taxels, write_formats
from tests.widgets.support.executors import in_process
from tests.widgets.support.mouse import left_release
from tests.widgets.support.window_driver import answer, cancel, drop, press_map, run


@pytest.fixture
def window(window_again):
    """Scenes are prepared at once; a window that closes, or needs the process, is a ``new_window``."""
    return window_again


@pytest.fixture
def backends():
    """Prepare scenes of a ``new_window`` in a process, as in the program."""
    return replace(INLINE, executor=in_process("prepare"))


@pytest.mark.long
def test_recording_is_stopped_replayed_scrubbed_and_left(new_window, qtbot, tmp_path):
    window = new_window
    window.action("record").trigger()
    assert window.live.recording.recorder is not None
    press_map(window, 70)
    run(window, 0.6)
    left_release(window.map_view.viewport())
    run(window, 0.2)
    window.action("record").trigger()
    (file,) = (tmp_path / "recordings").glob("*.mcap")
    assert str(file) in window.notification_bar.text
    player = RecordingPlayer(file)
    assert len(player) == round(0.8 / window.live.prepared.scene.tick) + 1
    assert verify(player).identical
    with qtbot.waitSignal(window.live.replay.player_changed, timeout=60_000):
        window.presenters.files.open_path(str(file))
        assert window.live.mode is Mode.RUNNING, "the session runs until the recording is open"
    assert window.live.mode is Mode.REPLAYING
    window.timeline.scrubbed.emit(0.5)
    assert window.live._shown.regions, "half a second in, the finger was down"
    window.action("pause").trigger()
    assert window.timeline.playhead.playing
    window.action("pause").trigger()
    quality = window.column["quality"].findChild(object, "quality-bijective")
    window.live.measurements.map_executor.run_waiting()
    assert quality.text() == "yes"
    window.timeline.live_requested.emit()
    assert window.live.mode is Mode.RUNNING
    assert window.live._shown.tick == window.live.runner.session.frame.tick


@pytest.mark.long
def test_closing_while_recording_completes_the_file(new_window, tmp_path):
    window = new_window
    window.action("record").trigger()
    run(window, 0.3)
    window.close()
    (file,) = (tmp_path / "recordings").glob("*.mcap")
    assert RecordingPlayer(file).complete


@pytest.mark.long
@pytest.mark.parametrize("name", ["nothing.urdf", "picture.docx", "broken.mcap"])
def test_invalid_file_shows_one_message_and_keeps_the_scene(window, qtbot, tmp_path, name):
    path = tmp_path / name
    if name != "nothing.urdf":
        path.write_bytes(b"not what it says")
    before = window.live.prepared
    window.presenters.files.open_path(str(path))
    qtbot.waitUntil(lambda: bool(window.notification_bar.text), timeout=20_000)
    assert str(path) in window.notification_bar.text
    assert "Traceback" not in window.notification_bar.text
    assert window.live.prepared is before
    assert window.live.mode is Mode.RUNNING
    run(window, 0.1)


@pytest.mark.long
def test_another_robot_is_prepared_while_the_session_runs(new_window, qtbot, tmp_path):
    window = new_window
    path = tmp_path / "ball.obj"
    steps = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = [(0.1 * np.cos(a), 0.1 * np.sin(a), z) for z in (0.0, 0.2) for a in steps]
    faces = [
        f"f {i + 1} {(i + 1) % 24 + 1} {i + 25}\nf {(i + 1) % 24 + 1} {(i + 1) % 24 + 25} {i + 25}" for i in range(24)
    ]
    path.write_text("\n".join(["v {:.5f} {:.5f} {:.5f}".format(*v) for v in ring] + faces))
    with qtbot.waitSignal(window.live.prepared_changed, timeout=60_000):
        window.presenters.files.open_path(str(path))
    assert window.live.prepared.robot.joints == ()
    assert window.live.mode is Mode.RUNNING
    run(window, 0.2)
    assert window.settings.recent[0] == str(path)


@pytest.mark.long
def test_cancelled_loading_keeps_the_scene(new_window, qtbot):
    window = new_window
    before = window.live.prepared
    with qtbot.waitSignal(window.live.loading_ended):
        window.presenters.files.open_robot("arm")
        window.live.cancel_loading()
    assert window.live.prepared is before
    run(window, 0.1)


@pytest.mark.long
def test_closing_during_loading_leaves_no_process(new_window):
    window = new_window
    window.presenters.files.open_robot("arm")
    assert window.live.scene_jobs.executor.pid in {process.pid for process in mp.active_children()}
    window.close()
    assert window.live.scene_jobs.executor.pid is None
    assert not mp.active_children()


@pytest.mark.long
def test_reset_starts_again_and_ends_the_recording(window, tmp_path):
    run(window, 0.3)
    window.action("record").trigger()
    run(window, 0.2)
    window.action("reset").trigger()
    assert window.live.recording.recorder is None
    assert window.live.runner.session.frame.tick == 0
    (file,) = (tmp_path / "recordings").glob("*.mcap")
    assert verify(RecordingPlayer(file)).identical


def test_failed_or_cancelled_files_are_not_recent_files(window, tmp_path, monkeypatch):
    broken = tmp_path / "broken.mcap"
    unwanted = tmp_path / "robot.xml"
    broken.write_bytes(b"?" * 100)
    unwanted.write_text("<mujoco><worldbody/></mujoco>")
    window.presenters.files.open_path(str(broken))
    assert window.notification_bar.text
    monkeypatch.setattr(window.live.scene_jobs.executor, "hold", True)
    window.presenters.files.open_path(str(unwanted))
    cancel(window)
    window.live.show_prepared(window.live.prepared)
    assert {str(broken), str(unwanted)}.isdisjoint(window.settings.recent)


def test_saved_recording_is_replayed_and_shown_in_its_folder(window, monkeypatch, tmp_path):
    shown = []
    monkeypatch.setattr(QDesktopServices, "openUrl", lambda url: shown.append(url.toLocalFile()))
    window.action("record").trigger()
    run(window, 0.1)
    window.action("record").trigger()
    (file,) = (tmp_path / "recordings").glob("*.mcap")
    window.action("show_saved").trigger()
    assert shown == [str(file.parent)]
    window.action("replay_saved").trigger()
    assert window.live.replay.player is not None
    assert window.live.replay.player.path == file
    window.live.replay.leave()


@pytest.mark.long
def test_command_line_of_scene_and_recording_is_copied(window, monkeypatch, tmp_path):
    window.action("copy_command").trigger()
    assert QGuiApplication.clipboard().text() == "tactile-maps gui --scene arm"
    assert "left out" in window.statusBar().currentMessage(), "the tests' arm has fewer taxels"
    window.action("record").trigger()
    run(window, 0.1)
    window.action("record").trigger()
    window.action("replay_saved").trigger()
    window.action("copy_command").trigger()
    assert shlex.split(QGuiApplication.clipboard().text()) == [
        "tactile-maps",
        "replay",
        str(window.live.replay.player.path),
    ]
    window.live.replay.leave()


@pytest.mark.parametrize(
    ("scene", "file", "words"),
    [
        (load_scene("push_box"), None, ["gui", "--scene", "push_box"]),
        (load_scene("push_box"), Path("a b.toml"), ["gui", "--scene", "a b.toml"]),
        (scene_for("two_arms"), None, ["gui", "--robot", "two_arms"]),
        (scene_for_taxels("skin.csv"), None, ["gui", "--robot", NO_ROBOT, "--skin", "skin.csv"]),
    ],
)
def test_command_line_opens_the_scene(scene, file, words):
    assert scene_words(scene, file) == (words, False)
    parsed = build_parser().parse_args(words)
    assert parsed.command == "gui"


@pytest.mark.parametrize("named", [["--scene", "push_box"], ["--robot", "two_arms"], ["--scene", "own.toml"]])
def test_copied_command_line_states_the_home_posture(named, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("own.toml").write_text("robot = 'arm'\n[home]\nelbow_pitch = 1.0\nwrist_pitch = 0.25\n")
    home = "elbow_pitch=1.25,shoulder_pitch=-0.1"
    scene = scene_from_arguments(build_parser().parse_args(["gui", *named, "--home", home]))
    words, left_out = scene_words(scene, Path("own.toml") if "own.toml" in named else None)
    assert words == ["gui", *named, f"--home={home}"]
    assert not left_out
    assert scene_from_arguments(build_parser().parse_args(words)).home == scene.home


def test_file_dialog_opens_in_the_folder_of_the_last_file_that_could_be_opened(window, monkeypatch, tmp_path):
    good = tmp_path / "good" / "study.csv"
    good.parent.mkdir()
    shutil.copy(min(asset("findings").glob("*.csv")), good)
    chosen = iter([tmp_path / "none.csv", good, "", ""])
    folders = []
    monkeypatch.setattr(
        FileDialog, "open_file", lambda _parent, _title, folder, _kinds: folders.append(folder) or str(next(chosen))
    )
    for name in ("open_study", "open_study", "open_study", "open_scene"):
        window.action(name).trigger()
    assert folders == [str(tmp_path), str(tmp_path), str(good.parent), str(tmp_path)], "each kind has its own"
    for dialog in window.findChildren(StudyDialog):
        dialog.close()


@pytest.mark.long
def test_scenes_are_listed_with_title_and_description(window, monkeypatch):
    opened = []
    monkeypatch.setattr(window.live, "open_scene", lambda scene, file=None: opened.append(scene))
    menu = window.findChild(QMenu, "scenes")
    for _ in range(2):
        menu.aboutToShow.emit()
    assert len(menu.actions()) == len(scene_names())
    for name in scene_names():
        item = window.findChild(QAction, f"scene-{name}")
        scene = load_scene(name)
        assert item.text() == (scene.title or name)
        assert item.toolTip() == f"{scene.description}\nTry: {scene.suggestion}"
        assert scene.description.endswith("."), name
        assert scene.suggestion.endswith("."), name
        item.trigger()
        assert opened[-1].name == scene.name
    assert len(opened) == len(scene_names()) >= 8


def test_saved_scene_contains_the_chosen_effects(window, choose_file, tmp_path):
    window.column["effects"].override_requested.emit("friction", "on")
    run(window, 0.02)
    path = tmp_path / "mine"
    choose_file("save_file", path)
    window.action("save_scene").trigger()
    saved = path.with_suffix(".toml")
    assert str(saved) in window.notification_bar.text
    assert str(saved) in window.settings.recent
    again = load_scene(str(saved))
    assert again.effects == window.live.runner.session.effects
    assert again == replace(window.presenters.effects.scene, name=again.name)


def test_failed_saving_of_a_scene_shows_a_message(window, tmp_path):
    window.presenters.scene_file.save(str(tmp_path / "no such folder" / "scene.toml"))
    assert "cannot be written" in window.notification_bar.text


def test_taxels_of_a_robot_with_touch_sensors_are_imported(window, monkeypatch, tmp_path):
    path = tmp_path / "plate.xml"
    path.write_text(
        '<mujoco><worldbody><body name="plate"><geom type="box" size=".1 .1 .1"/><site name="s" pos="0 0 .1"/></body>'
        '</worldbody><sensor><touch site="s"/></sensor></mujoco>'
    )
    opened = []
    monkeypatch.setattr(FileDialog, "open_files", lambda *_args: [str(path)])
    monkeypatch.setattr(window.live, "open_scene", lambda scene, file=None: opened.append(scene))
    window.action("import_taxels").trigger()
    window.presenters.files.open_path(str(path))
    assert [(scene.robot, scene.taxel_files) for scene in opened] == [(str(path), (str(path),)), (str(path), ())]


def test_scene_file_is_opened_or_its_error_shown(window, monkeypatch, choose_file, tmp_path):
    path = tmp_path / "own.toml"
    path.write_text('robot = "arm"\n[effects]\nfriction = "maybe"\n')
    choose_file("open_file", path)
    window.action("open_scene").trigger()
    assert "own.toml" in window.notification_bar.text
    assert "maybe" in window.notification_bar.text
    opened = []
    monkeypatch.setattr(window.live, "open_scene", lambda scene, file=None: opened.append(scene))
    path.write_text('robot = "arm"\n[effects]\nfriction = "on"\n')
    window.action("open_scene").trigger()
    assert opened[0].effects.friction


@pytest.fixture
def skin_files(tmp_path):
    return write_formats(tmp_path)


@pytest.mark.long
def test_taxel_files_of_all_formats_are_opened_and_dropped(window, monkeypatch, skin_files):
    window.presenters.files.open_path(str(skin_files["robot.urdf"]))
    opened = []
    monkeypatch.setattr(window.live, "open_scene", lambda scene, file=None: opened.append(scene))
    for name in FORMATS:
        if name == "map.npz":
            continue  # a map of the skin that is open, which is taken as an edit
        window.presenters.files.open_path(str(skin_files[name]))
        if name == "robot_in_its_skin.urdf":  # its own robot replaces the skin in preparation
            answer(window, QMessageBox.StandardButton.Discard)
        assert opened, (name, window.notification_bar.text)
        found = opened.pop()
        assert found.taxel_files == (str(skin_files[name]),)
        assert len(load_robot_and_skin(found)[1]) == 30, name
        drop(window, skin_files[name])
        if name == "robot_in_its_skin.urdf":
            answer(window, QMessageBox.StandardButton.Discard)
        assert opened.pop() == found


def press(window, answer):
    """Press a button of the question whether taxels replace those of other files."""
    (box,) = [box for box in window.findChildren(QMessageBox, "taxels-again") if box.isVisible()]
    next(button for button in box.buttons() if button.text() == answer).click()


@pytest.mark.long
def test_taxel_files_are_merged_replaced_or_added_as_one_step(window, monkeypatch, tmp_path, skin_files):
    files = [tmp_path / f"{name}.csv" for name in ("first", "second", "third")]
    for number, file in enumerate(files):
        part = cylinder_taxels().select(np.arange(30) // 10 == number)
        write_taxels(part if number else replace(part, link=None), file)
    paths = tuple(map(str, files))
    robot = scene_for(str(skin_files["robot.urdf"]))
    window.presenters.files.open_scene(replace(robot, cover=replace(robot.cover, taxels=20)))
    covered = len(window.live.prepared.skin)
    monkeypatch.setattr(FileDialog, "open_files", lambda *_args: list(paths[:2]))
    window.action("import_taxels").trigger()
    box = window.findChild(QInputDialog, "taxel-link")
    assert "first.csv names no link of rods" in box.labelText()
    box.setTextValue(LINK)
    box.accept()
    shown = window.live.prepared
    assert (shown.scene.taxel_files, shown.scene.cover.links, len(shown.skin)) == (paths[:2], (LINK,), 20)
    drop(window, files[2])
    press(window, "Add")
    assert (window.live.prepared.scene.taxel_files, len(window.live.prepared.skin)) == (paths, 30)
    window.action("undo").trigger()
    assert window.live.prepared is shown
    drop(window, files[1])
    (box,) = [box for box in window.findChildren(QMessageBox, "taxels-again") if box.isVisible()]
    assert "Add" not in [button.text() for button in box.buttons()], "the skin has these taxels"
    press(window, "Cancel")
    assert window.live.prepared is shown
    drop(window, files[2], files[1])
    press(window, "Replace")
    assert window.live.prepared.scene.taxel_files == (paths[2], paths[1])
    assert window.settings.recent[0] == paths[1]
    window.action("undo").trigger()
    window.action("undo").trigger()
    assert len(window.live.prepared.skin) == covered


@pytest.mark.parametrize(
    ("name", "link"),
    [
        ("t_hand", "hand"),
        ("left_hand_2", "hand"),
        ("r_hand", "r_hand"),
        ("skin of upper arm", "upper_arm"),
        ("R_Hand", "r_hand"),
        ("j1", "j1"),
        ("skin_r_1", None),
        ("handle", None),
    ],
)
def test_link_named_by_a_file_is_likely(name, link):
    assert likely_link(name, ("base", "upper_arm", "arm", "hand", "r_hand", "link_1", "j1")) == link
    assert likely_link(name, ()) is None


def test_taxels_without_a_known_link_ask_for_the_link(window, monkeypatch, tmp_path):
    opened = []
    monkeypatch.setattr(window.live, "open_scene", lambda scene, file=None: opened.append(scene))
    write_taxels(cylinder_taxels(link=None), tmp_path / "unnamed.csv")
    drop(window, tmp_path / "unnamed.csv")
    box = window.findChild(QInputDialog, "taxel-link")
    assert "unnamed.csv names no link of arm" in box.labelText()
    assert box.comboBoxItems()[-1] == "No robot: the skin alone"
    assert {"forearm", "hand"} <= set(box.comboBoxItems())
    assert box.textValue() == box.comboBoxItems()[0]
    box.reject()
    write_taxels(cylinder_taxels(link=None), tmp_path / "t_hand.csv")
    drop(window, tmp_path / "t_hand.csv")
    box = window.findChildren(QInputDialog, "taxel-link")[-1]
    assert box.textValue() == "hand"
    box.accept()
    assert (opened[0].robot, opened[0].cover.links) == ("arm", ("hand",))
    drop(window, tmp_path / "unnamed.csv")
    box = window.findChildren(QInputDialog, "taxel-link")[-1]
    box.setTextValue("No robot: the skin alone")
    box.accept()
    answer(window, QMessageBox.StandardButton.Discard)  # the skin that is being prepared
    assert (opened[1].robot, opened[1].title) == (NO_ROBOT, "unnamed.csv")
    assert len(load_robot_and_skin(opened[1])[1]) == 30


@pytest.mark.long
def test_map_without_a_body_is_shown_and_touched(window, tmp_path):
    places = [{"id": k, "x": [8.0 * (k % 6), 8.0 * (k // 6)], "type": "pressure", "cut": 0} for k in range(30)]
    path = tmp_path / "map.json"
    path.write_text(json.dumps({"tactile_maps": {"name": "flat", "taxels": places, "faces": []}}))
    window.presenters.files.open_scene(scene_for_taxels(str(path)))
    assert len(window.live.prepared.skin) == 30, window.notification_bar.text
    kinds = {finding.kind for finding in window.live.prepared.skin.findings}
    assert {"map-only", "guessed-unit"} <= kinds
    assert "see the panel Findings" in window.statusBar().currentMessage()
    assert window.column["findings"].list.notes
    press_map(window, 14)
    run(window, 0.3)
    left_release(window.map_view.viewport())
    assert window.live._shown.pressures.max() > 0


@pytest.mark.long
@pytest.mark.parametrize("backends", [INLINE])
def test_meshes_in_another_folder_are_found_after_choosing_a_package_root(new_window, qtbot, tmp_path, choose_file):
    """The refusal offers to choose a folder; once chosen it is remembered and the robot opens."""
    window = new_window
    ball = '<mesh name="ball" file="../shared/ball.stl"/>'
    model = tmp_path / "robot" / "ball.xml"
    model.parent.mkdir()
    model.write_text(
        f'<mujoco><asset>{ball}</asset><worldbody><body name="tip"><joint/><geom type="mesh" mesh="ball"/></body>'
        "</worldbody></mujoco>"
    )
    (tmp_path / "shared").mkdir()
    trimesh.creation.icosphere(2, radius=0.05).export(tmp_path / "shared" / "ball.stl")
    window.presenters.files.open_path(str(model))
    assert "leaves the robot's folder" in window.notification_bar.text
    assert "--package-root" not in window.notification_bar.text
    remedy = window.notification_bar.findChild(object, "message-remedy")
    assert remedy.text() == "Choose package root"
    assert remedy.isVisibleTo(window.notification_bar)
    choose_file("choose_folder", tmp_path)
    remedy.click()
    assert [link.name for link in window.live.prepared.robot.links] == ["tip"]
    assert window.live.prepared.scene.package_roots == (str(tmp_path),)
    assert window.settings.package_roots == (str(tmp_path),)


def test_missing_mesh_is_reported_and_replaced(window, tmp_path):
    model = tmp_path / "lost.xml"
    (tmp_path / "Ball.obj").write_text("")
    model.write_text(
        '<mujoco><asset><mesh name="ball" file="ball.stl"/></asset><worldbody><body name="tip"><joint/>'
        '<geom type="mesh" mesh="ball"/></body><body name="arm" pos="0 0 1"><joint/><geom size=".1"/></body>'
        "</worldbody></mujoco>"
    )
    window.presenters.files.open_path(str(model))
    assert "ball.stl" in window.notification_bar.text
    assert "missing" in window.notification_bar.text
    assert "(link tip); replaced by a small box; similar files: Ball.obj" in window.notification_bar.text
    (placeholder,) = window.robot_view.display.actors.links._placeholders
    assert placeholder.prop.style == "Wireframe", "drawn as none of the robot's"
    assert window.presenters.pointing.resolve(PointedAt(body=0)).name == "tip (missing: ball)"
