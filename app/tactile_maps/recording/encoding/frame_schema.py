"""Protobuf message that contains a frame as one field of bytes, described in the file.

Viewers of other programs reject channels with an unknown encoding and report an error. All of them know Protobuf and
skip fields of bytes. The comment of the descriptor describes the bytes.
"""

from __future__ import annotations

import struct

FIELD = 1
"""Number of the field ``data``."""
_LENGTH_DELIMITED = 2
_TAG = FIELD << 3 | _LENGTH_DELIMITED
PREFIX_BYTES = 6
"""Size of the prefix: the field's tag, and its length always in five bytes, which Protobuf allows."""
_PREFIX = struct.Struct("<B5B")
_SYNTAX = "proto3"
_MESSAGE = 4
_OPTIONAL = 1
_BYTES = 12
"""Numbers from descriptor.proto: the syntax, FileDescriptorProto.message_type, and a field's label and type."""


def prefix(length: int) -> bytes:
    """Return the prefix of ``length`` bytes of data."""
    return _PREFIX.pack(_TAG, *(length >> 7 * place & 0x7F | (0x80 if place < 4 else 0) for place in range(5)))


def has_prefix(message: bytes) -> bool:
    """Whether a message is one complete field of bytes."""
    return message[:PREFIX_BYTES] == prefix(max(len(message) - PREFIX_BYTES, 0))


def descriptor(package: str, name: str, comment: str) -> bytes:
    """Return a FileDescriptorSet with one message, ``bytes data = 1``, and a comment on it; see descriptor.proto."""
    data = _text(1, "data") + _number(3, FIELD) + _number(4, _OPTIONAL) + _number(5, _BYTES) + _text(10, "data")
    location = _bytes(1, bytes([_MESSAGE, 0])) + _bytes(2, bytes(3)) + _text(3, comment)
    file = (
        _text(1, f"{package}/{name}.proto")
        + _text(2, package)
        + _bytes(_MESSAGE, _text(1, name) + _bytes(2, data))
        + _bytes(9, _bytes(1, location))
        + _text(12, _SYNTAX)
    )
    return _bytes(1, file)


def _number(field: int, value: int) -> bytes:
    return _varint(field << 3) + _varint(value)


def _text(field: int, value: str) -> bytes:
    return _bytes(field, value.encode())


def _bytes(field: int, value: bytes) -> bytes:
    return _varint(field << 3 | _LENGTH_DELIMITED) + _varint(len(value)) + value


def _varint(value: int) -> bytes:
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*out, value])
