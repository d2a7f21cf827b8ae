"""The controller: which law does which task, with which gains, and what limits it now."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any, cast

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QButtonGroup, QGridLayout, QPushButton, QWidget

from app.control.command import ControlSettings, LawName
from app.control.laws import heeded
from app.session.frame import Frame
from widgets.panels.choice_box import ChoiceBox
from widgets.panels.controller_choices import CHOICES, LAWS, SLIDERS
from widgets.panels.panel import LabelledSlider, Panel


class ControllerPanel(Panel):
    """Emits settings as a person changes them; shows what the chosen law and task heed."""

    settings_edited = Signal(object)
    """ControlSettings wanted."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Controller", "controller-panel", parent)
        self._settings = ControlSettings()
        self._buttons: dict[str, QPushButton] = {}
        self._group = QButtonGroup(self)
        self.column.addLayout(self._law_buttons())
        self._boxes = {name: self._choice_box(name) for name in CHOICES}
        self._sliders: dict[str, LabelledSlider] = {}
        for name, spec in SLIDERS.items():
            slider = LabelledSlider(spec.text, spec.unit, spec.low, spec.high, spec.step, spec.tip, self)
            slider.setObjectName(f"gain-{name}")
            slider.value_changed.connect(partial(self._on_slider_changed, name))
            self._sliders[name] = slider
            self.column.addWidget(slider)
        self._why = self.caption("Not limited")
        self._why.setObjectName("why-limited")
        self.show_settings(self._settings)

    def show_settings(self, settings: ControlSettings) -> None:
        """Show the settings in force."""
        self._settings, names = settings, heeded(settings)
        self._buttons[settings.law].setChecked(True)
        for name, slider in self._sliders.items():
            slider.set_value(getattr(settings, name) * SLIDERS[name].scale)
            slider.setVisible(name in names)
        for name, box in self._boxes.items():
            value = getattr(settings, name)
            box.setCurrentIndex(box.findData(value))
            box.say(CHOICES[name][1][value])
            box.setVisible(name in names)

    def show_frame(self, frame: Frame) -> None:
        """Say what limits the controller."""
        if not len(frame.posture):
            text = "This robot has no joints to move"
        else:
            text = "Limited by: " + ", ".join(frame.why_limited) if frame.why_limited else "Not limited"
        if text != self._why.text():
            self._why.setText(text)

    def _law_buttons(self) -> QGridLayout:
        grid = QGridLayout()
        grid.setSpacing(4)
        for side in (0, 1):
            grid.setColumnStretch(side, 1)
        for number, (law, (text, tip)) in enumerate(LAWS.items()):
            button = QPushButton(text, self)
            button.setObjectName(f"law-{law}")
            button.setCheckable(True)
            button.setToolTip(tip)
            self._group.addButton(button)
            self._buttons[law] = button
            grid.addWidget(button, *divmod(number, 2))
        self._group.buttonClicked.connect(self._on_law_clicked)
        return grid

    def _choice_box(self, name: str) -> ChoiceBox:
        tip, words = CHOICES[name]
        box = ChoiceBox(self)
        box.setObjectName(f"choice-{name}")
        box.setAccessibleName(tip)
        box.setToolTip(tip)
        for value, text in words.items():
            box.addItem(text, value)
        box.activated.connect(partial(self._on_choice_made, name))
        self.column.addWidget(box)
        return box

    def _on_law_clicked(self, button: QPushButton) -> None:
        law = next(name for name, known in self._buttons.items() if known is button)
        self._edit(replace(self._settings, law=cast("LawName", law)))

    def _on_choice_made(self, name: str, row: int) -> None:
        changed: dict[str, Any] = {name: self._boxes[name].itemData(row)}
        self._edit(replace(self._settings, **changed))

    def _on_slider_changed(self, name: str, value: float) -> None:
        changed: dict[str, Any] = {name: value / SLIDERS[name].scale}
        self._edit(replace(self._settings, **changed))

    def _edit(self, settings: ControlSettings) -> None:
        self.show_settings(settings)
        self.settings_edited.emit(settings)
