"""The reference run: a switch, and the differences between the session and the reference, with the cost of both.

The section shows results and emits the state of the switch; the reference is simulated in a separate process.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtGui import QHideEvent, QShowEvent
from PySide6.QtWidgets import QCheckBox, QGridLayout, QLabel, QWidget

from tactile_maps.core.errors import counted
from tactile_maps.session.reference_run import FINER, REFERENCE_MODEL, ReferenceDifference
from tactile_widgets.common.make import caption_label, column_layout, make, value_label
from tactile_widgets.plots.work_precision_plot import format_number

SECONDS = 10.0
"""Simulated time over which the 95th percentile is shown [s]."""
_TIP = (
    f"Simulate this session once more in a separate process, with a time step {FINER} times shorter and the "
    f"{REFERENCE_MODEL} contact model, from the same inputs, and show the difference"
)


class _Row(NamedTuple):
    """A row of the table: name, tool tip, value of a difference in ``unit`` or None, and unit."""

    name: str
    tip: str
    value: Callable[[ReferenceDifference], float | None]
    unit: str


def _in(scale: float, value: float | None) -> float | None:
    return None if value is None else scale * value


_ROWS = (
    _Row(
        "Contact place",
        "Largest distance of a contact's centres in both, on the body",
        lambda d: _in(1e3, d.place),
        "mm",
    ),
    _Row("Contact force", "Difference of the sum over all contacts", lambda d: d.force, "N"),
    _Row("Posture", "Root mean square over the joints", lambda d: 1e3 * d.posture, "mrad"),
    _Row(
        "Wrong taxels",
        "Force on the wrong taxels, as a share of all force in the reference",
        lambda d: _in(100, d.wrong_taxels),
        "%",
    ),
)
_UNKNOWN = "–"
_WAITING = "Shown while a simulation runs."


class ReferenceSection(QWidget):
    """A switch and a table, which is visible while the switch is on."""

    enabled_changed = Signal(bool)
    """True if a reference is to be simulated from now on."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("reference-run")
        self._seen: deque[ReferenceDifference] = deque()
        self._enabled = False
        self.switch = make(
            QCheckBox,
            "Compare with a reference run",
            self,
            objectName="reference-switch",
            toolTip=_TIP,
            toggled=self._on_toggled,
        )
        self._table = QWidget(self)
        self._cost = caption_label(self, "reference-cost")
        self.note = caption_label(self, "reference-note")
        self._values = self._make_table()
        column_layout(self.switch, self._table, self._cost, self.note, parent=self).setContentsMargins(0, 4, 0, 0)
        for widget in (self._table, self._cost, self.note):
            widget.hide()
        self._show()

    def _make_table(self) -> dict[str, list[QLabel]]:
        grid = make(QGridLayout, self._table, horizontalSpacing=12, verticalSpacing=2)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setColumnStretch(0, 1)
        for place, text in ((1, "now"), (2, f"95\u202f% of {SECONDS:g}\u202fs")):
            grid.addWidget(value_label(text, self._table, right=True), 0, place)
        values = {}
        for number, row in enumerate(_ROWS, start=1):
            name = f"reference-{row.name.lower().replace(' ', '-')}"
            values[row.name] = [
                value_label(_UNKNOWN, self._table, right=True, objectName=f"{name}-{which}") for which in ("now", "p95")
            ]
            for place, label in enumerate((value_label(row.name, self._table, toolTip=row.tip), *values[row.name])):
                grid.addWidget(label, number, place)
        return values

    def show_difference(self, found: ReferenceDifference) -> None:
        """Add the difference of a frame; one with an earlier time belongs to another session."""
        if self._seen and found.time < self._seen[-1].time:
            self._seen.clear()
        self._seen.append(found)
        while found.time - self._seen[0].time > SECONDS:
            self._seen.popleft()
        self._show()
        count = found.unmatched
        self._say(f"{counted(count, 'contact')} that the other does not have." if count else "")

    def show_behind(self, seconds: float) -> None:
        """Show how far the reference is behind the session [s]."""
        self._say(f"Catching up: {seconds:.1f}\u202fs behind.")

    def show_refusal(self, text: str) -> None:
        """Show why this session has no reference."""
        self._say(text)

    def _say(self, text: str) -> None:
        self.note.setText(text)
        self.note.setVisible(bool(text) and self.switch.isChecked())

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._update_enabled()

    def hideEvent(self, event: QHideEvent) -> None:
        """Stop the reference while it is not visible."""
        super().hideEvent(event)
        self._update_enabled()

    def _on_toggled(self, on: bool) -> None:
        for widget in (self._table, self._cost):
            widget.setVisible(on)
        self._say(self.note.text())
        self._update_enabled()

    def _update_enabled(self) -> None:
        enabled = self.switch.isChecked() and self.isVisible()
        if enabled != self._enabled:
            self._enabled = enabled
            self._seen.clear()
            self._show()
            self._say(_WAITING)
            self.enabled_changed.emit(enabled)

    def _show(self) -> None:
        newest = self._seen[-1] if self._seen else None
        for row in _ROWS:
            known = [value for one in self._seen if (value := row.value(one)) is not None]
            values = (row.value(newest) if newest else None, float(np.percentile(known, 95)) if known else None)
            for label, value in zip(self._values[row.name], values, strict=True):
                label.setText(_UNKNOWN if value is None else f"{format_number(value)}\u202f{row.unit}")
        self._cost.setText(_cost_text(newest) if newest else "")


def _cost_text(found: ReferenceDifference) -> str:
    reference = found.reference_ms
    theirs = "" if reference is None else f", in the reference {format_number(reference)}\u202fms"
    return f"A tick takes {format_number(found.session_ms)}\u202fms{theirs}."
