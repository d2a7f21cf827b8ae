"""All messages of a recording: which frames there are and where, every input and event, and what has been lost.

Each topic's messages carry a running number (MCAP's ``sequence``), and frames a tick each: what is missing, repeated or
out of order shows in them, whatever became of the file.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Generic, NamedTuple, TypeVar

from app.contacts.events import ContactEvent
from app.core.codec import dump_json, load_json
from app.core.errors import RecordingError, SimulationError
from app.core.progress import Progress, no_progress
from app.recording import mcap_file
from app.recording.annotations import Mark
from app.recording.damage import DamageKind, Hole, RecordingDamage, find_losses, find_lost_frames, lost_at_end
from app.recording.encoding.frame_codec import tick_of
from app.recording.encoding.message_codecs import decode_event, decode_failure, decode_input, decode_mark
from app.session.bundle import DAMAGED
from app.session.inputs import SessionInput
from app.session.prepare import PreparedScene

_DAMAGE = "damage"
"""Of the metadata of a recovered recording: what its source had lost."""
_CHUNKS_A_STEP = 50
"""Chunks between two calls of ``progress``: some tenths of a second."""
_T = TypeVar("_T")


class FramePlace(NamedTuple):
    """Where a frame stands: its running number, its tick, the number of its chunk and its place among the messages."""

    number: int
    tick: int
    chunk: int
    place: int


@dataclass(frozen=True)
class RecordedMessages:
    """What a recording says.

    Attributes:
        frames: By tick, none twice.
        inputs: (tick, input), in the order they were given.
        events: Oldest first.
        marks: Set while it was recorded, in that order.
        failure: The tick at which the session stopped by itself, and why; None when it did not.
        damage: What is missing, repeated or out of order.
    """

    frames: list[FramePlace]
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
    frames: list[FramePlace] = []
    inputs: list[_Numbered[tuple[int, SessionInput]]] = []
    events: list[_Numbered[ContactEvent]] = []
    marks: list[Mark] = []
    failure, holes = None, []
    for number, chunk in enumerate(contents.chunks):
        if number % _CHUNKS_A_STEP == 0:
            progress("Reading the recording", number / len(contents.chunks))
        messages = mcap_file.chunk_messages(chunk, contents.channels)
        if messages is None:
            holes.append(Hole(frames[-1].tick if frames else None, None))
            continue
        for place, (topic, message) in enumerate(messages):
            if topic == "/frame":
                frames.append(FramePlace(message.sequence, tick_of(message.data, file=file), number, place))
                holes = [hole if hole.after is not None else replace(hole, after=frames[-1].tick) for hole in holes]
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
    written = {topic: contents.written.get(channel) for channel, topic in contents.channels.items()}
    kept, damage = _in_order(frames)
    at_end = lost_at_end([frame.number for frame in frames], written.get("/frame"))
    numbered = [(frame.number, frame.tick) for frame in kept]
    if mcap_file.MEASURED in contents.metadata:  # readings come when they come: only their numbers tell what is gone
        damage += find_losses(numbered, holes, at_end, DamageKind.FRAMES_MISSING)
    else:
        damage += find_lost_frames(numbered, at_end)
    acts, more = _numbered(inputs, holes, written.get("/input"), DamageKind.INPUTS_MISSING, DamageKind.INPUTS_REPEATED)
    told, most = _numbered(events, holes, written.get("/event"), DamageKind.EVENTS_MISSING, DamageKind.EVENTS_REPEATED)
    damage = [*_damage_of_file(contents, len(holes), kept), *damage, *more, *most, *_told_damage(contents, file)]
    ordered = sorted(set(damage), key=lambda one: (-1 if one.first is None else one.first, one.kind))
    if contents.checksum_fails and not ordered:
        ordered = [RecordingDamage(DamageKind.CHECKSUM)]
    return RecordedMessages(kept, acts, told, tuple(marks), failure, tuple(ordered))


def _damage_of_file(
    contents: mcap_file.RecordingContents, unreadable: int, frames: Sequence[FramePlace]
) -> list[RecordingDamage]:
    found = []
    if unreadable:
        found.append(RecordingDamage(DamageKind.UNREADABLE_CHUNK, unreadable))
    if not contents.complete:
        found.append(RecordingDamage(DamageKind.CUT_OFF, None, frames[-1].tick + 1 if frames else None))
    return found


def _in_order(frames: list[FramePlace]) -> tuple[list[FramePlace], list[RecordingDamage]]:
    """Frames by tick, none twice."""
    found, latest, repeated, late = dict[int, FramePlace](), -1, [], []
    for frame in frames:
        if frame.tick in found:
            repeated.append(frame.tick)
            continue
        found[frame.tick] = frame
        if frame.tick < latest:
            late.append(frame.tick)
        latest = max(latest, frame.tick)
    damage = [
        RecordingDamage(kind, len(ticks), min(ticks), max(ticks))
        for kind, ticks in ((DamageKind.FRAMES_REPEATED, repeated), (DamageKind.FRAMES_OUT_OF_ORDER, late))
        if ticks
    ]
    return [found[tick] for tick in sorted(found)], damage


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
    at_end = lost_at_end([message.number for message in messages], written)
    damage = find_losses([(message.number, message.tick) for message in kept], holes, at_end, missing)
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
    """The same as an entry of a recording's metadata; none where nothing is lost."""
    return {_DAMAGE: dump_json(_DamageEntry(damage)).decode()} if damage else {}
