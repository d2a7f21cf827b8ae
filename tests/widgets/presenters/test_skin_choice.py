"""A choice in the Skin panel that is not applied yet is part of the document: kept, asked about, and saved."""

from __future__ import annotations

import pickle
from functools import partial

import pytest
from PySide6.QtWidgets import QApplication, QLabel, QMessageBox, QToolButton

from tactile_maps.editing.arrange import move
from tactile_maps.editing.document_file import load_document
from tactile_maps.scene.scene_file import load_scene
from tactile_widgets.dialogs.dialogs import Button
from tactile_widgets.panels.registry import PanelTab
from tactile_widgets.session.live_input import LiveInputSettings
from tests.widgets.presenters.test_skin_presenter import (
    RODS,
    begin_to_open_rods,
    click,
    click_box,
    counts,
    offered,
    panel_of,
    previewed,
    wait_for_counts,
)
from tests.widgets.support.mouse import left_click
from tests.widgets.support.window_driver import answer, cancel, record_run, run

pytestmark = pytest.mark.usefixtures("scene_cache")

CHOSEN = "chosen skin (not applied yet)"
UNOPENED = "chosen skin of rods (not open yet)"
LINKS = ("upper_arm", "forearm", "hand")


@pytest.fixture(autouse=True)
def skins_not_at_hand(monkeypatch):
    """Skins that other tests have prepared are opened in the background too."""
    monkeypatch.setattr("tactile_widgets.session.session_host.find_prepared", lambda _scene: None)


def show_panel(window):
    window.action("choose_skin").trigger()
    QApplication.processEvents()
    assert panel_of(window).tree.rows
    return window


@pytest.fixture
def window(window_again):
    yield show_panel(window_again)
    window_again.live.cancel_loading()
    window_again.live.scene_jobs.executor.hold = False


@pytest.fixture
def rods(tmp_path):
    """File of a scene with another robot in a skin of few taxels."""
    (tmp_path / "rods.xml").write_text(RODS)
    scene = tmp_path / "rods.toml"
    scene.write_text('title = "Rods"\nrobot = "rods.xml"\n[cover]\ntaxels = 60\n')
    return scene


def question(window):
    """Text of the visible question, or an empty string."""
    return next((box.text() for box in window.findChildren(QMessageBox) if box.isVisible()), "")


def offers_save(window):
    """Return whether the visible question has the button Save."""
    (box,) = [box for box in window.findChildren(QMessageBox) if box.isVisible()]
    return box.button(Button.Save) is not None


def chosen(window):
    return {*panel_of(window).tree.checked}


def unsaved(window):
    return window.presenters.map_files.unsaved


def test_choice_that_is_not_applied_is_marked_and_asked_about(window, rods):
    assert not window.isWindowModified()
    click_box(window, "wrist")
    assert window.isWindowModified()
    for leave in (window.close, partial(window.presenters.files.open_path, str(rods))):
        leave()
        assert question(window).endswith(f"not saved: {CHOSEN}. Save applies the chosen skin first.")
        answer(window, Button.Cancel)
        assert window.isVisible()
        assert chosen(window) == {*LINKS, "wrist"}
    click_box(window, "wrist")
    assert not window.isWindowModified(), "it equals the skin again"
    panel_of(window).taxels.setValue(160)
    assert unsaved(window) == (CHOSEN,)
    click(window, "skin-revert")
    assert unsaved(window) == ()
    click_box(window, "wrist")
    click(window, "skin-apply")
    assert unsaved(window) == ("skin",)


@pytest.mark.long
def test_discarded_choice_returns_if_the_robot_is_not_opened(window, rods):
    click_box(window, "wrist")
    opening = window.live.scene_jobs.executor
    opening.hold = True
    window.presenters.files.open_path(str(rods))
    answer(window, Button.Discard)
    cancel(window)
    assert unsaved(window) == (CHOSEN,)
    window.presenters.files.open_path(str(rods))
    answer(window, Button.Discard)
    opening.hold = False
    opening.run_waiting()
    assert question(window) == "", "asked once"
    assert window.live.prepared.robot.name == "rods"
    assert unsaved(window) == ()
    assert chosen(window) == {"left", "right"}


