"""Undo and redo of target, force, path and posture in the real window across changes of the skin, in one order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication

from tests.widgets.presenters.control.test_control_presenter import click, pixels
from tests.widgets.presenters.test_skin_presenter import click as click_button
from tests.widgets.presenters.test_skin_presenter import click_box, counts, panel_of

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
    links = [patch.link for patch in window.live.prepared.skin.patches]
    window.action("set_target").trigger()
    _, places = pixels(window, links.index("upper_arm"))
    click(window.map_view.viewport(), places[number])


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


def test_another_scene_forgets_the_steps(window, prepared):
    set_target(window, 0)
    window.live.show_prepared(replace(prepared, scene=replace(prepared.scene, title="Another")))
    assert not window.action("undo").isEnabled()
