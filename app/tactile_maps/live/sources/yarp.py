"""A YARP port, read by its text-mode protocol over TCP, which needs no YARP library.

Protocol (YARP documentation, *YARP without YARP*): ``CONNECT name`` makes a text connection, ``r`` turns it into a
reader, and each message is a line ``do [number time]`` and a line of values. The name server replies to ``query /port``
with a line ``registration name /port ip ADDRESS port NUMBER type CARRIER``.
"""

from __future__ import annotations

import re
import socket
import time
from collections.abc import Callable

import numpy as np

from tactile_maps.core.errors import LiveError
from tactile_maps.live.readings.readings import MOST_VALUES, MalformedReadingError, Reading
from tactile_maps.live.sources.network import check_known

_NAME = "tactile-maps"
_SECONDS = 3.0
_LONGEST_LINE = 40 * MOST_VALUES
_REGISTRATION = re.compile(r"registration name (\S+) ip (\S+) port (\d+)")
_ENVELOPE = re.compile(r"do?(?:\s+(\d+)\s+([-+.\deE]+))?\s*$")


class YarpSource:
    """Readings of a YARP port: one vector of values, in the order of the taxels or of a link's channels. Mutable.

    Args:
        host: Host of the port, or of the name server.
        port: Its port number.
        name: Name of the port, which is resolved by the name server; None if host and port are the port's own.
        link: Link whose ids 0, 1, ... the values have; None for values without ids.
        clock: Wall time [s], for messages without a time.

    Attributes:
        address: Address for display.
        finite: False.
        slow: True.
    """

    finite = False
    slow = True

    def __init__(
        self,
        host: str,
        port: int,
        *,
        name: str | None = None,
        link: str | None = None,
        clock: Callable[[], float] = time.time,
    ) -> None:
        self.address = f"yarp://{host}:{port}{name or ''}{f'?link={link}' if link else ''}"
        self._link = link
        self._clock = clock
        self._host = host
        self._port = port
        self._name = name
        self._socket: socket.socket | None = None
        self._bytes = bytearray()
        self._envelope: re.Match[str] | None = None

    def open(self) -> None:
        """Resolve the name if there is one, and connect to the port as a reader."""
        host, port = self._query() if self._name else (self._host, self._port)
        self._connect(host, port)
        self._send("r")

    def receive(self, timeout: float) -> Reading | None:
        """Return the reading of the next message."""
        if self._socket is None:
            raise LiveError("the source is not open", place=self.address)
        while (line := self._line(timeout)) is not None:
            if self._envelope is None:
                self._envelope = _ENVELOPE.match(line.strip())
                continue  # other lines are not for readers
            envelope = self._envelope
            self._envelope = None
            return self._reading(line, envelope)
        return None

    def close(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _reading(self, line: str, envelope: re.Match[str]) -> Reading:
        number, at = envelope.groups()
        try:
            values = [float(word) for word in line.replace("(", " ").replace(")", " ").split()]
            when = self._clock() if at is None else float(at)
        except ValueError as error:
            raise MalformedReadingError("expected numbers", place=self.address, value=error) from error
        return Reading(
            when,
            np.array(values),
            ids=None if self._link is None else np.arange(len(values)),
            sequence=None if number is None else int(number) % 2**32,
            links=None if self._link is None else (self._link,) * len(values),
        )

    def _query(self) -> tuple[str, int]:
        self._connect(self._host, self._port)
        try:
            self._send("d")
            self._send(f"query {self._name}")
            while (line := self._line(_SECONDS)) is not None:
                found = _REGISTRATION.search(line)
                if found and found[1] == self._name:
                    return found[2], int(found[3])
                if line.startswith("*** end"):
                    break
        finally:
            self.close()
        remedy = "Start the program that publishes it; yarp name list shows the ports"
        raise LiveError("the name server does not know the port", place=self.address, value=self._name, remedy=remedy)

    def _connect(self, host: str, port: int) -> None:
        self._bytes.clear()
        self._envelope = None
        check_known(host)
        try:
            self._socket = socket.create_connection((host, port), timeout=_SECONDS)
        except OSError as error:
            remedy = "Check that it is running, and its host and port"
            raise LiveError("YARP does not respond", place=f"{host}:{port}", value=error, remedy=remedy) from error
        self._send(f"CONNECT {_NAME}")
        if not (self._line(_SECONDS) or "").startswith("Welcome"):
            self.close()
            remedy = "Give a port that accepts text mode"
            raise LiveError("this is not a YARP port", place=f"{host}:{port}", remedy=remedy)

    def _send(self, text: str) -> None:
        assert self._socket is not None
        try:
            self._socket.sendall(f"{text}\n".encode())
        except OSError as error:
            raise LiveError("the connection is lost", place=self.address, value=error) from error

    def _line(self, timeout: float) -> str | None:
        """Return the next complete line; None if it does not arrive in time."""
        assert self._socket is not None
        while (end := self._bytes.find(b"\n")) < 0:
            if len(self._bytes) > _LONGEST_LINE:
                self._bytes.clear()
                raise MalformedReadingError("a line does not end", place=self.address)
            self._socket.settimeout(max(timeout, 1e-4))
            try:
                more = self._socket.recv(65536)
            except TimeoutError:
                return None
            except OSError as error:
                raise LiveError("the connection is lost", place=self.address, value=error) from error
            if not more:
                raise LiveError("the connection is lost", place=self.address)
            self._bytes += more
        line = self._bytes[:end].decode(errors="replace").rstrip("\r")
        del self._bytes[: end + 1]
        return line
