"""Sliders of the controller's numbers, of which those are shown that the law and the task in force heed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from typing import Any

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QVBoxLayout, QWidget

from app.control.command import ControlSettings
from app.control.laws import heeded
from widgets.panels.controller_choices import SLIDERS
from widgets.panels.panel import LabelledSlider


class SettingSliders(QWidget):
    """Emits settings as a hand turns them; a double-click on a name puts that one back to where it began.

    Args:
        names: Of ``SLIDERS``, in the order shown.
        parent: Qt parent.
    """

    settings_edited = Signal(object)
    """ControlSettings wanted."""

    def __init__(self, names: Iterable[str] = SLIDERS, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._settings = self._defaults = ControlSettings()
        self.by_name: dict[str, LabelledSlider] = {}
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(8)
        for name in names:
            spec = SLIDERS[name]
            slider = LabelledSlider(spec.text, spec.unit, spec.low, spec.high, spec.step, spec.tip, self)
            slider.setObjectName(f"gain-{name}")
            slider.value_changed.connect(partial(self._on_value_changed, name))
            slider.default_wanted.connect(partial(self._on_default_wanted, name))
            self.by_name[name] = slider
            column.addWidget(slider)
        self.set_defaults(self._defaults)

    def set_defaults(self, defaults: ControlSettings) -> None:
        """Where the numbers began."""
        self._defaults = defaults
        for name, slider in self.by_name.items():
            spec = SLIDERS[name]
            slider.set_default_tip(f"{getattr(defaults, name) * spec.scale:.4g}\u2009{spec.unit}".strip())

    def show_settings(self, settings: ControlSettings) -> None:
        """Show the settings in force."""
        self._settings, names = settings, heeded(settings)
        for name, slider in self.by_name.items():
            slider.set_value(getattr(settings, name) * SLIDERS[name].scale)
            slider.setVisible(name in names)

    def _on_value_changed(self, name: str, value: float) -> None:
        self._edit(name, value / SLIDERS[name].scale)

    def _on_default_wanted(self, name: str) -> None:
        self._edit(name, getattr(self._defaults, name))

    def _edit(self, name: str, value: float) -> None:
        changed: dict[str, Any] = {name: value}
        self.settings_edited.emit(replace(self._settings, **changed))
