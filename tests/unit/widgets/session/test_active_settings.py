"""Settings and effects in force: told once a change, asked for again after a reset, taken back when refused."""

from __future__ import annotations

from dataclasses import replace

import pytest

from app.control.command import ControlChanged, ControlSettings
from app.session.inputs import EffectsChanged
from app.session.session import Session
from tests.support.touch import prepared_bar
from widgets.session.active_settings import ActiveSettings
from widgets.session.session_signals import SessionSignals

BAR = prepared_bar()
STIFF = ControlSettings(stiffness=20.0)
LIMITLESS = replace(BAR.scene.effects, joint_limits=False)


@pytest.fixture
def session():
    return Session(BAR, scripted=False)


@pytest.fixture
def facts():
    made = SessionSignals()
    made.heard = []
    made.settings_changed.connect(made.heard.append)
    made.effects_changed.connect(made.heard.append)
    return made


def test_each_is_told_only_when_it_is_another(session, facts):
    in_force = ActiveSettings(facts)
    in_force.begin(session)
    assert facts.heard == [session.settings, session.effects]
    in_force.begin(session)
    in_force.ask(ControlChanged(session.settings))
    assert len(facts.heard) == 2
    in_force.ask(ControlChanged(STIFF))
    in_force.ask(EffectsChanged(LIMITLESS))
    assert facts.heard[2:] == [STIFF, LIMITLESS]


def test_what_something_else_is_shown_by_is_told_even_where_it_is_the_same(session, facts):
    in_force = ActiveSettings(facts)
    in_force.begin(session)
    in_force.forget()
    in_force.tell(session.runtime_settings)
    assert len(facts.heard) == 4


def test_what_has_not_taken_effect_waits(session, facts):
    in_force = ActiveSettings(facts)
    assert in_force.waiting(session) == []
    in_force.begin(session)
    assert in_force.waiting(session) == []
    in_force.ask(ControlChanged(STIFF))
    in_force.ask(EffectsChanged(LIMITLESS))
    waiting = in_force.waiting(session)
    assert waiting == [ControlChanged(STIFF), EffectsChanged(LIMITLESS)]
    for act in waiting:
        session.submit(act)
    session.tick()
    assert in_force.waiting(session) == []


def test_what_was_refused_is_as_the_session_has_it(session, facts):
    in_force = ActiveSettings(facts)
    in_force.begin(session)
    in_force.ask(EffectsChanged(LIMITLESS))
    in_force.begin(session)
    assert facts.heard[-2:] == [LIMITLESS, session.effects]
    assert in_force.waiting(session) == []
