"""Ends the window when the system requests it: a real robot is stopped and the recording completed first."""

from __future__ import annotations

import os
import signal
import socket
from types import FrameType

from PySide6.QtCore import QObject, QSocketNotifier, Signal

from tactile_maps.core.interrupts import ENDING
from tactile_widgets.session.session_host import SessionHost


class EndingSignals(QObject):
    """Reports SIGTERM, SIGHUP and SIGQUIT in Qt's event loop; those that were ignored before stay ignored.

    Qt runs no Python code while it waits for events, so Python's handlers alone would run late. The interpreter writes
    the number of a signal to a socket at once, and Qt watches the socket.
    """

    arrived = Signal(int)
    """Number of the signal."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._near, self._far = socket.socketpair()
        for end in (self._near, self._far):
            end.setblocking(False)
        self._before = {number: signal.getsignal(number) for number in ENDING}
        self._woken = signal.set_wakeup_fd(self._far.fileno(), warn_on_full_buffer=False)
        for number, handler in self._before.items():
            if handler is signal.SIG_DFL:
                signal.signal(number, _ignore)
        self._notifier = QSocketNotifier(self._near.fileno(), QSocketNotifier.Type.Read, self)
        self._notifier.activated.connect(self._on_notifier_activated)

    def close(self) -> None:
        """Restore the handlers that were set before."""
        self._notifier.setEnabled(False)
        signal.set_wakeup_fd(self._woken)
        for number, handler in self._before.items():
            signal.signal(number, handler)
        self._near.close()
        self._far.close()

    def _on_notifier_activated(self) -> None:
        for number in self._near.recv(64):
            if number in ENDING:
                self.arrived.emit(number)


def end_at_once(live: SessionHost, number: int) -> None:
    """Stop the robot, complete the recording, and end the process without questions.

    Nothing else is saved: unsaved edits are offered at the next start, as after a crash.
    """
    try:
        if live.live_input is not None:
            live.live_input.stop_motion()
        live.close()
    finally:
        os._exit(128 + number)


def _ignore(_number: int, _frame: FrameType | None) -> None:
    """Keep the system from ending the process; the number arrives by the socket."""
