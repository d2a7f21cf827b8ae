"""Ranges of all stimuli, and the place of a finger on its track at any time."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SceneError
from tactile_maps.stimuli.stimulus import FingerTrack
from tactile_maps.stimuli.stimulus_file import STIMULUS_KINDS
from tactile_maps.tactile.poke import Finger

LINE = FingerTrack(
    0, Finger(), np.array([0.0, 1.0, 3.0]), np.zeros(3, int), np.array([[0, 0, 0], [1.0, 0, 0], [1, 4, 0]])
)


@pytest.mark.parametrize(
    ("seconds", "point"),
    [
        (-1, (0, 0, 0)),
        (0, (0, 0, 0)),
        (0.25, (0.25, 0, 0)),
        (1, (1, 0, 0)),
        (2, (1, 2, 0)),
        (3, (1, 4, 0)),
        (9, (1, 4, 0)),
    ],
)
def test_path_is_straight_between_points_and_constant_before_and_after(seconds, point):
    patch, found = LINE.at(seconds)
    assert patch == 0
    assert np.allclose(found, point)


USUAL = {"path": {"points": ((0.0, 0.1, 0.0, 0.02), (1.0, 0.2, 0.0, 0.02))}}


@pytest.fixture(params=STIMULUS_KINDS)
def kind(request):
    return lambda **values: STIMULUS_KINDS[request.param](**{**USUAL.get(request.param, {}), **values})


def test_finger_keeps_the_stated_values(kind):
    tip = kind(force=2.5, press=0.02, radius=0.01, stiffness=500.0).tip
    assert tip == Finger(stiffness=500.0, radius=0.01, max_force=2.5, speed=0.02)


@pytest.mark.parametrize(
    "bad",
    [
        {"force": -1.0},
        {"force": float("nan")},
        {"press": 2.0},
        {"radius": 0.0},
        {"stiffness": 0.0},
        {"rest": float("inf")},
        {"begin": -1.0},
        {"repeat": 0},
    ],
)
def test_invalid_setting_is_rejected_by_name(kind, bad):
    with pytest.raises(SceneError, match=rf"{kind().kind}\.{next(iter(bad))}.*Choose"):
        kind(**bad)


@pytest.mark.parametrize(
    ("name", "bad"),
    [
        ("poke", {"at": (0.5,)}),
        ("poke", {"at": (0.5, 1.5)}),
        ("tap", {"at": (0.1, 0.2, float("nan"))}),
        ("stroke", {"start": (2.0, 0.0)}),
        ("stroke", {"end": (0.0, -1.0)}),
        ("stroke", {"speed": 0.0}),
        ("stroke", {"hold": float("nan")}),
        ("roll", {"at": ()}),
        ("grasp", {"at": (0.0, 0.0, 1e9)}),
        ("tap", {"taps": 0}),
        ("roll", {"angle": 181.0}),
        ("grasp", {"fingers": 1}),
        ("babble", {"touches": 0}),
        ("babble", {"way": "wild"}),
        ("path", {"points": ((0.0, 0, 0, 0),)}),
        ("path", {"points": ((0.0, 0, 0, 0), (0.0, 1, 0, 0))}),
        ("path", {"points": ((1.0, 0, 0, 0), (2.0, 1, 0, 0))}),
        ("path", {"points": ((0.0, 0, 0, 0), (1.0, 1, float("nan"), 0))}),
        ("path", {"patches": ("a",)}),
    ],
)
def test_every_kind_rejects_its_invalid_values(name, bad):
    with pytest.raises(SceneError, match=rf"{name}\.{next(iter(bad))}"):
        STIMULUS_KINDS[name](**{**USUAL.get(name, {}), **bad})
