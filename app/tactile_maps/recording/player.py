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
from tactile_maps.recording.file.damage import RecordingDamage
from tactile_maps.recording.file.messages import read_messages
from tactile_maps.session import bundle
from tactile_maps.session.frame import Frame
from tactile_maps.session.inputs import MapEdited, SessionInput
from tactile_maps.session.runtime_settings import CHANGES, RuntimeSettings, runtime_settings_at
from tactile_maps.tactile.poke import PokePressed, PokeReleased

_CHUNKS_KEPT = 2
"""Unpacked chunks in memory. Frames are usually read one after the other."""


class RecordingPlayer:
    """A recording, indexed. Frames are read from the file on demand, so memory does not grow with its size.

    Args:
        path: The file; one that was cut off or damaged is read as far as it goes.
        progress: Told what is being done and how far it is, 0 to 1.

    Attributes:
        prepared: The scene, robot, skin and map it was made with.
        times: (n,) simulated seconds of the frames.
        inputs: (tick, input) of everything that was done, from the session's start.
        recorded_annotations: What the file says of itself: marks set while it was recorded, and of a part of another
            recording what was said of that. See ``annotations`` for what was said since.
        events: What contacts began or ended to do, oldest first.
        versions: Programs' versions when it was made.
        damage: All that is missing, repeated or cannot be believed, in the order of ticks as far as it has any.
        failure: The tick at which the session stopped by itself, and why; None when it did not.

    Raises:
        RecordingError: The file cannot be read, is not ours, or holds no frame.

    Cost: about 0.1 s to open, and 20 ms for each second recorded with 1000 taxels.
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
        """Where the readings of a real skin came from; None where they were simulated."""
        return self.versions.get(mcap_file.MEASURED)

    @property
    def began(self) -> str:
        """When its session began [ns since 1970, in decimal]; empty where the file does not say."""
        return self.versions.get(mcap_file.STARTED, "")

    @property
    def complete(self) -> bool:
        """Whether every tick from the first to the last is there, with all inputs and events, and the file's end."""
        return not self.damage

    def __getstate__(self) -> dict[str, object]:
        """For another process: all but the frames that are unpacked."""
        return {name: value for name, value in vars(self).items() if name not in ("_unpacked", "_changes")}

    def __setstate__(self, state: dict[str, object]) -> None:
        """From another process: pickling forgets that arrays are read-only."""
        vars(self).update(state)
        for value in (self.prepared, self._start, self.inputs, self.times):
            refreeze(value)
        self._unpacked = lru_cache(maxsize=_CHUNKS_KEPT)(self._unpack)

    def __len__(self) -> int:
        return len(self._frames)

    def __iter__(self) -> Iterator[Frame]:
        """All frames in order, each unpacked when its turn comes."""
        return map(self.frame, range(len(self)))

    @property
    def duration(self) -> float:
        """From the first frame to the last [s]."""
        return float(self.times[-1] - self.times[0])

    def frame(self, number: int) -> Frame:
        """Return frame ``number``, from 0. Cost: about 0.2 ms.

        Raises:
            RecordingError: It is damaged, or the file was removed or changed since it was opened.
        """
        chunk = int(self._frames.chunks[number])
        place = int(self._frames.places[number])
        frame = decode_frame(self._unpacked(chunk)[place], self.prepared, file=str(self.path))
        known = bisect_right(self.events, frame.tick, key=lambda event: event.tick)
        return (
            replace(frame, recent=tuple(self.events[max(known - RECENT_EVENTS, 0) : known][::-1])) if known else frame
        )

    def number_at(self, seconds: float) -> int:
        """The frame shown ``seconds`` after the first, clamped to the ends."""
        return int(
            np.clip(np.searchsorted(self.times, self.times[0] + seconds + 1e-9, side="right") - 1, 0, len(self) - 1)
        )

    def tick_at(self, seconds: float) -> int:
        """Of the frame shown ``seconds`` after the first."""
        return round(float(self.times[self.number_at(seconds)]) / self.prepared.scene.tick)

    def seconds_at(self, tick: int) -> float:
        """When a tick is [s since the first frame], within the recording."""
        return float(np.clip(tick * self.prepared.scene.tick - self.times[0], 0.0, self.duration))

    def runtime_settings_at(self, tick: int) -> RuntimeSettings:
        """By what the session ran at one of its ticks: as its scene says, and as it had been changed by then."""
        return runtime_settings_at(self._start, self._changes, tick)

    @cached_property
    def _changes(self) -> list[tuple[int, SessionInput]]:
        """Of thousands of inputs the few that change settings: every frame that is shown asks for those in force."""
        return [(tick, session_input) for tick, session_input in self.inputs if isinstance(session_input, CHANGES)]

    def annotations(self) -> Annotations:
        """What is said of it: the file beside it, else what it holds itself.

        Raises:
            RecordingError: The file beside it is damaged, or none of ours.
        """
        beside = load_annotations(self.path, of=self.began)
        return self.recorded_annotations if beside is None else beside

    def edits(self) -> list[tuple[float, str]]:
        """When the map was edited [s since the first frame] and the edits' names, for marks on a timeline."""
        tick = self.prepared.scene.tick
        first = float(self.times[0])
        found = [
            (at * tick - first, session_input.name)
            for at, session_input in self.inputs
            if isinstance(session_input, MapEdited)
        ]
        return [(seconds, name) for seconds, name in found if 0 <= seconds <= self.duration]

    def poke_spans(self) -> list[tuple[float, float]]:
        """Times [s] since the first frame between which a finger was on the skin, for marks on a timeline."""
        tick = self.prepared.scene.tick
        down: dict[int, int] = {}
        spans: list[tuple[int, int]] = []
        for at, session_input in self.inputs:
            if isinstance(session_input, PokePressed):
                down.setdefault(session_input.id, at)
            elif isinstance(session_input, PokeReleased) and session_input.id in down:
                spans.append((down.pop(session_input.id), at))
        last = round(float(self.times[-1]) / tick)
        spans += [(start, last) for start in down.values()]
        first = float(self.times[0])
        shown = [(start * tick - first, end * tick - first) for start, end in spans]
        return [(max(start, 0.0), min(end, self.duration)) for start, end in shown if end > 0 and start < self.duration]

    def damaged_spans(self) -> list[tuple[float, float, RecordingDamage]]:
        """From and to when [s since the first frame] something was lost, within the recording, for a timeline."""
        tick = self.prepared.scene.tick
        first = float(self.times[0])
        spans = []
        for damage in self.damage:
            if damage.first is not None:
                end = self.duration if damage.last is None else (damage.last + 1) * tick - first
                start = damage.first * tick - first
                spans.append((min(max(start, 0.0), self.duration), min(max(end, 0.0), self.duration), damage))
        return spans

    def _unpack(self, chunk: int) -> dict[int, bytes]:
        """Frames of a chunk by their index among its messages."""
        messages = self._contents.messages(chunk)
        if messages is None:
            raise RecordingError(mcap_file.CHANGED, file=self.path, remedy=mcap_file.REOPEN)
        return {place: message.data for place, (topic, message) in enumerate(messages) if topic == "/frame"}


def open_recording(path: str | Path) -> RecordingPlayer:
    """A recording's scene, frames and inputs; one that was cut off or damaged is read as far as it goes.

    Args:
        path: The file.

    Raises:
        RecordingError: It cannot be read, is not ours, or holds no frame.

    Example:
        >>> player = tm.open_recording("touch.mcap")
        >>> len(player), round(player.duration, 3)
        (21, 0.1)
        >>> player.frame(20).tick
        20
    """
    return RecordingPlayer(path)
