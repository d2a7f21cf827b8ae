"""All messages of a recording: which frames there are and where, every input and event, and what has been lost.

Each topic's messages carry a running number (MCAP's ``sequence``), and frames a tick each: what is missing, repeated or
out of order shows in them, whatever became of the file.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from tactile_maps.contacts.events import ContactEvent
from tactile_maps.core.arrays import IntArray
from tactile_maps.core.codec import dump_json, load_json
from tactile_maps.core.errors import RecordingError, SimulationError
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.recording.encoding.annotations import Mark
from tactile_maps.recording.encoding.frame_codec import tick_of
from tactile_maps.recording.encoding.message_codecs import decode_event, decode_failure, decode_input, decode_mark
from tactile_maps.recording.file import mcap_file
from tactile_maps.recording.file.damage import (
    DamageKind,
    Hole,
    RecordingDamage,
    find_losses,
    find_lost_frames,
    lost_at_end,
    merge_damage,
)
from tactile_maps.session.bundle import DAMAGED
from tactile_maps.session.inputs import SessionInput
from tactile_maps.session.prepare import PreparedScene

_DAMAGE = "damage"
"""Of the metadata of a recovered recording: what its source had lost."""
_CHUNKS_A_STEP = 50
"""Chunks between two calls of ``progress``: some tenths of a second."""
_T = TypeVar("_T")


@dataclass(frozen=True, eq=False)
class FramePlaces:
    """Frames of a recording by tick, none twice; as arrays, since there may be millions.

    Attributes:
        numbers: (n,) running numbers.
        ticks: (n,) rising.
        chunks: (n,) number of the chunk that holds each frame.
        places: (n,) index of each frame among the messages of its chunk.
    """

    numbers: IntArray
    ticks: IntArray
    chunks: IntArray
    places: IntArray

    def __len__(self) -> int:
        return len(self.ticks)

    def within(self, first: int, last: int) -> FramePlaces:
        """Return the frames with ticks from ``first`` to ``last``, both included."""
        chosen = slice(*np.searchsorted(self.ticks, (first, last + 1)).tolist())
        return FramePlaces(self.numbers[chosen], self.ticks[chosen], self.chunks[chosen], self.places[chosen])


@dataclass(frozen=True)
class RecordedMessages:
    """The messages of a recording.

    Attributes:
        frames: Locations of the frames.
        inputs: (tick, input), in the order they were given.
        events: Oldest first.
        marks: Set while it was recorded, in that order.
        failure: The tick at which the session stopped by itself, and why; None when it did not.
        damage: What is missing, repeated or out of order.
    """

    frames: FramePlaces
    inputs: list[tuple[int, SessionInput]]
    events: list[ContactEvent]
    marks: tuple[Mark, ...]
    failure: tuple[int, SimulationError] | None
    damage: tuple[RecordingDamage, ...]


class _Numbered(NamedTuple, Generic[_T]):
    number: int
    tick: int
    content: _T


def read_messages(
    contents: mcap_file.RecordingContents, prepared: PreparedScene, *, file: str, progress: Progress = no_progress
) -> RecordedMessages:
    """Read every message but the frames, whose places are enough, and find what has been lost.

    Args:
        contents: Of the file.
        prepared: The scene that was recorded.
        file: Its name, for errors.
        progress: Told how far it is, 0 to 1.

    Raises:
        RecordingError: A message matches its checksum and is still none of ours.
    """
    found = array("q")  # number, tick, chunk and place of each frame: 32 bytes each where tuples take 200
    inputs: list[_Numbered[tuple[int, SessionInput]]] = []
    events: list[_Numbered[ContactEvent]] = []
    marks: list[Mark] = []
    failure = None
    unreadable = 0
    holes: list[Hole] = []
    latest = None
    open_hole = False
    for number, messages in enumerate(contents.all_messages()):
        if number % _CHUNKS_A_STEP == 0:
            progress("Reading the recording", number / len(contents.chunks))
        if messages is None:
            unreadable += 1
            open_hole = True
            continue
        for place, (topic, message) in enumerate(messages):
            if topic == "/frame":
                tick = tick_of(message.data, file=file)
                found.extend((message.sequence, tick, number, place))
                after = tick if latest is None else max(latest, tick)
                if open_hole:  # several in a row are one
                    holes.append(Hole(latest, after))
                latest = after
                open_hole = False
            elif topic == "/input":
                item = decode_input(message.data, prepared.map, file=file)
                inputs.append(_Numbered(message.sequence, item[0], item))
            elif topic == "/event":
                event = decode_event(message.data, prepared.skin, file=file)
                events.append(_Numbered(message.sequence, event.tick, event))
            elif topic == "/mark":
                marks.append(decode_mark(message.data, file=file))
            elif topic == "/failure":
                failure = decode_failure(message.data, file=file)
    if open_hole:
        holes.append(Hole(latest, None))
    written = {topic: contents.written.get(channel) for channel, topic in contents.channels.items()}
    rows = np.array(found, dtype=np.int64).reshape(-1, 4)
    frames, damage = _in_order(rows)
    at_end = lost_at_end(rows[:, 0], written.get("/frame"))
    if mcap_file.MEASURED in contents.metadata:  # readings come when they come: only their numbers tell what is gone
        damage += find_losses(frames.numbers, frames.ticks, holes, at_end, DamageKind.FRAMES_MISSING)
    else:
        damage += find_lost_frames(frames.numbers, frames.ticks, at_end)
    acts, more = _numbered(inputs, holes, written.get("/input"), DamageKind.INPUTS_MISSING, DamageKind.INPUTS_REPEATED)
    told, most = _numbered(events, holes, written.get("/event"), DamageKind.EVENTS_MISSING, DamageKind.EVENTS_REPEATED)
    lost = merge_damage([*damage, *more, *most], _told_damage(contents, file))
    damage = [*_damage_of_file(contents, unreadable, frames), *lost]
    ordered = sorted(set(damage), key=lambda one: (-1 if one.first is None else one.first, one.kind))
    if contents.checksum_fails and not ordered:
        ordered = [RecordingDamage(DamageKind.CHECKSUM)]
    return RecordedMessages(frames, acts, told, tuple(marks), failure, tuple(ordered))


def _damage_of_file(
    contents: mcap_file.RecordingContents, unreadable: int, frames: FramePlaces
) -> list[RecordingDamage]:
    found = []
    if unreadable:
        found.append(RecordingDamage(DamageKind.UNREADABLE_CHUNK, unreadable))
    if not contents.complete:
        end = int(frames.ticks[-1]) + 1 if len(frames) else None
        kind = DamageKind.BEING_RECORDED if contents.being_recorded else DamageKind.CUT_OFF
        found.append(RecordingDamage(kind, None, end))
    if contents.trailing:
        found.append(RecordingDamage(DamageKind.TRAILING, contents.trailing))
    return found


def _in_order(rows: IntArray) -> tuple[FramePlaces, list[RecordingDamage]]:
    """Sort frames by tick, the first of each.

    Args:
        rows: (n, 4) number, tick, chunk and place, in the order of the file.
    """
    ticks = rows[:, 1]
    _, first = np.unique(ticks, return_index=True)
    again = np.ones(len(ticks), dtype=bool)
    again[first] = False
    late = ~again
    late[1:] &= ticks[1:] < np.maximum.accumulate(ticks)[:-1]
    late[:1] = False
    damage = [
        RecordingDamage(kind, len(found), int(found.min()), int(found.max()))
        for kind, found in (
            (DamageKind.FRAMES_REPEATED, ticks[again]),
            (DamageKind.FRAMES_OUT_OF_ORDER, ticks[late]),
        )
        if len(found)
    ]
    return FramePlaces(*rows[first].T), damage


def _numbered(
    messages: Sequence[_Numbered[_T]],
    holes: Sequence[Hole],
    written: int | None,
    missing: DamageKind,
    repeated: DamageKind,
) -> tuple[list[_T], list[RecordingDamage]]:
    """Messages by their running numbers, none twice; and what is not there."""
    found: dict[int, _Numbered[_T]] = {}
    twice = [message.tick for message in messages if found.setdefault(message.number, message) is not message]
    kept = [found[number] for number in sorted(found)]
    at_end = lost_at_end(np.array([message.number for message in messages], dtype=np.int64), written)
    numbers, ticks = np.array([(message.number, message.tick) for message in kept], dtype=np.int64).reshape(-1, 2).T
    damage = find_losses(numbers, ticks, holes, at_end, missing)
    if twice:
        damage.append(RecordingDamage(repeated, len(twice), min(twice), max(twice)))
    return [message.content for message in kept], damage


@dataclass(frozen=True)
class _DamageEntry:
    damage: tuple[RecordingDamage, ...]


def _told_damage(contents: mcap_file.RecordingContents, file: str) -> tuple[RecordingDamage, ...]:
    """What the recording it was recovered from had lost."""
    text = contents.metadata.get(_DAMAGE)
    if text is None:
        return ()
    return load_json(_DamageEntry, text, error=RecordingError, place=_DAMAGE, file=file, remedy=DAMAGED).damage


def damage_entry(damage: tuple[RecordingDamage, ...]) -> dict[str, str]:
    """Return the damage of a recording as an entry of its copy's metadata; empty where nothing is lost in the copy."""
    lost = tuple(
        replace(one, kind=DamageKind.CUT_OFF) if one.kind == DamageKind.BEING_RECORDED else one
        for one in damage
        if one.kind != DamageKind.TRAILING
    )
    return {_DAMAGE: dump_json(_DamageEntry(lost)).decode()} if lost else {}