@pytest.mark.long
def test_choice_is_applied_and_saved_before_the_window_closes(new_window, tmp_path, choose_file, qtbot):
    window = show_panel(new_window)
    choose_file("save_file", tmp_path / "own.toml")
    click_box(window, "wrist")
    opening = window.live.scene_jobs.executor
    opening.hold = True
    window.close()
    answer(window, Button.Save)
    click_box(window, "elbow")
    assert unsaved(window) == ("skin", CHOSEN)
    opening.run_waiting()
    qtbot.waitUntil(lambda: question(window) != "")
    assert question(window).split(". ")[0].endswith(f"not saved: {CHOSEN[:-1]})"), "the rest is saved"
    assert {*load_scene(str(tmp_path / "own.toml")).cover.links} == {*LINKS, "wrist"}
    opening.hold = False
    answer(window, Button.Save)
    qtbot.waitUntil(lambda: not window.isVisible())
    assert {*load_scene(str(tmp_path / "own.toml")).cover.links} == {*LINKS, "wrist", "elbow"}


def test_save_applies_the_choice_and_saves_it_once_it_is_shown(window, tmp_path, choose_file, qtbot):
    choose_file("save_file", tmp_path / "own.toml")
    opening = window.live.scene_jobs.executor
    opening.hold = True
    click_box(window, "wrist")
    window.action("save").trigger()
    assert not (tmp_path / "own.toml").exists()
    opening.hold = False
    opening.run_waiting()
    qtbot.waitUntil((tmp_path / "own.toml").exists)
    assert {*load_scene(str(tmp_path / "own.toml")).cover.links} == {*LINKS, "wrist"}
    assert unsaved(window) == ()


def messages(window):
    return [message.text for message in window.notification_bar.messages]


def open_again(window):
    """Complete what is being opened, then press the button of the message that something is not opened."""
    window.live.scene_jobs.executor.hold = False
    window.live.scene_jobs.executor.run_waiting()
    QApplication.processEvents()
    buttons = window.notification_bar.findChildren(QToolButton, "message-remedy")
    left_click(next(button for button in buttons if button.text() == "Open again"))
    QApplication.processEvents()


def test_opening_that_a_change_of_the_skin_stops_is_offered_again(window, tmp_path, choose_file, rods):
    stopped = "The opening of {} was cancelled, because the skin is being changed."
    record_run(window, tmp_path / "a.mcap", 0.1)
    choose_file("save_file", tmp_path / "own.toml")
    click_box(window, "wrist")
    window.live.scene_jobs.executor.hold = True
    window.presenters.files.open_path(str(tmp_path / "a.mcap"))
    window.action("save").trigger()
    assert stopped.format("a.mcap") in messages(window)
    open_again(window)
    assert {*load_scene(str(tmp_path / "own.toml")).cover.links} == {*LINKS, "wrist"}
    assert window.live.replay.player.path == tmp_path / "a.mcap"
    window.live.replay.leave()
    assert counts(window).keys() == {*LINKS, "wrist"}
    window.live.scene_jobs.executor.hold = True
    window.presenters.files.open_path(str(rods))
    window.action("undo").trigger()
    assert stopped.format("Rods") in messages(window)
    assert counts(window).keys() == {*LINKS}
    open_again(window)
    assert question(window).endswith("not saved: skin."), "the file contains the other one"
    answer(window, Button.Discard)
    assert window.live.prepared.robot.name == "rods"


