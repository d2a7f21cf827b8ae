"""Why the controller is limited: shape and words, never colour alone, and no flicker."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication

from tests.widgets.pictures import pixels
from widgets.colours import DARK, LIGHT, apply_theme
from widgets.panels.limit_memory import Limit
from widgets.panels.why_line import State, WhyLine

STOPPED = "stopped: 41 N of force, more than 40 N; lift what touches to go on"


@pytest.fixture
def line(qtbot):
    line = WhyLine()
    qtbot.addWidget(line)
    line.resize(260, 60)
    line.show()
    qtbot.waitExposed(line)
    return line


@pytest.mark.parametrize(
    ("limits", "state", "words"),
    [
        ((), State.FREE, "Not limited"),
        ((Limit("joint limit", True),), State.LIMITED, "Limited: joint limit"),
        ((Limit("joint limit", False),), State.ENDED, "Was limited: joint limit"),
        ((Limit("a", True), Limit("b", False)), State.LIMITED, "Limited: a; b"),
        ((Limit(STOPPED, True),), State.STOPPED, STOPPED),
    ],
)
def test_words_and_state(line, limits, state, words):
    line.show_limits(limits)
    assert (line.state, line.words) == (state, words)


def test_a_robot_without_joints_has_nothing_to_limit(line):
    line.say_no_joints()
    assert line.words == "This robot has no joints to move"
    line.show_limits(())
    assert line.words == "Not limited"


def test_each_state_has_a_shape_of_its_own(line):
    drawn = {}
    for limits in ((), (Limit("a", True),), (Limit("a", False),), (Limit(STOPPED, True),)):
        line.show_limits(limits)
        grey = pixels(line._sign.grab().toImage()).astype(float).mean(axis=2)
        drawn[line.state] = np.abs(grey - grey[0, 0]) > 30
    assert len(drawn) == len(State)
    shapes = list(drawn.values())
    assert all(shape.any() for shape in shapes)
    assert all((a != b).mean() > 0.04 for k, a in enumerate(shapes) for b in shapes[:k])


def test_what_ended_is_quieter_than_what_goes_on(line):
    apply_theme(QApplication.instance(), LIGHT)
    try:
        line.show_limits((Limit("a", True), Limit("b", False)))
        assert f'<span style="color:{LIGHT.quiet}">b</span>' in line._words.text()
        assert "<span" not in line._words.text().split("b<")[0].split(";")[0]
    finally:
        apply_theme(QApplication.instance(), DARK)


def test_nothing_below_moves_when_limits_come_and_go(line):
    free = line.sizeHint().height()
    line.show_limits((Limit("something holds the arm back", True), Limit("joint speed", True)))
    assert line.heightForWidth(260) <= max(free, line.minimumSizeHint().height()) + 1


def test_what_controllers_say_is_text_and_no_markup(line):
    line.show_limits((Limit("<b>5 < 6</b>", True),))
    assert "&lt;b&gt;5 &lt; 6" in line._words.text()
