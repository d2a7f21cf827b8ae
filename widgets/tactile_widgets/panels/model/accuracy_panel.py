"""The accuracy panel: cost and accuracy of each setting of a stage, measured on the user's own skin.

A click on a setting applies it. ``AccuracyView`` has the buttons of the stages, the work-precision diagram and the
button that measures, in the column or in a separate window; ``AccuracyPanel`` keeps the results until the skin changes,
and runs measurements in an executor.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import QButtonGroup, QComboBox, QDialog, QLabel, QPushButton, QWidget

from tactile_maps.editing.document import MapDocument
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import Skin
from tactile_maps.studies.budget.measurement import BudgetMeasurement
from tactile_maps.studies.stages.registry import STAGES
from tactile_maps.studies.study.work_precision import Diagram, Setting, Stage, Subject, Trial, diagram
from tactile_widgets.common.colours import DARK, Theme
from tactile_widgets.common.make import (
    add_items,
    button_grid,
    caption_label,
    column_layout,
    make,
    progress_bar,
    push_button,
    row_layout,
    show_text,
)
from tactile_widgets.common.panel import Panel
from tactile_widgets.document.stage_settings import subject_of
from tactile_widgets.jobs.executor import Executor, Job
from tactile_widgets.jobs.measuring_jobs import measure_budget, measure_stage
from tactile_widgets.panels.model.budget_section import BudgetSection
from tactile_widgets.panels.model.reference_section import ReferenceSection
from tactile_widgets.plots.work_precision_plot import WorkPrecisionPlot

_REPLAYING = "Measurements are those of the session; return to it to see them."
_DIED = "The measurement ended unexpectedly; the diagram before it is kept. Measure again."
_BUDGET = "budget"
"""Name of the measurement that does not belong to a stage."""


class AccuracyView(QWidget):
    """Stage, error, diagram and progress."""

    selection_changed = Signal()
    """The user chose another stage or another error."""
    measure_requested = Signal()
    """The user starts the measurement of the stage."""
    cancelled = Signal()
    """The user cancels the measurement."""
    chosen = Signal(Setting)
    """Setting of the point that was clicked."""
    enlarge_requested = Signal()
    """The user opens or closes the separate window."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("accuracy-board")
        self._switch = make(QButtonGroup, self, idClicked=self._on_stage_clicked)
        for number, (name, stage) in enumerate(STAGES.items()):
            button = make(
                QPushButton, stage.title, self, objectName=f"accuracy-{name}", checkable=True, toolTip=stage.question
            )
            self._switch.addButton(button, number)
        self._switch.button(0).setChecked(True)
        self._errors = make(
            QComboBox, self, objectName="accuracy-error", accessibleName="Error", activated=self._on_error_chosen
        )
        self._error_name = make(QLabel, "Error", self, buddy=self._errors)
        self._question = caption_label(self, "accuracy-question")
        self.plot = make(WorkPrecisionPlot, theme, self, chosen=self.chosen)
        self._note = caption_label(self, "accuracy-note")
        self._progress = make(progress_bar, self, minimumWidth=40)
        tip = "Cancel, and keep the previous diagram"
        self._cancel = push_button(self, "accuracy-cancel", "Cancel", tip, self.cancelled)
        tip = "Try every setting on your own skin, in a separate process"
        self._measure = push_button(self, "accuracy-measure", "Measure", tip, self.measure_requested)
        tip = "Show the diagrams in a separate window, or back in the panel"
        self._enlarge = push_button(self, "accuracy-enlarge", "Enlarge", tip, self.enlarge_requested)
        column_layout(
            button_grid(self._switch.buttons()),
            row_layout(self._error_name, self._errors, stretch=self._errors),
            self._question,
            self.plot,
            self._note,
            row_layout(self._progress, self._cancel, self._measure, None, self._enlarge, stretch=self._progress),
            parent=self,
            stretch=self.plot,
        )
        self._show_working(False)
        self._fill_errors()

    @property
    def stage(self) -> Stage:
        """Current stage."""
        return list(STAGES.values())[self._switch.checkedId()]

    @property
    def error(self) -> str:
        """Key of the current error."""
        return str(self._errors.currentData())

    def set_theme(self, theme: Theme) -> None:
        """Use another theme."""
        self.plot.set_theme(theme)

    def show_empty(self, text: str, *, can_measure: bool) -> None:
        """Show what a measurement would show."""
        self._question.setText(text)
        self._show_parts("Measure", empty=True, can_measure=can_measure)

    def show_diagram(self, diagram: Diagram, present: Setting | None, *, can_measure: bool) -> None:
        """Show the result of a measurement."""
        self._show_parts("Measure again", empty=False, can_measure=can_measure)
        self.plot.show_diagram(diagram, present)

    def _show_parts(self, measure: str, *, empty: bool, can_measure: bool) -> None:
        self._question.setVisible(empty)
        for part in (self.plot, self._errors, self._error_name):
            part.setHidden(empty)
        self._measure.setText(measure)
        self._measure.setEnabled(can_measure)

    def say(self, text: str) -> None:
        """Show a line below the diagram: what was measured, what is missing, or an error."""
        show_text(self._note, text)

    def show_progress(self, text: str, fraction: float) -> None:
        """Show the progress of a measurement."""
        self._progress.setValue(round(1000 * fraction))
        self._progress.setToolTip(text)
        self.say(text)
        self._show_working(True)

    def show_enlarged(self, on: bool) -> None:
        """Show that the view is in a separate window, or in the panel."""
        self._enlarge.setText("Dock" if on else "Enlarge")

    def rest(self) -> None:
        """Show that nothing is being measured."""
        self._show_working(False)

    def _show_working(self, on: bool) -> None:
        self._progress.setVisible(on)
        self._cancel.setVisible(on)
        self._measure.setVisible(not on)

    def _fill_errors(self) -> None:
        self._errors.clear()
        add_items(self._errors, ((f"{kind.name} ({kind.unit})", kind.key, kind.tip) for kind in self.stage.errors))
        self._show_error_tip()

    def _on_stage_clicked(self) -> None:
        self._fill_errors()
        self.selection_changed.emit()

    def _on_error_chosen(self) -> None:
        self._show_error_tip()
        self.selection_changed.emit()

    def _show_error_tip(self) -> None:
        self._errors.setToolTip(self._errors.currentData(Qt.ItemDataRole.ToolTipRole))


