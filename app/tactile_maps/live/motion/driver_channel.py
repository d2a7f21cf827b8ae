"""The connection to a robot's driver, and the conditions for sending motion over it."""

from __future__ import annotations

import secrets
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from urllib.parse import urlsplit

from tactile_maps.core.errors import LiveError, UsageError
from tactile_maps.live.sources.network import check_known, check_token, is_group, is_this_machine
from tactile_maps.live.sources.open import host_and_port
from tactile_maps.live.sources.send import sender

_ANY_HOST = ("0.0.0.0", "::")


def check_sending(address: str, *, remote: bool) -> None:
    """Check that motion may be sent to an address: to one driver, and to another machine only on the user's request.

    Raises:
        UsageError: Another machine was not requested, the address is of a group of machines, or it is invalid.
        LiveError: The host is unknown.
    """
    host, _ = host_and_port(address)
    if urlsplit(address).scheme not in ("udp", "zmq"):
        remedy = "Give udp://HOST:PORT or zmq://HOST:PORT"
        raise UsageError("motion cannot be sent to such an address", place="--send", value=address, remedy=remedy)
    if is_group(host):
        remedy = "Give the address of the computer that runs the robot's driver"
        raise UsageError("motion can only be sent to one driver", place="--send", value=host, remedy=remedy)
    if is_this_machine(host):
        return
    check_known(host)
    if not remote:
        remedy = "Send to 127.0.0.1, or add --remote"
        raise UsageError("sending motion to other machines is not enabled", value=host, remedy=remedy)


def check_not_source(address: str, source: str) -> None:
    """Check that the driver's address is not the one at which this program receives readings.

    Args:
        address: Address of the driver.
        source: Address of the readings.

    Raises:
        UsageError: They are the same.
    """
    try:
        driver = host_and_port(address)
        readings = host_and_port(source, any_free=True)
    except UsageError:  # invalid port, which is reported where the address is used
        return
    schemes = {urlsplit(address).scheme, urlsplit(source).scheme}
    if len(schemes) > 1 or schemes.isdisjoint({"udp", "zmq"}) or driver[1] != readings[1]:
        return
    own = is_this_machine(driver[0]) and (is_this_machine(readings[0]) or readings[0] in _ANY_HOST)
    if own or driver[0] == readings[0]:
        remedy = "Give the address at which the robot's driver receives"
        raise UsageError("the readings are received at this address", place="--send", value=address, remedy=remedy)


def needs_token(source: str) -> bool:
    """Return whether readings of ``source`` need a token while motion is sent."""
    return source.partition(":")[0] in ("udp", "zmq")


def check_readings(source: str, token: str | None) -> None:
    """Check that readings that move a robot cannot come from any program on the network or on this computer.

    Access to a serial port or a file is a matter of its permissions. YARP and ROS 2 have no token; access to them is a
    matter of their own network.

    Args:
        source: Address of the readings.
        token: Token required in every packet; None if there is none.

    Raises:
        UsageError: A token is required and missing or too short.
    """
    if not needs_token(source):
        return
    if token is None:
        token = secrets.token_urlsafe(12)
        remedy = f"Set a token, for example {token}, and configure the sender to include it in every packet"
        problem = "readings need a token while motion is sent, because any program could send them"
        raise UsageError(problem, value=source, remedy=remedy)
    check_token(token)


@contextmanager
def driver_channel(address: str) -> Iterator[Callable[[bytes], Any]]:
    """Yield a function that sends a packet to ``udp://HOST:PORT``, or publishes it at ``zmq://HOST:PORT``.

    A UDP socket is connected: it uses the network that leads to the driver, receives from no other address, and raises
    ConnectionRefusedError for the packet after one that no program received. A ZeroMQ publisher cannot detect that.
    Of the addresses of a host name, an IPv4 address is preferred, as for sources of readings.

    Raises:
        UsageError: The address is invalid.
        LiveError: It cannot be sent to, or another program on this computer sends motion to it.
    """
    host, port = host_and_port(address)
    if urlsplit(address).scheme != "udp":
        with sender(address) as put:
            yield put
        return
    with ExitStack() as opened:
        try:
            found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
            # Debian lists ::1 before 127.0.0.1 for localhost, where most drivers receive.
            family, kind, protocol, _, place = min(found, key=lambda one: one[0] is not socket.AF_INET)
            channel = opened.enter_context(socket.socket(family, kind, protocol))
            channel.connect(place)
        except (OSError, ValueError) as error:
            raise LiveError("the driver's address cannot be used", place=address, value=error) from error
        opened.enter_context(_claimed(address, channel.getpeername()))
        yield channel.send


@contextmanager
def _claimed(address: str, place: tuple[Any, ...]) -> Iterator[None]:
    """Hold the exclusive right to send to a driver. Only Linux has socket names that end with their process; on other
    systems nothing is held.

    Raises:
        LiveError: Another program holds it.
    """
    if not sys.platform.startswith("linux"):
        yield
        return
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as claim:
        try:
            claim.bind(f"\0tactile-maps/driver/{place[0]}:{place[1]}")
        except OSError as error:
            remedy = "End that program, or stop sending there"
            problem = "another program on this computer sends motion to this driver"
            raise LiveError(problem, place=address, remedy=remedy) from error
        yield
