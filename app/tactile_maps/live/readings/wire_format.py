"""Packets of readings, format 1: JSON for simple senders, compact binary for large skins. Specified on the guide's page
*Live input*.

JSON: one object per packet, keys ``v`` (1), ``seq``, ``t`` [s], ``unit``, ``values``, and optionally ``ids`` or
``channels`` (pairs of module and channel), ``joints`` (positions by name) and ``token``. Other keys are rejected. Ids
are numbers, or texts ``link:id`` for a skin whose links repeat ids. A value of null, or NaN in a binary packet, means
that the taxel did not report. The value of a taxel with three axes is a list ``[p, t1, t2]``: pressure and shear.

Binary, little-endian, without padding: ``HEADER``, the token (UTF-8), int32 ids (n) or int32 pairs (n, 2) according to
``labels``, float32 values (n) or (n, 3), then for each joint a byte with the length of its name, the name (UTF-8) and a
float64.
"""

from __future__ import annotations

import hmac
import json
import math
import struct
from collections.abc import Callable
from typing import Any, cast

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.codec import parse_json
from tactile_maps.core.errors import LiveError, TactileMapsError
from tactile_maps.live.readings.readings import (
    MOST_VALUES,
    MalformedReadingError,
    Reading,
    Unit,
    labels_of,
    row_name,
    unit_of,
)

VERSION = 1
MAGIC = b"TMLR"
HEADER = struct.Struct("<4sBBBBIdIH")
"""Magic, version, labels (0 none, 1 ids, 2 channels; plus 4 for three values per taxel), unit (0 counts, 1 Pa, 2 kPa),
bytes of the token, sequence number, time [s], number of taxels, number of joints."""
_THREE = 4
"""Added to the labels where each taxel has three values."""
_UNITS = tuple(Unit)
_KEYS = {"v", "seq", "t", "unit", "values", "ids", "channels", "joints", "token"}
LARGEST_PACKET = 4_000_000


def encode_json(reading: Reading, *, token: str | None = None) -> bytes:
    """Return a packet as one line of JSON, without a line end."""
    fields: dict[str, Any] = {"v": VERSION, "t": reading.time, "unit": reading.unit.value}
    if reading.sequence is not None:
        fields["seq"] = reading.sequence
    for name in ("ids", "channels"):
        if (labels := getattr(reading, name)) is not None:
            fields[name] = labels.tolist()
    if reading.links is not None:
        fields["ids"] = [f"{link}:{number}" for link, number in zip(reading.links, fields["ids"], strict=True)]
    values: list[Any] = [None if math.isnan(value) else value for value in reading.values.tolist()]
    if reading.shear is not None:
        both = zip(values, reading.shear.tolist(), strict=True)
        values = [
            value
            if math.isnan(t1) and math.isnan(t2)
            else [value, *(None if math.isnan(one) else one for one in (t1, t2))]
            for value, (t1, t2) in both
        ]
    fields["values"] = values
    if reading.joints:
        fields["joints"] = dict(reading.joints)
    if token is not None:
        fields["token"] = token
    return json.dumps(fields, separators=(",", ":")).encode()


def encode_binary(reading: Reading, *, token: str | None = None) -> bytes:
    """Return a compact packet: 26 bytes, and 8 for each value with its id; 16 with shear. Values are float32.

    Raises:
        LiveError: The ids have links, which only JSON can state.
    """
    if reading.links is not None:
        raise LiveError("binary packets cannot state the links of ids", remedy="Send JSON (--json)")
    labels, which = (reading.ids, 1) if reading.ids is not None else (reading.channels, 2)
    secret = (token or "").encode()
    which = 0 if labels is None else which
    values = reading.values
    if reading.shear is not None:
        which += _THREE
        values = np.column_stack([values, reading.shear])
    unit = _UNITS.index(reading.unit)
    count = len(reading.values)
    sequence = 0 if reading.sequence is None else reading.sequence
    parts = [
        HEADER.pack(MAGIC, VERSION, which, unit, len(secret), sequence, reading.time, count, len(reading.joints)),
        secret,
        b"" if labels is None else labels.astype("<i4").tobytes(),
        values.astype("<f4").tobytes(),
    ]
    for name, position in reading.joints.items():
        text = name.encode()
        parts += [bytes([len(text)]), text, struct.pack("<d", position)]
    return b"".join(parts)


