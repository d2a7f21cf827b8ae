"""The reference run: a switch, and how far what is shown is off, beside what both cost.

It shows what it is told and says whether it is wanted; the session is followed in another process.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtGui import QHideEvent, QShowEvent
from PySide6.QtWidgets import QCheckBox, QGridLayout, QLabel, QVBoxLayout, QWidget

from tactile_maps.session.reference_run import FINER, REFERENCE_MODEL, ReferenceDifference
from tactile_widgets.common.panel import value_label
from tactile_widgets.plots.work_precision_plot import format_number

SECONDS = 10.0
"""Simulated time of which the 95th percentile is shown."""
_TIP = (
    f"Simulate this session once more in another process, with a time step {FINER} times as short and the "
    f"{REFERENCE_MODEL} contact model, from the same inputs, and show the difference"
)


class _Row(NamedTuple):
    """A row: its name, what it means, its value of a difference in the unit shown, or None, and that unit."""

    name: str
    tip: str
    value: Callable[[ReferenceDifference], float | None]
    unit: str


_ROWS = (
    _Row("Contact place", "Between the centres of each contact in both, the largest, on the body",
         lambda one: None if one.place is None else 1e3 * one.place, "mm"),
    _Row("Contact force", "Of all contacts together", lambda one: one.force, "N"),
    _Row("Posture", "Root mean square over the joints", lambda one: 1e3 * one.posture, "mrad"),
    _Row("Wrong taxels", "Force on the wrong taxels, as a share of all force that the reference reads",
         lambda one: None if one.wrong_taxels is None else 100 * one.wrong_taxels, "%"),
)  # fmt: skip
_UNKNOWN = "–"


class ReferenceSection(QWidget):
    """The switch and the table; the table is there while it is on."""

    wanted = Signal(bool)
    """Whether a reference is wanted from now on."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("reference-run")
        self._seen: deque[ReferenceDifference] = deque()
        self._wanted = False
        self.switch = QCheckBox("Compare with a reference run", self)
        self.switch.setObjectName("reference-switch")
        self.switch.setToolTip(_TIP)
        self.switch.toggled.connect(self._on_toggled)
        self._table, self._cost, self.note = QWidget(self), QLabel(self), QLabel(self)
        for label, name in ((self._cost, "cost"), (self.note, "note")):
            label.setObjectName(f"reference-{name}")
            label.setProperty("role", "caption")
            label.setWordWrap(True)
        self._values = self._make_table()
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 4, 0, 0)
        column.setSpacing(8)
        for widget in (self.switch, self._table, self._cost, self.note):
            column.addWidget(widget)
        for widget in (self._table, self._cost, self.note):
            widget.hide()
        self._show()

    def _make_table(self) -> dict[str, tuple[QLabel, QLabel]]:
        grid = QGridLayout(self._table)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(12)
        grid.setVerticalSpacing(2)
        grid.setColumnStretch(0, 1)
        for column, text in ((1, "now"), (2, f"95\u202f% of {SECONDS:g}\u202fs")):
            grid.addWidget(value_label(text, self._table, right=True), 0, column)
        found = {}
        for number, (name, tip, _value, _unit) in enumerate(_ROWS, start=1):
            heading = value_label(name, self._table)
            heading.setToolTip(tip)
            labels = value_label(_UNKNOWN, self._table, right=True), value_label(_UNKNOWN, self._table, right=True)
            for label, which in zip(labels, ("now", "p95"), strict=True):
                label.setObjectName(f"reference-{name.lower().replace(' ', '-')}-{which}")
            for column, widget in enumerate((heading, *labels)):
                grid.addWidget(widget, number, column)
            found[name] = labels
        return found

    def show_difference(self, found: ReferenceDifference) -> None:
        """Show one more frame's difference; an earlier one is of another session."""
        if self._seen and found.time < self._seen[-1].time:
            self._seen.clear()
        self._seen.append(found)
        while found.time - self._seen[0].time > SECONDS:
            self._seen.popleft()
        self._show()
        self._say_note("" if not found.unmatched else _unmatched_words(found.unmatched))

    def show_behind(self, seconds: float) -> None:
        """It is still on its way to what is shown."""
        self._say_note(f"Catching up: {seconds:.1f}\u202fs behind.")

    def show_refusal(self, text: str) -> None:
        """There is no reference of this session."""
        self._say_note(text)

    def _say_note(self, text: str) -> None:
        """Empty, it leaves no gap."""
        self.note.setText(text)
        self.note.setVisible(bool(text) and self.switch.isChecked())

    def showEvent(self, event: QShowEvent) -> None:
        """Qt: it goes on."""
        super().showEvent(event)
        self._tell_wanted()

    def hideEvent(self, event: QHideEvent) -> None:
        """Qt: folded, or behind another panel: what nobody sees is not simulated."""
        super().hideEvent(event)
        self._tell_wanted()

    def _on_toggled(self, on: bool) -> None:
        for widget in (self._table, self._cost):
            widget.setVisible(on)
        self.note.setVisible(on and bool(self.note.text()))
        self._tell_wanted()

    def _tell_wanted(self) -> None:
        wanted = self.switch.isChecked() and self.isVisible()
        if wanted != self._wanted:
            self._wanted = wanted
            self._seen.clear()
            self._show()
            self._say_note(_WAITING)
            self.wanted.emit(wanted)

    def _show(self) -> None:
        for row in _ROWS:
            known = [value for one in self._seen if (value := row.value(one)) is not None]
            now = row.value(self._seen[-1]) if self._seen else None
            self._say(row.name, now, float(np.percentile(known, 95)) if known else None, row.unit)
        self._cost.setText(_cost_words(self._seen[-1]) if self._seen else "")

    def _say(self, name: str, now: float | None, usual: float | None, unit: str) -> None:
        for label, value in zip(self._values[name], (now, usual), strict=True):
            label.setText(_UNKNOWN if value is None else f"{format_number(value)}\u202f{unit}")


_WAITING = "Shown while a simulation runs."


def _cost_words(found: ReferenceDifference) -> str:
    ours = f"A tick takes {format_number(found.session_ms)}\u202fms"
    theirs = "" if found.reference_ms is None else f", in the reference {format_number(found.reference_ms)}\u202fms"
    return f"{ours}{theirs}."


def _unmatched_words(count: int) -> str:
    return f"{count} contact{'s' * (count > 1)} that the other does not have."
