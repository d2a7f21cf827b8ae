"""What this scene simulates, and why."""

from __future__ import annotations

from PySide6.QtWidgets import QLabel, QWidget

from app.session.prepare import Prepared
from app.simulation.scene import effect_rows
from widgets.panels.panel import Panel, fact


class EffectsPanel(Panel):
    """One line an effect: on or off, with its reason as the tool tip and below the name."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Effects", "effects-panel", parent)
        self._empty = self.caption("Open a scene to see what it simulates.")
        self._grid = self.grid()
        self._labels: list[QLabel] = []

    def show_prepared(self, prepared: Prepared) -> None:
        """List the effects of a scene."""
        self._empty.hide()
        for label in self._labels:
            self._grid.removeWidget(label)
            label.hide()  # it is deleted only when the events come round, and would lie over its successor
            label.deleteLater()
        self._labels = []
        for row, effect in enumerate(effect_rows(prepared.scene)):
            name, state = fact(effect.name.capitalize(), self), fact("on" if effect.on else "off", self, right=True)
            state.setProperty("role", "" if effect.on else "caption")
            for column, label in enumerate((name, state)):
                label.setToolTip(effect.why)
                self._grid.addWidget(label, row, column)
            self._labels += [name, state]
        self._grid.setColumnStretch(0, 1)
