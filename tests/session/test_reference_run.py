"""The reference run: the same session where the effects are the same, to the bit; else nearer to the truth."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import SimulationError
from tactile_maps.scene.effects import Effects
from tactile_maps.session.inputs import ControlChanged, EffectsChanged
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.reference_run import FINER, ReferenceRun, reference_effects
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import Finger, PokeMoved, PokePressed, PokeReleased
from tests.support.pressed_arm import forearm
from tests.support.sessions import run


@pytest.fixture(scope="module")
def prepared() -> PreparedScene:
    return forearm()


def same(effects: Effects) -> Effects:
    return effects


def played(prepared: PreparedScene, ticks: int = 160):
    """A session in which a finger presses, strokes and leaves, and a person changes controller and effects."""
    skin = prepared.skin
    session = Session(prepared, scripted=False)
    acts = {
        5: PokePressed(1, skin.taxel_point(150), Finger(stiffness=2000.0)),
        60: PokeMoved(1, skin.taxel_point(151)),
        80: ControlChanged(ControlSettings(controller="hybrid", task="hold_point", force_goal=3.0)),
        110: EffectsChanged(replace(session.effects, friction=True)),
        140: PokeReleased(1),
    }
    return session, run(session, ticks, {tick: [each] for tick, each in acts.items()})


def differences(prepared, session, frames, effects=reference_effects):
    reference = ReferenceRun(prepared, session.inputs, effects=effects)
    reference.take(session.inputs)
    found = []
    for frame in frames[::4]:
        while not reference.advance(frame.tick, 10.0):
            pass
        found.append(reference.compare(frame))
    return found


def test_reference_with_the_same_effects_equals_the_session(prepared):
    session, frames = played(prepared)
    found = differences(prepared, session, frames, same)
    assert any(one.place is not None for one in found)
    assert {(one.place or 0.0, one.force, one.posture, one.wrong_taxels or 0.0, one.unmatched) for one in found} == {
        (0.0, 0.0, 0.0, 0.0, 0)
    }


def test_reference_effects_are_finer_and_keep_exact_models():
    usual = Effects(skin="water-fill", timestep=0.001)
    assert reference_effects(usual) == replace(usual, timestep=0.001 / FINER, skin="half-space")
    for model in ("foundation", "depth", "half-space", "off"):
        assert reference_effects(replace(usual, skin=model)).skin == model


@pytest.mark.long
def test_difference_is_proportional_to_the_time_step(prepared):
    """The integrator is of first order: half the step, half the difference, against the same fine reference."""
    fine = Effects(timestep=0.00015625)
    off = []
    for timestep in (0.005, 0.0025, 0.00125):
        scene = replace(prepared.scene, overrides={**prepared.scene.overrides, "timestep": timestep})
        own = replace(prepared, scene=scene)
        session = Session(own, scripted=False)
        session.submit(PokePressed(1, own.skin.taxel_point(150), Finger(stiffness=500.0)))
        frames = [session.tick() for _ in range(40)]
        assert session.effects.timestep == timestep
        found = differences(own, session, frames, lambda effects: replace(effects, timestep=fine.timestep))
        off.append(max(one.force for one in found))
    for coarse, finer in pairwise(off):
        assert 0.3 < finer / coarse < 0.7


def test_blur_of_the_cover_changes_taxels_but_not_the_force(prepared):
    session, frames = played(prepared, 100)
    found = [one for one in differences(prepared, session, frames) if one.wrong_taxels is not None]
    assert np.median([one.wrong_taxels for one in found]) > 0.005
    assert max(one.place for one in found if one.place is not None) < 0.005
    assert all(one.reference_ms is not None and one.session_ms > 0 for one in found)


@pytest.mark.long
def test_reference_stops_when_its_time_is_used_up_and_continues(prepared):
    session, frames = played(prepared, 100)
    reference = ReferenceRun(prepared, session.inputs)
    reference.take(session.inputs)
    assert not reference.advance(100, 0.0)
    assert reference.time == 0.0
    assert reference.advance(100, 60.0)
    assert reference.time == frames[-1].time


def test_failing_reference_raises_its_error(prepared):
    session, _frames = played(prepared, 40)
    broken = lambda effects: replace(effects, timestep=0.005, integrator="euler", gravity="on")  # noqa: E731
    reference = ReferenceRun(prepared, session.inputs, effects=broken)
    reference.take([*session.inputs, (20, PokePressed(2, prepared.skin.taxel_point(10), Finger(stiffness=1e9)))])
    with pytest.raises(SimulationError):
        reference.advance(40, 60.0)
