"""Live viewers of other programs (Foxglove, Rerun) that show the window's session."""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer, Signal

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.session.session_run import ShownSession

if TYPE_CHECKING:
    from tactile_maps.export.live_rerun import LiveRerun
    from tactile_maps.export.live_server import LiveServer

_RETRY_MS = 100
_MOST_TRIES = 50
"""Interval and number of attempts to share another scene: the system frees the port of a closed server late."""


class ViewerKind(Enum):
    """Programs whose viewers can show a session while it runs."""

    FOXGLOVE = "Foxglove"
    RERUN = "Rerun"


class Sharing(QObject):
    """Sends the frames that are shown to viewers of another program.

    Args:
        session: The session that is shown.
        parent: Qt parent.
    """

    changed = Signal(object)
    """Address at which viewers find the session, or of the viewer that shows it; None after sharing has ended."""

    def __init__(self, session: ShownSession, parent: QObject) -> None:
        super().__init__(parent)
        self._session = session
        self._server: LiveServer | LiveRerun | None = None
        self._kind = ViewerKind.FOXGLOVE
        self._tries = 0  # left until restarting fails
        self._again = QTimer(self)
        self._again.setInterval(_RETRY_MS)
        self._again.timeout.connect(self._try_again)

    @property
    def kind(self) -> ViewerKind | None:
        """Program whose viewers see the session; None while it is not shared."""
        return None if self._server is None else self._kind

    @property
    def address(self) -> str | None:
        """Address at which viewers find the session, or of the viewer that shows it; None while it is not shared."""
        return None if self._server is None else self._server.address

    def start(self, kind: ViewerKind = ViewerKind.FOXGLOVE) -> None:
        """Share with viewers on this computer; ends sharing with viewers of another kind."""
        source = self._session.source
        if source is None or self.kind is kind:
            return
        self.stop()
        self._kind = kind
        self._tries = 1
        self._try_again()
        if self._server is None:
            self.changed.emit(None)

    def stop(self) -> None:
        """Close the connection to viewers, if there is one."""
        self._again.stop()
        server = self._server
        self._server = None
        if server is not None:
            server.close()
            self.changed.emit(None)

    def restart(self) -> None:
        """Connect again for another scene, which has other topics."""
        if self._server is not None or self._again.isActive():
            self.stop()
            self._tries = _MOST_TRIES
            self._try_again()

    def _try_again(self) -> None:
        """Connect; try again later if the port of the closed server is not free yet."""
        self._again.stop()
        source = self._session.source
        if source is None:
            return
        try:
            self._server = _connect(self._kind, source.prepared)
        except TactileMapsError as error:
            self._tries -= 1
            if self._tries:
                self._again.start()
            else:
                self._session.report_failure(str(error))
            return
        self.changed.emit(self._server.address)
        if self._session.shown is not None:
            self.show_frame(self._session.shown)

    def show_frame(self, frame: Frame) -> None:
        """Send a frame; ends sharing if the viewer was closed."""
        if self._server is None or (source := self._session.source) is None:
            return
        if self._server.gone:
            self._session.report_failure(
                f"The viewer at {self._server.address} was closed: the session is no longer shown there."
            )
            self.stop()
        else:
            self._server.offer(frame, source.settings.map)


def _connect(kind: ViewerKind, prepared: PreparedScene) -> LiveServer | LiveRerun:
    """Connect to viewers; imports their library only now, so that the window starts without it."""
    if kind is ViewerKind.RERUN:
        from tactile_maps.export.live_rerun import LiveRerun

        return LiveRerun(prepared)
    from tactile_maps.export.live_server import LiveServer

    return LiveServer(prepared)
