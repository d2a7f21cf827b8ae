"""What a recording has lost: found by running numbers and checksums, told with its ticks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise


class DamageKind(StrEnum):
    """What is wrong with a recording."""

    CUT_OFF = "cut off"
    """The file ends before its end: what followed is lost, nobody knows how much."""
    UNREADABLE_CHUNK = "unreadable chunk"
    """A chunk of messages does not match its checksum, or its place in the file is not known any more."""
    CHECKSUM = "checksum"
    """Every part with a checksum of its own is whole, and yet the file is not: its metadata or framing was changed."""
    FRAMES_MISSING = "frames missing"
    FRAMES_REPEATED = "frames repeated"
    """The later ones are left out."""
    FRAMES_OUT_OF_ORDER = "frames out of order"
    """They were sorted."""
    INPUTS_MISSING = "inputs missing"
    """What the session did afterwards cannot be simulated again."""
    INPUTS_REPEATED = "inputs repeated"
    EVENTS_MISSING = "events missing"
    EVENTS_REPEATED = "events repeated"


@dataclass(frozen=True)
class RecordingDamage:
    """One thing that a recording has lost.

    Attributes:
        kind: What.
        count: How many chunks, frames, inputs or events; None where nobody knows.
        first: First tick that it can concern; None where it has no place in time.
        last: The last one; None where it has no place in time, or reaches to an unknown end.
    """

    kind: DamageKind
    count: int | None = None
    first: int | None = None
    last: int | None = None


_WORDS = {
    DamageKind.CUT_OFF: "the file was cut off: what followed is lost",
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


def damage_text(damage: RecordingDamage, tick_seconds: float) -> str:
    """What is wrong, where and how long, for people: "frames missing: 6, ticks 96 to 101 (0.03 s from 0.48 s on)".

    Args:
        damage: Which.
        tick_seconds: Of the recording's scene [s].
    """
    text = _WORDS[damage.kind].format("unknown number" if damage.count is None else damage.count)
    if damage.first is None:
        return text
    start = damage.first * tick_seconds
    if damage.last is None:
        return f"{text}, from tick {damage.first} on ({start:.4g} s)"
    if damage.last == damage.first:
        return f"{text}, at tick {damage.first} ({start:.4g} s)"
    length = (damage.last - damage.first + 1) * tick_seconds
    return f"{text}, ticks {damage.first} to {damage.last} ({length:.4g} s from {start:.4g} s on)"


@dataclass(frozen=True)
class Hole:
    """Where bytes could not be read: after a message of tick ``before`` (None: none yet), before one of ``after``."""

    before: int | None
    after: int | None


def find_losses(
    numbers: Sequence[tuple[int, int]], holes: Sequence[Hole], at_end: int, kind: DamageKind
) -> list[RecordingDamage]:
    """What is missing of a topic's messages by their running numbers.

    Args:
        numbers: (number, tick) of each that is there, sorted.
        holes: Where bytes could not be read.
        at_end: How many are missing behind the last, see ``lost_at_end``.
        kind: What to call it.
    """
    found = []
    end = (numbers[-1][0] if numbers else -1) + at_end + 1
    for (number, tick), (following, then) in pairwise([(-1, None), *numbers, (end, None)]):
        if (count := following - number - 1) > 0:
            first, last = _span(tick, then, holes)
            found.append(RecordingDamage(kind, count, first, last))
    return found


def lost_at_end(numbers: Sequence[int], written: int | None) -> int:
    """How many messages of a topic are missing behind the last that is there.

    Args:
        numbers: Running numbers of all that were read, also of those that occur again.
        written: How many the file says it was given; None where it does not say so any more.
    """
    between = max(numbers, default=-1) + 1 - len(set(numbers))
    return 0 if written is None else max(written - len(numbers) - between, 0)


def _span(first: int | None, last: int | None, holes: Sequence[Hole]) -> tuple[int, int | None]:
    """Ticks between which messages were lost: those of the holes between their neighbours, if there are any."""
    low = 0 if first is None else first
    inside = [
        hole
        for hole in holes
        if (hole.after is None or hole.after >= low) and (last is None or hole.before is None or hole.before <= last)
    ]
    if not inside:
        return low, last
    starts = [low if hole.before is None else max(hole.before, low) for hole in inside]
    ends = [last if hole.after is None else hole.after if last is None else min(hole.after, last) for hole in inside]
    return min(starts), None if None in ends else max(end for end in ends if end is not None)


def find_lost_frames(numbers: Sequence[tuple[int, int]], at_end: int) -> list[RecordingDamage]:
    """Frames that are not there: one was written each tick, so their ticks are known.

    Args:
        numbers: (number, tick) of each that is there, sorted by tick, no tick twice.
        at_end: How many are missing behind the last, see ``lost_at_end``.
    """
    spans = [(before + 1, after - 1) for (_, before), (_, after) in pairwise(numbers) if after - before > 1]
    if numbers:
        (first, start), (_, end) = numbers[0], numbers[-1]
        if first > 0:
            spans.insert(0, (max(start - first, 0), start - 1))
        if at_end:
            spans.append((end + 1, end + at_end))
    return [RecordingDamage(DamageKind.FRAMES_MISSING, end - start + 1, start, end) for start, end in spans]
