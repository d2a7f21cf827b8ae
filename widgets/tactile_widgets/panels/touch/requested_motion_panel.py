"""The motion that a controller wants of the robot whose skin is shown; sent to it while a switch is on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QHBoxLayout, QLineEdit, QPushButton, QSizePolicy, QWidget

from tactile_maps.control.controller_registry import CONTROLLERS
from tactile_maps.control.limit_texts import limit_text
from tactile_maps.core.errors import TactileMapsError
from tactile_maps.live.motion.command_latency import latency_text
from tactile_maps.live.motion.motion_sender import FORCES, SPEEDS, MotionLimits
from tactile_maps.robots.model.robot import Robot
from tactile_widgets.common.number_field import NumberField
from tactile_widgets.common.panel import FlatComboBox, Panel, value_label
from tactile_widgets.common.sentence import as_sentence
from tactile_widgets.session.live_input import LiveInput
from tactile_widgets.session.live_motion import MotionFacts

_REFRESH_MS = 100
_FASTEST = 3
"""Joints that are named; the others are slower."""
_LEAST_ROOM = 200
"""Width for a joint's name and velocity before the panel has been laid out [px]."""
_UNKNOWN = "–"
ADDRESS = "udp://127.0.0.1:9900"


class RequestedMotionPanel(Panel):
    """Hidden while nothing is connected; a controller runs only while it is unfolded, or its motion is sent."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Requested motion", "wanted-motion-panel", parent)
        self._input: LiveInput | None = None
        self._error = ""
        grid = self.grid()
        grid.setColumnStretch(0, 1)
        self._controller = FlatComboBox(self)
        self._controller.setObjectName("motion-controller")
        self._controller.setAccessibleName("Controller")
        self._names = [name for name in CONTROLLERS if name != "impedance"]
        self._controller.addItems([CONTROLLERS[name].title for name in self._names])
        self._controller.activated.connect(self._on_controller_activated)
        self._joints = value_label(_UNKNOWN, self, right=True)
        self._joints.setObjectName("motion-joints")
        self._joints.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignTop)
        self._joints.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)  # names must not widen it
        self._joints.setMinimumHeight(_FASTEST * self._joints.fontMetrics().lineSpacing())
        self._force = value_label(_UNKNOWN, self, right=True)
        self._force.setObjectName("motion-force")
        rows: tuple[tuple[str, str, QWidget | None], ...] = (
            ("Controller", "Whose motion is shown; goal and gains are those from before connecting", self._controller),
            ("Contact force", "Measured normal force of the strongest contact", self._force),
            ("Fastest joints", "Wanted velocities, the largest first", None),
        )
        for row, (text, tip, widget) in enumerate(rows):
            name = value_label(text, self)
            name.setToolTip(tip)
            grid.addWidget(name, row, 0)
            if widget is not None:
                grid.addWidget(widget, row, 1)
        grid.addWidget(self._joints, len(rows), 0, 1, 2)
        self._address = QLineEdit(ADDRESS, self)
        self._address.setObjectName("motion-address")
        self._address.setAccessibleName("Address of the robot's driver")
        self._address.setToolTip("udp://HOST:PORT or zmq://HOST:PORT on this computer; the guide says what is sent")
        driver = QHBoxLayout()
        driver.addWidget(value_label("Driver", self))
        driver.addWidget(self._address, 1)
        self.column.addLayout(driver)
        slowed = "Faster motion is slowed as a whole; the speed limits of the robot's model apply as well"
        ended = "A stronger contact ends sending"
        self._speed = NumberField("Fastest joint sent", "rad/s", *SPEEDS, 0.005, slowed, self)
        self._most_force = NumberField("Largest force", "N", *FORCES, 1.0, ended, self)
        self._speed.show_number(MotionLimits().speed)
        self._most_force.show_number(MotionLimits().force)
        self.column.addLayout(self._limits())
        self._switch = QPushButton("Send to the robot", self)
        self._switch.setObjectName("motion-send")
        self._switch.setCheckable(True)
        self._switch.setToolTip("Send the wanted velocities: the robot may move. Press again to stop it.")
        self._switch.clicked.connect(self._on_switched)
        self.column.addWidget(self._switch)
        # What comes and goes is below the switch, which must not move under the pointer.
        self._sent, self._told = self.caption(), self.caption()
        self._sent.setObjectName("motion-sent")
        self._told.setObjectName("motion-told")
        self._timer = QTimer(self)
        self._timer.setInterval(_REFRESH_MS)
        self._timer.timeout.connect(self.refresh)
        self.folded_changed.connect(self._watch)
        self.hide()

    def _limits(self) -> QHBoxLayout:
        row = QHBoxLayout()
        row.addWidget(value_label("At most", self))
        row.addStretch(1)
        row.addWidget(self._speed)
        row.addWidget(self._most_force)
        return row

    def show_input(self, live: LiveInput | None) -> None:
        """Show another live input; None for none."""
        self._input = live
        self._error = ""
        self.setVisible(live is not None)
        self._watch()
        if live is None:
            self._timer.stop()
            self._switch.setChecked(False)
        else:
            self._timer.start()
            self.refresh()

    def set_folded(self, folded: bool) -> None:
        """Fold or unfold it without telling a person's hand."""
        super().set_folded(folded)
        self._watch()

    def refresh(self) -> None:
        """Show how things are now."""
        if self._input is None:
            return
        facts = self._input.motion()
        name = facts.settings.controller
        if name in self._names:
            self._controller.setCurrentIndex(self._names.index(name))
        self._controller.say(CONTROLLERS[name].title)
        wanted = facts.wanted
        self._joints.setText(_fastest(self._input.origin.robot, facts, self._elided))
        self._force.setText(_UNKNOWN if wanted is None else f"{wanted.force:.1f}\u202fN")
        limits = () if wanted is None else wanted.limits
        lines = [self._error or facts.problem or "", *map(limit_text, limits)]
        self._told.setText("\n".join(map(as_sentence, lines)).strip())
        self._told.setHidden(not self._told.text())
        self._switch.setChecked(facts.sending.active)
        self._switch.setText("Stop sending" if facts.sending.active else "Send to the robot")
        for field in (self._address, self._speed, self._most_force):
            field.setEnabled(not facts.sending.active)
        self._sent.setText(_sent_text(facts))
        self._sent.setHidden(not self._sent.text())

    def _elided(self, name: str, value: str) -> str:
        """The name and value in one line; a name that is too long is cut in its middle."""
        metrics = self._joints.fontMetrics()
        room = max(self._joints.width(), _LEAST_ROOM) - metrics.horizontalAdvance(f" {value}")
        return f"{metrics.elidedText(name, Qt.TextElideMode.ElideMiddle, room)} {value}"

    def _watch(self) -> None:
        if self._input is not None:
            self._input.watch_motion(watched=not self.folded)

    def _on_controller_activated(self, index: int) -> None:
        self._try(lambda live: live.use_controller(self._names[index]))

    def _on_switched(self, wanted: bool) -> None:
        if not wanted:
            self._try(lambda live: live.stop_motion())
            return
        self._try(
            lambda live: live.send_motion(
                self._address.text().strip(), MotionLimits(self._speed.value(), self._most_force.value())
            )
        )

    def _try(self, act: Callable[[LiveInput], None]) -> None:
        """What a hand asks for; why it is refused is said above."""
        self._error = ""
        if self._input is not None:
            try:
                act(self._input)
            except TactileMapsError as error:
                self._error = str(error)
        self.refresh()


def _fastest(robot: Robot, facts: MotionFacts, line: Callable[[str, str], str]) -> str:
    """The fastest joints with their velocities; ``line`` makes a line of a name and a value."""
    if facts.wanted is None:
        return _UNKNOWN
    velocity = facts.wanted.velocity
    order = np.argsort(-np.abs(velocity), kind="stable")[:_FASTEST]
    moving = [number for number in order if abs(velocity[number]) >= 5e-4]
    units = {number: "m/s" if robot.joints[number].slide else "rad/s" for number in moving}
    values = [f"{velocity[number]:+.3f}\u202f{units[number]}".replace("-", "−") for number in moving]
    lines = [line(robot.joints[number].name, value) for number, value in zip(moving, values, strict=True)]
    return "\n".join(lines) or "None moves"


def _sent_text(facts: MotionFacts) -> str:
    """How sending goes, or why it ended."""
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
    detail = f" ({sending.detail})" if sending.detail else ""
    return f"Stopped: {sending.stopped.value}{detail}. {sending.sent} velocities were sent{slowed}.{late}"
