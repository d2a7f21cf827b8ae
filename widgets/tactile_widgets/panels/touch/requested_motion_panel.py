"""The requested motion of the robot whose skin is connected; once armed, it is sent while a switch is on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QLineEdit, QSizePolicy, QWidget

from tactile_maps.control.controller_registry import CONTROLLERS
from tactile_maps.control.limit_texts import limit_text
from tactile_maps.live.motion.command_latency import latency_text
from tactile_maps.live.motion.motion_sender import FORCES, SPEEDS, MotionLimits, StopReason
from tactile_maps.live.session.facts import tare_doubt
from tactile_maps.robots.model.robot import Robot
from tactile_widgets.common.make import SteadyLabel, add_fact, make, push_button, row_layout, value_label
from tactile_widgets.common.mode import Mode
from tactile_widgets.common.number_field import NumberField
from tactile_widgets.common.panel import FlatComboBox
from tactile_widgets.common.sentence import as_sentence
from tactile_widgets.panels.touch.connected_panel import ConnectedPanel
from tactile_widgets.session.live_input import LiveInput
from tactile_widgets.session.live_motion import MotionFacts

_NAME = "wanted-motion-panel"
"""Object name, which is stored in the settings of existing users."""
_REFRESH_MS = 100
_FASTEST = 3
"""Number of listed joints, the fastest ones."""
_LEAST_ROOM = 200
"""Width for a joint's name and velocity before the panel has been laid out [px]."""
_UNKNOWN = "–"
ADDRESS = "udp://127.0.0.1:9900"
_CONTROLLER_TIP = "Controller whose motion is shown; goal and gains are those from before connecting"
_ARM_TIP = "Allow sending. Stopping, disconnecting, a pause and a replay take the permission back."
_SEND_TIP = "Send the requested velocities: the robot may move. Press again to stop it. Arm it first."
_BLOCKED = {
    Mode.PAUSED: "The readings are paused. Press Play to arm.",
    Mode.REPLAYING: "A recording is shown. Press Back to live to arm.",
}
_SLOWED_TIP = "Faster motion is slowed as a whole; the speed limits of the robot's model apply as well"


