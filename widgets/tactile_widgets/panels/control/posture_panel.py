"""The posture of the robot, joint by joint: sliders within the limits, typed values, copied and pasted."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QLabel, QWidget

from tactile_maps.core.arrays import FloatArray
from tactile_maps.robots.model.robot import Joint, Robot
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.make import column_layout, make, push_button, row_layout
from tactile_widgets.common.number_field import guard_wheel
from tactile_widgets.common.panel import LabelledSlider, Panel
from tactile_widgets.document.posture_editor import PostureEditor

_TURN = 2 * math.pi
"""Range of the slider of a revolute joint without a limit, to either side [rad]."""
_SLIDE = 1.0
"""Range of the slider of a prismatic joint without a limit, to either side [m]."""
_NEAR = math.radians(0.5)
"""Distance within which a joint has reached its target [rad or m]."""
_EVERY = 6
"""Frames per update of sliders and text."""
_LIVE = "The robot moves there at 34°/s under its controller, which also controls contacts."
_PAUSED = "The simulation is paused: the robot is placed there, and nothing touches it."
_MOVED = "This scene moves the robot by itself."
_BLANK = "\u00a0"


class PosturePanel(Panel):
    """Sliders of the joints, constructed when the panel is first unfolded, and the remaining distance below them."""

    simulates = True
    scene_posture_requested = Signal()
    """The user resets the robot to the posture of its scene."""
    copied = Signal()
    """The user copies the posture."""
    pasted = Signal()
    """The user pastes a posture."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Posture", "posture-panel", parent)
        self._editor: PostureEditor | None = None
        self._robot: Robot | None = None
        self._frames = 0
        self._editable = False
        self._radians = False
        self._moved = False
        self.sliders: list[LabelledSlider] = []
        self._rows = QWidget(self)
        self._how = self.caption(_LIVE)
        self.column.addWidget(self._rows)
        self._way = self.caption(_BLANK)  # one line from the start: the buttons do not move under the pointer
        self._buttons = [
            push_button(self, name, text, tip, clicked, accessibleName=tip)
            for name, text, tip, clicked in (
                ("scene-posture", "Reset", "Return to the posture of the scene", self.scene_posture_requested),
                ("copy-posture", "Copy", "Copy the target posture as text: a line a joint", self.copied),
                ("paste-posture", "Paste", "Take the copied posture", self.pasted),
            )
        ]
        self.column.addLayout(row_layout(*self._buttons, None))
        self._heading.toggled.connect(self._build)

    def follow_editor(self, editor: PostureEditor) -> None:
        """Show and change the posture of an editor."""
        self._editor = editor
        editor.changed.connect(self._on_changed)
        self._on_changed()

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show the joints of another robot."""
        self._moved = bool(prepared.scene.motion)
        if prepared.robot is not self._robot:
            self._robot = prepared.robot
            self._rebuild()

    def set_angles(self, *, radians: bool) -> None:
        """Show revolute joints in radians or degrees."""
        if radians is not self._radians:
            self._radians = radians
            self._rebuild()

    def _rebuild(self) -> None:
        rows = self._rows
        self._rows = QWidget(self)
        self.column.replaceWidget(rows, self._rows)
        rows.deleteLater()
        self.sliders = []
        self._build()

    def set_editable(self, *, editable: bool) -> None:
        self._editable = editable
        self._on_changed()

    def show_frame(self, frame: Frame) -> None:
        """Show the remaining distance, or in a recording the posture, a few times per second."""
        self._frames += 1
        if self._frames % _EVERY or self.folded or self._editor is None:
            return
        if not self._editable:
            self._show_posture(frame.posture)
        elif not self._editor.placing:
            self._show_distance(frame.posture)

    def _build(self, _folded: bool = False) -> None:
        """Construct the sliders if they are missing and visible. Cost: 1 ms per joint."""
        if self._robot is None or self.folded or self.sliders:
            return
        for number, joint in enumerate(self._robot.joints):
            slider = _slider(joint, _Unit(joint, self._radians), self._rows)
            slider.value_changed.connect(partial(self._on_moved, number))
            slider.rested.connect(self._on_rested)
            slider.default_requested.connect(partial(self._on_default_requested, number))
            self.sliders.append(slider)
        shown: list[QWidget] = [*self.sliders] or [QLabel("The robot has no joints.", self._rows)]
        column_layout(*shown, parent=self._rows, spacing=6)
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
            self._show_posture(editor.target)
        if editor.placing or not possible:
            self._way.setText(_BLANK)

    def _show_posture(self, posture: FloatArray) -> None:
        """Move the sliders, if they exist and belong to the robot of this posture."""
        if self._robot is None or not len(posture) == len(self.sliders) == len(self._robot.joints):
            return
        for slider, joint, position in zip(self.sliders, self._robot.joints, posture.tolist(), strict=True):
            if not slider.held:
                slider.set_value(_Unit(joint, self._radians).shown(position))

    def _show_distance(self, posture: FloatArray) -> None:
        """Show the joint with the largest remaining distance; the controller may have other tasks first."""
        if self._editor is None or self._robot is None or len(posture) != len(self._editor.target):
            return
        off = self._editor.target - posture
        farthest = int(np.argmax(np.abs(off))) if len(off) else 0
        if not len(off) or abs(off[farthest]) < _NEAR:
            self._way.setText("There")
            return
        joint = self._robot.joints[farthest]
        self._way.setText(f"{_title(joint)} {_Unit(joint, self._radians).words(float(off[farthest]))} to go")

    def _on_moved(self, number: int, value: float) -> None:
        if self._editor is None or self._robot is None:
            return
        joint = self._robot.joints[number]
        name = f"set {_title(joint)}"
        posture = self._editor.target.copy()
        posture[number] = value / _Unit(joint, self._radians).factor
        if not self.sliders[number].held:  # typed, or changed by a key
            self._editor.do(name, posture, continues=True)
            return
        if self._editor.gesture != name:
            self._editor.begin(name)
        self._editor.change(posture)

    def _on_rested(self, _value: float) -> None:
        if self._editor is not None:
            self._editor.end()

    def _on_default_requested(self, number: int) -> None:
        if self._editor is None or self._robot is None:
            return
        posture = self._editor.target.copy()
        posture[number] = self._robot.home[number]
        self._editor.do(f"reset {_title(self._robot.joints[number])}", posture)


class _Unit:
    """Unit in which the position of a joint is shown: mm for slides, degrees or radians for others.

    Attributes:
        factor: Number of units in a metre or radian.
        parts: Number of steps of a slider in a unit.
        name: Its name.
    """

    def __init__(self, joint: Joint, radians: bool) -> None:
        self.factor = 1e3 if joint.slide else 1.0 if radians else math.degrees(1.0)
        self.parts = 100 if radians and not joint.slide else 10
        self.name = "mm" if joint.slide else "rad" if radians else "°"

    def shown(self, position: float) -> float:
        """Return a position [rad or m] in this unit."""
        return self.factor * position

    def words(self, position: float) -> str:
        """Return a position [rad or m] as text."""
        digits = 2 if self.name == "rad" else 0
        space = "" if self.name == "°" else "\u202f"
        return f"{self.shown(position):+.{digits}f}{space}{self.name}"


def _title(joint: Joint) -> str:
    return joint.name.replace("_", " ")


def _slider(joint: Joint, unit: _Unit, parent: QWidget) -> LabelledSlider:
    most = _SLIDE if joint.slide else _TURN
    low = max(joint.lower, -most)
    high = min(joint.upper, most)
    words = "no limit" if math.isinf(joint.lower) else f"limits {unit.words(low)} and {unit.words(high)}"
    low = math.ceil(unit.parts * unit.shown(low)) / unit.parts
    high = math.floor(unit.parts * unit.shown(high)) / unit.parts
    tip = f"Position of the joint {_title(joint)}, {words}"
    name = f"joint-{joint.name}"
    slider = make(LabelledSlider, _title(joint), unit.name, low, high, 1 / unit.parts, tip, parent, objectName=name)
    slider.set_default_tip("the scene's posture")
    return slider
