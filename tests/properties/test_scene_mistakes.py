"""Whatever a person writes into a scene file, it is a scene or a SceneError: nothing else ever comes out."""

from __future__ import annotations

import re

from hypothesis import given, settings
from hypothesis import strategies as st

from app.errors import SceneError
from app.scene.scene import Scene
from app.scene.scene_text import scene_from_toml, scene_to_toml

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
law = "impedance"
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
ODD = ("nan", "-inf", "-1", "0", "1e400", "1" + "0" * 400, "1" + "0" * 5000, '"5 mm"', '""', "[]", "{}", "true",
       "[[1]]",
       '["x"]', "2026-01-01", "[nan, 1]", "{ sd = nan }", '"auto"', "{ a = { b = 1 } }", "[1, 2, 3]", "'''\n\n'''", "=",
       "[", '"\\u0000"', '"on"')  # fmt: skip
LINES = TEXT.splitlines()


@settings(max_examples=400, deadline=None)
@given(st.integers(0, len(LINES) - 1), st.sampled_from(ODD), st.sampled_from(["value", "key", "gone", "twice"]))
def test_one_odd_line(number, odd, what):
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


@settings(max_examples=200, deadline=None)
@given(st.text(max_size=200))
def test_any_text(text):
    check(text)


@settings(max_examples=200, deadline=None)
@given(st.integers(0, len(TEXT)), st.integers(0, 20), st.text('[]{}"=.#\n', max_size=5))
def test_a_bite_out_of_it(start, length, instead):
    check(TEXT[:start] + instead + TEXT[start + length :])


def test_the_whole_is_a_scene():
    assert isinstance(scene_from_toml(TEXT, name="s"), Scene)


def check(text: str) -> None:
    told = ""
    try:
        scene = scene_from_toml(text, name="s", file="f")
    except SceneError as error:
        told = str(error)
    if told:
        assert told.startswith("f")
        assert "\n" not in told
    else:
        assert scene_from_toml(scene_to_toml(scene), name="s") == scene
