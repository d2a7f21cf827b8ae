"""The MCAP file of a recording: begun by whoever writes one, and read without trust: complete, cut off, or hostile."""

from __future__ import annotations

import io
import os
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, DataEnd, Footer, Message, Metadata, Statistics
from mcap.stream_reader import breakup_chunk
from mcap.writer import Writer

from app.core.errors import RecordingError
from app.core.files import check_output, open_regular_file
from app.recording.encoding.message_codecs import TOPICS
from app.recording.encoding.viewer_messages import ENCODING, Schema
from app.session.bundle import MEDIA_TYPES

FORMAT = "11"
"""Of the messages; another one is not read."""
_METADATA = "tactile-maps"
STARTED = "started_ns"
"""Of the metadata: wall-clock time of tick 0 [ns since 1970]."""
MEASURED = "measured"
"""Of the metadata: where the readings of a real skin came from. Such a recording has no frame for every tick."""
_NUMBERED_TOPICS = tuple(topic for topic in TOPICS if topic != "/mark")
"""Whose channels have the numbers 1, 2, ... in every file; that of marks is known by its record alone."""
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
_UNSURE = "What the recording was made with cannot be trusted; take a copy from before the damage"


def create_file(path: Path, *, overwrite: bool) -> BinaryIO:
    """A new file to write to.

    Raises:
        RecordingError: It exists already, or cannot be made.
    """
    target = check_output(path, error=RecordingError, overwrite=overwrite)
    try:
        return target.open("wb" if overwrite else "xb")
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
    for topic, said in TOPICS.items():
        schema = writer.register_schema(said.name, said.schema_encoding, said.schema)
        channels[topic] = writer.register_channel(topic, said.encoding, schema)
    return channels


def add_viewer_channels(writer: Writer, schemas: Mapping[str, Schema]) -> Mapping[str, int]:
    """Announce the topics for viewers of other programs, by their schemas; each topic's channel."""
    numbers = {
        schema: writer.register_schema(schema.name, schema.encoding, schema.data)
        for schema in dict.fromkeys(schemas.values())
    }
    return {topic: writer.register_channel(topic, ENCODING, numbers[schema]) for topic, schema in schemas.items()}


@dataclass
class RecordingContents:
    """The records of one file. Mutable only while it is being read.

    Attributes:
        attachments: Data by name; each matches its checksum.
        metadata: Of this program; empty when the file has none.
        channels: Topic by channel id.
        chunks: Compressed, in order; each holds messages. None where one was and cannot be read.
        written: How many messages each channel was given, as the file's end says; empty where that is lost.
        complete: Whether the file ends as it should.
        checksum_fails: Whether the data or the summary does not match its checksum.
    """

    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, str] = field(default_factory=dict)
    channels: dict[int, str] = field(default_factory=lambda: dict(enumerate(_NUMBERED_TOPICS, start=1)))
    chunks: list[Chunk | None] = field(default_factory=list)
    written: dict[int, int] = field(default_factory=dict)
    complete: bool = False
    checksum_fails: bool = False


def read_recording(path: str | Path) -> RecordingContents:
    """Read all there is. Where a record cannot be read, go on at the next chunk that the file's index knows.

    Raises:
        RecordingError: The file cannot be opened, is not MCAP at all, its messages are of another format, or an
            attachment does not match its checksum.
    """
    path, contents = Path(path), RecordingContents()
    with open_regular_file(path, error=RecordingError) as stream:
        if stream.read(len(_MAGIC)) != _MAGIC:
            raise RecordingError("this is not a recording", file=path, remedy="Recordings are .mcap files")
        for record in _Records(stream, os.fstat(stream.fileno()).st_size):
            _collect(record, contents, path)
    found = contents.metadata.get("format", FORMAT)
    if found != FORMAT:
        remedy = f"This program reads format {FORMAT}; replay it with the version that made it"
        raise RecordingError("the recording has another format", file=path, value=found, remedy=remedy)
    return contents


@dataclass(frozen=True)
class _Record:
    """One record as it stands in the file.

    Attributes:
        opcode: Its kind.
        body: Its bytes.
        checksum: CRC-32 of the bytes before it in its section: the data up to their end, then the summary.
    """

    opcode: int
    body: bytes
    checksum: int


_FRAMING = struct.Struct("<BQ")
"""Opcode and length of a record, https://mcap.dev/spec."""
_END = 0
"""Stands for the magic bytes after the last record; no record has this opcode."""
_FOOTER_BYTES = _FRAMING.size + 20 + len(_MAGIC)
_CHUNK_INDEX_OFFSET = struct.Struct("<QQQ")
"""Of a chunk index: the first and the last time in the chunk, and where it stands."""


