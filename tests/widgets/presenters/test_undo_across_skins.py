"""Undo and redo of target, force, path and posture in the real window across changes of the skin, in one order."""

from __future__ import annotations

import pickle
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication

from tactile_maps.editing.arrange import rotate
from tactile_maps.maps.formats.map_file import map_to_bytes
from tactile_widgets.dialogs.dialogs import Button
from tactile_widgets.panels.history_panel import HistoryPanel
from tests.widgets.presenters.control.test_control_presenter import click
from tests.widgets.presenters.files.test_grid_edits import autosave
from tests.widgets.presenters.test_live_input_presenter import draw_path
from tests.widgets.presenters.test_skin_presenter import click as click_button
from tests.widgets.presenters.test_skin_presenter import click_box, counts, panel_of
from tests.widgets.support.window_driver import answer

pytestmark = pytest.mark.usefixtures("scene_cache")


@pytest.fixture
def window(window_again):
    window = window_again
    window.action("choose_skin").trigger()
    QApplication.processEvents()
    assert panel_of(window).tree.rows
    return window


def set_target(window, number):
    """Click the target on the upper arm."""
    skin = window.live.prepared.skin
    places = [place for place in map(skin.taxel_point, range(len(skin))) if skin.link(place) == "upper_arm"]
    window.action("set_target").trigger()
    click(window.map_view.viewport(), window.map_view.pixel_of(places[3 + 15 * number]).toPoint())


def apply_skin(window, link):
    """Check or uncheck a link, and apply."""
    click_box(window, link)
    click_button(window, "skin-apply")
    QApplication.processEvents()


def settings(window):
    return window.live.run.settings.settings


def place(window):
    """Place on the body of the target of the session; None without a target."""
    map_ = window.live.run.map
    path = settings(window).path
    if not path:
        return None
    point = map_.to_body(np.array(path[0]))
    return map_.skin.patches[point.patch].link, map_.skin.position(point)


def state(window):
    """Skin, settings and target posture."""
    return counts(window), settings(window), window.presenters.posture.editor.target.tolist()


def offered(window):
    """Edits that the actions revert and repeat; empty for a grey action."""
    return tuple(action.isEnabled() and action.iconText() for action in (window.action("undo"), window.action("redo")))


def do(window, name):
    assert window.action(name).isEnabled()
    window.action(name).trigger()
    QApplication.processEvents()


@pytest.mark.long
def test_target_set_after_a_change_of_the_skin_is_redone(window):
    set_target(window, 0)
    apply_skin(window, "shoulder")
    set_target(window, 2)
    last = state(window)
    assert "shoulder" in last[0]
    do(window, "undo")
    first = state(window)
    assert first != last
    do(window, "undo")
    assert "shoulder" not in counts(window)
    assert offered(window) == ("Undo set the target", "Redo change skin")
    do(window, "redo")
    assert state(window) == first
    do(window, "redo")
    assert state(window) == last
    assert not window.action("redo").isEnabled()


def test_target_set_before_an_undone_change_of_the_skin_is_undone(window):
    empty = state(window)
    set_target(window, 0)
    target = state(window)
    assert place(window)[0] == "upper_arm"
    assert window.presenters.map_files.unsaved == ("target", "controller")
    apply_skin(window, "shoulder")
    do(window, "undo")
    assert state(window) == target
    do(window, "undo")
    assert state(window) == empty
    assert not window.action("undo").isEnabled()
    assert window.presenters.map_files.unsaved == ()


@pytest.mark.long
def test_all_edits_are_undone_and_redone_in_one_order(window):
    editor = window.presenters.control_tools.settings_editor
    states = [state(window)]

    def done():
        QApplication.processEvents()
        states.append(state(window))

    set_target(window, 0)
    done()
    window.presenters.posture.editor.do("move", window.presenters.posture.editor.target + 0.05)
    done()
    apply_skin(window, "shoulder")
    done()
    editor.do("set the force", force_goal=editor.settings.force_goal + 1.0)
    done()
    window.presenters.posture.editor.do("move", window.presenters.posture.editor.target + 0.03)
    done()
    apply_skin(window, "upper_arm")
    assert settings(window).path == (), "the link of the target has no skin"
    assert "Not on the new skin and removed: the target," in window.notification_bar.text
    done()
    editor.do("set the force", force_goal=editor.settings.force_goal + 1.0)
    done()
    apply_skin(window, "upper_arm")
    done()
    set_target(window, 1)
    done()
    last = states[-1]
    for expected in reversed(states[:-1]):
        do(window, "undo")
        assert state(window)[:2] == expected[:2]
    assert not window.action("undo").isEnabled()
    for expected in states[1:]:
        do(window, "redo")
        assert state(window)[:2] == expected[:2]
    assert not window.action("redo").isEnabled()
    assert state(window) == last


