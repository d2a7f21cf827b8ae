"""Budget: limits of time or of error, the settings of all stages that are proposed within them, and their application.

The section shows results and emits requests; the panel measures, and the owner of each stage applies its setting.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from html import escape

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QLabel, QWidget

from tactile_maps.core.errors import BudgetError
from tactile_maps.session.frame import Frame
from tactile_maps.studies.budget.measurement import TIMED_STAGES, BudgetMeasurement
from tactile_maps.studies.budget.proposal import Budget, Proposal, fastest_path, propose
from tactile_maps.studies.budget.wording import number_words, proposal_words, setting_words
from tactile_maps.studies.study.work_precision import Setting
from tactile_widgets.common.make import (
    add_items,
    caption_label,
    column_layout,
    make,
    progress_bar,
    push_button,
    row_layout,
    show_text,
)
from tactile_widgets.common.number_field import NumberField, guard_wheel

_TIME = "time"
_ERRORS = "errors"
_WATCHED = 200
_EVERY = 50
"""Ticks over which the median is taken, and between two updates of its text."""
_TIME_TIP = "Simulation, touch and one image of the map together, as often as the skin is read"
_PLACE_TIP = "Error of a contact's centre; for controllers, of the true contact from its path, 95\u202f% of the time"
_FORCE_TIP = "Error of a contact's force; for controllers, of the true force from its goal, 95\u202f% of the time"


class BudgetSection(QWidget):
    """Limits, the proposal within them, and the time that it takes once it is applied."""

    measure_requested = Signal(bool)
    """The user requests a proposal; whether controllers are to be measured too."""
    cancelled = Signal()
    """The user cancels the measurement."""
    applied = Signal(tuple)
    """Settings to apply, ``Setting`` each."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("budget")
        self._present: dict[str, Setting] = {}
        self._spent: deque[float] = deque(maxlen=_WATCHED)
        self._ticks = 0
        self._can_measure = False
        self._reset()
        self._make_controls()
        self._on_kind_chosen()
        self.rest()

    def _reset(self) -> None:
        self._measured: BudgetMeasurement | None = None
        self._found: Proposal | None = None
        self._proposed: tuple[Setting, ...] = ()
        self._before: tuple[Setting, ...] = ()
        self._predicted: float | None = None
        self._spent.clear()

    def _make_controls(self) -> None:
        tip = "The best settings of simulation, touch, image and control within a limit"
        heading = make(QLabel, "Budget", self, toolTip=tip)
        self.kind = make(
            QComboBox, self, objectName="budget-kind", accessibleName="What is limited", activated=self._on_kind_chosen
        )
        add_items(self.kind, (("Time per tick at most", _TIME, ""), ("Contact within", _ERRORS, "")))
        guard_wheel(self.kind)
        self.limits = {
            "milliseconds": NumberField("Time per tick", "ms", 0.05, 100.0, 0.05, _TIME_TIP, self),
            "millimetres": NumberField("Error of the place", "mm", 0.1, 50.0, 0.1, _PLACE_TIP, self),
            "newtons": NumberField("Error of the force", "N", 0.01, 10.0, 0.01, _FORCE_TIP, self),
        }
        for (name, field), number in zip(self.limits.items(), (1.0, 5.0, 0.5), strict=True):
            field.setObjectName(f"budget-{name}")
            field.show_number(number)
            field.valueChanged.connect(self._on_limit_changed)
        tip = "Measure every setting in this scene, and choose the best within the limit"
        self.propose = push_button(self, "budget-propose", "Propose", tip, self._on_propose)
        tip = "Cancel, and keep the previous proposal"
        self.cancel = push_button(self, "budget-cancel", "Cancel", tip, self.cancelled)
        self.apply = push_button(self, "budget-apply", "Apply", "Use all proposed settings", self._on_apply)
        self.back = push_button(self, "budget-back", "Go back", "Use the previous settings", self._on_back)
        self.progress = make(progress_bar, self, "Progress of measuring", minimumWidth=40)
        self.table = caption_label(self, "budget-table")
        self.note = caption_label(self, "budget-note")
        self.table.hide()
        column_layout(
            heading,
            row_layout(self.kind, *self.limits.values()),
            row_layout(self.progress, self.cancel, self.propose, self.apply, self.back, None),
            self.table,
            self.note,
            parent=self,
        ).setContentsMargins(0, 4, 0, 0)

    def show_present(self, present: Mapping[str, Setting], *, can_measure: bool) -> None:
        """Show the current settings by stage; ``can_measure`` if there is a robot to measure."""
        self._can_measure = can_measure
        if present != self._present:
            self._present = dict(present)
            self._show_table()
        self._update_buttons()

    def forget(self) -> None:
        """Discard the measurement, which does not apply to another scene."""
        self._reset()
        show_text(self.table, "")
        self.say("")
        self._update_buttons()

    def show_progress(self, text: str, fraction: float) -> None:
        """Show the progress of a measurement."""
        self.progress.setValue(round(1000 * fraction))
        self.progress.setToolTip(text)
        self._show_working(True)

    def rest(self) -> None:
        """Show that nothing is being measured."""
        self._show_working(False)
        self._update_buttons()

    def say(self, text: str) -> None:
        """Show a text below the table."""
        show_text(self.note, text)

    def show_measured(self, measured: BudgetMeasurement) -> None:
        """Take a measurement, and propose settings."""
        self._measured = measured
        self._propose()

    def show_frames(self, frames: Iterable[Frame]) -> None:
        """Take the times of frames, and show them with the predicted time once a proposal is applied."""
        if self._measured is None:
            return
        for frame in frames:
            ms = frame.timings.ms
            self._spent.append(sum(ms.get(name, 0.0) for name in TIMED_STAGES.values()))
            self._ticks += 1
        if self._predicted is not None and self._ticks >= _EVERY and self.isVisible():
            self._ticks = 0
            predicted = number_words(self._predicted)
            median = number_words(float(np.median(self._spent)))
            self.say(f"Simulation and touch: {predicted}\u202fms predicted, {median}\u202fms measured.")

    @property
    def budget(self) -> Budget:
        """Budget as entered."""
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
            self._propose()  # one measurement suffices for every budget

    def _on_propose(self) -> None:
        self.measure_requested.emit(self.kind.currentData() == _ERRORS)

    def _propose(self) -> None:
        assert self._measured is not None
        measured = self._measured
        self._found = None
        self._proposed = ()
        self._predicted = None
        try:
            found = propose(self.budget, measured.options, pitch_mm=measured.pitch_mm, force=measured.force)
        except BudgetError as error:
            show_text(self.table, "")
            self.say(f"▲ {error}")
        else:
            path = fastest_path(self.budget, measured.paths)
            chosen = [option.trial for option in found.chosen.values()]
            self._proposed = tuple(trial.setting for trial in (*chosen, *([path] if path else [])))
            self._show_table()
            tried = bool(measured.paths) and self.budget.of_error
            self.say(" ".join(proposal_words(found, path, tried=tried)))
            self._found = found
        self._update_buttons()

    def _show_table(self) -> None:
        """Show current and proposed settings; changed ones are bold."""
        if not self._proposed:
            return
        rows = ["<tr><td></td><td>Now&nbsp;</td><td>Proposed</td></tr>"]
        for setting in self._proposed:
            now, then = (escape(setting_words(one)) for one in (self._present.get(setting.stage), setting))
            mark = then if now == then else f"<b>{then}</b>"
            stage = escape(setting.stage.capitalize())
            rows.append(f"<tr><td>{stage}&nbsp;</td><td>{now}&nbsp;</td><td>{mark}</td></tr>")
        show_text(self.table, f"<table>{''.join(rows)}</table>")

    def _on_apply(self) -> None:
        self._before = tuple(self._present[one.stage] for one in self._proposed if one.stage in self._present)
        assert self._found is not None
        live = sum(self._found.chosen[stage].cost.milliseconds for stage in TIMED_STAGES)
        self._predicted = live * self._slowdown()
        self._spent.clear()
        self._ticks = 0
        self.applied.emit(self._proposed)
        self._update_buttons()

    def _slowdown(self) -> float:
        """Return the ratio of the time of a tick in this window, which also draws, to that in a separate process.

        The ratio is that of the current settings; 1 if they were not measured.
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
        self._update_buttons()

    def _show_working(self, on: bool) -> None:
        for widget in (self.progress, self.cancel):
            widget.setVisible(on)
        for widget in (self.propose, self.apply, self.back):
            widget.setVisible(not on)

    def _update_buttons(self) -> None:
        self.propose.setEnabled(self._can_measure)
        different = any(self._present.get(one.stage) != one for one in self._proposed)
        self.apply.setEnabled(self._can_measure and different)
        self.back.setEnabled(bool(self._before))
