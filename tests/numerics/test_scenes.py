"""The main job on every robot: touched by script and by hand, felt, answered, recorded and verified."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.control.command import ControlChanged, ControlSettings
from app.errors import RobotError
from app.recording.player import Player
from app.recording.recorder import Recorder
from app.recording.verify import verify
from app.scene.scene_file import load_scene
from app.session.prepare import prepare
from app.session.session import Session
from app.touch.poke import PokePressed, PokeReleased


@pytest.fixture(scope="module", params=["arm", "ur5e", "icub"])
def prepared(request):
    """Each shipped scene, with fewer taxels so that it is made in seconds."""
    scene = load_scene(request.param)
    try:
        return prepare(replace(scene, cover=replace(scene.cover, taxels=400)))
    except RobotError as error:
        pytest.skip(f"{request.param} needs the robots extra: {error}")


def facing_taxel(prepared) -> int:
    """A taxel in the middle of the patch that the scene strokes first."""
    names = [patch.name for patch in prepared.skin.patches]
    patch = names.index(prepared.scene.stimuli[0].patch)
    positions = prepared.skin.patches[patch].taxels.positions
    middle = np.linalg.norm(positions - positions.mean(axis=0), axis=1).argmin()
    return int(prepared.skin.first[patch] + middle)


def test_the_map_is_one_to_one_and_every_taxel_on_it(prepared):
    assert len(prepared.skin) == 400
    for taxel in range(0, 400, 7):
        at = prepared.skin.taxel_point(taxel)
        again = prepared.map.to_body(prepared.map.to_map(at))
        assert again is not None
        assert again.patch == at.patch
        assert np.linalg.norm(prepared.skin.position(again) - prepared.skin.position(at)) < 1e-9


def test_the_scripted_stroke_is_felt_and_force_is_conserved(prepared):
    session = Session(prepared)
    felt = 0
    for _ in range(400):
        frame = session.tick()
        pressed = sum(poke.force for poke in frame.pokes)
        assert float(frame.pressures @ prepared.skin.areas) == pytest.approx(pressed, rel=1e-6, abs=1e-9)
        felt += bool(frame.regions)
    assert felt > 200


def test_a_held_contact_stays_at_the_set_force_and_the_arm_comes_home(prepared):
    session = Session(prepared)
    session.submit(ControlChanged(ControlSettings(law="hold_force", force_goal=3.0)))
    session.submit(PokePressed(1, prepared.skin.taxel_point(facing_taxel(prepared))))
    forces = []
    for _ in range(800):
        frame = session.tick()
        forces.append(sum(region.force for region in frame.regions))
    assert np.mean(forces[-100:]) == pytest.approx(3.0, rel=0.05)
    assert np.abs(frame.posture - prepared.robot.home).max() > 0.005, "the arm must have moved"
    session.submit(PokeReleased(1))
    for _ in range(1200):
        frame = session.tick()
    assert np.abs(frame.posture - prepared.robot.home).max() < 0.01


def test_a_spring_to_home_yields_and_returns(prepared):
    session = Session(prepared)
    session.submit(PokePressed(1, prepared.skin.taxel_point(facing_taxel(prepared))))
    for _ in range(400):
        frame = session.tick()
    pushed = np.abs(frame.posture - prepared.robot.home).max()
    assert pushed > 1e-3
    session.submit(PokeReleased(1))
    for _ in range(800):
        frame = session.tick()
    assert np.abs(frame.posture - prepared.robot.home).max() < 0.05 * pushed


def test_it_is_recorded_and_verified_bit_for_bit(prepared, tmp_path):
    session = Session(prepared)
    with Recorder(tmp_path / "demo.mcap", prepared) as recorder:
        for tick in range(200):
            if tick == 50:
                session.submit(PokePressed(1, prepared.skin.taxel_point(facing_taxel(prepared))))
            recorder.write(session.tick(), session.inputs)
    outcome = verify(Player(tmp_path / "demo.mcap"))
    assert outcome.frames == 200
    assert outcome.identical


def test_links_that_feel_each_other_stay_quiet_at_home(prepared):
    """With self-contact on, nothing touches at rest and nothing moves: what overlaps by construction is excluded."""
    scene = replace(prepared.scene, wishes={"contact": "self"}, stimuli=())
    session = Session(replace(prepared, scene=scene))
    for _ in range(200):
        frame = session.tick()
    assert not frame.regions
    assert np.abs(frame.posture - prepared.robot.home).max() < 1e-3
