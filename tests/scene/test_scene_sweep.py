"""Sweep files: what they vary and how, and every mistake named with its place."""

from __future__ import annotations

import pytest

from tactile_maps.core.errors import SceneError
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.scene.scene_sweep import load_sweep, varied_scene


@pytest.fixture
def read(tmp_path):
    def sweep(text):
        path = tmp_path / "sweep.toml"
        path.write_text(text)
        return load_sweep(path)

    return sweep


def test_sweep_without_draws_is_every_combination_in_order(read):
    sweep = read(
        'seconds = 2\n[vary]\nseed = { from = 3, count = 2 }\ncontrol.controller = ["qp", "hybrid"]\ntick = 0.005\n'
        "layer.stiffness = { from = 1e4, to = 1e6, steps = 3, log = true }\n"
    )
    assert (sweep.seconds, len(sweep.variants)) == (2.0, 12)
    assert sweep.variants[0] == {"seed": 3, "control.controller": "qp", "tick": 0.005, "layer.stiffness": 1e4}
    assert [one["layer.stiffness"] for one in sweep.variants[:3]] == pytest.approx([1e4, 1e5, 1e6])
    assert sweep.variants[2]["layer.stiffness"] == 1e6
    assert sweep.variants[-1]["seed"] == 4


def test_draws_are_in_range_and_depend_only_on_number_key_and_seed(read):
    vary = "[vary]\nstimuli.0.at = { from = [0.2, 0.0], to = [0.4, 1.0] }\ntick = [0.005, 0.01]\n"
    few = read(f"draws = 3\n{vary}")
    many = read(f"draws = 200\n{vary}seed = {{ from = 0, count = 9 }}\n")
    for one, other in zip(few.variants, many.variants, strict=False):
        assert one == {key: other[key] for key in one}
    along = [one["stimuli.0.at"][0] for one in many.variants]
    assert 0.2 <= min(along) < 0.21
    assert 0.39 < max(along) <= 0.4
    assert {one["tick"] for one in many.variants} == {0.005, 0.01}
    assert read(f"draws = 3\nseed = 1\n{vary}").variants != few.variants


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("drawn = 3", "drawn: unknown key"),
        ("seconds = 0.0", "line 1, seconds: the time is out of range"),
        ("draws = 0", "line 1, draws: the number of scenes is out of range"),
        ("seed = -1", "a seed cannot be negative"),
        ("[vary]\nseed = []", "line 2, vary.seed: the list is empty"),
        ("[vary]\ntick = { from = 1.0, to = 2.0 }", "line 2, vary.tick: the range has no number of steps"),
        ("[vary]\nlayer.depth = { from = 1.0 }", "line 2, vary.layer.depth: invalid range"),
        ("[vary]\ntick = { from = 1.0, to = [2.0], steps = 2 }", "invalid range"),
        ("[vary]\ntick = { from = 0.0, to = 2.0, steps = 2, log = true }", "must be above 0"),
        (
            "[vary]\nseed = { from = 0, count = 1000 }\nx = { from = 0, count = 1001 }",
            "number of scenes is out of range",
        ),
    ],
)
def test_invalid_entry_is_reported_with_its_place(read, text, words):
    with pytest.raises(SceneError, match=words):
        read(text)


def test_settings_replace_those_of_the_scene():
    scene = load_scene("poke")
    settings = {"stimuli.0.force": 2.5, "effects.noise.sd": 30.0, "control.controller": "qp", "seed": 7}
    varied = varied_scene(scene, settings, file="s.toml")
    assert (varied.stimuli[0].force, varied.seed, varied.control["controller"]) == (2.5, 7, "qp")
    assert varied.effects.sensor.noise.sd == 30.0
    assert varied_scene(scene, {}, file="s.toml") == scene


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("stimuli.4.force", 1.0, r"s.toml, vary.stimuli.4.force: unknown setting.*This scene has 1 of them"),
        ("stimuli.0.force", 1e9, r"s.toml, vary.stimuli.*force: a setting of the poke is out of range"),
        ("robot.name", "arm", "It has no parts"),
        ("taxels", 3, "vary.taxels: there is no such key"),
    ],
)
def test_invalid_setting_is_named(key, value, words):
    with pytest.raises(SceneError, match=words):
        varied_scene(load_scene("poke"), {key: value}, file="s.toml")


@pytest.mark.long
def test_shipped_sweep_fits_its_scene():
    sweep = load_sweep("pokes")
    scene = load_scene("poke")
    for settings in sweep.variants[:20]:
        varied_scene(scene, settings, file=sweep.file)
