"""What this scene simulates, why, what it costs, and a way to have it otherwise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from app.errors import Finding
from app.scene.decide import Decision, EffectRow
from app.scene.effect_table import EFFECTS, SENSOR_KEYS
from app.session.frame import Frame
from app.session.prepare import Prepared
from widgets.panels.effect_choices import autos_of, choices_of
from widgets.panels.effect_costs import EffectCosts
from widgets.panels.effect_line import EffectLine
from widgets.panels.fold_heading import FoldHeading
from widgets.panels.panel import Panel, fact

_EVERY = 15
_WARNING = "⚠"


class EffectsPanel(Panel):
    """A row an effect: its state, its milliseconds a tick, a box that overrides it. Decides nothing.

    What is measured where it runs is shown plainly; what was measured in a process beside, quietly.
    """

    wished = Signal(str, object)
    """Key and wish: a person wants an effect otherwise; ``auto`` for as the scene needs it."""
    all_auto_wished = Signal()
    """All of them as the scene needs them."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Effects", "effects-panel", parent)
        self._empty = self.caption("Open a scene to see what it simulates.")
        self._costs = EffectCosts()
        self._decision: Decision | None = None
        self._lines: dict[str, EffectLine] = {}
        self._count, self._open = 0, True
        self._content = QWidget(self)
        self.column.addWidget(self._content)
        self._rows = QVBoxLayout(self._content)
        self._rows.setContentsMargins(0, 0, 0, 0)
        self._rows.setSpacing(2)
        self._warnings = self._note("effects-warnings")
        self._closed = self._note("effects-closed")
        self._closed.setText("What the recording was made with.")
        self._rows.addLayout(self._header())
        self._body, self._sensor = QWidget(self._content), QWidget(self._content)
        self._columns = {group: _column(group) for group in (self._body, self._sensor)}
        self._fold = FoldHeading("Sensor", self._content)
        self._fold.setObjectName("effects-sensor-heading")
        self._fold.toggled.connect(self._sensor.setHidden)
        self._fold.setChecked(True)
        self._rows.addWidget(self._body)
        self._rows.addSpacing(6)
        for widget in (self._fold, self._sensor):
            self._rows.addWidget(widget)
        self._total = fact("", self._content, right=True)
        self._total.setObjectName("effects-total")
        self._auto = QPushButton("All to auto", self._content)
        self._auto.setObjectName("effects-all-auto")
        self._auto.setToolTip("Simulate what the scene needs, and no more")
        self._auto.clicked.connect(self.all_auto_wished)
        self._rows.addSpacing(8)
        self._rows.addLayout(self._footer())
        self._notes = self._note("effects-notes")
        for label in (self._closed, self._notes):
            label.setProperty("role", "caption")
        self._content.hide()

    def show_prepared(self, prepared: Prepared) -> None:
        """List the effects of another scene."""
        self._empty.hide()
        self._content.show()
        self._costs.clear(prepared.scene.tick)
        for line in self._lines.values():
            line.hide()  # it is deleted only when the events come round, and would lie over its successor
            line.deleteLater()
        self._lines = {}
        for key in EFFECTS:
            group = self._sensor if key in SENSOR_KEYS else self._body
            line = EffectLine(key, choices_of(key, tick=prepared.scene.tick), group)
            line.chosen.connect(self.wished)
            line.selected.connect(self._on_selected)
            self._columns[group].addWidget(line)
            self._lines[key] = line
        self.show_decision(prepared.scene.decision, autos_of(prepared.scene))

    def show_decision(
        self, decision: Decision, autos: Mapping[str, EffectRow], *, notes: Sequence[Finding] = ()
    ) -> None:
        """Show what is simulated now, and what is wrong with it.

        Args:
            decision: What is simulated.
            autos: Each effect as it would be by itself, by key.
            notes: Warnings beside those of the decision.
        """
        self._decision = decision
        for row in decision.rows:
            self._lines[row.name].show_row(row, autos[row.name])
        self.set_enabled(enabled=self._open)
        warnings = [finding.action for finding in (*decision.warnings, *notes)]
        self._warnings.setText("\n".join(f"{_WARNING} {words}." for words in warnings))
        self._warnings.setVisible(bool(warnings))
        self.refresh()

    def show_prices(self, prices: dict[str, float]) -> None:
        """Milliseconds a tick by key, as measured beside."""
        self._costs.prices = prices
        self.refresh()

    def show_frame(self, frame: Frame) -> None:
        """Take a frame's stage times; shown a few times a second, so that digits can be read."""
        self._costs.add(frame.timings)
        self._count += 1
        if self._count % _EVERY == 1 and self.isVisible():
            self.refresh()
            self._notes.setText("\n".join(frame.notes))
            self._notes.setVisible(bool(frame.notes))

    def set_enabled(self, *, enabled: bool) -> None:
        """Take wishes, or only show, as while replaying."""
        self._open = enabled
        self._closed.setVisible(not enabled)
        for line in self._lines.values():
            line.box.setEnabled(enabled)
        rows = () if self._decision is None else self._decision.rows
        self._auto.setEnabled(enabled and any(row.wished for row in rows))

    def refresh(self) -> None:
        """Show costs now."""
        if self._decision is None:
            return
        for row in self._decision.rows:
            cost = self._costs.of(row)
            self._lines[row.name].show_cost(cost.words, beside=cost.beside, tip=cost.tip)
        self._total.setText(self._costs.total)
        on = sum(row.on for row in self._decision.rows if row.name in SENSOR_KEYS)
        self._fold.setText(f"Sensor  ·  {on} on" if on else "Sensor  ·  ideal")

    @property
    def lines(self) -> dict[str, EffectLine]:
        """The rows by key."""
        return self._lines

    def _note(self, name: str) -> QLabel:
        label = QLabel(self._content)
        label.setObjectName(name)
        label.setWordWrap(True)
        label.setMinimumWidth(1)
        label.hide()
        self._rows.addWidget(label)
        return label

    def _header(self) -> QHBoxLayout:
        row = QHBoxLayout()
        for words, side in (("Effect", Qt.AlignmentFlag.AlignLeft), ("ms a tick", Qt.AlignmentFlag.AlignRight)):
            label = QLabel(words, self._content)
            label.setProperty("role", "caption")
            row.addWidget(label, 0, side)
        return row

    def _footer(self) -> QHBoxLayout:
        row = QHBoxLayout()
        row.addWidget(self._auto)
        row.addWidget(self._total, 1)
        return row

    def _on_selected(self, key: str) -> None:
        for name, line in self._lines.items():
            line.select(selected=name == key)


def _column(group: QWidget) -> QVBoxLayout:
    column = QVBoxLayout(group)
    column.setContentsMargins(0, 0, 0, 0)
    column.setSpacing(2)
    return column
