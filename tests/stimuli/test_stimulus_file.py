"""Scripts as TOML: what they say is what one gets, and a mistake is named with its line."""

from __future__ import annotations

import pytest

from tactile_maps.core.errors import SceneError
from tactile_maps.stimuli.stimulus_file import (
    STIMULUS_KINDS,
    load_stimuli,
    save_stimuli,
    stimuli_from_toml,
    stimuli_to_toml,
    stimulus_to_table,
)
from tactile_maps.stimuli.stimulus_kinds import Babble, FingerPath, Grasp, Poke, Roll, Stroke, Tap

ALL = (
    Poke(),
    Poke(patch='an "odd"\tname \\ \x7f µ', at=(0.1, -0.02, 3e-05), force=2.5, begin=0.0, repeat=3),
    Stroke(start=(0.0, 1.0), end=(0.1, 0.2, 0.3), speed=0.1, stay=1.0),
    Tap(taps=2), Roll(heading=-45.0), Grasp(fingers=4), Babble(way="self-touch", seed=7),
    FingerPath(points=((0.0, 0.1, 0.2, 0.3), (1.5, 0.1, 0.2, 0.25)), patches=("a", "b")),
)  # fmt: skip


def test_every_kind_is_written_and_read_back(tmp_path):
    assert {stimulus.kind for stimulus in ALL} == set(STIMULUS_KINDS)
    save_stimuli(ALL, tmp_path / "script.toml")
    assert load_stimuli(tmp_path / "script.toml") == ALL


def test_only_values_that_differ_from_defaults_are_written():
    assert stimuli_to_toml([Poke()]) == '[[stimuli]]\nkind = "poke"\n'
    assert stimulus_to_table(Tap(at=(0.1, 0.2), taps=2, press=0.1)) == {"kind": "tap", "at": (0.1, 0.2), "taps": 2}
    assert "points = [\n  [0.0, 0.1, 0.2, 0.3],\n" in stimuli_to_toml(ALL), "a long way is one point a line"
    assert stimuli_to_toml([]) == ""


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("kind = ", r"not valid TOML"),
        ("robot = 'arm'", r"line 1, robot.*unknown key in a stimulus file.*\[\[stimuli\]\]"),
        ("stimuli = 5", r"must be tables.*\[\[stimuli\]\]"),
        ("[[stimuli]]\npatch = 'x'", r"stimuli\.kind: the kind of the stimulus is missing.*poke, stroke"),
        ("[[stimuli]]\nkind = 3", r"unknown kind of stimulus"),
        ("[[stimuli]]\nkind = 'storke'", r"line 2, stimuli\.kind.*storke.*Did you mean stroke\?"),
        (
            "[[stimuli]]\nkind = 'poke'\n[[stimuli]]\nkind = 'poke'\nholt = 1",
            r"line 5, stimuli\.holt.*Did you mean hold\?",
        ),
        ("[[stimuli]]\nkind = 'poke'\nat = [0.1]", r"line 3, stimuli\.at.*\[along, around\]"),
        ("[[stimuli]]\nkind = 'poke'\nat = ['a', 1]", r"line 3, stimuli\.at.*number"),
        ("[[stimuli]]\nkind = 'poke'\nforce = '3 N'", r"line 3, stimuli\.force.*write 3"),
        ("[[stimuli]]\nkind = 'roll'\nangle = '30 deg'", r"line 3, stimuli\.angle.*degrees here: write 30"),
        ("[[stimuli]]\nkind = 'poke'\nhold = true", r"line 3, stimuli\.hold.*number"),
        ("[[stimuli]]\nkind = 'poke'\nforce = 1000", r"line 3, stimuli\.force.*1000.*0 to 100"),
        ("[[stimuli]]\nkind = 'tap'\ntaps = 2.5", r"line 3, stimuli\.taps.*whole"),
        ("[[stimuli]]\nkind = 'babble'\nway = 'wild'", r"line 3, stimuli\.way.*wild.*unbiased"),
        ("[[stimuli]]\nkind = 'poke'\nradius = 8", r"line 3, stimuli\.radius.*Choose 0\.0001 to 0\.1 metres"),
        ("[[stimuli]]\nkind = 'path'", r"missing.*points"),
        ("[[stimuli]]\nkind = 'path'\npoints = [[0, 1, 2]]", r"line 3, stimuli\.points.*4"),
    ],
)
def test_invalid_entry_is_reported_with_its_place(text, words):
    with pytest.raises(SceneError, match=rf"(?s)my file.*{words}") as caught:
        stimuli_from_toml(text, file="my file")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("content", [None, b"\xff\xfe", b"#" * 10_000_001])
def test_unreadable_file_is_rejected(tmp_path, content):
    path = tmp_path / "bad.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(SceneError, match="bad.toml"):
        load_stimuli(path)
