"""Every input can be recorded."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.behaviours import Behaviour
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import RecordingError
from tactile_maps.recording.encoding.message_codecs import decode_input, encode_input
from tactile_maps.scene.effects import Effects
from tactile_maps.session.inputs import (
    BehavioursChanged,
    CalibrationUsed,
    ControlChanged,
    EffectsChanged,
    MapEdited,
    PosturePlaced,
    ReadingChanged,
    RestChanged,
    SessionInput,
)
from tactile_maps.studies.testbeds.reference_bodies import flat_map
from tactile_maps.tactile.poke import PokeMoved, PokePressed, PokePulled, PokeReleased


def test_every_input_can_be_recorded():
    map_ = flat_map(30)
    at = map_.skin.taxel_point(3)
    edit = MapEdited("Move", map_)
    acts = [PokePressed(1, at), PokeMoved(1, at), PokePulled(1, at), PokeReleased(1), ControlChanged(ControlSettings())]
    then = {"task": "retreat", "force_goal": 0.1, "starts": 3, "path": ((0.0, 0.1), (0.2, 0.3))}
    behaviour = Behaviour("tap", "bar", 2, 1 / 3, then=then)
    acts += [BehavioursChanged((behaviour,)), EffectsChanged(Effects(gravity="on"))]
    acts += [ReadingChanged(ReadingSettings("tikhonov", threshold=2e3)), RestChanged((0.1, 1 / 3), 0.6)]
    acts += [PosturePlaced((0.1, 1 / 3)), edit]
    level = np.full(len(map_.skin), 1 / 3)
    acts.append(CalibrationUsed(level, 2 * level, 0 * level, None, True, "baseline"))
    assert {type(act) for act in acts} == set(get_args(SessionInput))
    back = [decode_input(encode_input(5, act, map_), map_) for act in acts]
    assert back[:-2] == [(5, act) for act in acts[:-2]]
    (tick, moved), (_, used) = back[-2:]
    assert (tick, moved.name, moved.map.layout) == (5, "Move", map_.layout)
    assert (used.known, used.mode, used.spread) == (True, "baseline", None)
    for name in ("gain", "offset", "baseline"):
        np.testing.assert_array_equal(getattr(used, name), getattr(acts[-1], name))


@pytest.mark.parametrize(
    ("broken", "stuck", "problem"),
    [([2, 5], [5], None), ([2, 5], [6], "a stuck taxel is not among"), ([2, 10_000], [], "invalid number of a broken")],
)
def test_stuck_taxels_are_among_the_broken_ones(broken, stuck, problem):
    map_ = flat_map(30)
    level = np.ones(len(map_.skin))
    act = CalibrationUsed(
        level, level, level, None, True, "raw", broken=np.array(broken, int), stuck=np.array(stuck, int)
    )
    written = encode_input(5, act, map_)
    if problem is None:
        assert decode_input(written, map_)[1].stuck.tolist() == stuck
    else:
        with pytest.raises(RecordingError, match=problem):
            decode_input(written, map_)
