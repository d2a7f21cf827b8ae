"""A recording of a sweep has its own settings and is complete or absent."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tactile_maps.core.errors import SceneError, SimulationError
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.sweep_recording import SweepRecording, record_case
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.session import Session
from tactile_maps.skin.fitting.cover import CoverSpec


@pytest.fixture
def common(tmp_path):
    scene = replace(load_scene("poke"), cover=CoverSpec(links=("hand",), taxels=30))
    scene = replace(scene, stimuli=(replace(scene.stimuli[0], patch="hand", press=0.1),))
    return SweepRecording(scene, tmp_path, "s.toml", viewers=False)


@pytest.mark.long
def test_sweep_is_recorded_with_its_own_settings(common):
    case = {"file": "1.mcap", "seconds": 0.2, "stimuli.0.force": 1.5, "seed": 3}
    [row] = record_case(case, common=common)
    player = RecordingPlayer(common.folder / "1.mcap")
    assert (len(player), row["frames"]) == (40, 40)
    assert player.prepared.scene.seed == 3
    assert player.prepared.scene.stimuli[0].force == 1.5
    assert row["contacts"] == 1
    assert 0 < row["max_force_N"] <= 1.6
    assert 0 < row["touched"] < 1
    assert record_case(case, common=common) == [row], "the file is replaced by an equal one"


def test_failed_sweep_leaves_no_file(common, monkeypatch):
    with pytest.raises(SceneError, match=r"s.toml, vary.tick"):
        record_case({"file": "1.mcap", "seconds": 0.1, "tick": 9.0}, common=common)

    def diverge(session):
        raise SimulationError("the simulation diverged")

    monkeypatch.setattr(Session, "tick", diverge)
    with pytest.raises(SimulationError):
        record_case({"file": "1.mcap", "seconds": 0.1}, common=common)
    assert list(common.folder.iterdir()) == []
