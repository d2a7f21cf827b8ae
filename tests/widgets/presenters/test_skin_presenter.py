"""Choice of the skin in the window: links checked in the panel, previewed, applied, undone, saved and opened again."""

from __future__ import annotations

import re
import time
from dataclasses import fields, replace
from functools import partial

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QPushButton, QStyle, QStyleOptionViewItem, QToolButton

from tactile_maps.editing.arrange import move
from tactile_maps.robots.load import load_robot_file
from tactile_maps.scene.scene_file import load_scene, with_grid
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.skin.fitting.cover import CoverCandidate, CoverSpec, cover_candidates
from tactile_maps.skin.fitting.grid import GridSpec
from tactile_widgets.common.mode import Mode
from tactile_widgets.context.notification_bar import READ_SECONDS
from tactile_widgets.dialogs.dialogs import Button
from tactile_widgets.dialogs.palette import matching
from tactile_widgets.jobs.skin_jobs import plan_cover
from tactile_widgets.panels.model.skin_panel import SkinChoice, SkinPanel
from tactile_widgets.session.live_input import LiveInputSettings
from tactile_widgets.views.interaction.view_tool import PointedAt
from tactile_widgets.window.palette_commands import action_commands
from tests.widgets.support.mouse import left_click
from tests.widgets.support.window_driver import answer, blow_up, run

pytestmark = pytest.mark.usefixtures("scene_cache")


RODS = """<mujoco model="rods"><worldbody><body name="base"><geom type="box" size=".05 .05 .05"/>
  <body name="left" pos="0 .2 0"><joint axis="1 0 0"/><geom type="capsule" size=".03" fromto="0 0 0 0 0 .2"/></body>
  <body name="right" pos="0 -.2 0"><joint axis="1 0 0"/><geom type="capsule" size=".03" fromto="0 0 0 0 0 .2"/></body>
</body></worldbody></mujoco>"""


@pytest.fixture
def window(window_again):
    window = window_again
    window.action("choose_skin").trigger()
    QApplication.processEvents()
    assert panel_of(window).tree.rows
    return window


def panel_of(window):
    return window.column.get(SkinPanel)


def counts(window):
    """Number of taxels of each link with skin, in the session."""
    skin = window.live.prepared.skin
    return {link: sum(len(p.taxels) for p in skin.patches if p.link == link) for link in {p.link for p in skin.patches}}


def listed(window):
    """Numbers of taxels that the panel lists, by link."""
    rows = panel_of(window).tree.rows
    return {link: int(row.text(2).replace(",", "")) for link, row in rows.items() if row.text(2).strip("…0")}


def click_box(window, link):
    """Click the check box of a link."""
    tree = panel_of(window).tree
    row = tree.rows[link]
    tree.scrollToItem(row)
    index = tree.indexFromItem(row)
    option = QStyleOptionViewItem()
    tree.initViewItemOption(option)
    option.rect = tree.visualRect(index)
    option.features |= QStyleOptionViewItem.ViewItemFeature.HasCheckIndicator
    box = tree.style().subElementRect(QStyle.SubElement.SE_ItemViewItemCheckIndicator, option, tree)
    left_click(tree.viewport(), box.center())


def click(window, name):
    left_click(panel_of(window).findChild(QPushButton, name))
    QApplication.processEvents()


def wait_for_counts(window, qtbot):
    """Wait until the preview of the choice is shown."""
    qtbot.waitUntil(lambda: "taxels on" in panel_of(window).note.text())


def previewed(window):
    """Links on which the robot view shows a preview."""
    preview = window.robot_view.display.actors._preview
    links = window.live.prepared.robot.links
    return set() if preview is None else {links[number].name for number, _ in preview.link_actors}


def refusal(window):
    label = panel_of(window).findChild(QLabel, "skin-refusal")
    return "" if label.isHidden() else label.text()


