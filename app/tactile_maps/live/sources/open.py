"""Selection of a source by its address."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from ipaddress import ip_address
from pathlib import Path
from urllib.parse import SplitResult, parse_qs, parse_qsl, urlsplit

from tactile_maps.core.errors import LiveError, UsageError
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.core.files import open_regular_file
from tactile_maps.core.plugins import Plugin, PluginObject, Registry, guard_call
from tactile_maps.live.readings.readings import Reading, Source
from tactile_maps.skin.formats.identify import kind_of

DEFAULT_PORT = 9870
"""Default port of UDP and ZeroMQ addresses."""
FILE_SUFFIXES = (".csv", ".txt", ".parquet", ".mcap", ".db3")
ADDRESSES = "udp://127.0.0.1:9870, zmq://127.0.0.1:9870, serial:///dev/ttyUSB0, yarp://HOST:PORT, ros2: or a file"


@dataclass(frozen=True)
class SourceOptions:
    """Options of a source that are not part of its address.

    Attributes:
        token: Token required in every packet; needed to receive from other machines.
        remote: Whether to receive packets from other machines.
        mapping: TOML file with the topics and fields of ROS 2 messages.
        speed: Playback speed of a file relative to the recording; None for as fast as possible.
        clock: Receiver's clock [s], for ages of readings and commands, and for the time that a sender owns a stream.
    """

    token: str | None = None
    remote: bool = False
    mapping: Path | None = None
    speed: float | None = 1.0
    clock: Callable[[], float] = time.monotonic


_USUAL = SourceOptions()


@dataclass(frozen=True)
class SourceKind:
    """A kind of source that a plug-in adds.

    Attributes:
        name: Scheme of its addresses, before the colon.
        title: Name for display.
        build: Returns the source at an address, not opened yet.
    """

    name: str
    title: str
    build: Callable[[str, SourceOptions], Source]


def _guarded(plugin: Plugin, kind: SourceKind) -> SourceKind:
    """Return a plug-in's kind whose sources raise a ``LiveError`` when they fail, so that they are opened again."""

    def receive(method: Callable[[float], object], timeout: float) -> Reading | None:
        found = method(timeout)
        if found is None or isinstance(found, Reading):
            return found
        raise plugin.error("it did not return a Reading", type(found).__name__)

    def build(make: Callable[[str, SourceOptions], object], address: str, options: SourceOptions) -> PluginObject:
        members = ("address", "finite", "slow", "open", "receive", "close")
        return PluginObject(plugin, make(address, options), *members, checks={"receive": receive}, kind=LiveError)

    return replace(kind, build=guard_call(plugin, kind.build, "address", "options", check=build))


_BUILT_IN = ("udp", "zmq", "serial", "yarp", "ros2")
SOURCE_KINDS: Registry[SourceKind] = Registry("sources", SourceKind, (), _guarded, reserved=_BUILT_IN)
"""Kinds added by plug-ins, by scheme; ``ADDRESSES`` lists the built-in ones."""


def open_source(address: str, options: SourceOptions = _USUAL) -> Source:
    """Return the source at ``address``; it is not opened yet.

    Raises:
        UsageError: The kind of source is unknown, or receiving from other machines is not protected.
        LiveError: A mapping or a file cannot be read.
    """
    if not address.strip():
        raise UsageError("no source is named", remedy=f"Give one of: {ADDRESSES}")
    scheme, found, rest = address.partition(":")
    if not found or len(scheme) == 1:  # a single letter is a drive of Windows
        return _file(address, options)
    # Imported here because each needs a library that may not be installed.
    if scheme in ("udp", "zmq"):
        from tactile_maps.live.sources.network import UdpSource, ZmqSource, check_single

        host, port = host_and_port(address, any_free=scheme == "udp")
        check_single(host, address)
        if scheme == "zmq":
            return ZmqSource(host, port, token=options.token)
        return UdpSource(host, port, token=options.token, remote=options.remote, clock=options.clock)
    if scheme == "serial":
        from tactile_maps.live.sources.serial_port import SerialSource

        parts = _split(address)
        return SerialSource(parts.path or parts.netloc, baud=_baud(address, parts), token=options.token)
    if scheme == "yarp":
        from tactile_maps.live.sources.yarp import YarpSource

        host, port = host_and_port(address, 10000, parameters=("link",))
        parts = urlsplit(address)
        link = parse_qs(parts.query).get("link", [None])[0]
        return YarpSource(host, port, name=parts.path if len(parts.path) > 1 else None, link=link)
    if scheme == "ros2":
        from tactile_maps.live.sources.ros2 import Ros2Source, load_topics

        return Ros2Source(load_topics(Path(rest) if rest else options.mapping))
    if scheme in SOURCE_KINDS:
        return SOURCE_KINDS[scheme].build(address, options)
    added = "".join(f", {name}:" for name in SOURCE_KINDS)
    remedy = f"Give one of: {ADDRESSES}{added}; or install the plug-in that adds it"
    raise UsageError("unknown kind of source", value=address, remedy=remedy)


