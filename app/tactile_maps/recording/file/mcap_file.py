"""The MCAP file of a recording: its beginning, and reading without trust: complete, cut off, or hostile."""

from __future__ import annotations

import io
import os
import struct
import zlib
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import BinaryIO, NamedTuple, TypeVar

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, DataEnd, Footer, Header, Message, Metadata, Statistics
from mcap.writer import CompressionType, Writer

from tactile_maps.core.errors import RecordingError
from tactile_maps.core.files import is_locked, open_regular_file
from tactile_maps.recording.encoding.message_codecs import TOPICS
from tactile_maps.recording.encoding.viewer_messages import ENCODING, Schema
from tactile_maps.session.bundle import DAMAGED, MEDIA_TYPES

FORMAT = "11"
"""Version of the messages; others are not read."""
_METADATA = _LIBRARY = "tactile-maps"
STARTED = "started_ns"
"""Key in the metadata: wall-clock time of tick 0 [ns since 1970]."""
MEASURED = "measured"
"""Key in the metadata: source of a real skin's readings. Such a recording does not have a frame for every tick."""
_NUMBERED_TOPICS = tuple(topic for topic in TOPICS if topic != "/mark")
"""Topics whose channels have the numbers 1, 2, ... in every file; the channel of marks is known only by its record."""
NO_SPACE = "Free space or choose another folder; what was written so far can be read with recover"
"""Remedy for a file that cannot grow."""
CHANGED = "the recording was changed since it was opened"
REOPEN = "Open it again; do not change or move a recording while it is open"
_COPY_CHUNK_BYTES = 1_000_000
MAX_CHUNK = 128_000_000
"""Maximum size of a chunk, compressed and uncompressed [bytes]. This program writes chunks of about a megabyte; the
largest contain the surfaces of a robot for viewers.
"""
MAX_RECORD = 500_000_000
"""Maximum size of any other record [bytes]."""
MAX_CHUNK_RECORDS = 200_000
"""Maximum number of records in a chunk."""
_UNPACKED_BASE = 2_000_000_000
_UNPACKED_RATIO = 1000
"""All chunks together may unpack to ``_UNPACKED_BASE`` bytes plus this many for each byte of the file. Idle skin of
10,000 taxels compresses to about 1 : 400.
"""
_MESSAGES_BASE = 20_000
_BYTES_PER_MESSAGE = 32
"""A file may contain ``_MESSAGES_BASE`` messages, plus one for each 32 bytes. The writer spends 16 bytes of index on
each.
"""
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
"""Errors of the MCAP library for damaged bytes."""
_MAGIC = b"\x89MCAP0\r\n"
_UNSURE = "The scene of the recording cannot be trusted; use a copy from before the damage"


def begin_recording(writer: Writer, metadata: Mapping[str, str], attachments: Mapping[str, bytes]) -> Mapping[str, int]:
    """Write the metadata, attachments and channels, which precede the messages.

    Args:
        writer: Writer of a new file.
        metadata: Facts that the numbers depend on; the format is added.
        attachments: Data by name, see ``bundle``.

    Returns:
        Channel of each topic.
    """
    writer.start(profile="", library=_LIBRARY)
    writer.add_metadata(_METADATA, {**metadata, "format": FORMAT})
    for name, data in attachments.items():
        writer.add_attachment(0, 0, name, MEDIA_TYPES.get(name, "application/octet-stream"), data)
    channels = {}
    for topic, description in TOPICS.items():
        schema = writer.register_schema(description.name, description.schema_encoding, description.schema)
        channels[topic] = writer.register_channel(topic, description.encoding, schema)
    return channels


def add_viewer_channels(writer: Writer, schemas: Mapping[str, Schema]) -> Mapping[str, int]:
    """Register the topics for viewers of other programs by their schemas; return the channel of each."""
    numbers = {
        schema: writer.register_schema(schema.name, schema.encoding, schema.data)
        for schema in dict.fromkeys(schemas.values())
    }
    return {topic: writer.register_channel(topic, ENCODING, numbers[schema]) for topic, schema in schemas.items()}


def begin_copy(
    stream: BinaryIO, contents: RecordingContents, metadata: Mapping[str, str], schemas: Mapping[str, Schema]
) -> tuple[Writer, Mapping[str, int]]:
    """Begin a copy of a recording, with channels for viewers if it has them.

    Args:
        stream: The new file.
        contents: The recording.
        metadata: Metadata of the copy.
        schemas: Schemas of the topics for viewers.

    Returns:
        The writer, and the channel of each topic.
    """
    writer = Writer(stream, chunk_size=_COPY_CHUNK_BYTES, compression=CompressionType.ZSTD, enable_data_crcs=True)
    channels = begin_recording(writer, metadata, contents.attachments)
    if not schemas.keys().isdisjoint(contents.channels.values()):
        channels = {**channels, **add_viewer_channels(writer, schemas)}
    return writer, channels


