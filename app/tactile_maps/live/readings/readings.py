"""The one interface that every source of readings speaks: a ``Reading``, and the ``Source`` that has them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from types import MappingProxyType
from typing import Protocol, runtime_checkable

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray, freeze_arrays
from tactile_maps.core.errors import LiveError
from tactile_maps.session.inputs import CalibrationUsed

MOST_VALUES = 200_000
"""In one reading: far above any skin, far below what would exhaust the memory."""


class MalformedReadingError(LiveError):
    """One reading that cannot be used; it is counted, and the next one is taken."""


class Unit(StrEnum):
    """Of the values of a reading."""

    COUNTS = "counts"
    PASCAL = "Pa"
    KILOPASCAL = "kPa"

    @property
    def pascals(self) -> float | None:
        """Pascals in one of it; None where only a calibration can tell."""
        return {Unit.COUNTS: None, Unit.PASCAL: 1.0, Unit.KILOPASCAL: 1e3}[self]


def unit_of(text: object) -> Unit:
    """The unit of that name.

    Raises:
        MalformedReadingError: There is none.
    """
    try:
        return Unit(str(text))
    except ValueError as error:
        remedy = f"Choose one of: {', '.join(Unit)}"
        raise MalformedReadingError("there is no such unit", place="unit", value=text, remedy=remedy) from error


_NO_JOINTS: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class Reading:
    """What a skin, or a part of it, said at one time.

    Attributes:
        time: By the sender's clock [s]; only differences are used.
        values: (n,) in ``unit``, finite.
        unit: Of the values.
        ids: (n,) hardware id of each value's taxel; None where they are not stated.
        channels: (n, 2) module and channel of each value's taxel; None where they are not stated. With neither, the
            values are those of all taxels in their order.
        joints: Positions of joints by name [rad, or m for a slide], as far as the sender knows them.
        sequence: Running number of the packet, modulo 2³²; None where the sender counts none.
        recorded: Of the first reading of a recording: by what its readings were shown in the end; None for others.

    Raises:
        MalformedReadingError: Lengths differ, or a number is not finite.
    """

    time: float
    values: FloatArray
    unit: Unit = Unit.COUNTS
    ids: IntArray | None = None
    channels: IntArray | None = None
    joints: Mapping[str, float] = field(default_factory=lambda: _NO_JOINTS)
    sequence: int | None = None
    recorded: CalibrationUsed | None = None

    def __post_init__(self) -> None:
        freeze_arrays(self, "values")
        freeze_arrays(self, "ids", "channels", dtype=np.int64)
        count = len(self.values) if self.values.ndim == 1 else -1
        if not 0 <= count <= MOST_VALUES:
            raise MalformedReadingError("the values are no list", place="values", value=self.values.shape)
        if self.ids is not None and self.ids.shape != (count,):
            raise MalformedReadingError("there is not one id for each value", place="ids", value=self.ids.shape)
        if self.channels is not None and self.channels.shape != (count, 2):
            problem = "there is not one module and channel for each value"
            raise MalformedReadingError(problem, place="channels", value=self.channels.shape)
        if not math.isfinite(self.time):
            raise MalformedReadingError("the time is not finite", place="time", value=self.time)
        if not np.isfinite(self.values).all():
            row = int(np.argmin(np.isfinite(self.values)))
            raise MalformedReadingError("a value is not finite", place=f"values, {row}", value=float(self.values[row]))
        for name, position in self.joints.items():
            if not math.isfinite(position):
                raise MalformedReadingError("a joint's position is not finite", place=name, value=position)


class Source(Protocol):
    """Where readings come from. Mutable; not for two threads.

    Attributes:
        address: For people, and to open it again.
        finite: Whether it ends by itself, as a file does; then it is not opened again.
        slow: Whether opening it may take longer than a person notices.
    """

    address: str
    finite: bool
    slow: bool

    def open(self) -> None:
        """Make it ready; raises LiveError with a remedy where it cannot be."""

    def receive(self, timeout: float) -> Reading | None:
        """The next reading, or None where none came within ``timeout`` [s].

        Raises:
            MalformedReadingError: Something came that is no reading; the next call goes on behind it.
            SourceEndedError: There are no more.
            LiveError: The connection is lost.
        """

    def close(self) -> None:
        """Let go of it; twice does nothing."""


@runtime_checkable
class PacketSource(Source, Protocol):
    """A source whose packets can be received first and decoded later: those replaced by newer ones need no decoding.

    Attributes:
        one_sender: True while only the packets of one sender are received, those of others refused; it may be set.
    """

    one_sender: bool

    @property
    def refused(self) -> dict[str, int]:
        """Number of refused packets by the address of their sender."""

    def wait_for_packet(self, timeout: float) -> bool:
        """Wait until a packet can be received, for ``timeout`` [s] at most; True if one can. Any thread may wait."""

    def receive_packet(self, timeout: float) -> bytes | None:
        """Return the next packet as it came, or None; raises LiveError where the connection is lost."""

    def is_plausible_packet(self, packet: bytes) -> bool:
        """Return False for a packet that is no reading by its first bytes; True says nothing about the rest."""

    def decode_packet(self, packet: bytes) -> Reading:
        """Return the reading of a packet; raises MalformedReadingError."""


class SourceEndedError(LiveError):
    """A source has no more readings: a file is read to its end."""