def decode(packet: bytes, *, token: str | None = None) -> Reading:
    """Return the reading of an untrusted packet, JSON or binary.

    Args:
        packet: One complete packet.
        token: Token that the packet must contain; None if none is required.

    Raises:
        MalformedReadingError: The packet is invalid, of another version, or does not contain the token.

    Cost: 5,000 values with ids 0.1 ms binary, 4 ms JSON.
    """
    if len(packet) > LARGEST_PACKET:
        raise MalformedReadingError("the packet is too large", value=f"{len(packet)} bytes")
    return _decode_binary(packet, token) if packet.startswith(MAGIC) else _decode_json(packet, token)


def is_plausible(packet: bytes) -> bool:
    """Return False for a packet that cannot be a reading by its first bytes. Cost: 0.3 µs."""
    if packet.startswith(MAGIC):
        return len(packet) >= HEADER.size and packet[len(MAGIC)] == VERSION
    return packet.lstrip().startswith(b"{")


def _check_token(found: object, required: str | None) -> None:
    if required is not None and not hmac.compare_digest(str(found or "").encode(), required.encode()):
        remedy = "Configure the sender to include this token in every packet"
        raise MalformedReadingError("the packet does not contain the token", place="token", remedy=remedy)


def _check_version(found: object) -> None:
    if found != VERSION or isinstance(found, bool):
        raise MalformedReadingError("unknown version of the packet", place="v", value=found, remedy="Send version 1")


def _decode_json(packet: bytes, token: str | None) -> Reading:
    try:
        fields = parse_json(packet)
    except (TactileMapsError, ValueError):
        fields = None
    if not isinstance(fields, dict):
        raise MalformedReadingError("the packet is not a JSON object", value=packet[:40])
    _check_token(fields.get("token"), token)
    _check_version(fields.get("v"))
    if more := fields.keys() - _KEYS:
        remedy = f"Allowed keys: {', '.join(sorted(_KEYS))}"
        raise MalformedReadingError("unknown key", place=min(more), remedy=remedy)
    joints = fields.get("joints", {})
    if not isinstance(joints, dict):
        raise MalformedReadingError("the joints are not an object", place="joints", value=joints)
    sequence = fields.get("seq")
    links, ids = _ids(fields)
    channels = _numbers(fields, "channels", np.int64) if "channels" in fields else None
    values, shear = _values(fields, lambda row: row_name(row, ids, links, channels))
    return Reading(
        _number(fields.get("t"), "t"),
        values,
        unit_of(fields.get("unit", "counts")),
        ids,
        channels,
        {name: _number(position, f"joints, {name}") for name, position in joints.items()},
        None if sequence is None else _sequence(sequence),
        links=links,
        shear=shear,
    )


def _ids(fields: dict[str, Any]) -> tuple[tuple[str, ...] | None, IntArray | None]:
    """Return the links and ids of a packet: all ids with their links, or all without."""
    ids = fields.get("ids")
    if not (isinstance(ids, list) and ids and all(isinstance(one, str) for one in ids)):
        return None, _numbers(fields, "ids", np.int64) if "ids" in fields else None
    return labels_of(ids)