@dataclass(frozen=True)
class _Measured:
    """Results of a stage, the subject of the measurement, and the state of the subject at that time."""

    subject: Subject
    basis: str
    trials: tuple[Trial, ...] = ()


class AccuracyPanel(Panel):
    """Measurements by stage, kept until the skin changes; nothing is measured before the button is pressed.

    ``shut`` must be called before the window is closed.
    """

    chosen = Signal(Setting)
    """Setting of the point that was clicked; see ``reflatten_for`` and ``edits_map``."""

    def __init__(self, theme: Theme = DARK, parent: QWidget | None = None) -> None:
        super().__init__("Accuracy and time", "accuracy-panel", parent)
        self._document: MapDocument | None = None
        self._skin: Skin | None = None
        self._prepared: PreparedScene | None = None
        self._selected: tuple[int, ...] = ()
        self._present: dict[str, Setting] = {}
        self._results: dict[str, _Measured] = {}
        self._running: tuple[str, _Measured] | None = None
        self._error = ""
        self._executor: Executor
        self._editable = True
        self._window: _DetachedWindow | None = None
        self.board = make(
            AccuracyView,
            theme,
            self,
            selection_changed=self._show,
            measure_requested=self._on_measure_requested,
            cancelled=self._on_cancelled,
            chosen=self.chosen,
            enlarge_requested=self._on_enlarge_requested,
        )
        self._detached = make(QLabel, "Shown in a separate window.", self, role="caption")
        self.budget = make(
            BudgetSection,
            self,
            measure_requested=self._on_budget_requested,
            cancelled=self._on_cancelled,
            applied=self._on_budget_applied,
        )
        self.reference = ReferenceSection(self)
        for widget in (self.board, self._detached, self.budget, self.reference):
            self.column.addWidget(widget)
        self._detached.hide()
        self._show()

    def measure_with(self, executor: Executor) -> None:
        """Set the executor of measurements, before anything is shown."""
        self._executor = executor
        self._show()

    def set_theme(self, theme: Theme) -> None:
        self.board.set_theme(theme)

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Take another scene for the stages that move the robot; its map arrives as a document."""
        if prepared is not self._prepared:
            self.budget.forget()
        self._prepared = prepared
        self._show()

    def show_document(self, document: MapDocument | None, selected: tuple[int, ...] = ()) -> None:
        """Take the current map and the selected patches; another skin discards all measurements.

        Cost: 1 ms with a diagram, nothing while hidden.
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

    def set_editable(self, *, editable: bool) -> None:
        """Hide the measurements of the session while a recording is shown."""
        self._editable = editable
        self._show()

    def show_present(self, setting: Setting) -> None:
        """Take a current setting that is not part of the document: image, touch, simulation or control."""
        self._present[setting.stage] = setting
        self._show()

    def shut(self) -> None:
        """Stop the measurement and close the separate window, permanently."""
        self._stop()
        if self._window is not None:
            self._window.close()

    @property
    def busy(self) -> bool:
        """Whether something is being measured."""
        return self._executor.busy

    def _subject(self) -> Subject | None:
        """Return the selected patches, or all, as subject of a measurement."""
        if self._document is None or not self._editable:
            return None
        return self._now(self._document, self._selected or tuple(range(len(self._document.patches))))

    def _now(self, document: MapDocument, patches: tuple[int, ...]) -> Subject:
        """Return the current state of patches, and the robot that they cover."""
        ours = self._prepared is not None and self._prepared.map.skin is document.skin
        return subject_of(document, patches, self._prepared if ours else None)

    def _show(self) -> None:
        stage = self.board.stage
        subject = self._subject()
        result = self._result(stage)
        if result is None or self._document is None:
            hint = _measure_hint(stage, subject) if self._editable else _REPLAYING
            self.board.show_empty(hint, can_measure=subject is not None)
        else:
            now = self._now(self._document, result.subject.patches)
            drawn = diagram(stage, result.trials, error=self.board.error, subject=now)
            present = self._present.get(stage.name) or stage.current(now)
            self.board.show_diagram(drawn, present, can_measure=True)
        if self._running is None:
            self.board.rest()
            self.budget.rest()
            self.board.say(self._note(stage, result))
        self.budget.show_present(self._present, can_measure=subject is not None and subject.prepared is not None)

    def _result(self, stage: Stage) -> _Measured | None:
        """Return the results of the running measurement, or of the last one; None while a recording is shown."""
        if not self._editable:
            return None
        if self._running is not None and self._running[0] == stage.name and self._running[1].trials:
            return self._running[1]
        return self._results.get(stage.name)

    def _note(self, stage: Stage, result: _Measured | None) -> str:
        error = self._error
        self._error = ""
        if result is None or self._document is None:
            return error
        now = self._now(self._document, result.subject.patches)
        drawn = diagram(stage, result.trials, error=self.board.error)
        parts = (
            error,
            f"Measured on {result.subject.title}." if stage.recipes else "Measured on the whole map.",
            stage.certainty,
            "▲ The map has changed: measure again." if stage.fingerprint(now) != result.basis else "",
            f"Not available: {'; '.join(drawn.missing)}" if drawn.missing else "",
        )
        return " ".join(filter(None, parts))

    def _on_measure_requested(self) -> None:
        subject = self._subject()
        if subject is not None:
            stage = self.board.stage
            job = Job(measure_stage, stage.name, subject, died=_DIED, deferrable=True)
            self._measure(job, stage.name, _Measured(subject, stage.fingerprint(subject)))

    def _on_budget_requested(self, paths: bool) -> None:
        subject = self._subject()
        if subject is not None:
            job = Job(measure_budget, subject, paths, died=_DIED, deferrable=True)
            self._measure(job, _BUDGET, _Measured(subject, ""))

    def _measure(self, job: Job[Any], name: str, measured: _Measured) -> None:
        self._executor.close()
        self._running = (name, measured)
        self._on_progressed("starting", 0.0)
        self._executor.start(
            job, self._on_finished, self._on_failed, progressed=self._on_progressed, received=self._on_tried
        )

    def _on_budget_applied(self, settings: tuple[Setting, ...]) -> None:
        for setting in settings:
            if setting != self._present.get(setting.stage):
                self.chosen.emit(setting)

    def _on_progressed(self, text: str, fraction: float) -> None:
        name = self._running[0] if self._running else self.board.stage.name
        if name == _BUDGET:
            self.budget.show_progress(text, fraction)
        else:
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
        self._error = f"▲ {text}"
        self._show()

    def _on_cancelled(self) -> None:
        self._stop()
        self._show()

    def _stop(self) -> None:
        self._running = None
        self._executor.close()

    def _on_enlarge_requested(self) -> None:
        if self._window is not None:
            self._window.close()
            return
        self._window = _DetachedWindow(self.board, _main_window(self))
        self._window.ended.connect(self._on_window_ended)
        self._detached.show()
        self.board.show_enlarged(True)
        self._window.show()

    def _on_window_ended(self) -> None:
        self.column.insertWidget(0, self.board)
        self.board.show()
        self._detached.hide()
        self.board.show_enlarged(False)
        if self._window is not None:
            self._window.deleteLater()
            self._window = None