def test_checked_link_is_previewed_applied_undone_saved_and_opened_again(
    window, prepared, qtbot, tmp_path, choose_file
):
    before = counts(window)
    first = window.editor.document
    assert listed(window) == before
    click_box(window, "wrist")
    click_box(window, "upper_arm")
    axes = panel_of(window).axes
    axes.setCurrentIndex(axes.findData(3))
    axes.activated.emit(axes.currentIndex())
    assert counts(window) == before, "the session keeps its skin"
    wait_for_counts(window, qtbot)
    chosen = listed(window)
    assert chosen.keys() == {"forearm", "hand", "wrist"} == previewed(window)
    click(window, "skin-apply")
    run(window, 0.02)
    assert counts(window) == chosen
    assert previewed(window) == set()
    document = window.editor.document
    assert sorted(patch.link for patch in document.skin.patches) == ["forearm", "hand", "wrist"]
    assert len(document.map.taxel_points) == sum(chosen.values())
    assert np.isfinite(document.map.taxel_points).all()
    assert window.live.prepared.skin.three_axis.all()
    assert window.live.runner.session.map is document.map
    assert window.presenters.state.state.undo.undo_name == "Change skin"
    assert window.isWindowModified()
    window.action("undo").trigger()
    assert window.editor.document is first
    assert counts(window) == before == listed(window)
    assert axes.currentData() == 1
    window.action("redo").trigger()
    assert window.editor.document is document
    assert listed(window) == chosen
    choose_file("save_file", tmp_path / "own.toml")
    window.action("save_scene").trigger()
    assert not window.isWindowModified()
    window.live.show_prepared(prepared)
    assert counts(window) == before
    window.presenters.files.open_path(str(tmp_path / "own.toml"))
    assert counts(window) == chosen
    assert panel_of(window).tree.checked == ("forearm", "wrist", "hand")
    assert axes.currentData() == 3
    assert window.live.prepared.skin.three_axis.all()


def test_unchanged_values_and_revert_offer_nothing_to_apply(window, qtbot):
    panel = panel_of(window)
    assert not panel.apply.isEnabled()
    panel.pattern.setCurrentIndex(panel.pattern.findData("hexagonal"))
    panel.pattern.activated.emit(panel.pattern.currentIndex())
    panel.margin.setValue(15.0)
    wait_for_counts(window, qtbot)
    assert (panel.cover.pattern, panel.cover.margin) == ("hexagonal", 0.015)
    assert not panel.dense.isEnabled(), "only the even pattern follows a density"
    assert panel.apply.isEnabled()
    click(window, "skin-revert")
    assert panel.cover == replace(window.live.prepared.scene.cover)
    assert not panel.apply.isEnabled()
    assert previewed(window) == set()
    for link in panel.tree.checked:
        click_box(window, link)
    assert panel.note.text() == "Check at least one link."
    assert not panel.apply.isEnabled()


@pytest.mark.long
def test_impossible_choice_states_why_and_cannot_be_applied(window, qtbot):
    panel = panel_of(window)
    panel.amount.setCurrentIndex(panel.amount.findData("pitch"))
    panel.pitch.setValue(0.5)
    qtbot.waitUntil(lambda: "more than 20,000 taxels" in panel.note.text())
    assert not panel.apply.isEnabled()
    panel.pitch.setValue(20.0)
    wait_for_counts(window, qtbot)
    assert panel.apply.isEnabled()


@pytest.mark.parametrize("key", [Qt.Key.Key_Delete, Qt.Key.Key_Backspace])
def test_delete_unchecks_the_selected_link(window, key):
    panel = panel_of(window)
    tree = panel.tree
    first = tree.checked
    run(window, 0.1)
    time_before = window.live.runner.session.frame.time
    assert time_before > 0
    for link in ("wrist", first[0]):  # one without skin, and one with skin
        row = tree.rows[link]
        tree.scrollToItem(row)
        left_click(tree.viewport(), tree.visualItemRect(row).center())
        assert tree.checked == first
        QTest.keyClick(QApplication.focusWidget(), key)
    assert tree.checked == first[1:]
    assert panel.apply.isEnabled()
    assert window.live.runner.session.frame.time == time_before, "the scene is not reset"
    click(window, "skin-revert")
    assert tree.checked == first


@pytest.mark.long
def test_checked_link_without_taxels_states_the_reason(window, qtbot):
    """The reason is stated in the preview and for the applied skin."""
    panel = panel_of(window)
    click_box(window, "wrist")
    panel.margin.setValue(60.0)
    wait_for_counts(window, qtbot)
    row = panel.tree.rows["wrist"]
    for _ in range(2):
        assert row.text(2) == "0"
        line = next(line for line in panel.bare.text().splitlines() if line.startswith("⚠ wrist "))
        assert re.search(r" not covered: only \d+ cm² are clear of other links and visible, 12 taxels need ", line)
        assert row.toolTip(0) == f"wrist moves; {line.removeprefix('⚠ wrist ')}"
        click(window, "skin-apply")
    panel.margin.setValue(5.0)
    wait_for_counts(window, qtbot)
    assert row.text(2) != "0"
    assert panel.bare.isHidden()
    assert row.toolTip(0) == "wrist moves"


