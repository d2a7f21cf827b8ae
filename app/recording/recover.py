"""Salvages a recording that was cut off: everything whole is written to a new, complete file."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from mcap.records import Message
from mcap.writer import CompressionType, Writer

from app.core.errors import RecordingError
from app.recording import mcap_file
from app.recording.bundle import DAMAGED


@dataclass(frozen=True)
class RecoveryResult:
    """What was saved.

    Attributes:
        frames: Frames in the new file.
        lost_frames: Frames missing between the first and the last saved one; how many followed the cut nobody knows.
        was_complete: Whether the file was whole to begin with.
        file: The new file.
    """

    frames: int
    lost_frames: int
    was_complete: bool
    file: str


def recover(source: str | Path, target: str | Path, *, overwrite: bool = False) -> RecoveryResult:
    """Copy what is whole in ``source`` to a complete recording ``target``.

    Raises:
        RecordingError: The source is no recording or holds no frame; the target exists or cannot be written.
    """
    source, target = Path(source), Path(target)
    if source.resolve() == target.resolve():
        raise RecordingError("a recording cannot be recovered into itself", file=target, remedy="Name another file")
    contents = mcap_file.read_recording(source)
    chunks = [mcap_file.chunk_messages(chunk, contents.channels) for chunk in contents.chunks]
    ticks = [message.sequence for chunk in chunks for topic, message in chunk if topic == "/frame"]
    if not ticks:
        raise RecordingError("nothing can be recovered: it has no complete frame", file=source, remedy=DAMAGED)
    try:
        with mcap_file.create_file(target, overwrite=overwrite) as stream:
            writer = Writer(stream, chunk_size=1_000_000, compression=CompressionType.ZSTD)
            _write(writer, contents, chunks)
    except OSError as error:
        problem = "the recovered recording cannot be written"
        raise RecordingError(problem, file=target, value=error, remedy=mcap_file.NO_SPACE) from error
    return RecoveryResult(len(ticks), ticks[-1] - ticks[0] + 1 - len(ticks), contents.complete, str(target))


def _write(writer: Writer, contents: mcap_file.RecordingContents, chunks: list[list[tuple[str, Message]]]) -> None:
    channels = mcap_file.begin_recording(writer, contents.metadata, contents.attachments)
    for topic, message in chain.from_iterable(chunks):
        if topic in channels:
            writer.add_message(channels[topic], message.log_time, message.data, message.publish_time, message.sequence)
    writer.finish()