class ChunkPlace(NamedTuple):
    """Location of a chunk record in the file: offset and length of its body, and the checksum of its messages."""

    offset: int
    length: int
    checksum: int


@dataclass
class RecordingContents:
    """The records of one file, except the chunks, which are read from the file on demand. Mutable while it is read.

    Attributes:
        path: The file.
        attachments: Data by name; each matches its checksum.
        metadata: Metadata of this program; empty when the file has none.
        channels: Topic by channel id.
        chunks: Locations of the chunks, in order; None for a chunk that cannot be located or parsed.
        written: Number of messages written on each channel, from the end of the file; empty where that is lost.
        complete: Whether the end of the file is intact.
        ours: Whether the header names this program.
        being_recorded: Whether a recorder had the file locked when it was read.
        trailing: Number of bytes after the end.
        checksum_fails: Whether the data or the summary does not match its checksum.
    """

    path: Path
    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, str] = field(default_factory=dict)
    channels: dict[int, str] = field(default_factory=lambda: dict(enumerate(_NUMBERED_TOPICS, start=1)))
    chunks: list[ChunkPlace | None] = field(default_factory=list)
    written: dict[int, int] = field(default_factory=dict)
    complete: bool = False
    ours: bool = False
    being_recorded: bool = False
    trailing: int = 0
    checksum_fails: bool = False

    def no_frame(self) -> RecordingError:
        """Return the error of a recording without a frame."""
        if self.complete or self.chunks:
            return RecordingError("the recording contains no frame", file=self.path, remedy=DAMAGED)
        if self.being_recorded:
            remedy = "Open it again once the recorder has written more"
            problem = "the recording has just begun and contains no frame yet"
            return RecordingError(problem, file=self.path, remedy=remedy)
        problem = "the recording was cut off before its first complete frame"
        return RecordingError(problem, file=self.path, remedy="Nothing can be recovered from it; record again")

    def chunk(self, number: int) -> Chunk | None:
        """Return a chunk as stored; None where it cannot be parsed.

        Raises:
            RecordingError: The file cannot be opened, or was changed since ``read_recording``.
        """
        with open_regular_file(self.path, error=RecordingError) as stream:
            return self._read_chunk(stream, number)

    def messages(self, number: int) -> list[tuple[str, Message]] | None:
        """Return topic and message of everything in a chunk; None where it cannot be read.

        Raises:
            RecordingError: Same as for ``chunk``, or the chunk holds too many records.
        """
        return chunk_messages(self.chunk(number), self.channels, file=self.path)

    def all_messages(self) -> Iterator[list[tuple[str, Message]] | None]:
        """Yield ``messages`` of each chunk in order, one chunk in memory at a time.

        Raises:
            RecordingError: Same as for ``messages``, or the file contains more messages than its size allows.
        """
        total = 0
        with open_regular_file(self.path, error=RecordingError) as stream:
            most = _MESSAGES_BASE + os.fstat(stream.fileno()).st_size // _BYTES_PER_MESSAGE
            for number in range(len(self.chunks)):
                messages = chunk_messages(self._read_chunk(stream, number), self.channels, file=self.path)
                total += len(messages or ())
                if total > most:
                    problem = "the recording contains more messages than its size allows"
                    remedy = f"The maximum for a file of this size is {most}"
                    raise RecordingError(problem, file=self.path, place=f"chunk {number}", value=total, remedy=remedy)
                yield messages

    def _read_chunk(self, stream: BinaryIO, number: int) -> Chunk | None:
        place = self.chunks[number]
        if place is None:
            return None
        stream.seek(place.offset)
        chunk = _parsed(Chunk.read, stream.read(place.length))
        if chunk is None or chunk.uncompressed_crc != place.checksum:
            raise RecordingError(CHANGED, file=self.path, remedy=REOPEN)
        return chunk


