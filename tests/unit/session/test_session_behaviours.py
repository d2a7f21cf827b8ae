"""Behaviours in a session: a touch changes the controller at the next tick, recorded and replayed alike."""

from __future__ import annotations

from dataclasses import asdict, replace

import pytest

from app.control.behaviour import Behaviour
from app.control.command import ControlChanged, ControlSettings
from app.errors import SceneError
from app.recording.player import Player
from app.recording.recorder import Recorder
from app.recording.verify import verify
from app.session.inputs import BehavioursChanged
from app.session.session import Session
from app.touch.poke import Finger, PokePressed, PokeReleased
from tests.touch import arm, prepared_bar, taxel_near

DOUBLE = Behaviour("tap", times=2, then={"law": "hybrid", "task": "retreat"})
PRESSED = Behaviour("press", until_released=True, then={"force_goal": 1.0})


def session_with(*behaviours: Behaviour) -> Session:
    return Session(prepared_bar(control={"law": "hybrid"}, behaviours=tuple(map(asdict, behaviours))))


def tap(session: Session, *, ticks: int = 20) -> None:
    taxel = taxel_near(session.prepared.skin, 0, (0.3, 0.0, 0.02))
    session.submit(PokePressed(1, session.prepared.skin.taxel_point(taxel), Finger(speed=0.05)))
    for _ in range(ticks):
        session.tick()
    assert session.frame.regions, "it was felt"
    session.submit(PokeReleased(1))
    for _ in range(40):
        session.tick()
    assert not session.frame.regions


def derived(session: Session) -> list[str]:
    return [act.by for _, act in session.inputs if isinstance(act, ControlChanged) and act.by]


def test_a_double_tap_makes_the_arm_retreat():
    session = session_with(DOUBLE)
    tap(session)
    assert session.settings.task == "keep_force"
    tap(session)
    assert session.settings.task == "retreat"
    assert derived(session) == ["double tap"]


def test_while_pressed_another_goal_holds():
    session = session_with(PRESSED)
    skin = session.prepared.skin
    session.submit(PokePressed(1, skin.taxel_point(taxel_near(skin, 0, (0.3, 0.0, 0.02)))))
    for _ in range(100):
        session.tick()
    assert session.settings.force_goal == 1.0
    session.submit(PokeReleased(1))
    for _ in range(100):
        session.tick()
    assert session.settings.force_goal == ControlSettings().force_goal
    assert derived(session) == ["press", "released"]


def test_behaviours_can_be_changed_while_it_runs_and_outlive_a_reset():
    session = session_with()
    session.submit(BehavioursChanged((DOUBLE,)))
    session.tick()
    session.reset()
    assert session.rules.behaviours == (DOUBLE,)
    assert (0, BehavioursChanged((DOUBLE,))) in session.inputs
    tap(session)
    tap(session)
    assert session.settings.task == "retreat"


def test_behaviours_for_other_skin_are_refused_and_the_old_ones_stay():
    session = session_with(DOUBLE)
    session.submit(BehavioursChanged((Behaviour("tap", "elbow", then={"task": "guide"}),)))
    with pytest.raises(SceneError, match="elbow"):
        session.tick()
    session.tick()
    assert session.rules.behaviours == (DOUBLE,)


def test_what_a_behaviour_did_is_not_taken_from_outside():
    session = session_with(DOUBLE)
    session.submit(ControlChanged(ControlSettings(law="qp"), by="double tap"))
    session.tick()
    assert session.settings.law == "hybrid"


def test_a_recording_replays_what_behaviours_did(tmp_path):
    prepared = arm()
    scene = replace(prepared.scene, stimuli=(), control={"law": "hybrid"}, behaviours=(asdict(PRESSED),))
    prepared = replace(prepared, scene=scene)
    session = Session(prepared)
    with Recorder(tmp_path / "r.mcap", prepared) as recorder:
        for tick in range(360):
            if tick == 10:
                session.submit(PokePressed(1, prepared.skin.taxel_point(40)))
            if tick == 160:
                session.submit(BehavioursChanged((PRESSED, DOUBLE)))
                session.submit(PokeReleased(1))
            recorder.write(session.tick(), session.inputs)
    assert derived(session) == ["press", "released"]
    player = Player(tmp_path / "r.mcap")
    assert player.rules_at(0).behaviours == (PRESSED,)
    assert player.rules_at(200).behaviours == (PRESSED, DOUBLE)
    assert player.inputs == session.inputs
    assert verify(player).identical
