"""Dialog that calibrates with a known weight on the skin, shows the progress, undoes it, and saves the gains."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QDoubleSpinBox, QFormLayout, QLabel, QWidget

from tactile_maps.live.calibration.weighing import LONGEST
from tactile_maps.live.session.facts import MeasuredFacts
from tactile_maps.live.session.reading_gap import ReadingGap
from tactile_widgets.common.make import make, push_button
from tactile_widgets.common.sentence import as_sentence

_STEPS = (
    "1. Tare while nothing touches the skin.\n"
    "2. Put the weight on; select the taxels under it, or none for the whole skin.\n"
    "3. Measure. The mean of the readings over the time sets the gains."
)
_SCOPE_TIP = (
    "With selected taxels only their readings are summed, and only their gains change,\n"
    "unless nothing was calibrated before: then all gains get the same factor"
)


class KnownWeightDialog(QDialog):
    """A dialog that stays open while taxels are selected in the window."""

    measure_requested = Signal(float, float)
    """Mass of the weight [kg], and the time over which the mean is taken [s]."""
    negative_requested = Signal()
    """The readings fell under the weight, and the user applies the negative gain."""
    undo_requested = Signal()
    """The user returns to the calibration before the last weight."""
    save_requested = Signal()
    """The user saves the gains."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("known-weight")
        self.setWindowTitle("Calibrate by a known weight")
        self.setMinimumWidth(420)
        self.grams = self._number("weight-grams", 100_000.0, 500.0, "\u202fg")
        self.seconds = self._number("weight-seconds", LONGEST, 2.0, "\u202fs")
        self.scope = make(QLabel, self, objectName="weight-scope", toolTip=_SCOPE_TIP)
        self.state = make(QLabel, self, objectName="weight-state", wordWrap=True)
        self.state.setMinimumHeight(3 * self.state.fontMetrics().lineSpacing())
        buttons = make(QDialogButtonBox, QDialogButtonBox.StandardButton.Close, self, rejected=self.reject)
        self.measure = push_button(self, "weight-measure", "Measure", "", self._on_measure_clicked, autoDefault=False)
        tip = "Use a negative gain, because the readings fall under the weight"
        self.negative = push_button(self, "weight-negative", "Apply", tip, self.negative_requested, autoDefault=False)
        self.negative.hide()
        self.undo = push_button(self, "weight-undo", "Undo", "", self.undo_requested, autoDefault=False)
        self.save = push_button(self, "weight-save", "Save gains…", "", self.save_requested, autoDefault=False)
        for button in (self.measure, self.negative, self.undo, self.save):
            buttons.addButton(button, QDialogButtonBox.ButtonRole.ActionRole)
        form = QFormLayout(self)
        form.addRow(make(QLabel, _STEPS, self, wordWrap=True))
        form.addRow("Weight", self.grams)
        form.addRow("Mean over", self.seconds)
        form.addRow("Location", self.scope)
        form.addRow(self.state)
        form.addRow(buttons)

    def show_selected(self, count: int) -> None:
        """Show the number of selected taxels."""
        noun = "taxel" if count == 1 else "taxels"
        self.scope.setText(f"{count} selected {noun}" if count else "The whole skin")

    def show_facts(self, facts: MeasuredFacts, gap: ReadingGap | None, *, error: str = "") -> None:
        """Show the state of the calibration, a gap in the readings it waits for, or the error of the last request."""
        weighing = facts.weighing
        self.measure.setEnabled(facts.tared and not facts.taring and weighing.left is None)
        self.negative.setVisible(weighing.falling)
        self.undo.setEnabled(weighing.undoable or weighing.left is not None)
        self.save.setEnabled(facts.known)
        if gap is not None and not error and (facts.taring or weighing.left is not None):
            text = f"{'The tare' if facts.taring else 'The measurement'} waits for readings: {gap.cause}."
        elif weighing.left is not None:
            text = f"Measuring, {weighing.left:.1f}\u202fs left" if weighing.left > 0 else "Waiting for a reading"
        elif weighing.falling and not error:
            text = "The readings fall under the weight: the gain is negative. Apply it?"
        elif error or weighing.problem:
            text = as_sentence(error or str(weighing.problem))
        elif facts.taring or not facts.tared:
            text = "Taring…" if facts.taring else "Not tared yet: press Tare while nothing touches the skin."
        elif weighing.factor is not None:
            shown = " Readings are shown as pressure, contacts in newtons." if facts.calibrated else ""
            text = f"Done: gains × {weighing.factor:.4g}.{shown}"
        else:
            text = "Calibrated." if facts.known else "Not calibrated."
        self.state.setText(text)
        self.setMinimumHeight(self.heightForWidth(self.width()))  # a layout alone would cut long text

    def _number(self, name: str, high: float, value: float, unit: str) -> QDoubleSpinBox:
        return make(
            QDoubleSpinBox, self, objectName=name, decimals=1, minimum=0.1, maximum=high, value=value, suffix=unit
        )

    def _on_measure_clicked(self) -> None:
        self.measure_requested.emit(1e-3 * self.grams.value(), self.seconds.value())