def test_reasons_of_two_links_without_taxels_are_written_out(qtbot):
    panel = SkinPanel()
    qtbot.addWidget(panel)
    names = ("a", "b", "c", "d")
    panel.show_candidates([CoverCandidate(name, 0.01, True) for name in names])
    panel.show_choice(SkinChoice(CoverSpec(names), {"a": 7}, dict.fromkeys(names, "has no room")), same_robot=True)
    lines = panel.bare.text().splitlines()
    assert lines == ["⚠ b has no room", "⚠ c has no room", "⚠ 1 more link without taxels: point at it for the reason"]


def test_names_that_differ_only_at_their_end_are_distinguished(window):
    tree = panel_of(window).tree
    names = [f"left_hand_index_finger_distal_phalanx_fingertip_link_{end}" for end in "ab"]
    tree.show_candidates([CoverCandidate(name, 0.01, True) for name in names])
    QApplication.processEvents()
    rows = [tree.viewport().grab(tree.visualItemRect(tree.rows[name])).toImage() for name in names]
    assert rows[0] != rows[1]
    assert [tree.rows[name].toolTip(0).split()[0] for name in names] == names
    panel_of(window).show_candidates(cover_candidates(window.live.prepared.robot, measured=False))


@pytest.mark.long
def test_newer_choice_cancels_the_preview_of_an_older_one(window, qtbot):
    preview = window.presenters.skin.preview
    preview.executor.hold = True
    click_box(window, "wrist")
    qtbot.waitUntil(lambda: preview.executor.busy)
    (older,) = preview.executor._waiting
    click_box(window, "elbow")
    assert older.done
    qtbot.waitUntil(lambda: preview.executor.busy)
    preview.executor.run_waiting()
    assert listed(window).keys() == {"upper_arm", "elbow", "forearm", "wrist", "hand"} == previewed(window)
    preview.executor.hold = False


def test_link_checked_before_the_areas_are_known_stays_checked(window):
    panel = panel_of(window)
    robot = window.live.prepared.robot
    panel.show_candidates(())
    panel.show_candidates(cover_candidates(robot, measured=False))
    assert not any(row.text(1) for row in panel.tree.rows.values())
    shown = panel.tree.checked
    bare = next(link for link, row in panel.tree.rows.items() if link not in shown and row.flags())
    panel.tree.rows[bare].setCheckState(0, Qt.CheckState.Checked)
    panel.show_candidates(cover_candidates(robot))
    assert set(panel.tree.checked) == {*shown, bare}
    assert panel.tree.rows[bare].text(1)


def test_links_without_a_shape_cannot_be_checked(window):
    tree = panel_of(window).tree
    candidates = cover_candidates(window.live.prepared.robot)
    tool = replace(candidates[-1], link="tool0", area=0.0, reason="it has no shape")
    panel_of(window).show_candidates([*candidates, tool])
    row = tree.rows["tool0"]
    assert row.flags() == Qt.ItemFlag.NoItemFlags
    assert row.toolTip(0) == "tool0 cannot be covered: it has no shape"


def draw_path(window, link):
    """Draw a path of two corners on a link."""
    skin = window.live.prepared.skin
    map_ = window.editor.document.map
    taxels = [k for k in range(len(skin)) if skin.link(skin.taxel_point(k)) == link]
    path = tuple(tuple(map_.to_map(skin.taxel_point(k)).tolist()) for k in (taxels[1], taxels[5]))
    window.presenters.control_tools.settings_editor.do("draw", controller="hybrid", path=path)
    run(window, 0.02)
    return path


def offered(window, link):
    """Entries of the context menu of a link, by name."""
    skin = window.live.prepared.skin
    taxels = [k for k in range(len(skin)) if skin.link(skin.taxel_point(k)) == link]
    body = window.live.prepared.robot.link_index[link]
    hit = PointedAt(skin.taxel_point(taxels[0])) if taxels else PointedAt(None, body)
    pointing = window.presenters.pointing
    return {action.name: action for action in pointing.actions(pointing.resolve(hit))}


@pytest.mark.long
def test_path_on_a_removed_link_is_reported_and_returns_with_undo(window):
    path = draw_path(window, "hand")
    offered(window, "hand")["remove-skin"].run()
    run(window, 0.02)
    assert counts(window).keys() == {"upper_arm", "forearm"}
    assert "the drawn path" in window.notification_bar.text
    settings = window.live.runner.session.settings
    assert (settings.controller, settings.path) == ("hybrid", ())
    window.action("undo").trigger()
    run(window, 0.02)
    assert window.live.runner.session.settings.path == path