class RequestedMotionPanel(ConnectedPanel):
    """The motion of a controller, which runs only while the panel is unfolded or its motion is sent."""

    stop_reported = Signal(str, bool)
    """Reason for which sending stopped without the user's request, and whether the reason is a doubtful tare; an empty
    reason once the motion is sent again."""
    start_refused = Signal(str)
    """Reason why sending did not start."""
    tare_doubted = Signal(str)
    """Reason why the tare is doubtful, which prevents arming; ``arm`` arms nevertheless."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Requested motion", _NAME, _REFRESH_MS, parent)
        self._error = ""
        self._accepted = ""  # the doubt about the tare with which the user armed
        self._blocked = ""  # why the window's mode does not allow sending
        grid = self.grid()
        grid.setColumnStretch(0, 1)
        self._controller = make(
            FlatComboBox,
            self,
            objectName="motion-controller",
            accessibleName="Controller",
            activated=self._on_controller_activated,
        )
        self._names = [name for name in CONTROLLERS if name != "impedance"]
        self._controller.addItems([CONTROLLERS[name].title for name in self._names])
        self._force = value_label(_UNKNOWN, self, right=True, objectName="motion-force")
        self._joints = value_label(_UNKNOWN, self, objectName="motion-joints")
        self._joints.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignTop)
        self._joints.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)  # names must not widen it
        self._joints.setText((_FASTEST - 1) * "\n")
        self._joints.setMinimumHeight(self._joints.sizeHint().height())
        add_fact(grid, 0, "Controller", _CONTROLLER_TIP, self._controller)
        add_fact(grid, 1, "Contact force", "Measured normal force of the strongest contact", self._force)
        grid.addWidget(value_label("Fastest joints", self, toolTip="Requested velocities, the largest first"), 2, 0)
        grid.addWidget(self._joints, 3, 0, 1, 2)
        self._address = make(
            QLineEdit,
            ADDRESS,
            self,
            objectName="motion-address",
            accessibleName="Address of the robot's driver",
            toolTip="udp://HOST:PORT or zmq://HOST:PORT on this computer; the guide describes the messages",
        )
        self.column.addLayout(row_layout(value_label("Driver", self), self._address, stretch=self._address))
        self._speed = NumberField("Fastest joint sent", "rad/s", *SPEEDS, 0.005, _SLOWED_TIP, self)
        ended = "A stronger contact ends sending"
        self._most_force = NumberField("Largest force", "N", *FORCES, 1.0, ended, self)
        self._speed.show_number(MotionLimits().speed)
        self._most_force.show_number(MotionLimits().force)
        self.column.addLayout(row_layout(value_label("At most", self), None, self._speed, self._most_force))
        self._switch = push_button(
            self, "motion-send", "Send to the robot", _SEND_TIP, self._on_switched, checkable=True
        )
        self._arm = push_button(self, "motion-arm", "Arm", _ARM_TIP, self._on_armed, checkable=True)
        self._switch.setEnabled(False)
        self.column.addLayout(row_layout(self._arm, self._switch, stretch=self._switch))
        # The buttons must not move under the pointer: changing texts are below them and keep their height.
        self._sent = self.caption(name="motion-sent", kind=SteadyLabel)
        self._notes = self.caption(name="motion-notes", kind=SteadyLabel)

    def show_input(self, live: LiveInput | None) -> None:
        self._error = ""
        self._arm.setChecked(False)
        super().show_input(live)
        if live is None:
            self._switch.setChecked(False)
        self._show_armed()

    def set_mode(self, mode: Mode) -> None:
        """Stop sending and disarm where the readings are not shown as they arrive."""
        self._blocked = _BLOCKED.get(mode, "")
        if self._blocked:
            if self._switch.isChecked():
                self._act(lambda live: live.stop_motion(StopReason.PAUSED))
            self._arm.setChecked(False)
        self._show_armed()
        self.refresh()

    def arm(self) -> None:
        """Arm, although the tare may be doubtful; does nothing where the window's mode does not allow it."""
        if self._blocked:
            return
        self._accepted = self._doubt
        self._arm.setChecked(True)
        self._show_armed()

    def _on_armed(self, armed: bool) -> None:
        self._accepted = ""
        if not (armed and self._disarm_if_doubted()):
            self._show_armed()

    def _disarm_if_doubted(self) -> bool:
        """Disarm and report why, if the tare is doubtful for a reason that the user has not accepted."""
        doubt = self._doubt
        if doubt in ("", self._accepted):
            return False
        self._switch.setChecked(False)
        self._arm.setChecked(False)
        self._show_armed()
        self.tare_doubted.emit(doubt)
        return True

    @property
    def _doubt(self) -> str:
        return "" if self._input is None else tare_doubt(self._input.facts()[0])

    def _show_armed(self) -> None:
        active = self._switch.isChecked()
        self._arm.setEnabled(not active and not self._blocked)
        self._switch.setEnabled(active or self._arm.isChecked())
        self._arm.setToolTip(self._blocked or _ARM_TIP)
        self._switch.setToolTip(self._blocked or _SEND_TIP)

    def refresh(self) -> None:
        if self._input is None or (self.folded and not self._switch.isChecked()):
            return  # the state needs the lock of the readings
        facts = self._input.motion()
        name = facts.settings.controller
        if name in self._names:
            self._controller.setCurrentIndex(self._names.index(name))
        self._controller.say(CONTROLLERS[name].title)
        motion = facts.requested
        self._joints.setText(_fastest(self._input.origin.robot, facts, self._elided))
        self._force.setText(_UNKNOWN if motion is None else f"{motion.force:.1f}\u202fN")
        limits = () if motion is None else motion.limits
        lines = [self._error or facts.problem or "", *map(limit_text, limits)]
        self._notes.setText("\n".join(map(as_sentence, lines)).strip())
        active = facts.sending.active
        if self._switch.isChecked() and not active:
            self._arm.setChecked(False)
            stopped = facts.sending.stopped
            if not self._error and stopped not in (None, StopReason.BY_HAND, StopReason.PAUSED):
                self.stop_reported.emit(_reason(facts), stopped is StopReason.DOUBTFUL_TARE)
        self._switch.setChecked(active)
        self._show_armed()
        self._switch.setText("Stop sending" if active else "Send to the robot")
        for field in (self._address, self._speed, self._most_force):
            field.setEnabled(not active)
        self._sent.setText("\n".join(filter(None, (_sent_text(facts), self._blocked))))

    def _elided(self, name: str, value: str) -> str:
        """Return name and value in one line; a name that is too long is cut in its middle."""
        metrics = self._joints.fontMetrics()
        room = max(self._joints.width(), _LEAST_ROOM) - metrics.horizontalAdvance(f" {value}")
        return f"{metrics.elidedText(name, Qt.TextElideMode.ElideMiddle, room)} {value}"

    def _on_folded_changed(self) -> None:
        if self._input is not None:
            self._input.watch_motion(watched=not self.folded)
            self.refresh()

    def _on_controller_activated(self, index: int) -> None:
        self._act(lambda live: live.use_controller(self._names[index]))

    def _on_switched(self, on: bool) -> None:
        if on and not self._disarm_if_doubted():
            limits = MotionLimits(self._speed.value(), self._most_force.value())
            self._act(lambda live: live.send_motion(self._address.text().strip(), limits, accepted=self._accepted))
            if self._error:
                self.start_refused.emit(self._error)
            elif self._switch.isChecked():
                self.stop_reported.emit("", False)
        elif not on:
            self._arm.setChecked(False)
            self._act(LiveInput.stop_motion)

    def _act(self, act: Callable[[LiveInput], None]) -> None:
        self._error = self._try(act)
        self.refresh()


def _fastest(robot: Robot, facts: MotionFacts, line: Callable[[str, str], str]) -> str:
    """Return the fastest joints with their velocities; ``line`` formats a name and a value."""
    if facts.requested is None:
        return _UNKNOWN
    velocity = facts.requested.velocity
    order = np.argsort(-np.abs(velocity), kind="stable")[:_FASTEST]
    lines = []
    for number in order:
        joint = robot.joints[number]
        if abs(velocity[number]) >= 5e-4:
            unit = "m/s" if joint.slide else "rad/s"
            lines.append(line(joint.name, f"{velocity[number]:+.3f}\u202f{unit}".replace("-", "−")))
    return "\n".join(lines) or "None moves"


def _sent_text(facts: MotionFacts) -> str:
    """Return the progress of sending, or why it ended."""
    sending = facts.sending
    latency = facts.latency
    slowed = f", {sending.slowed} of them slowed" if sending.slowed else ""
    if sending.waiting is not None:
        return f"Waiting for {sending.waiting}. Nothing is sent yet."
    late = "" if latency is None else f"\n{latency_text(latency)}"
    if sending.sending:
        return f"Sending: {sending.sent} velocities{slowed}.{late}"
    if sending.stopped is None:
        return ""
    return f"Stopped: {_reason(facts)}. {sending.sent} velocities were sent{slowed}.{late}"


def _reason(facts: MotionFacts) -> str:
    """Return why sending stopped."""
    sending = facts.sending
    assert sending.stopped is not None
    return sending.stopped.value + (f" ({sending.detail})" if sending.detail else "")
