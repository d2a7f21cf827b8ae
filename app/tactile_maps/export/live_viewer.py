"""Common part of the connections to viewers: the newest frame, sent by a separate thread."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from typing import Self

from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene


class LiveViewer(ABC):
    """Connection of a session to viewers. Mutable; ``close`` ends it. Also a context manager.

    Frames are passed in memory; a separate thread sends the newest one, so that the session never waits for it.

    Args:
        prepared: The scene of the session.
    """

    def __init__(self, prepared: PreparedScene) -> None:
        self._prepared = prepared
        self._map = prepared.map
        self._changed = threading.Condition()
        self._closed = False
        self._waiting: tuple[Frame, TactileMap] | None = None
        self._thread = threading.Thread(target=self._loop, name=type(self).__name__, daemon=True)

    def offer(self, frame: Frame, map_: TactileMap) -> None:
        """Show a frame on the current map; thread-safe, without waiting. Cost: 2 µs."""
        with self._changed:
            self._waiting = frame, map_
            self._changed.notify()

    @property
    def gone(self) -> bool:
        """Whether the viewer was closed, so that nothing more is sent."""
        return not self._thread.is_alive()

    def close(self) -> None:
        """End the connection. Closing it again has no effect."""
        with self._changed:
            if self._closed:
                return
            self._closed = True
            self._changed.notify()
        self._thread.join()
        self._disconnect()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @abstractmethod
    def _loop(self) -> None:
        """Send the frames that are offered, until ``close`` is called or the viewer is gone."""

    @abstractmethod
    def _disconnect(self) -> None:
        """Release the connection, after the thread has ended."""
