"""Example sender of packets, to test a receiver: ``python -m tactile_maps.live.sources.send``.

It plays back a file of readings, or generates one contact that moves over the taxels.
"""

from __future__ import annotations

import argparse
import math
import socket
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import count, islice
from typing import Any
from urllib.parse import urlsplit

import numpy as np

from tactile_maps.core.errors import LiveError, TactileMapsError, UsageError, system_message
from tactile_maps.live.readings.readings import MalformedReadingError, Reading, SourceEndedError, Unit
from tactile_maps.live.readings.wire_format import encode_binary, encode_json
from tactile_maps.live.sources.network import check_known, import_zmq
from tactile_maps.live.sources.open import SourceOptions, host_and_port, open_source

MOST_TAXELS = 100_000


@contextmanager
def sender(address: str) -> Iterator[Callable[[bytes], Any]]:
    """Yield a function that sends a packet to ``udp://HOST:PORT``, or publishes it at ``zmq://HOST:PORT``.

    Raises:
        UsageError: The address is invalid.
        LiveError: It cannot be sent to.
    """
    host, port = host_and_port(address)
    scheme = urlsplit(address).scheme
    if scheme == "udp":
        check_known(host)
        with socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_DGRAM) as opened:
            yield lambda packet: opened.sendto(packet, (host, port))
    elif scheme == "zmq":
        zmq = import_zmq()
        with zmq.Context() as context, context.socket(zmq.PUB) as published:
            published.setsockopt(zmq.LINGER, 500)
            try:
                published.bind(f"tcp://{host}:{port}")
            except zmq.ZMQError as error:
                raise LiveError("nothing can be published there", place=address, value=error) from error

            def publish(packet: bytes) -> None:
                try:
                    published.send(packet)
                except zmq.ZMQError as error:
                    raise LiveError("a packet cannot be published", place=address, value=error) from error

            yield publish
    else:
        remedy = "Give udp://HOST:PORT or zmq://HOST:PORT"
        raise UsageError("packets cannot be sent to this address", value=address, remedy=remedy)


_FRICTION = 0.4
"""Shear over pressure of generated readings with three axes."""


def made_up(taxels: int, rate: float, axes: int = 1) -> Iterator[Reading]:
    """Yield generated readings, ``rate`` per second: a moving contact on a little noise, in the order of the taxels.

    With three ``axes``, the contact drags every taxel along its t1 in the direction of its motion.
    """
    random = np.random.default_rng(0)
    places = np.arange(taxels)
    for number in count():
        at = taxels * (0.5 + 0.5 * math.sin(0.5 * number / rate))
        pressed = 60.0 * np.exp(-(((places - at) / max(0.02 * taxels, 1.0)) ** 2))
        values = np.round(pressed + random.normal(20, 0.7, taxels))
        shear = None
        if axes == 3:
            along = math.copysign(_FRICTION, math.cos(0.5 * number / rate))
            dragged = np.column_stack([along * pressed, np.zeros(taxels)])
            shear = np.round(dragged + random.normal(0, 0.7, (taxels, 2)))
        yield Reading(number / rate, values, Unit.COUNTS, shear=shear)


def _of_file(path: str) -> Iterator[Reading]:
    source = open_source(path, SourceOptions(speed=1.0))
    source.open()
    try:
        while True:
            try:
                reading = source.receive(1.0)
            except MalformedReadingError as error:
                sys.stderr.write(f"{error}\n")
                continue
            except SourceEndedError:
                return
            if reading is not None:
                yield reading
    finally:
        source.close()


def send(arguments: argparse.Namespace) -> int:
    """Send what the arguments request; return the number of packets."""
    sent = 0
    start = time.monotonic()
    encode = encode_json if arguments.json else encode_binary
    readings = _of_file(arguments.file) if arguments.file else made_up(arguments.taxels, arguments.rate, arguments.axes)
    with sender(arguments.address) as put:
        for number, reading in enumerate(islice(readings, arguments.count)):
            if not arguments.file:
                time.sleep(max(start + number / arguments.rate - time.monotonic(), 0.0))
            put(encode(replace(reading, time=time.time(), sequence=number % 2**32), token=arguments.token))
            sent += 1
    return sent


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return 0 for success, 1 for an error, 2 for bad usage."""
    parser = argparse.ArgumentParser(
        prog="python -m tactile_maps.live.sources.send", description=__doc__.splitlines()[0]
    )
    parser.add_argument("address", help="udp://127.0.0.1:9870, or zmq://127.0.0.1:9870 to publish there")
    parser.add_argument("--file", help="file of readings to send instead of generated ones")
    parser.add_argument("--taxels", type=int, default=100, help="number of taxels of generated readings (default 100)")
    parser.add_argument(
        "--axes", type=int, choices=(1, 3), default=1, help="values of each generated taxel: 3 with shear (default 1)"
    )
    parser.add_argument("--rate", type=float, default=100.0, help="rate of generated readings [Hz] (default 100)")
    parser.add_argument("--count", type=int, help="number of packets after which to stop")
    parser.add_argument("--token", help="token in every packet")
    parser.add_argument("--json", action="store_true", help="send JSON instead of compact packets")
    arguments = parser.parse_args(argv)
    for name, value, most in (("taxels", arguments.taxels, MOST_TAXELS), ("count", arguments.count, sys.maxsize)):
        if value is not None and not 1 <= value <= most:
            parser.error(f"argument --{name}: must be 1 to {most}")
    try:
        sent = send(arguments)
    except TactileMapsError as error:
        sys.stderr.write(f"send: {error}\n")
        return 2 if isinstance(error, UsageError) else 1
    except KeyboardInterrupt:
        return 130
    except OSError as error:
        sys.stderr.write(f"send: the packets cannot be sent: {system_message(error)}\n")
        return 1
    sys.stdout.write(f"sent {sent} packets\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
