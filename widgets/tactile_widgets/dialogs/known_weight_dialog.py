"""Asks for a known weight that lies on the skin, tells how calibrating by it goes, takes it back, saves the gains."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QDoubleSpinBox,
    QFileDialog,
    QFormLayout,
    QLabel,
    QPushButton,
    QWidget,
)

from tactile_maps.live.channels.weighing import LONGEST
from tactile_maps.live.session.measured_session import MeasuredFacts

_STEPS = (
    "1. Tare while nothing touches the skin.\n"
    "2. Lay the weight on; select the taxels under it, or none for the whole skin.\n"
    "3. Measure. The mean of the readings over the time sets the gains."
)
_SCOPE_TIP = (
    "Of a weight on selected taxels only their readings are summed, and only their gains change,\n"
    "unless nothing was calibrated before: then all gains take the same factor"
)
_KINDS = "Calibration (*.csv)"


class KnownWeightDialog(QDialog):
    """Stays beside the window while taxels are selected there."""

    measure_wanted = Signal(float, float)
    """Calibrate by so many kilograms, by the mean over so many seconds."""
    undo_wanted = Signal()
    """Go back to the calibration before the newest weight."""
    save_wanted = Signal(str)
    """Write the gains to this file."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("known-weight")
        self.setWindowTitle("Calibrate by a known weight")
        self.setMinimumWidth(420)
        form = QFormLayout(self)
        steps = QLabel(_STEPS, self)
        steps.setWordWrap(True)
        form.addRow(steps)
        self.grams = self._number("weight-grams", 0.1, 100_000.0, 500.0, "\u202fg")
        form.addRow("Weight", self.grams)
        self.seconds = self._number("weight-seconds", 0.1, LONGEST, 2.0, "\u202fs")
        form.addRow("Mean over", self.seconds)
        self.scope = QLabel(self)
        self.scope.setObjectName("weight-scope")
        self.scope.setToolTip(_SCOPE_TIP)
        form.addRow("It lies on", self.scope)
        self.state = QLabel(self)
        self.state.setObjectName("weight-state")
        self.state.setWordWrap(True)
        self.state.setMinimumHeight(3 * self.state.fontMetrics().lineSpacing())
        form.addRow(self.state)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close, self)
        self.measure = self._button(buttons, "Measure", self._on_measure_clicked)
        self.undo = self._button(buttons, "Undo", self.undo_wanted.emit)
        self.save = self._button(buttons, "Save gains…", self._on_save_clicked)
        buttons.rejected.connect(self.reject)
        form.addRow(buttons)

    def show_selected(self, count: int) -> None:
        """So many taxels are selected."""
        noun = "taxel" if count == 1 else "taxels"
        self.scope.setText(f"{count} selected {noun}" if count else "The whole skin")

    def show_facts(self, facts: MeasuredFacts, *, error: str = "") -> None:
        """How it goes; ``error`` is why the newest wish was refused."""
        weighing = facts.weighing
        self.measure.setEnabled(facts.tared and not facts.taring and weighing.left is None)
        self.undo.setEnabled(weighing.undoable or weighing.left is not None)
        self.save.setEnabled(facts.calibrated)
        if weighing.left is not None:
            text = f"Measuring, {weighing.left:.1f}\u202fs left" if weighing.left > 0 else "Waiting for a reading"
        elif error or weighing.problem:
            text = error or str(weighing.problem)
        elif facts.taring or not facts.tared:
            text = "Taring…" if facts.taring else "Not tared yet: press Tare while nothing touches the skin."
        elif weighing.factor is not None:
            text = f"Done: gains × {weighing.factor:.4g}. Readings are shown as pressure, contacts in newtons."
        else:
            text = "Calibrated." if facts.calibrated else "Not calibrated."
        self.state.setText(text)

    def _number(self, name: str, low: float, high: float, value: float, unit: str) -> QDoubleSpinBox:
        box = QDoubleSpinBox(self)
        box.setObjectName(name)
        box.setRange(low, high)
        box.setDecimals(1)
        box.setValue(value)
        box.setSuffix(unit)
        return box

    def _button(self, buttons: QDialogButtonBox, text: str, clicked: object) -> QPushButton:
        button = buttons.addButton(text, QDialogButtonBox.ButtonRole.ActionRole)
        button.setAutoDefault(False)
        button.clicked.connect(clicked)
        return button

    def _on_measure_clicked(self) -> None:
        self.measure_wanted.emit(1e-3 * self.grams.value(), self.seconds.value())

    def _on_save_clicked(self) -> None:
        path = QFileDialog.getSaveFileName(self, "Save gains and offsets", "gains.csv", _KINDS)[0]
        if path:
            self.save_wanted.emit(path)
