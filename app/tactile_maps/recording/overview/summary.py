"""Summary of a recording for a list: its facts and a small picture, from a few frames of the file."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.errors import RecordingError, TactileMapsError
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.recording.encoding.annotations import Annotations, annotations_in, load_annotations
from tactile_maps.recording.encoding.frame_codec import decode_frame
from tactile_maps.recording.file import mcap_file
from tactile_maps.session.bundle import unpack_scene
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene

THUMBNAIL_WIDTH = 96
_LOOKED_AT = 12
"""Number of chunks from which a summary reads a frame."""
MOST_SUMMARISED_BYTES = 2_000_000_000


@dataclass(frozen=True, eq=False)
class RecordingSummary:
    """Summary of a recording for a list.

    Attributes:
        path: The file.
        modified: Time of the last change [s since 1970].
        seconds: Time from its first frame to its last [s]; None if it cannot be read.
        robot: Name of the robot; empty if it cannot be read.
        scene: Name of the scene for display.
        taxels: Number of taxels.
        annotations: Annotations, except marks that were set while recording.
        picture: (h, w) float32, the tactile image [kPa] at the strongest touch among the read frames, NaN off the skin
            and where a taxel has no reading; None if the recording cannot be read.
        problem: Description of the problem; empty if there is none.
    """

    path: Path
    modified: float
    seconds: float | None = None
    robot: str = ""
    scene: str = ""
    taxels: int = 0
    annotations: Annotations = field(default_factory=Annotations)
    picture: NDArray[np.float32] | None = None
    problem: str = ""


def summarise(path: str | Path) -> RecordingSummary:
    """Return the summary of a recording; that of an unreadable one states the reason.

    Cost: 0.3 s, and to read the file once.
    """
    path = Path(path)
    try:
        known = path.stat()
    except OSError as error:
        return RecordingSummary(path, 0.0, problem=f"The file cannot be read: {error.strerror}")
    blank = RecordingSummary(path, known.st_mtime)
    if known.st_size > MOST_SUMMARISED_BYTES:
        return replace(blank, problem="Too large for a summary")
    try:
        return _summary(blank)
    except TactileMapsError as error:
        return replace(blank, problem=str(error))


def _summary(blank: RecordingSummary) -> RecordingSummary:
    path = blank.path
    file = str(blank.path)
    contents = mcap_file.read_recording(path)
    prepared = unpack_scene(contents.attachments, file=file)
    frames = _some_frames(contents, prepared, file)
    if not frames:
        raise contents.no_frame()
    problem = ""
    annotations = annotations_in(contents.metadata, (), file=file)
    if contents.being_recorded and not contents.complete:
        problem = "It is being recorded"
    elif not contents.complete or contents.checksum_fails or None in contents.chunks:
        problem = "Damaged: it was cut off, or parts of it cannot be read. Open it to see what is lost"
    try:
        annotations = load_annotations(path, of=contents.metadata.get(mcap_file.STARTED, "")) or annotations
    except RecordingError as error:
        problem = str(error)
    return replace(
        blank,
        seconds=(frames[-1].tick - frames[0].tick) * prepared.scene.tick,
        robot=prepared.robot.name,
        scene=prepared.scene.title or prepared.scene.name,
        taxels=len(prepared.skin),
        annotations=annotations,
        picture=_picture(frames, prepared),
        problem=problem,
    )


def _some_frames(contents: mcap_file.RecordingContents, prepared: PreparedScene, file: str) -> list[Frame]:
    """Return the recording's first and last frame, and one of each selected chunk between."""
    count = len(contents.chunks)
    # Chunks of other messages may precede the first frame and follow the last.
    first = next((at for at in range(count) if _frame_data(contents, at)), None)
    last = next((at for at in reversed(range(count)) if _frame_data(contents, at)), None)
    if first is None or last is None:
        return []
    between = np.unique(np.linspace(first, last, min(_LOOKED_AT, last - first + 1)).astype(int)).tolist()
    data = [own[0] for at in between if (own := _frame_data(contents, at))] + _frame_data(contents, last)[-1:]
    frames = {frame.tick: frame for frame in (decode_frame(one, prepared, file=file) for one in data)}
    return [frames[tick] for tick in sorted(frames)]


def _frame_data(contents: mcap_file.RecordingContents, chunk: int) -> list[bytes]:
    """Return the messages of the frames in a chunk."""
    return [message.data for topic, message in contents.messages(chunk) or () if topic == "/frame"]


def _picture(frames: list[Frame], prepared: PreparedScene) -> NDArray[np.float32]:
    strongest = max(frames, key=lambda frame: frame.highest_pressure)
    image = TactileImage(prepared.map, width=THUMBNAIL_WIDTH)
    return np.where(image.shown, image.render(strongest.pressures), np.nan).astype(np.float32)
