"""Options of the commands that receive readings: the source, its token and its end."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from tactile_maps.cli.shared.unused_options import given_options, refuse_with_input
from tactile_maps.core.errors import LiveError, TactileMapsError, UsageError
from tactile_maps.core.files import read_bounded_text
from tactile_maps.live.session.connection import Connection
from tactile_maps.live.session.facts import MeasuredFacts
from tactile_maps.live.sources.network import check_token, is_this_machine
from tactile_maps.live.sources.open import SourceOptions, host_and_port, open_source, uses_option

_PURPOSES = {
    "speed": "It sets how fast a file is played",
    "mapping": "It names the topics and fields of ROS 2 messages",
    "token": "It is for packets: of udp:, zmq: and serial: sources, and of --send",
    "remote": "It is for udp: sources that other machines reach, such as udp://0.0.0.0:9870, and for --send to others",
}
"""Purposes of the options of a source, by their names in ``SourceOptions``."""
OTHER_SKIN = "they may be of another skin. Name the skin or taxel file that belongs to them with --skin"
"""Remedy for readings that contain few of the skin's taxels."""


def connection_of(arguments: argparse.Namespace, *, clock: Callable[[], float] = time.monotonic) -> Connection:
    """Return a connection to the source, which is not open yet; raises UsageError for options without effect."""
    _refuse_source_options(arguments)
    mapping = Path(arguments.mapping) if arguments.mapping else None
    options = SourceOptions(arguments.token, arguments.remote, mapping, arguments.speed, clock)
    return Connection(open_source(arguments.source, options), clock=clock)


def token_of(arguments: argparse.Namespace) -> str | None:
    """The token from the command line or from a file that other users need not be able to read."""
    if arguments.token_file is None:
        token: str | None = arguments.token
        return token
    if arguments.token is not None:
        raise UsageError("the token is given twice", value="--token-file", remedy="Give one of them")
    token = read_bounded_text(Path(arguments.token_file), error=LiveError).strip()
    check_token(token)
    return token


def refuse_silence(connection: Connection, facts: MeasuredFacts) -> None:
    """Raise LiveError if no reading of the source could be used."""
    if facts.readings:
        return
    status = connection.status
    problem = "no reading arrived"
    remedy = "Check that the sender runs and sends to this address"
    if connection.source.finite:
        problem = "no reading of the file can be used"
        remedy = "Correct the file, or choose the skin that was recorded"
    value = status.problem or facts.problem or status.malformed
    raise LiveError(problem, place=status.address, value=value, remedy=remedy)


@contextmanager
def blaming(option: str, *, problem: str | None = None) -> Iterator[None]:
    """Turn errors into usage errors of an option."""
    try:
        yield
    except TactileMapsError as error:
        raise error.at(kind=UsageError, place=option, problem=problem) from error


@contextmanager
def until_interrupted(*, live: bool) -> Iterator[None]:
    """Treat Ctrl-C as the normal end of a live source; its figures are printed."""
    try:
        yield
    except KeyboardInterrupt as stop:
        if not live or type(stop) is not KeyboardInterrupt:
            raise


def _refuse_source_options(arguments: argparse.Namespace) -> None:
    """Refuse options that have no effect with the source and the address of ``--send``; raises UsageError."""
    address: str | None = getattr(arguments, "send", None)
    sent_to = host_and_port(address)[0] if address else ""
    used_by_sending = {"token": bool(sent_to), "remote": bool(sent_to) and not is_this_machine(sent_to)}
    for name, purpose in _PURPOSES.items():
        options = {"--token", "--token-file"} if name == "token" else {f"--{name}"}
        if options.isdisjoint(given_options(arguments)) or used_by_sending.get(name):
            continue
        if not uses_option(arguments.source, name):
            refuse_with_input(arguments, sorted(options), "source", arguments.source, purpose=purpose)
