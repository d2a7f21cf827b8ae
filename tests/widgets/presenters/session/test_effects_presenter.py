"""Effects chosen in the real window: they act live, keep the state, are asked about, refused, recorded and replayed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtWidgets import QPushButton, QToolButton

from tactile_maps.live.sources.open import SourceOptions
from tactile_maps.scene.scene import with_override
from tactile_maps.scene.stability import stability_warning
from tactile_maps.session.inputs import EffectsChanged
from tactile_maps.studies.study.work_precision import Setting
from tactile_widgets.common.mode import Mode
from tactile_widgets.session.live_input import LiveInputSettings
from tests.widgets.support.mouse import left_click
from tests.widgets.support.window_driver import choose_effect, press_map, record_run, run

pytestmark = pytest.mark.long


@pytest.fixture
def window(window_again):
    """Effects begin again with the scene."""
    return window_again


@pytest.fixture
def panel(window):
    return window.column["effects"]


def in_force(window):
    return window.live.runner.session.effects


def test_chosen_effect_acts_at_the_next_tick_and_keeps_the_state(window, panel):
    run(window, 0.2)
    press_map(window, 70)
    run(window, 0.4)
    before = window.live.runner.session.frame
    assert before.pokes
    assert before.regions
    choose_effect(window, "noise", "on")
    run(window, 0.005)
    after = window.live.runner.session.frame
    assert in_force(window).sensor.noise is not None
    assert after.tick == before.tick + 1
    assert [poke.id for poke in after.pokes] == [poke.id for poke in before.pokes]
    np.testing.assert_allclose(after.posture, before.posture, atol=1e-3)
    assert panel.lines["noise"].words[1] == "on"
    assert panel.lines["noise"].marked


def test_auto_removes_a_choice(window, panel):
    opened = window.presenters.effects.scene
    choose_effect(window, "noise", "on")
    choose_effect(window, "friction", "on")
    run(window, 0.01)
    choose_effect(window, "noise", "auto")
    run(window, 0.01)
    assert in_force(window) == with_override(opened, "friction", "on").effects
    left_click(panel.findChild(QPushButton, "effects-all-auto"))
    run(window, 0.01)
    assert in_force(window) == opened.effects
    assert not any(line.marked for line in panel.lines.values())


def test_choice_equal_to_the_automatic_value_is_stored(window, panel):
    choose_effect(window, "joint_limits", "on")
    run(window, 0.01)
    assert panel.lines["joint_limits"].marked
    assert window.presenters.effects.scene.overrides["joint_limits"] == "on"
    changes = [act for _, act in window.live.runner.session.inputs if isinstance(act, EffectsChanged)]
    assert not changes, "the simulation is unchanged"


def test_rejected_effect_is_reported_and_the_panel_restored(window, panel):
    refused = replace(window.presenters.effects.scene.effects, timestep=0.003)
    window.live.set_effects(refused)
    run(window, 0.05)
    assert "whole number" in window.notification_bar.text
    assert window.live.mode is Mode.RUNNING, "the session continues"
    assert window.live.runner.session.frame.tick
    assert panel.lines["timestep"].words[1] == "0.001 s"


def test_contradicting_choice_is_rejected(window, panel):
    panel.override_requested.emit("timestep", 0.003)
    assert "whole number" in window.notification_bar.text
    run(window, 0.01)
    assert in_force(window) == window.presenters.effects.scene.effects


@pytest.fixture
def in_a_corner(window, panel):
    """Choose an unstable integrator: long explicit steps while bodies touch."""
    choose_effect(window, "contact", "all")
    run(window, 0.01)
    choose_effect(window, "integrator", "euler")
    run(window, 0.01)
    for step in (0.0025, 0.005):
        scene = with_override(window.presenters.effects.scene, "timestep", step)
        if stability_warning(scene.effects, scene.layer) != stability_warning(
            window.presenters.effects.scene.effects, window.presenters.effects.scene.layer
        ):
            choose_effect(window, "timestep", step)
            return scene
    return pytest.fail("the table knows no corner here")


def test_unstable_choice_needs_a_confirmation(window, panel, in_a_corner):
    assert "Contact" in window.notification_bar.text or "contact" in window.notification_bar.text
    run(window, 0.02)
    assert in_force(window).timestep != in_a_corner.effects.timestep
    assert panel.lines["timestep"].words[1] == "0.001 s"
    button = window.notification_bar.findChild(QToolButton, "message-remedy")
    assert button.text() == "Use anyway"
    left_click(button)
    run(window, 0.005)
    assert in_force(window).timestep == in_a_corner.effects.timestep
    assert panel.findChild(object, "effects-warnings").isVisibleTo(panel)


def test_unstable_choice_can_be_declined(window, panel, in_a_corner):
    before = in_force(window)
    keep = window.notification_bar.findChild(QToolButton, "message-dismiss")
    assert keep.text() == "Keep"
    left_click(keep)
    run(window, 0.02)
    assert in_force(window) == before
    assert window.notification_bar.text == ""


def test_effects_chosen_while_paused_are_kept_after_a_reset(window, panel):
    window.action("pause").trigger()
    choose_effect(window, "noise", "on")
    window.action("reset").trigger()
    window.action("pause").trigger()
    run(window, 0.02)
    assert in_force(window).sensor.noise is not None
    assert panel.lines["noise"].words[1] == "on"


def test_replay_shows_its_effects_and_accepts_no_choice(window, panel, tmp_path):
    choose_effect(window, "noise", "on")
    run(window, 0.1)
    path = tmp_path / "effects.mcap"
    window.live.recording.start(path)
    run(window, 0.2)
    choose_effect(window, "friction", "on")
    run(window, 0.2)
    window.live.recording.stop()
    choose_effect(window, "noise", "auto")
    run(window, 0.1)
    window.live.open_recording(path)
    assert panel.lines["noise"].words[1] == "on"
    assert panel.lines["friction"].words[1] == "off"
    assert not panel.lines["noise"].box.isEnabled()
    shown = window.presenters.effects.scene
    window.presenters.effects.choose("fingers", "off")
    panel.auto_all_requested.emit()
    assert window.presenters.effects.scene is shown
    window.live.replay.seek(window.live.replay.player.duration)
    assert panel.lines["friction"].words[1] == "on"
    window.live.replay.leave()
    assert panel.lines["noise"].words[1] == "off"
    assert panel.lines["friction"].words[1] == "on", "the choice is kept"
    assert panel.lines["noise"].box.isEnabled()


def test_time_step_of_readings_is_not_shown_as_a_choice(window, panel, tmp_path):
    (tmp_path / "readings.csv").write_text("# unit: Pa\ntime,0,1\n" + "".join(f"{n / 10},0,0\n" for n in range(9)))
    window.live.connection.open(LiveInputSettings(str(tmp_path / "readings.csv"), SourceOptions(speed=None)))
    run(window, 0.1)

    def shown():
        line = panel.lines["timestep"]
        return line.words[1], line.marked, "nothing is simulated" in line.toolTip()

    assert shown() == ("0.0001 s", False, True)
    record_run(window, tmp_path / "real.mcap", 0.3)
    window.live.open_recording(tmp_path / "real.mcap")
    assert shown() == ("0.0001 s", False, True)
    window.live.replay.leave()
    window.live.connection.close()
    assert "nothing is simulated" not in panel.lines["timestep"].toolTip()
    choose_effect(window, "timestep", 0.001)
    run(window, 0.1)
    assert panel.lines["timestep"].marked


def test_measured_costs_are_shown_in_the_panel(window, panel):
    window.live.measurements.cost_seconds = 0.2
    panel.set_folded(False)
    panel.folded_changed.emit(False)
    window.live.measurements.cost_executor.run_waiting()
    cost = panel.lines["joint_limits"].words[2]
    assert cost not in ("…", "–")
    assert panel.lines["friction"].words[2] == "–"


def test_controller_chosen_by_accuracy_is_used(window):
    """Controller and speed are applied, the gains stay, and the point becomes the current setting."""
    before = window.live.runner.session.settings
    chosen = Setting("control", "parallel", {"path_speed_mm_s": 30.0})
    window.column["accuracy"].chosen.emit(chosen)
    run(window, 0.02)
    settings = window.live.runner.session.settings
    assert (settings.controller, settings.task, settings.path_speed) == ("parallel", "follow_path", 0.03)
    assert settings.force_goal == before.force_goal
    assert window.column["accuracy"]._present["control"] == chosen
    assert window.column["controller"].settings == settings


def test_contact_model_chosen_by_accuracy_is_used(window, panel):
    setting = Setting("touch", "punch")
    window.column["accuracy"].chosen.emit(setting)
    run(window, 0.02)
    assert in_force(window).skin == setting.method
    assert panel.lines["skin"].words[1] == setting.method
    assert window.column["accuracy"]._present["touch"] == setting
