"""Budget in the panel: the proposal is shown next to the current settings, applied and reverted by one click."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QPushButton

from tactile_maps.core.timing import Timings
from tactile_maps.studies.budget.measurement import BudgetMeasurement
from tactile_maps.studies.budget.proposal import Cost, Option
from tactile_maps.studies.study.work_precision import Setting, Trial
from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.common.colours import DARK
from tactile_widgets.panels.model.budget_section import BudgetSection

NOW = {
    "simulation": Setting("simulation", "implicitfast", {"timestep_ms": 1.0}),
    "touch": Setting("touch", "water-fill"),
    "image": Setting("image", "natural-neighbour", {"pixels": 256}),
    "control": Setting("control", "hybrid", {"path_speed_mm_s": 10.0}),
}


def option(stage, method, ms, mm, values=None):
    setting = Setting(stage, method, values or {})
    return Option(Trial(setting, "", ms, {}), Cost(ms, mm))


def measured(*, paths=True):
    options = {
        "simulation": (option("simulation", "implicitfast", 0.2, 0.0, {"timestep_ms": 1.0}),),
        "touch": (option("touch", "water-fill", 0.02, 4.0), option("touch", "punch", 0.4, 1.0)),
        "image": (
            option("image", "nearest", 0.01, 3.0, {"pixels": 128}),
            option("image", "natural-neighbour", 0.5, 1.0, {"pixels": 512}),
        ),
    }
    errors = {"body_mm": 2.0, "force_n": 0.2, "lost_percent": 0.0}
    round_ = Trial(Setting("control", "parallel", {"path_speed_mm_s": 30.0}), "", 4000.0, errors)
    return BudgetMeasurement(options, (round_,) if paths else (), 0.005, 3.0, 8.0)


@pytest.fixture
def section(qtbot):
    apply_theme(QApplication.instance(), DARK)
    made = BudgetSection()
    qtbot.addWidget(made)
    made.resize(280, 240)
    made.show_present(NOW, can_measure=True)
    made.show()
    qtbot.waitExposed(made)
    return made


def press(section, name, qtbot):
    button = section.findChild(QPushButton, f"budget-{name}")
    assert button.isVisible()
    assert button.isEnabled()
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton)


def limit(section, kind, **limits):
    section.kind.setCurrentIndex(section.kind.findData(kind))
    section.kind.activated.emit(section.kind.currentIndex())
    for name, number in limits.items():
        section.limits[name].setValue(number)


def test_limit_fields_follow_the_kind_of_budget(section):
    assert [name for name, field in section.limits.items() if field.isVisible()] == ["milliseconds"]
    limit(section, "errors")
    assert [name for name, field in section.limits.items() if field.isVisible()] == ["millimetres", "newtons"]
    assert not section.apply.isEnabled()
    section.show_present({}, can_measure=False)
    assert not section.propose.isEnabled()


def test_controllers_are_measured_if_errors_are_limited(section, qtbot):
    with qtbot.waitSignal(section.measure_requested) as asked:
        press(section, "propose", qtbot)
    assert asked.args == [False]
    limit(section, "errors")
    with qtbot.waitSignal(section.measure_requested) as asked:
        press(section, "propose", qtbot)
    assert asked.args == [True]


def test_one_measurement_is_used_for_every_budget_and_states_the_trade_off(section):
    section.show_measured(measured())
    limit(section, "time", milliseconds=0.3)
    assert "<b>Nearest 128²</b>" in section.table.text()
    assert "Natural neighbour 256²" in section.table.text()
    assert "0.23\u202fms a tick" in section.note.text()
    assert "most accurate settings: 1.1\u202fms" in section.note.text()
    limit(section, "time", milliseconds=1.2)
    assert "<b>Punch</b>" in section.table.text()
    limit(section, "time", milliseconds=0.1)
    assert "nearest settings need 0.23 ms" in section.note.text()
    assert not section.table.text()
    assert not section.apply.isEnabled()


def test_error_budget_proposes_a_controller_or_reports_that_none_satisfies_it(section):
    section.show_measured(measured())
    limit(section, "errors", millimetres=4.5, newtons=0.5)
    assert "Parallel 30\u202fmm/s" in section.table.text()
    assert "A path of 30\u202fmm in 4\u202fs" in section.note.text()
    limit(section, "errors", millimetres=1.5, newtons=0.1)
    assert "No controller keeps both limits" in section.note.text()


def test_apply_and_back_are_one_click_and_measured_time_follows_prediction(section, qtbot):
    section.show_measured(measured(paths=False))
    limit(section, "time", milliseconds=0.3)
    with qtbot.waitSignal(section.applied) as applied:
        press(section, "apply", qtbot)
    (settings,) = applied.args
    assert [one.stage for one in settings] == ["simulation", "touch", "image"]
    section.show_present({**NOW, **{one.stage: one for one in settings}}, can_measure=True)
    assert not section.apply.isEnabled(), "it is already applied"
    section.show_frames(ticks(0.3, 0.05))
    assert section.note.text() == "Simulation and touch: 0.22\u202fms predicted, 0.35\u202fms measured."
    with qtbot.waitSignal(section.applied) as back:
        press(section, "back", qtbot)
    assert back.args == [tuple(NOW[one.stage] for one in settings)]
    assert not section.back.isEnabled()


def ticks(physics, touch):
    return [SimpleNamespace(timings=Timings({"physics": physics, "touch": touch, "control": 9.0}))] * 60


def test_prediction_is_scaled_to_the_slower_window(section, qtbot):
    """The current settings take three times as long in the window as alone."""
    section.show_measured(measured(paths=False))
    limit(section, "time", milliseconds=1.2)
    section.show_frames(ticks(0.6, 0.06))
    press(section, "apply", qtbot)
    section.show_frames(ticks(0.6, 1.1))
    assert section.note.text() == "Simulation and touch: 1.8\u202fms predicted, 1.7\u202fms measured."


def test_another_scene_clears_the_budget(section):
    section.show_measured(measured())
    section.forget()
    assert (section.table.text(), section.note.text()) == ("", "")
    assert not section.apply.isEnabled()
    limit(section, "time", milliseconds=0.5)
    assert not section.table.text()
