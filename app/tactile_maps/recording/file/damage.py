"""Losses of a recording, found by running numbers and checksums, with their ticks."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from tactile_maps.core.arrays import IntArray


class DamageKind(StrEnum):
    """Kind of damage of a recording."""

    CUT_OFF = "cut off"
    """The file ends early; the number of lost messages is unknown."""
    BEING_RECORDED = "being recorded"
    """A recorder is still writing the file."""
    TRAILING = "trailing bytes"
    """Bytes follow the end of the complete recording."""
    UNREADABLE_CHUNK = "unreadable chunk"
    """A chunk of messages does not match its checksum, or its location in the file is lost."""
    CHECKSUM = "checksum"
    """All parts with their own checksum are intact, but the file is not: its metadata or framing was changed."""
    FRAMES_MISSING = "frames missing"
    FRAMES_REPEATED = "frames repeated"
    """The later ones are ignored."""
    FRAMES_OUT_OF_ORDER = "frames out of order"
    """They were sorted."""
    INPUTS_MISSING = "inputs missing"
    """The session after them cannot be simulated again."""
    INPUTS_REPEATED = "inputs repeated"
    EVENTS_MISSING = "events missing"
    EVENTS_REPEATED = "events repeated"


@dataclass(frozen=True)
class RecordingDamage:
    """A loss of data in a recording.

    Attributes:
        kind: Kind of damage.
        count: Number of bytes, chunks, frames, inputs or events; None if unknown.
        first: First tick that may be affected; None if it has no place in time.
        last: Last such tick; None if it has no place in time, or extends to an unknown end.
    """

    kind: DamageKind
    count: int | None = None
    first: int | None = None
    last: int | None = None


_WORDS = {
    DamageKind.CUT_OFF: "the file was cut off: what followed is lost",
    DamageKind.BEING_RECORDED: "the file is being recorded: what follows is not in it yet",
    DamageKind.TRAILING: "{} bytes after its end, which are ignored",
    DamageKind.UNREADABLE_CHUNK: "{} of its chunks cannot be read",
    DamageKind.CHECKSUM: "the file does not match its checksum, though each of its chunks and attachments does",
    DamageKind.FRAMES_MISSING: "frames missing: {}",
    DamageKind.FRAMES_REPEATED: "frames that occur again and were left out: {}",
    DamageKind.FRAMES_OUT_OF_ORDER: "frames out of order, sorted: {}",
    DamageKind.INPUTS_MISSING: "inputs missing: {}; what followed cannot be simulated again",
    DamageKind.INPUTS_REPEATED: "inputs that occur again and were left out: {}",
    DamageKind.EVENTS_MISSING: "contact events missing: {}",
    DamageKind.EVENTS_REPEATED: "contact events that occur again and were left out: {}",
}


def damage_text(damage: RecordingDamage, tick_seconds: float, *, begins: float = 0.0) -> str:
    """Return a description with place and duration: "frames missing: 6, ticks 96 to 101 (0.03 s from 0.48 s on)".

    Args:
        damage: The damage.
        tick_seconds: Time step of the recording's scene [s].
        begins: Session time of the first frame [s]; the times in the text are since then, as on a timeline.
    """
    text = _WORDS[damage.kind].format("unknown number" if damage.count is None else damage.count)
    if damage.first is None:
        return text
    start = max(damage.first * tick_seconds - begins, 0.0)
    if damage.last is None:
        return f"{text}, from tick {damage.first} on ({start:.4g} s)"
    if damage.last == damage.first:
        return f"{text}, at tick {damage.first} ({start:.4g} s)"
    length = (damage.last - damage.first + 1) * tick_seconds
    return f"{text}, ticks {damage.first} to {damage.last} ({length:.4g} s from {start:.4g} s on)"


@dataclass(frozen=True)
class Hole:
    """Bytes that could not be read: after a message of tick ``before`` (None: none yet), before one of ``after``."""

    before: int | None
    after: int | None


def find_losses(
    numbers: IntArray, ticks: IntArray, holes: Sequence[Hole], at_end: int, kind: DamageKind
) -> list[RecordingDamage]:
    """Return the gaps in the running numbers of a topic's messages.

    Args:
        numbers: (n,) running numbers of the messages, increasing.
        ticks: (n,) their ticks.
        holes: Bytes that could not be read, in the order of the file; ``before`` and ``after`` do not decrease.
        at_end: Number of messages missing after the last, see ``lost_at_end``.
        kind: The kind of damage.
    """
    spans = _Spans(holes)
    counts = np.diff(numbers, prepend=-1) - 1
    found = []
    for place in np.flatnonzero(counts > 0).tolist():
        first, last = spans.between(int(ticks[place - 1]) if place else None, int(ticks[place]))
        found.append(RecordingDamage(kind, int(counts[place]), first, last))
    if at_end:
        found.append(RecordingDamage(kind, at_end, *spans.between(int(ticks[-1]) if len(ticks) else None, None)))
    return found


def merge_damage(found: Sequence[RecordingDamage], stated: Sequence[RecordingDamage]) -> list[RecordingDamage]:
    """Return the damage found in a copy and the damage of its source that the copy states, each loss once.

    Messages that the source had lost leave a gap in the running numbers of the copy as well. The source states more
    precisely when they were lost, unless more of them are missing now.
    """
    kept = list(stated)
    for one in found:
        same = [other for other in kept if one.kind in _MISSING and other.kind is one.kind and _overlap(one, other)]
        known = sum(other.count or 0 for other in same)
        if not same or (one.count or 0) > known:
            kept = [other for other in kept if other not in same] + [one]
    return kept


def _overlap(one: RecordingDamage, other: RecordingDamage) -> bool:
    if one.first is None or other.first is None:
        return False
    one_last = _NEVER if one.last is None else one.last
    other_last = _NEVER if other.last is None else other.last
    return one.first <= other_last and other.first <= one_last


def lost_at_end(numbers: IntArray, written: int | None) -> int:
    """Return the number of messages of a topic that are missing after the last one read.

    Args:
        numbers: (n,) running numbers of all messages that were read, including repeated ones.
        written: Number of messages that were written according to the file; None if that is lost.
    """
    if written is None:
        return 0
    between = int(numbers.max(initial=-1)) + 1 - len(np.unique(numbers))
    return max(written - len(numbers) - between, 0)


class _Spans:
    """Finds the ticks between which messages were lost, in logarithmic time: a file may have many holes and losses."""

    def __init__(self, holes: Sequence[Hole]) -> None:
        self._before = [-1 if hole.before is None else hole.before for hole in holes]
        self._after = [_NEVER if hole.after is None else hole.after for hole in holes]

    def between(self, first: int | None, last: int | None) -> tuple[int, int | None]:
        """Return the ticks of the holes between two neighbouring messages, if there are any; otherwise theirs."""
        low = 0 if first is None else first
        begin = bisect_left(self._after, low)
        end = len(self._before) if last is None else bisect_right(self._before, last)
        if begin >= end:
            return low, last
        until = self._after[end - 1]
        if last is not None:
            until = min(until, last)
        return max(self._before[begin], low), None if until == _NEVER else until


_MISSING = (DamageKind.FRAMES_MISSING, DamageKind.INPUTS_MISSING, DamageKind.EVENTS_MISSING)
_NEVER = 2**63
"""Tick of the message that follows a hole at the end of the file."""


def find_lost_frames(numbers: IntArray, ticks: IntArray, at_end: int) -> list[RecordingDamage]:
    """Return the missing frames: one was written at each tick, so their ticks are known.

    Args:
        numbers: (n,) sequence numbers of the frames.
        ticks: (n,) their ticks, increasing.
        at_end: Number of frames missing after the last, see ``lost_at_end``.
    """
    gaps = np.flatnonzero(np.diff(ticks) > 1).tolist()
    spans = [(int(ticks[gap]) + 1, int(ticks[gap + 1]) - 1) for gap in gaps]
    if len(ticks):
        start = int(ticks[0])
        end = int(ticks[-1])
        if numbers[0] > 0:
            spans.insert(0, (max(start - int(numbers[0]), 0), start - 1))
        if at_end:
            spans.append((end + 1, end + at_end))
    return [RecordingDamage(DamageKind.FRAMES_MISSING, end - start + 1, start, end) for start, end in spans]
