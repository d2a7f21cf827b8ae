"""The scripted hand does what a person could do, and only what the tick says."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SceneError
from tactile_maps.stimuli.stimulus_kinds import Babble, Grasp, Poke, Stroke, Tap
from tactile_maps.stimuli.stimulus_player import StimulusPlayer
from tactile_maps.tactile.poke import PokeMoved, PokePressed, PokeReleased
from tests.support.touch import arm, bar_skin

TICK = 0.005


def kinds(player, count) -> list[list[type]]:
    return [[type(act) for act in player.inputs(tick)] for tick in range(count)]


def presses(player, rounds=1) -> list[tuple[int, PokePressed]]:
    return [
        (tick, act)
        for tick in range(rounds * player.ticks)
        for act in player.inputs(tick)
        if isinstance(act, PokePressed)
    ]


def test_stroke_presses_moves_and_lifts_within_its_time():
    stroke = Stroke(start=(0.05, 0.0, 0.02), end=(0.15, 0.0, 0.02), hold=0.1, rest=0.2, speed=0.1, force=2.5)
    player = StimulusPlayer(bar_skin(), [stroke], tick=TICK)
    assert player.ticks == (0.1 + 1.0 + 0.2) / TICK
    acts = {tick: player.inputs(tick) for tick in range(2 * player.ticks)}
    assert isinstance(acts[0][0], PokePressed)
    assert acts[0][0].finger.max_force == 2.5
    assert not any(acts[tick] for tick in range(1, 21)), "pressed in before it moves"
    for tick in range(21, 220):
        (move,) = acts[tick]
        assert isinstance(move, PokeMoved)
        assert np.allclose(bar_skin().position(move.at), [0.05 + 0.1 * (tick - 20) * TICK, 0, 0.02], atol=1e-9)
    assert [type(act) for act in acts[220]] == [PokeMoved, PokeReleased]
    assert not any(acts[tick] for tick in range(221, 260))
    assert all(acts[tick] == acts[tick + 260] for tick in range(260)), "and again"
    once = StimulusPlayer(bar_skin(), [stroke], tick=TICK, repeat=False)
    assert all(once.inputs(tick) == acts[tick] for tick in range(260))
    assert not any(once.inputs(tick) for tick in range(260, 520))


def test_stimuli_with_a_time_play_together_each_with_its_finger():
    script = [
        Poke(hold=0.5, rest=0.1),
        Poke(begin=0.2, hold=0.1, rest=0.0),
        Poke(begin=0.25, hold=0.1, rest=0.0),
        Poke(begin=0.4, hold=0.05),
        Poke(hold=0.02),
    ]
    player = StimulusPlayer(bar_skin(), script, tick=TICK)
    assert [(tick * TICK, act.id) for tick, act in presses(player)] == [
        (0.0, 0),
        (0.2, -1),
        (0.25, -2),
        (0.4, -1),
        (pytest.approx(0.4 + 0.05 + 0.6), 0),
    ]
    assert player.fingers == (0, -1, -2)


def test_repeated_stimulus_starts_again_after_its_period():
    player = StimulusPlayer(bar_skin(), [Poke(hold=0.05, rest=0.05, repeat=3), Tap(taps=2)], tick=TICK)
    assert [tick for tick, _ in presses(player)] == [0, 20, 40, 60, 100]


@pytest.mark.long
def test_inputs_depend_only_on_the_tick():
    script = [Babble(touches=6, way="multi-touch"), Stroke(patch="hand", begin=0.3)]
    one, other = (StimulusPlayer(arm().skin, script, tick=TICK) for _ in range(2))
    forward = [one.inputs(tick) for tick in range(one.ticks)]
    shuffled = np.random.default_rng(0).permutation(one.ticks)
    assert all(other.inputs(int(tick)) == forward[tick] for tick in shuffled)
    assert any(forward)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("tick", [0.0005, 0.005, 0.03])
def test_every_press_is_released_and_no_finger_has_two_places(tick):
    script = [
        Babble(touches=5, way="self-touch"),
        Tap(begin=0.1),
        Grasp(patch="forearm", begin=0.2, hold=5.0),
        Stroke(patch="hand", rest=0.0, hold=0.0),
    ]
    player = StimulusPlayer(arm().skin, script, tick=tick)
    down = set()
    for number in range(2 * player.ticks):
        for act in player.inputs(number):
            if isinstance(act, PokePressed):
                assert act.id not in down
                down.add(act.id)
            else:
                assert act.id in down
            if isinstance(act, PokeReleased):
                down.remove(act.id)
        if (number + 1) % player.ticks == 0:
            assert not down


def test_empty_script_gives_no_inputs():
    player = StimulusPlayer(bar_skin(), [], tick=TICK)
    assert (player.inputs(123), player.ticks, player.fingers) == ([], 0, ())


def test_unknown_patch_is_named_with_the_known_ones():
    with pytest.raises(SceneError, match=r"wing.*top"):
        StimulusPlayer(bar_skin(), [Stroke(patch="wing")], tick=TICK)
