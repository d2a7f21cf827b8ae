"""What was drawn can be taken back and done again, without touching what was turned elsewhere in between."""

from __future__ import annotations

from dataclasses import replace

from tactile_maps.control.motion.command import ControlSettings
from tactile_widgets.tools.control.control_settings_editor import MOST_STEPS, ControlUndoStack

FIRST = ControlSettings()
PATH = replace(FIRST, controller="hybrid", task="follow_path", path=((0.0, 0.0), (0.1, 0.0)))
LONGER = replace(PATH, path=(*PATH.path, (0.1, 0.1)))


def drawn():
    wishes = ControlUndoStack()
    wishes.done("draw a path", FIRST, PATH)
    wishes.done("add a corner", PATH, LONGER)
    return wishes


def test_nothing_can_be_taken_back_at_first():
    wishes = ControlUndoStack()
    assert (wishes.undo_name, wishes.redo_name) == ("", "")
    assert wishes.undo(PATH) is PATH
    assert wishes.redo(PATH) is PATH


def test_back_and_forth():
    wishes = drawn()
    assert wishes.undo_name == "add a corner"
    assert wishes.undo(LONGER) == PATH
    assert (wishes.undo_name, wishes.redo_name) == ("draw a path", "add a corner")
    assert wishes.undo(PATH) == FIRST
    assert wishes.redo(FIRST) == PATH
    assert wishes.redo(PATH) == LONGER
    assert wishes.redo_name == ""


def test_a_gain_turned_in_between_stays():
    wishes = drawn()
    turned = replace(LONGER, force_gain=0.03, path_speed=0.02)
    assert wishes.undo(turned) == replace(PATH, force_gain=0.03, path_speed=0.02)


def test_another_step_forgets_what_was_taken_back():
    wishes = drawn()
    wishes.undo(LONGER)
    wishes.done("move a corner", PATH, replace(PATH, path=((0.0, 0.0), (0.2, 0.0))))
    assert wishes.redo_name == ""
    assert wishes.undo_name == "move a corner"


def test_what_changed_nothing_is_no_step():
    wishes = drawn()
    wishes.done("move a corner", LONGER, LONGER)
    assert wishes.undo_name == "add a corner"


def test_steps_of_one_kind_go_on_as_one():
    wishes = drawn()
    now = LONGER
    for force in (3.5, 4.0, 4.5):
        now, before = replace(now, force_goal=force), now
        wishes.done("set the force", before, now, extend=True)
    assert wishes.undo(now) == LONGER
    assert wishes.undo_name == "add a corner"


def test_what_goes_on_after_something_else_is_a_step_of_its_own():
    wishes = drawn()
    wishes.done("add a corner", LONGER, replace(LONGER, force_goal=4.0), extend=True)
    assert wishes.undo(replace(LONGER, force_goal=4.0)) == LONGER


def test_steps_of_another_name_do_not_go_on():
    wishes = drawn()
    there = replace(LONGER, path=((0.0, 0.0), (0.3, 0.0)))
    wishes.done("move a corner", LONGER, there, extend=True)
    assert wishes.undo(there) == LONGER


def test_old_steps_are_forgotten():
    wishes = ControlUndoStack()
    for number in range(MOST_STEPS + 5):
        wishes.done(f"{number}", replace(FIRST, force_goal=number), replace(FIRST, force_goal=number + 1))
    for _ in range(MOST_STEPS):
        assert wishes.undo_name
        wishes.undo(FIRST)
    assert wishes.undo_name == ""
