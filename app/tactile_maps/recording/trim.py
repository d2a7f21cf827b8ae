"""Copies a part of a recording to a new file; the recording is not modified.

The part contains the frames of its ticks, all inputs up to its end, so that it can be simulated again like the whole
recording, and the annotations of these ticks.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap.records import Message

from tactile_maps.core.errors import RecordingError
from tactile_maps.core.files import check_output, make_output_folder, open_atomically
from tactile_maps.core.progress import Progress, no_progress, part_of_progress
from tactile_maps.recording.encoding.annotations import (
    LabelledEpisode,
    annotations_entry,
    annotations_in,
    load_annotations,
)
from tactile_maps.recording.encoding.viewer_messages import ROBOT_TOPIC, viewer_schemas
from tactile_maps.recording.file import mcap_file
from tactile_maps.recording.file.damage import DamageKind, RecordingDamage, damage_text
from tactile_maps.recording.file.messages import FramePlaces, RecordedMessages, damage_entry, read_messages
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.session.bundle import unpack_scene
from tactile_maps.session.prepare import PreparedScene

_CHUNKS_A_STEP = 50
_OF_FRAMES = (DamageKind.FRAMES_MISSING, DamageKind.FRAMES_REPEATED, DamageKind.FRAMES_OUT_OF_ORDER)


@dataclass(frozen=True)
class TrimResult:
    """Result of a trim.

    Attributes:
        frames: Number of frames.
        seconds: Time from the first to the last frame [s].
        file: The new file.
        damage: Damage of the source that affects the part; the new file states the same.
        tick: Time step of the scene [s].
        begins: Session time of the source's first frame [s].
    """

    frames: int
    seconds: float
    file: str
    damage: tuple[RecordingDamage, ...] = ()
    tick: float = 0.0
    begins: float = 0.0

    @property
    def damage_texts(self) -> tuple[str, ...]:
        """Descriptions of the damage, with times since the first frame of the source."""
        return tuple(damage_text(one, self.tick, begins=self.begins) for one in self.damage)


def trim(
    source: str | Path,
    target: str | Path,
    *,
    first: int = 0,
    last: int | None = None,
    overwrite: bool = False,
    progress: Progress = no_progress,
) -> TrimResult:
    """Write the ticks ``first`` to ``last`` of a recording to a new one.

    Args:
        source: The recording; it is not modified.
        target: The new file.
        first: First tick.
        last: Last tick, which is included; None for the end.
        overwrite: Replace an existing file.
        progress: Receives a description and the progress, 0 to 1; may raise to cancel, and then no file is left.

    Raises:
        RecordingError: The source is invalid or has no frame in this range; the target exists or cannot be written.
    """
    source = Path(source)
    target = Path(target)
    check_apart(source, target)
    contents = mcap_file.read_recording(source)
    prepared = unpack_scene(contents.attachments, file=str(source))
    messages = read_messages(contents, prepared, file=str(source), progress=lambda text, done: progress(text, done / 2))
    ticks = messages.frames.ticks
    if not len(ticks):
        raise contents.no_frame()
    kept = messages.frames.within(first, int(ticks[-1]) if last is None else last).ticks
    if not len(kept):
        span = f"ticks {first} to {'the end' if last is None else last}"
        has = f"It has ticks {ticks[0]} to {ticks[-1]}"
        raise RecordingError("the recording has no frame in this range", file=source, value=span, remedy=has)
    begin = int(kept[0])
    end = int(kept[-1])
    own = annotations_in(contents.metadata, messages.marks, file=str(source))
    annotations = load_annotations(source, of=contents.metadata.get(mcap_file.STARTED, "")) or own
    part = _Part(contents, messages, prepared, begin, end)
    with open_atomically(target, error=RecordingError, overwrite=overwrite) as stream:
        part.write(stream, annotations_entry(annotations.within(begin, end)), progress)
    seconds = (end - begin) * prepared.scene.tick
    step = prepared.scene.tick
    return TrimResult(len(kept), seconds, str(target), part.damage, step, float(ticks[0] * step))


def check_apart(source: Path, target: Path) -> None:
    """Check that a part is not written over its source.

    Raises:
        RecordingError: They are the same file.
    """
    if source.resolve() == target.resolve():
        raise RecordingError("a recording cannot be cut into itself", file=target, remedy="Give another file")


class _Part:
    """The messages of a recording that belong into the new file."""

    def __init__(
        self,
        contents: mcap_file.RecordingContents,
        messages: RecordedMessages,
        prepared: PreparedScene,
        first: int,
        last: int,
    ) -> None:
        self._contents = contents
        self._prepared = prepared
        self._first = first
        self._last = last
        frames = messages.frames.within(first, last)
        self._number = int(frames.numbers.min())  # running numbers begin at 0 and keep their gaps
        self.damage = tuple(one for one in messages.damage if _concerns(one, first, last))
        self._to_end = last == messages.frames.ticks[-1]
        self._frames = _by_chunk(frames)
        start = contents.messages(int(frames.chunks[0]))
        assert start is not None
        self._start_time = start[int(frames.places[0])][1].log_time
        self._end_time = self._start_time + round(1e9 * (last - first) * prepared.scene.tick)

    def write(self, stream: BinaryIO, entry: dict[str, str], progress: Progress) -> None:
        contents = self._contents
        metadata = contents.metadata | damage_entry(self.damage) | entry
        writer, channels = mcap_file.begin_copy(stream, contents, metadata, viewer_schemas(self._prepared))
        for number, messages in enumerate(contents.all_messages()):
            if number % _CHUNKS_A_STEP == 0:
                progress("Writing the part", 0.5 + 0.5 * number / len(contents.chunks))
            frames = self._frames(number)
            for place, (topic, message) in enumerate(messages or ()):
                for time, sequence in self._as_kept(topic, message, kept=place in frames):
                    if topic in channels:
                        writer.add_message(channels[topic], time, message.data, time, sequence)
        writer.finish()

    def _as_kept(self, topic: str, message: Message, *, kept: bool) -> Iterator[tuple[int, int]]:
        """Yield time and running number of a message in the new file; nothing if it does not belong there.

        Args:
            topic: Topic of the message.
            message: The message.
            kept: Whether it is one of the frames of the part.
        """
        time = message.log_time
        inside = self._start_time <= message.log_time <= self._end_time
        if topic == "/frame":
            if kept:
                yield time, message.sequence - self._number
        elif topic == "/failure":
            if self._to_end:
                yield time, message.sequence
        elif topic in ("/input", "/event"):
            if time <= self._end_time:
                yield time, message.sequence
        elif topic == ROBOT_TOPIC:
            yield max(time, self._start_time), message.sequence
        elif topic != "/mark" and inside:
            yield time, message.sequence


def _by_chunk(frames: FramePlaces) -> Callable[[int], frozenset[int]]:
    """Return a function that returns the indices of the frames among the messages of a chunk."""
    order = np.lexsort((frames.places, frames.chunks))
    chunks = frames.chunks[order]
    places = frames.places[order]

    def of(chunk: int) -> frozenset[int]:
        return frozenset(places[slice(*np.searchsorted(chunks, (chunk, chunk + 1)).tolist())].tolist())

    return of


def _concerns(damage: RecordingDamage, first: int, last: int) -> bool:
    """Whether the damage can affect these ticks: missing frames within them, missing inputs and events also before.

    Damage without a place in time (unreadable chunks, checksums) may affect any part.
    """
    if damage.first is None:
        return True
    if damage.first > last:
        return False
    return damage.kind not in _OF_FRAMES or damage.last is None or damage.last >= first


def trim_episodes(
    player: RecordingPlayer, folder: Path, *, overwrite: bool = False, progress: Progress = no_progress
) -> list[TrimResult]:
    """Write each labelled episode of a recording to its own file, "01 press.mcap", in a folder that may be new.

    Raises:
        RecordingError: No episode is labelled, and no folder is made; the folder cannot be made; or as ``trim``.
    """
    episodes = player.annotations().episodes
    if not episodes:
        remedy = "Label them in the window: Recording > Range as episode"
        raise RecordingError("no episode of the recording is labelled", file=player.path, remedy=remedy)
    make_output_folder(folder, error=RecordingError)
    for number, one in enumerate(episodes, start=1):  # check all before writing the first
        check_output(folder / episode_file_name(number, one), error=RecordingError, overwrite=overwrite)
    written = []
    for number, one in enumerate(episodes, start=1):
        own = part_of_progress(progress, (number - 1) / len(episodes), number / len(episodes))
        target = folder / episode_file_name(number, one)
        written.append(trim(player.path, target, first=one.first, last=one.last, overwrite=overwrite, progress=own))
    return written


def episode_file_name(number: int, episode: LabelledEpisode) -> str:
    """Return the file name of an episode: "01 press.mcap"."""
    label = re.sub(r"[^\w\-]+", " ", episode.label).strip()[:80]
    return f"{number:02d} {label or 'episode'}.mcap"
