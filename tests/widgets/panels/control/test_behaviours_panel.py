"""The behaviours panel: sentences of boxes, a button that adds one, a cross that takes one away."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel, QPushButton, QToolButton

from tactile_maps.control.behaviours import Behaviour
from tactile_widgets.common.panel import FlatComboBox
from tactile_widgets.panels.control.behaviours_panel import BehavioursPanel
from tests.support.touch import prepared_bar

pytestmark = pytest.mark.qt_log_ignore("This plugin does not support", extend=True)  # offscreen, of lists
RETREAT = Behaviour("press", "bar", then={"controller": "hybrid", "task": "retreat"})


@pytest.fixture
def panel(qtbot):
    panel = BehavioursPanel()
    qtbot.addWidget(panel)
    panel.show_prepared(prepared_bar())
    panel.resize(300, 300)
    panel.show()
    return panel


def box(panel, part, number=0) -> FlatComboBox:
    return panel.findChildren(FlatComboBox, f"behaviour-{part}")[number]


def pick(box: FlatComboBox, words: str) -> None:
    """Choose as the keys do: open the list, walk there, take it."""
    box.setFocus()
    QTest.keyClick(box, Qt.Key.Key_Space)
    view = box.view()
    assert view.isVisible()
    view.setCurrentIndex(box.model().index(box.findText(words), 0))
    QTest.keyClick(view, Qt.Key.Key_Return)
    assert not view.isVisible()


def note(panel) -> QLabel:
    return panel.findChild(QLabel, "behaviours-note")


def test_empty_panel_shows_an_explanation(panel):
    assert note(panel).isVisible()
    assert "add a behaviour" in note(panel).text()


def test_button_adds_a_valid_default_behaviour(panel, qtbot):
    button = panel.findChild(QPushButton, "behaviour-add")
    with qtbot.waitSignal(panel.behaviours_edited) as edited:
        qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
    assert edited.args[0] == (Behaviour("tap", times=2, then={"controller": "hybrid", "task": "retreat"}),)
    assert [box(panel, part).words for part in ("when", "where", "then", "lasts")] == [
        "double tap",
        "anywhere",
        "retreat",
        "permanently",
    ]
    assert not note(panel).isVisible()


@pytest.mark.parametrize(
    ("part", "words", "expected"),
    [
        ("when", "stroke", Behaviour("stroke", "bar", then=dict(RETREAT.then))),
        ("where", "anywhere", Behaviour("press", then=dict(RETREAT.then))),
        ("where", "top", Behaviour("press", "top", then=dict(RETREAT.then))),
        ("then", "impedance", Behaviour("press", "bar", then={"controller": "impedance"})),
        ("lasts", "until released", Behaviour("press", "bar", until_released=True, then=dict(RETREAT.then))),
    ],
)
def test_every_part_can_be_changed(panel, qtbot, part, words, expected):
    panel.show_behaviours((RETREAT,))
    with qtbot.waitSignal(panel.behaviours_edited) as edited:
        pick(box(panel, part), words)
    assert edited.args[0] == (expected,)
    assert panel.behaviours == (expected,)


def test_tap_offers_no_duration_until_release(panel, qtbot):
    panel.show_behaviours((Behaviour("press", until_released=True, then={"controller": "impedance"}),))
    with qtbot.waitSignal(panel.behaviours_edited) as edited:
        pick(box(panel, "when"), "tap")
    assert edited.args[0] == (Behaviour("tap", then={"controller": "impedance"}),)
    assert not box(panel, "lasts").isEnabled()


def test_remove_button_deletes_its_behaviour(panel, qtbot):
    other = Behaviour("tap", then={"controller": "impedance"})
    panel.show_behaviours((RETREAT, other))
    cross = panel.findChildren(QToolButton, "behaviour-remove")[0]
    with qtbot.waitSignal(panel.behaviours_edited) as edited:
        qtbot.mouseClick(cross, Qt.MouseButton.LeftButton)
    assert edited.args[0] == (other,)


def test_scene_behaviour_with_values_not_in_the_lists_is_shown(panel):
    panel.show_behaviours((Behaviour("press", times=4, above=5.0, then={"force_goal": 1.5, "task": "hold_point"}),))
    assert box(panel, "when").words == "4 times press > 5\u202fN"
    assert box(panel, "then").words == "force goal 1.5, task hold point"


def test_last_triggered_behaviour_is_shown(panel):
    panel.show_behaviours((RETREAT,))
    panel.show_triggered(Behaviour("press", where="bar", then={"task": "retreat"}))
    assert note(panel).text() == "Last: press on bar"
