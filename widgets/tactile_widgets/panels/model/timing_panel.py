"""Computation times: milliseconds by stage, and the ratio of simulated to real time."""

from __future__ import annotations

from collections import deque

import numpy as np
from PySide6.QtWidgets import QLabel, QWidget

from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.make import add_fact, value_label
from tactile_widgets.common.panel import Panel
from tactile_widgets.common.sentence import capitalized
from tactile_widgets.plots.traces.history import SENSOR_STAGE, stage_times

_WINDOW = 120
_REFRESH_EVERY = 15
VIEW_STAGE = "3-D view"
_STAGES = {
    "physics": "Physics of robot and probes, per tick",
    "touch": "Contact forces to taxel pressures, per tick",
    SENSOR_STAGE: "Sensor effects, per tick; listed singly under Effects",
    "contacts": "Contact regions and events, per tick",
    "control": "Controller, per tick",
    VIEW_STAGE: "Rendering of the robot, per frame",
}


class TimingPanel(Panel):
    """Medians over the last two seconds, updated a few times per second, so that digits can be read."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Timing", "timing-panel", parent)
        self._grid = self.grid()
        self._grid.setColumnStretch(0, 1)
        self._history: dict[str, deque[float]] = {}
        self._count = 0
        self._shown_factor = ""
        self._values: dict[str, QLabel] = {}
        self._add_row("factor", "Real time", "Simulated seconds per second; below the chosen speed, time is dropped")
        for stage, tip in _STAGES.items():
            self._add_row(stage, capitalized(stage), tip)

    def clear(self) -> None:
        """Forget all times."""
        self._history.clear()
        for value in self._values.values():
            value.setText("–")

    def add(self, stage: str, milliseconds: float) -> None:
        """Add a measurement of a stage."""
        self._history.setdefault(stage, deque(maxlen=_WINDOW)).append(milliseconds)

    def show_factor(self, factor: float | None) -> None:
        """Set the real-time factor; None in a replay, which has none."""
        self._shown_factor = "–" if factor is None else f"{factor:.2f}×"

    def show_prepared(self, prepared: PreparedScene) -> None:
        self.clear()

    def show_frame(self, frame: Frame) -> None:
        """Add the stage times of a frame."""
        times = stage_times(frame.timings)
        for stage in self._history.keys() - times.keys() - {VIEW_STAGE}:
            del self._history[stage]  # switched off: its times are outdated
            if stage in self._values:
                self._values[stage].setText("–")
        for stage, milliseconds in times.items():
            self.add(stage, milliseconds)
        self._count += 1
        if self._count % _REFRESH_EVERY == 1 and self.isVisible():
            self.refresh()

    def refresh(self) -> None:
        """Show the current medians and 95th percentiles."""
        self._values["factor"].setText(self._shown_factor)
        for stage, values in self._history.items():
            if stage not in self._values:
                self._add_row(stage, capitalized(stage), "Per tick")
            median, high = np.percentile(list(values), [50, 95])
            self._values[stage].setText(f"{median:.2f}\u202fms")
            self._values[stage].setToolTip(f"Median of the last {len(values)}; 95\u202f% within {high:.2f}\u202fms")

    def _add_row(self, key: str, text: str, tip: str) -> None:
        row = len(self._values)
        self._values[key] = value_label("–", self, right=True, objectName=f"timing-{key}")
        add_fact(self._grid, row, text, tip, self._values[key])