@pytest.mark.long
def test_path_of_a_file_dropped_by_a_new_skin_is_not_an_unsaved_change(window, tmp_path):
    path = draw_path(window, "hand")
    file = tmp_path / "own.toml"
    scene = window.presenters.scene_file
    scene.save(str(file))
    window.presenters.files.open_path(str(file))
    run(window, 0.02)
    files = window.presenters.map_files
    assert files.unsaved == ()
    offered(window, "hand")["remove-skin"].run()
    run(window, 0.02)
    assert files.unsaved == ("skin",)
    window.action("undo").trigger()
    run(window, 0.02)
    assert files.unsaved == ()
    window.presenters.control_tools.settings_editor.clear_path()
    run(window, 0.02)
    assert files.unsaved == ("path",), "removed by the user"
    window.action("undo").trigger()
    run(window, 0.02)
    assert window.live.runner.session.settings.path == path
    offered(window, "hand")["remove-skin"].run()
    run(window, 0.02)
    assert files.unsaved == ("skin",)
    offered(window, "wrist")["cover"].run()
    run(window, 0.02)
    assert files.unsaved == ("skin",), "a second change of the skin"
    draw_path(window, "forearm")
    assert set(files.unsaved) == {"skin", "path"}


def same_patches(before, after):
    """Require that patches with their taxels, in the order of the skin, are equal to the last digit."""
    for one, other in zip(before, after, strict=True):
        assert (one.name, one.link) == (other.name, other.link)
        for mine, theirs in ((one.surface, other.surface), (one.taxels, other.taxels)):
            for name, value in vars(mine).items():
                if isinstance(value, np.ndarray) and name in {field.name for field in fields(mine)}:
                    np.testing.assert_array_equal(value, getattr(theirs, name), err_msg=f"{one.name}: {name}")


@pytest.mark.long
def test_other_links_keep_skin_and_map_to_the_last_digit_when_one_is_covered_and_cleared(window):
    window.editor.do("Move", partial(move, numbers=[1], by=(0.3, 0.1)))
    first = window.editor.document
    names = [patch.name for patch in first.skin.patches]
    offered(window, "wrist")["cover"].run()
    run(window, 0.02)
    covered = window.editor.document
    same_patches(first.skin.patches, covered.skin.patches[:3])
    assert covered.layout.placements[:3] == first.layout.placements
    assert covered.charts[:3] == first.charts
    offered(window, "forearm")["remove-skin"].run()
    run(window, 0.02)
    cleared = window.editor.document
    kept = [number for number, name in enumerate(names) if name != "forearm"]
    same_patches([first.skin.patches[number] for number in kept], cleared.skin.patches[:2])
    assert [cleared.layout.placements[k] for k in range(2)] == [first.layout.placements[number] for number in kept]
    offered(window, "wrist")["remove-skin"].run()
    offered(window, "forearm")["cover"].run()
    run(window, 0.02)
    same_patches(first.skin.patches, window.editor.document.skin.patches)
    assert window.presenters.map_files.unsaved == ("map",), "the skin is that of the scene again"


@pytest.mark.long
def test_skin_steps_do_not_count_as_map_edits(window, tmp_path, choose_file):
    for link in ("wrist", "elbow"):
        offered(window, link)["cover"].run()
        run(window, 0.02)
    assert window.presenters.map_files.unsaved == ("skin",)
    choose_file("save_file", tmp_path / "own.toml")
    skin = window.live.prepared.skin
    window.action("save_scene").trigger()
    assert window.presenters.map_files.unsaved == ()
    window.presenters.files.open_path(str(tmp_path / "own.toml"))
    same_patches(skin.patches, window.live.prepared.skin.patches)


@pytest.mark.long
def test_covered_link_gets_the_density_of_the_others_and_the_path_stays(window):
    before = counts(window)
    draw_path(window, "forearm")
    assert "remove-skin" not in offered(window, "wrist")
    offered(window, "wrist")["cover"].run()
    run(window, 0.02)
    after = counts(window)
    assert after.keys() == before.keys() | {"wrist"}
    assert {link: after[link] for link in before} == before
    patches = window.live.prepared.skin.patches
    density = [sum(p.taxels.areas.sum() for p in patches if p.link == link) / n for link, n in after.items()]
    assert max(density) < 1.5 * min(density)
    assert len(window.live.runner.session.settings.path) == 2
    assert not window.notification_bar.isVisible()
    assert window.presenters.state.state.undo.undo_name == "Cover wrist"


