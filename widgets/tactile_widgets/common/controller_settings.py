"""Controller settings in the window: labels and tool tips of tasks and paths, ranges of gains.

``ControllerSliders`` shows the settings that the chosen controller and task use. ``GainsByController`` (no Qt) stores
the gains of each controller while another one is tried, and the default gains. Used by the controller panel, the menus
and the comparison of controllers.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from tactile_maps.control.controller_registry import CONTROLLERS, effective_settings
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.scene.tasks import SHEAR_SETTINGS
from tactile_widgets.common.make import column_layout
from tactile_widgets.common.panel import LabelledSlider

CONTROLLER_SCENES = {
    "impedance": "arm",
    "hold_force": "poke",
    "admittance": "poke",
    "hybrid": "follow_path",
    "parallel": "follow_path",
    "projection": "follow_path",
    "priority": "crowded",
    "qp": "crowded",
}
"""Scene that shows best how a controller differs from others."""
SETTING_CHOICES = {
    "task": (
        "Task",
        {
            "keep_force": "Keep force",
            "hold_point": "Hold contact position",
            "follow_path": "Follow path",
            "balance": "Balance contact forces",
            "retreat": "Retreat from touch",
            "guide": "Hand guiding",
        },
    ),
    "path_kind": (
        "Path shape",
        {"polyline": "Polyline", "spline": "Spline", "lemniscate": "Figure of eight", "raster": "Raster"},
    ),
    "gains": (
        "Gain limits for sensor rate and delay",
        {"limited": "Limit gains for sensor rate and delay", "as_given": "Unlimited gains"},
    ),
    "jacobian": (
        "Jacobian of the map",
        {
            "smoothed": "Smoothed Jacobian (2-ring)",
            "raw": "Exact per-triangle Jacobian",
            "isometric": "Isometric (map distortion ignored)",
        },
    ),
}
"""Tool tip, and label by value, of each setting that is chosen from a list."""

RESTART_LABELS = {"follow_path": "Restart path", "hold_point": "Hold current position"}
"""Label of restarting a task, by task that stores a position."""


class SliderSpec(NamedTuple):
    """A slider: its text, unit, range and step as shown, shown units per SI unit, and tool tip."""

    text: str
    unit: str
    low: float
    high: float
    step: float
    scale: float
    tip: str


SLIDERS = {
    "stiffness": SliderSpec(
        "Natural frequency",
        "rad/s",
        1.0,
        30.0,
        0.5,
        1.0,
        "Natural frequency of each joint about its home; higher is stiffer",
    ),
    "damping_ratio": SliderSpec("Damping ratio", "", 0.1, 2.0, 0.05, 1.0, "1 returns without overshoot"),
    "force_goal": SliderSpec("Force goal", "N", 0.0, 15.0, 0.5, 1.0, "Contact force to keep; 0 only retreats"),
    "shear_goal": SliderSpec(
        "Shear goal",
        "N",
        0.0,
        15.0,
        0.5,
        1.0,
        "Force along the skin to keep; 0 for none. It needs taxels that measure shear",
    ),
    "shear_direction": SliderSpec(
        "Shear direction",
        "°",
        -180.0,
        180.0,
        5.0,
        180.0 / math.pi,
        "Direction of the shear goal on the map: 0° to the right, 90° up",
    ),
    "shear_threshold": SliderSpec(
        "Guiding threshold",
        "N",
        0.0,
        5.0,
        0.1,
        1.0,
        "Force along the skin with which a hand begins to move the arm. It needs taxels that measure shear",
    ),
    "force_gain": SliderSpec(
        "Force gain",
        "mm/s per N",
        1.0,
        40.0,
        1.0,
        1e3,
        "Approach or retreat speed per newton of force error",
    ),
    "integral_time": SliderSpec(
        "Integral time", "s", 0.05, 2.0, 0.05, 1.0, "Shorter removes steady-state errors faster, and overshoots more"
    ),
    "position_gain": SliderSpec(
        "Position gain", "1/s", 0.0, 12.0, 0.5, 1.0, "Speed on the map per metre of position error"
    ),
    "inertia_time": SliderSpec(
        "Inertia", "ms", 0.0, 300.0, 10.0, 1e3, "Time constant of the virtual mass: longer reacts more slowly"
    ),
    "path_speed": SliderSpec("Path speed", "mm/s", 0.0, 60.0, 1.0, 1e3, "Speed along the path on the map"),
    "path_size": SliderSpec(
        "Path size",
        "mm",
        10.0,
        100.0,
        5.0,
        1e3,
        "Size of the default path around the first contact, used when none is drawn",
    ),
    "max_force": SliderSpec("Force limit", "N", 5.0, 100.0, 5.0, 1.0, "Contact force above which the arm stops"),
    "max_impact": SliderSpec(
        "Impact limit",
        "N",
        5.0,
        200.0,
        5.0,
        1.0,
        "Largest force with which the skin may hit an object at rest: the arm moves more slowly where it would be "
        "larger",
    ),
    "max_shear": SliderSpec(
        "Shear limit",
        "N",
        0.0,
        20.0,
        0.5,
        1.0,
        "Largest force along the skin: a contact with more yields along the skin. It needs taxels that measure shear",
    ),
    "friction_use": SliderSpec(
        "Friction in use",
        "%",
        20.0,
        100.0,
        5.0,
        100.0,
        "Largest share of its friction that a contact may use: the force goal rises while it uses more. "
        "It needs taxels that measure shear",
    ),
}
"""Slider of each setting, in the order shown."""


GAIN_SETTINGS = (
    "stiffness",
    "damping_ratio",
    "force_gain",
    "integral_time",
    "position_gain",
    "gains",
    "inertia_time",
    "jacobian",
)
"""Settings of how a controller works; the others define its task."""
_SHEAR_SETTINGS = frozenset((*SHEAR_SETTINGS, "shear_direction", "shear_threshold"))
"""Settings that need taxels that measure shear."""


class GainsByController:
    """Gains of each controller. Mutable: ``switched`` and ``begin``.

    Attributes:
        defaults: Default gains.
    """

    def __init__(self) -> None:
        self.begin(ControlSettings())

    def begin(self, defaults: ControlSettings) -> None:
        """Forget all gains, for another scene."""
        self.defaults = defaults
        self._known: dict[str, dict[str, Any]] = {}

    def switched(self, settings: ControlSettings, controller: str) -> ControlSettings:
        """Return the settings with another controller, with its last gains if it was used before."""
        self._known[settings.controller] = {name: getattr(settings, name) for name in GAIN_SETTINGS}
        return replace(settings, controller=controller, **self._known.get(controller, {}))

    def reset(self, settings: ControlSettings) -> ControlSettings:
        """Return the settings with default gains."""
        began: dict[str, Any] = {name: getattr(self.defaults, name) for name in GAIN_SETTINGS}
        return replace(settings, **began)


def settings_by_controller(settings: ControlSettings) -> dict[str, frozenset[str]]:
    """Return the names of the settings that affect each controller, with the task and path of ``settings``."""
    return {c: effective_settings(replace(settings, controller=c)) for c in CONTROLLERS}


class ControllerSliders(QWidget):
    """Sliders of controller settings; a double-click on a name restores its default.

    Args:
        names: Keys of ``SLIDERS``, in the order shown.
        parent: Qt parent.
    """

    settings_edited = Signal(ControlSettings)
    """Controller settings entered by the user."""

    def __init__(self, names: Iterable[str] = SLIDERS, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._settings = self._defaults = ControlSettings()
        self._without = frozenset[str]()
        self.by_name: dict[str, LabelledSlider] = {}
        column = column_layout(parent=self)
        for name in names:
            spec = SLIDERS[name]
            slider = LabelledSlider(spec.text, spec.unit, spec.low, spec.high, spec.step, spec.tip, self)
            slider.setObjectName(f"gain-{name}")
            slider.value_changed.connect(partial(self._on_value_changed, name))
            slider.default_requested.connect(partial(self._on_default_requested, name))
            self.by_name[name] = slider
            column.addWidget(slider)
        column.addStretch(1)
        self._heights = max(slider.sizeHint().height() for slider in self.by_name.values()) + column.spacing()
        self.set_defaults(self._defaults)

    def set_defaults(self, defaults: ControlSettings) -> None:
        """Set the defaults of the sliders."""
        self._defaults = defaults
        for name, slider in self.by_name.items():
            spec = SLIDERS[name]
            slider.set_default_tip(f"{getattr(defaults, name) * spec.scale:.4g}\u202f{spec.unit}".strip())

    def set_measured(self, *, shear: bool) -> None:
        """Hide the settings of shear for a skin that measures none, or show them."""
        self._without = frozenset() if shear else _SHEAR_SETTINGS
        self.show_settings(self._settings)

    def show_settings(self, settings: ControlSettings) -> None:
        """Show the current settings."""
        self._settings = settings
        names = effective_settings(settings) - self._without
        for name, slider in self.by_name.items():
            slider.set_value(getattr(settings, name) * SLIDERS[name].scale)
            slider.setVisible(name in names)
        self.setMinimumHeight(self._most(settings) * self._heights)

    def _most(self, settings: ControlSettings) -> int:
        """Return the largest number of sliders of a controller for this task, whose room is reserved for all."""
        of_each = (effective_settings(replace(settings, controller=c)) for c in CONTROLLERS)
        return max(len((names - self._without) & self.by_name.keys()) for names in of_each)

    def _on_value_changed(self, name: str, value: float) -> None:
        self._edit(name, value / SLIDERS[name].scale)

    def _on_default_requested(self, name: str) -> None:
        self._edit(name, getattr(self._defaults, name))

    def _edit(self, name: str, value: float) -> None:
        changed: dict[str, Any] = {name: value}
        self.settings_edited.emit(replace(self._settings, **changed))
