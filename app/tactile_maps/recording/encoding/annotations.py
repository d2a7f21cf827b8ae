"""What a person says of a recording: moments with a name, episodes with label and instruction, how it ended.

Moments that are marked while recording are messages of the recording itself. What is said afterwards goes into a JSON
file beside it, ``demo.notes.json`` for ``demo.mcap``: the recording is never touched. Where that file is, it is what
holds; a recording that was cut out of another has its part of them in its metadata.
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
"""Of the metadata of a recording that was cut out of another."""
MOST_TEXT = 2000
"""Characters of a name, label or instruction."""
_MOST_BYTES = 4_000_000
_REMEDY = "Delete the file to use the recording without its notes"


class Outcome(StrEnum):
    """How a demonstration ended."""

    SUCCESS = "success"
    FAILURE = "failure"


@dataclass(frozen=True)
class Mark:
    """A moment with a name.

    Attributes:
        tick: Of the frame that was shown.
        name: For people.
    """

    tick: int
    name: str

    def __post_init__(self) -> None:
        _check_text(self.name, "name")


@dataclass(frozen=True)
class LabelledEpisode:
    """A part of a recording that is one demonstration.

    Attributes:
        first: Its first tick.
        last: Its last tick.
        label: What it is, in a word or two.
        instruction: What was to be done, in words, as a policy is told.
        outcome: How it ended; None where nobody says.
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
    """All that is said of one recording.

    Attributes:
        marks: By tick.
        episodes: By first tick.
        label: Of the whole.
        outcome: Of the whole; None where nobody says.
        recording: When that began [ns since 1970, in decimal]: a file of its name that was recorded anew is another
            one. Empty for any.
    """

    marks: tuple[Mark, ...] = ()
    episodes: tuple[LabelledEpisode, ...] = ()
    label: str = ""
    outcome: Outcome | None = None
    recording: str = field(default="", compare=False, metadata=LATER)

    def __post_init__(self) -> None:
        _check_text(self.label, "label")

    def with_mark(self, mark: Mark) -> Annotations:
        """With one more; one at the same tick gives way to it."""
        others = [other for other in self.marks if other.tick != mark.tick]
        return replace(self, marks=tuple(sorted([*others, mark], key=lambda one: one.tick)))

    def without_mark(self, mark: Mark) -> Annotations:
        """Without it."""
        return replace(self, marks=tuple(other for other in self.marks if other != mark))

    def with_episode(self, episode: LabelledEpisode) -> Annotations:
        """With one more; one of the same ticks gives way to it."""
        others = [one for one in self.episodes if (one.first, one.last) != (episode.first, episode.last)]
        return replace(self, episodes=tuple(sorted([*others, episode], key=lambda one: (one.first, one.last))))

    def without_episode(self, episode: LabelledEpisode) -> Annotations:
        """Without it."""
        return replace(self, episodes=tuple(other for other in self.episodes if other != episode))

    def within(self, first: int, last: int) -> Annotations:
        """Of the ticks ``first`` to ``last`` alone; episodes that reach beyond are cut there."""
        kept = [one for one in self.episodes if one.first <= last and one.last >= first]
        return replace(
            self,
            marks=tuple(mark for mark in self.marks if first <= mark.tick <= last),
            episodes=tuple(replace(one, first=max(one.first, first), last=min(one.last, last)) for one in kept),
        )


def _check_text(text: str, what: str) -> None:
    if len(text) > MOST_TEXT:
        remedy = f"The most is {MOST_TEXT} characters"
        raise RecordingError("the text is too long", place=what, value=f"{len(text)} characters", remedy=remedy)


def annotations_file(recording: str | Path) -> Path:
    """Where what is said of a recording is kept."""
    return Path(recording).with_suffix(".notes.json")


def load_annotations(recording: str | Path, *, of: str = "") -> Annotations | None:
    """What was said of a recording after it was made; None where nothing was.

    Args:
        recording: Its file.
        of: When it began, as in ``Annotations.recording``; empty not to ask.

    Raises:
        RecordingError: The file with it is damaged, none of ours, or of another recording.
    """
    file = annotations_file(recording)
    if not os.path.exists(file):
        return None
    data = read_bounded_file(file, error=RecordingError, most=_MOST_BYTES)
    found = load_json(Annotations, data, error=RecordingError, file=file, remedy=_REMEDY)
    if of and found.recording and found.recording != of:
        raise RecordingError("these notes are of another recording that had this name", file=file, remedy=_REMEDY)
    return found


def save_annotations(recording: str | Path, annotations: Annotations, *, of: str = "") -> None:
    """Keep what is said of a recording beside it, whole or not at all; ``of`` as for ``load_annotations``.

    Raises:
        RecordingError: It cannot be written there.
    """
    kept = dump_json(replace(annotations, recording=of))
    write_atomically(annotations_file(recording), kept, error=RecordingError)


def annotations_entry(annotations: Annotations) -> dict[str, str]:
    """The same as an entry of a recording's metadata."""
    return {ANNOTATIONS: dump_json(annotations).decode()}


def annotations_in(metadata: dict[str, str], marks: tuple[Mark, ...], *, file: str) -> Annotations:
    """What a recording holds itself, with the marks that were set while it was made.

    Raises:
        RecordingError: The entry of the metadata is none of ours.
    """
    text = metadata.get(ANNOTATIONS)
    if text is not None:
        return load_json(Annotations, text, error=RecordingError, place=ANNOTATIONS, file=file)
    found = Annotations()
    for mark in marks:
        found = found.with_mark(mark)
    return found