def read_recording(path: str | Path) -> RecordingContents:
    """Read everything but the chunks, of which only the locations are kept.

    After a record that cannot be read, reading continues at the next chunk in the file's index.

    Raises:
        RecordingError: The file cannot be opened, is not MCAP at all, its messages are of another format, an
            attachment does not match its checksum, it was cut off before its first frame, or its chunks claim an
            implausible size.
    """
    path = Path(path)
    contents = RecordingContents(path)
    unpacked = 0
    with open_regular_file(path, error=RecordingError) as stream:
        contents.being_recorded = is_locked(stream.fileno())
        start = stream.read(len(_MAGIC))
        if start != _MAGIC and _MAGIC.startswith(start):
            raise contents.no_frame()
        if start != _MAGIC:
            raise RecordingError("this is not a recording (no MCAP header)", file=path, remedy="Give an .mcap file")
        size = os.fstat(stream.fileno()).st_size
        most = _UNPACKED_BASE + _UNPACKED_RATIO * size
        for record in _Records(stream, size):
            unpacked += _collect(record, contents)
            if record is not None and record.opcode == _END:
                contents.trailing = size - record.offset - len(_MAGIC)
            if unpacked > most:
                problem = "the recording would unpack to an implausible size"
                place = f"chunk {len(contents.chunks) - 1}"
                remedy = f"The maximum for a file of this size is {most} bytes"
                raise RecordingError(problem, file=path, place=place, value=f"{unpacked} bytes", remedy=remedy)
    found = contents.metadata.get("format", FORMAT)
    if found != FORMAT:
        remedy = f"This program reads format {FORMAT}; replay it with the version that made it"
        raise RecordingError("the recording has another format", file=path, value=found, remedy=remedy)
    whole = contents.complete or contents.chunks or contents.attachments.keys() >= MEDIA_TYPES.keys()
    if contents.ours and not whole:
        raise contents.no_frame()
    return contents


@dataclass(frozen=True)
class _Record:
    """A record as stored in the file.

    Attributes:
        opcode: Its kind.
        body: Its bytes.
        offset: Location of the body in the file.
        checksum: CRC-32 of the bytes before it in its section: the data up to their end, then the summary.
    """

    opcode: int
    body: bytes
    offset: int
    checksum: int


_FRAMING = struct.Struct("<BQ")
"""Opcode and length of a record, https://mcap.dev/spec."""
_END = 0
"""Denotes the magic bytes after the last record; no record has this opcode."""
_FOOTER_BYTES = _FRAMING.size + 20 + len(_MAGIC)
_CHUNK_INDEX_OFFSET = struct.Struct("<QQQ")
"""Start of a chunk index: the first and the last time in the chunk, and the chunk's offset."""
_MESSAGE_HEAD = struct.Struct("<HIQQ")
"""Start of a message: channel, running number, log time and publish time."""


class _Records:
    """Iterates over the records of a stream positioned after the file's first eight bytes, as far as it can be read.

    A record with an invalid length, and everything after it up to the next chunk of the index, is reported as one
    unreadable chunk: None. The MCAP library's own reader stops there, and does not check the checksums of attachments.
    """

    def __init__(self, stream: BinaryIO, size: int) -> None:
        self._stream = stream
        self._size = size
        self._offsets: list[int] | None = None  # read when first needed: an intact file never needs it

    def __iter__(self) -> Iterator[_Record | None]:
        at = len(_MAGIC)
        checksum = zlib.crc32(_MAGIC)
        while True:
            head = self._stream.read(_FRAMING.size)
            if len(head) < _FRAMING.size:
                return
            opcode, length = _FRAMING.unpack(head)
            most = MAX_CHUNK if opcode == Opcode.CHUNK else MAX_RECORD
            if not 0 < opcode <= Opcode.DATA_END or length > min(most, self._size - at - len(head)):
                offsets = self._chunk_offsets()
                following = bisect_right(offsets, at)
                if following == len(offsets):
                    return
                yield None
                at = offsets[following]
                self._stream.seek(at)
                continue
            body = self._stream.read(length)
            yield _Record(opcode, body, at + len(head), checksum)
            checksum = 0 if opcode == Opcode.DATA_END else zlib.crc32(body, zlib.crc32(head, checksum))
            at += len(head) + length
            if opcode == Opcode.FOOTER and self._stream.read(len(_MAGIC)) == _MAGIC:
                yield _Record(_END, b"", at, 0)
            if opcode == Opcode.FOOTER:
                return

    def _chunk_offsets(self) -> list[int]:
        """Sorted offsets of the chunks in the index at the file's end; empty where that is not intact."""
        if self._offsets is None:
            back = self._stream.tell()
            self._offsets = sorted(set(self._indexed_chunks()))
            self._stream.seek(back)
        return self._offsets

    def _indexed_chunks(self) -> list[int]:
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
        return [
            _CHUNK_INDEX_OFFSET.unpack_from(summary, start)[2]
            for opcode, start, end_ in _split(summary)
            if opcode == Opcode.CHUNK_INDEX and end_ - start >= _CHUNK_INDEX_OFFSET.size
        ]


