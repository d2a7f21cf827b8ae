"""Which plots are shown, in which order: what a person chose is kept, whatever was kept is read."""

from __future__ import annotations

import pytest

from tactile_widgets.plots.choice.plot_choice import STANDARD, PlotChoice, PlotKey, PlotKind

FORCE, ERROR, SPEED, LIMITS, PRESSURE, TIME, EVENTS = STANDARD
ELBOW = PlotKey(PlotKind.JOINT, "elbow")
CONTACT = PlotKey(PlotKind.CONTACT, "4")
CALLED_FOR = frozenset({FORCE, PRESSURE})


def texts(choice):
    return [key.text for key in choice.shown(CALLED_FOR)]


def test_until_a_person_chooses_those_are_shown_that_the_controller_calls_for():
    assert texts(PlotChoice()) == ["force", "pressure"]
    assert PlotChoice().shown({TIME, ERROR}) == (ERROR, TIME)
    added = PlotChoice().with_plot(ELBOW, CALLED_FOR)
    assert texts(added) == ["force", "pressure", "joint:elbow"]
    assert added.shown({TIME}) == (TIME, ELBOW), "the standard ones follow the controller still"


def test_a_standard_plot_that_is_added_or_hidden_ends_that():
    more = PlotChoice().with_plot(EVENTS, CALLED_FOR)
    assert more.shown({TIME}) == (FORCE, PRESSURE, EVENTS)
    assert texts(PlotChoice().without(FORCE, CALLED_FOR)) == ["pressure"]
    assert texts(more.with_plot(ELBOW, CALLED_FOR).without(ELBOW, CALLED_FOR)) == texts(more)


def test_plots_are_moved_before_others_or_to_the_end():
    choice = PlotChoice().with_plot(ELBOW, CALLED_FOR)
    assert texts(choice.moved(ELBOW, FORCE)) == ["joint:elbow", "force", "pressure"]
    assert texts(choice.moved(FORCE, None)) == ["pressure", "joint:elbow", "force"]
    assert choice.moved(FORCE, FORCE) == choice


def test_what_is_kept_is_read_again_but_for_contacts_which_end_with_the_session():
    choice = PlotChoice().with_plot(ELBOW, CALLED_FOR).with_plot(CONTACT, CALLED_FOR).moved(ELBOW, FORCE)
    choice = choice.without(PRESSURE, CALLED_FOR).with_window(ELBOW, (10, 20, 300, 200)).with_window(CONTACT, None)
    again = PlotChoice.from_text(choice.to_text())
    assert texts(again) == ["joint:elbow", "force"]
    assert again.windows == {ELBOW: (10, 20, 300, 200)}


@pytest.mark.parametrize(
    "text",
    ["", "null", "{", "[1]", '{"order": 3}', '{"order": ["what", "joint:", "taxel:x", "limit:none", 4, "force:of"]}'],
)
def test_what_says_nothing_known_is_left_out(text):
    assert PlotChoice.from_text(text).shown(CALLED_FOR) == (FORCE, PRESSURE)
