"""Speed of recording relative to real time, and the time to write a frame."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.recording.recorder import Recorder
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepare import prepare
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import PokePressed


@pytest.mark.parametrize("viewers", [True, False])
def test_recording_one_frame(benchmark, tmp_path, viewers):
    """The difference of the two is the cost of the messages for viewers: at most 0.1 ms of CPU time."""
    prepared = prepare(load_scene("arm"))
    session = Session(prepared)
    session.submit(PokePressed(1, prepared.skin.taxel_point(500)))
    frames = [session.tick() for _ in range(200)]
    assert frames[-1].regions
    with Recorder(prepared, tmp_path / "rate.mcap", viewers=viewers) as recorder:
        endless = (replace(frames[number % 200], tick=number + 1) for number in itertools.count())
        benchmark.pedantic(lambda: recorder.write(next(endless), session.inputs), rounds=1000, warmup_rounds=50)
        assert recorder.frames > 0
    if benchmark.stats is not None:
        mean = float(np.mean(benchmark.stats.stats.data))
        benchmark.extra_info["times real time"] = f"{prepared.scene.tick / mean:.0f}"
        benchmark.extra_info["bytes a frame"] = recorder.path.stat().st_size // recorder.frames