def test_choice_that_cannot_be_applied_is_not_offered_to_be_saved(window, rods, tmp_path):
    click_box(window, "wrist")
    window.live.recording.start(tmp_path / "a.mcap")
    window.presenters.files.open_path(str(rods))
    assert question(window).endswith("cannot be saved now. A recording is being made: stop it to change the skin.")
    assert not offers_save(window)
    answer(window, Button.Cancel)
    window.action("save").trigger()
    assert "cannot be saved now. A recording is being made" in window.notification_bar.text
    window.live.recording.stop()
    for link in chosen(window):
        click_box(window, link)
    window.presenters.files.open_path(str(rods))
    assert question(window).endswith("cannot be saved now. Check at least one link.")
    assert not offers_save(window)
    answer(window, Button.Cancel)
    assert unsaved(window) == (CHOSEN,)


def test_choice_that_fails_to_be_applied_keeps_the_document_and_states_why(window, rods):
    click_box(window, "hand")
    panel = panel_of(window)
    panel.amount.setCurrentIndex(panel.amount.findData("pitch"))
    panel.pitch.setValue(0.5)
    window.presenters.files.open_path(str(rods))
    answer(window, Button.Save)
    assert "more than 20,000 taxels" in window.notification_bar.text
    assert window.live.prepared.robot.name == "arm"
    assert unsaved(window) == (CHOSEN,)


@pytest.mark.long
def test_choice_waits_during_a_recording_or_a_connection(window, tmp_path, qtbot):
    record_run(window, tmp_path / "a.mcap", 0.1)
    click_box(window, "wrist")
    wait_for_counts(window, qtbot)
    window.live.open_recording(tmp_path / "a.mcap")
    assert chosen(window) == {*LINKS}
    window.close()
    assert CHOSEN in question(window)
    assert "A recording is shown" in question(window)
    assert not offers_save(window)
    answer(window, Button.Cancel)
    window.live.replay.leave()
    assert chosen(window) == {*LINKS, "wrist"}
    wait_for_counts(window, qtbot)
    assert previewed(window) == {*LINKS, "wrist"}
    (tmp_path / "readings.csv").write_text("# unit: Pa\ntime,0,1\n0.0,0,0\n0.1,0,0\n")
    window.live.connection.open(LiveInputSettings(str(tmp_path / "readings.csv")))
    assert chosen(window) == {*LINKS}
    window.action("disconnect").trigger()
    assert chosen(window) == {*LINKS, "wrist"}
    assert unsaved(window) == (CHOSEN,)


@pytest.mark.long
def test_choice_is_shown_again_after_the_panel_showed_a_robot_that_is_not_open(window, tmp_path, rods):
    record_run(window, tmp_path / "a.mcap", 0.1)
    begin_to_open_rods(window, rods)
    click_box(window, "wrist")
    window.action("choose_links").trigger()
    assert chosen(window) == {"left", "right"}
    click_box(window, "left")
    assert unsaved(window) == (CHOSEN, UNOPENED)
    click(window, "skin-revert")
    assert chosen(window) == {*LINKS, "wrist"}
    begin_to_open_rods(window, rods, discarding=True)
    window.action("choose_links").trigger()
    window.column.show_tab(PanelTab.TOUCH)
    window.live.open_recording(tmp_path / "a.mcap")
    window.live.scene_jobs.executor.run_waiting()
    window.live.replay.leave()
    assert unsaved(window) == (CHOSEN,)
    show_panel(window)
    assert chosen(window) == {*LINKS, "wrist"}


@pytest.mark.long
def test_other_changes_of_the_skin_are_part_of_the_choice(window):
    panel = panel_of(window)
    click_box(window, "wrist")
    click_box(window, "hand")
    panel.margin.setValue(12.0)
    offered(window, "elbow")["cover"].run()
    run(window, 0.02)
    assert counts(window).keys() == {*LINKS, "elbow"}
    assert chosen(window) == {"upper_arm", "forearm", "elbow", "wrist"}
    assert panel.cover.margin == 0.012
    assert panel.taxels.value() == sum(counts(window).values())
    assert unsaved(window) == ("skin", CHOSEN)
    offered(window, "forearm")["remove-skin"].run()
    run(window, 0.02)
    assert chosen(window) == {"upper_arm", "elbow", "wrist"}
    window.action("undo").trigger()
    window.action("undo").trigger()
    assert counts(window).keys() == {*LINKS}
    assert chosen(window) == {"upper_arm", "forearm", "wrist"}
    assert unsaved(window) == (CHOSEN,)


