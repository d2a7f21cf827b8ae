"""Packets from a network: a UDP port on which we listen, and a ZeroMQ publisher to which we connect.

By default only packets from this machine are received; packets from others require a token.
"""

from __future__ import annotations

import errno
import ipaddress
import selectors
import socket
import time
from collections.abc import Callable
from typing import Any

from tactile_maps.core.errors import LiveError, UsageError, install_line
from tactile_maps.live.readings.readings import MalformedReadingError, Reading
from tactile_maps.live.readings.wire_format import decode, is_plausible
from tactile_maps.live.sources.one_sender import OneSender

_BUFFER = 4_000_000
"""Size of the system's receive buffer [bytes]: one second of the largest skins."""
_SHORTEST_TOKEN = 8


def check_listening(host: str, *, remote: bool, token: str | None) -> None:
    """Check that listening on ``host`` is requested and protected by a token if other machines can reach it.

    Raises:
        UsageError: It is not, or the token is too short.
        LiveError: The host is unknown.
    """
    if token is not None:
        check_token(token)
    if is_this_machine(host):
        return
    check_known(host)
    if token is None:
        remedy = "Listen on 127.0.0.1, or set a token and send it in every packet"
        raise UsageError("this address is open to other machines", value=host, remedy=remedy)
    if not remote:
        remedy = "Listen on 127.0.0.1, or add --remote"
        raise UsageError("receiving packets from other machines is not enabled", value=host, remedy=remedy)


def check_token(token: str) -> None:
    """Raise UsageError for a token that is too short."""
    if len(token) < _SHORTEST_TOKEN:
        remedy = f"Choose one of at least {_SHORTEST_TOKEN} characters"
        raise UsageError("the token is too short", place="token", remedy=remedy)


def is_this_machine(host: str) -> bool:
    """Whether a host name or address refers to this machine only."""
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def check_known(host: str) -> None:
    """Raise LiveError for a host name that cannot be resolved."""
    try:
        socket.getaddrinfo(host, None)
    except (OSError, UnicodeError) as error:  # labels that are empty or too long raise UnicodeError
        remedy = "Check its spelling and the network, or give its IP address"
        raise LiveError("unknown host", value=host, remedy=remedy) from error


def is_group(host: str) -> bool:
    """Whether an address is a multicast or broadcast address."""
    try:
        number = ipaddress.ip_address(host)
    except ValueError:
        return False
    return number.is_multicast or host == "255.255.255.255"


def check_single(host: str, address: str) -> None:
    """Reject a multicast or broadcast address: multicast groups are not joined, so nothing would arrive.

    Raises:
        UsageError: The host is a multicast or broadcast address.
    """
    if is_group(host):
        remedy = "Give the address of this computer to which the sender sends"
        problem = "readings cannot be received at a multicast or broadcast address"
        raise UsageError(problem, place=address, value=host, remedy=remedy)


class UdpSource:
    """Packets at a UDP port. Mutable.

    Args:
        host: Address on which to listen.
        port: Port; 0 for any free one.
        token: Token required in every packet.
        remote: Whether the host may be reachable from other machines.
        clock: Receiver's clock [s], which defines how long a stream belongs to its sender.

    Attributes:
        address: Address for display.
        finite: False.
        slow: False.
        port: Port that is in use.
        one_sender: Whether only the packets of one sender are received.

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
        """Number of rejected packets of other senders by address, while only one was admitted."""
        return dict(self._sender.refused)

    def open(self) -> None:
        """Listen on the port."""
        check_known(self._host)
        family = socket.AF_INET6 if ":" in self._host else socket.AF_INET
        opened = socket.socket(family, socket.SOCK_DGRAM)
        try:
            opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)
            opened.bind((self._host, self.port))
            opened.setblocking(False)
        except (OSError, OverflowError) as error:
            opened.close()
            if getattr(error, "errno", None) == errno.EADDRNOTAVAIL:
                problem = "this computer does not have the address"
                remedy = "Give one of its own, such as 127.0.0.1, or 0.0.0.0 for all of them"
            else:
                problem = "cannot listen on the port"
                remedy = "Choose another port, or close the program that listens there"
            raise LiveError(problem, place=self.address, value=error, remedy=remedy) from error
        self._socket = opened
        self.port = opened.getsockname()[1]
        self._readable = selectors.DefaultSelector()
        self._readable.register(opened, selectors.EVENT_READ)
        self.address = f"udp://{self._host}:{self.port}"

    def receive(self, timeout: float) -> Reading | None:
        """Return the reading of the next packet."""
        packet = self.receive_packet(timeout)
        return None if packet is None else self.decode_packet(packet)

    def wait_for_packet(self, timeout: float) -> bool:
        """Wait until a packet can be received, at most ``timeout`` [s]; return whether one can. Thread-safe."""
        if self._readable is None:
            raise LiveError("the source is not open", place=self.address)
        return bool(self._readable.select(timeout))

    def receive_packet(self, timeout: float) -> bytes | None:
        """Return the next raw packet, or None if none arrives within ``timeout`` [s]. Does not block for 0."""
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
        return is_plausible(packet)

    def decode_packet(self, packet: bytes) -> Reading:
        return decode(packet, token=self._token)

    def close(self) -> None:
        if self._socket is not None and self._readable is not None:
            self._readable.close()
            self._socket.close()
            self._socket = self._readable = None


class ZmqSource:
    """Packets of a ZeroMQ publisher (PUB), to which we connect (SUB). Mutable.

    Args:
        host: Host of the publisher.
        port: Port of the publisher.
        token: Token required in every packet.

    Attributes:
        address: Address for display.
        finite: False.
        slow: False.
    """

    finite = False
    slow = False

    def __init__(self, host: str, port: int, *, token: str | None = None) -> None:
        self.address = f"zmq://{host}:{port}"
        self._host = host
        self._endpoint = f"tcp://{host}:{port}"
        self._token = token
        self._context: Any = None
        self._socket: Any = None

    def open(self) -> None:
        """Connect; the publisher may start later."""
        zmq = import_zmq()
        check_known(self._host)  # ZeroMQ would wait for it without an error
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
            raise LiveError("invalid address", place=self.address, value=error) from error

    def receive(self, timeout: float) -> Reading | None:
        """Return the reading of the next packet, which is the last part of a multipart message."""
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
        if self._socket is not None:
            self._socket.close()
            self._context.term()
            self._socket = self._context = None


def import_zmq() -> Any:
    """Return the optional library ``zmq``.

    Raises:
        LiveError: It is not installed.
    """
    try:
        import zmq
    except ImportError as error:
        remedy = f"Install it with: {install_line('live')}"
        raise LiveError("ZeroMQ needs pyzmq", remedy=remedy) from error
    return zmq
