"""Two hours of simulated session with edits of the map, gains, effects and recordings: nothing grows or diverges.

A bar rocks a weight on its skin, as in ``test_long_run``. Every simulated minute the map is edited, and a gain or an
effect is changed; every ten minutes a minute is recorded. ``TACTILE_MAPS_SOAK_MINUTES`` takes another length.
"""

from __future__ import annotations

import gc
import os
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from tactile_maps.editing.arrange import move, rotate
from tactile_maps.editing.document import MapDocument
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import Recorder
from tactile_maps.recording.verify import verify
from tactile_maps.session.inputs import ControlChanged, EffectsChanged, MapEdited
from tactile_maps.session.session import Session
from tests.control.whole_arm.test_long_run import TICK, scene

MINUTES = int(os.environ.get("TACTILE_MAPS_SOAK_MINUTES", "120"))
A_MINUTE = round(60 / TICK)
RECORDED_EVERY = 10
_GROWN = 300
"""Blocks of memory that a minute may leave behind: its inputs and its part of the record of what was done."""


@dataclass(frozen=True)
class Soak:
    """Result of two hours of simulated time.

    Attributes:
        files: The recordings, in order.
        heights: Height of the weight at the end of each minute [m].
        held: Memory blocks at the end of each minute.
        session: The session in its final state.
    """

    files: tuple[Path, ...]
    heights: np.ndarray
    held: np.ndarray
    session: Session


def act(session: Session, minute: int, documents: tuple[MapDocument, ...]) -> None:
    """Submit the changes of a minute: another map, and other gains or another effect."""
    session.submit(MapEdited("Move", documents[minute % len(documents)].map))
    if minute % 2:
        settings = session.settings
        session.submit(
            ControlChanged(replace(settings, stiffness=settings.stiffness * (0.8 if minute % 4 == 1 else 1.25)))
        )
    else:
        effects = session.runtime_settings.effects
        session.submit(EffectsChanged(replace(effects, friction=not effects.friction)))


@pytest.fixture(scope="module")
def soak(tmp_path_factory) -> Soak:
    """Two hours, once."""
    folder = tmp_path_factory.mktemp("soak")
    session = Session(scene())
    first = MapDocument.of(session.prepared.map)
    documents = (first, move(first, [0], (0.05, 0.02)), rotate(first, [0], 0.5))
    files = []
    heights = np.zeros(MINUTES)
    held = np.zeros(MINUTES, int)
    for minute in range(MINUTES):
        act(session, minute, documents)
        recorder = None
        if minute % RECORDED_EVERY == 0:
            files.append(folder / f"{minute}.mcap")
            recorder = Recorder(session.prepared, files[-1])
            recorder.write(session.frame, session.inputs)
        for _ in range(A_MINUTE):
            frame = session.tick()
            assert np.isfinite(frame.pressures).all()
            if recorder is not None:
                recorder.write(frame, session.inputs)
        if recorder is not None:
            recorder.close()
        heights[minute] = frame.objects[0, 2, 3]
        gc.collect()
        held[minute] = sys.getallocatedblocks()
    return Soak(tuple(files), heights, held, session)


@pytest.mark.long
def test_time_equals_the_simulated_time(soak):
    assert soak.session.frame.time == pytest.approx(60 * MINUTES, abs=1e-6)
    assert soak.session.failure is None


@pytest.mark.long
def test_repeated_four_minute_rounds_end_in_the_same_state(soak):
    """Gains and effects are the same again after four minutes, and so is the weight's height."""
    assert np.ptp(soak.heights) > 0.01, "the gains matter"
    assert soak.heights[8:] == pytest.approx(soak.heights[4:-4], abs=1e-5)


@pytest.mark.long
def test_memory_does_not_grow(soak):
    """But for the inputs, which a session keeps."""
    warm = len(soak.held) // 10
    assert soak.held[-1] - soak.held[warm] < _GROWN * (len(soak.held) - warm)
    assert len(soak.session.inputs) == 1 + 2 * MINUTES  # the first is what the scene begins with


@pytest.mark.long
def test_recordings_are_reproduced(soak):
    players = [RecordingPlayer(file) for file in soak.files]
    assert all(player.complete and len(player) == A_MINUTE + 1 for player in players)
    assert verify(players[0]).identical