def test_target_set_on_a_later_skin_keeps_its_place_when_an_earlier_skin_is_chosen(window):
    set_target(window, 0)
    first = place(window)
    apply_skin(window, "shoulder")
    set_target(window, 2)
    link, position = place(window)
    skins = window.presenters.files._skin_steps
    skins.go(-1)  # as the panel History does
    QApplication.processEvents()
    assert "shoulder" not in counts(window)
    assert place(window)[0] == link
    np.testing.assert_allclose(place(window)[1], position, atol=5e-3)
    do(window, "undo")
    np.testing.assert_allclose(place(window)[1], first[1], atol=1e-9)
    skins.go(1)
    QApplication.processEvents()
    np.testing.assert_allclose(place(window)[1], first[1], atol=5e-3)
    do(window, "redo")
    np.testing.assert_allclose(place(window)[1], position, atol=1e-9)


def test_change_of_the_skin_that_is_taken_back_by_hand_is_a_step(window):
    set_target(window, 0)
    first = place(window)
    apply_skin(window, "shoulder")
    set_target(window, 2)
    second = state(window)
    apply_skin(window, "shoulder")
    third = state(window)
    assert "shoulder" not in third[0]
    assert np.linalg.norm(place(window)[1] - first[1]) > 0.01
    assert offered(window) == ("Undo change skin", False)
    do(window, "undo")
    assert state(window) == second
    do(window, "redo")
    assert state(window) == third
    for _ in range(3):
        do(window, "undo")
    assert "shoulder" not in counts(window)
    np.testing.assert_allclose(place(window)[1], first[1], atol=1e-6)


def rotate_patch(window, number):
    assert window.editor.do("Rotate", partial(rotate, numbers=[number], angle=0.05))


def whole(window):
    """Everything that undo and redo return: skin, settings, and the map to the last byte."""
    return counts(window), settings(window), map_to_bytes(window.live.run.map)


def walk(window, *edits):
    """Make edits one after another; return the states before and after each."""
    states = [whole(window)]
    for edit in edits:
        last = window.presenters.tools.undo_stack.undo_step
        edit()
        QApplication.processEvents()
        assert window.presenters.tools.undo_stack.undo_step is not last
        states.append(whole(window))
    return states


def undo_and_redo_all(window, states):
    """Require that undo and redo of all edits return each state."""
    for expected in reversed(states[:-1]):
        do(window, "undo")
        assert whole(window) == expected
    assert not window.action("undo").isEnabled()
    for expected in states[1:]:
        do(window, "redo")
        assert whole(window) == expected
    assert not window.action("redo").isEnabled()


@pytest.fixture
def edits(window):
    """Edits by name: two changes of the skin, the second of which returns to the first skin, and others."""
    control = window.presenters.control_tools.settings_editor
    posture = window.presenters.posture.editor
    links = [patch.link for patch in window.live.prepared.skin.patches]
    return {
        "skin": partial(apply_skin, window, "shoulder"),
        "map": partial(rotate_patch, window, links.index("upper_arm")),
        "target": partial(set_target, window, 0),
        "other target": partial(set_target, window, 2),
        "force": lambda: control.do("set the force", force_goal=control.settings.force_goal + 1.0),
        "controller": lambda: control.do("choose", controller="admittance"),
        "path": lambda: draw_path(window, (5, 12, 20)),
        "posture": lambda: posture.do("move", posture.target + 0.05),
    }


MAP_EDITS = ("map", "map", "skin", "map", "skin", "map")
SEVERAL = ("target", "map", "posture", "skin", "map", "other target", "skin", "force", "map")
LONGER = ("path", "map", "skin", "force", "map", "skin", "map", "controller", "skin", "map", "target", "skin", "map")


@pytest.mark.parametrize(
    "names",
    [
        SEVERAL,
        pytest.param(MAP_EDITS, marks=pytest.mark.long),
        pytest.param(LONGER, marks=pytest.mark.long),
    ],
)
def test_skin_that_is_chosen_again_has_edits_of_its_own(window, edits, names):
    """Edits of a skin, of another one and of the first one again belong to different steps."""
    states = walk(window, *(edits[name] for name in names))
    undo_and_redo_all(window, states)
    undo_and_redo_all(window, states)


def test_redo_waits_for_the_end_of_a_drag(window, edits):
    """No undone setting or change of the skin can be redone while a setting or a patch is dragged."""
    control = window.presenters.control_tools.settings_editor
    edits["skin"]()
    edits["force"]()
    for redone in ("Redo set the force", "Redo change skin"):
        do(window, "undo")
        control.begin("drag")
        control.change(force_goal=control.settings.force_goal + 0.5)
        assert offered(window)[1] is False
        control.cancel()
        assert offered(window)[1] == redone
        window.editor.begin("Rotate")
        window.editor.change(partial(rotate, numbers=[0], angle=0.1))
        assert offered(window)[1] is False
        window.editor.cancel()
        assert offered(window)[1] == redone


@pytest.mark.long
def test_edit_in_the_middle_replaces_the_steps_after_it(window, edits):
    states = walk(window, *(edits[name] for name in ("map", "skin", "map", "map", "skin", "map")))
    for _ in range(3):
        do(window, "undo")
    assert whole(window) == states[3]
    after = walk(window, *(edits[name] for name in ("force", "map", "skin", "map")))
    assert "shoulder" not in counts(window)
    undo_and_redo_all(window, [*states[:3], *after])


