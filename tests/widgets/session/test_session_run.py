"""A running scene in the window: requested changes survive a reset, rejected ones do not."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.session.inputs import ControlChanged, EffectsChanged
from tactile_maps.session.session import Session
from tactile_widgets.session.session_run import SessionRun
from tactile_widgets.session.session_runner import InlineRunner
from tests.support.touch import prepared_bar

BAR = prepared_bar()
STIFF = ControlSettings(stiffness=20.0)
LIMITLESS = replace(BAR.scene.effects, joint_limits=False)


@pytest.fixture
def run():
    return SessionRun(InlineRunner(Session(BAR, scripted=False), lambda _frame: None))


def test_pending_inputs_wait_until_they_are_applied(run):
    assert run.waiting() == []
    run.submit(ControlChanged(STIFF))
    run.submit(EffectsChanged(LIMITLESS))
    assert run.settings.settings == STIFF
    assert run.waiting() == [ControlChanged(STIFF), EffectsChanged(LIMITLESS)]
    run.runner.step()
    assert run.waiting() == []


def test_requested_settings_are_kept_after_a_reset(run):
    run.submit(EffectsChanged(LIMITLESS))
    assert not run.reset()
    run.runner.step()
    assert run.runner.session.effects == LIMITLESS


def test_rejected_settings_are_no_longer_requested(run):
    run.submit(EffectsChanged(replace(BAR.scene.effects, timestep=0.003)))
    run.runner.step()
    update = run.update()
    assert "whole number" in str(update.failure)
    assert run.settings.effects == run.runner.session.effects == BAR.scene.effects
    assert run.waiting() == []
    assert run.update().failure is None, "it is said once"
