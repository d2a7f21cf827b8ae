"""Interface of all sources of readings: the ``Reading`` data type and the ``Source`` protocol."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import lru_cache
from types import MappingProxyType
from typing import Protocol, runtime_checkable

import numpy as np

from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray, readonly
from tactile_maps.core.errors import LiveError
from tactile_maps.session.inputs import CalibrationUsed

MOST_VALUES = 200_000
"""Maximum number of values in one reading: far more than any skin has, far less than would exhaust the memory."""


COMPONENTS = ("x", "y", "z", "norm", "xyz")
"""Choices for the value of a taxel that sends three numbers; with ``xyz``, z is its pressure, x and y its shear."""


class MalformedReadingError(LiveError):
    """A reading that cannot be used; it is counted and skipped."""


class Unit(StrEnum):
    """Unit of the values of a reading."""

    COUNTS = "counts"
    PASCAL = "Pa"
    KILOPASCAL = "kPa"

    @property
    def pascals(self) -> float | None:
        """Pascals per unit; None where this depends on a calibration."""
        return {Unit.COUNTS: None, Unit.PASCAL: 1.0, Unit.KILOPASCAL: 1e3}[self]


def unit_of(text: object) -> Unit:
    """Return the unit with a given name.

    Raises:
        MalformedReadingError: The name is unknown.
    """
    try:
        return Unit(str(text))
    except ValueError as error:
        remedy = f"Choose one of: {', '.join(Unit)}"
        raise MalformedReadingError("unknown unit", place="unit", value=text, remedy=remedy) from error


def split_id(text: str) -> tuple[str | None, int]:
    """Return the link, if any, and the id in ``link:id`` or ``id``.

    Raises:
        MalformedReadingError: It is neither.
    """
    link, colon, number = text.strip().rpartition(":")
    if not (number.isdecimal() and number.isascii() and len(number) <= 18) or bool(link) != bool(colon):
        raise MalformedReadingError("expected an id, or link:id", value=text[:40])
    return link or None, int(number)


def labels_of(texts: Sequence[str]) -> tuple[tuple[str, ...] | None, IntArray]:
    """Return the links and the ids of labels ``link:id``, or no links of plain ids.

    Raises:
        MalformedReadingError: A label is invalid, or only some labels have a link.

    Cost: 2.5 ms for 1,000 labels, 0.05 ms if they are those of one of the last 32 calls.
    """
    labels = tuple(texts)
    return _parsed(labels) if len(labels) <= _MOST_CACHED else _parsed.__wrapped__(labels)


_MOST_CACHED = 10_000
"""Largest number of labels that are kept in the cache: longer lists would take much memory."""


@lru_cache(maxsize=32)
def _parsed(texts: tuple[str, ...]) -> tuple[tuple[str, ...] | None, IntArray]:
    labels = [split_id(text) for text in texts]
    ids = readonly([number for _, number in labels], np.int64)
    links = tuple(link for link, _ in labels if link is not None)
    if links and len(links) < len(ids):
        problem = "only some ids have a link"
        raise MalformedReadingError(problem, value=f"{len(links)} of {len(ids)}", remedy="Write all ids as link:id")
    return links or None, ids


_NO_JOINTS: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class Reading(ArrayFields):
    """Values of a skin, or of a part of it, at one time.

    Attributes:
        time: Sender's clock [s]; only differences are used.
        values: (n,) values in ``unit``, finite; NaN where the taxel did not report.
        unit: Unit of the values.
        ids: (n,) hardware id of each value's taxel; None if not stated.
        channels: (n, 2) module and channel of each value's taxel; None if not stated. Without ids and channels, the
            values are those of all taxels in order.
        joints: Joint positions by name [rad, or m for a slide], as far as the sender knows them.
        sequence: Running number of the packet, modulo 2³²; None if the sender does not count.
        recorded: Calibration at the end of a recording, in its first reading; None otherwise.
        links: Name of the link of each id, for skins whose links repeat ids; None if not stated.
        shear: (n, 2) values along t1 and t2 of each value's taxel, in ``unit``; NaN where the taxel has one axis or did
            not report. None if only the values against the normals were sent.

    Raises:
        MalformedReadingError: Lengths differ, a value is infinite, or another number is not finite.
    """

    time: float
    values: FloatArray
    unit: Unit = Unit.COUNTS
    ids: IntArray | None = None
    channels: IntArray | None = None
    joints: Mapping[str, float] = field(default_factory=lambda: _NO_JOINTS)
    sequence: int | None = None
    recorded: CalibrationUsed | None = None
    links: tuple[str, ...] | None = None
    shear: FloatArray | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        count = len(self.values) if self.values.ndim == 1 else -1
        if not 0 <= count <= MOST_VALUES:
            raise MalformedReadingError("the values are not a list", place="values", value=self.values.shape)
        if self.ids is not None and self.ids.shape != (count,):
            raise MalformedReadingError("the values need one id each", place="ids", value=self.ids.shape)
        if self.links is not None and (self.ids is None or len(self.links) != count):
            raise MalformedReadingError("the values need one id and link each", place="links", value=len(self.links))
        if self.channels is not None and self.channels.shape != (count, 2):
            problem = "the values need one module and channel each"
            raise MalformedReadingError(problem, place="channels", value=self.channels.shape)
        if not math.isfinite(self.time):
            raise MalformedReadingError("the time is not finite", place="time", value=self.time)
        if (infinite := np.isinf(self.values)).any():
            row = int(np.argmax(infinite))
            raise MalformedReadingError("a value is infinite", place=f"values, {row}", value=float(self.values[row]))
        if self.shear is not None:
            self._check_shear(self.shear, count)
        for name, position in self.joints.items():
            if not math.isfinite(position):
                raise MalformedReadingError("a joint's position is not finite", place=name, value=position)

    def _check_shear(self, shear: FloatArray, count: int) -> None:
        if shear.shape != (count, 2):
            problem = "the values need two of shear each"
            raise MalformedReadingError(problem, place="shear", value=shear.shape)
        infinite = np.isinf(shear).any(axis=1)
        if infinite.any():
            row = int(infinite.argmax())
            place = self.row_name(row)
            raise MalformedReadingError("a value is infinite", place=place, value=shear[row].tolist())

    def row_name(self, row: int) -> str:
        """Return the label of a value for display."""
        return row_name(row, self.ids, self.links, self.channels)


def row_name(row: int, ids: IntArray | None, links: tuple[str, ...] | None, channels: IntArray | None) -> str:
    """Return the label of a value for display, of a reading whose labels are given."""
    if ids is not None and row < len(ids):
        return f"{links[row]}:{ids[row]}" if links is not None and row < len(links) else f"id {ids[row]}"
    if channels is not None and row < len(channels):
        return f"module {channels[row][0]}, channel {channels[row][1]}"
    return f"value {row}"


class Source(Protocol):
    """Source of readings. Mutable; not thread-safe.

    Attributes:
        address: Address for display and for opening it again.
        finite: Whether it ends by itself, like a file; it is then not opened again.
        slow: Whether opening it may take noticeably long.
    """

    address: str
    finite: bool
    slow: bool

    def open(self) -> None:
        """Open the source; raises LiveError with a remedy if that fails."""

    def receive(self, timeout: float) -> Reading | None:
        """Return the next reading, or None if none arrives within ``timeout`` [s].

        Raises:
            MalformedReadingError: A packet is not a valid reading; the next call continues after it.
            SourceEndedError: There are no more readings.
            LiveError: The connection is lost.
        """

    def close(self) -> None:
        """Release the source; calling it again has no effect."""


@runtime_checkable
class PacketSource(Source, Protocol):
    """Source whose packets can be received first and decoded later, so that superseded packets need no decoding.

    Attributes:
        one_sender: Whether only the packets of one sender are received and those of others rejected; it may be set.
    """

    one_sender: bool

    @property
    def refused(self) -> dict[str, int]:
        """Number of rejected packets by the address of their sender."""

    def wait_for_packet(self, timeout: float) -> bool:
        """Wait until a packet can be received, at most ``timeout`` [s]; return whether one can. Thread-safe."""

    def receive_packet(self, timeout: float) -> bytes | None:
        """Return the next raw packet, or None; raises LiveError if the connection is lost."""

    def is_plausible_packet(self, packet: bytes) -> bool:
        """Return False for a packet that cannot be a reading by its first bytes; the rest is not checked."""

    def decode_packet(self, packet: bytes) -> Reading:
        """Return the reading of a packet; raises MalformedReadingError."""


class SourceEndedError(LiveError):
    """A source has no more readings, such as a file at its end."""
