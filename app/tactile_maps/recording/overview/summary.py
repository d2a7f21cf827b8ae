"""What a recording is, for a list of recordings: its facts and a small picture, from a few frames of the file."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.errors import RecordingError, TactileMapsError
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.pressure_colours import colour_image, rounded_scale
from tactile_maps.recording.encoding.annotations import Annotations, annotations_in, load_annotations
from tactile_maps.recording.encoding.frame_codec import decode_frame
from tactile_maps.recording.file import mcap_file
from tactile_maps.session.bundle import unpack_scene
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene

THUMBNAIL_WIDTH = 96
_LOOKED_AT = 12
"""Chunks of a recording that its summary looks into."""
MOST_SUMMARISED_BYTES = 2_000_000_000


@dataclass(frozen=True, eq=False)
class RecordingSummary:
    """What a list of recordings shows of one.

    Attributes:
        path: The file.
        size: Bytes.
        modified: When it was written [s since 1970].
        seconds: From its first frame to its last; None where it could not be read.
        robot: Its name; empty where it could not be read.
        scene: Its name for people.
        taxels: How many.
        annotations: What is said of it, but for marks that were set while it was recorded.
        picture: (h, w, 3) uint8, the tactile image at the strongest touch that was looked at; None for none.
        problem: What is wrong with it, for people; empty for nothing.
    """

    path: Path
    size: int
    modified: float
    seconds: float | None = None
    robot: str = ""
    scene: str = ""
    taxels: int = 0
    annotations: Annotations = field(default_factory=Annotations)
    picture: NDArray[np.uint8] | None = None
    problem: str = ""


def summarise(path: str | Path) -> RecordingSummary:
    """Look into a recording; one that cannot be read says why. Cost: 0.3 s, and to read the file once."""
    path = Path(path)
    try:
        known = path.stat()
    except OSError as error:
        return RecordingSummary(path, 0, 0.0, problem=f"The file cannot be read: {error.strerror}")
    blank = RecordingSummary(path, known.st_size, known.st_mtime)
    if known.st_size > MOST_SUMMARISED_BYTES:
        return RecordingSummary(path, known.st_size, known.st_mtime, problem="Too large to be looked into here")
    try:
        return _summary(blank)
    except TactileMapsError as error:
        return RecordingSummary(path, known.st_size, known.st_mtime, problem=str(error))


def _summary(blank: RecordingSummary) -> RecordingSummary:
    path = blank.path
    file = str(blank.path)
    contents = mcap_file.read_recording(path)
    prepared = unpack_scene(contents.attachments, file=file)
    frames = _some_frames(contents, prepared, file)
    if not frames:
        raise contents.no_frame()
    problem = ""
    said = annotations_in(contents.metadata, (), file=file)
    if contents.being_recorded and not contents.complete:
        problem = "It is being recorded"
    elif not contents.complete or contents.checksum_fails or None in contents.chunks:
        problem = "Damaged: it was cut off, or parts of it cannot be read. Open it to see what is lost"
    try:
        said = load_annotations(path, of=contents.metadata.get(mcap_file.STARTED, "")) or said
    except RecordingError as error:
        problem = str(error)
    return RecordingSummary(
        path,
        blank.size,
        blank.modified,
        (frames[-1].tick - frames[0].tick) * prepared.scene.tick,
        prepared.robot.name,
        prepared.scene.title or prepared.scene.name,
        len(prepared.skin),
        said,
        _picture(frames, prepared),
        problem,
    )


def _some_frames(contents: mcap_file.RecordingContents, prepared: PreparedScene, file: str) -> list[Frame]:
    """The recording's first frame, its last, and one of each chunk between that is looked into."""
    count = len(contents.chunks)
    # Before the first frame and behind the last there may be chunks of other messages.
    first = next((at for at in range(count) if _frame_data(contents, at)), None)
    last = next((at for at in reversed(range(count)) if _frame_data(contents, at)), None)
    if first is None or last is None:
        return []
    between = np.unique(np.linspace(first, last, min(_LOOKED_AT, last - first + 1)).astype(int)).tolist()
    data = [own[0] for at in between if (own := _frame_data(contents, at))] + _frame_data(contents, last)[-1:]
    frames = {frame.tick: frame for frame in (decode_frame(one, prepared, file=file) for one in data)}
    return [frames[tick] for tick in sorted(frames)]


def _frame_data(contents: mcap_file.RecordingContents, chunk: int) -> list[bytes]:
    """The frames' messages of a chunk."""
    return [message.data for topic, message in contents.messages(chunk) or () if topic == "/frame"]


def _picture(frames: list[Frame], prepared: PreparedScene) -> NDArray[np.uint8]:
    strongest = max(frames, key=lambda frame: float(np.nanmax(frame.pressures, initial=0.0)))
    scale = rounded_scale(1e-3 * float(np.nanmax(strongest.pressures, initial=0.0)))
    image = TactileImage(prepared.map, width=THUMBNAIL_WIDTH)
    return np.ascontiguousarray(colour_image(image, strongest.pressures, scale))
