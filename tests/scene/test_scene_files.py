"""Whatever a person writes into a scene or a script, it is one or a named error; and scripts survive being written and
played.
"""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tactile_maps.core.errors import SceneError
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_file import scene_from_toml, scene_to_toml
from tactile_maps.stimuli.skin_locations import SkinLocator
from tactile_maps.stimuli.stimuli_from_pokes import TOLERANCE, stimuli_from_pokes
from tactile_maps.stimuli.stimulus_file import stimuli_from_toml, stimuli_to_toml
from tactile_maps.stimuli.stimulus_kinds import Babble, FingerPath, Grasp, Poke, Roll, Stroke, Tap
from tactile_maps.stimuli.stimulus_player import StimulusPlayer
from tactile_maps.tactile.babbling import KINDS as WAYS
from tactile_maps.tactile.poke import PokePressed, PokeReleased
from tests.support.examples import examples
from tests.support.touch import arm

TEXT = """title = "x"
robot = "arm"
task = "slide"
outputs = ["readings", "force"]
tick = 0.005
seed = 1
[cover]
links = ["hand"]
taxels = 40
thickness = 0.003
[layer]
stiffness = 20000
poisson = 0.2
[effects]
gravity = "on"
friction = true
timestep = 0.001
noise = { sd = 50 }
[control]
controller = "impedance"
stiffness = 8.0
[[objects]]
name = "wall"
kind = "box"
size = [0.1, 0.1, 0.1]
at = [2, 0, 0]
mass = 1
[[objects]]
name = "probe"
kind = "probe"
size = [0.01]
path = [[0, 0, 0, 0], [1, 0, 0, 1]]
[[motion]]
posture = { elbow_pitch = 1 }
unit = "deg"
seconds = 2
[[motion]]
posture = [1, 2]
[[stimuli]]
kind = "stroke"
start = [0.1, 0.2]
force = 3
"""
ODD = (
    "nan",
    "-inf",
    "-1",
    "0",
    "1e400",
    "1" + "0" * 400,
    "1" + "0" * 5000,
    '"5 mm"',
    '""',
    "[]",
    "{}",
    "true",
    "[[1]]",
    '["x"]',
    "2026-01-01",
    "[nan, 1]",
    "{ sd = nan }",
    '"auto"',
    "{ a = { b = 1 } }",
    "[1, 2, 3]",
    "'''\n\n'''",
    "=",
    "[",
    '"\\u0000"',
    '"on"',
)
LINES = TEXT.splitlines()


@pytest.mark.long
@examples(400)
@given(st.integers(0, len(LINES) - 1), st.sampled_from(ODD), st.sampled_from(["value", "key", "gone", "twice"]))
def test_scene_with_one_odd_line_is_read_or_rejected(number, odd, what):
    line = LINES[number]
    key = re.match(r"\w+", line)
    if what == "value" and key:
        line = f"{key[0]} = {odd}"
    elif what == "key" and key:
        line = line.replace(key[0], f"{key[0][::-1]}", 1)
    elif what == "twice":
        line = f"{line}\n{line}"
    text = "\n".join([*LINES[:number], *([line] if what != "gone" else []), *LINES[number + 1 :]])
    check(text)


@pytest.mark.long
@examples(200)
@given(st.text(max_size=200))
def test_any_text_is_read_or_rejected(text):
    check(text)


@pytest.mark.long
@examples(200)
@given(st.integers(0, len(TEXT)), st.integers(0, 20), st.text('[]{}"=.#\n', max_size=5))
def test_scene_with_a_part_removed_is_read_or_rejected(start, length, instead):
    check(TEXT[:start] + instead + TEXT[start + length :])


def test_unchanged_text_is_read_as_a_scene():
    assert isinstance(scene_from_toml(TEXT, name="s"), Scene)


def check(text: str) -> None:
    message = ""
    try:
        scene = scene_from_toml(text, name="s", file="f")
    except SceneError as error:
        message = str(error)
    if message:
        assert message.startswith("f")
        assert "\n" not in message
    else:
        assert scene_from_toml(scene_to_toml(scene), name="s") == scene


TICK = 0.005


@cache
def locator() -> SkinLocator:
    return SkinLocator(arm().skin)


def numbers(low, high):
    return st.floats(low, high, allow_nan=False)


shares = st.tuples(numbers(0, 1), numbers(0, 1))
coordinates = st.tuples(*[numbers(-100, 100)] * 3)
anywhere = st.one_of(shares, coordinates)
common = {
    "patch": st.text(max_size=8),
    "force": numbers(0, 100),
    "press": numbers(0, 1),
    "radius": numbers(1e-4, 0.1),
    "stiffness": numbers(1e-3, 1e6),
    "rest": numbers(0, 3600),
    "begin": st.none() | numbers(0, 1e6),
    "repeat": st.integers(1, 1000),
}
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
    st.builds(FingerPath, **common, points=points),
)


@pytest.mark.long
@given(script=st.lists(stimuli, max_size=6))
@examples(60)
def test_stimuli_are_written_and_read(script):
    assert stimuli_from_toml(stimuli_to_toml(script), file="script") == tuple(script)


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
    return stimuli_from_pokes(arm().skin, play(script), tick=TICK, scripted=True)


@given(taxel=taxels, hold=ticks, tip=st.fixed_dictionaries(tips))
@examples(40)
def test_poke_is_recovered_from_its_inputs(taxel, hold, tip):
    patch, place = exact(taxel)
    poke = Poke(patch=arm().skin.patches[patch].name, at=place, hold=hold, begin=0.0, **tip)
    (again,) = recorded([poke])
    assert (again.kind, again.patch, again.tip, again.begin) == ("poke", poke.patch, poke.tip, 0.0)
    assert abs(again.hold - hold) < 1e-9
    assert np.linalg.norm(np.subtract(again.at, poke.at)) < 3e-5, "but for the rounding of what is written"


@pytest.mark.long
@given(ends=st.tuples(taxels, taxels), hold=ticks, speed=numbers(0.02, 0.3), tip=st.fixed_dictionaries(tips))
@examples(40)
def test_stroke_is_recovered_from_its_inputs(ends, hold, speed, tip):
    (patch, start), (other, end) = map(exact, ends)
    assume(patch == other and np.linalg.norm(np.subtract(start, end)) > 0.005)
    stroke = Stroke(patch=arm().skin.patches[patch].name, start=start, end=end, hold=hold, speed=speed, **tip)
    (again,) = recorded([stroke])
    assert again.tip == stroke.tip
    assert_same_way(play([stroke]), play([again]))
    if again.kind == "stroke":
        assert abs(again.speed - speed) < 0.15 * speed
        assert abs(again.hold - hold) < 0.05 + 2 * TICK


@pytest.mark.long
@given(seed=st.integers(0, 1000), way=st.sampled_from(WAYS), taxel=taxels)
@examples(15)
def test_any_script_is_recovered_from_its_inputs(seed, way, taxel):
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
    down = {}
    done = []
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
    for (press, scripted, lift), (again, played, lift_again) in zip(ways(before), ways(after), strict=True):
        assert (press, lift) == (again, lift_again)
        for tick, (patch, place) in scripted.items():
            there, found = played[max(known for known in played if known <= tick)]
            assert patch == there
            assert np.linalg.norm(found - place) < 2 * TOLERANCE, "within 1 mm"
