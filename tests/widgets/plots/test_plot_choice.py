"""Choice and order of plots, its stored text, and taxel groups as text."""

from __future__ import annotations

import pytest

from tactile_widgets.plots.choice.plot_choice import STANDARD, PlotChoice, PlotKey, PlotKind, TaxelGroup

FORCE, ERROR, SPEED, LIMITS, PRESSURE, TIME, EVENTS = STANDARD
ELBOW = PlotKey(PlotKind.JOINT, "elbow")
CONTACT = PlotKey(PlotKind.CONTACT, "4")
CALLED_FOR = frozenset({FORCE, PRESSURE})


def texts(choice):
    return [key.text for key in choice.shown(CALLED_FOR)]


def test_controller_determines_standard_plots_until_the_user_chooses():
    assert texts(PlotChoice()) == ["force", "pressure"]
    assert PlotChoice().shown({TIME, ERROR}) == (ERROR, TIME)
    added = PlotChoice().with_plot(ELBOW, CALLED_FOR)
    assert texts(added) == ["force", "pressure", "joint:elbow"]
    assert added.shown({TIME}) == (TIME, ELBOW), "the controller still determines the standard plots"


def test_adding_or_hiding_a_standard_plot_fixes_the_standard_plots():
    more = PlotChoice().with_plot(EVENTS, CALLED_FOR)
    assert more.shown({TIME}) == (FORCE, PRESSURE, EVENTS)
    assert texts(PlotChoice().without(FORCE, CALLED_FOR)) == ["pressure"]
    assert texts(more.with_plot(ELBOW, CALLED_FOR).without(ELBOW, CALLED_FOR)) == texts(more)


def test_plots_move_before_others_or_to_the_end():
    choice = PlotChoice().with_plot(ELBOW, CALLED_FOR)
    assert texts(choice.moved(ELBOW, FORCE)) == ["joint:elbow", "force", "pressure"]
    assert texts(choice.moved(FORCE, None)) == ["pressure", "joint:elbow", "force"]
    assert choice.moved(FORCE, FORCE) == choice


def test_stored_choice_is_restored_without_plots_of_contacts():
    choice = PlotChoice().with_plot(ELBOW, CALLED_FOR).with_plot(CONTACT, CALLED_FOR).moved(ELBOW, FORCE)
    choice = choice.without(PRESSURE, CALLED_FOR).with_window(ELBOW, (10, 20, 300, 200)).with_window(CONTACT, None)
    again = PlotChoice.from_text(choice.to_text())
    assert texts(again) == ["joint:elbow", "force"]
    assert again.windows == {ELBOW: (10, 20, 300, 200)}


@pytest.mark.parametrize(
    "text",
    ["", "null", "{", "[1]", '{"order": 3}', '{"order": ["what", "joint:", "taxel:x", "limit:none", 4, "force:of"]}'],
)
def test_unknown_stored_entries_are_ignored(text):
    assert PlotChoice.from_text(text).shown(CALLED_FOR) == (FORCE, PRESSURE)


def test_group_text_round_trips_with_special_characters_in_the_name():
    group = TaxelGroup("a=b, c:d-1", (2, 3, 4, 9, 11))
    assert group.text == "a=b, c:d-1=2-4,9,11"
    assert TaxelGroup.parse(group.text) == group
    key = PlotKey.parse(f"group-force:{group.text}")
    assert key is not None
    assert key.title == "Force on a=b, c:d-1"


@pytest.mark.parametrize("text", ["", "palm", "=1", "palm=", "palm=x", "palm=3-1", "palm=1,,2", "palm=0-999999999"])
def test_invalid_group_text_is_none(text):
    assert TaxelGroup.parse(text) is None
    assert PlotKey.parse(f"group-pressure:{text}") is None


@pytest.mark.parametrize("joint", ["shoulder_pan_joint", "shoulder_pan"])
def test_title_of_a_joint_names_the_word_joint_once(joint):
    titles = [PlotKey(kind, joint).title for kind in (PlotKind.JOINT, PlotKind.JOINT_SPEED)]
    assert titles == ["Joint shoulder pan", "Speed of joint shoulder pan"]