def _main_window(widget: QWidget) -> QWidget:
    """Return the main window; the window of an undocked panel is destroyed when the panel returns to the column."""
    window = widget.window()
    while (parent := window.parentWidget()) is not None:
        window = parent.window()
    return window


class _DetachedWindow(QDialog):
    """Separate window of the view, until it is closed."""

    ended = Signal()

    def __init__(self, board: AccuracyView, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("accuracy-window")
        self.setWindowTitle("Accuracy and time")
        self.resize(820, 640)
        column_layout(board, parent=self, margins=(16, 16, 16, 16))
        board.show()

    def done(self, result: int) -> None:
        """Close on Escape."""
        super().done(result)
        self.ended.emit()

    def closeEvent(self, event: QCloseEvent) -> None:
        event.accept()
        self.ended.emit()


def _measure_hint(stage: Stage, subject: Subject | None) -> str:
    """Return what a measurement would show, and its duration."""
    if subject is None:
        return f"{stage.question} Open a robot to measure its skin."
    what = subject.title if stage.recipes else "the whole map"
    errors = ", ".join(kind.name.lower() for kind in stage.errors)
    took = f"about {max(round(stage.seconds(subject)), 1)}\u202fs"
    return f"{stage.question} Measuring {what} takes {took} and draws each setting: {errors}, against milliseconds."
