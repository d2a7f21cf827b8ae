"""How presenters speak to a person: the message bar, the status line, and the progress of jobs beside the window."""

from __future__ import annotations

import traceback
from collections import Counter
from collections.abc import Sequence

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QStatusBar

from tactile_maps.core.errors import describe_unexpected_error
from tactile_widgets.context.notification_bar import HintBar, NotificationBar
from tactile_widgets.context.progress_indicator import ProgressIndicator

STATUS_MS = 5_000
INTRODUCTION_MS = 20_000


class Notifier(QObject):
    """Says things, each in its place. Mutable: it knows which jobs are under way and which faults were told.

    Args:
        bar: For what must not be missed.
        hints: The first hints.
        status: For what may be missed.
        progress: For jobs.
        parent: Qt parent.
    """

    cancelled = Signal(str)
    """The job whose progress was shown is not wanted any more: its key."""
    told = Signal(str, bool)
    """What was said, and whether something failed."""
    hints_dismissed = Signal()
    """The first hints are not wanted any more."""

    def __init__(
        self,
        bar: NotificationBar,
        hints: HintBar,
        status: QStatusBar,
        progress: ProgressIndicator,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._bar = bar
        self._hints = hints
        self._status = status
        self._progress = progress
        self._jobs: dict[str, tuple[str, float | None]] = {}
        self._faults: Counter[str] = Counter()
        progress.cancelled.connect(self._on_cancelled)
        hints.dismissed.connect(self.hints_dismissed)

    def say(
        self, text: str, *, fault: bool = False, remedies: Sequence[QAction] = (), dismiss: str = "Dismiss"
    ) -> None:
        """Show a message over the views; see ``NotificationBar.say``."""
        self._bar.say(text, fault=fault, remedies=remedies, dismiss=dismiss)
        self.told.emit(text, fault)

    def offer(self, text: str, *, remedies: Sequence[QAction], dismiss: str) -> None:
        """Offer something until it is answered; see ``NotificationBar.offer``."""
        self._bar.offer(text, remedies=remedies, dismiss=dismiss)
        self.told.emit(text, False)

    def withdraw(self) -> None:
        """Do not offer it any more."""
        self._bar.withdraw()

    def fault(self, text: str) -> None:
        """Say what could not be done."""
        self.say(text, fault=True)

    def unexpected(self, error: BaseException) -> None:
        """Say what nobody foresaw, and keep its details in a file: once for each distinct fault, then count.

        Code that runs once a frame fails once a frame; a thousand equal files would hide the first.
        """
        key = _fault_key(error)
        self._faults[key] += 1
        if self._faults[key] == 1:
            self.fault(describe_unexpected_error(error))
        else:
            self.status(f"The same unexpected error again: {type(error).__name__}, {self._faults[key]} times")

    def status(self, text: str, milliseconds: int = STATUS_MS) -> None:
        """Show a line at the window's lower edge for a while; an empty one clears it."""
        self._status.showMessage(text, milliseconds)

    def introduce(self, text: str, suggestion: str) -> None:
        """Say what a scene shows and what to try in it: for a while at the lower edge, and among the messages."""
        words = f"{text} Try: {suggestion}" if suggestion else text
        self._status.showMessage(words, INTRODUCTION_MS)
        self.told.emit(words, False)

    # Jobs.

    def progress(self, job: str, text: str, fraction: float | None = None) -> None:
        """A job goes on.

        Args:
            job: Its key; of several jobs, the one that began last is shown.
            text: The stage.
            fraction: How far the whole is, 0 to 1; None where nobody knows.
        """
        self._jobs[job] = text, fraction
        self._show_jobs()

    def done(self, job: str) -> None:
        """A job is not under way any more: done, failed or cancelled. Nothing for one that was not."""
        if self._jobs.pop(job, None) is not None:
            self._show_jobs()

    def _show_jobs(self) -> None:
        if self._jobs:
            self._progress.show_progress(*list(self._jobs.values())[-1])
        else:
            self._progress.clear()

    def _on_cancelled(self) -> None:
        if self._jobs:
            self.cancelled.emit(list(self._jobs)[-1])

    # Hints.

    def show_hints(self, *, shown: bool) -> None:
        """Show the first hints, or hide them."""
        self._hints.setVisible(shown)


def _fault_key(error: BaseException) -> str:
    """The same for faults of one kind at one place: its type, and each file and line on the way to it."""
    lines = [f"{frame.filename}:{frame.lineno}" for frame in traceback.extract_tb(error.__traceback__)]
    return " ".join([type(error).__qualname__, *lines])
