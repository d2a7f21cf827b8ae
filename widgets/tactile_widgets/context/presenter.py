"""Base class of presenters, and the progress of their background work."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QWidget

from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.notifier import Notifier


class Presenter(QObject):
    """Connects actions, views, panels, session and document for one topic.

    Args:
        context: Session, views, panels and services of the window.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        super().__init__(parent)
        self._context = context
        self._session = context.session
        self._notifier = context.notifier
        self._window = parent


class JobProgress(QObject):
    """Progress of one kind of background work in the status line.

    Args:
        notifier: Shows the progress.
        cancel: Called when the user cancels the work.
    """

    def __init__(self, notifier: Notifier, cancel: Callable[[], object]) -> None:
        super().__init__(notifier)
        self._notifier = notifier
        self._cancel = cancel
        notifier.cancelled.connect(self._on_cancelled)

    def show(self, text: str, fraction: float | None = None) -> None:
        """Show the current stage and its progress, 0 to 1; None if the progress is unknown."""
        self._notifier.progress(self, text, fraction)

    def end(self) -> None:
        """Hide the progress of work that was completed, failed or cancelled."""
        self._notifier.done(self)

    def _on_cancelled(self, job: object) -> None:
        if job is self:
            self._cancel()
