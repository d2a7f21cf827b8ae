"""A running session in an open Rerun viewer, to which this program connects."""

from __future__ import annotations

import socket
from urllib.parse import urlsplit

import numpy as np

from tactile_maps.core.errors import ExportError, packages_of
from tactile_maps.export.live_viewer import LiveViewer
from tactile_maps.export.rerun_log import RerunLog
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.pressure_colours import rounded_scale
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene

VIEWER = "rerun+http://127.0.0.1:9876/proxy"
"""Default address of a viewer that was started by ``rerun``."""
_PERIOD = 0.04
"""Session time between two frames that are sent [s]: more often than a viewer displays."""
_LOOK_EVERY = 2.0
"""Time between two checks that the viewer is still open [s]: Rerun buffers without limit what it cannot send."""


class LiveRerun(LiveViewer):
    """Sends frames to a viewer, which keeps its data when the connection ends.

    Args:
        prepared: The scene of the session.
        address: Address of the viewer.

    Attributes:
        address: Value of the argument.

    Raises:
        ExportError: The address is invalid, the package is not installed, or no viewer listens there.
    """

    def __init__(self, prepared: PreparedScene, *, address: str = VIEWER) -> None:
        self._place = _place_of(address)
        with packages_of("rerun"):
            import rerun
        self.address = address
        self._rerun = rerun
        if not _listens(self._place):
            remedy = "Start the viewer first: rerun"
            raise ExportError("no Rerun viewer listens there", place=address, remedy=remedy)
        super().__init__(prepared)
        self._stream = rerun.RecordingStream("tactile-maps")
        self._stream.connect_grpc(address)
        self._scale = rounded_scale(0.0)
        self._next = -np.inf
        self._log = RerunLog(prepared, rerun, self._stream, scale=self._scale)
        self._log.open()
        self._thread.start()

    def _disconnect(self) -> None:
        self._stream.disconnect()

    def _loop(self) -> None:
        looked = 0.0
        while True:
            with self._changed:
                while self._waiting is None and not self._closed:
                    self._changed.wait()
                if self._waiting is None:
                    return
                frame, map_ = self._waiting
                self._waiting = None
            if frame.time < self._next - _PERIOD:
                self._next = -np.inf  # a reset, or an earlier time in a recording
            if frame.time < self._next:
                continue
            self._next = frame.time + _PERIOD
            if abs(frame.time - looked) > _LOOK_EVERY:
                looked = frame.time
                if not _listens(self._place):
                    return
            self._send(frame, map_)

    def _send(self, frame: Frame, map_: TactileMap) -> None:
        if map_ is not self._map:
            self._map = map_
            self._log.use_map(map_)
        scale = rounded_scale(1e-3 * frame.highest_pressure)
        if scale > self._scale:
            self._scale = scale
            self._log.use_scale(scale)
        self._stream.set_time("time", duration=frame.time)
        self._log.add(frame)
        for event in frame.events:
            self._stream.log("events", self._rerun.TextLog(event.words, level="INFO"))


def _place_of(address: str) -> tuple[str, int]:
    """Return host and port.

    Raises:
        ExportError: The address is not that of a viewer.
    """
    try:
        parts = urlsplit(address)
        host = parts.hostname
        port = parts.port
    except ValueError:
        host = port = None
    if not port or host is None or not parts.scheme.startswith("rerun") or parts.path != "/proxy":
        raise ExportError("invalid address of a Rerun viewer", value=address, remedy=f"Give one like {VIEWER}")
    return host, port


def _listens(place: tuple[str, int]) -> bool:
    try:
        with socket.create_connection(place, timeout=1.0):
            return True
    except OSError:
        return False