@pytest.mark.long
def test_choice_made_while_a_robot_is_opened_is_saved_instead(window, tmp_path, choose_file, rods, qtbot):
    choose_file("save_file", tmp_path / "own.toml")
    opening = window.live.scene_jobs.executor
    opening.hold = True
    panel_of(window).taxels.setValue(160)
    window.presenters.files.open_path(str(rods))
    answer(window, Button.Discard)
    click_box(window, "wrist")
    opening.hold = False
    opening.run_waiting()
    answer(window, Button.Save)
    qtbot.waitUntil((tmp_path / "own.toml").exists)
    assert "The opening of Rods was cancelled" in "".join(one.text for one in window.notification_bar.messages)
    assert window.live.prepared.robot.name == "arm"
    assert counts(window).keys() == {*LINKS, "wrist"}
    assert unsaved(window) == ()


def test_choice_whose_application_is_cancelled_is_asked_about_again(window):
    window.live.scene_jobs.executor.hold = True
    panel_of(window).taxels.setValue(62)
    click(window, "skin-apply")
    assert unsaved(window) == ("skin",)
    cancel(window)
    assert unsaved(window) == (CHOSEN,)
    click(window, "skin-apply")
    panel_of(window).taxels.setValue(63)
    assert unsaved(window) == ("skin", CHOSEN)
    click(window, "skin-apply")
    assert unsaved(window) == ("skin",), "instead of the first"


@pytest.mark.long
def test_other_changes_are_saved_without_a_choice_that_cannot_be(new_window, tmp_path, choose_file, qtbot):
    window = show_panel(new_window)
    record_run(window, tmp_path / "a.mcap", 0.1)
    click_box(window, "wrist")
    window.editor.do("Move", partial(move, numbers=[0], by=(0.01, 0.0)))
    window.live.open_recording(tmp_path / "a.mcap")
    choose_file("save_file", tmp_path / "own.npz")
    window.close()
    assert question(window).endswith("Save saves the other changes, and the chosen skin is lost.")
    answer(window, Button.Save)
    qtbot.waitUntil(lambda: not window.isVisible())
    saved = load_document(tmp_path / "own.npz")
    assert saved.layout == window.editor.document.layout


# Restored after a crash.


def crash(window, prepared):
    """Show the arm again as the next start of the program does after a crash, which leaves the copy of the work."""
    files = window.presenters.map_files
    files._wait()  # a running autosave precludes another one
    files.autosave()
    files._wait()
    window.live.show_prepared(pickle.loads(pickle.dumps(prepared)))
    assert unsaved(window) == ()
    assert chosen(window) == {*LINKS}


def test_choice_is_restored_after_a_crash_and_not_applied(window, prepared):
    click_box(window, "wrist")
    panel_of(window).taxels.setValue(64)
    choice = panel_of(window).cover
    crash(window, prepared)
    window.action("restore_map").trigger()
    assert chosen(window) == {*LINKS, "wrist"}
    assert window.presenters.map_files.choice == panel_of(window).cover == choice
    assert counts(window).keys() == {*LINKS}
    crash(window, prepared)
    click_box(window, "elbow")
    window.action("restore_map").trigger()
    assert question(window) == "A skin was chosen since. Restoring replaces this choice."
    answer(window, Button.Cancel, "restore")
    assert chosen(window) == {*LINKS, "elbow"}
    window.action("restore_map").trigger()
    answer(window, Button.Yes, "restore")
    assert chosen(window) == {*LINKS, "wrist"}


