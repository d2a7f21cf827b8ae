"""The MCAP file of a recording: begun by whoever writes one, and read without trust: complete, cut off, or hostile."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

import zstandard
from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Chunk, Footer, McapRecord, Message, Metadata
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import Writer

from app.core.errors import RecordingError
from app.recording.bundle import MEDIA_TYPES
from app.recording.message_codecs import TOPICS

FORMAT = "7"
"""Of the messages; another one is not read."""
_METADATA = "tactile-maps"
NO_SPACE = "Free space or choose another folder; what was written so far can be read with recover"
"""What to do when a file takes no more bytes."""
MAX_CHUNK = 256_000_000
MAX_RECORD = 1_500_000_000
_DAMAGE = (
    McapError,
    zstandard.ZstdError,
    struct.error,
    EOFError,
    ValueError,
    KeyError,
    AssertionError,
    OverflowError,
    MemoryError,
)
"""What reading damaged bytes may raise in the MCAP library."""
_MAGIC = b"\x89MCAP0\r\n"


def create_file(path: Path, *, overwrite: bool) -> BinaryIO:
    """A new file to write to.

    Raises:
        RecordingError: It exists already, or cannot be made.
    """
    try:
        return path.open("wb" if overwrite else "xb")
    except FileExistsError as error:
        remedy = "Choose another name, or overwrite it"
        raise RecordingError("the file already exists", file=path, remedy=remedy) from error
    except OSError as error:
        remedy = "Choose a folder you may write to"
        raise RecordingError("the recording cannot be written", file=path, value=error.strerror, remedy=remedy) from (
            error
        )


def begin_recording(writer: Writer, metadata: Mapping[str, str], attachments: Mapping[str, bytes]) -> Mapping[str, int]:
    """Write what goes before the messages.

    Args:
        writer: Of a new file.
        metadata: The format and what the numbers depend on.
        attachments: Data by name, see ``bundle``.

    Returns:
        Each topic's channel.
    """
    writer.start(profile="", library="tactile-maps")
    writer.add_metadata(_METADATA, {**metadata, "format": FORMAT})
    for name, data in attachments.items():
        writer.add_attachment(0, 0, name, MEDIA_TYPES.get(name, "application/octet-stream"), data)
    channels = {}
    for topic, (name, text, encoding) in TOPICS.items():
        schema = writer.register_schema(name, "jsonschema", text.encode())
        channels[topic] = writer.register_channel(topic, encoding, schema)
    return channels


@dataclass
class RecordingContents:
    """The records of one file. Mutable only while it is being read.

    Attributes:
        attachments: Data by name.
        metadata: Of this program; empty when the file has none.
        channels: Topic by channel id.
        chunks: Compressed, in order; each holds messages.
        complete: Whether the file ends as it should.
    """

    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, str] = field(default_factory=dict)
    channels: dict[int, str] = field(default_factory=dict)
    chunks: list[Chunk] = field(default_factory=list)
    complete: bool = False


def read_recording(path: str | Path) -> RecordingContents:
    """Read all there is, up to the first damage.

    Raises:
        RecordingError: The file cannot be opened, is not MCAP at all, or its messages are of another format.
    """
    path, contents = Path(path), RecordingContents()
    try:
        with path.open("rb") as stream:
            if stream.read(len(_MAGIC)) != _MAGIC:
                raise RecordingError("this is not a recording", file=path, remedy="Recordings are .mcap files")
            stream.seek(0)
            for record in _records(stream):
                _collect(record, contents)
    except OSError as error:
        value, remedy = error.strerror or error, "Check the path"
        raise RecordingError("the recording cannot be read", file=path, value=value, remedy=remedy) from error
    found = contents.metadata.get("format", FORMAT)
    if found != FORMAT:
        remedy = f"This program reads format {FORMAT}; replay it with the version that made it"
        raise RecordingError("the recording has another format", file=path, value=found, remedy=remedy)
    return contents


def _records(stream: BinaryIO) -> Iterator[McapRecord]:
    """Records up to the end or the first that cannot be read: a cut file ends in the middle of one."""
    records = StreamReader(stream, emit_chunks=True, record_size_limit=MAX_RECORD).records
    while True:
        try:
            yield next(records)
        except (StopIteration, *_DAMAGE):
            return


def _collect(record: McapRecord, contents: RecordingContents) -> None:
    if isinstance(record, Attachment):
        contents.attachments[record.name] = record.data
    elif isinstance(record, Metadata) and record.name == _METADATA:
        contents.metadata = dict(record.metadata)
    elif isinstance(record, Channel):
        contents.channels[record.id] = record.topic
    elif isinstance(record, Chunk):
        contents.chunks.append(record)
    elif isinstance(record, Footer):
        contents.complete = True


def chunk_messages(chunk: Chunk, channels: dict[int, str]) -> list[tuple[str, Message]]:
    """Topic and message of everything in a chunk; channels it declares are learnt. Empty where it is damaged."""
    if not _is_sane(chunk):
        return []
    try:
        records = breakup_chunk(chunk, validate_crc=True)
    except _DAMAGE:
        return []
    found = []
    for record in records:
        if isinstance(record, Channel):
            channels[record.id] = record.topic
        elif isinstance(record, Message):
            found.append((channels.get(record.channel_id, ""), record))
    return found


def _is_sane(chunk: Chunk) -> bool:
    """Whether unpacking the chunk takes a bounded amount of memory."""
    if chunk.uncompressed_size > MAX_CHUNK or chunk.compression not in ("", "zstd"):
        return False
    if chunk.compression == "zstd":
        try:
            return int(zstandard.frame_content_size(chunk.data)) <= MAX_CHUNK
        except zstandard.ZstdError:
            return False
    return True
