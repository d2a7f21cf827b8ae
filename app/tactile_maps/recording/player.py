"""A recording opened for replay: frames by number, inputs by tick."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np

from tactile_maps.contacts.events import RECENT_EVENTS
from tactile_maps.core.arrays import refreeze
from tactile_maps.core.errors import RecordingError
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.recording.encoding.annotations import Annotations, annotations_in, load_annotations
from tactile_maps.recording.encoding.frame_codec import decode_frame
from tactile_maps.recording.file import mcap_file
from tactile_maps.recording.file.damage import RecordingDamage, damage_text
from tactile_maps.recording.file.messages import read_messages
from tactile_maps.session import bundle
from tactile_maps.session.frame import Frame
from tactile_maps.session.inputs import MapEdited, SessionInput
from tactile_maps.session.runtime_settings import CHANGES, RuntimeSettings, runtime_settings_at
from tactile_maps.tactile.poke import PokePressed, PokeReleased

_CHUNKS_KEPT = 2
"""Number of unpacked chunks in memory. Frames are usually read in order."""


class RecordingPlayer:
    """An indexed recording. Frames are read from the file on demand, so memory use does not depend on its size.

    Args:
        path: The file; a damaged one is read as far as possible.
        progress: Receives a description and the progress, 0 to 1.

    Attributes:
        prepared: Scene, robot, skin and map of the recording.
        times: (n,) simulated times of the frames [s].
        inputs: (tick, input) of all inputs, from the session's start.
        recorded_annotations: Annotations in the file itself: marks set while recording, or, in a part of another
            recording, its annotations. ``annotations`` includes later ones.
        events: Contact events, oldest first.
        versions: Metadata, with the versions of the programs.
        damage: All that is missing, repeated or invalid, by tick if it has one.
        failure: Tick and error at which the session stopped by itself; None if it did not.

    Raises:
        RecordingError: The file cannot be read, is not a recording, or contains no frame.

    Cost: about 0.1 s to open, and 20 ms for each recorded second with 1000 taxels.
    """

    def __init__(self, path: str | Path, *, progress: Progress = no_progress) -> None:
        self.path = Path(path)
        file = str(path)
        contents = mcap_file.read_recording(path)
        self._contents = contents
        self.versions = contents.metadata
        self.prepared = bundle.unpack_scene(contents.attachments, file=file)
        self._start = RuntimeSettings.of_scene(self.prepared)
        messages = read_messages(contents, self.prepared, file=file, progress=progress)
        if not len(messages.frames):
            raise contents.no_frame()
        self.inputs = messages.inputs
        self.events = messages.events
        self.failure = messages.failure
        self.damage = messages.damage
        self.recorded_annotations = annotations_in(contents.metadata, messages.marks, file=file)
        self._frames = messages.frames
        self.times = self.prepared.scene.tick * messages.frames.ticks
        self._unpacked = lru_cache(maxsize=_CHUNKS_KEPT)(self._unpack)

    @property
    def measured(self) -> str | None:
        """Source of a real skin's readings; None if they were simulated."""
        return self.versions.get(mcap_file.MEASURED)

    @property
    def began(self) -> str:
        """Start of the session [ns since 1970, in decimal]; empty if the file does not state it."""
        return self.versions.get(mcap_file.STARTED, "")

    @property
    def complete(self) -> bool:
        """Whether the recording has no damage."""
        return not self.damage

    def __getstate__(self) -> dict[str, object]:
        """Exclude unpacked frames when pickling for another process."""
        return {name: value for name, value in vars(self).items() if name not in ("_unpacked", "_changes")}

    def __setstate__(self, state: dict[str, object]) -> None:
        """Restore the read-only flags of arrays, which are lost in pickling."""
        vars(self).update(state)
        for value in (self.prepared, self._start, self.inputs, self.times):
            refreeze(value)
        self._unpacked = lru_cache(maxsize=_CHUNKS_KEPT)(self._unpack)

    def __len__(self) -> int:
        return len(self._frames)

    def __iter__(self) -> Iterator[Frame]:
        """Iterate over all frames in order; each is unpacked on demand."""
        return map(self.frame, range(len(self)))

    @property
    def duration(self) -> float:
        """Time from the first frame to the last [s]."""
        return float(self.times[-1] - self.times[0])

    def frame(self, number: int) -> Frame:
        """Return frame ``number``, from 0. Cost: about 0.2 ms.

        Raises:
            RecordingError: The frame is damaged, or the file was removed or changed since it was opened.
        """
        chunk = int(self._frames.chunks[number])
        place = int(self._frames.places[number])
        frame = decode_frame(self._unpacked(chunk)[place], self.prepared, file=str(self.path))
        known = bisect_right(self.events, frame.tick, key=lambda event: event.tick)
        recent = self.events[max(known - RECENT_EVENTS, 0) : known][::-1]
        return replace(frame, recent=tuple(recent)) if recent else frame

    def number_at(self, seconds: float) -> int:
        """Return the number of the frame at ``seconds`` after the first, clamped to the recording."""
        number = np.searchsorted(self.times, self.times[0] + seconds + 1e-9, side="right") - 1
        return int(np.clip(number, 0, len(self) - 1))

    def tick_at(self, seconds: float) -> int:
        """Return the tick of the frame at ``seconds`` after the first."""
        return round(float(self.times[self.number_at(seconds)]) / self.prepared.scene.tick)

    def seconds_at(self, tick: int) -> float:
        """Return the time of a tick [s since the first frame], clamped to the recording."""
        return float(np.clip(tick * self.prepared.scene.tick - self.times[0], 0.0, self.duration))

    def runtime_settings_at(self, tick: int) -> RuntimeSettings:
        """Return the settings of the session at a tick: those of its scene with the changes up to then."""
        return runtime_settings_at(self._start, self._changes, tick)

    @cached_property
    def _changes(self) -> list[tuple[int, SessionInput]]:
        """The inputs that change settings, a few of thousands: every displayed frame needs the current settings."""
        return [(tick, session_input) for tick, session_input in self.inputs if isinstance(session_input, CHANGES)]

    def annotations(self) -> Annotations:
        """Return the annotations in the file next to the recording, or else those in the recording.

        Raises:
            RecordingError: The file next to it is damaged or invalid.
        """
        found = load_annotations(self.path, of=self.began)
        return self.recorded_annotations if found is None else found

    def _seconds(self, tick: int) -> float:
        """Return the time of a tick [s since the first frame], which may be outside of the recording."""
        return tick * self.prepared.scene.tick - float(self.times[0])

    def edits(self) -> list[tuple[float, str]]:
        """Return time [s since the first frame] and name of the map edits, for a timeline."""
        found = [(self._seconds(tick), item.name) for tick, item in self.inputs if isinstance(item, MapEdited)]
        return [(seconds, name) for seconds, name in found if 0 <= seconds <= self.duration]

    def poke_spans(self) -> list[tuple[float, float]]:
        """Return start and end [s since the first frame] of each press of a finger on the skin, for a timeline."""
        down: dict[int, int] = {}
        spans: list[tuple[int, int]] = []
        for at, session_input in self.inputs:
            if isinstance(session_input, PokePressed):
                down.setdefault(session_input.id, at)
            elif isinstance(session_input, PokeReleased) and session_input.id in down:
                spans.append((down.pop(session_input.id), at))
        last = round(float(self.times[-1]) / self.prepared.scene.tick)
        spans += [(start, last) for start in down.values()]
        times = [(self._seconds(start), self._seconds(end)) for start, end in spans]
        return [(max(start, 0.0), min(end, self.duration)) for start, end in times if end > 0 and start < self.duration]

    @property
    def damage_texts(self) -> tuple[str, ...]:
        """Descriptions of ``damage``, with times since the first frame."""
        return tuple(map(self._damage_text, self.damage))

    def _damage_text(self, damage: RecordingDamage) -> str:
        return damage_text(damage, self.prepared.scene.tick, begins=float(self.times[0]))

    def damaged_spans(self) -> list[tuple[float, float, str]]:
        """Return start and end [s since the first frame] and descriptions of damage, for a timeline.

        They are clamped to the recording.
        """
        spans = []
        for damage in self.damage:
            if damage.first is not None:
                end = self.duration if damage.last is None else self.seconds_at(damage.last + 1)
                spans.append((self.seconds_at(damage.first), end, self._damage_text(damage)))
        return spans

    def _unpack(self, chunk: int) -> dict[int, bytes]:
        """Return the frames of a chunk by their index among its messages."""
        messages = self._contents.messages(chunk)
        if messages is None:
            raise RecordingError(mcap_file.CHANGED, file=self.path, remedy=mcap_file.REOPEN)
        return {place: message.data for place, (topic, message) in enumerate(messages) if topic == "/frame"}


def open_recording(path: str | Path) -> RecordingPlayer:
    """Open a recording; a damaged one is read as far as possible.

    Args:
        path: The file.

    Raises:
        RecordingError: The file cannot be read, is not a recording, or contains no frame.

    Example:
        >>> player = tm.open_recording("touch.mcap")
        >>> len(player), round(player.duration, 3)
        (21, 0.1)
        >>> player.frame(20).tick
        20
    """
    return RecordingPlayer(path)
