"""Undo and redo of drawn settings, without reverting settings changed elsewhere in the meantime."""

from __future__ import annotations

from dataclasses import replace

from tactile_maps.control.motion.command import ControlSettings
from tactile_widgets.document.skin_steps import StepsOnSkin
from tactile_widgets.tools.control.control_settings_editor import MOST_STEPS, ControlUndoStack

FIRST = ControlSettings()
PATH = replace(FIRST, controller="hybrid", task="follow_path", path=((0.0, 0.0), (0.1, 0.0)))
LONGER = replace(PATH, path=(*PATH.path, (0.1, 0.1)))


def drawn():
    steps = ControlUndoStack()
    steps.done("draw a path", FIRST, PATH)
    steps.done("add a corner", PATH, LONGER)
    return steps


def test_new_stack_has_nothing_to_undo_or_redo():
    steps = ControlUndoStack()
    assert (steps.undo_step.name, steps.redo_step.name) == ("", "")
    assert steps.undo(PATH) is PATH
    assert steps.redo(PATH) is PATH


def test_steps_are_undone_and_redone_in_order():
    steps = drawn()
    assert steps.undo_step.name == "add a corner"
    assert steps.undo(LONGER) == PATH
    assert (steps.undo_step.name, steps.redo_step.name) == ("draw a path", "add a corner")
    assert steps.undo(PATH) == FIRST
    assert steps.redo(FIRST) == PATH
    assert steps.redo(PATH) == LONGER
    assert steps.redo_step.name == ""


def test_undo_keeps_settings_changed_elsewhere():
    steps = drawn()
    turned = replace(LONGER, force_gain=0.03, path_speed=0.02)
    assert steps.undo(turned) == replace(PATH, force_gain=0.03, path_speed=0.02)


def test_new_step_discards_undone_steps():
    steps = drawn()
    steps.undo(LONGER)
    steps.done("move a corner", PATH, replace(PATH, path=((0.0, 0.0), (0.2, 0.0))))
    assert steps.redo_step.name == ""
    assert steps.undo_step.name == "move a corner"


def test_unchanged_settings_add_no_step():
    steps = drawn()
    steps.done("move a corner", LONGER, LONGER)
    assert steps.undo_step.name == "add a corner"


def test_extended_steps_of_one_kind_are_merged():
    steps = drawn()
    now = LONGER
    for force in (3.5, 4.0, 4.5):
        now, before = replace(now, force_goal=force), now
        steps.done("set the force", before, now, extend=True)
    assert steps.undo(now) == LONGER
    assert steps.undo_step.name == "add a corner"


def test_extending_a_step_of_other_settings_adds_a_step():
    steps = drawn()
    steps.done("add a corner", LONGER, replace(LONGER, force_goal=4.0), extend=True)
    assert steps.undo(replace(LONGER, force_goal=4.0)) == LONGER


def test_extending_a_step_of_another_name_adds_a_step():
    steps = drawn()
    there = replace(LONGER, path=((0.0, 0.0), (0.3, 0.0)))
    steps.done("move a corner", LONGER, there, extend=True)
    assert steps.undo(there) == LONGER


def test_oldest_steps_are_discarded():
    steps = ControlUndoStack()
    for number in range(MOST_STEPS + 5):
        steps.done(f"{number}", replace(FIRST, force_goal=number), replace(FIRST, force_goal=number + 1))
    for _ in range(MOST_STEPS):
        assert steps.undo_step.name
        steps.undo(FIRST)
    assert steps.undo_step.name == ""


def unchanged(kind, path):
    return kind, path


def test_skin_shown_again_has_its_settings_without_steps_undone_since(prepared):
    steps = drawn()
    left = steps.leave_skin(prepared.map)
    assert steps.settings_on_skin(left, LONGER, unchanged) == LONGER
    steps.undo(LONGER)
    assert steps.settings_on_skin(left, LONGER, unchanged) == PATH
    steps.done("set the force", PATH, replace(PATH, force_goal=4.0))
    assert steps.settings_on_skin(left, LONGER, unchanged) == replace(PATH, force_goal=4.0)


def test_steps_made_on_another_skin_are_carried_to_the_skin_shown_again(prepared):
    steps = drawn()
    other = ((0.5, 0.5),)
    assert steps.settings_on_skin(StepsOnSkin(prepared.map), FIRST, lambda kind, _path: (kind, other)) == replace(
        LONGER, path=other
    )
    steps.enter_skin(StepsOnSkin(prepared.map), "polyline", lambda kind, path: (kind, other if path else ()))
    assert steps.undo(LONGER).path == other
    assert steps.undo(LONGER).path == ()


def test_steps_discarded_as_the_oldest_are_not_undone_on_a_skin_shown_again(prepared):
    steps = drawn()
    left = steps.leave_skin(prepared.map)
    now = LONGER
    for number in range(MOST_STEPS):
        now, before = replace(now, force_goal=float(number + 1)), now
        steps.done(f"{number}", before, now)
    assert steps.settings_on_skin(left, LONGER, unchanged) == now


def test_forgotten_steps_are_not_undone_on_a_skin_shown_again(prepared):
    steps = drawn()
    left = steps.leave_skin(prepared.map)
    steps.reset()
    assert steps.settings_on_skin(left, LONGER, unchanged) == LONGER
