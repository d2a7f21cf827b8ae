"""The controller panel under a hand: controllers, tasks, paths, only the gains that count, and why it is limited."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QPushButton

from tactile_maps.control.controller_registry import CONTROLLERS, effective_settings
from tactile_maps.control.controllers import CONTROL_SCHEMES
from tactile_maps.control.limit_texts import limit_text
from tactile_maps.control.motion.command import CHOICES, ControlSettings, TaskReport
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.session.inputs import ControlChanged
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import Finger, PokePressed
from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.common.colours import DARK, LIGHT, THEMES
from tactile_widgets.common.controller_settings import SLIDERS
from tactile_widgets.common.panel import MIXED_VALUES
from tactile_widgets.panels.control.controller_panel import ControllerPanel, LimitState, LimitStatusLine
from tactile_widgets.plots.traces.history import ShownLimit
from tactile_widgets.plots.traces.span_strip import severity_colour
from tests.support.touch import arm
from tests.widgets.support.mouse import left_click, left_double_click
from tests.widgets.support.samples import touched
from tests.widgets.support.snapshots import pixels


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
    """Return the enabled settings; settings of other controllers keep their place but are disabled."""
    parts = {**panel.sliders.by_name, **panel._boxes}
    return {name for name, part in parts.items() if part.isVisible() and part.isEnabled()}


@pytest.mark.sampled(2)
@pytest.mark.parametrize("controller", CONTROLLERS)
def test_controller_chosen_by_its_button_shows_its_effective_settings(panel, controller):
    panel.show_settings(ControlSettings(controller="qp" if controller != "qp" else "impedance"))
    left_click(panel._buttons[controller])
    assert panel.edits[-1] == ControlSettings(controller=controller)
    assert [name for name, button in panel._buttons.items() if button.isChecked()] == [controller]
    assert visible(panel) == effective_settings(panel.edits[-1]) - {"path"}


@pytest.mark.long
@pytest.mark.parametrize("task", CHOICES["task"])
def test_task_is_chosen_from_its_list(panel, task):
    panel.show_settings(ControlSettings(controller="hybrid", task="guide" if task != "guide" else "retreat"))
    box = panel._boxes["task"]
    row = box.findData(task)
    assert row >= 0
    box.setFocus()
    QTest.keyClick(box, Qt.Key.Key_Home)
    for _ in range(row):
        QTest.keyClick(box, Qt.Key.Key_Down)
    assert panel.edits[-1].task == task
    assert box.words == box.itemText(row)
    assert visible(panel) == effective_settings(panel.edits[-1]) - {"path"}


def test_drawn_path_has_its_own_size(panel):
    drawn = ControlSettings(controller="qp", task="follow_path", path=((0.0, 0.0), (0.1, 0.0)))
    panel.show_settings(drawn)
    assert "path_size" not in visible(panel)
    QTest.keyClick(panel.sliders.by_name["path_speed"]._slider, Qt.Key.Key_Right)
    assert panel.edits[-1].path == drawn.path
    assert panel.edits[-1].path_speed == pytest.approx(drawn.path_speed + 0.001)


@pytest.mark.parametrize("task", ["keep_force", "guide"])
def test_shear_settings_are_hidden_for_a_skin_without_shear(panel, prepared, task):
    settings = ControlSettings(controller="hybrid", task=task, shear_goal=1.0, max_shear=5.0)
    panel.show_settings(settings)
    panel.show_prepared(prepared)
    of_shear = {"shear_goal", "shear_direction", "shear_threshold", "max_shear", "friction_use"}
    assert effective_settings(settings) & of_shear
    assert visible(panel) == effective_settings(settings) - of_shear - {"path"}
    panel.sliders.set_measured(shear=True)
    assert visible(panel) == effective_settings(settings) - {"path"}
    assert panel.edits == []


def test_shown_settings_are_not_reported_as_edits(panel):
    panel.show_settings(ControlSettings(controller="parallel", task="follow_path", jacobian="raw", path_kind="raster"))
    assert panel.edits == []
    assert panel._boxes["jacobian"].words == "Exact per-triangle Jacobian"
    assert panel._boxes["path_kind"].words == "Raster"


def click(panel, name):
    button = panel.findChild(QPushButton, name)
    assert button.isVisible()
    left_click(button)


def moving(prepared, time, **what):
    frame = touched(prepared.map, [10], tick=round(200 * time), time=time)
    return replace(frame, posture=np.zeros(7), velocity=np.zeros(7), **what)


def text(panel, name):
    return panel.findChild(QLabel, name).text()


def test_every_controller_can_be_chosen_by_keyboard(panel):
    panel._buttons["impedance"].setFocus()
    rows = len(CONTROLLERS) // 2
    for key in (*[Qt.Key.Key_Down] * (rows - 1), Qt.Key.Key_Right, *[Qt.Key.Key_Up] * (rows - 1)):
        QTest.keyClick(panel.focusWidget(), key)
    assert {edit.controller for edit in panel.edits} >= set(CONTROLLERS) - {"impedance"}


@pytest.mark.sampled(2)
@pytest.mark.parametrize("how", ["double click", "delete"])
@pytest.mark.parametrize("name", ["force_gain", "integral_time", "force_goal"])
def test_single_setting_can_be_reset(panel, name, how):
    began = ControlSettings(controller="hybrid")
    changed = replace(began, force_gain=0.03, integral_time=1.0, force_goal=7.0)
    panel.show_settings(changed)
    slider = panel.sliders.by_name[name]
    if how == "delete":
        slider._slider.setFocus()
        QTest.keyClick(slider._slider, Qt.Key.Key_Delete)
    else:
        left_double_click(slider._name)
    assert panel.edits == [replace(changed, **{name: getattr(began, name)})]
    assert slider.value == pytest.approx(getattr(began, name) * SLIDERS[name].scale)
    assert "Double-click" in slider._name.toolTip()


def test_all_gains_are_reset_and_the_task_is_kept(panel):
    settings = ControlSettings(
        controller="parallel", task="hold_point", force_gain=0.03, inertia_time=0.2, force_goal=8.0
    )
    panel.show_settings(settings)
    click(panel, "reset-gains")
    assert panel.edits == [ControlSettings(controller="parallel", task="hold_point", force_goal=8.0)]
    assert not panel.findChild(QPushButton, "reset-gains").isEnabled(), "there is nothing to reset any more"


def test_controller_chosen_again_restores_its_gains(panel):
    panel.show_settings(ControlSettings(controller="hybrid", force_gain=0.008))
    click(panel, "controller-qp")
    QTest.keyClick(panel.sliders.by_name["force_gain"]._slider, Qt.Key.Key_End)
    click(panel, "controller-hybrid")
    assert panel.edits[-1] == ControlSettings(controller="hybrid", force_gain=0.008)
    click(panel, "controller-qp")
    assert panel.edits[-1].force_gain == pytest.approx(0.04)
    QTest.keyClick(panel.sliders.by_name["force_gain"]._slider, Qt.Key.Key_Home)
    panel.take(ControlSettings(controller="hybrid", force_gain=0.02))
    click(panel, "controller-qp")
    assert panel.edits[-1].force_gain == pytest.approx(0.001), "remembered however the controller was left"


def test_gains_are_reset_to_those_of_the_scene(panel, prepared):
    scene = replace(prepared.scene, control={"stiffness": 20.0})
    panel.show_prepared(replace(prepared, scene=scene))
    panel.show_settings(ControlSettings(stiffness=9.0))
    left_double_click(panel.sliders.by_name["stiffness"]._name)
    assert panel.edits[-1].stiffness == 20.0


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (ControlSettings(controller="hybrid", task="follow_path"), "Restart path"),
        (
            ControlSettings(controller="hybrid", task="follow_path", path=((0.1, 0.1), (0.2, 0.1))),
            "Restart path",
        ),
        (ControlSettings(controller="qp", task="hold_point"), "Hold current position"),
        (ControlSettings(controller="qp", task="hold_point", path=((0.1, 0.1),)), None),
        (ControlSettings(controller="qp", task="guide"), None),
        (ControlSettings(controller="impedance", task="follow_path"), None),
    ],
)
def test_task_with_a_stored_place_can_be_restarted(panel, settings, words):
    panel.show_settings(settings)
    button = panel.findChild(QPushButton, "task-again")
    assert button.isVisible(), "it keeps its place"
    assert button.isEnabled() == (words is not None)
    if words is not None:
        assert button.text() == words
        click(panel, "task-again")
        assert panel.edits == [replace(settings, starts=1)]


def test_activity_and_energy_of_the_controller_are_shown(panel, prepared):
    panel.show_settings(ControlSettings(controller="hybrid", task="hold_point"))
    report = TaskReport(error=0.0021, force_goal=3.0, energy=-0.126, tank=0.99)
    panel.show_frame(moving(prepared, 1.0, task=report))
    assert text(panel, "task-state") == "Holding the point, error 2.1\u202fmm"
    assert text(panel, "energy") == "−0.13\u202fJ, 0.99\u202fJ left"
    panel.show_settings(ControlSettings())
    assert text(panel, "energy") == MIXED_VALUES


def test_brief_limit_stays_legible_for_a_while_and_then_disappears(panel, prepared):
    panel.show_settings(ControlSettings(controller="hybrid"))
    panel.show_frame(moving(prepared, 1.0, why_limited=(Limit(LimitKind.JOINT_SPEED),)))
    assert panel._why.words == "Adapted: joint speed"
    panel.show_frame(moving(prepared, 1.1))
    assert panel._why.words == "Recently limited: joint speed"
    panel.show_frame(moving(prepared, 2.5))
    assert panel._why.words == "Not limited"


def test_robot_without_joints_is_reported(panel, prepared):
    panel.show_frame(touched(prepared.map))
    assert panel._why.words == "The robot has no actuated joints"


def test_step_response_is_shown_until_another_setting_is_changed(panel, prepared):
    settings = ControlSettings(controller="hybrid")
    panel.show_settings(settings)
    label = panel.findChild(QLabel, "step-response")
    for k in range(50):
        panel.show_frame(moving(prepared, 0.02 * k, task=TaskReport(force_goal=3.0)))
    assert label.text() == "Step response: none yet"
    panel.show_settings(replace(settings, force_goal=6.0))
    for k in range(50, 100):
        panel.show_frame(moving(prepared, 0.02 * k, task=TaskReport(force_goal=6.0)))
    assert "6.0" in label.text()
    assert label.text().startswith("Goal 3.0 → 6.0\u202fN: ")
    samples = len(panel._step._samples)
    panel.show_settings(replace(settings, force_goal=6.0, force_gain=0.02))
    panel.show_frame(moving(prepared, 2.0, task=TaskReport(force_goal=6.0)))
    assert len(panel._step._samples) == samples


def test_comparison_is_requested(panel, qtbot):
    with qtbot.waitSignal(panel.comparison_requested):
        click(panel, "compare-controllers")


def test_choosing_the_current_controller_is_not_an_edit(panel):
    assert "impedance" not in CONTROL_SCHEMES
    click(panel, "controller-impedance")
    assert panel.edits == []


@pytest.mark.long
@pytest.mark.parametrize(("steps", "limit"), [(4, 20.0), (0, 40.0)])
@pytest.mark.parametrize("controller", ["impedance", "hybrid"])
def test_force_limit_set_in_the_panel_stops_the_arm_with_a_reason(panel, controller, steps, limit):
    """A finger of 30 N stops the arm above a limit of 20 N and not above the usual one."""
    session = Session(arm(), scripted=False, settings=ControlSettings(controller=controller))
    panel.settings_edited.connect(lambda settings: session.submit(ControlChanged(settings)))
    panel.show_prepared(arm())
    panel.show_settings(session.settings)
    for _ in range(steps):
        QTest.keyClick(panel.sliders.by_name["max_force"]._slider, Qt.Key.Key_Left)
    session.tick()
    assert session.settings.max_force == pytest.approx(limit)
    session.submit(PokePressed(1, arm().skin.taxel_point(150), Finger(speed=0.5, max_force=30.0)))
    line = panel.findChild(LimitStatusLine)
    for _ in range(100):
        panel.show_frame(session.tick())
        if line.state is LimitState.STOPPED:
            break
    assert (line.state is LimitState.STOPPED) == (limit < 30.0)
    reason = f"stopped: contact force too high: .*more than {limit:.0f}.N; remove the contact to continue"
    assert (re.match(reason, line.words) is not None) == (limit < 30.0)


A = Limit(LimitKind.JOINT_LIMIT)
B = Limit(LimitKind.JOINT_SPEED)
STOPPED = Limit(LimitKind.STOPPED_BY_FORCE, value=41.0, bound=40.0)


@pytest.fixture
def line(qtbot):
    line = LimitStatusLine()
    qtbot.addWidget(line)
    line.resize(260, 60)
    line.show()
    qtbot.waitExposed(line)
    return line


@pytest.mark.parametrize(
    ("limits", "state", "words"),
    [
        ((), LimitState.FREE, "Not limited"),
        ((ShownLimit(A, True),), LimitState.LIMITED, "Limited: joint limit"),
        ((ShownLimit(A, False),), LimitState.ENDED, "Recently limited: joint limit"),
        ((ShownLimit(A, True), ShownLimit(B, False)), LimitState.LIMITED, "Limited: joint limit; joint speed"),
        ((ShownLimit(B, True),), LimitState.ADAPTED, "Adapted: joint speed"),
        ((ShownLimit(B, True), ShownLimit(A, True)), LimitState.LIMITED, "Limited: joint speed; joint limit"),
        ((ShownLimit(STOPPED, True),), LimitState.STOPPED, limit_text(STOPPED)),
    ],
)
def test_limit_line_shows_text_and_state(line, limits, state, words):
    line.show_limits(limits)
    assert (line.state, line.words) == (state, words)


def test_number_of_limits_is_in_front_if_the_first_one_takes_all_room(line):
    line.resize(150, 60)
    line.show_limits(
        (ShownLimit(Limit(LimitKind.PLACE_UNCERTAIN, value=0.006, bound=0.003), True), ShownLimit(B, True))
    )
    assert line.findChild(QLabel).text().startswith("Adapted: 2 limits, coarse skin")


def test_limits_without_room_are_counted_and_listed_in_the_tooltip(line):
    many = [Limit(kind) for kind in (LimitKind.SLOW_HOMING, LimitKind.SKIN_SATURATED, LimitKind.OSCILLATION)] * 2
    line.show_limits(tuple(ShownLimit(limit, True) for limit in many))
    label = line.findChild(QLabel)
    assert label.text().endswith("\u00a0more")
    assert label.heightForWidth(label.width()) <= label.height()
    assert not line.toolTip().endswith("\u00a0more")
    assert line.toolTip().count(limit_text(many[1])) == 2
    line.resize(1400, 60)
    assert not label.text().endswith("\u00a0more")


def test_number_and_unit_are_not_split_over_two_lines(line):
    line.show_limits((ShownLimit(Limit(LimitKind.FORCE_GAIN_UNSTABLE, bound=4.6e-3), True),))
    assert "mm/\u2060s\u00a0per\u00a0N" in line.findChild(QLabel).text()
    assert "mm/s per N" in line.words


def test_limit_line_states_that_the_robot_has_no_joints(line):
    line.say_no_joints()
    assert line.words == "The robot has no actuated joints"
    line.show_limits(())
    assert line.words == "Not limited"


def test_each_state_has_its_own_shape(line):
    drawn = {}
    acting = ((ShownLimit(one, True),) for one in (A, B, STOPPED))
    for limits in ((), (ShownLimit(A, False),), *acting):
        line.show_limits(limits)
        grey = pixels(line._sign.grab().toImage()).astype(float).mean(axis=2)
        drawn[line.state] = np.abs(grey - grey[0, 0]) > 30
    assert len(drawn) == len(LimitState)
    shapes = list(drawn.values())
    assert all(shape.any() for shape in shapes)
    assert all((a != b).mean() > 0.04 for k, a in enumerate(shapes) for b in shapes[:k])


@pytest.mark.long
def test_ended_limit_is_drawn_weaker_than_an_active_one(line):
    line.show_limits((ShownLimit(A, True), ShownLimit(B, False)))
    assert '<span style="color:palette(placeholder-text)">joint speed</span>' in line._words.text()
    assert "<span" not in line._words.text().split("joint speed<")[0].split(";")[0]


def picture_in(theme, widget):
    apply_theme(QApplication.instance(), theme)
    QApplication.processEvents()
    return pixels(widget.grab().toImage())


@pytest.fixture
def dark_theme(qapp):
    """Begin and end with the dark theme; widgets made before the first theme have another font until the second."""
    apply_theme(qapp, DARK)
    yield
    apply_theme(qapp, DARK)


def test_link_follows_the_theme(panel, dark_theme):
    for theme, other in ((LIGHT, DARK), (DARK, LIGHT), (LIGHT, DARK)):
        picture = picture_in(theme, panel.findChild(QLabel, "controller-difference"))
        colours = {QColor(*pixel).name() for row in picture.tolist() for pixel in row}
        assert theme.link in colours, "its underline"
        assert other.link not in colours


def test_ended_limit_follows_the_theme(dark_theme, line):
    line.show_limits((ShownLimit(B, False),))
    dark = picture_in(DARK, line._words)
    after = picture_in(LIGHT, line._words)
    line.show_limits(())
    line.show_limits((ShownLimit(B, False),))
    np.testing.assert_array_equal(after, picture_in(LIGHT, line._words))
    np.testing.assert_array_equal(dark, picture_in(DARK, line._words))


def test_rows_below_do_not_move_when_limits_appear_and_disappear(line):
    free = line.sizeHint().height()
    line.show_limits((ShownLimit(Limit(LimitKind.HELD_BACK), True), ShownLimit(B, True)))
    assert line.heightForWidth(260) <= max(free, line.minimumSizeHint().height()) + 1


def test_text_of_controllers_is_not_markup(line):
    line.show_limits((ShownLimit(Limit(LimitKind.JOINT_LIMIT, ("<b>5 < 6</b>",)), True),))
    assert "&lt;b&gt;5 &lt; 6" in line._words.text()


@pytest.mark.parametrize("theme", THEMES.values(), ids=THEMES)
def test_only_a_missed_goal_is_shown_as_an_alarm(theme):
    colours = {kind: severity_colour(kind.severity, theme) for kind in LimitKind}
    for kind in (LimitKind.JOINT_RESPONSE, LimitKind.FORCE_GAIN_HELD, LimitKind.POSITION_GAIN_HELD):
        assert colours[kind] == theme.quiet
    for kind in (LimitKind.OUT_OF_REACH, LimitKind.JOINT_LIMIT, LimitKind.CONTACT_LOST):
        assert colours[kind] == theme.warning
    assert {kind for kind in LimitKind if colours[kind] == theme.fault} == {kind for kind in LimitKind if kind.stops}
