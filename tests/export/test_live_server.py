"""A viewer receives the topics and the messages of a recording; connections from elsewhere are rejected."""

from __future__ import annotations

import base64
import gc
import json
import os
import socket
import struct
import time
import weakref

import foxglove
import pytest

from tactile_maps.core.errors import ExportError
from tactile_maps.export.live_server import LOOPBACK, LiveServer
from tactile_maps.recording.encoding.viewer_messages import viewer_schemas
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import PokePressed
from tests.support.recordings import small_arm


class Viewer:
    """The least of a Foxglove client: it greets, subscribes to all topics, and reads."""

    def __init__(self, address):
        host, port = address.removeprefix("ws://").split(":")
        self._socket = socket.create_connection((host, int(port)), timeout=60)
        key = base64.b64encode(os.urandom(16)).decode()
        lines = [
            "GET / HTTP/1.1",
            f"Host: {host}:{port}",
            "Upgrade: websocket",
            "Connection: Upgrade",
            f"Sec-WebSocket-Key: {key}",
            "Sec-WebSocket-Version: 13",
            "Sec-WebSocket-Protocol: foxglove.sdk.v1",
        ]
        self._socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        head = b""
        while not head.endswith(b"\r\n\r\n"):
            head += self._socket.recv(1)
        assert b"101" in head.splitlines()[0]
        self.topics = {}

    def _exactly(self, count):
        data = b""
        while len(data) < count:
            more = self._socket.recv(count - len(data))
            if not more:
                raise ConnectionError
            data += more
        return data

    def read(self):
        """Kind (1 text, 2 binary) and content of the next message."""
        first, second = self._exactly(2)
        length = second & 127
        if length == 126:
            (length,) = struct.unpack(">H", self._exactly(2))
        elif length == 127:
            (length,) = struct.unpack(">Q", self._exactly(8))
        return first & 15, self._exactly(length)

    def subscribe(self, count):
        """Subscribe to all topics after ``count`` of them were advertised."""
        while len(self.topics) < count:
            kind, content = self.read()
            received = json.loads(content) if kind == 1 else {}
            if received.get("op") == "advertise":
                self.topics |= {one["id"]: one for one in received.get("channels", [])}
        subscriptions = [{"id": number, "channelId": number} for number in self.topics]
        self._send(json.dumps({"op": "subscribe", "subscriptions": subscriptions}).encode())

    def _send(self, data):
        mask = os.urandom(4)
        head = struct.pack(">BBH", 0x81, 0x80 | 126, len(data)) + mask
        self._socket.sendall(head + bytes(byte ^ mask[place % 4] for place, byte in enumerate(data)))

    def messages_of(self, topics):
        """Time and content of the first message of each of ``topics``."""
        found = {}
        while not set(topics) <= set(found):
            kind, content = self.read()
            if kind == 2 and content[0] == 1:
                number, at = struct.unpack_from("<IQ", content, 1)
                found.setdefault(self.topics[number]["topic"], (at, content[13:]))
        return found

    def close(self):
        self._socket.close()


@pytest.fixture
def server():
    with LiveServer(small_arm(), port=0) as server:
        yield server


@pytest.fixture
def viewer(server):
    viewer = Viewer(server.address)
    yield viewer
    viewer.close()


def test_viewer_receives_every_topic_also_those_published_once(server, viewer):
    prepared = small_arm()
    session = Session(prepared)
    session.submit(PokePressed(1, prepared.skin.taxel_point(30)))
    for _ in range(10):
        server.offer(session.tick(), prepared.map)
    schemas = viewer_schemas(prepared)
    viewer.subscribe(len(schemas))
    for _ in range(40):
        server.offer(session.tick(), prepared.map)
        time.sleep(0)  # the server's thread may take each
    found = viewer.messages_of({"/robot"})
    assert b"forearm" in found["/robot"][1]
    session.reset()  # begins again: everything is due
    server.offer(session.tick(), prepared.map)
    found = viewer.messages_of(set(schemas) - {"/robot", "/events"})
    for topic, (at, data) in found.items():
        assert abs(at - time.time_ns()) < 60e9
        assert data
        assert next(one for one in viewer.topics.values() if one["topic"] == topic)["schemaName"] == schemas[topic].name


def test_server_listens_on_this_computer_only(server):
    assert server.address.startswith(f"ws://{LOOPBACK}:")


def test_port_in_use_is_reported_with_a_remedy(server):
    port = int(server.address.rpartition(":")[2])
    with pytest.raises(ExportError, match=r"cannot start.*Choose another port"):
        LiveServer(small_arm(), port=port)


def test_closed_server_does_not_respond():
    alone = "127.93.7.5"  # of this computer too; on the usual one another test may be given the port that is free now
    server = LiveServer(small_arm(), host=alone, port=0)
    port = int(server.address.rpartition(":")[2])
    socket.create_connection((alone, port), timeout=2).close()
    server.close()
    server.close()
    with pytest.raises(ConnectionError):
        _connect_until_refused(alone, port)


def test_closed_server_is_not_kept_by_its_listener(monkeypatch):
    """The library releases the listener of a closed server when it is used again, or at once, by chance."""
    listeners = []
    start = foxglove.start_server

    def start_and_keep(*, server_listener, **settings):
        listeners.append(server_listener)
        return start(server_listener=server_listener, **settings)

    monkeypatch.setattr(foxglove, "start_server", start_and_keep)
    server = LiveServer(small_arm(), port=0)
    server.close()
    kept = weakref.ref(server)
    del server
    gc.collect()
    assert len(listeners) == 1
    assert kept() is None


def _connect_until_refused(host, port):
    """The server's own thread lets go of the port a moment later."""
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        socket.create_connection((host, port), timeout=2).close()
