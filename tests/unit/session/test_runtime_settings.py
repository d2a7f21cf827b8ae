"""What a person may change while a session runs: what is in force at a tick, and what leads from one to another."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

import pytest

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.behaviours import Behaviour
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.scene.effects import Effects
from tactile_maps.session.inputs import (
    BehavioursChanged,
    ControlChanged,
    EffectsChanged,
    MapEdited,
    ReadingChanged,
    SessionInput,
)
from tactile_maps.session.runtime_settings import CHANGES, RuntimeSettings, runtime_settings_at
from tactile_maps.session.session import Session
from tactile_maps.studies.testbeds.reference_bodies import flat_map
from tactile_maps.tactile.poke import PokeReleased
from tests.support.touch import prepared_bar

START = RuntimeSettings.of_scene(prepared_bar(control={"controller": "hybrid"}, reading={"estimator": "tikhonov"}))
ACTS = {
    "settings": ControlChanged(ControlSettings(stiffness=12.0)),
    "effects": EffectsChanged(Effects(gravity="on")),
    "behaviours": BehavioursChanged((Behaviour("tap", then={"task": "guide"}),)),
    "reading": ReadingChanged(ReadingSettings("lumped")),
    "map": MapEdited("As it was edited before", flat_map(30)),
}


def test_a_scene_says_how_it_starts():
    assert (START.settings.controller, START.reading.estimator, START.behaviours) == ("hybrid", "tikhonov", ())


@pytest.mark.parametrize("name", ACTS)
def test_an_input_changes_its_own_part_and_is_found_again(name):
    after = START.after(ACTS[name])
    changed = [part for part in ACTS if getattr(after, part) is not getattr(START, part)]
    assert changed == [name]
    [found] = after.since(START)
    assert vars(found) == vars(ACTS[name])


def test_the_same_rules_need_no_input():
    assert START.since(replace(START)) == []
    assert START.after(PokeReleased(1)) is START


def test_the_inputs_that_change_something_are_named():
    """A player looks at these alone."""
    for kind in get_args(SessionInput):
        assert (kind in CHANGES) is (kind in {type(act) for act in ACTS.values()})


@pytest.mark.parametrize(("tick", "stiffness"), [(0, 8.0), (4, 8.0), (5, 12.0), (8, 12.0), (9, 3.0), (100, 3.0)])
def test_the_rules_at_a_tick(tick, stiffness):
    inputs = [
        (5, ControlChanged(ControlSettings(stiffness=12.0))),
        (6, PokeReleased(1)),
        (9, ControlChanged(ControlSettings(stiffness=3.0))),
    ]
    assert runtime_settings_at(START, inputs, tick).settings.stiffness == stiffness


def test_a_session_runs_by_what_it_is_given():
    session = Session(prepared_bar(), scripted=False)
    assert session.runtime_settings.since(RuntimeSettings.of_scene(session.prepared)) == []
    session.submit(ACTS["reading"])
    session.tick()
    assert session.runtime_settings.since(RuntimeSettings.of_scene(session.prepared)) == [ACTS["reading"]]