@pytest.mark.long
def test_behaviours_and_contact_detection_are_kept_after_a_change_of_the_skin(window):
    reading = replace(window.live.run.settings.reading, estimator="tikhonov")
    window.live.set_reading(reading)
    run(window, 0.02)
    offered(window, "wrist")["cover"].run()
    run(window, 0.02)
    assert window.live.run.settings.reading == reading


@pytest.mark.long
def test_paused_session_stays_paused_after_a_change_of_the_skin(window, prepared):
    window.action("pause").trigger()
    click_box(window, "wrist")
    for change in (partial(click, window, "skin-apply"), window.action("undo").trigger, window.action("redo").trigger):
        skin = window.live.prepared.skin
        change()
        run(window, 0.1)
        assert window.live.prepared.skin is not skin
        assert window.live.mode is Mode.PAUSED
        assert "paused" in window.windowTitle()
        assert window.live.runner.session.frame.time == 0.0, "the script has not started"
    window.action("pause").trigger()
    window.action("undo").trigger()
    assert window.live.mode is Mode.RUNNING
    window.action("pause").trigger()
    window.live.show_prepared(prepared)
    assert window.live.mode is Mode.RUNNING, "another scene runs"


@pytest.mark.long
def test_change_of_the_skin_starts_a_simulation_that_failed(window):
    blow_up(window.live)
    assert window.live.mode is Mode.PAUSED
    offered(window, "wrist")["cover"].run()
    assert window.live.mode is Mode.RUNNING


@pytest.mark.long
def test_reason_is_stated_if_the_skin_cannot_be_changed(window, tmp_path):
    panel = panel_of(window)
    assert refusal(window) == ""
    window.live.recording.start(tmp_path / "a.mcap")
    assert "being made" in refusal(window)
    assert not panel.tree.isEnabled()
    assert not {"cover", "remove-skin"} & offered(window, "wrist").keys()
    run(window, 0.1)
    window.live.recording.stop()
    assert refusal(window) == ""
    window.live.open_recording(tmp_path / "a.mcap")
    assert "go back to the live scene" in refusal(window)
    window.live.replay.leave()
    assert refusal(window) == ""
    (tmp_path / "readings.csv").write_text("# unit: Pa\ntime,0,1\n0.0,0,0\n0.1,0,0\n")
    window.live.connection.open(LiveInputSettings(str(tmp_path / "readings.csv")))
    assert "disconnect it" in refusal(window)
    window.action("disconnect").trigger()
    assert refusal(window) == ""
    assert panel.tree.isEnabled()


@pytest.fixture
def rods(tmp_path):
    """File of a robot that no scene describes."""
    (tmp_path / "rods.xml").write_text(RODS)
    return tmp_path / "rods.xml"


def begin_to_open_rods(window, path, *, discarding=False):
    """Open a robot until its skin is planned, as its process does before the skin is fitted; return the job.

    Args:
        window: The window.
        path: The file of the robot, or of a scene with it.
        discarding: Whether the question about unsaved changes is asked, and answered by discarding them.
    """
    opening = window.live.scene_jobs.executor
    opening.hold = True
    window.presenters.files.open_path(str(path))
    if discarding:
        answer(window, Button.Discard)
    (job,) = opening._waiting
    scene = load_scene(str(path)) if path.suffix == ".toml" else job.job.arguments[0]
    job.deliver("part", plan_cover(scene, load_robot_file(path.with_suffix(".xml"))))
    return job


@pytest.mark.long
def test_skin_that_is_chosen_before_the_opening_is_counted_when_the_panel_was_hidden(window_again, rods, qtbot):
    window = window_again
    assert not panel_of(window).isVisible()
    begin_to_open_rods(window, rods)
    window.action("choose_links").trigger()
    window.live.scene_jobs.executor.hold = False
    wait_for_counts(window, qtbot)
    assert listed(window).keys() == {"left", "right"}
    assert sum(listed(window).values()) == 1000
    click(window, "skin-revert")


def place(widget):
    """Return the upper left corner of a widget on the screen, once the nested layouts are current."""
    for _ in range(3):
        QApplication.processEvents()
    return widget.mapToGlobal(QPoint(0, 0))


