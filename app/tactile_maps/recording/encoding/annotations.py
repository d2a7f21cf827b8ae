"""Annotations of a recording: named moments, episodes with label and instruction, and the outcome.

Moments that are marked while recording are messages of the recording itself. Later annotations go into a JSON file next
to it, ``demo.notes.json`` for ``demo.mcap``, so the recording is never modified. That file takes precedence. A
recording that was cut out of another one contains its part of the annotations in its metadata.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path

from tactile_maps.core.codec import LATER, dump_json, load_json
from tactile_maps.core.errors import RecordingError
from tactile_maps.core.files import read_bounded_file, write_atomically

ANNOTATIONS = "annotations"
"""Key in the metadata of a recording that was cut out of another one."""
MOST_TEXT = 2000
"""Maximum number of characters of a name, label or instruction."""
_MOST_BYTES = 4_000_000
_REMEDY = "Delete the file to use the recording without its notes"


class Outcome(StrEnum):
    """Outcome of a demonstration."""

    SUCCESS = "success"
    FAILURE = "failure"


@dataclass(frozen=True)
class Mark:
    """A moment with a name.

    Attributes:
        tick: Tick of the displayed frame.
        name: Name for display.
    """

    tick: int
    name: str

    def __post_init__(self) -> None:
        _check_text(self.name, "name")


@dataclass(frozen=True)
class LabelledEpisode:
    """A part of a recording that is one demonstration.

    Attributes:
        first: First tick.
        last: Last tick.
        label: Label of a word or two.
        instruction: The task in words, as given to a policy.
        outcome: Outcome; None if it is not set.
    """

    first: int
    last: int
    label: str
    instruction: str = ""
    outcome: Outcome | None = None

    def __post_init__(self) -> None:
        if self.last < self.first:
            value = f"ticks {self.first} to {self.last}"
            raise RecordingError("an episode ends before it begins", value=value, remedy="Give its first tick first")
        _check_text(self.label, "label")
        _check_text(self.instruction, "instruction")


@dataclass(frozen=True)
class Annotations:
    """All annotations of one recording.

    Attributes:
        marks: Marks, sorted by tick.
        episodes: Episodes, sorted by first tick.
        label: Label of the whole recording.
        outcome: Outcome of the whole recording; None if it is not set.
        recording: Start of the recording [ns since 1970, in decimal], which identifies it: a later recording may have
            the same file name. Empty for any.
    """

    marks: tuple[Mark, ...] = ()
    episodes: tuple[LabelledEpisode, ...] = ()
    label: str = ""
    outcome: Outcome | None = None
    recording: str = field(default="", compare=False, metadata=LATER)

    def __post_init__(self) -> None:
        _check_text(self.label, "label")

    def with_mark(self, mark: Mark) -> Annotations:
        """Return a copy with ``mark``, which replaces a mark at the same tick."""
        others = [other for other in self.marks if other.tick != mark.tick]
        return replace(self, marks=tuple(sorted([*others, mark], key=lambda one: one.tick)))

    def without_mark(self, mark: Mark) -> Annotations:
        """Return a copy without ``mark``."""
        return replace(self, marks=tuple(other for other in self.marks if other != mark))

    def with_episode(self, episode: LabelledEpisode) -> Annotations:
        """Return a copy with ``episode``, which replaces an episode of the same ticks."""
        others = [one for one in self.episodes if (one.first, one.last) != (episode.first, episode.last)]
        return replace(self, episodes=tuple(sorted([*others, episode], key=lambda one: (one.first, one.last))))

    def without_episode(self, episode: LabelledEpisode) -> Annotations:
        """Return a copy without ``episode``."""
        return replace(self, episodes=tuple(other for other in self.episodes if other != episode))

    def within(self, first: int, last: int) -> Annotations:
        """Return the annotations of the ticks ``first`` to ``last``; episodes are clipped to them."""
        kept = [one for one in self.episodes if one.first <= last and one.last >= first]
        return replace(
            self,
            marks=tuple(mark for mark in self.marks if first <= mark.tick <= last),
            episodes=tuple(replace(one, first=max(one.first, first), last=min(one.last, last)) for one in kept),
        )


def _check_text(text: str, name: str) -> None:
    if len(text) > MOST_TEXT:
        remedy = f"The maximum is {MOST_TEXT} characters"
        raise RecordingError("the text is too long", place=name, value=f"{len(text)} characters", remedy=remedy)


def annotations_file(recording: str | Path) -> Path:
    """Return the path of the annotations of a recording."""
    return Path(recording).with_suffix(".notes.json")


def load_annotations(recording: str | Path, *, of: str = "") -> Annotations | None:
    """Return the annotations in the file next to a recording; None if there is none.

    Args:
        recording: File of the recording.
        of: Start of the recording, as in ``Annotations.recording``; empty to skip the check.

    Raises:
        RecordingError: The file is damaged, of another format, or of another recording.
    """
    file = annotations_file(recording)
    if not os.path.exists(file):
        return None
    data = read_bounded_file(file, error=RecordingError, most=_MOST_BYTES)
    found = load_json(Annotations, data, error=RecordingError, file=file, remedy=_REMEDY)
    if of and found.recording and found.recording != of:
        raise RecordingError("the notes belong to another recording of this name", file=file, remedy=_REMEDY)
    return found


def save_annotations(recording: str | Path, annotations: Annotations, *, of: str = "") -> None:
    """Write the annotations atomically to the file next to a recording; ``of`` as in ``load_annotations``.

    Raises:
        RecordingError: The file cannot be written.
    """
    kept = dump_json(replace(annotations, recording=of))
    write_atomically(annotations_file(recording), kept, error=RecordingError)


def annotations_entry(annotations: Annotations) -> dict[str, str]:
    """Return annotations as an entry of a recording's metadata."""
    return {ANNOTATIONS: dump_json(annotations).decode()}


def annotations_in(metadata: dict[str, str], marks: tuple[Mark, ...], *, file: str) -> Annotations:
    """Return the annotations in a recording's metadata, or else the marks that were set while recording.

    Raises:
        RecordingError: The entry of the metadata is invalid.
    """
    text = metadata.get(ANNOTATIONS)
    if text is not None:
        return load_json(Annotations, text, error=RecordingError, place=ANNOTATIONS, file=file)
    found = Annotations()
    for mark in marks:
        found = found.with_mark(mark)
    return found
