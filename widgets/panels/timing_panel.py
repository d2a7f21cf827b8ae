"""Where the time goes: milliseconds a stage, and how simulated time keeps up with the wall."""

from __future__ import annotations

from collections import deque

import numpy as np
from PySide6.QtWidgets import QLabel, QWidget

from app.session.frame import Frame
from widgets.panels.panel import Panel, fact

_WINDOW = 120
_EVERY = 15


class TimingPanel(Panel):
    """Medians over the last two seconds, shown a few times a second, so that digits can be read."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Time per tick", "timing-panel", parent)
        self._grid = self.grid()
        self._grid.setColumnStretch(0, 1)
        self._rows: dict[str, tuple[QLabel, QLabel]] = {}
        self._history: dict[str, deque[float]] = {}
        self._count = 0

    def clear(self) -> None:
        """Forget another scene's times."""
        self._history.clear()

    def add(self, stage: str, milliseconds: float) -> None:
        """One measurement of a stage."""
        self._history.setdefault(stage, deque(maxlen=_WINDOW)).append(milliseconds)

    def show_frame(self, frame: Frame) -> None:
        """Take a frame's stage times."""
        for stage, milliseconds in frame.timings.ms.items():
            self.add(stage, milliseconds)
        self._count += 1
        if self._count % _EVERY == 1 and self.isVisible():
            self.refresh()

    def refresh(self) -> None:
        """Show the medians and 95th percentiles now."""
        for stage, values in self._history.items():
            if stage not in self._rows:
                row = len(self._rows)
                self._rows[stage] = fact(stage[0].upper() + stage[1:], self), fact("", self, right=True)
                for column, label in enumerate(self._rows[stage]):
                    self._grid.addWidget(label, row, column)
                self._rows[stage][0].setToolTip("Median over the last two seconds")
            median, high = np.percentile(list(values), [50, 95])
            self._rows[stage][1].setText(f"{median:.2f}\u2009ms")
            self._rows[stage][1].setToolTip(f"95 % within {high:.2f} ms")