def test_number_of_taxels_keeps_its_place_when_the_links_are_found(window, rods, qtbot):
    panel = panel_of(window)
    preview = window.presenters.skin.preview
    preview.executor.hold = True
    begin_to_open_rods(window, rods)
    window.action("choose_links").trigger()
    assert not panel.tree.rows
    assert panel.note.text() == "Finding the links…"
    before = place(panel.taxels)
    qtbot.waitUntil(lambda: preview.executor.busy)
    preview.executor.run_waiting()
    preview.executor.hold = False
    window.live.scene_jobs.executor.hold = False
    wait_for_counts(window, qtbot)
    assert panel.tree.rows
    assert place(panel.taxels) == before
    click(window, "skin-revert")
    assert place(panel.taxels).y() < before.y(), "the list of the shown robot is as high as needed"


def test_robot_without_a_scene_reports_its_skin_and_opens_with_a_chosen_one(window, rods, qtbot, monkeypatch):
    job = begin_to_open_rods(window, rods)
    bar = window.notification_bar
    monkeypatch.setattr(bar, "_clock", lambda: time.monotonic() + 2 * READ_SECONDS)
    bar._read.timeout.emit()
    assert bar.text == "rods: 1,000 taxels on left and right", "shown while the links can be chosen"
    left_click(window.notification_bar.findChild(QToolButton, "message-remedy"))
    window.live.scene_jobs.executor.hold = False
    assert job.done
    assert window.live.prepared.robot.name == "arm", "the present robot is still shown"
    panel = panel_of(window)
    assert panel.tree.checked == ("left", "right")
    assert panel.apply.text() == "Open"
    wait_for_counts(window, qtbot)
    click_box(window, "left")
    panel.taxels.setValue(60)
    wait_for_counts(window, qtbot)
    assert listed(window) == {"right": 60}
    assert previewed(window) == set(), "the robot view shows another robot"
    click(window, "skin-apply")
    assert window.live.prepared.robot.name == "rods"
    assert counts(window) == {"right": 60}
    assert panel.apply.text() == "Apply"
    assert window.presenters.map_files.unsaved == ("skin",), "no file contains the choice"


@pytest.mark.long
def test_opening_by_default_only_reports_the_skin(window, rods):
    window.presenters.files.open_path(str(rods))
    assert window.notification_bar.text == "rods: 1,000 taxels on left and right"
    assert counts(window).keys() == {"left", "right"}
    assert window.presenters.map_files.unsaved == ()
    window.action("choose_skin").trigger()
    assert panel_of(window).tree.checked == ("left", "right")
    assert not panel_of(window).apply.isEnabled()


@pytest.mark.long
def test_grid_stays_while_its_link_is_checked(window, prepared):
    grid = GridSpec("hand", 4, 4, (0.02, -0.03, 0.03), (0.02, 0.03, 0.09))
    scene = replace(prepared.scene, cover=replace(prepared.scene.cover, links=("forearm", "hand")))
    window.live.show_prepared(prepare_cached(with_grid(scene, grid, ("forearm", "hand"))))
    panel = panel_of(window)
    assert panel.tree.checked == ("forearm", "hand")
    panel.tree.rows["wrist"].setCheckState(0, Qt.CheckState.Checked)
    click(window, "skin-apply")
    assert window.live.prepared.scene.grids == (grid,)
    assert window.live.prepared.scene.cover.links == ("forearm", "wrist")
    offered(window, "hand")["remove-skin"].run()
    assert window.live.prepared.scene.grids == ()
    assert counts(window).keys() == {"forearm", "wrist"}


@pytest.mark.parametrize("typed", ["cover", "skin", "taxels", "links"])
def test_palette_finds_the_panel(window, typed):
    found = [command.text for command in matching(typed, action_commands(window.context.actions))]
    assert any(text.endswith("Skin: cover links with taxels") for text in found[:3])


def test_menu_lists_links_to_cover_and_to_clear(window):
    commands = window._commands
    commands.open_palette()
    texts = {command.text: command for command in commands.palette._commands}
    commands.palette.close()
    assert "Remove skin of link > hand" in texts
    assert "Cover link > hand" not in texts
    texts["Cover link > wrist"].run()
    assert "wrist" in counts(window)


def test_value_in_a_scene_is_kept_to_the_last_digit(qtbot):
    panel = SkinPanel()
    qtbot.addWidget(panel)
    cover = CoverSpec(("a",), pitch=0.0065432, margin=1 / 300, pattern="hexagonal")
    panel.show_choice(SkinChoice(cover))
    assert panel.cover == cover
    assert not panel.different
