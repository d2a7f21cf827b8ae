"""A running session in Foxglove and Lichtblick: a WebSocket server with the same messages as recordings.

The topic ``/skin/contacts`` has the wrenches of the contacts as JSON, with the fields of the message in ROS 2 bags.

By default it listens on this computer only. Viewers are read-only: nothing that they send is used.
"""

from __future__ import annotations

import json
import logging
import time
from weakref import ref

import foxglove
from foxglove.websocket import ChannelView, Client, ServerListener

from tactile_maps.core.errors import ExportError
from tactile_maps.export.contact_messages import CONTACTS_SCHEMA, CONTACTS_TYPE, contacts_json
from tactile_maps.export.live_viewer import LiveViewer
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.recording.encoding.viewer_messages import (
    CONTACTS_TOPIC,
    ENCODING,
    ROBOT_TOPIC,
    ViewerMessages,
)
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene

LOOPBACK = "127.0.0.1"
PORT = 8765
"""Default port of viewers."""
_WRENCHES = "/skin/contacts"
_DRIFT_NS = 500_000_000
"""Maximum deviation of the messages' times from the wall clock [ns]; the times restart when it is exceeded."""


class LiveServer(LiveViewer):
    """Server for one session; ``close`` disconnects its viewers.

    Args:
        prepared: The scene of the session.
        host: Address on which to listen; by default only reachable from this computer.
        port: Port; 0 for any free one.

    Attributes:
        address: Address for viewers: ``ws://HOST:PORT``.

    Raises:
        ExportError: The port is in use, or the host is not an address of this computer.
    """

    def __init__(
        self,
        prepared: PreparedScene,
        *,
        host: str = LOOPBACK,
        port: int = PORT,
    ) -> None:
        super().__init__(prepared)
        self._opening_due = True
        # The context is kept because channels close with it. Viewers that disconnect without notice are not logged.
        self._context = context = foxglove.Context()
        logging.getLogger("foxglove.websocket").setLevel(logging.CRITICAL)
        listener = _Listener(self)
        try:
            self._server = foxglove.start_server(
                name="Tactile Maps", host=host, port=port, context=context, server_listener=listener
            )
        except (RuntimeError, OSError) as error:
            place = f"{host}:{port}"
            remedy = "Choose another port, or an address of this computer"
            raise ExportError("the live server cannot start", place=place, value=error, remedy=remedy) from error
        self.address = f"ws://{host}:{self._server.port}"
        self._messages = self._fresh(0)
        self._channels = {
            topic: foxglove.Channel(
                topic,
                message_encoding=ENCODING,
                schema=foxglove.Schema(name=schema.name, encoding=schema.encoding, data=schema.data),
                context=context,
            )
            for topic, schema in self._messages.schemas.items()
        }
        schema = foxglove.Schema(
            name=CONTACTS_TYPE, encoding="jsonschema", data=json.dumps(CONTACTS_SCHEMA).encode("utf8")
        )
        self._wrenches = foxglove.Channel(_WRENCHES, message_encoding="json", schema=schema, context=context)
        self._last = -1
        self._thread.start()

    def _disconnect(self) -> None:
        self._server.stop()

    def request_opening(self) -> None:
        """Send the robot's surfaces, which are sent once, to a viewer that connects later."""
        with self._changed:
            self._opening_due = True
            self._changed.notify()

    def _fresh(self, tick: int) -> ViewerMessages:
        """Return messages whose times match the wall clock, with ``tick`` at the current time."""
        self._started = time.time_ns() - self._after(tick)
        return ViewerMessages(self._prepared, started=self._started)

    def _after(self, tick: int) -> int:
        return round(1e9 * tick * self._prepared.scene.tick)

    def _loop(self) -> None:
        frame: Frame | None = None
        while True:
            with self._changed:
                while self._waiting is None and not self._closed and not (self._opening_due and frame is not None):
                    self._changed.wait()
                if self._closed:
                    return
                opening = self._opening_due
                self._opening_due = False
                waiting = self._waiting
                self._waiting = None
            if waiting is not None:
                frame = waiting[0]
                self._follow(*waiting)
            if frame is not None:
                self._send(frame, opening=opening, new=waiting is not None)

    def _follow(self, frame: Frame, map_: TactileMap) -> None:
        """Restart the times if they jump: after a reset, or if the session was paused."""
        lag = time.time_ns() - self._started - self._after(frame.tick)
        if frame.tick < self._last or abs(lag) > _DRIFT_NS:
            self._messages = self._fresh(frame.tick)
            self._opening_due = True
            self._messages.use_map(map_)
        elif map_ is not self._map:
            self._messages.use_map(map_)
        self._map = map_
        self._last = frame.tick

    def _send(self, frame: Frame, *, opening: bool, new: bool) -> None:
        messages = self._messages.opening(frame.tick) if opening else []
        if new:
            messages += self._messages.of(frame)
        at = self._started + self._after(frame.tick)
        for topic, data in messages:
            self._channels[topic].log(data, log_time=at)
            if topic == CONTACTS_TOPIC:  # sent at the same rate
                text = json.dumps(contacts_json(frame, self._prepared.skin, at), allow_nan=False)
                self._wrenches.log(text.encode("utf8"), log_time=at)


class _Listener(ServerListener):
    """Reports subscriptions; other actions of viewers have no effect.

    Refers to the server weakly: the library may release its listener only when it is used again.
    """

    def __init__(self, server: LiveServer) -> None:
        self._server = ref(server)

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        """Report a subscription to the robot's surfaces; called on the thread of the library."""
        server = self._server()
        if server is not None and channel.topic == ROBOT_TOPIC:
            server.request_opening()
