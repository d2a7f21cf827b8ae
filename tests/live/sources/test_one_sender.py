"""A stream belongs to the first sender of a valid packet until it falls silent."""

from __future__ import annotations

from tactile_maps.live.sources.one_sender import OWNED_SECONDS, OneSender

OWNER = ("127.0.0.1", 5001)
OTHER = ("127.0.0.1", 5002)


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


def one_sender():
    clock = Clock()
    return OneSender(lambda packet: packet == b"valid", clock=clock), clock


def test_first_valid_packet_decides_the_sender():
    stream, _ = one_sender()
    assert stream.admits(b"none", OTHER)  # the decoder counts it as malformed
    assert stream.admits(b"valid", OWNER)
    assert not stream.admits(b"valid", OTHER)
    assert not stream.admits(b"none", OTHER)
    assert stream.admits(b"valid", OWNER)
    assert stream.refused == {"127.0.0.1:5002": 2}


def test_silent_owner_is_replaced_by_another_sender():
    stream, clock = one_sender()
    stream.admits(b"valid", OWNER)
    clock.now = OWNED_SECONDS
    assert not stream.admits(b"valid", OTHER)
    clock.now = OWNED_SECONDS + 0.01
    assert stream.admits(b"valid", OTHER)
    assert not stream.admits(b"valid", OWNER)


def test_excess_sender_addresses_are_counted_together():
    stream, _ = one_sender()
    stream.admits(b"valid", OWNER)
    for port in range(1000, 2000):
        stream.admits(b"valid", ("127.0.0.1", port))
    assert len(stream.refused) == 17
    assert stream.refused["other addresses"] == 1000 - 16
