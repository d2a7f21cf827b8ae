"""Curves over a whole recording, without replaying it: a few numbers of each frame."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.arrays import FloatArray, freeze_arrays
from tactile_maps.recording.encoding.frame_codec import FrameArrays, FrameNumbers, frame_arrays, frame_numbers
from tactile_maps.recording.file import mcap_file

CURVES = FrameNumbers._fields[1:]
"""Names of the curves."""
_CHUNKS_A_PIECE = 40


class QuantityKind(Enum):
    """Which number of a frame."""

    JOINT_POSITION = "joint position"
    """[rad] or, of a slide, [m]."""
    JOINT_SPEED = "joint speed"
    """[rad/s] or [m/s]."""
    PEAK_PRESSURE = "peak pressure"
    """Highest of some taxels [Pa]."""
    SKIN_FORCE = "skin force"
    """Sum of pressure times area over some taxels [N]."""
    CONTACT_FORCE = "contact force"
    """Sum over the contacts on some patches [N]."""


@dataclass(frozen=True)
class FrameQuantity:
    """A number of each frame that a person wants to see over the whole recording.

    Attributes:
        kind: Which.
        members: The joint's number, or those of the taxels or patches; at least one.
        areas: Of the taxels [m^2], for ``SKIN_FORCE``.
    """

    kind: QuantityKind
    members: tuple[int, ...]
    areas: tuple[float, ...] = ()

    def of(self, frame: FrameArrays) -> float:
        """The number; NaN where the frame has no such joint or taxel. Cost: 3 µs, and 50 ns a taxel."""
        if self.kind is QuantityKind.CONTACT_FORCE:
            return float(frame.forces[np.isin(frame.patches, self.members)].sum())
        values = {
            QuantityKind.JOINT_POSITION: frame.posture,
            QuantityKind.JOINT_SPEED: frame.velocity,
        }.get(self.kind, frame.pressures)
        if max(self.members) >= len(values):
            return float("nan")
        chosen = values[list(self.members)]
        return float(chosen @ self.areas) if self.kind is QuantityKind.SKIN_FORCE else float(chosen.max())


@dataclass(frozen=True, eq=False)
class Curves:
    """Numbers of frames over time.

    Attributes:
        ticks: (n,) of the frames, rising.
        values: (n, len(CURVES) and one for each chosen quantity) SI; NaN where there is none.
    """

    ticks: NDArray[np.int64]
    values: FloatArray

    def __post_init__(self) -> None:
        freeze_arrays(self, "ticks", "values")


NO_CURVES = Curves(np.zeros(0, dtype=np.int64), np.zeros((0, len(CURVES))))


def read_curves(path: str | Path, chosen: Sequence[FrameQuantity] = ()) -> Iterator[tuple[float, Curves]]:
    """The curves of a recording, a piece of some hundred frames at a time, each with the share that is read then.

    Args:
        path: The recording.
        chosen: What is read beside ``CURVES``; a column each, behind those.

    Cost: 0.1 ms a frame of 1000 taxels, to unpack it.

    Raises:
        RecordingError: The file cannot be read or is not ours; damaged frames are left out.
    """
    contents = mcap_file.read_recording(path)
    count = len(contents.chunks)
    every = contents.all_messages()
    for start in range(0, count, _CHUNKS_A_PIECE):
        rows: dict[int, tuple[float, ...]] = {}
        for messages in islice(every, _CHUNKS_A_PIECE):
            for topic, message in messages or ():
                if topic == "/frame" and (frame := frame_arrays(message.data)) is not None:
                    own = tuple(quantity.of(frame) for quantity in chosen)
                    rows[frame.tick] = (*frame_numbers(frame)[1:], *own)
        ticks = sorted(rows)
        values = np.array([rows[tick] for tick in ticks]).reshape(-1, len(CURVES) + len(chosen))
        yield min((start + _CHUNKS_A_PIECE) / count, 1.0), Curves(np.array(ticks, dtype=np.int64), values)


def joined(pieces: list[Curves]) -> Curves:
    """Pieces as one, by tick; of a tick that occurs again the first."""
    if not pieces:
        return NO_CURVES
    ticks, first = np.unique(np.concatenate([piece.ticks for piece in pieces]), return_index=True)
    return Curves(ticks, np.concatenate([piece.values for piece in pieces])[first])


def envelope(times: FloatArray, values: FloatArray, edges: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Least and largest of the values in each bin: what is drawn when there are more than pixels, so no peak is lost.

    Args:
        times: (n,) rising [s].
        values: (n,) of them; NaN is passed over.
        edges: (k + 1,) of the bins, rising [s]; a bin holds its first edge and not its last.

    Returns:
        (k,) and (k,); NaN for an empty bin.
    """
    at = np.searchsorted(times, edges, side="left")
    low = np.full(len(edges) - 1, np.nan)
    high = np.full(len(edges) - 1, np.nan)
    full = np.flatnonzero(at[1:] > at[:-1])
    if len(full):
        inside = values[: at[full[-1] + 1]]  # the last bin ends there; empty bins between hold nothing
        low[full] = np.fmin.reduceat(inside, at[full])
        high[full] = np.fmax.reduceat(inside, at[full])
    return low, high