def test_choice_for_a_skin_that_was_not_saved_is_restored_with_it(window, prepared):
    panel_of(window).taxels.setValue(160)
    click_box(window, "wrist")
    click(window, "skin-apply")
    click_box(window, "elbow")
    panel_of(window).taxels.setValue(150)
    choice = panel_of(window).cover
    crash(window, prepared)
    window.action("restore_map").trigger()
    assert counts(window).keys() == {*LINKS, "wrist"}
    assert panel_of(window).cover == choice
    assert unsaved(window) == ("map", "skin", CHOSEN)


def test_undone_choice_leaves_no_copy(window, prepared):
    click_box(window, "wrist")
    crash(window, prepared)
    window.action("restore_map").trigger()
    window.action("undo").trigger()
    click(window, "skin-revert")
    crash(window, prepared)
    assert not window.action("restore_map").isEnabled()


# A robot that is not open yet.


@pytest.fixture
def choosing(window, rods):
    """The window whose panel chooses the skin of a robot before it is opened."""
    begin_to_open_rods(window, rods)
    window.action("choose_links").trigger()
    assert unsaved(window) == (), "nothing is chosen yet"
    yield window
    window.live.scene_jobs.executor.hold = False


@pytest.mark.long
def test_choice_for_a_robot_that_is_not_open_is_restored_after_a_crash(choosing, prepared):
    window = choosing
    click_box(window, "left")
    panel_of(window).taxels.setValue(65)
    choice = panel_of(window).cover
    crash(window, prepared)
    assert "a skin chosen for another robot" in window.notification_bar.text
    window.action("restore_map").trigger()
    QApplication.processEvents()
    assert (panel_of(window).cover, chosen(window)) == (choice, {"right"})
    assert UNOPENED in unsaved(window)
    click_box(window, "left")
    panel_of(window).taxels.setValue(60)
    assert UNOPENED not in unsaved(window), "it equals the default again"
    click_box(window, "left")
    panel_of(window).taxels.setValue(65)
    assert UNOPENED in unsaved(window)
    crash(window, prepared)
    window.action("restore_map").trigger()
    window.live.scene_jobs.executor.hold = False
    window.editor.undo()
    click(window, "skin-apply")
    assert window.live.prepared.robot.name == "rods"
    assert counts(window).keys() == {"right"}
    assert sum(counts(window).values()) == 65


def taxels_after_job(window, qtbot):
    """Run the next job of the preview, which waits for it, and return the texts of the taxels of each link."""
    preview = window.presenters.skin.preview
    qtbot.waitUntil(lambda: preview.executor.busy)
    preview.executor.run_waiting()
    return {link: row.text(2) for link, row in panel_of(window).tree.rows.items()}


def test_taxels_for_a_robot_that_is_not_open_are_pending_until_they_are_counted(window, prepared, rods, qtbot):
    pending = {"base": "", "left": "…", "right": "…"}
    executor = window.presenters.skin.preview.executor
    executor.hold = True
    begin_to_open_rods(window, rods)
    window.action("choose_links").trigger()
    assert taxels_after_job(window, qtbot) == pending
    assert taxels_after_job(window, qtbot) == {"base": "", "left": "30", "right": "30"}
    panel_of(window).taxels.setValue(50)
    crash(window, prepared)
    window.action("restore_map").trigger()
    assert taxels_after_job(window, qtbot) == pending
    assert taxels_after_job(window, qtbot) == {"base": "", "left": "25", "right": "25"}
    executor.hold = False
    window.live.scene_jobs.executor.hold = False
    click(window, "skin-revert")


