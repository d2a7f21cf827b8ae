"""The scripted hand does what a person could do, and only what the tick says."""

from __future__ import annotations

import numpy as np
import pytest

from app.errors import SceneError
from app.simulation.poke import PokeMoved, PokePressed, PokeReleased
from app.simulation.stimuli import FINGER, StimulusPlayer, Stroke, stroke_path
from app.skin.skin import Patch, Skin
from app.skin.taxels import Taxels
from tests.touch import arm, bar_skin

TICK = 0.005


def test_a_path_lies_on_the_skin_in_even_steps():
    skin = arm().skin
    path = stroke_path(skin, Stroke(patch="forearm", start=(0.1, 0.2), end=(0.9, 0.4)))
    points = np.array([skin.position(at) for at in path])
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert len(path) > 100
    assert {at.patch for at in path} == {1}
    assert steps.max() < 0.004, "no jump: the finger strokes"
    assert np.median(steps) == pytest.approx(0.001, rel=0.2)


def test_one_stroke_presses_moves_and_lifts_within_its_time():
    stroke = Stroke(hold=0.1, rest=0.2, speed=0.1, force=2.5)
    player, path = StimulusPlayer(bar_skin(), [stroke], tick=TICK), stroke_path(bar_skin(), stroke)
    acts = {tick: player.inputs(tick) for tick in range(2000)}
    press = acts[0][0]
    assert isinstance(press, PokePressed)
    assert press.finger.max_force == 2.5
    lift = next(tick for tick, act in acts.items() if any(isinstance(one, PokeReleased) for one in act))
    assert lift * TICK == pytest.approx(0.1 + (len(path) - 1) * 0.001 / 0.1, abs=TICK)
    assert acts[lift][0].at == path[-1]
    assert all(isinstance(one, PokeMoved) for tick in range(1, lift) for one in acts[tick])
    assert not any(acts[tick] for tick in range(1, int(0.1 / TICK))), "pressed in before it moves"
    again = next(tick for tick in range(lift + 1, 2000) if acts[tick])
    assert again - lift == pytest.approx(0.2 / TICK, abs=1)
    assert acts[again] == acts[0], "and again"
    assert {one.id for act in acts.values() for one in act} == {FINGER}


def test_the_same_place_twice_is_a_poke_that_lifts():
    player = StimulusPlayer(bar_skin(), [Stroke(end=(0.25, 0.25), hold=0.05, rest=0.05)], tick=TICK)
    kinds = [[type(act) for act in player.inputs(tick)] for tick in range(21)]
    assert kinds[0] == kinds[20] == [PokePressed]
    assert kinds[10] == [PokeMoved, PokeReleased]
    assert not any(kinds[1:10] + kinds[11:20])


def test_strokes_take_turns():
    strokes = [Stroke(patch=name, hold=0, rest=0, speed=1.0) for name in ("hand", "forearm")]
    player = StimulusPlayer(arm().skin, strokes, tick=TICK)
    presses = [act.at.patch for tick in range(400) for act in player.inputs(tick) if isinstance(act, PokePressed)]
    assert presses[:4] == [2, 1, 2, 1]


def test_no_strokes_do_nothing():
    assert StimulusPlayer(bar_skin(), [], tick=TICK).inputs(123) == []


def test_an_unknown_patch_is_named_with_the_known_ones():
    with pytest.raises(SceneError, match=r"wing.*top"):
        StimulusPlayer(bar_skin(), [Stroke(patch="wing")], tick=TICK)


def test_where_no_way_leads_there_it_presses_the_end():
    patch = bar_skin().patches[0]
    taxels = Taxels(patch.taxels.positions, patch.taxels.normals, patch.taxels.faces, patch.taxels.weights,
                    patch.taxels.areas, np.zeros((0, 2)), patch.taxels.quadrature)  # fmt: skip
    assert len(stroke_path(Skin((Patch("top", "bar", patch.surface, taxels),)), Stroke())) == 1


@pytest.mark.parametrize("bad", [{"start": (2.0, 0.0)}, {"end": (0.0, -1.0)}, {"force": -1.0}, {"speed": 0.0},
                                 {"hold": float("nan")}, {"rest": float("inf")}])  # fmt: skip
def test_a_stroke_that_cannot_be_is_refused(bad):
    with pytest.raises(SceneError, match=f"strokes.{next(iter(bad))}"):
        Stroke(**bad)