@pytest.mark.long
def test_history_reaches_each_step_of_the_same_skin(window, edits):
    states = walk(window, *(edits[name] for name in ("map", "skin", "map", "skin", "map")))
    skins = window.presenters.tools.skin_steps
    skins.go(-2)
    QApplication.processEvents()
    assert whole(window) == states[0]
    for expected in states[1:]:
        do(window, "redo")
        assert whole(window) == expected
    skins.go(-1)
    skins.go(1)
    QApplication.processEvents()
    assert whole(window) == states[4]


@pytest.mark.long
def test_edits_are_restored_although_their_skin_was_shown_again_since(window, prepared, edits):
    walk(window, edits["skin"], edits["map"], edits["map"])
    lost = whole(window)
    autosave(window)
    window.live.show_prepared(pickle.loads(pickle.dumps(prepared)))  # as another start of the program does
    states = walk(window, edits["map"], edits["skin"], edits["map"])
    for _ in range(2):
        do(window, "undo")
    window.action("restore_map").trigger()
    answer(window, Button.Yes, "restore")
    assert whole(window)[2] == lost[2]
    assert window.presenters.map_files.unsaved[:2] == ("map", "skin")
    do(window, "undo")
    assert whole(window) == states[1]


@pytest.mark.long
def test_skin_is_unsaved_after_undo_of_the_one_that_was_saved(window, edits, tmp_path):
    files = window.presenters.map_files
    edits["skin"]()
    window.presenters.scene_file.save(str(tmp_path / "own.toml"))
    saved = window.live.prepared
    assert files.unsaved == ()
    do(window, "undo")
    assert files.unsaved == ("skin",)
    do(window, "redo")
    assert files.unsaved == ()
    do(window, "undo")
    edits["skin"]()
    assert files.unsaved == (), "the file contains this skin"
    do(window, "undo")
    edits["map"]()
    last = whole(window)
    autosave(window)
    window.live.show_prepared(pickle.loads(pickle.dumps(saved)))  # as another start of the program does
    assert "shoulder" in counts(window)
    do(window, "restore_map")
    assert whole(window) == last


@pytest.mark.long
def test_scene_that_is_opened_again_has_no_steps(window, edits, tmp_path):
    walk(window, edits["skin"])
    file = tmp_path / "own.toml"
    window.presenters.scene_file.save(str(file))
    window.presenters.files.open_path(str(file))
    assert "shoulder" in counts(window)
    assert offered(window) == (False, False)


def test_another_scene_forgets_the_steps(window, prepared):
    set_target(window, 0)
    window.live.show_prepared(replace(prepared, scene=replace(prepared.scene, title="Another")))
    assert not window.action("undo").isEnabled()


def test_patch_that_only_made_room_for_edited_ones_is_not_reported_as_edited(window):
    window.editor.do("turn", lambda document: rotate(document, [0], 1.0))
    apply_skin(window, "shoulder")
    assert "shoulder" in counts(window)
    apply_skin(window, "shoulder")
    assert "shoulder" not in counts(window)
    assert "map edits" not in window.notification_bar.text


def test_edited_patch_of_a_link_that_the_skin_leaves_is_reported(window):
    window.editor.do("turn", lambda document: rotate(document, [0], 1.0))
    apply_skin(window, "shoulder")
    names = [patch.name for patch in window.editor.document.patches]
    window.editor.do("turn", lambda document: rotate(document, [names.index("shoulder")], 1.0))
    apply_skin(window, "shoulder")
    assert "Not on the new skin and removed: the map edits of shoulder." in window.notification_bar.text


@pytest.mark.parametrize(
    "undone", ["map", "", *(pytest.param(one, marks=pytest.mark.long) for one in ("force", "skin"))]
)
def test_skin_that_is_refused_changes_no_step(window, edits, tmp_path, undone):
    """An edit that was undone can still be redone after a refused skin, and no step is added."""
    if undone:
        edits[undone]()
        do(window, "undo")
    before = offered(window)
    rows = window.column.get(HistoryPanel).steps.items
    file = tmp_path / "far.csv"
    file.write_text("id,x,y,z,link\n0,9,9,9,upper_arm\n1,9,9.01,9,upper_arm\n")
    window.presenters.files.open_path(str(file))
    QApplication.processEvents()
    assert "far.csv" in window.notification_bar.text
    assert offered(window) == before
    assert window.column.get(HistoryPanel).steps.items == rows
    if undone:
        do(window, "redo")
        assert offered(window) == (before[1].replace("Redo", "Undo"), False)


@pytest.mark.long
def test_edit_that_was_undone_before_a_change_of_the_skin_is_not_redone_after_it(window, edits):
    walk(window, edits["map"], edits["map"])
    do(window, "undo")
    edits["skin"]()
    assert offered(window) == ("Undo change skin", False)
    do(window, "undo")
    assert offered(window) == ("Undo rotate", False)
