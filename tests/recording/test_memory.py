"""Memory does not grow with the size of a recording: chunks are read from the file one after the other."""

from __future__ import annotations

import gc
import subprocess
import sys
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.export import sinks
from tactile_maps.export.export import FORMATS, export_recording
from tactile_maps.recording.overview.curves import read_curves
from tactile_maps.recording.overview.summary import summarise
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import Recorder
from tactile_maps.recording.recover import recover
from tactile_maps.recording.trim import trim
from tactile_maps.scene.scene import Scene
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.session import Session
from tests.support.touch import bar, bar_map, bar_skin

SHORT = 200
LONG = 600
TAXELS = 1000
SHARE = 0.1
"""Bytes of memory per additional byte of recording. Locations take 32 bytes a frame, of about 8,000 in the file."""


QUICK = ("parquet", "npz")
"""Formats that are exported fast enough for the default tests. The package of ``rerun`` is not installed for tests."""


def noisy_recording(path, prepared, frames):
    """Record frames whose pressures cannot be compressed."""
    frame = Session(prepared).tick()
    noise = np.random.default_rng(0).uniform(0, 1e4, (97, len(prepared.skin)))
    with Recorder(prepared, path, viewers=False) as recorder:
        for number in range(frames):
            pressures = noise[number % 97] * (1 + 1e-9 * number)
            tick = frame.tick + number
            recorder.write(replace(frame, tick=tick, time=tick * prepared.scene.tick, pressures=pressures), [])
    return path


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """A short and a long recording."""
    folder = tmp_path_factory.mktemp("memory")
    prepared = PreparedScene(Scene(name="bar", robot="bar"), bar(), bar_skin(TAXELS), bar_map(TAXELS))
    return [noisy_recording(folder / f"{frames}.mcap", prepared, frames) for frames in (SHORT, LONG)]


def opened(path, folder):
    return RecordingPlayer(path)


def played(path, folder):
    assert sum(1 for _ in RecordingPlayer(path)) in (SHORT, LONG)


def scrubbed(path, folder):
    player = RecordingPlayer(path)
    for number in range(0, len(player), 10):
        player.frame(number * 97 % len(player))


def trimmed(path, folder):
    trim(path, folder / "part.mcap", first=10, overwrite=True)


def recovered(path, folder):
    recover(path, folder / "whole.mcap", overwrite=True)


def curves(path, folder):
    assert sum(len(piece.ticks) for _, piece in read_curves(path)) in (SHORT, LONG)


def summary(path, folder):
    assert not summarise(path).problem


def exported(to):
    """A work that exports to this format."""

    def work(path, folder):
        target = folder / f"{path.stem}{FORMATS[to].ending}"
        export_recording(path, target, to=to)
        assert target.exists()

    return work


def peak(work, path, folder):
    """Largest number of bytes that Python allocated at a time during ``work``."""
    gc.collect()
    tracemalloc.start()
    try:
        work(path, folder)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "work",
    [
        scrubbed,
        pytest.param(exported("parquet"), id="parquet"),
        *(pytest.param(work, marks=pytest.mark.long) for work in (opened, played, trimmed, recovered, curves, summary)),
        *(
            pytest.param(exported(to), id=to, marks=pytest.mark.long)
            for to in ("npz", "csv", "hdf5", "rosbag2", "mp4", "lerobot")
        ),
    ],
)
def test_memory_does_not_grow_with_the_recording(pair, tmp_path, work, monkeypatch):
    monkeypatch.setattr(sinks, "ROW_GROUP", 2**18)  # less than the short recording
    growth = pair[1].stat().st_size - pair[0].stat().st_size
    assert growth > 3_000_000
    (tmp_path / "first").mkdir()
    work(pair[0], tmp_path / "first")  # imports and caches
    small, large = (peak(work, path, tmp_path) for path in pair)
    assert large - small < SHARE * growth


HUGE = 330_000_000
"""Bytes of a recording in the long test."""
MEASURED = """
import os, subprocess, sys
child = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL)
_, status, usage = os.wait4(child.pid, 0)
print(usage.ru_maxrss)
sys.exit(os.waitstatus_to_exitcode(status))
"""
"""Runs a command and prints its peak memory [kB]. A process inherits the peak of its parent, so this small process is
placed between pytest and the command."""
MOST_RESIDENT = {"inspect": 300, "replay": 300, "trim": 320, "recover": 320, "export": 400}
"""Peak memory of a whole process [MB]. Kept in memory, the recording alone would exceed each."""


@pytest.fixture(scope="module")
def huge(tmp_path_factory):
    """A recording of 330 MB."""
    taxels = 1000
    prepared = PreparedScene(Scene(name="bar", robot="bar"), bar(), bar_skin(taxels), bar_map(taxels))
    path = noisy_recording(tmp_path_factory.mktemp("huge") / "huge.mcap", prepared, HUGE // (8 * taxels))
    assert path.stat().st_size > 0.8 * HUGE
    return path


@pytest.mark.long
@pytest.mark.parametrize(
    "words",
    [
        ["inspect"],
        ["replay"],
        ["trim", "--from", "1", "-o", "part.mcap"],
        ["recover", "-o", "whole.mcap"],
        ["export", "--to", "hdf5", "-o", "tables.h5"],
        ["export", "--to", "npz", "-o", "tables.npz"],
        ["export", "--to", "mp4", "-o", "film.mp4"],
        ["export", "--to", "parquet", "-o", "tables"],
        ["export", "--to", "rosbag2", "-o", "bag"],
    ],
    ids=" ".join,
)
def test_commands_on_a_huge_recording_need_bounded_memory(huge, tmp_path, words):
    command = [sys.executable, "-m", "tactile_maps", words[0], str(huge), *words[1:]]
    done = subprocess.run(
        [sys.executable, "-c", MEASURED, *command],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout.split()[-1]) < 1000 * MOST_RESIDENT[words[0]]
