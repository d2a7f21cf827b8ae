"""The accuracy panel: what each setting of a stage costs and gains on the user's own skin, chosen by a click.

``AccuracyView`` is the switch of stages, the work-precision diagram and the button that measures, in the column or in a
window of its own; ``AccuracyPanel`` keeps the results until the skin changes and asks the worker it was given.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import (
    QAbstractButton,
    QButtonGroup,
    QComboBox,
    QDialog,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QProgressBar,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from tactile_maps.editing.document import MapDocument
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import Skin
from tactile_maps.studies.budget.measurement import BudgetMeasurement
from tactile_maps.studies.stages.registry import STAGES
from tactile_maps.studies.study.work_precision import Diagram, Setting, Stage, Subject, Trial, diagram
from tactile_widgets.common.colours import DARK, Theme
from tactile_widgets.common.panel import Panel
from tactile_widgets.document.stage_settings import subject_of
from tactile_widgets.jobs.executor import Executor, Job
from tactile_widgets.jobs.measuring_jobs import measure_budget, measure_stage
from tactile_widgets.panels.model.budget_section import BudgetSection
from tactile_widgets.panels.model.reference_section import ReferenceSection
from tactile_widgets.plots.work_precision_plot import WorkPrecisionPlot

_DIED = "The measurement ended unexpectedly; the diagram before it is kept. Measure again."
_BUDGET = "budget"
"""Name of the measurement that is not of a stage."""
_COLUMNS = 2
"""Stages beside each other: more would not fit the column."""


class AccuracyView(QWidget):
    """Shows what it is told and says what the user does; decides nothing."""

    selection_changed = Signal()
    """Another stage or another error is wanted."""
    measure_requested = Signal()
    """Measure the stage."""
    cancelled = Signal()
    """Stop measuring."""
    chosen = Signal(Setting)
    """Use this setting."""
    enlarge_asked = Signal()
    """A window of its own is wanted, or no longer."""

    def __init__(self, theme: Theme, stages: Mapping[str, Stage] = STAGES, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("accuracy-board")
        self._stages = stages
        self._switch, self._errors = QButtonGroup(self), QComboBox(self)
        self._buttons: list[QPushButton] = []
        self.plot = WorkPrecisionPlot(theme, self)
        self.plot.chosen.connect(self.chosen)
        self._question, self._note = _caption("accuracy-question", self), _caption("accuracy-note", self)
        self._measure, self._cancel = QPushButton("Measure", self), QPushButton("Cancel", self)
        self._progress, self._enlarge = QProgressBar(self), QPushButton("Enlarge", self)
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.setSpacing(8)
        self._column.addLayout(self._make_switch())
        self._column.addLayout(self._make_error_row())
        self._column.addWidget(self._question)
        self._column.addWidget(self.plot, 1)
        self._column.addWidget(self._note)
        self._column.addLayout(self._make_measure_row())
        self._fill_errors()

    @property
    def stage(self) -> Stage:
        """The one that is shown."""
        return next(
            stage for stage, button in zip(self._stages.values(), self._buttons, strict=True) if button.isChecked()
        )

    @property
    def error(self) -> str:
        """Key of the error that is shown."""
        return str(self._errors.currentData())

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self.plot.set_theme(theme)

    def show_empty(self, text: str, *, can_measure: bool) -> None:
        """There is nothing to draw yet: say what would be."""
        self._question.setText(text)
        self._question.show()
        self.plot.hide()
        self._errors_shown(False)
        self._measure.setText("Measure")
        self._measure.setEnabled(can_measure)

    def show_diagram(self, diagram: Diagram, present: Setting | None, *, can_measure: bool) -> None:
        """Draw what was measured."""
        self._question.hide()
        self.plot.show()
        self._errors_shown(True)
        self.plot.show_diagram(diagram, present)
        self._measure.setText("Measure again")
        self._measure.setEnabled(can_measure)

    def say(self, text: str) -> None:
        """A line under the diagram: what it is of, what is missing, what went wrong."""
        self._note.setText(text)
        self._note.setVisible(bool(text))

    def show_progress(self, text: str, fraction: float) -> None:
        """Something is being measured."""
        self._progress.setValue(round(1000 * fraction))
        self._progress.setToolTip(text)
        self.say(text)
        self._working(True)

    def show_enlarged(self, on: bool) -> None:
        """Whether it has a window of its own."""
        self._enlarge.setText("Dock" if on else "Enlarge")

    def rest(self) -> None:
        """Nothing is being measured any more."""
        self._working(False)

    def _working(self, on: bool) -> None:
        self._progress.setVisible(on)
        self._cancel.setVisible(on)
        self._measure.setVisible(not on)

    def _errors_shown(self, on: bool) -> None:
        self._errors.setVisible(on)
        self._error_name.setVisible(on)

    def _make_switch(self) -> QGridLayout:
        grid = QGridLayout()
        grid.setSpacing(4)
        for number, (name, stage) in enumerate(self._stages.items()):
            button = QPushButton(stage.title, self)
            button.setObjectName(f"accuracy-{name}")
            button.setCheckable(True)
            button.setToolTip(stage.question)
            self._switch.addButton(button)
            self._buttons.append(button)
            grid.addWidget(button, number // _COLUMNS, number % _COLUMNS)
        self._buttons[0].setChecked(True)
        self._switch.buttonClicked.connect(self._on_stage_clicked)
        return grid

    def _make_error_row(self) -> QHBoxLayout:
        self._errors.setObjectName("accuracy-error")
        self._errors.setAccessibleName("Error")
        self._errors.activated.connect(self._on_error_chosen)
        self._error_name = QLabel("Error", self)
        self._error_name.setBuddy(self._errors)
        row = QHBoxLayout()
        row.setSpacing(8)
        row.addWidget(self._error_name)
        row.addWidget(self._errors, 1)
        return row

    def _make_measure_row(self) -> QHBoxLayout:
        self._measure.setObjectName("accuracy-measure")
        self._measure.setToolTip("Try every setting on your own skin, in another process")
        self._measure.clicked.connect(self.measure_requested)
        self._cancel.setObjectName("accuracy-cancel")
        self._cancel.setToolTip("Cancel, and keep the diagram before")
        self._cancel.clicked.connect(self.cancelled)
        self._progress.setRange(0, 1000)
        self._progress.setTextVisible(False)
        self._progress.setFixedHeight(6)
        self._progress.setMinimumWidth(40)  # by itself it would be too wide for the column
        self._progress.setAccessibleName("Progress")
        self._enlarge.setObjectName("accuracy-enlarge")
        self._enlarge.setToolTip("Show the diagrams in a separate window, or back in the panel")
        self._enlarge.clicked.connect(self.enlarge_asked)
        row = QHBoxLayout()
        row.setSpacing(8)
        row.addWidget(self._progress, 1)
        row.addWidget(self._cancel)
        row.addWidget(self._measure)
        row.addStretch()
        row.addWidget(self._enlarge)
        self._working(False)
        return row

    def _fill_errors(self) -> None:
        self._errors.clear()
        for number, kind in enumerate(self.stage.errors):
            self._errors.addItem(f"{kind.name} ({kind.unit})", kind.key)
            self._errors.setItemData(number, kind.tip, Qt.ItemDataRole.ToolTipRole)
        self._on_error_named()

    def _on_stage_clicked(self, _button: QAbstractButton) -> None:
        self._fill_errors()
        self.selection_changed.emit()

    def _on_error_chosen(self, _index: int) -> None:
        self._on_error_named()
        self.selection_changed.emit()

    def _on_error_named(self) -> None:
        self._errors.setToolTip(self._errors.currentData(Qt.ItemDataRole.ToolTipRole))


def _caption(name: str, parent: QWidget) -> QLabel:
    label = QLabel(parent)
    label.setObjectName(name)
    label.setProperty("role", "caption")
    label.setWordWrap(True)
    return label


@dataclass(frozen=True)
class _Measured:
    """What was measured of a stage: on what, and the state it was in."""

    subject: Subject
    basis: str
    trials: tuple[Trial, ...] = field(default_factory=tuple)


class AccuracyPanel(Panel):
    """Keeps what was measured until the skin changes. Nothing is measured unless the button is pressed.

    ``shut`` must be called before the window goes.
    """

    chosen = Signal(Setting)
    """Setting of the point that was clicked; see ``reflatten_for`` and ``edits_map``."""

    def __init__(self, theme: Theme = DARK, parent: QWidget | None = None) -> None:
        super().__init__("Accuracy and time", "accuracy-panel", parent)
        self._document: MapDocument | None = None
        self._skin: Skin | None = None
        self._prepared: PreparedScene | None = None
        self._selected: tuple[int, ...] = ()
        self._told: dict[str, Setting] = {}
        self._results: dict[str, _Measured] = {}
        self._running: tuple[str, _Measured] | None = None
        self._trouble = ""
        self._executor: Executor | None = None
        self.board = AccuracyView(theme, parent=self)
        self.board.selection_changed.connect(self._show)
        self.board.measure_requested.connect(self._on_asked)
        self.board.cancelled.connect(self._on_cancelled)
        self.board.chosen.connect(self.chosen)
        self.board.enlarge_asked.connect(self._on_enlarge_asked)
        self._away = QLabel("Shown in a separate window.", self)
        self._away.setProperty("role", "caption")
        self._window: _DetachedWindow | None = None
        self.budget = BudgetSection(self)
        self.budget.asked.connect(self._on_budget_asked)
        self.budget.cancelled.connect(self._on_cancelled)
        self.budget.applied.connect(self._on_budget_applied)
        self.reference = ReferenceSection(self)
        for widget in (self.board, self._away, self.budget, self.reference):
            self.column.addWidget(widget)
        self._away.hide()
        self._show()

    def measure_with(self, executor: Executor) -> None:
        """Measure with this executor; without one nothing can be measured."""
        self._executor = executor
        self._show()

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self.board.set_theme(theme)

    def show_prepared(self, prepared: PreparedScene) -> None:
        """The scene whose robot moves, for the stages that are about moving; its map comes as a document."""
        if prepared is not self._prepared:
            self.budget.forget()
        self._prepared = prepared
        self._show()

    def show_document(self, document: MapDocument | None, selected: tuple[int, ...] = ()) -> None:
        """The map as it is now, and the patches that are selected; with another skin everything measured is forgotten.

        Cost: 1 ms beside a diagram, nothing else while hidden.
        """
        self._document = document
        self._selected = selected
        skin = document.skin if document else None
        if skin is not self._skin:
            self._skin = skin
            self._results.clear()
            self.budget.forget()
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
        return self._executor is not None and self._executor.busy

    def _subject(self) -> Subject | None:
        """The selected patches, or all."""
        if self._document is None or self._executor is None:
            return None
        return self._now(self._document, self._selected or tuple(range(len(self._document.patches))))

    def _now(self, document: MapDocument, patches: tuple[int, ...]) -> Subject:
        """Patches as they are now, and the robot that they cover."""
        ours = self._prepared is not None and self._prepared.map.skin is document.skin
        return subject_of(document, patches, self._prepared if ours else None)

    def _show(self) -> None:
        stage = self.board.stage
        subject = self._subject()
        result = self._result(stage)
        if result is None or self._document is None:
            self.board.show_empty(_measure_hint(stage, subject), can_measure=subject is not None)
        else:
            now = self._now(self._document, result.subject.patches)
            drawn = diagram(stage, result.trials, error=self.board.error, subject=now)
            present = self._told.get(stage.name) or stage.current(now)
            self.board.show_diagram(drawn, present, can_measure=True)
        if self._running is None:
            self.board.rest()
            self.budget.rest()
            self.board.say(self._note(stage, result))
        self.budget.show_present(self._told, can_measure=subject is not None and subject.prepared is not None)

    def _result(self, stage: Stage) -> _Measured | None:
        """What there is to draw: what comes in now, or what was measured last."""
        if self._running is not None and self._running[0] == stage.name and self._running[1].trials:
            return self._running[1]
        return self._results.get(stage.name)

    def _note(self, stage: Stage, result: _Measured | None) -> str:
        trouble = self._trouble
        self._trouble = ""
        if result is None or self._document is None:
            return trouble
        now = self._now(self._document, result.subject.patches)
        stale = stage.fingerprint(now) != result.basis
        drawn = diagram(stage, result.trials, error=self.board.error)
        parts = (
            trouble,
            f"Measured on {result.subject.title}." if stage.recipes else "Measured on the whole map.",
            stage.certainty,
            "▲ The map has changed: measure again." if stale else "",
            f"Not available: {'; '.join(drawn.missing)}" if drawn.missing else "",
        )
        return " ".join(part for part in parts if part)

    def _on_asked(self) -> None:
        subject = self._subject()
        if subject is not None:
            stage = self.board.stage
            job = Job(measure_stage, stage.name, subject, died=_DIED, deferrable=True)
            self._measure(job, stage.name, _Measured(subject, stage.fingerprint(subject)))

    def _on_budget_asked(self, paths: bool) -> None:
        subject = self._subject()
        if subject is not None:
            job = Job(measure_budget, subject, paths, died=_DIED, deferrable=True)
            self._measure(job, _BUDGET, _Measured(subject, ""))

    def _measure(self, job: Job[Any], name: str, measured: _Measured) -> None:
        if self._executor is not None:
            self._executor.close()
            self._running = (name, measured)
            self._on_progressed("starting", 0.0)
            self._executor.start(
                job, self._on_finished, self._on_failed, progressed=self._on_progressed, received=self._on_tried
            )

    def _on_budget_applied(self, settings: tuple[Setting, ...]) -> None:
        for setting in settings:
            if setting != self._told.get(setting.stage):
                self.chosen.emit(setting)

    @property
    def _budgeting(self) -> bool:
        return self._running is not None and self._running[0] == _BUDGET

    def _on_progressed(self, text: str, fraction: float) -> None:
        if self._budgeting:
            self.budget.show_progress(text, fraction)
            return
        name = self._running[0] if self._running else self.board.stage.name
        self.board.show_progress(f"{name.capitalize()}: {text}…", fraction)

    def _on_tried(self, trials: tuple[Trial, ...]) -> None:
        if self._running is not None:
            name, measured = self._running
            self._running = (name, replace(measured, trials=(*measured.trials, *trials)))
            self._show()

    def _on_finished(self, budget: BudgetMeasurement | None) -> None:
        if self._running is not None:
            name, measured = self._running
            self._stop()
            if budget is None:
                self._results[name] = measured
            else:
                self.budget.show_measured(budget)
            self._show()

    def _on_failed(self, text: str) -> None:
        self._stop()
        self._trouble = f"▲ {text}"
        self._show()

    def _on_cancelled(self) -> None:
        self._stop()
        self._show()

    def _stop(self) -> None:
        self._running = None
        if self._executor is not None:
            self._executor.close()

    def _on_enlarge_asked(self) -> None:
        if self._window is not None:
            self._window.close()
            return
        self._window = _DetachedWindow(self.board, _outermost(self))
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


def _outermost(widget: QWidget) -> QWidget:
    """The window that outlasts all others: that of a panel that stands apart goes when the panel comes back."""
    window = widget.window()
    while (parent := window.parentWidget()) is not None:
        window = parent.window()
    return window


class _DetachedWindow(QDialog):
    """The board in a window of its own, until it is closed."""

    ended = Signal()

    def __init__(self, board: AccuracyView, parent: QWidget) -> None:
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


def _measure_hint(stage: Stage, subject: Subject | None) -> str:
    """What measuring would show, and how long it takes."""
    if subject is None:
        return f"{stage.question} Open a robot to measure its skin."
    what = subject.title if stage.recipes else "the whole map"
    errors = ", ".join(kind.name.lower() for kind in stage.errors)
    took = f"about {max(round(stage.seconds(subject)), 1)}\u202fs"
    return f"{stage.question} Measuring {what} takes {took} and draws each setting: {errors}, against milliseconds."
