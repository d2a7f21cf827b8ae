"""The controller panel under a hand: laws, tasks, paths, and only the gains that count."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel, QPushButton

from app.control.command import ControlSettings
from app.control.laws import RULES, heeded
from app.control.report import TaskReport
from app.control.settings_check import CHOICES
from tests.widgets.hand_made import touched
from widgets.panels.controller_choices import LAWS, SLIDERS
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
    return {name for name, part in {**panel.sliders.by_name, **panel._boxes}.items() if part.isVisible()}


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
    QTest.keyClick(panel.sliders.by_name["path_speed"]._slider, Qt.Key.Key_Right)
    assert panel.edits[-1].path == drawn.path
    assert panel.edits[-1].path_speed == pytest.approx(drawn.path_speed + 0.001)


def test_settings_shown_are_not_taken_for_edits(panel):
    panel.show_settings(ControlSettings(law="parallel", task="follow_path", jacobian="raw", path_kind="raster"))
    assert panel.edits == []
    assert panel._boxes["jacobian"].words == "Map as each triangle says"
    assert panel._boxes["path_kind"].words == "Raster"


def click(panel, name):
    button = panel.findChild(QPushButton, name)
    assert button.isVisible()
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)


def moving(prepared, time, **what):
    frame = touched(prepared.map, [10], tick=round(200 * time), time=time)
    return replace(frame, posture=np.zeros(7), velocity=np.zeros(7), **what)


def text(panel, name):
    return panel.findChild(QLabel, name).text()


def test_every_law_is_reached_by_keys_alone(panel):
    panel._buttons["impedance"].setFocus()
    rows = len(LAWS) // 2
    for key in (*[Qt.Key.Key_Down] * (rows - 1), Qt.Key.Key_Right, *[Qt.Key.Key_Up] * (rows - 1)):
        QTest.keyClick(panel.focusWidget(), key)
    assert {edit.law for edit in panel.edits} >= set(LAWS) - {"impedance"}


@pytest.mark.parametrize("how", ["double click", "delete"])
@pytest.mark.parametrize("name", ["force_gain", "integral_time", "force_goal"])
def test_one_number_goes_back_to_where_it_began(panel, name, how):
    began = ControlSettings(law="hybrid")
    changed = replace(began, force_gain=0.03, integral_time=1.0, force_goal=7.0)
    panel.show_settings(changed)
    slider = panel.sliders.by_name[name]
    if how == "delete":
        slider._slider.setFocus()
        QTest.keyClick(slider._slider, Qt.Key.Key_Delete)
    else:
        QTest.mouseDClick(slider._name, Qt.MouseButton.LeftButton)
    assert panel.edits == [replace(changed, **{name: getattr(began, name)})]
    assert slider.value == pytest.approx(getattr(began, name) * SLIDERS[name].scale)
    assert "Double-click" in slider._name.toolTip()


def test_all_gains_go_back_and_what_is_to_be_done_stays(panel):
    settings = ControlSettings(law="parallel", task="hold_point", force_gain=0.03, inertia_time=0.2, force_goal=8.0)
    panel.show_settings(settings)
    click(panel, "reset-gains")
    assert panel.edits == [ControlSettings(law="parallel", task="hold_point", force_goal=8.0)]
    assert not panel.findChild(QPushButton, "reset-gains").isEnabled(), "there is nothing to reset any more"


def test_a_law_has_its_gains_back_when_it_is_chosen_again(panel):
    panel.show_settings(ControlSettings(law="hybrid", force_gain=0.008))
    click(panel, "law-qp")
    QTest.keyClick(panel.sliders.by_name["force_gain"]._slider, Qt.Key.Key_End)
    click(panel, "law-hybrid")
    assert panel.edits[-1] == ControlSettings(law="hybrid", force_gain=0.008)
    click(panel, "law-qp")
    assert panel.edits[-1].force_gain == pytest.approx(0.04)
    QTest.keyClick(panel.sliders.by_name["force_gain"]._slider, Qt.Key.Key_Home)
    panel.take(ControlSettings(law="hybrid", force_gain=0.02))
    click(panel, "law-qp")
    assert panel.edits[-1].force_gain == pytest.approx(0.001), "remembered however the law was left"


def test_gains_go_back_to_the_scene_s_own(panel, prepared):
    scene = replace(prepared.scene, control={"stiffness": 20.0})
    panel.show_prepared(replace(prepared, scene=scene))
    panel.show_settings(ControlSettings(stiffness=9.0))
    QTest.mouseDClick(panel.sliders.by_name["stiffness"]._name, Qt.MouseButton.LeftButton)
    assert panel.edits[-1].stiffness == 20.0


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (ControlSettings(law="hybrid", task="follow_path"), "Start the path again"),
        (ControlSettings(law="hybrid", task="follow_path", path=((0.1, 0.1), (0.2, 0.1))), "Start the path again"),
        (ControlSettings(law="qp", task="hold_point"), "Hold where it is now"),
        (ControlSettings(law="qp", task="hold_point", path=((0.1, 0.1),)), None),
        (ControlSettings(law="qp", task="guide"), None),
        (ControlSettings(law="impedance", task="follow_path"), None),
    ],
)
def test_a_task_that_remembers_a_place_can_be_started_again(panel, settings, words):
    panel.show_settings(settings)
    button = panel.findChild(QPushButton, "task-again")
    assert button.isVisible() == (words is not None)
    if words is not None:
        assert button.text() == words
        click(panel, "task-again")
        assert panel.edits == [replace(settings, starts=1)]


def test_what_it_does_and_the_energy_it_gave_are_said(panel, prepared):
    panel.show_settings(ControlSettings(law="hybrid", task="hold_point"))
    report = TaskReport(error=0.0021, force_goal=3.0, energy=-0.126, tank=0.99)
    panel.show_frame(moving(prepared, 1.0, task=report))
    assert text(panel, "task-state") == "Holding the point, 2.1\u202fmm off"
    assert text(panel, "energy") == "-0.13\u2009J, 0.99\u2009J left"
    assert panel.findChild(QLabel, "energy").isVisible()
    panel.show_settings(ControlSettings())
    assert not panel.findChild(QLabel, "energy").isVisible()


def test_a_limit_that_flashed_stays_legible_and_then_goes(panel, prepared):
    panel.show_settings(ControlSettings(law="hybrid"))
    panel.show_frame(moving(prepared, 1.0, why_limited=("joint speed",)))
    assert panel._why.words == "Limited: joint speed"
    panel.show_frame(moving(prepared, 1.1))
    assert panel._why.words == "Was limited: joint speed"
    panel.show_frame(moving(prepared, 2.5))
    assert panel._why.words == "Not limited"


def test_a_robot_without_joints_is_told(panel, prepared):
    panel.show_frame(touched(prepared.map))
    assert panel._why.words == "This robot has no joints to move"


def test_the_answer_to_a_step_of_the_goal_is_told_until_something_else_is_changed(panel, prepared):
    settings = ControlSettings(law="hybrid")
    panel.show_settings(settings)
    label = panel.findChild(QLabel, "step-response")
    for k in range(50):
        panel.show_frame(moving(prepared, 0.02 * k, task=TaskReport(force_goal=3.0)))
    assert not label.isVisible()
    panel.show_settings(replace(settings, force_goal=6.0))
    for k in range(50, 100):
        panel.show_frame(moving(prepared, 0.02 * k, task=TaskReport(force_goal=6.0)))
    assert label.isVisible()
    assert label.text().startswith("Goal 3.0 → 6.0\u2009N: ")
    samples = len(panel._step._samples)
    panel.show_settings(replace(settings, force_goal=6.0, force_gain=0.02))
    panel.show_frame(moving(prepared, 2.0, task=TaskReport(force_goal=6.0)))
    assert len(panel._step._samples) == samples


def test_comparing_is_asked_for(panel, qtbot):
    with qtbot.waitSignal(panel.compare_asked):
        click(panel, "compare-laws")


def test_a_law_that_is_in_force_already_is_no_edit(panel):
    assert "impedance" not in RULES
    click(panel, "law-impedance")
    assert panel.edits == []
