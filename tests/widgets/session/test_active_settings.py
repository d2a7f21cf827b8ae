"""Current settings and effects are reported once per change, and again when another session is shown."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.session.runtime_settings import RuntimeSettings
from tactile_widgets.session.session_run import ActiveSettings
from tests.support.touch import prepared_bar

BAR = prepared_bar()
START = RuntimeSettings.of_scene(BAR)
STIFF = ControlSettings(stiffness=20.0)
LIMITLESS = replace(BAR.scene.effects, joint_limits=False)


@pytest.fixture
def heard():
    return []


@pytest.fixture
def active(heard):
    return ActiveSettings(settings=heard.append, effects=heard.append)


def test_setting_is_reported_only_when_it_changes(active, heard):
    active.show(START)
    assert heard == [START.settings, START.effects]
    active.show(START)
    active.show(replace(START, settings=replace(START.settings)))
    assert len(heard) == 2, "equal is not another"
    active.show(replace(START, settings=STIFF))
    active.show(replace(START, settings=STIFF, effects=LIMITLESS))
    assert heard[2:] == [STIFF, LIMITLESS]


def test_all_settings_of_another_source_are_reported(active, heard):
    active.show(START)
    active.forget()
    active.show(START)
    assert heard == 2 * [START.settings, START.effects]