def _number(value: object, place: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise MalformedReadingError("expected a number", place=place, value=value)
    try:
        return float(value)
    except OverflowError as error:
        raise MalformedReadingError("a number is too large", place=place) from error


def _sequence(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**32:
        raise MalformedReadingError("expected a whole number below 2³²", place="seq", value=value)
    return value


def _values(fields: dict[str, Any], name: Callable[[int], str]) -> tuple[FloatArray, FloatArray | None]:
    """Return the values of a packet and, if it has three for any taxel, those of shear; NaN for null.

    Args:
        fields: Fields of the packet.
        name: Returns the label of a row.
    """
    values = fields.get("values")
    if isinstance(values, list):
        values = [math.nan if value is None else value for value in values]
    try:
        numbers: FloatArray = _numbers({"values": values}, "values", np.float64)
    except MalformedReadingError:
        if not (isinstance(values, list) and list in map(type, values)):
            raise
    else:
        if numbers.ndim == 1:
            return numbers, None
    rows = np.array([_row(one, at, name) for at, one in enumerate(cast("list[Any]", values))])
    return rows[:, 0], rows[:, 1:]


def _row(value: object, at: int, name: Callable[[int], str]) -> list[float]:
    """Return pressure and shear of one taxel: a list of three numbers or null, or one number."""
    place = f"values, {name(at)}"
    if not isinstance(value, list):
        return [_number(value, place), math.nan, math.nan]
    if len(value) != 3:
        remedy = "Send [p, t1, t2] for a taxel with three axes, or one number"
        raise MalformedReadingError("wrong number of channels", place=place, value=len(value), remedy=remedy)
    return [math.nan if one is None else _number(one, place) for one in value]


def _numbers(fields: dict[str, Any], name: str, dtype: Any) -> Any:
    """Return a list of numbers, or of pairs for channels; reject anything else, such as strings or booleans."""
    values = fields.get(name)
    try:
        array = np.array(values)
        good = isinstance(values, list) and (not values or array.dtype.kind in ("iu" if dtype is np.int64 else "iuf"))
        if good:
            return array.astype(dtype)
    except (ValueError, OverflowError) as error:
        raise MalformedReadingError("expected a list of numbers", place=name) from error
    raise MalformedReadingError("expected a list of numbers", place=name, value=values)


def _decode_binary(packet: bytes, token: str | None) -> Reading:
    if len(packet) < HEADER.size:
        raise MalformedReadingError("the packet ends too early", value=f"{len(packet)} bytes")
    _magic, version, which, unit, secret, sequence, time, count, joints = HEADER.unpack_from(packet)
    _check_version(version)
    three = which >= _THREE
    which -= _THREE if three else 0
    if which > 2 or unit >= len(_UNITS) or count > MOST_VALUES:
        found = f"labels {which}, unit {unit}, {count} values"
        raise MalformedReadingError("the packet's header is not of format 1", value=found)
    start = HEADER.size + secret
    middle = start + 4 * which * count
    end = middle + (12 if three else 4) * count
    if end > len(packet):
        raise MalformedReadingError("the packet ends too early", value=f"{len(packet)} bytes")
    _check_token(packet[HEADER.size : start].decode(errors="replace"), token)
    labels = np.frombuffer(packet[start:middle], "<i4").astype(np.int64)
    values = np.frombuffer(packet[middle:end], "<f4").astype(np.float64)
    shear = values.reshape(-1, 3)[:, 1:] if three else None
    values = values[::3] if three else values
    ids = labels if which == 1 else None
    channels = labels.reshape(-1, 2) if which == 2 else None
    return Reading(time, values, _UNITS[unit], ids, channels, _joints(packet, end, joints), sequence, shear=shear)


def _joints(packet: bytes, at: int, count: int) -> dict[str, float]:
    found = {}
    for _ in range(count):
        if at >= len(packet) or at + 9 + packet[at] > len(packet):
            raise MalformedReadingError("the packet ends too early", place="joints")
        name = packet[at + 1 : at + 1 + packet[at]].decode(errors="replace")
        at += 9 + packet[at]
        found[name] = struct.unpack_from("<d", packet, at - 8)[0]
    if at != len(packet):
        raise MalformedReadingError("extra bytes follow the packet", value=len(packet) - at)
    return found
