"""Curves over a whole recording without replaying it: a few numbers of each frame."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import islice
from pathlib import Path

import numpy as np

from tactile_maps.core.arrays import ArrayFields, FloatArray
from tactile_maps.recording.encoding.frame_codec import (
    FrameArrays,
    FrameNumbers,
    frame_arrays,
    frame_numbers,
    frame_shear,
)
from tactile_maps.recording.file import mcap_file

CURVES = FrameNumbers._fields[1:]
"""Names of the curves."""
_CHUNKS_A_PIECE = 40


class QuantityKind(Enum):
    """Kind of a number of a frame."""

    JOINT_POSITION = "joint position"
    """[rad], or [m] for a slide."""
    JOINT_SPEED = "joint speed"
    """[rad/s] or [m/s]."""
    PEAK_PRESSURE = "peak pressure"
    """Maximum over some taxels [Pa]."""
    SKIN_FORCE = "skin force"
    """Sum of pressure times area over some taxels [N]."""
    CONTACT_FORCE = "contact force"
    """Sum over the contacts on some patches [N]."""
    SHEAR_FORCE = "shear force"
    """Sum of the contacts' forces along the skin [N]."""
    FRICTION_IN_USE = "friction in use"
    """Highest friction in use of the contacts."""


@dataclass(frozen=True)
class FrameQuantity:
    """A number of each frame that a user selects for a curve.

    Attributes:
        kind: Kind of the number.
        members: Number of the joint, or of the taxels or patches, at least one; none for shear and friction.
        areas: Areas of the taxels [m^2], for ``SKIN_FORCE``.
    """

    kind: QuantityKind
    members: tuple[int, ...] = ()
    areas: tuple[float, ...] = ()

    def of(self, frame: FrameArrays) -> float:
        """Return the number; NaN if the frame has no such joint or taxel, or no shear.

        Cost: 3 µs, and 50 ns per taxel; 50 µs for shear and friction.
        """
        if self.kind in (QuantityKind.SHEAR_FORCE, QuantityKind.FRICTION_IN_USE):
            force, usage = frame_shear(frame)
            return force if self.kind is QuantityKind.SHEAR_FORCE else usage
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
class Curves(ArrayFields):
    """Numbers of frames over time.

    Attributes:
        ticks: (n,) ticks of the frames, increasing.
        values: (n, len(CURVES) + number of selected quantities) in SI units; NaN for missing ones.
    """

    ticks: FloatArray
    values: FloatArray


NO_CURVES = Curves(np.zeros(0, dtype=np.int64), np.zeros((0, len(CURVES))))


def read_curves(path: str | Path, chosen: Sequence[FrameQuantity] = ()) -> Iterator[tuple[float, Curves]]:
    """Yield the curves of a recording in pieces of some hundred frames, each with the share that has been read.

    Args:
        path: The recording.
        chosen: Quantities in addition to ``CURVES``, one column each, after those.

    Cost: 0.1 ms per frame of 1000 taxels, to unpack it.

    Raises:
        RecordingError: The file cannot be read or is not a recording; damaged frames are skipped.
    """
    for share, frames in frame_pieces(path):
        rows = {
            frame.tick: (*frame_numbers(frame)[1:], *(quantity.of(frame) for quantity in chosen)) for frame in frames
        }
        ticks = sorted(rows)
        values = np.array([rows[tick] for tick in ticks]).reshape(-1, len(CURVES) + len(chosen))
        yield share, Curves(np.array(ticks, dtype=np.int64), values)


def frame_pieces(path: str | Path) -> Iterator[tuple[float, Iterator[FrameArrays]]]:
    """Yield the frames of a recording in pieces, each with the share that has been read after it.

    Raises:
        RecordingError: The file cannot be read or is not a recording; damaged frames are skipped.
    """
    contents = mcap_file.read_recording(path)
    count = len(contents.chunks)
    every = contents.all_messages()
    for start in range(0, count, _CHUNKS_A_PIECE):
        found = (
            frame_arrays(message.data)
            for messages in islice(every, _CHUNKS_A_PIECE)
            for topic, message in messages or ()
            if topic == "/frame"
        )
        yield min((start + _CHUNKS_A_PIECE) / count, 1.0), (frame for frame in found if frame is not None)


def joined(pieces: list[Curves]) -> Curves:
    """Concatenate pieces by tick; the first of a repeated tick counts."""
    if not pieces:
        return NO_CURVES
    ticks, first = np.unique(np.concatenate([piece.ticks for piece in pieces]), return_index=True)
    return Curves(ticks, np.concatenate([piece.values for piece in pieces])[first])


def envelope(times: FloatArray, values: FloatArray, edges: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return minimum and maximum of the values in each bin, to draw more values than pixels without losing peaks.

    Args:
        times: (n,) times, increasing [s].
        values: (n,) values; NaN is skipped.
        edges: (k + 1,) edges of the bins, increasing [s]; a bin includes its first edge and excludes its last.

    Returns:
        (k,) minima and (k,) maxima; NaN for an empty bin.
    """
    at = np.searchsorted(times, edges, side="left")
    low = np.full(len(edges) - 1, np.nan)
    high = np.full(len(edges) - 1, np.nan)
    full = np.flatnonzero(at[1:] > at[:-1])
    if len(full):
        inside = values[: at[full[-1] + 1]]  # up to the end of the last non-empty bin
        low[full] = np.fmin.reduceat(inside, at[full])
        high[full] = np.fmax.reduceat(inside, at[full])
    return low, high
