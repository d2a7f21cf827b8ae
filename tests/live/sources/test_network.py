"""Real packets on the loopback: UDP sockets, and a ZeroMQ publisher."""

from __future__ import annotations

import socket

import numpy as np
import pytest

from tactile_maps.core.errors import LiveError, UsageError
from tactile_maps.live.prepare import as_measured
from tactile_maps.live.readings.readings import MalformedReadingError, Reading
from tactile_maps.live.readings.wire_format import encode_binary, encode_json
from tactile_maps.live.session.connection import Connection
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.live.sources.network import UdpSource, ZmqSource, check_listening
from tactile_maps.live.sources.open import SourceOptions, open_source
from tests.support.simulated_clock import SimulatedClock
from tests.support.touch import prepared_bar

SECRET = "a secret of ours"


def reading(number, count=5):
    return Reading(0.01 * number, [float(number)] * count, sequence=number)


@pytest.fixture
def udp():
    source = UdpSource("127.0.0.1", 0)
    source.open()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.connect(("127.0.0.1", source.port))
        yield source, sender
    source.close()


def test_udp_packets_arrive_and_foreign_ones_are_malformed(udp):
    source, sender = udp
    sender.send(encode_json(reading(1)))
    sender.send(b"hello")
    sender.send(encode_binary(reading(2, count=5000)))
    assert source.receive(1.0).sequence == 1
    with pytest.raises(MalformedReadingError):
        source.receive(1.0)
    assert len(source.receive(1.0).values) == 5000
    assert source.receive(0.0) is None


def test_port_in_use_is_rejected_and_a_closed_source_reports_it(udp):
    source, _ = udp
    other = UdpSource("127.0.0.1", source.port)
    with pytest.raises(LiveError, match="cannot listen on the port"):
        other.open()
    with pytest.raises(LiveError, match="not open"):
        other.receive(0.0)


def test_address_of_another_computer_is_not_blamed_on_the_port():
    source = UdpSource("192.0.2.1", 0, token=SECRET, remote=True)
    with pytest.raises(LiveError, match="this computer does not have the address.*127.0.0.1, or 0.0.0.0"):
        source.open()


@pytest.mark.parametrize("token", [None, SECRET])
@pytest.mark.parametrize("host", ["no-such-host.invalid", "no..such"])
@pytest.mark.parametrize("kind", ["udp", "zmq", "yarp"])
def test_unknown_host_is_named_with_and_without_a_token(kind, host, token):
    if kind == "zmq":
        pytest.importorskip("zmq")
    with pytest.raises(LiveError, match=rf"unknown host \(found: {host}\)\. Check its spelling"):
        open_source(f"{kind}://{host}:9870", SourceOptions(token=token)).open()


def test_packets_without_the_token_are_rejected():
    source = UdpSource("127.0.0.1", 0, token=SECRET)
    connection = Connection(source)
    connection.open()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for token in (None, "a guess of theirs", SECRET):
            sender.sendto(encode_binary(reading(1), token=token), ("127.0.0.1", source.port))
        for _ in range(3):
            connection.step(1.0)
    assert connection.take().reading.sequence == 1
    assert connection.take() is None
    assert connection.status.counts.malformed == 2
    assert SECRET not in connection.status.malformed
    connection.close()


@pytest.mark.parametrize("numbered", [True, False])
def test_udp_packet_with_an_outlying_time_does_not_advance_live_time(numbered):
    source = UdpSource("127.0.0.1", 0)
    clock = SimulatedClock()
    times = []
    connection = Connection(source, clock=clock)
    connection.open()
    measured = MeasuredSession(as_measured(prepared_bar()), connection.take)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for number in range(10):
            sent = 100 + 0.01 * number + (9.0 if number == 5 else 0.0)
            packet = Reading(sent, np.zeros(60), sequence=number if numbered else None)
            sender.sendto(encode_json(packet), ("127.0.0.1", source.port))
            clock.now = 0.01 * number
            connection.step(1.0)
            times.append(measured.tick().time)
    np.testing.assert_allclose(times, 0.01 * np.arange(10), atol=1e-4)
    assert measured.facts.mistimed == 1
    connection.close()


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.7"])
def test_other_machines_are_accepted_only_on_request_with_a_token(host):
    with pytest.raises(UsageError, match="is not enabled"):
        check_listening(host, remote=False, token=SECRET)
    for remote in (False, True):
        with pytest.raises(UsageError, match="open to other machines"):
            check_listening(host, remote=remote, token=None)
    check_listening(host, remote=True, token=SECRET)
    for own in ("127.0.0.1", "::1", "localhost"):
        check_listening(own, remote=False, token=None)


def test_publisher_is_received_again_after_a_pause():
    zmq = pytest.importorskip("zmq")
    source = None
    with zmq.Context() as context:
        with context.socket(zmq.PUB) as publisher:
            publisher.setsockopt(zmq.LINGER, 0)
            port = publisher.bind_to_random_port("tcp://127.0.0.1")
            source = ZmqSource("127.0.0.1", port)
            source.open()
            first = heard(source, publisher)
            publisher.send_multipart([b"topic", b"no reading"])
            with pytest.raises(MalformedReadingError):
                until_refused(source)
        with context.socket(zmq.PUB) as publisher:
            publisher.setsockopt(zmq.LINGER, 0)
            for _ in range(200):
                try:
                    publisher.bind(f"tcp://127.0.0.1:{port}")
                    break
                except zmq.ZMQError:
                    source.receive(0.01)  # until the system lets the port go
            again = heard(source, publisher)
    source.close()
    assert first.values.tolist() == again.values.tolist() == [7.0] * 5


def until_refused(source):
    """Readings that came before are passed over."""
    while True:
        source.receive(1.0)


def heard(source, publisher):
    """The first packet that arrives: a subscriber hears only what is published after it has joined."""
    for _ in range(500):
        publisher.send(encode_binary(reading(7)))
        if (found := source.receive(0.01)) is not None:
            return found
    raise AssertionError("nothing was heard")


def test_invalid_address_is_rejected():
    pytest.importorskip("zmq")
    with pytest.raises(LiveError, match="invalid address"):
        ZmqSource("127.0.0.1", -1).open()


def test_newest_packet_of_a_full_buffer_is_used_and_the_others_are_counted():
    source = UdpSource("127.0.0.1", 0)
    connection = Connection(source)
    connection.open()
    connection.keep_newest(on=True)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.connect(("127.0.0.1", source.port))
        for number in range(100):
            sender.send(encode_json(reading(number)))
    assert source.wait_for_packet(10.0)
    assert [item.reading.sequence for item in connection.take_newest(lambda _: False)] == [99]
    counts = connection.status.counts
    assert (counts.received, counts.superseded, counts.lost) == (100, 99, 0)
    connection.close()
    with pytest.raises(LiveError, match="not open"):
        source.wait_for_packet(0.0)
