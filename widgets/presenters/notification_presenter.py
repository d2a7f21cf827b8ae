"""What the session has to tell a person: what failed, what stopped it and how to keep that, what was saved."""

from __future__ import annotations

from datetime import datetime
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from widgets.presenters import file_presenter

if TYPE_CHECKING:
    from widgets.window.main_window import MainWindow


class NotificationPresenter(QObject):
    """Says it in the window's message bar, with what helps.

    Args:
        window: The window, with its session, actions and message bar made.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window, self._live = window, window.live
        self._live.failed.connect(self._on_failed)
        self._live.cost_worker.failed.connect(self._on_failed)
        self._live.halted.connect(self._on_halted)
        self._live.saved.connect(self._on_saved)
        window.action("save_report").triggered.connect(self.save_report)

    def save_report(self) -> None:
        """Keep what led to the stop where recordings are kept."""
        self._live.save_report(file_presenter.recordings_folder() / f"stopped {datetime.now():%Y-%m-%d %H.%M.%S}.mcap")

    def _on_failed(self, text: str) -> None:
        self._window.notification_bar.say(text, fault=True)

    def _on_halted(self, text: str) -> None:
        """What the physics could not do can be kept and repeated; what nobody foresaw cannot."""
        names = ("reset", "save_report") if self._live.can_report else ("reset",)
        self._window.notification_bar.say(text, fault=True, remedies=[self._window.action(name) for name in names])

    def _on_saved(self, path: str) -> None:
        self._window.notification_bar.say(f"Saved {path}")
        self._window.statusBar().showMessage(f"Saved {path}", 10_000)  # a second message may replace the first
        self._window.settings.add_recent(path)
