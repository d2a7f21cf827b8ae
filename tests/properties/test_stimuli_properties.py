"""Scripts survive being written and being played: whatever a stimulus says, its text and its inputs say as well."""

from __future__ import annotations

from functools import cache

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from app.stimuli.babble import Babble
from app.stimuli.from_hand import NEAR, from_hand
from app.stimuli.grasp import Grasp
from app.stimuli.path import Path
from app.stimuli.place import Ground
from app.stimuli.player import StimulusPlayer
from app.stimuli.poke import Poke
from app.stimuli.roll import Roll
from app.stimuli.stimulus_file import stimuli_from_toml, to_toml
from app.stimuli.stroke import Stroke
from app.stimuli.tap import Tap
from app.touch.babbling import KINDS as WAYS
from app.touch.poke import PokeMoved, PokePressed, PokeReleased
from tests.touch import arm

TICK = 0.005


@cache
def ground() -> Ground:
    return Ground(arm().skin)


def numbers(low, high):
    return st.floats(low, high, allow_nan=False)


shares = st.tuples(numbers(0, 1), numbers(0, 1))
coordinates = st.tuples(*[numbers(-100, 100)] * 3)
anywhere = st.one_of(shares, coordinates)
common = {
    "patch": st.text(max_size=8), "force": numbers(0, 100), "press": numbers(0, 1), "radius": numbers(1e-4, 0.1),
    "stiffness": numbers(1e-3, 1e6), "rest": numbers(0, 3600), "begin": st.none() | numbers(0, 1e6),
    "repeat": st.integers(1, 1000),
}  # fmt: skip
points = st.lists(st.tuples(numbers(1e-3, 10), coordinates), min_size=1, max_size=6).map(
    lambda rows: (
        (0.0, 0.0, 0.0, 0.0),
        *((sum(row[0] for row in rows[: k + 1]), *rows[k][1]) for k in range(len(rows))),
    )
)
stimuli = st.one_of(
    st.builds(Poke, **common, at=anywhere, hold=numbers(0, 3600)),
    st.builds(Stroke, **common, start=anywhere, end=anywhere, speed=numbers(1e-3, 10), stay=numbers(0, 3600)),
    st.builds(Tap, **common, at=anywhere, taps=st.integers(1, 100), down=numbers(0.001, 1)),
    st.builds(Roll, **common, at=anywhere, heading=numbers(-360, 360), rolls=st.integers(1, 9)),
    st.builds(Grasp, **common, at=anywhere, fingers=st.integers(2, 20)),
    st.builds(Babble, **common, way=st.sampled_from(WAYS), seed=st.integers(0, 2**31), strokes=numbers(0, 1)),
    st.builds(Path, **common, points=points),
)  # fmt: skip


@given(script=st.lists(stimuli, max_size=6))
@settings(max_examples=60, deadline=None)
def test_text_says_what_the_stimuli_say(script):
    assert stimuli_from_toml(to_toml(script), file="script") == tuple(script)


taxels = st.integers(0, 299)
ticks = st.integers(2, 120).map(lambda n: n * TICK)
tips = {"force": numbers(0.1, 20), "press": numbers(0.001, 0.2), "radius": numbers(0.002, 0.02)}


def exact(taxel: int) -> tuple[int, tuple[float, float, float]]:
    """Patch and place of a taxel, as a script writes it."""
    at = arm().skin.taxel_point(taxel)
    return at.patch, tuple(round(float(value), 5) for value in arm().skin.position(at))


def play(script) -> list:
    player = StimulusPlayer(arm().skin, script, tick=TICK)
    return [(tick, act) for tick in range(player.ticks) for act in player.inputs(tick)]


def recorded(script) -> tuple:
    return from_hand(arm().skin, play(script), tick=TICK, scripted=True)


@given(taxel=taxels, hold=ticks, tip=st.fixed_dictionaries(tips))
@settings(max_examples=40, deadline=None)
def test_a_poke_played_and_recorded_is_the_same_poke(taxel, hold, tip):
    patch, place = exact(taxel)
    poke = Poke(patch=arm().skin.patches[patch].name, at=place, hold=hold, begin=0.0, **tip)
    (again,) = recorded([poke])
    assert (again.kind, again.patch, again.tip, again.begin) == ("poke", poke.patch, poke.tip, 0.0)
    assert abs(again.hold - hold) < 1e-9
    assert np.linalg.norm(np.subtract(again.at, poke.at)) < 3e-5, "but for the rounding of what is written"


@given(ends=st.tuples(taxels, taxels), hold=ticks, speed=numbers(0.02, 0.3), tip=st.fixed_dictionaries(tips))
@settings(max_examples=40, deadline=None)
def test_a_stroke_played_and_recorded_goes_the_same_way(ends, hold, speed, tip):
    (patch, start), (other, end) = map(exact, ends)
    assume(patch == other and np.linalg.norm(np.subtract(start, end)) > 0.005)
    stroke = Stroke(patch=arm().skin.patches[patch].name, start=start, end=end, hold=hold, speed=speed, **tip)
    (again,) = recorded([stroke])
    assert again.tip == stroke.tip
    assert_same_way(play([stroke]), play([again]))
    if again.kind == "stroke":
        assert abs(again.speed - speed) < 0.15 * speed
        assert abs(again.hold - hold) < 0.05 + 2 * TICK


@given(seed=st.integers(0, 1000), way=st.sampled_from(WAYS), taxel=taxels)
@settings(max_examples=15, deadline=None)
def test_whatever_plays_is_recorded_and_plays_again(seed, way, taxel):
    patch, place = exact(taxel)
    name = arm().skin.patches[patch].name
    script = [Babble(touches=4, way=way, seed=seed), Roll(patch=name, at=place, begin=0.5, rolls=1), Tap(patch=name)]
    before = play(script)
    after = play(recorded(script))
    for kind in (PokePressed, PokeReleased):
        assert [tick for tick, act in before if isinstance(act, kind)] == [
            tick for tick, act in after if isinstance(act, kind)
        ]
    assert_same_way(before, after)


def ways(acts) -> list[tuple[int, dict[int, tuple[int, np.ndarray]], int]]:
    """(press, {tick: (patch, place)}, lift) of every touch, by its press and place."""
    down, done = {}, []
    for tick, act in acts:
        if isinstance(act, PokeReleased):
            press, places = down.pop(act.id)
            done.append((press, places, tick))
        else:
            if isinstance(act, PokePressed):
                down[act.id] = tick, {}
            down[act.id][1][tick] = act.at.patch, arm().skin.position(act.at)
    assert not down
    return sorted(done, key=lambda touch: (touch[0], *touch[1][touch[0]][1].round(3)))


def assert_same_way(before, after) -> None:
    for (press, told, lift), (again, played, lift_again) in zip(ways(before), ways(after), strict=True):
        assert (press, lift) == (again, lift_again)
        for tick, (patch, place) in told.items():
            there, found = played[max(known for known in played if known <= tick)]
            assert patch == there
            assert np.linalg.norm(found - place) < 2 * NEAR, "within 1 mm"


def test_the_kinds_of_inputs_are_all_there():
    """The laws above are about presses, moves and lifts: the strokes that hypothesis draws have them all."""
    acts = play([Stroke(patch="forearm")])
    assert {type(act) for _, act in acts} == {PokePressed, PokeMoved, PokeReleased}
