"""Target posture of the robot, set by sliders or by dragging a link, with undo and redo.

In a running session the robot moves to the target under its controller, at a bounded speed. In a paused session the
target is previewed during the gesture, and the robot is placed there when the gesture ends.
"""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QObject, Signal

from tactile_maps.control.motion.joint_impedance import joint_limits
from tactile_maps.core.arrays import FloatArray, readonly
from tactile_maps.editing.history import Step
from tactile_maps.robots.model.robot import Robot
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.document.step_list import StepList

MOST_STEPS = 100
_SAME = 1e-9
"""Joints closer than this to their target have reached it [rad, or m]."""


class PostureEditor(QObject):
    """The target posture and its previous values. Mutable.

    A gesture changes the target at each mouse move and is one step: ``begin``, ``change``, then ``end`` or ``cancel``.

    Args:
        parent: Qt parent.

    Attributes:
        robot: The robot; None before the first.
        target: (n,) target position of each joint [rad, or m].
        found: (n,) posture of the newest frame [rad, or m].
        enabled: True if there is a simulated robot that can be moved.
        placing: True while the session is paused: the robot is placed at the target instead of moving there.
        gesture: Name of the current gesture; empty if there is none.
        lower: (n,) lower limits of the joints [rad, or m].
        upper: (n,) upper limits of the joints [rad, or m].
    """

    requested = Signal(np.ndarray)
    """Target posture (n,) [rad, or m]; during a gesture, each intermediate one."""
    previewed = Signal(np.ndarray)
    """Posture (n,) to preview [rad, or m]; None to end the preview."""
    changed = Signal()
    """The target, the steps or the limits changed."""
    notified = Signal(str)
    """Message for the status line."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.robot: Robot | None = None
        self.enabled = self.placing = False
        self.gesture = ""
        self._tick = -1
        self._rejected = False
        self._steps = StepList[FloatArray](MOST_STEPS)
        self._return_home(np.zeros(0))

    def _return_home(self, home: FloatArray) -> None:
        self.target = self.found = self._before = readonly(home)
        self.lower = self.upper = self.target
        self.gesture = ""

    # State of the session.

    def show_prepared(self, prepared: PreparedScene, *, other_skin: bool = False) -> None:
        """Reset for another robot, or for a new session of the same robot; ``other_skin`` keeps the undo steps."""
        self.robot = prepared.robot
        self._tick = -1
        if not other_skin or len(prepared.robot.joints) != len(self.target):
            self._steps.reset()
        self._return_home(prepared.robot.home)
        self.lower, self.upper = joint_limits(prepared.robot)
        self.changed.emit()

    def show_frame(self, frame: Frame) -> None:
        """Take a new frame; a tick before the last one means a reset session, which resets the target."""
        if self.robot is None or len(frame.posture) != len(self.robot.joints):
            return
        if frame.tick < self._tick:
            lower = self.lower
            upper = self.upper
            self._steps.reset()
            self._return_home(self.robot.home)
            self.lower = lower
            self.upper = upper
            self.changed.emit()
        self._tick = frame.tick
        self.found = frame.posture

    def show_target(self, posture: FloatArray) -> None:
        """Show the target posture (n,) of a session that did not begin at the home posture."""
        self.target = readonly(np.clip(posture, self.lower, self.upper))
        self.changed.emit()

    def set_mode(self, *, enabled: bool, placing: bool) -> None:
        """Set whether there is a robot to move, and whether the session is paused."""
        if not enabled:
            self.cancel()
        self.enabled = enabled
        self.placing = placing
        self.changed.emit()

    def reject(self) -> None:
        """Note, during ``requested``, that the session rejects the target."""
        self._rejected = True

    # Edits.

    def do(self, name: str, posture: FloatArray, *, continues: bool = False) -> None:
        """Set the target posture (n,) in one step; with ``continues``, merged with a last step of the same name."""
        self.begin(name)
        self.change(posture)
        self.end(continues=continues)

    def begin(self, name: str) -> None:
        """Start a gesture, after ending the current one."""
        self.end()
        self.gesture = name
        self._before = self.target

    def change(self, posture: FloatArray) -> None:
        """Set the target (n,) during the gesture, clipped to the limits."""
        if not self.enabled:
            return
        self.target = readonly(np.clip(posture, self.lower, self.upper))
        (self.previewed if self.placing else self.requested).emit(self.target)
        self.changed.emit()

    def end(self, *, continues: bool = False) -> None:
        """Complete the gesture as one step; in a paused session, place the robot."""
        name = self.gesture
        self.gesture = ""
        if not name:
            return
        before = self._before
        if np.abs(self.target - before).max(initial=0.0) > _SAME and (
            not self.placing or self._request(self.target, before)
        ):
            self._steps.push(name, before, self.target, extend=continues)
        self.changed.emit()

    def cancel(self) -> bool:
        """Discard the gesture; return whether there was one."""
        name = self.gesture
        self.gesture = ""
        if name:
            self.target = self._before
            if self.placing:
                self.previewed.emit(None)
            elif self.enabled:
                self.requested.emit(self.target)
            self.changed.emit()
        return bool(name)

    # Undo.

    @property
    def can_undo(self) -> bool:
        """True if there is a gesture or a step to undo."""
        return self.enabled and bool(self.gesture or self.undo_step.number)

    @property
    def can_redo(self) -> bool:
        """True if there is a step to redo."""
        return self.enabled and not self.gesture and bool(self.redo_step.number)

    @property
    def undo_step(self) -> Step:
        """The step that ``undo`` reverts."""
        return self._steps.undo_step

    @property
    def redo_step(self) -> Step:
        """The step that ``redo`` applies."""
        return self._steps.redo_step

    @property
    def unfinished(self) -> bool:
        """Whether there is a gesture."""
        return bool(self.gesture)

    def undo(self) -> None:
        """Return to the target before the last step; the robot moves or is placed there."""
        if self.cancel() or not self.can_undo:
            return
        name = self.undo_step.name
        if self._request(self._steps.back(), self.target):
            self.notified.emit(f"Undone: {name}")
        else:
            self._steps.forward()
        self.changed.emit()

    def redo(self) -> None:
        """Apply the step that was undone last."""
        if not self.can_redo:
            return
        name = self.redo_step.name
        if self._request(self._steps.forward(), self.target):
            self.notified.emit(f"Redone: {name}")
        else:
            self._steps.back()
        self.changed.emit()

    def _request(self, posture: FloatArray, before: FloatArray) -> bool:
        """Request a target; return False, and return to the target ``before``, if the session rejects it."""
        self.target = posture
        self._rejected = False
        self.requested.emit(posture)
        if self._rejected:
            self.target = before
            self.previewed.emit(None)
        return not self._rejected
