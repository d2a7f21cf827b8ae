"""The Effects panel under real events: what it shows, what it asks for, and that a passing wheel changes nothing."""

from __future__ import annotations

from dataclasses import replace

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QPalette
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QPushButton

from tactile_maps.core.errors import Finding
from tactile_maps.core.timing import Timings
from tactile_maps.scene.effects import EFFECTS, SENSOR_KEYS
from tactile_maps.scene.scene import with_override
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind
from tactile_widgets.panels.model.effects_panel import EffectsPanel, automatic_rows
from tests.widgets.support.mouse import left_click, turn_wheel
from tests.widgets.support.samples import touched

NONE = Qt.KeyboardModifier.NoModifier
pytestmark = pytest.mark.qt_log_ignore("This plugin does not support", extend=True)  # offscreen, of lists


@pytest.fixture
def panel(qtbot, prepared):
    panel = EffectsPanel()
    qtbot.addWidget(panel)
    panel.resize(300, 700)
    panel.show_prepared(prepared)
    panel.show()
    qtbot.waitExposed(panel)
    return panel


@pytest.fixture
def overrides(panel):
    heard = []
    panel.override_requested.connect(lambda *override: heard.append(override))
    return heard


def pick(line, words):
    """Choose from a row's box as the keys do: open it, walk there, take it."""
    line.box.setFocus()
    QTest.keyClick(line.box, Qt.Key.Key_Space)
    view = line.box.view()
    assert view.isVisible()
    index = next(k for k in range(line.box.count()) if line.box.itemText(k).split(" ")[0] == words)
    view.setCurrentIndex(line.box.model().index(index, 0))
    QTest.keyClick(view, Qt.Key.Key_Return)
    assert not view.isVisible()


def test_every_effect_has_a_row_with_its_value(panel, prepared):
    assert list(panel.lines) == list(EFFECTS)
    for row in prepared.scene.decision.rows:
        assert panel.lines[row.name].words[:2] == (row.title, row.value)


def test_sensor_effects_are_folded_until_opened(panel):
    assert panel.lines["skin"].isVisible()
    assert not any(panel.lines[key].isVisible() for key in SENSOR_KEYS)
    left_click(panel.findChild(object, "effects-sensor-heading"))
    assert all(panel.lines[key].isVisible() for key in SENSOR_KEYS)


def test_choice_makes_a_request_and_the_row_shows_the_current_effect(panel, overrides, prepared):
    line = panel.lines["friction"]
    assert line.words[1] == "off"
    pick(line, "on")
    assert overrides == [("friction", "on")]
    assert line.words[1] == "off", "not simulated yet"
    show(panel, with_override(prepared.scene, "friction", "on"))
    assert line.words[1] == "on"
    assert line.marked
    pick(line, "Auto")
    assert overrides[1:] == [("friction", "auto")]


def show(panel, scene, notes=()):
    panel.show_decision(scene.decision, automatic_rows(scene), notes=notes)


def test_choosing_the_current_value_makes_no_request(panel, overrides, prepared):
    pick(panel.lines["friction"], "Auto")
    show(panel, with_override(prepared.scene, "friction", "on"))
    pick(panel.lines["friction"], "on")
    assert overrides == []


def test_override_that_is_not_in_the_list_can_be_reset(panel, overrides, prepared):
    show(panel, with_override(prepared.scene, "timestep", 0.00125))
    line = panel.lines["timestep"]
    assert line.words[1] == "0.00125 s"
    pick(line, "Auto")
    assert overrides == [("timestep", "auto")]


def test_wheel_over_a_box_scrolls_the_panel_without_changing_it(panel, overrides):
    box = panel.lines["friction"].box
    event = turn_wheel(box, notches=-1)
    assert overrides == []
    assert not event.isAccepted()


def test_click_on_a_row_shows_its_reason_for_one_row_at_a_time(panel):
    assert not any(line.why for line in panel.lines.values())
    left_click(panel.lines["gravity"], QPoint(30, 8))
    assert panel.lines["gravity"].why
    panel.lines["skin"].box.setFocus(Qt.FocusReason.TabFocusReason)
    assert [key for key, line in panel.lines.items() if line.why] == ["skin"]


def test_costs_measured_in_this_session_are_emphasized_over_others(panel, prepared):
    panel.show_frame(replace(touched(prepared.map), timings=Timings({"physics": 0.5, "touch": 0.25})))
    panel.show_prices({"joint_limits": 0.04})
    cost = {key: panel.findChild(QLabel, f"effect-{key}-cost") for key in ("skin", "joint_limits", "friction")}
    assert [label.text() for label in cost.values()] == ["0.25", "0.04", "–"]
    assert cost["skin"].foregroundRole() == QPalette.ColorRole.WindowText
    assert cost["joint_limits"].foregroundRole() == QPalette.ColorRole.PlaceholderText
    assert panel.findChild(QLabel, "effects-total").text() == "0.75 of 5\u202fms a tick"


def test_note_of_one_tick_is_shown_at_the_next_refresh_and_once(panel, prepared):
    label = panel.findChild(QLabel, "effects-notes")
    frame = touched(prepared.map)
    hard = replace(frame, notes=(ContactNote(ContactNoteKind.HARD, ("ball", "hand"), force=7e3),))
    shown = []
    for number in range(46):
        panel.show_frame(hard if number == 20 else frame)
        shown.append("ball presses hand very hard" in label.text())
    assert shown == [30 <= number < 45 for number in range(46)]
    assert label.isHidden()


def test_warnings_are_shown_while_present(panel, prepared):
    label = panel.findChild(QLabel, "effects-warnings")
    assert not label.isVisible()
    show(panel, prepared.scene, notes=[Finding("unstable-time-step", "here", "Choose another step")])
    assert "Choose another step" in label.text()
    show(panel, with_override(prepared.scene, "skin", "off"))
    assert label.isVisible()
    assert "skin" in label.text()
    show(panel, prepared.scene)
    assert not label.isVisible()


def test_all_to_auto_is_visible_if_an_effect_is_overridden(panel, prepared, qtbot):
    button = panel.findChild(QPushButton, "effects-all-auto")
    assert not button.isEnabled()
    show(panel, with_override(prepared.scene, "friction", "on"))
    assert button.isEnabled()
    with qtbot.waitSignal(panel.auto_all_requested):
        left_click(button)


def test_panel_is_read_only_in_a_replay(panel, prepared):
    show(panel, with_override(prepared.scene, "friction", "on"))
    panel.set_editable(editable=False)
    assert not any(line.box.isEnabled() for line in panel.lines.values())
    assert not panel.findChild(QPushButton, "effects-all-auto").isEnabled()
    show(panel, with_override(prepared.scene, "noise", "on"))
    assert not panel.findChild(QPushButton, "effects-all-auto").isEnabled()
    assert panel.findChild(QLabel, "effects-closed").isVisible()
    panel.set_editable(editable=True)
    assert panel.lines["noise"].box.isEnabled()


def test_scene_with_another_tick_replaces_choices_and_rows(panel, prepared):
    old = panel.lines["timestep"]
    panel.show_prepared(prepared)
    assert panel.lines["timestep"] is old, "the same choices need no other rows"
    offered = [old.box.itemText(k) for k in range(1, old.box.count())]
    panel.show_prepared(replace(prepared, scene=replace(prepared.scene, tick=0.004)))
    QApplication.processEvents()
    assert not old.isVisible()
    new = panel.lines["timestep"]
    assert new.isVisible()
    assert [new.box.itemText(k) for k in range(1, new.box.count())] != offered
