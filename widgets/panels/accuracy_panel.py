"""The Accuracy/time panel: what each setting of a stage costs and gains on the user's own skin, chosen by a click."""

from __future__ import annotations

from dataclasses import dataclass, field

from PySide6.QtCore import Signal
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import QDialog, QLabel, QVBoxLayout, QWidget

from app.editing.document import MapDocument
from app.experiments.work_precision import Setting, Stage, Subject, Trial, diagram
from app.session.prepare import Prepared
from app.skin.skin import Skin
from widgets.accuracy_process import AccuracyProcess
from widgets.colours import DARK, Theme
from widgets.panels.accuracy_board import AccuracyBoard
from widgets.panels.panel import Panel


@dataclass(frozen=True)
class _Result:
    """What was measured of a stage: on what, and the state it was in."""

    subject: Subject
    basis: str
    trials: tuple[Trial, ...] = field(default_factory=tuple)


class AccuracyPanel(Panel):
    """Keeps what was measured until the skin changes. Nothing is measured unless the button is pressed.

    ``shut`` must be called before the window goes.
    """

    chosen = Signal(object)
    """The Setting of a point that was clicked; see ``stages.table.wanted`` and ``edits_map``."""

    def __init__(self, theme: Theme = DARK, parent: QWidget | None = None) -> None:
        super().__init__("Accuracy and time", "accuracy-panel", parent)
        self._document: MapDocument | None = None
        self._skin: Skin | None = None
        self._prepared: Prepared | None = None
        self._selected: tuple[int, ...] = ()
        self._told: dict[str, Setting] = {}
        self._results: dict[str, _Result] = {}
        self._running: tuple[str, _Result] | None = None
        self._trouble = ""
        self._process = AccuracyProcess(self)
        self._process.progressed.connect(self._on_progressed)
        self._process.tried.connect(self._on_tried)
        self._process.finished.connect(self._on_finished)
        self._process.failed.connect(self._on_failed)
        self.board = AccuracyBoard(theme, parent=self)
        self.board.turned.connect(self._show)
        self.board.asked.connect(self._on_asked)
        self.board.cancelled.connect(self._on_cancelled)
        self.board.chosen.connect(self.chosen)
        self.board.enlarge_asked.connect(self._on_enlarge_asked)
        self._away = QLabel("Shown in its own window.", self)
        self._away.setProperty("role", "caption")
        self._window: _Enlarged | None = None
        for widget in (self.board, self._away):
            self.column.addWidget(widget)
        self._away.hide()
        self._show()

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self.board.set_theme(theme)

    def show_prepared(self, prepared: Prepared) -> None:
        """The scene whose robot moves, for the stages that are about moving; its map comes as a document."""
        self._prepared = prepared
        self._show()

    def show_document(self, document: MapDocument | None, selected: tuple[int, ...] = ()) -> None:
        """The map as it is now, and the patches that are selected; with another skin everything measured is forgotten.

        Cost: 1 ms beside a diagram, nothing else while hidden.
        """
        self._document, self._selected = document, selected
        skin = document.skin if document else None
        if skin is not self._skin:
            self._skin = skin
            self._results.clear()
            self._stop()
        self._show()

    def show_present(self, setting: Setting) -> None:
        """A setting in force that is not in the document: the view's image, later touch, simulation and control."""
        self._told[setting.stage] = setting
        self._show()

    def shut(self) -> None:
        """End what is being measured and close the own window, for good."""
        self._stop()
        if self._window is not None:
            self._window.close()

    @property
    def busy(self) -> bool:
        """Whether something is being measured."""
        return self._process.busy

    def _subject(self) -> Subject | None:
        """The selected patches, or all."""
        if self._document is None:
            return None
        return self._now(self._document, self._selected or tuple(range(len(self._document.patches))))

    def _now(self, document: MapDocument, patches: tuple[int, ...]) -> Subject:
        """Patches as they are now, and the robot that wears them."""
        ours = self._prepared is not None and self._prepared.map.skin is document.skin
        return Subject(document, patches, self._prepared if ours else None)

    def _show(self) -> None:
        stage, subject = self.board.stage, self._subject()
        result = self._result(stage)
        if result is None or self._document is None:
            self.board.show_empty(_promise(stage, subject), can_measure=subject is not None)
        else:
            drawn = diagram(stage, result.trials, error=self.board.error)
            now = self._now(self._document, result.subject.patches)
            present = self._told.get(stage.name) or stage.present(now)
            self.board.show_diagram(drawn, present, can_measure=True)
        if self._running is None:
            self.board.rest()
            self.board.say(self._note(stage, result))

    def _result(self, stage: Stage) -> _Result | None:
        """What there is to draw: what comes in now, or what was measured last."""
        if self._running is not None and self._running[0] == stage.name and self._running[1].trials:
            return self._running[1]
        return self._results.get(stage.name)

    def _note(self, stage: Stage, result: _Result | None) -> str:
        trouble, self._trouble = self._trouble, ""
        if result is None or self._document is None:
            return trouble
        now = self._now(self._document, result.subject.patches)
        stale = stage.basis(now) != result.basis
        drawn = diagram(stage, result.trials, error=self.board.error)
        parts = (
            trouble,
            f"Measured on {result.subject.title}." if stage.wanted else "Measured on the whole map.",
            "▲ The map has changed since: measure again." if stale else "",
            f"Not possible here: {'; '.join(drawn.missing)}" if drawn.missing else "",
        )
        return " ".join(part for part in parts if part)

    def _on_asked(self) -> None:
        subject = self._subject()
        if subject is None:
            return
        stage = self.board.stage
        self._running = (stage.name, _Result(subject, stage.basis(subject)))
        self._process.measure(stage.name, subject)

    def _on_progressed(self, text: str, fraction: float) -> None:
        name = self._running[0] if self._running else self.board.stage.name
        self.board.show_progress(f"{name.capitalize()}: {text}…", fraction)

    def _on_tried(self, trials: tuple[Trial, ...]) -> None:
        if self._running is not None:
            name, result = self._running
            self._running = (name, _Result(result.subject, result.basis, (*result.trials, *trials)))
            self._show()

    def _on_finished(self) -> None:
        if self._running is not None:
            name, result = self._running
            self._results[name] = result
        self._running = None
        self._show()

    def _on_failed(self, text: str) -> None:
        self._running, self._trouble = None, f"▲ {text}"
        self._show()

    def _on_cancelled(self) -> None:
        self._stop()
        self._show()

    def _stop(self) -> None:
        self._process.close()
        self._running = None

    def _on_enlarge_asked(self) -> None:
        if self._window is not None:
            self._window.close()
            return
        self._window = _Enlarged(self.board, self.window())
        self._window.ended.connect(self._on_window_ended)
        self._away.show()
        self.board.show_enlarged(True)
        self._window.show()

    def _on_window_ended(self) -> None:
        self.column.insertWidget(0, self.board)
        self.board.show()
        self._away.hide()
        self.board.show_enlarged(False)
        if self._window is not None:
            self._window.deleteLater()
            self._window = None


class _Enlarged(QDialog):
    """The board in a window of its own, until it is closed."""

    ended = Signal()

    def __init__(self, board: AccuracyBoard, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("accuracy-window")
        self.setWindowTitle("Accuracy and time")
        self.resize(820, 640)
        column = QVBoxLayout(self)
        column.setContentsMargins(16, 16, 16, 16)
        column.addWidget(board)
        board.show()

    def done(self, result: int) -> None:
        """Qt: Escape."""
        super().done(result)
        self.ended.emit()

    def closeEvent(self, event: QCloseEvent) -> None:
        """Qt: the window's own button."""
        event.accept()
        self.ended.emit()


def _promise(stage: Stage, subject: Subject | None) -> str:
    """What measuring would show, and how long it takes."""
    if subject is None:
        return f"{stage.question} Open a robot to measure its skin."
    what = subject.title if stage.wanted else "the whole map"
    errors = ", ".join(kind.name.lower() for kind in stage.errors)
    took = f"about {max(round(stage.seconds(subject)), 1)}\u2009s"
    return f"{stage.question} Measuring {what} takes {took} and draws each setting: {errors}, against milliseconds."
