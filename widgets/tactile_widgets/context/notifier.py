"""Messages to the user: the message bar, the status line, and the progress of background jobs."""

from __future__ import annotations

import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QStatusBar

from tactile_maps.core.errors import TactileMapsError, describe_unexpected_error
from tactile_widgets.context.notification_bar import HintBar, Message, MessageStack
from tactile_widgets.context.progress_indicator import ProgressIndicator

STATUS_MS = 5_000
INTRODUCTION_MS = 20_000


class Notifier(QObject):
    """Shows messages and progress. Mutable: it stores the running jobs and the reported faults.

    Args:
        messages: Shows messages that must not be missed.
        hints: Shows the first hints.
        status: Shows messages that may be missed.
        progress: Shows the progress of jobs.
        parent: Qt parent.
    """

    cancelled = Signal(object)
    """The job whose progress was shown when the user cancelled it."""
    message_shown = Signal(str, bool)
    """Text of a message, and whether it is about a failure."""
    hints_dismissed = Signal()
    """The user closed the first hints."""

    def __init__(
        self,
        messages: MessageStack,
        hints: HintBar,
        status: QStatusBar,
        progress: ProgressIndicator,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._messages = messages
        self._hints = hints
        self._status = status
        self._progress = progress
        self._jobs: dict[object, tuple[str, float | None]] = {}
        self._faults: Counter[str] = Counter()
        progress.cancelled.connect(self._on_cancelled)
        hints.dismissed.connect(self.hints_dismissed)

    def say(
        self,
        text: str,
        *,
        fault: bool = False,
        remedies: Sequence[QAction] = (),
        dismiss: str = "Dismiss",
        of: str = "",
        pending: Callable[[], bool] | None = None,
        warning: bool = False,
        lasting: bool = False,
    ) -> None:
        """Show a message over the views; see ``Message``."""
        message = Message(text, fault, remedies, dismiss, of, pending=pending, warning=warning, lasting=lasting)
        self._messages.show_message(message)
        self.message_shown.emit(text, fault)

    def offer(self, text: str, *, remedies: Sequence[QAction], dismiss: str) -> None:
        """Show a message until one of its buttons is pressed, or until ``withdraw``."""
        self._messages.show_message(Message(text, remedies=remedies, dismiss=dismiss, kept=True))
        self.message_shown.emit(text, False)

    def withdraw(self) -> None:
        """Hide the offer."""
        self._messages.withdraw()

    def succeed(self, of: str) -> None:
        """Hide the failures of an operation that succeeded; the list of messages keeps them."""
        self._messages.succeed(of)

    def drop_outdated(self) -> None:
        """Hide messages about what was shown before, because something else is; the list of messages keeps them."""
        self._messages.drop_outdated()

    def fault(self, text: str, *, of: str = "") -> None:
        """Show that an operation failed; the message is shown until the operation succeeds."""
        self.say(text, fault=True, of=of)

    def update_fault(self, text: str, *, of: str) -> None:
        """Replace the text of the failure of an operation, if it is still shown; the list of messages is unchanged."""
        self._messages.update_fault(text, of)

    @contextmanager
    def errors_shown(self, of: str, *, finishes: bool = True) -> Iterator[None]:
        """Show an error of the ``with`` block as a failure of an operation; without one, the operation succeeded.

        Args:
            of: The operation.
            finishes: False if the block only begins the operation, which may still fail.
        """
        try:
            yield
        except TactileMapsError as error:
            self.fault(str(error), of=of)
        else:
            if finishes:
                self.succeed(of)

    def unexpected(self, error: BaseException) -> None:
        """Report an unexpected error and save its details in a file, once for each distinct error; then count.

        An error in code that runs every frame would otherwise write thousands of equal files.
        """
        key = _fault_key(error)
        self._faults[key] += 1
        if self._faults[key] == 1:
            self.fault(describe_unexpected_error(error))
        else:
            self.status(f"The same unexpected error again: {type(error).__name__}, {self._faults[key]} times")

    def status(self, text: str, milliseconds: int = STATUS_MS) -> None:
        """Show a text in the status line for some time; an empty one clears it."""
        self._status.showMessage(text, milliseconds)

    def introduce(self, text: str, suggestion: str) -> None:
        """Show the description of a scene and what to try in it, in the status line and the list of messages."""
        words = f"{text} Try: {suggestion}" if suggestion else text
        self._status.showMessage(words, INTRODUCTION_MS)
        self.message_shown.emit(words, False)

    # Jobs.

    def progress(self, job: object, text: str, fraction: float | None = None) -> None:
        """Show the progress of a job.

        Args:
            job: The job; of several jobs, the one that began last is shown.
            text: The stage.
            fraction: Share of the whole job that is done, 0 to 1; None if unknown.
        """
        self._jobs[job] = text, fraction
        self._show_jobs()

    def done(self, job: object) -> None:
        """Remove a job that has finished, failed or been cancelled; others are ignored."""
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
    """Return a key of the error: its type, and each file and line of its traceback."""
    lines = [f"{frame.filename}:{frame.lineno}" for frame in traceback.extract_tb(error.__traceback__)]
    return " ".join([type(error).__qualname__, *lines])
