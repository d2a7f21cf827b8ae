"""Switch, diagram and the button that measures: what the Accuracy/time panel holds, or its own window."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QAbstractButton,
    QButtonGroup,
    QComboBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QProgressBar,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from app.experiments.stages.table import STAGES
from app.experiments.work_precision import Diagram, Setting, Stage
from widgets.colours import Theme
from widgets.panels.work_precision_plot import WorkPrecisionPlot

_ABREAST = 2
"""Stages beside each other: more would not fit the column."""


class AccuracyBoard(QWidget):
    """Shows what it is told and says what the hand does; decides nothing."""

    turned = Signal()
    """Another stage or another error is wanted."""
    asked = Signal()
    """Measure the stage."""
    cancelled = Signal()
    """Stop measuring."""
    chosen = Signal(object)
    """Use this Setting."""
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
        self._enlarge.setText("Bring back" if on else "Enlarge")

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
            grid.addWidget(button, number // _ABREAST, number % _ABREAST)
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
        self._measure.setToolTip("Try every setting on your own skin, in a process beside the simulation")
        self._measure.clicked.connect(self.asked)
        self._cancel.setObjectName("accuracy-cancel")
        self._cancel.setToolTip("Stop, and keep the diagram before")
        self._cancel.clicked.connect(self.cancelled)
        self._progress.setRange(0, 1000)
        self._progress.setTextVisible(False)
        self._progress.setFixedHeight(6)
        self._progress.setMinimumWidth(40)  # by itself it would be too wide for the column
        self._progress.setAccessibleName("Progress")
        self._enlarge.setObjectName("accuracy-enlarge")
        self._enlarge.setToolTip("Show the diagrams in a window of their own, or back in the column")
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
        self.turned.emit()

    def _on_error_chosen(self, _index: int) -> None:
        self._on_error_named()
        self.turned.emit()

    def _on_error_named(self) -> None:
        self._errors.setToolTip(self._errors.currentData(Qt.ItemDataRole.ToolTipRole))


def _caption(name: str, parent: QWidget) -> QLabel:
    label = QLabel(parent)
    label.setObjectName(name)
    label.setProperty("role", "caption")
    label.setWordWrap(True)
    return label