def _split(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, start and end of the body of each record in a sequence of records.

    Raises:
        ValueError: A record ends behind the data.
    """
    at = 0
    while at < len(data):
        if at + _FRAMING.size > len(data):
            raise ValueError("a record is cut off")
        opcode, length = _FRAMING.unpack_from(data, at)
        start = at + _FRAMING.size
        at = start + length
        if at > len(data):
            raise ValueError("a record is cut off")
        yield opcode, start, at


_KINDS: Mapping[int, Callable[[ReadDataStream], object]] = {
    Opcode.ATTACHMENT: Attachment.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.CHUNK: Chunk.read,
    Opcode.DATA_END: DataEnd.read,
    Opcode.FOOTER: Footer.read,
    Opcode.HEADER: Header.read,
    Opcode.METADATA: Metadata.read,
    Opcode.STATISTICS: Statistics.read,
}
_R = TypeVar("_R")


def _parsed(read: Callable[[ReadDataStream], _R], body: bytes) -> _R | None:
    """Parse the body of a record; None where it is damaged."""
    try:
        return read(ReadDataStream(io.BytesIO(body)))
    except _DAMAGE:
        return None


def _collect(found: _Record | None, contents: RecordingContents) -> int:
    """Keep the relevant part of a record; return the number of bytes that it claims to unpack to."""
    if found is None:
        contents.chunks.append(None)
        return 0
    contents.complete |= found.opcode == _END
    if found.opcode not in _KINDS:
        return 0
    record = _parsed(_KINDS[found.opcode], found.body)
    if isinstance(record, Attachment):
        if zlib.crc32(found.body[:-4]) != int.from_bytes(found.body[-4:], "little"):
            problem = "an attachment of the recording does not match its checksum"
            raise RecordingError(problem, file=contents.path, place=record.name, remedy=_UNSURE)
        contents.attachments[record.name] = record.data
    elif isinstance(record, Metadata):
        if record.name == _METADATA:
            contents.metadata = dict(record.metadata)
    elif isinstance(record, Header):
        contents.ours = record.library == _LIBRARY
    elif isinstance(record, Channel):
        contents.channels[record.id] = record.topic
    elif isinstance(record, Chunk):
        contents.chunks.append(ChunkPlace(found.offset, len(found.body), record.uncompressed_crc))
        return min(record.uncompressed_size, MAX_CHUNK)  # a chunk that claims more is not unpacked
    elif found.opcode == Opcode.CHUNK:
        contents.chunks.append(None)
    elif isinstance(record, Statistics):
        contents.written = dict(record.channel_message_counts)
    elif isinstance(record, DataEnd):
        contents.checksum_fails |= record.data_section_crc not in (0, found.checksum)
    elif isinstance(record, Footer):
        whole = _FRAMING.pack(found.opcode, len(found.body)) + found.body[:16]
        contents.checksum_fails |= record.summary_crc not in (0, zlib.crc32(whole, found.checksum))
    return 0


def chunk_messages(
    chunk: Chunk | None, channels: dict[int, str], *, file: Path | None = None
) -> list[tuple[str, Message]] | None:
    """Return topic and message of everything in a chunk; None where it cannot be read.

    Args:
        chunk: The chunk as stored.
        channels: Topic by channel id; channels that the chunk declares are added.
        file: The recording, for errors.

    Raises:
        RecordingError: The chunk holds more than ``MAX_CHUNK_RECORDS`` records.
    """
    if chunk is None or (data := _unpacked(chunk)) is None:
        return None
    try:
        records = list(islice(_split(data), MAX_CHUNK_RECORDS + 1))
        if len(records) > MAX_CHUNK_RECORDS:
            problem = "a chunk of the recording contains too many messages"
            remedy = f"The maximum is {MAX_CHUNK_RECORDS}"
            raise RecordingError(problem, file=file, value=f"more than {MAX_CHUNK_RECORDS}", remedy=remedy)
        found = []
        for opcode, start, end in records:
            if opcode == Opcode.CHANNEL:
                channel = Channel.read(ReadDataStream(io.BytesIO(data[start:end])))
                channels[channel.id] = channel.topic
            elif opcode == Opcode.MESSAGE:
                if end - start < _MESSAGE_HEAD.size:
                    return None
                channel_id, sequence, logged, published = _MESSAGE_HEAD.unpack_from(data, start)
                body = data[start + _MESSAGE_HEAD.size : end]
                found.append((channels.get(channel_id, ""), Message(channel_id, logged, body, published, sequence)))
    except _DAMAGE:
        return None
    return found


def _unpacked(chunk: Chunk) -> bytes | None:
    """Return the records of a chunk; None where they would not fit the chunk's own statements or ``MAX_CHUNK``."""
    size = chunk.uncompressed_size
    if not chunk.uncompressed_crc or size > MAX_CHUNK:
        return None
    data = chunk.data
    try:
        if chunk.compression == "zstd":
            if zstandard.frame_content_size(data) not in (-1, size):
                return None
            data = zstandard.decompress(data, size)
        elif chunk.compression:
            return None
    except _DAMAGE:
        return None
    return data if len(data) == size and zlib.crc32(data) == chunk.uncompressed_crc else None
