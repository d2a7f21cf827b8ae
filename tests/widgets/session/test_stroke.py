"""A stroke at a hand's speed while few frames are drawn: one contact from its begin to its end, where the hand was."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.session.session import Session
from tactile_maps.stimuli.skin_locations import SkinLocator
from tactile_maps.tactile.poke import PokeMoved, PokePressed, PokeReleased
from tactile_widgets.session.session_runner import InlineRunner
from tactile_widgets.session.stroke import LEAP, LONGEST, StrokePlan

SPEED = 0.110
FRAME = 0.1
"""A stroke as people make them [m/s], and a slow window's frame [s]."""


@pytest.fixture(scope="module")
def line(coarse_prepared):
    """(k, 3) a way of 66 mm along a patch, and its number."""
    skin = coarse_prepared.skin
    for patch in range(len(skin.patches)):
        locator = SkinLocator(skin)
        ends = locator.point(patch, (0.2, 0.5)), locator.point(patch, (0.8, 0.5))
        way = locator.straight_path(patch, *ends)
        if np.linalg.norm(np.diff(way, axis=0), axis=1).max() < LEAP and len(way) > 66:
            return patch, way[:67]
    raise AssertionError("no patch is long enough")


def places(prepared, line):
    """Return the positions of the mouse, one per frame."""
    patch, way = line
    locator = SkinLocator(prepared.skin)
    return [locator.surface_point(patch, point) for point in way[:: round(SPEED * FRAME / 0.001)]]


@pytest.mark.long
def test_fast_stroke_in_a_slow_window_is_one_continuous_contact(coarse_prepared, line):
    stops = places(coarse_prepared, line)
    skin = coarse_prepared.skin
    frames = []
    assert len(stops) >= 6
    runner = InlineRunner(Session(coarse_prepared, scripted=False), frames.append)
    runner.submit(PokePressed(1, stops[0]))
    runner.run_for(0.5)
    for at in stops[1:]:
        runner.submit(PokeMoved(1, at))
        runner.run_for(FRAME)
    runner.submit(PokeReleased(1))
    (poke,) = frames[-1].pokes
    assert poke.at == stops[-1]
    runner.run_for(LONGEST + 0.1)
    assert not frames[-1].pokes
    went = [act.at for _, act in runner.session.inputs if isinstance(act, PokePressed | PokeMoved)]
    steps = np.linalg.norm(np.diff([skin.position(at) for at in went], axis=0), axis=1)
    assert steps.max() <= 1.5 * LEAP, "of a hand that was 11 mm farther on at each event"
    assert {region.id for frame in frames for region in frame.regions} == {1}


def plan(prepared, at):
    made = StrokePlan(prepared.skin, 0.005)
    assert made.take(PokePressed(1, at), 0) == (PokePressed(1, at),)
    return made


def test_large_move_is_spread_over_its_time_and_ends_at_the_pointer(coarse_prepared, line):
    stops = places(coarse_prepared, line)
    skin = coarse_prepared.skin
    strokes = plan(coarse_prepared, stops[0])
    assert strokes.take(PokeMoved(1, stops[1]), 10) == ()
    assert strokes.take(PokeReleased(1), 10) == (), "the lift waits for the end of the way"
    acts = [strokes.due(tick) for tick in range(10, 25)]
    moves = [act.at for now in acts for act in now if isinstance(act, PokeMoved)]
    assert moves[-1] == stops[1]
    steps = np.diff([skin.position(at) for at in (stops[0], *moves)], axis=0)
    assert np.linalg.norm(steps, axis=1).max() <= 1.5 * LEAP
    assert sum(isinstance(act, PokeReleased) for now in acts[:10] for act in now) == 1
    assert acts[10:] == [[]] * 5, "in as many ticks as the hand took"


def test_short_moves_and_moves_to_other_patches_are_applied_at_once(coarse_prepared, line):
    stops = places(coarse_prepared, line)
    skin = coarse_prepared.skin
    near = SkinLocator(skin).surface_point(line[0], line[1][1])
    strokes = plan(coarse_prepared, stops[0])
    assert strokes.take(PokeMoved(1, near), 50) == (PokeMoved(1, near),)
    other = skin.taxel_point(next(t for t in range(len(skin)) if skin.patch_of[t] != line[0]))
    assert strokes.take(PokeMoved(1, other), 90) == (PokeMoved(1, other),)
    assert strokes.take(PokeReleased(1), 91) == (PokeReleased(1),)
    assert strokes.take(PokeMoved(1, near), 92) == (PokeMoved(1, near),), "of a finger that is up: the session's"