class _Records:
    """The records of a stream that stands behind the file's first eight bytes, each as far as it can be read.

    A record whose length cannot be, and all behind it up to the next chunk of the index, is one unreadable chunk: None.
    The MCAP library's own reader stops there, and checks no attachment's checksum.
    """

    def __init__(self, stream: BinaryIO, size: int) -> None:
        self._stream, self._size = stream, size

    def __iter__(self) -> Iterator[_Record | None]:
        at, checksum = len(_MAGIC), zlib.crc32(_MAGIC)
        while True:
            head = self._stream.read(_FRAMING.size)
            if len(head) < _FRAMING.size:
                return
            opcode, length = _FRAMING.unpack(head)
            if not 0 < opcode <= Opcode.DATA_END or length > min(MAX_RECORD, self._size - at - len(head)):
                following = [offset for offset in self._chunk_offsets() if offset > at]
                if not following:
                    return
                yield None
                at = min(following)
                self._stream.seek(at)
                continue
            body = self._stream.read(length)
            yield _Record(opcode, body, checksum)
            checksum = 0 if opcode == Opcode.DATA_END else zlib.crc32(body, zlib.crc32(head, checksum))
            at += len(head) + length
            if opcode == Opcode.FOOTER and self._stream.read() == _MAGIC:
                yield _Record(_END, b"", 0)
            if opcode == Opcode.FOOTER:
                return

    def _chunk_offsets(self) -> list[int]:
        """Where chunks begin, by the index at the file's end; nothing where that is not whole."""
        back = self._stream.tell()
        try:
            self._stream.seek(max(self._size - _FOOTER_BYTES, 0))
            end = self._stream.read(_FOOTER_BYTES)
            if len(end) < _FOOTER_BYTES or not end.endswith(_MAGIC) or end[0] != Opcode.FOOTER:
                return []
            footer = Footer.read(ReadDataStream(io.BytesIO(end[_FRAMING.size :])))
            length = self._size - _FOOTER_BYTES - footer.summary_start
            if not 0 < length <= MAX_RECORD:
                return []
            self._stream.seek(footer.summary_start)
            summary = self._stream.read(length)
            if zlib.crc32(summary + end[: _FRAMING.size + 16]) != footer.summary_crc:
                return []
            return list(_indexed_chunks(summary))
        finally:
            self._stream.seek(back)


def _indexed_chunks(summary: bytes) -> Iterator[int]:
    """Offsets of chunks in a summary section that matches its checksum."""
    at = 0
    while at + _FRAMING.size <= len(summary):
        opcode, length = _FRAMING.unpack_from(summary, at)
        at += _FRAMING.size
        if opcode == Opcode.CHUNK_INDEX:
            yield _CHUNK_INDEX_OFFSET.unpack_from(summary, at)[2]
        at += length


_KINDS: Mapping[int, Callable[[ReadDataStream], object]] = {
    Opcode.ATTACHMENT: Attachment.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.CHUNK: Chunk.read,
    Opcode.DATA_END: DataEnd.read,
    Opcode.FOOTER: Footer.read,
    Opcode.METADATA: Metadata.read,
    Opcode.STATISTICS: Statistics.read,
}


def _collect(found: _Record | None, contents: RecordingContents, file: Path) -> None:
    """Keep what is ours of a record."""
    if found is None:
        contents.chunks.append(None)
        return
    contents.complete |= found.opcode == _END
    if found.opcode not in _KINDS:
        return
    try:
        record = _KINDS[found.opcode](ReadDataStream(io.BytesIO(found.body)))
    except _DAMAGE:
        record = None
    if isinstance(record, Attachment):
        if zlib.crc32(found.body[:-4]) != int.from_bytes(found.body[-4:], "little"):
            problem = "an attachment of the recording does not match its checksum"
            raise RecordingError(problem, file=file, place=record.name, remedy=_UNSURE)
        contents.attachments[record.name] = record.data
    elif isinstance(record, Metadata):
        if record.name == _METADATA:
            contents.metadata = dict(record.metadata)
    elif isinstance(record, Channel):
        contents.channels[record.id] = record.topic
    elif isinstance(record, Chunk) or found.opcode == Opcode.CHUNK:
        contents.chunks.append(record if isinstance(record, Chunk) else None)
    elif isinstance(record, Statistics):
        contents.written = dict(record.channel_message_counts)
    elif isinstance(record, DataEnd):
        contents.checksum_fails |= record.data_section_crc not in (0, found.checksum)
    elif isinstance(record, Footer):
        whole = _FRAMING.pack(found.opcode, len(found.body)) + found.body[:16]
        contents.checksum_fails |= record.summary_crc not in (0, zlib.crc32(whole, found.checksum))


def chunk_messages(chunk: Chunk | None, channels: dict[int, str]) -> list[tuple[str, Message]] | None:
    """Topic and message of everything in a chunk; channels it declares are learnt. None where it cannot be read."""
    if chunk is None or not _is_sane(chunk):
        return None
    try:
        records = breakup_chunk(chunk, validate_crc=True)
    except _DAMAGE:
        return None
    found = []
    for record in records:
        if isinstance(record, Channel):
            channels[record.id] = record.topic
        elif isinstance(record, Message):
            found.append((channels.get(record.channel_id, ""), record))
    return found


def _is_sane(chunk: Chunk) -> bool:
    """Whether its content can be checked, and unpacking it takes a bounded amount of memory."""
    if not chunk.uncompressed_crc or chunk.uncompressed_size > MAX_CHUNK or chunk.compression not in ("", "zstd"):
        return False
    if chunk.compression == "zstd":
        try:
            return int(zstandard.frame_content_size(chunk.data)) <= MAX_CHUNK
        except zstandard.ZstdError:
            return False
    return True
