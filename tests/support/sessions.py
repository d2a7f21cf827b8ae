"""Runs of sessions: inputs at ticks, and frames compared bit for bit."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from tactile_maps.core.timing import Timings
from tactile_maps.recording.encoding.frame_codec import encode_frame
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import Recorder
from tactile_maps.session.frame import Frame
from tactile_maps.session.inputs import SessionInput
from tactile_maps.session.session import Session


def run(session: Session, ticks: int, inputs: Mapping[int, Iterable[SessionInput]] | None = None) -> list[Frame]:
    """Advance a session; return the frames.

    Args:
        session: The session.
        ticks: Number of ticks.
        inputs: Inputs submitted before a tick, which is counted from 0.
    """
    frames = []
    for tick in range(ticks):
        for each in (inputs or {}).get(tick, ()):
            session.submit(each)
        frames.append(session.tick())
    return frames


def record(
    session: Session, file: Path, ticks: int, inputs: Mapping[int, Iterable[SessionInput]] | None = None
) -> RecordingPlayer:
    """Advance a session as ``run`` does, record it, and open the recording."""
    with Recorder(session.prepared, file) as recorder:
        for tick in range(ticks):
            recorder.write(run(session, 1, {0: (inputs or {}).get(tick, ())})[0], session.inputs)
    return RecordingPlayer(file)


def same(one: Frame, other: Frame) -> bool:
    """Whether two frames are equal, bit for bit, except for the time that they took."""
    return encode_frame(replace(one, timings=Timings())) == encode_frame(replace(other, timings=Timings()))
