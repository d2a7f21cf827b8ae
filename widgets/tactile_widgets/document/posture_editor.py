"""The posture that is wanted of the robot: set by sliders or by dragging a link, with steps that are taken back.

While time passes the robot goes there under its controller, at a bounded speed; while it stands still, the robot is
placed there as soon as the gesture ends, and shown there until then.
"""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QObject, Signal

from tactile_maps.control.motion.joint_impedance import joint_limits
from tactile_maps.core.arrays import FloatArray, readonly
from tactile_maps.robots.model.robot import Robot
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene

MOST_STEPS = 100
_SAME = 1e-9
"""Joints nearer than this are where they are wanted [rad, or m]."""


class PostureEditor(QObject):
    """Knows what is wanted, and what was wanted before. Mutable.

    A gesture changes the posture at each move of the mouse and is one step: ``begin``, ``change``, then ``end`` or
    ``cancel``.

    Args:
        parent: Qt parent.

    Attributes:
        robot: Whose posture; None before there is one.
        wanted: (n,) each joint's position [rad, or m].
        found: (n,) the posture that was shown last.
        enabled: Whether there is a simulated robot that can be led.
        placing: Whether time stands still: the robot is placed, and does not go there.
        gesture: Name of the gesture that is going on; empty for none.
        lower: (n,) limits of the joints.
        upper: (n,).
    """

    wished = Signal(np.ndarray)
    """Target posture (n,) [rad, or m]; during a gesture, each intermediate one."""
    previewed = Signal(np.ndarray)
    """Posture (n,) to preview [rad, or m]; None to end the preview."""
    changed = Signal()
    """Something that can be asked is something else."""
    told = Signal(str)
    """What a person should know."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.robot: Robot | None = None
        self.enabled = self.placing = False
        self.gesture = ""
        self._tick = -1
        self._forget(np.zeros(0))

    def _forget(self, home: FloatArray) -> None:
        self.wanted = self.found = self._before = readonly(home)
        self.lower = self.upper = self.wanted
        self._steps: list[tuple[str, FloatArray, FloatArray]] = []
        self._position = 0
        self.gesture = ""

    # Facts.

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Another robot, or the same from its start."""
        self.robot = prepared.robot
        self._tick = -1
        self._forget(prepared.robot.home)
        self.lower, self.upper = joint_limits(prepared.robot)
        self.changed.emit()

    def show_frame(self, frame: Frame) -> None:
        """Another instant; one before the last is a new start, at which the posture wanted is forgotten."""
        if self.robot is None or len(frame.posture) != len(self.robot.joints):
            return
        if frame.tick < self._tick:
            lower = self.lower
            upper = self.upper
            self._forget(self.robot.home)
            self.lower = lower
            self.upper = upper
            self.changed.emit()
        self._tick = frame.tick
        self.found = frame.posture

    def show_wanted(self, posture: FloatArray) -> None:
        """Show the target posture (n,) of a session that did not begin at home."""
        self.wanted = readonly(np.clip(posture, self.lower, self.upper))
        self.changed.emit()

    def set_mode(self, *, enabled: bool, placing: bool) -> None:
        """Whether there is a robot to lead, and whether time stands still."""
        if not enabled:
            self.cancel()
        self.enabled = enabled
        self.placing = placing
        self.changed.emit()

    def refused(self) -> None:
        """The posture asked for last is not taken: what was wanted before is wanted again."""
        if self._position:
            self._position -= 1
            _, before, _ = self._steps[self._position]
            del self._steps[self._position :]
            self.wanted = before
        self.previewed.emit(None)
        self.changed.emit()

    # Wishes.

    def do(self, name: str, posture: FloatArray, *, goes_on: bool = False) -> None:
        """Want a posture (n,) in one step; one that ``goes_on`` makes one step with the last of that name."""
        self.begin(name)
        self.change(posture)
        self.end(goes_on=goes_on)

    def begin(self, name: str) -> None:
        """A gesture starts; one that goes on has ended."""
        self.end()
        self.gesture = name
        self._before = self.wanted

    def change(self, posture: FloatArray) -> None:
        """What the gesture wants so far, within the limits."""
        if not self.enabled:
            return
        self.wanted = readonly(np.clip(posture, self.lower, self.upper))
        (self.previewed if self.placing else self.wished).emit(self.wanted)
        self.changed.emit()

    def end(self, *, goes_on: bool = False) -> None:
        """The gesture is one step, and a robot that is placed is placed now. Nothing without a gesture."""
        name = self.gesture
        self.gesture = ""
        if not name:
            return
        if np.abs(self.wanted - self._before).max(initial=0.0) > _SAME:
            self._keep(name, goes_on=goes_on)
            if self.placing:
                self.wished.emit(self.wanted)
        self.changed.emit()

    def _keep(self, name: str, *, goes_on: bool) -> None:
        kept = self._steps[: self._position]
        before = self._before
        if goes_on and kept and kept[-1][0] == name:
            before = kept.pop()[1]
        self._steps = [*kept, (name, before, self.wanted)][-MOST_STEPS:]
        self._position = len(self._steps)

    def cancel(self) -> bool:
        """The gesture never was. Whether there was one."""
        name = self.gesture
        self.gesture = ""
        if name:
            self.wanted = self._before
            if self.placing:
                self.previewed.emit(None)
            elif self.enabled:
                self.wished.emit(self.wanted)
            self.changed.emit()
        return bool(name)

    # Undo.

    @property
    def can_undo(self) -> bool:
        """Whether there is a gesture or a step to take back."""
        return self.enabled and bool(self.gesture or self._position)

    @property
    def can_redo(self) -> bool:
        """Whether a step was taken back."""
        return self.enabled and not self.gesture and self._position < len(self._steps)

    @property
    def undo_name(self) -> str:
        """What ``undo`` takes back; empty for nothing."""
        return self._steps[self._position - 1][0] if self._position else ""

    @property
    def redo_name(self) -> str:
        """What ``redo`` does again; empty for nothing."""
        return self._steps[self._position][0] if self._position < len(self._steps) else ""

    def undo(self) -> None:
        """Want again what was wanted before the last step; the robot goes back, or is placed there."""
        if self.cancel() or not self.can_undo:
            return
        self._position -= 1
        name, before, _ = self._steps[self._position]
        self._want_again(before)
        self.told.emit(f"Undone: {name}")

    def redo(self) -> None:
        """Do again what was taken back last."""
        if not self.can_redo:
            return
        name, _, after = self._steps[self._position]
        self._position += 1
        self._want_again(after)
        self.told.emit(f"Redone: {name}")

    def _want_again(self, posture: FloatArray) -> None:
        self.wanted = posture
        self.wished.emit(posture)
        self.changed.emit()
