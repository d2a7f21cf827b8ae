"""Packets from a serial port: JSON, one per line."""

from __future__ import annotations

from typing import Any

from tactile_maps.core.errors import LiveError, install_line
from tactile_maps.live.readings.readings import MalformedReadingError, Reading
from tactile_maps.live.readings.wire_format import decode

_LONGEST_LINE = 1_000_000


class SerialSource:
    """Lines of a serial port. Mutable.

    Args:
        port: Name of the port, such as ``/dev/ttyUSB0`` or ``COM3``.
        baud: Bits per second.
        token: Token required in every packet.

    Attributes:
        address: Address for display.
        finite: False.
        slow: False.
    """

    finite = False
    slow = False

    def __init__(self, port: str, *, baud: int = 115200, token: str | None = None) -> None:
        self.address = f"serial://{port}?baud={baud}"
        self._port = port
        self._baud = baud
        self._token = token
        self._serial: Any = None
        self._bytes = bytearray()
        self._first = True

    def open(self) -> None:
        try:
            import serial
        except ImportError as error:
            remedy = f"Install it with: {install_line('live')}"
            raise LiveError("serial ports need pyserial", remedy=remedy) from error
        try:
            self._serial = serial.Serial(self._port, self._baud, timeout=0, exclusive=True)
        except (OSError, ValueError) as error:
            remedy = "Check that the board is connected and that you have permission to read the port"
            raise LiveError("the serial port cannot be opened", place=self._port, value=error, remedy=remedy) from error
        self._bytes.clear()
        self._first = True

    def receive(self, timeout: float) -> Reading | None:
        """Return the reading of the next line. An invalid first line is skipped, since it may have begun before
        opening.
        """
        if self._serial is None:
            raise LiveError("the source is not open", place=self.address)
        if (line := self._line()) is None:
            try:
                self._serial.timeout = timeout
                self._bytes += self._serial.read(1)
                self._bytes += self._serial.read(self._serial.in_waiting)
            except OSError as error:
                raise LiveError("the connection is lost", place=self.address, value=error) from error
            line = self._line()
        if line is None:
            return None
        first = self._first
        self._first = False
        try:
            return decode(line, token=self._token)
        except MalformedReadingError:
            if first:
                return None
            raise

    def _line(self) -> bytes | None:
        """Return the next complete line that is not empty."""
        while (end := self._bytes.find(b"\n")) >= 0:
            line = bytes(self._bytes[:end]).strip()
            del self._bytes[: end + 1]
            if line:
                return line
        if len(self._bytes) > _LONGEST_LINE:
            self._bytes.clear()
            raise MalformedReadingError("a line does not end", place=self.address, remedy="End each packet with \\n")
        return None

    def close(self) -> None:
        if self._serial is not None:
            self._serial.close()
            self._serial = None
