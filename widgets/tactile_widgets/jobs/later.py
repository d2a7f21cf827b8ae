"""Calls after the pending events, for Qt objects that may be deleted before.

PySide's ``QTimer.singleShot(0, receiver, function)`` keeps the function for ever if the receiver is deleted first.
"""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, Qt, Signal


class _Call(QObject):
    requested = Signal(object)

    def __init__(self, receiver: QObject) -> None:
        super().__init__(receiver)
        self.requested.connect(self._call, Qt.ConnectionType.QueuedConnection)

    def _call(self, function: Callable[[], object]) -> None:
        self.deleteLater()
        function()


def call_later(receiver: QObject, function: Callable[[], object]) -> None:
    """Call ``function`` after the pending events, or release it uncalled if ``receiver`` is deleted first."""
    _Call(receiver).requested.emit(function)
