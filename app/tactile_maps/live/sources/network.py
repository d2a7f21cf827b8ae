"""Packets from a network: UDP, to which we listen, and ZeroMQ, to whose publisher we connect.

We listen to this machine alone unless asked, and to others only for packets that carry a token.
"""

from __future__ import annotations

import ipaddress
import selectors
import socket
import time
from collections.abc import Callable
from typing import Any

from tactile_maps.core.errors import LiveError, UsageError
from tactile_maps.live.readings.readings import MalformedReadingError, Reading
from tactile_maps.live.readings.wire_format import decode, is_plausible
from tactile_maps.live.sources.one_sender import OneSender

_BUFFER = 4_000_000
"""Bytes that the system may keep for us while we are busy: a second of the largest skins."""
_SHORTEST_TOKEN = 8


def check_listening(host: str, *, remote: bool, token: str | None) -> None:
    """Refuse to listen to other machines unless it is asked for, with a token.

    Raises:
        UsageError: It is not, or the token is too short.
    """
    if token is not None:
        check_token(token)
    if is_this_machine(host):
        return
    if token is None:
        remedy = "Listen on 127.0.0.1, or set a token and send it in every packet"
        raise UsageError("this address is open to other machines", value=host, remedy=remedy)
    if not remote:
        remedy = "Listen on 127.0.0.1, or add --remote"
        raise UsageError("packets of other machines are not asked for", value=host, remedy=remedy)


def check_token(token: str) -> None:
    """Refuse a token that is soon guessed; raises UsageError."""
    if len(token) < _SHORTEST_TOKEN:
        remedy = f"Choose one of at least {_SHORTEST_TOKEN} characters"
        raise UsageError("the token is too short", place="token", remedy=remedy)


def is_this_machine(host: str) -> bool:
    """Whether a host's name or number means this machine and no other."""
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def is_group(host: str) -> bool:
    """Return whether several machines receive at an address: multicast and broadcast."""
    try:
        number = ipaddress.ip_address(host)
    except ValueError:
        return False
    return number.is_multicast or host == "255.255.255.255"


def check_single(host: str, address: str) -> None:
    """Refuse a source at a group of machines: multicast groups are not joined, so nothing would arrive.

    Raises:
        UsageError: The host is a multicast or broadcast address.
    """
    if is_group(host):
        remedy = "Receive at the address of this computer, to which the sender sends"
        problem = "readings cannot be received at a multicast or broadcast address"
        raise UsageError(problem, place=address, value=host, remedy=remedy)


