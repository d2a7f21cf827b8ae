"""What every stimulus refuses, and where a track has its finger at any time."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SceneError
from tactile_maps.stimuli.stimulus import FingerTrack, stationary_track
from tactile_maps.stimuli.stimulus_file import STIMULUS_KINDS
from tactile_maps.tactile.poke import Finger

LINE = FingerTrack(
    0, Finger(), np.array([0.0, 1.0, 3.0]), np.zeros(3, int), np.array([[0, 0, 0], [1.0, 0, 0], [1, 4, 0]])
)


@pytest.mark.parametrize(("seconds", "point"), [
    (-1, (0, 0, 0)), (0, (0, 0, 0)), (0.25, (0.25, 0, 0)), (1, (1, 0, 0)), (2, (1, 2, 0)), (3, (1, 4, 0)),
    (9, (1, 4, 0)),
])  # fmt: skip
def test_straight_between_points_and_still_outside(seconds, point):
    patch, found = LINE.at(seconds)
    assert patch == 0
    assert np.allclose(found, point)


def test_it_steps_over_to_another_patch_without_a_way_between():
    track = FingerTrack(0, Finger(), np.array([0.0, 1.0, 2.0]), np.array([0, 1, 1]), np.eye(3))
    assert track.at(0.99)[0] == 0
    assert np.array_equal(track.at(0.99)[1], [1, 0, 0])
    assert track.at(1.0)[0] == 1
    assert np.allclose(track.at(1.5)[1], [0, 0.5, 0.5])


def test_points_at_the_same_time_take_the_last():
    track = FingerTrack(0, Finger(), np.array([0.0, 1.0, 1.0]), np.zeros(3, int), np.eye(3))
    assert np.array_equal(track.at(1.0)[1], [0, 0, 1])


def test_a_still_finger_is_still_and_its_arrays_are_frozen():
    track = stationary_track(2, Finger(), 1, np.ones(3), press=0.5, lift=2.0)
    assert track.finger == 2
    assert all(np.array_equal(track.at(t)[1], np.ones(3)) and track.at(t)[0] == 1 for t in (0, 0.5, 1.7, 3))
    assert not track.points.flags.writeable


USUAL = {"path": {"points": ((0.0, 0.1, 0.0, 0.02), (1.0, 0.2, 0.0, 0.02))}}


@pytest.fixture(params=STIMULUS_KINDS)
def kind(request):
    return lambda **values: STIMULUS_KINDS[request.param](**{**USUAL.get(request.param, {}), **values})


def test_the_finger_is_as_said(kind):
    tip = kind(force=2.5, press=0.02, radius=0.01, stiffness=500.0).tip
    assert tip == Finger(stiffness=500.0, radius=0.01, max_force=2.5, speed=0.02)


@pytest.mark.parametrize("bad", [{"force": -1.0}, {"force": float("nan")}, {"press": 2.0},
                                 {"radius": 0.0}, {"stiffness": 0.0}, {"rest": float("inf")}, {"begin": -1.0},
                                 {"repeat": 0}])  # fmt: skip
def test_what_cannot_be_is_refused_by_name(kind, bad):
    with pytest.raises(SceneError, match=rf"{kind().kind}\.{next(iter(bad))}.*Choose"):
        kind(**bad)


@pytest.mark.parametrize(("name", "bad"), [
    ("poke", {"at": (0.5,)}), ("poke", {"at": (0.5, 1.5)}), ("tap", {"at": (0.1, 0.2, float("nan"))}),
    ("stroke", {"start": (2.0, 0.0)}), ("stroke", {"end": (0.0, -1.0)}), ("stroke", {"speed": 0.0}),
    ("stroke", {"hold": float("nan")}), ("roll", {"at": ()}), ("grasp", {"at": (0.0, 0.0, 1e9)}),
    ("tap", {"taps": 0}), ("roll", {"angle": 181.0}), ("grasp", {"fingers": 1}), ("babble", {"touches": 0}),
    ("babble", {"way": "wild"}), ("path", {"points": ((0.0, 0, 0, 0),)}),
    ("path", {"points": ((0.0, 0, 0, 0), (0.0, 1, 0, 0))}), ("path", {"points": ((1.0, 0, 0, 0), (2.0, 1, 0, 0))}),
    ("path", {"points": ((0.0, 0, 0, 0), (1.0, 1, float("nan"), 0))}), ("path", {"patches": ("a",)}),
])  # fmt: skip
def test_each_kind_refuses_its_own(name, bad):
    with pytest.raises(SceneError, match=rf"{name}\.{next(iter(bad))}"):
        STIMULUS_KINDS[name](**{**USUAL.get(name, {}), **bad})
