"""A heading gives way: cut short where there is little room, whole where there is enough."""

from __future__ import annotations

import pytest

from widgets.window.toolbar import ElidedLabel

WORDS = "Follow a path drawn on the map"


@pytest.fixture
def label(qtbot):
    made = ElidedLabel()
    qtbot.addWidget(made)
    made.setText(WORDS)
    made.show()
    return made


def test_it_is_whole_where_there_is_room(label):
    label.resize(label.sizeHint())
    assert label.shown == WORDS
    assert label.toolTip() == ""


def test_it_is_cut_and_the_tool_tip_says_all_of_it(label):
    label.resize(80, 20)
    assert label.shown.endswith("…")
    assert WORDS.startswith(label.shown[:-1])
    assert label.toolTip() == WORDS
    assert label.minimumSizeHint().width() < 40


@pytest.mark.parametrize("width", [1280, 1400])
def test_the_real_time_factor_is_seen_beside_a_long_title(window, qtbot, width):
    window.session_bar.show_title(WORDS)
    window.resize(width, 800)
    qtbot.waitUntil(lambda: window.session_bar.width() == width)
    assert window.session_bar.factor.isVisible()
    assert window.session_bar.factor.geometry().right() <= width