class UdpSource:
    """Packets that arrive at a UDP port. Mutable.

    Args:
        host: On which we listen.
        port: Likewise; 0 for any that is free.
        token: That every packet must carry.
        remote: Whether the host may be one that other machines reach.
        clock: Receiver's clock [s], by which the stream belongs to one sender.

    Attributes:
        address: For people.
        finite: False.
        slow: False.
        port: That is listened to.
        one_sender: True while only the packets of one sender are received.

    Raises:
        UsageError: See ``check_listening``.
    """

    finite = False
    slow = False

    def __init__(
        self,
        host: str,
        port: int,
        *,
        token: str | None = None,
        remote: bool = False,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        check_listening(host, remote=remote, token=token)
        self.address = f"udp://{host}:{port}"
        self._host = host
        self.port = port
        self._token = token
        self._socket: socket.socket | None = None
        self._readable: selectors.BaseSelector | None = None
        self.one_sender = False
        self._sender = OneSender(self._valid, clock=clock)

    @property
    def refused(self) -> dict[str, int]:
        """Number of packets of second senders by address, refused while only one was admitted."""
        return dict(self._sender.refused)

    def open(self) -> None:
        """Listen."""
        family = socket.AF_INET6 if ":" in self._host else socket.AF_INET
        opened = socket.socket(family, socket.SOCK_DGRAM)
        try:
            opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)
            opened.bind((self._host, self.port))
            opened.setblocking(False)
        except (OSError, OverflowError) as error:
            opened.close()
            remedy = "Choose another port, or close the program that listens there"
            raise LiveError("the port cannot be listened to", place=self.address, value=error, remedy=remedy) from error
        self._socket = opened
        self.port = opened.getsockname()[1]
        self._readable = selectors.DefaultSelector()
        self._readable.register(opened, selectors.EVENT_READ)
        self.address = f"udp://{self._host}:{self.port}"

    def receive(self, timeout: float) -> Reading | None:
        """The reading of the next packet."""
        packet = self.receive_packet(timeout)
        return None if packet is None else self.decode_packet(packet)

    def wait_for_packet(self, timeout: float) -> bool:
        """Wait until a packet can be received, for ``timeout`` [s] at most; True if one can. Any thread may wait."""
        if self._readable is None:
            raise LiveError("the source is not open", place=self.address)
        return bool(self._readable.select(timeout))

    def receive_packet(self, timeout: float) -> bytes | None:
        """Return the next packet as it came, or None where none came within ``timeout`` [s]. Never waits for 0."""
        if timeout > 0 and not self.wait_for_packet(timeout):
            return None
        if self._socket is None:
            raise LiveError("the source is not open", place=self.address)
        try:
            while True:
                packet, sender = self._socket.recvfrom(65536)
                if not self.one_sender or self._sender.admits(packet, sender):
                    return packet
        except BlockingIOError:
            return None
        except OSError as error:
            raise LiveError("the connection is lost", place=self.address, value=error) from error

    def _valid(self, packet: bytes) -> bool:
        try:
            self.decode_packet(packet)
        except MalformedReadingError:
            return False
        return True

    def is_plausible_packet(self, packet: bytes) -> bool:
        """Return False for a packet that is no reading by its first bytes."""
        return is_plausible(packet)

    def decode_packet(self, packet: bytes) -> Reading:
        """Return the reading of a packet; raises MalformedReadingError."""
        return decode(packet, token=self._token)

    def close(self) -> None:
        """Stop listening."""
        if self._socket is not None and self._readable is not None:
            self._readable.close()
            self._socket.close()
            self._socket = self._readable = None


class ZmqSource:
    """Packets of a ZeroMQ publisher (PUB), to which we connect (SUB). Mutable.

    Args:
        host: Where it publishes.
        port: Likewise.
        token: That every packet must carry.

    Attributes:
        address: For people.
        finite: False.
        slow: False.
    """

    finite = False
    slow = False

    def __init__(self, host: str, port: int, *, token: str | None = None) -> None:
        self.address = f"zmq://{host}:{port}"
        self._endpoint = f"tcp://{host}:{port}"
        self._token = token
        self._context: Any = None
        self._socket: Any = None

    def open(self) -> None:
        """Connect; a publisher that is not there yet is waited for."""
        zmq = import_zmq()
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.SUB)
        try:
            self._socket.setsockopt(zmq.LINGER, 0)
            self._socket.setsockopt(zmq.RCVHWM, 10_000)
            self._socket.setsockopt(zmq.RECONNECT_IVL_MAX, 5000)
            self._socket.setsockopt(zmq.SUBSCRIBE, b"")
            self._socket.connect(self._endpoint)
        except zmq.ZMQError as error:
            self.close()
            raise LiveError("there is no such address", place=self.address, value=error) from error

    def receive(self, timeout: float) -> Reading | None:
        """The reading of the next packet; of a message of several parts, the last part."""
        if self._socket is None:
            raise LiveError("the source is not open", place=self.address)
        zmq = import_zmq()
        try:
            if not self._socket.poll(int(1000 * timeout + 0.5)):
                return None
            packet = self._socket.recv_multipart()[-1]
        except zmq.ZMQError as error:
            raise LiveError("the connection is lost", place=self.address, value=error) from error
        return decode(packet, token=self._token)

    def close(self) -> None:
        """Disconnect."""
        if self._socket is not None:
            self._socket.close()
            self._context.term()
            self._socket = self._context = None


def import_zmq() -> Any:
    """The library, which is optional.

    Raises:
        LiveError: It is not installed.
    """
    try:
        import zmq
    except ImportError as error:
        remedy = "Install it with: pip install 'tactile-maps[live]'"
        raise LiveError("ZeroMQ needs pyzmq", remedy=remedy) from error
    return zmq
