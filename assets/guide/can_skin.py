"""Plug-in that reads a skin on a CAN bus with python-can: ``tactile-maps listen can:socketcan:can0 --skin hand.npz``.

Copy this module into a package of your own, with the dependency ``python-can`` and, in its ``pyproject.toml``,

    [project.entry-points."tactile_maps.sources"]
    can = "can_skin:CAN"

and adapt ``reading_of`` to the messages of your boards. Here, board b sends messages with the identifier 0x100 + b,
whose data are four unsigned 16-bit counts, most significant byte first, of the taxels 4 b to 4 b + 3.
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np

from tactile_maps.core.errors import LiveError, UsageError
from tactile_maps.live.readings.readings import MalformedReadingError, Reading
from tactile_maps.live.sources.open import SourceKind, SourceOptions

FIRST_IDENTIFIER = 0x100
BOARDS = 32
_COUNTS = struct.Struct(">4H")


def reading_of(message: Any) -> Reading | None:
    """Return the reading of a message; None for messages of other devices.

    Raises:
        MalformedReadingError: A board sent too few or too many bytes.
    """
    board = message.arbitration_id - FIRST_IDENTIFIER
    if message.is_error_frame or message.is_remote_frame or not 0 <= board < BOARDS:
        return None
    if len(message.data) != _COUNTS.size:
        raise MalformedReadingError("a message has not 8 bytes", place=f"board {board}", value=len(message.data))
    values = np.array(_COUNTS.unpack(message.data), dtype=np.float64)
    return Reading(message.timestamp, values, ids=4 * board + np.arange(4))


class CanSource:
    """Readings of a CAN bus. Mutable.

    Args:
        address: ``can:INTERFACE:CHANNEL``, names of python-can such as ``can:socketcan:can0``.

    Raises:
        UsageError: The address has another form.
    """

    finite = False
    slow = True

    def __init__(self, address: str) -> None:
        _, *parts = address.split(":", 2)
        if len(parts) != 2 or not all(parts):
            remedy = "Write can:INTERFACE:CHANNEL, such as can:socketcan:can0"
            raise UsageError("invalid address of a CAN bus", value=address, remedy=remedy)
        self.address = address
        self._interface, self._channel = parts
        self._bus: Any = None

    def open(self) -> None:
        """Connect to the bus; raises LiveError if that fails."""
        try:
            import can
        except ImportError as error:
            raise LiveError("CAN needs python-can", remedy="Install it with: pip install python-can") from error
        try:
            self._bus = can.Bus(interface=self._interface, channel=self._channel)
        except (can.CanError, OSError, ValueError) as error:
            remedy = "Check that the interface is up, for example with: ip link show"
            raise LiveError("the CAN bus cannot be opened", place=self.address, value=error, remedy=remedy) from error

    def receive(self, timeout: float) -> Reading | None:
        """Return the reading of the next message; None if none arrives, or one of another device."""
        if self._bus is None:
            raise LiveError("the source is not open", place=self.address)
        import can

        try:
            message = self._bus.recv(timeout)
        except (can.CanError, OSError) as error:
            raise LiveError("the connection is lost", place=self.address, value=error) from error
        return None if message is None else reading_of(message)

    def close(self) -> None:
        """Leave the bus."""
        if self._bus is not None:
            self._bus.shutdown()
            self._bus = None


def _build(address: str, options: SourceOptions) -> CanSource:
    return CanSource(address)


CAN = SourceKind("can", "CAN bus", _build)
