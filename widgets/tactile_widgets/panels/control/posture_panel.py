"""The posture of the robot, joint by joint: sliders within the limits, typed values, copied and pasted."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from tactile_maps.core.arrays import FloatArray
from tactile_maps.robots.model.robot import Joint, Robot
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.panel import LabelledSlider, Panel
from tactile_widgets.common.wheel_guard import guard_wheel
from tactile_widgets.document.posture_editor import PostureEditor

_TURN = 2 * math.pi
"""Range of the slider of a joint without a limit, to either side [rad]."""
_SLIDE = 1.0
"""The same of a joint that slides [m]."""
_NEAR = math.radians(0.5)
"""A joint nearer than this is where it is wanted [rad, or m]."""
_EVERY = 6
"""Frames of which one is told in words: they are for the eye."""
_LIVE = "The robot goes there at 34°/s under its controller, which decides what a contact is given."
_PAUSED = "Time stands still: the robot is placed there, where nothing touches it."
_MOVED = "This scene moves the robot by itself."


class PosturePanel(Panel):
    """A slider a joint, made when the panel is first unfolded; what the robot does to get there, in a line below."""

    simulates = True
    scene_posture_wanted = Signal()
    """The robot is to have the posture of its scene."""
    copied = Signal()
    """The posture is to be copied."""
    pasted = Signal()
    """The copied posture is wanted."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Posture", "posture-panel", parent)
        self._editor: PostureEditor | None = None
        self._robot: Robot | None = None
        self._frames = 0
        self._editable = False
        self._moved = False
        self.sliders: list[LabelledSlider] = []
        self._rows = QWidget(self)
        self._how = self.caption(_LIVE)
        self.column.addWidget(self._rows)
        self._way = self.caption("\u00a0")  # one line from the start: the buttons do not move under the pointer
        self._buttons = self._make_buttons()
        self._heading.toggled.connect(self._build)  # sliders are made for whoever unfolds it

    def _make_buttons(self) -> tuple[QPushButton, ...]:
        row = QHBoxLayout()
        made = []
        for name, text, tip, told in (
            ("scene-posture", "Reset", "The posture of the scene again", self.scene_posture_wanted),
            ("copy-posture", "Copy", "Copy the posture wanted as text: a line a joint", self.copied),
            ("paste-posture", "Paste", "Take the copied posture", self.pasted),
        ):
            button = QPushButton(text, self)
            button.setObjectName(name)
            button.setAccessibleName(tip)
            button.setToolTip(tip)
            button.clicked.connect(told)
            row.addWidget(button)
            made.append(button)
        row.addStretch(1)
        self.column.addLayout(row)
        return tuple(made)

    def follow_editor(self, editor: PostureEditor) -> None:
        """Show what it wants, and tell it what a person wants."""
        self._editor = editor
        editor.changed.connect(self._on_changed)
        self._on_changed()

    # Facts.

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Another robot has other joints."""
        self._moved = bool(prepared.scene.motion)
        if prepared.robot is not self._robot:
            self._robot = prepared.robot
            self._clear()
            self._build()

    def set_editable(self, *, editable: bool) -> None:
        """Only a simulation can be led."""
        self._editable = editable
        self._on_changed()

    def show_frame(self, frame: Frame) -> None:
        """A few times a second: how far the robot is, or in a recording where."""
        self._frames += 1
        if self._frames % _EVERY or self.folded or self._editor is None:
            return
        if not self._editable:
            self._show_posture(frame.posture)
        elif not self._editor.placing:
            self._say_way(frame.posture)

    # Inside.

    def _clear(self) -> None:
        rows = self._rows
        self._rows = QWidget(self)
        self.column.replaceWidget(rows, self._rows)
        rows.deleteLater()
        self.sliders = []

    def _build(self, _folded: bool = False) -> None:
        """Cost: 1 ms a joint."""
        if self._robot is None or self.folded or self.sliders:
            return
        column = QVBoxLayout(self._rows)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(6)
        if not self._robot.joints:
            column.addWidget(QLabel("The robot has no joints.", self._rows))
        for number, joint in enumerate(self._robot.joints):
            slider = _slider(joint, self._rows)
            slider.value_changed.connect(partial(self._on_moved, number))
            slider.rested.connect(self._on_rested)
            slider.default_wanted.connect(partial(self._on_default_wanted, number))
            column.addWidget(slider)
            self.sliders.append(slider)
        guard_wheel(self._rows)
        self._on_changed()

    def _on_changed(self) -> None:
        editor = self._editor
        if editor is None:
            return
        possible = self._editable and editor.enabled
        for widget in (*self.sliders, *self._buttons):
            widget.setEnabled(possible)
        self._how.setText(_MOVED if self._moved else _PAUSED if editor.placing else _LIVE)
        if possible:
            self._show_posture(editor.wanted)
        if editor.placing or not possible:
            self._way.setText("\u00a0")

    def _show_posture(self, posture: FloatArray) -> None:
        """Nothing while the panel is folded, or between two robots."""
        if self._robot is None or not len(posture) == len(self.sliders) == len(self._robot.joints):
            return
        for slider, joint, position in zip(self.sliders, self._robot.joints, posture.tolist(), strict=True):
            if not slider.held:
                slider.set_value(shown(joint, position))

    def _say_way(self, posture: FloatArray) -> None:
        """Which joint has farthest to go; the controller may have other things to do first."""
        if self._editor is None or self._robot is None or len(posture) != len(self._editor.wanted):
            return
        off = self._editor.wanted - posture
        farthest = int(np.argmax(np.abs(off))) if len(off) else 0
        if not len(off) or abs(off[farthest]) < _NEAR:
            self._way.setText("There")
            return
        joint = self._robot.joints[farthest]
        self._way.setText(f"{joint.name.replace('_', ' ')} {_with_unit(joint, float(off[farthest]))} to go")

    # Wishes.

    def _on_moved(self, number: int, value: float) -> None:
        if self._editor is None or self._robot is None:
            return
        joint = self._robot.joints[number]
        name = f"set {joint.name.replace('_', ' ')}"
        posture = self._editor.wanted.copy()
        posture[number] = position_of(joint, value)
        if not self.sliders[number].held:  # typed, or turned by a key
            self._editor.do(name, posture, goes_on=True)
            return
        if self._editor.gesture != name:
            self._editor.begin(name)
        self._editor.change(posture)

    def _on_rested(self, _value: float) -> None:
        if self._editor is not None:
            self._editor.end()

    def _on_default_wanted(self, number: int) -> None:
        if self._editor is None or self._robot is None:
            return
        posture = self._editor.wanted.copy()
        posture[number] = self._robot.home[number]
        self._editor.do(f"reset {self._robot.joints[number].name.replace('_', ' ')}", posture)


def shown(joint: Joint, position: float) -> float:
    """A joint's position [rad, or m] in the unit that people read: degrees, or millimetres."""
    return 1e3 * position if joint.slide else math.degrees(position)


def position_of(joint: Joint, value: float) -> float:
    """The position [rad, or m] of what people read."""
    return 1e-3 * value if joint.slide else math.radians(value)


def _with_unit(joint: Joint, position: float) -> str:
    return f"{shown(joint, position):+.0f}\u202fmm" if joint.slide else f"{shown(joint, position):+.0f}°"


def _slider(joint: Joint, parent: QWidget) -> LabelledSlider:
    most = _SLIDE if joint.slide else _TURN
    low = max(joint.lower, -most)
    high = min(joint.upper, most)
    words = "no limit" if math.isinf(joint.lower) else f"limits {_with_unit(joint, low)} and {_with_unit(joint, high)}"
    low = math.ceil(10 * shown(joint, low)) / 10
    high = math.floor(10 * shown(joint, high)) / 10
    unit = "mm" if joint.slide else "°"
    name = joint.name.replace("_", " ")
    slider = LabelledSlider(name, unit, low, high, 0.1, f"Position of the joint {name}, {words}", parent)
    slider.set_default_tip("the scene's posture")
    slider.setObjectName(f"joint-{joint.name}")
    return slider
