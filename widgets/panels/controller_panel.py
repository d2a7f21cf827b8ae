"""The controller: which law, with which gains, and what limits it now."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any, cast

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QButtonGroup, QHBoxLayout, QPushButton, QWidget

from app.control.command import ControlSettings, LawName
from app.session.frame import Frame
from widgets.panels.panel import LabelledSlider, Panel

_LAWS = {
    "impedance": ("Hold posture", "The arm is a spring to its home posture: it yields to a touch and returns"),
    "hold_force": ("Hold force", "The arm retreats from or follows a touch so that its force stays at the goal"),
}
_SLIDERS = {
    # setting: law, text, unit, low, high, step, shown units per SI unit, tool tip
    "stiffness": (
        "impedance",
        "Stiffness",
        "rad/s",
        1.0,
        30.0,
        0.5,
        1.0,
        "Natural frequency of every joint about its home; higher yields less",
    ),
    "damping_ratio": ("impedance", "Damping ratio", "", 0.1, 2.0, 0.05, 1.0, "1 returns without overshoot"),
    "force_goal": ("hold_force", "Force goal", "N", 0.0, 15.0, 0.5, 1.0, "The contact force to keep; 0 only retreats"),
    "force_gain": (
        "hold_force",
        "Force gain",
        "mm/s per N",
        1.0,
        40.0,
        1.0,
        1000.0,
        "Retreat or approach speed for each newton too much or too little",
    ),
    "integral_time": (
        "hold_force",
        "Integral time",
        "s",
        0.05,
        2.0,
        0.05,
        1.0,
        "Shorter removes lasting errors faster, and overshoots more",
    ),
}


class ControllerPanel(Panel):
    """Emits settings as a person changes them."""

    settings_edited = Signal(object)
    """ControlSettings wanted."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Controller", "controller-panel", parent)
        self._settings = ControlSettings()
        self._buttons: dict[str, QPushButton] = {}
        self._group = QButtonGroup(self)
        row = QHBoxLayout()
        row.setSpacing(4)
        for law, (text, tip) in _LAWS.items():
            button = QPushButton(text, self)
            button.setObjectName(f"law-{law}")
            button.setCheckable(True)
            button.setToolTip(tip)
            self._group.addButton(button)
            self._buttons[law] = button
            row.addWidget(button)
        self._group.buttonClicked.connect(self._on_law_clicked)
        self.column.addLayout(row)
        self._sliders: dict[str, LabelledSlider] = {}
        for name, (_, text, unit, low, high, step, _, tip) in _SLIDERS.items():
            slider = LabelledSlider(text, unit, low, high, step, tip, self)
            slider.setObjectName(f"gain-{name}")
            slider.value_changed.connect(partial(self._on_slider_changed, name))
            self._sliders[name] = slider
            self.column.addWidget(slider)
        self._why = self.caption("Not limited")
        self._why.setObjectName("why-limited")
        self.show_settings(self._settings)

    def show_settings(self, settings: ControlSettings) -> None:
        """Show the settings in force."""
        self._settings = settings
        self._buttons[settings.law].setChecked(True)
        for name, (law, *_, scale, _) in _SLIDERS.items():
            self._sliders[name].set_value(getattr(settings, name) * scale)
            self._sliders[name].setVisible(law == settings.law)

    def show_frame(self, frame: Frame) -> None:
        """Say what limits the controller."""
        if not len(frame.posture):
            text = "This robot has no joints to move"
        else:
            text = "Limited by: " + ", ".join(frame.why_limited) if frame.why_limited else "Not limited"
        if text != self._why.text():
            self._why.setText(text)

    def _on_law_clicked(self, button: QPushButton) -> None:
        law = next(name for name, known in self._buttons.items() if known is button)
        self._edit(replace(self._settings, law=cast("LawName", law)))

    def _on_slider_changed(self, name: str, value: float) -> None:
        changed: dict[str, Any] = {name: value / _SLIDERS[name][6]}
        self._edit(replace(self._settings, **changed))

    def _edit(self, settings: ControlSettings) -> None:
        self.show_settings(settings)
        self.settings_edited.emit(settings)