def uses_option(address: str, name: str) -> bool:
    """Return whether one of the ``SourceOptions`` has an effect for the source at ``address``.

    Sources of plug-ins may use all of them; a missing file is reported when it is opened.

    Args:
        address: Address of the source.
        name: ``token``, ``remote``, ``mapping`` or ``speed``.

    Raises:
        UsageError: The address is invalid.
        LiveError: A recording cannot be read.
    """
    if not is_live(address):
        path = Path(address)
        return name == "speed" or (name == "mapping" and (not path.exists() or _is_bag(path)))
    scheme, _, rest = address.partition(":")
    if scheme not in _BUILT_IN:
        return True
    if name == "remote":
        from tactile_maps.live.sources.network import is_this_machine

        return scheme == "udp" and not is_this_machine(host_and_port(address, any_free=True)[0])
    if name == "token":
        return scheme in ("udp", "zmq", "serial")
    return name == "mapping" and scheme == "ros2" and not rest


def host_and_port(
    address: str, default: int = DEFAULT_PORT, *, any_free: bool = False, parameters: tuple[str, ...] = ()
) -> tuple[str, int]:
    """Return the host and port of ``address``: this computer and ``default`` if it states none.

    Args:
        address: For example ``udp://HOST:PORT``.
        default: Port of an address without one.
        any_free: Whether port 0 means any free port, which is possible only for listening.
        parameters: Names that the address may have after a question mark.

    Raises:
        UsageError: No slash follows the colon, the host is a number that is not an IP address, the port is not a whole
            number up to 65535, or is 0 without ``any_free``, or the address has other parameters after a question mark.
    """
    parts = _split(address)
    _refuse_unknown_parameters(address, parts, *parameters)
    if parts.path and not parts.netloc and not parts.path.startswith("/"):
        remedy = f"Write {parts.scheme}://{parts.path} for a host, or {parts.scheme}: for the usual address"
        raise UsageError("the address has no // before the host", value=address, remedy=remedy)
    host = parts.hostname or "127.0.0.1"
    if not host.strip("0123456789."):
        try:
            ip_address(host)
        except ValueError as error:
            remedy = "Give four numbers from 0 to 255, such as 127.0.0.1 for this computer"
            raise UsageError("invalid IP address", place=address, value=host, remedy=remedy) from error
    port = parts.port
    if port == 0 and not any_free:
        remedy = f"Give the port of the other program, 1 to 65535, or none for {default}"
        raise UsageError("no program can be reached at port 0", value=address, remedy=remedy)
    return host, default if port is None else port


def _split(address: str) -> SplitResult:
    """Return the parts of ``address`` after checking its port."""
    try:
        parts = urlsplit(address)
    except ValueError as error:
        raise UsageError("invalid address", value=address, remedy=f"Give one of: {ADDRESSES}") from error
    try:
        _ = parts.port  # reading it checks it
    except ValueError as error:
        port = parts.netloc.rpartition(":")[2]
        remedy = "Give a whole number from 1 to 65535"
        raise UsageError("invalid port number", place=address, value=port, remedy=remedy) from error
    return parts


def _refuse_unknown_parameters(address: str, parts: SplitResult, *known: str) -> None:
    """Reject parameters of ``address`` after its question mark other than the ``known`` ones."""
    unknown = [word for word, _ in parse_qsl(parts.query, keep_blank_values=True) if word not in known]
    if unknown:
        allowed = f"Choose {', '.join(known)}" if known else "Remove the question mark and everything after it"
        problem = "the address has an unknown parameter"
        raise UsageError(problem, place=address, value=", ".join(unknown), remedy=allowed)


def _baud(address: str, parts: SplitResult) -> int:
    _refuse_unknown_parameters(address, parts, "baud")
    text = parse_qs(parts.query, keep_blank_values=True).get("baud", ["115200"])[0]
    if not text.isdecimal() or len(text) > 8 or not 50 <= int(text) <= 20_000_000:
        remedy = "Choose 50 to 20000000, for example ?baud=115200"
        raise UsageError("invalid baud rate", value=address, remedy=remedy)
    return int(text)


def _file(address: str, options: SourceOptions) -> Source:
    from tactile_maps.live.sources.files import FileSource, read_recording, read_table, read_text

    path = Path(address)
    if path.exists() and not path.is_dir():
        with open_regular_file(path, error=LiveError):
            pass  # rejects a pipe or device before anything blocks on it
    if _is_bag(path):
        from tactile_maps.live.sources.ros2 import load_topics, read_bag

        topics = load_topics(options.mapping)
        return FileSource(path, lambda file: read_bag(file, topics), speed=options.speed)
    if path.is_dir():
        remedy = "Name a file in it, or the folder that ros2 bag record made, with its metadata.yaml"
        raise UsageError("this folder is not a source of readings", file=path, remedy=remedy)
    if path.suffix.lower() == ".mcap":
        return FileSource(path, read_recording, speed=options.speed)
    if path.suffix.lower() not in FILE_SUFFIXES:
        raise UsageError("unknown kind of source", value=address, remedy=f"Give one of: {ADDRESSES}")
    return FileSource(path, read_text if path.suffix.lower() == ".txt" else read_table, speed=options.speed)


def _is_bag(path: Path) -> bool:
    """Whether the path is a recording of ROS 2: a folder with its metadata, or a file of another program."""
    return (path / "metadata.yaml").is_file() or kind_of(path) is FileKind.ROS_RECORDING


def is_live(address: str) -> bool:
    """Whether the address is of a live source, not of a file."""
    scheme, found, _ = address.partition(":")
    return bool(found) and len(scheme) > 1
