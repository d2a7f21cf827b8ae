"""The controller panel under a hand: laws, tasks, paths, and only the gains that count."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from app.control.command import ControlSettings
from app.control.laws import heeded
from app.control.settings_check import CHOICES
from widgets.panels.controller_choices import LAWS
from widgets.panels.controller_panel import ControllerPanel


@pytest.fixture
def panel(qtbot):
    panel = ControllerPanel()
    qtbot.addWidget(panel)
    panel.show()
    qtbot.waitExposed(panel)
    panel.edits = []
    panel.settings_edited.connect(panel.edits.append)
    return panel


def visible(panel) -> set[str]:
    return {name for name, part in {**panel._sliders, **panel._boxes}.items() if part.isVisible()}


@pytest.mark.parametrize("law", LAWS)
def test_a_law_is_chosen_by_its_button_and_shows_what_it_heeds(panel, law):
    panel.show_settings(ControlSettings(law="qp" if law != "qp" else "impedance"))
    QTest.mouseClick(panel._buttons[law], Qt.MouseButton.LeftButton)
    assert panel.edits[-1] == ControlSettings(law=law)
    assert [name for name, button in panel._buttons.items() if button.isChecked()] == [law]
    assert visible(panel) == heeded(panel.edits[-1]) - {"path"}


@pytest.mark.parametrize("task", CHOICES["task"])
def test_a_task_is_chosen_from_its_list(panel, task):
    panel.show_settings(ControlSettings(law="hybrid", task="guide" if task != "guide" else "retreat"))
    box = panel._boxes["task"]
    row = box.findData(task)
    assert row >= 0
    box.setFocus()
    QTest.keyClick(box, Qt.Key.Key_Home)
    for _ in range(row):
        QTest.keyClick(box, Qt.Key.Key_Down)
    assert panel.edits[-1].task == task
    assert box.words == box.itemText(row)
    assert visible(panel) == heeded(panel.edits[-1]) - {"path"}


def test_a_drawn_path_has_its_own_size(panel):
    drawn = ControlSettings(law="qp", task="follow_path", path=((0.0, 0.0), (0.1, 0.0)))
    panel.show_settings(drawn)
    assert "path_size" not in visible(panel)
    QTest.keyClick(panel._sliders["path_speed"]._slider, Qt.Key.Key_Right)
    assert panel.edits[-1].path == drawn.path
    assert panel.edits[-1].path_speed == pytest.approx(drawn.path_speed + 0.001)


def test_settings_shown_are_not_taken_for_edits(panel):
    panel.show_settings(ControlSettings(law="parallel", task="follow_path", jacobian="raw", path_kind="raster"))
    assert panel.edits == []
    assert panel._boxes["jacobian"].words == "Map as each triangle says"
    assert panel._boxes["path_kind"].words == "Raster"
