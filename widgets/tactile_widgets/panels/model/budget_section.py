"""Budget: give milliseconds, or millimetres and newtons; what is proposed for every stage, applied and gone back from.

It shows what it is told and says what the user does; the panel around it measures, and whoever owns a stage applies.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from html import escape

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QProgressBar, QPushButton, QVBoxLayout, QWidget

from tactile_maps.core.errors import BudgetError
from tactile_maps.session.frame import Frame
from tactile_maps.studies.budget.measurement import TIMED_STAGES, BudgetMeasurement
from tactile_maps.studies.budget.proposal import Budget, Proposal, fastest_path, propose
from tactile_maps.studies.budget.wording import number_words, proposal_words, setting_words
from tactile_maps.studies.study.work_precision import Setting
from tactile_widgets.common.number_field import NumberField
from tactile_widgets.common.wheel_guard import guard_wheel

_TIME = "time"
_ERRORS = "errors"
_WATCHED = 200
_EVERY = 50
"""Ticks of which the median is shown as measured, and how often it is renewed."""


class BudgetSection(QWidget):
    """The limits, what is proposed within them, and what came of it."""

    asked = Signal(bool)
    """Measure, and propose; whether controllers are wanted too."""
    cancelled = Signal()
    """Stop measuring."""
    applied = Signal(tuple)
    """Apply these settings, ``Setting`` each."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("budget")
        self._measured: BudgetMeasurement | None = None
        self._present: dict[str, Setting] = {}
        self._found: Proposal | None = None
        self._proposed: tuple[Setting, ...] = ()
        self._before: tuple[Setting, ...] = ()
        self._predicted: float | None = None
        self._spent: deque[float] = deque(maxlen=_WATCHED)
        self._ticks = 0
        self._can_measure = False
        self.kind = QComboBox(self)
        self.limits = {
            "milliseconds": NumberField("Time per tick", "ms", 0.05, 100.0, 0.05, _TIME_TIP, self),
            "millimetres": NumberField("Error of the place", "mm", 0.1, 50.0, 0.1, _PLACE_TIP, self),
            "newtons": NumberField("Error of the force", "N", 0.01, 10.0, 0.01, _FORCE_TIP, self),
        }
        self.propose, self.cancel = QPushButton("Propose", self), QPushButton("Cancel", self)
        self.apply, self.back = QPushButton("Apply", self), QPushButton("Go back", self)
        self.progress, self.table, self.note = QProgressBar(self), QLabel(self), QLabel(self)
        self._lay_out()
        for name, number in (("milliseconds", 1.0), ("millimetres", 5.0), ("newtons", 0.5)):
            self.limits[name].show_number(number)
        self._on_kind_chosen()
        self.rest()

    def _lay_out(self) -> None:
        heading = QLabel("Budget", self)
        heading.setToolTip("The best settings of simulation, touch, image and control within a limit")
        self.kind.addItem("Time per tick at most", _TIME)
        self.kind.addItem("Contact within", _ERRORS)
        self.kind.setObjectName("budget-kind")
        self.kind.setAccessibleName("What is limited")
        self.kind.activated.connect(self._on_kind_chosen)
        guard_wheel(self.kind)
        for name, field in self.limits.items():
            field.setObjectName(f"budget-{name}")
            field.valueChanged.connect(self._on_limit_changed)
        for button, name, tip, act in (
            (self.propose, "propose", "Measure every setting in this scene, and choose the best within the limit",
             self._on_propose),
            (self.cancel, "cancel", "Cancel, and keep what was proposed before", self.cancelled),
            (self.apply, "apply", "Use all that is proposed", self._on_apply),
            (self.back, "back", "Use what was in force before", self._on_back),
        ):  # fmt: skip
            button.setObjectName(f"budget-{name}")
            button.setToolTip(tip)
            button.clicked.connect(act)
        self.progress.setRange(0, 1000)
        self.progress.setTextVisible(False)
        self.progress.setFixedHeight(6)
        self.progress.setMinimumWidth(40)
        self.progress.setAccessibleName("Progress of measuring")
        self.table.hide()
        for label, name in ((self.table, "table"), (self.note, "note")):
            label.setObjectName(f"budget-{name}")
            label.setProperty("role", "caption")
            label.setWordWrap(True)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 4, 0, 0)
        column.setSpacing(8)
        column.addWidget(heading)
        column.addLayout(_row(self.kind, *self.limits.values()))
        column.addLayout(_row(self.progress, self.cancel, self.propose, self.apply, self.back, stretch=True))
        column.addWidget(self.table)
        column.addWidget(self.note)

    def show_present(self, present: Mapping[str, Setting], *, can_measure: bool) -> None:
        """The settings in force, by stage, and whether there is a robot to measure."""
        self._can_measure = can_measure
        if present != self._present:
            self._present = dict(present)
            self._show_table()
        self._enable()

    def forget(self) -> None:
        """Another scene: nothing that was measured holds."""
        self._measured = None
        self._found = None
        self._proposed = ()
        self._before = ()
        self._predicted = None
        self._spent.clear()
        self._set_table("")
        self.say("")
        self._enable()

    def show_progress(self, text: str, fraction: float) -> None:
        """Something is being measured for it."""
        self.progress.setValue(round(1000 * fraction))
        self.progress.setToolTip(text)
        self._working(True)

    def rest(self) -> None:
        """Nothing is being measured any more."""
        self._working(False)
        self._enable()

    def say(self, text: str) -> None:
        """A line under the table."""
        self.note.setText(text)
        self.note.setVisible(bool(text))

    def show_measured(self, measured: BudgetMeasurement) -> None:
        """What there is to choose from; the proposal follows."""
        self._measured = measured
        self._propose()

    def show_frames(self, frames: Iterable[Frame]) -> None:
        """Frames that passed: what they took, and once a proposal is applied that beside what was predicted."""
        if self._measured is None:
            return
        for frame in frames:
            ms = frame.timings.ms
            self._spent.append(sum(ms.get(name, 0.0) for name in TIMED_STAGES.values()))
            self._ticks += 1
        if self._predicted is not None and self._ticks >= _EVERY and self.isVisible():
            self._ticks = 0
            median = float(np.median(self._spent))
            predicted = number_words(self._predicted)
            found = number_words(median)
            self.say(f"Simulation and touch: {predicted}\u202fms predicted, {found}\u202fms measured.")

    @property
    def budget(self) -> Budget:
        """As it is given now."""
        if self.kind.currentData() == _TIME:
            return Budget(milliseconds=self.limits["milliseconds"].value())
        return Budget(millimetres=self.limits["millimetres"].value(), newtons=self.limits["newtons"].value())

    def _on_kind_chosen(self) -> None:
        of_time = self.kind.currentData() == _TIME
        for name, field in self.limits.items():
            field.setVisible((name == "milliseconds") == of_time)
        self._on_limit_changed()

    def _on_limit_changed(self) -> None:
        if self._measured is not None and (self._measured.paths or self.kind.currentData() == _TIME):
            self._propose()  # the same measurement answers every budget

    def _on_propose(self) -> None:
        self.asked.emit(self.kind.currentData() == _ERRORS)

    def _propose(self) -> None:
        assert self._measured is not None
        measured = self._measured
        self._found = None
        self._proposed = ()
        self._predicted = None
        try:
            found = propose(self.budget, measured.options, pitch_mm=measured.pitch_mm, force=measured.force)
        except BudgetError as error:
            self._set_table("")
            self.say(f"▲ {error}")
        else:
            path = fastest_path(self.budget, measured.paths)
            chosen = [option.trial for option in found.chosen.values()]
            self._proposed = tuple(trial.setting for trial in (*chosen, *([path] if path else [])))
            self._show_table()
            tried = bool(measured.paths) and self.budget.of_error
            self.say(" ".join(proposal_words(found, path, tried=tried)))
            self._found = found
        self._enable()

    def _show_table(self) -> None:
        """What is in force beside what is proposed."""
        if not self._proposed:
            return
        rows = []
        for setting in self._proposed:
            now, then = (setting_words(one) for one in (self._present.get(setting.stage), setting))
            same = now == then
            mark = escape(then) if same else f"<b>{escape(then)}</b>"
            rows.append(
                f"<tr><td>{escape(setting.stage.capitalize())}&nbsp;</td><td>{escape(now)}&nbsp;</td><td>{mark}</td></tr>"
            )
        head = "<tr><td></td><td>Now&nbsp;</td><td>Proposed</td></tr>"
        self._set_table(f"<table>{head}{''.join(rows)}</table>")

    def _set_table(self, text: str) -> None:
        """Empty, it leaves no gap."""
        self.table.setText(text)
        self.table.setVisible(bool(text))

    def _on_apply(self) -> None:
        self._before = tuple(self._present[one.stage] for one in self._proposed if one.stage in self._present)
        assert self._found is not None
        live = sum(self._found.chosen[stage].cost.milliseconds for stage in TIMED_STAGES)
        self._predicted = live * self._slower_than_alone()
        self._spent.clear()
        self._ticks = 0
        self.applied.emit(self._proposed)
        self._enable()

    def _slower_than_alone(self) -> float:
        """By how much a tick takes longer in this window, which draws, than where nothing else is done: as one with the
        settings in force does. 1 where these were not measured.
        """
        if self._measured is None or len(self._spent) < _EVERY:
            return 1.0
        options = (
            next((one for one in self._measured.options[stage] if one.trial.setting == self._present.get(stage)), None)
            for stage in TIMED_STAGES
        )
        alone = [np.nan if option is None else option.cost.milliseconds for option in options]
        ratio = float(np.median(self._spent) / np.sum(alone))
        return ratio if np.isfinite(ratio) else 1.0

    def _on_back(self) -> None:
        before = self._before
        self._before = ()
        self._predicted = None
        self.say("")
        self.applied.emit(before)
        self._enable()

    def _working(self, on: bool) -> None:
        for widget in (self.progress, self.cancel):
            widget.setVisible(on)
        for widget in (self.propose, self.apply, self.back):
            widget.setVisible(not on)

    def _enable(self) -> None:
        self.propose.setEnabled(self._can_measure)
        different = any(self._present.get(one.stage) != one for one in self._proposed)
        self.apply.setEnabled(self._can_measure and different)
        self.back.setEnabled(bool(self._before))


_TIME_TIP = "Simulation, touch and one image of the map together, as often as the skin is read"
_PLACE_TIP = "Of a contact's centre; for controllers, of the true contact from its path, 95\u202f% of the time"
_FORCE_TIP = "Of a contact; for controllers, of the true force from its goal, 95\u202f% of the time"


def _row(*widgets: QWidget, stretch: bool = False) -> QHBoxLayout:
    row = QHBoxLayout()
    row.setSpacing(8)
    for widget in widgets:
        row.addWidget(widget)
    if stretch:
        row.addStretch()
    return row