def test_panel_names_the_robot_that_is_not_open_until_it_shows_another_skin(choosing):
    panel = panel_of(choosing)
    name = panel.findChild(QLabel, "skin-robot")
    panel.show_counts({"left": 20, "right": 30}, {})
    assert "50 taxels" in panel.note.text()
    assert name.isVisible()
    assert name.text() == "Skin of rods, which is not open yet"
    click(choosing, "skin-revert")
    assert not name.isVisible()


def test_choice_for_a_robot_that_is_not_open_is_asked_about(choosing):
    window = choosing
    click_box(window, "left")
    assert window.isWindowModified()
    window.action("save").trigger()
    assert "rods is not open yet" in window.notification_bar.text
    for leave in (window.close, partial(window.presenters.files.open_shipped, "carry")):
        leave()
        assert question(window) == (
            f"These parts have changes that are not saved: {UNOPENED}. The chosen skin cannot be saved now. "
            "rods is not open yet: Open in the panel Skin opens it with this skin."
        )
        assert not offers_save(window)
        answer(window, Button.Cancel)
        assert window.isVisible()
        assert chosen(window) == {"right"}
    click_box(window, "left")
    assert unsaved(window) == (), "it equals the default again"
    click_box(window, "left")
    click(window, "skin-revert")
    assert unsaved(window) == ()
    assert chosen(window) == {*LINKS}


def test_discarded_choice_for_a_robot_that_is_not_open_is_asked_about_once(choosing, rods):
    window = choosing
    click_box(window, "left")
    window.presenters.files.open_path(str(rods))
    answer(window, Button.Discard)
    assert unsaved(window) == (UNOPENED,), "until the robot replaces it"
    window.live.scene_jobs.executor.run_waiting()
    assert question(window) == ""
    assert chosen(window) == {"left", "right"} == {*counts(window)}
    assert unsaved(window) == ()


@pytest.mark.long
def test_choice_for_a_robot_stays_until_the_robot_is_open(choosing, tmp_path):
    window = choosing
    opening = window.live.scene_jobs.executor
    click_box(window, "left")
    click(window, "skin-apply")
    assert question(window) == "", "the choice is what is opened"
    assert unsaved(window) == (UNOPENED,)
    window.close()
    assert UNOPENED in question(window)
    answer(window, Button.Cancel)
    cancel(window)
    assert unsaved(window) == (UNOPENED,)
    assert chosen(window) == {"right"}
    click(window, "skin-apply")
    panel_of(window).taxels.setValue(70)
    opening.hold = False
    opening.run_waiting()
    assert question(window) == ""
    assert {*counts(window)} == {"right"}
    assert unsaved(window) == ("skin", CHOSEN)
    assert panel_of(window).taxels.value() == 70
    assert panel_of(window).apply.text() == "Apply"


def test_choice_that_returns_to_the_default_while_its_robot_is_opened_is_kept(choosing):
    window = choosing
    click_box(window, "left")
    click(window, "skin-apply")
    click_box(window, "left")
    window.live.scene_jobs.executor.run_waiting()
    assert {*counts(window)} == {"right"}
    assert chosen(window) == {"left", "right"}
    assert unsaved(window) == ("skin", CHOSEN)


@pytest.mark.long
def test_recording_and_changes_of_the_skin_leave_the_choice_for_another_robot(choosing, tmp_path):
    window = choosing
    window.live.scene_jobs.executor.hold = False
    click_box(window, "left")
    record_run(window, tmp_path / "a.mcap", 0.1)
    window.live.open_recording(tmp_path / "a.mcap")
    assert chosen(window) == {"right"}
    window.live.replay.leave()
    assert chosen(window) == {"right"}
    offered(window, "wrist")["cover"].run()
    run(window, 0.02)
    assert window.live.prepared.robot.name == "arm"
    assert counts(window).keys() == {*LINKS, "wrist"}
    assert unsaved(window) == ("skin", UNOPENED)
    click(window, "skin-revert")
    assert chosen(window) == {*LINKS, "wrist"}
    assert unsaved(window) == ("skin",)
