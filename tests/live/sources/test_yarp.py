"""A YARP port by its documented text-mode protocol, spoken here by a small server: no YARP was run."""

from __future__ import annotations

import socket
import threading
from contextlib import contextmanager

import pytest

from tactile_maps.core.errors import LiveError, UsageError
from tactile_maps.live.readings.readings import MalformedReadingError
from tactile_maps.live.sources.open import open_source
from tactile_maps.live.sources.yarp import YarpSource


@contextmanager
def port(messages, *, known=None):
    """A port that sends ``messages`` to each new subscriber and responds to queries for ``known`` names."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            while True:
                try:
                    accepted, _ = server.accept()
                except OSError:
                    return
                with accepted, accepted.makefile("rw", newline="") as stream:
                    for line in stream:
                        words = line.strip().split()
                        if words[:1] == ["CONNECT"]:
                            stream.write(f"Welcome {words[1]}\r\n")
                        elif words == ["r"]:
                            stream.write(messages)
                            stream.flush()
                            break
                        elif words[:1] == ["query"] and known and words[1] in known:
                            stream.write(f"registration name {words[1]} ip 127.0.0.1 port {known[words[1]]} type tcp\n")
                            stream.write("*** end of message\n")
                        elif words[:1] == ["query"]:
                            stream.write("*** end of message\n")
                        stream.flush()

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        yield server.getsockname()[1]
        server.shutdown(socket.SHUT_RDWR)
    thread.join()


STATE = "do 2654 1215723086.25\n10.0 10.5 -10.0\ndo 2655 1215723086.75\r\n11.0 (12.0 13)\r\n"


def test_messages_have_number_time_and_values():
    with port(STATE) as number:
        source = YarpSource("127.0.0.1", number)
        source.open()
        first = source.receive(2.0)
        second = source.receive(2.0)
        assert (first.sequence, first.time, first.values.tolist()) == (2654, 1215723086.25, [10.0, 10.5, -10.0])
        assert (second.sequence, second.values.tolist()) == (2655, [11.0, 12.0, 13.0])
        with pytest.raises(LiveError, match="connection is lost"):
            source.receive(2.0)
        source.close()


def test_link_in_the_address_applies_to_all_channels():
    with port(STATE) as number:
        source = open_source(f"yarp://127.0.0.1:{number}?link=l_forearm")
        source.open()
        reading = source.receive(2.0)
        assert (reading.ids.tolist(), reading.links) == ([0, 1, 2], ("l_forearm",) * 3)
        assert source.address == f"yarp://127.0.0.1:{number}?link=l_forearm"
        source.close()
    with pytest.raises(UsageError, match=r"unknown parameter .found: part.. Choose link"):
        open_source("yarp://127.0.0.1:5?part=arm")


def test_messages_without_envelope_get_the_arrival_time_and_text_is_malformed():
    with port("do\n1 2\nd\nhello yarp\ndo\n3 4\n") as number:
        source = YarpSource("127.0.0.1", number, clock=lambda: 7.0)
        source.open()
        first = source.receive(2.0)
        assert (first.sequence, first.time, first.values.tolist()) == (None, 7.0, [1.0, 2.0])
        with pytest.raises(MalformedReadingError):
            source.receive(2.0)
        assert source.receive(2.0).values.tolist() == [3.0, 4.0]
        source.close()


def test_name_server_resolves_a_port():
    with port(STATE) as number, port("", known={"/skin/torso": number}) as names:
        source = YarpSource("127.0.0.1", names, name="/skin/torso")
        source.open()
        assert source.receive(2.0).sequence == 2654
        source.close()
        with pytest.raises(LiveError, match="does not know the port .found: /skin/arm"):
            YarpSource("127.0.0.1", names, name="/skin/arm").open()


def test_unresponsive_server_is_reported():
    with socket.create_server(("127.0.0.1", 0)) as server:
        number = server.getsockname()[1]
    with pytest.raises(LiveError, match="YARP does not respond"):
        YarpSource("127.0.0.1", number).open()
