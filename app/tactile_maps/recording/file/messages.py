"""All messages of a recording: locations of the frames, inputs, events, and what has been lost.

The messages of each topic have running numbers (MCAP's ``sequence``) and each frame has a tick, which show what is
missing, repeated or out of order regardless of how the file was damaged.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Generic, NamedTuple, TypeVar

import numpy as np
from mcap.records import Message

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
"""Key in the metadata of a copy: damage of its source."""
_CHUNKS_A_STEP = 50
"""Number of chunks between two calls of ``progress``: some tenths of a second."""
_T = TypeVar("_T")


@dataclass(frozen=True, eq=False)
class FramePlaces:
    """Locations of the frames of a recording by tick, without repetitions; as arrays, since there may be millions.

    Attributes:
        numbers: (n,) running numbers.
        ticks: (n,) ticks, increasing.
        chunks: (n,) number of the chunk that contains each frame.
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
        events: Contact events, oldest first.
        marks: Marks set while recording, in that order.
        failure: Tick and error at which the session stopped by itself; None if it did not.
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


class _CollectedMessages:
    """Messages of a recording, added chunk by chunk, and the ticks between which chunks are unreadable.

    Attributes:
        frames: Number, tick, chunk and place of each frame; 32 bytes per frame, while tuples take 200.
        inputs: Inputs with their numbers and ticks.
        events: Events with their numbers and ticks.
        marks: Marks of the user.
        failure: Tick and error at which the session stopped by itself; None if it did not.
        unreadable: Number of chunks that cannot be read.
    """

    def __init__(self, prepared: PreparedScene, file: str) -> None:
        self._prepared = prepared
        self._file = file
        self.frames = array("q")
        self.inputs: list[_Numbered[tuple[int, SessionInput]]] = []
        self.events: list[_Numbered[ContactEvent]] = []
        self.marks: list[Mark] = []
        self.failure: tuple[int, SimulationError] | None = None
        self.unreadable = 0
        self._holes: list[Hole] = []
        self._latest: int | None = None
        self._open_hole = False

    @property
    def all_holes(self) -> list[Hole]:
        """Holes that unreadable chunks left; adjacent ones are one hole, which has no end at the end of the file."""
        return [*self._holes, *([Hole(self._latest, None)] if self._open_hole else [])]

    def add_chunk(self, number: int, messages: Iterable[tuple[str, Message]] | None) -> None:
        """Add the messages of a chunk, each with its topic; None for an unreadable chunk."""
        if messages is None:
            self.unreadable += 1
            self._open_hole = True
            return
        for place, (topic, message) in enumerate(messages):
            match topic:
                case "/frame":
                    self._add_frame(number, place, message)
                case "/input":
                    item = decode_input(message.data, self._prepared.map, file=self._file)
                    self.inputs.append(_Numbered(message.sequence, item[0], item))
                case "/event":
                    event = decode_event(message.data, self._prepared.skin, file=self._file)
                    self.events.append(_Numbered(message.sequence, event.tick, event))
                case "/mark":
                    self.marks.append(decode_mark(message.data, file=self._file))
                case "/failure":
                    self.failure = decode_failure(message.data, file=self._file)

    def _add_frame(self, chunk: int, place: int, message: Message) -> None:
        tick = tick_of(message.data, file=self._file)
        self.frames.extend((message.sequence, tick, chunk, place))
        after = tick if self._latest is None else max(self._latest, tick)
        if self._open_hole:
            self._holes.append(Hole(self._latest, after))
        self._latest = after
        self._open_hole = False


def read_messages(
    contents: mcap_file.RecordingContents, prepared: PreparedScene, *, file: str, progress: Progress = no_progress
) -> RecordedMessages:
    """Read all messages except the frames, of which only the locations are kept, and find losses.

    Args:
        contents: Contents of the file.
        prepared: The recorded scene.
        file: Name of the file, for errors.
        progress: Receives a description and the progress, 0 to 1.

    Raises:
        RecordingError: A message matches its checksum but is invalid.
    """
    read = _CollectedMessages(prepared, file)
    for number, messages in enumerate(contents.all_messages()):
        if number % _CHUNKS_A_STEP == 0:
            progress("Reading the recording", number / len(contents.chunks))
        read.add_chunk(number, messages)
    holes = read.all_holes
    written = {topic: contents.written.get(channel) for channel, topic in contents.channels.items()}
    rows = np.array(read.frames, dtype=np.int64).reshape(-1, 4)
    frames, damage = _in_order(rows)
    at_end = lost_at_end(rows[:, 0], written.get("/frame"))
    if mcap_file.MEASURED in contents.metadata:  # readings arrive at any tick: only their numbers show losses
        damage += find_losses(frames.numbers, frames.ticks, holes, at_end, DamageKind.FRAMES_MISSING)
    else:
        damage += find_lost_frames(frames.numbers, frames.ticks, at_end)
    inputs, input_damage = _numbered(
        read.inputs, holes, written.get("/input"), DamageKind.INPUTS_MISSING, DamageKind.INPUTS_REPEATED
    )
    events, event_damage = _numbered(
        read.events, holes, written.get("/event"), DamageKind.EVENTS_MISSING, DamageKind.EVENTS_REPEATED
    )
    lost = merge_damage([*damage, *input_damage, *event_damage], _stated_damage(contents, file))
    damage = [*_damage_of_file(contents, read.unreadable, frames), *lost]
    ordered = sorted(set(damage), key=lambda one: (-1 if one.first is None else one.first, one.kind))
    if contents.checksum_fails and not ordered:
        ordered = [RecordingDamage(DamageKind.CHECKSUM)]
    return RecordedMessages(frames, inputs, events, tuple(read.marks), read.failure, tuple(ordered))


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
    """Sort frames by tick and keep the first of each tick.

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
    """Return messages by their running numbers without repetitions, and their damage."""
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


def _stated_damage(contents: mcap_file.RecordingContents, file: str) -> tuple[RecordingDamage, ...]:
    """Return the damage of the source of a copy."""
    text = contents.metadata.get(_DAMAGE)
    if text is None:
        return ()
    return load_json(_DamageEntry, text, error=RecordingError, place=_DAMAGE, file=file, remedy=DAMAGED).damage


def damage_entry(damage: tuple[RecordingDamage, ...]) -> dict[str, str]:
    """Return the damage of a recording as an entry of its copy's metadata; empty if nothing is lost in the copy."""
    lost = tuple(
        replace(one, kind=DamageKind.CUT_OFF) if one.kind == DamageKind.BEING_RECORDED else one
        for one in damage
        if one.kind != DamageKind.TRAILING
    )
    return {_DAMAGE: dump_json(_DamageEntry(lost)).decode()} if lost else {}
