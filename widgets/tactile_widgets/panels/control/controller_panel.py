"""The controller panel: controller, task and gains, the state of the task, what limits it, and its step response.

Below the buttons, three lines show the state of the task in one sentence (``task_status_text``), the limits that act
now or ended just before (``LimitStatusLine``: shape and words, never colour alone), and the response to the last step
of the force goal (``StepResponseMonitor``: overshoot, settling time, ripple).
"""

from __future__ import annotations

from dataclasses import replace
from enum import Enum
from functools import partial
from html import escape
from typing import Any

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPalette, QPen, QPolygonF, QResizeEvent
from PySide6.QtWidgets import QButtonGroup, QGridLayout, QLabel, QPushButton, QWidget

from tactile_maps.control.controller_registry import CONTROLLERS, effective_settings, has_task, settings_from
from tactile_maps.control.force_loop.loop_stability import StepResponse, step_response
from tactile_maps.control.limit_texts import limit_text
from tactile_maps.control.motion.command import ControlSettings, RegraspState
from tactile_maps.control.motion.limits import LimitKind, Severity
from tactile_maps.core.errors import counted
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import DARK
from tactile_widgets.common.controller_settings import (
    CONTROLLER_SCENES,
    RESTART_LABELS,
    SETTING_CHOICES,
    ControllerSliders,
    GainsByController,
    settings_by_controller,
)
from tactile_widgets.common.make import (
    RichLabel,
    add_fact,
    add_items,
    button_grid,
    column_layout,
    make,
    push_button,
    row_layout,
    select_data,
    value_label,
)
from tactile_widgets.common.panel import MIXED_VALUES, FlatComboBox, Panel
from tactile_widgets.common.sentence import capitalized
from tactile_widgets.plots.traces.history import LimitHistory, ShownLimit

STEP_DURATION = 10.0
"""Observation time of a step [s]."""
_SMALLEST_STEP = 0.05
"""Smallest change of the goal that counts as a step [N]."""
_MERGE_STEPS_WITHIN = 0.5
"""Time within which another change belongs to the same step [s], as while a slider moves; the step starts at the last
change.
"""


class StepResponseMonitor:
    """Samples after the last step of the force goal. Mutable: ``take`` and ``clear``."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget all samples."""
        self._goal: float | None = None
        self._time: float | None = None
        self._began = 0.0
        self._step: tuple[float, float] | None = None
        self._samples: list[tuple[float, float]] = []
        self._held = False

    def hold(self) -> None:
        """Keep the samples and take no more: after a change of another setting the response is not one to the step."""
        self._held = True

    def take(self, time: float, force: float, goal: float | None) -> None:
        """Add a sample.

        Args:
            time: Time [s]; a time before the previous one clears the samples.
            force: Force [N].
            goal: Goal of the force [N]; None ends the observation and keeps the samples.
        """
        if self._time is not None and time < self._time:
            self.clear()
        self._time = time
        before = self._goal
        self._goal = goal
        if goal is None:
            return
        if before is not None and abs(goal - before) > _SMALLEST_STEP:
            continues = self._step is not None and time - self._began < _MERGE_STEPS_WITHIN
            self._step = (self._step[0] if continues and self._step else before, goal)
            self._began = time
            self._samples = []
            self._held = False
        if self._step is not None and not self._held and time - self._began <= STEP_DURATION:
            self._samples.append((time - self._began, force))

    @property
    def response(self) -> StepResponse | None:
        """Response to the last step; None before the first step. Cost: 50 µs."""
        if self._step is None or abs(self._step[1] - self._step[0]) <= _SMALLEST_STEP:
            return None
        times, forces = np.array(self._samples).T
        return step_response(times, forces, before=self._step[0], goal=self._step[1])


def step_response_text(response: StepResponse) -> str:
    """Return a text like "Goal 3.0 → 6.0 N: 12 % overshoot, settled in 0.42 s, ripple 0.05 N"."""
    parts = [f"{100 * response.overshoot:.0f}\u202f% overshoot"]
    if response.settling is not None and response.ripple is not None:
        parts += [f"settled in {response.settling:.2f}\u202fs", f"ripple {response.ripple:.2f}\u202fN"]
    else:
        parts.append("not settled yet")
    return f"Goal {response.before:.1f} → {response.goal:.1f}\u202fN: {', '.join(parts)}"


_STILL = 0.02
"""Joint speed below which the robot is described as holding its posture [rad/s]."""
_KEPT_N = 0.3
_KEPT = 0.1
"""Tolerance of the force goal: in newtons, and as a fraction of the goal; the larger one applies."""

_WAITING_TEXTS = {
    "keep_force": "Waiting for a contact",
    "hold_point": "Waiting for a contact to hold",
    "follow_path": "Waiting for a contact to move along the path",
    "balance": "Waiting for contacts",
    "retreat": "Ready to retreat",
    "guide": "Waiting for contact",
}

_REGRASP_TEXTS = {
    RegraspState.PLAN: "Planning a regrasp",
    RegraspState.RETURN: "Moving the contact back",
    RegraspState.FAILED: "Waiting: the path cannot be continued",
}
"""Texts of the states that are not steps of the regrasp."""


def task_status_text(settings: ControlSettings, frame: Frame) -> str:
    """Return the state of the task in one sentence.

    Args:
        settings: Current settings.
        frame: Current frame.
    """
    if not has_task(settings.controller) or frame.task is None:
        return _status_without_task(settings, frame)
    limits = {limit.kind for limit in frame.why_limited}
    if any(kind.stops for kind in limits):
        return "Stopped"
    if frame.task.regrasp is not None:
        return _REGRASP_TEXTS.get(frame.task.regrasp, "Regrasping")
    if LimitKind.CONTACT_LOST in limits:
        return "Reacquiring contact"
    if not frame.regions:
        return _WAITING_TEXTS[settings.task]
    return _status_of_task(settings, frame)


def _status_without_task(settings: ControlSettings, frame: Frame) -> str:
    if settings.controller == "hold_force":
        return _force_text(settings, frame) if frame.regions else "Waiting for a contact"
    if float(np.abs(frame.velocity).max(initial=0.0)) < _STILL:
        return "Holding its posture"
    return "Yielding to the touch" if frame.regions else "Moving to its posture"


def _force_text(settings: ControlSettings, frame: Frame) -> str:
    """Return "Keeping" if the strongest contact has the goal, or the goal and the measured force."""
    goal = settings.force_goal
    read = frame.strongest_force
    if abs(read - goal) <= max(_KEPT_N, _KEPT * goal):
        count = 1 if frame.task is None else len(frame.task.controlled)
        return f"Keeping {goal:.1f}\u202fN" + (f" at {count} contacts" if count > 1 else "")
    return f"Approaching {goal:.1f}\u202fN, now {read:.1f}\u202fN"


def _status_of_task(settings: ControlSettings, frame: Frame) -> str:
    task = frame.task
    off = "" if task is None or task.error is None else f", error {1e3 * task.error:.1f}\u202fmm"
    count = len(frame.regions)
    if settings.task == "follow_path":
        if any(limit.kind is LimitKind.PATH_WAITS for limit in frame.why_limited):
            return f"Waiting for the contact{off}"
        way = 0.0 if task is None else 1e3 * task.way
        return f"Following path, {way:.0f}\u202fmm along it{off}"
    if settings.task == "balance" and count > 1:
        return f"Balancing {count} contacts"
    return {
        "hold_point": f"Holding the point{off}",
        "guide": f"Hand guiding{off}",
        "retreat": f"Retreating from {counted(count, 'contact')}",
    }.get(settings.task) or _force_text(settings, frame)


_SIZE = 14
_LINES = 2
_DIFFERENCE_LINES = 3
_LIMIT_LINES = 4
"""Reserved lines of text, so that nothing below moves when limits change or another controller is chosen."""
_NO_STEP = "Step response: none yet"
_GAIN_UNIT = "mm/s per N"
_UNBROKEN_GAIN_UNIT = "mm/\u2060s\u00a0per\u00a0N"


class LimitState(Enum):
    """State of the controller's limits."""

    FREE = "Not limited"
    ENDED = "Recently limited"
    ADAPTED = "Adapted"
    LIMITED = "Limited"
    STOPPED = "Stopped"


class LimitStatusLine(QWidget):
    """Symbol and text of the limits of a ``LimitHistory``."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("why-limited")
        self._sign = _LimitIcon(self)
        self._words = make(
            RichLabel, self, wordWrap=True, textFormat=Qt.TextFormat.RichText, alignment=Qt.AlignmentFlag.AlignTop
        )
        line = row_layout(self._sign, self._words, parent=self, stretch=self._words)
        line.setAlignment(self._sign, Qt.AlignmentFlag.AlignTop)
        self._words.setFixedHeight(_LIMIT_LINES * (self._words.fontMetrics().lineSpacing() + 1))
        self._said: tuple[str, ...] = ("",)
        self.show_limits(())

    @property
    def state(self) -> LimitState:
        """State of the limits."""
        return self._sign.state

    @property
    def words(self) -> str:
        """The complete text, without markup."""
        return self.accessibleName()

    def show_limits(self, limits: tuple[ShownLimit, ...]) -> None:
        """Show limits that act now, and quietly those that ended."""
        now = [limit_text(shown.limit) for shown in limits if shown.active]
        ended = [limit_text(shown.limit) for shown in limits if not shown.active]
        self._say(_limit_state(limits), now, ended)

    def say_no_joints(self) -> None:
        """Show that the robot has no joints to limit."""
        self._say(LimitState.FREE, [], [], head="The robot has no actuated joints")

    def _say(self, state: LimitState, now: list[str], ended: list[str], *, head: str = "") -> None:
        stopped = state is LimitState.STOPPED
        head = head or ("" if stopped else state.value + (": " if now or ended else ""))
        active = [escape(capitalized(words) if stopped else words) for words in now]
        faded = [f'<span style="color:palette(placeholder-text)">{escape(words)}</span>' for words in ended]
        said = (head, *(words.replace(_GAIN_UNIT, _UNBROKEN_GAIN_UNIT) for words in active + faded))
        if said != self._said:
            self._said = said
            self._fit()
            self.setAccessibleName(f"{head}{'; '.join([*now, *ended])}")
            self.setToolTip(self.words)  # includes the limits that do not fit
        self._sign.set_state(state)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        """Show as many limits as fit, and the number of the others: in front if there is no room behind the first."""
        head, *parts = self._said
        for count in range(len(parts), -1, -1):
            more = f"{len(parts) - count}\u00a0more"
            self._words.setText(head + "; ".join(parts[:count] + [more] * (count < len(parts))))
            if count == 0 or self._words.heightForWidth(self._words.width()) <= self._words.height():
                return
            if count == 1:
                number = f"{len(parts)} limits, " if len(parts) > 1 else ""
                self._words.setText(f"{head}{number}{parts[0]}")
                return


class _LimitIcon(QWidget):
    """A ring for no limit, a triangle for a limit (hollow after it ended), a square for a stop."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.state = LimitState.FREE
        self.setFixedSize(_SIZE, _SIZE + 4)

    def set_state(self, state: LimitState) -> None:
        if state is not self.state:
            self.state = state
            self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        box = QRectF(1.5, 3.5, _SIZE - 3, _SIZE - 3)
        colour = {
            LimitState.LIMITED: QColor(DARK.warning),
            LimitState.STOPPED: QColor(DARK.fault),
        }.get(self.state, self.palette().color(QPalette.ColorRole.PlaceholderText))
        painter.setPen(QPen(colour, 1.6))
        painter.setBrush(Qt.BrushStyle.NoBrush if self.state in (LimitState.FREE, LimitState.ENDED) else colour)
        if self.state in (LimitState.FREE, LimitState.ADAPTED):
            painter.drawEllipse(box.adjusted(1, 1, -1, -1))
        elif self.state is LimitState.STOPPED:
            painter.drawRect(box)
        else:
            painter.drawPolygon(QPolygonF([box.bottomLeft(), QPointF(box.center().x(), box.top()), box.bottomRight()]))


def _limit_state(limits: tuple[ShownLimit, ...]) -> LimitState:
    active = [shown for shown in limits if shown.active]
    if any(shown.limit.kind.stops for shown in active):
        return LimitState.STOPPED
    if any(shown.limit.kind.severity is Severity.UNMET for shown in active):
        return LimitState.LIMITED
    return LimitState.ADAPTED if active else LimitState.ENDED if limits else LimitState.FREE


def can_restart_task(settings: ControlSettings) -> bool:
    """Return whether a path can be restarted, or the held place chosen again; a drawn point stays."""
    drawn_point = settings.task == "hold_point" and bool(settings.path)
    return has_task(settings.controller) and settings.task in RESTART_LABELS and not drawn_point


_GAINS_TIP = "Reset all gains of this controller to the scene's values; the task stays"
_COMPARE_TIP = "Run several controllers on the same stimulus and compare their metrics"
_ENERGY_TIP = "Net energy output to contacts, and what the energy tank (passivity) has left before the arm slows down"
_STEP_TIP = "Step response of the force, once its goal is changed in contact; settling band 5 %"


class ControllerPanel(Panel):
    """Settings of the chosen controller and task, and the state of the task."""

    settings_edited = Signal(ControlSettings)
    """Controller settings entered by the user."""
    comparison_requested = Signal()
    """The user opens the comparison of controllers."""
    scene_requested = Signal(str)
    """Name of the scene that shows the difference of this controller, requested by the user."""

    simulates = True

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Controller", "controller-panel", parent)
        self.settings = ControlSettings()
        self._gains = GainsByController()
        self._limits = LimitHistory()
        self._step = StepResponseMonitor()
        self._group = QButtonGroup(self)
        self._buttons = {controller: self._controller_button(controller) for controller in CONTROLLERS}
        chooser = QWidget(self)
        grid = button_grid(self._buttons.values(), chooser)
        for side in (0, 1):
            grid.setColumnStretch(side, 1)
        self._difference = self._fixed_caption("controller-difference", _DIFFERENCE_LINES)
        self._difference.linkActivated.connect(self.scene_requested)
        self._boxes = {name: self._choice_box(name) for name in SETTING_CHOICES}
        self.sliders = ControllerSliders(parent=self)
        self.sliders.settings_edited.connect(self._edit)
        settings = QWidget(self)
        column_layout(*self._boxes.values(), self._command_buttons(), self.sliders, parent=settings)
        state = self._state_part()
        self._parts = chooser, state, settings  # without the link, which opens a scene at any time
        for part in (chooser, self._difference, state, settings):
            self.column.addWidget(part)
        self.show_settings(self.settings)

    @property
    def can_start_again(self) -> bool:
        """Whether the current task can start from its beginning."""
        return can_restart_task(self.settings)

    def set_editable(self, *, editable: bool) -> None:
        for part in self._parts:
            part.setEnabled(editable)

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Use the gains of another scene as defaults."""
        self._gains.begin(settings_from(dict(prepared.scene.control)))
        self.sliders.set_defaults(self._gains.defaults)
        self.sliders.set_measured(shear=bool(prepared.skin.three_axis.any()))
        self._limits.clear()
        self._step.clear()

    def show_settings(self, settings: ControlSettings) -> None:
        """Show the current settings."""
        if replace(settings, force_goal=self.settings.force_goal) != self.settings:
            self._step.hold()
        self.settings = settings
        names = effective_settings(settings)
        self._buttons[settings.controller].setChecked(True)
        self._show_difference(settings.controller)
        self.sliders.show_settings(settings)
        of_any_controller = frozenset[str]().union(*settings_by_controller(settings).values())
        for name, box in self._boxes.items():
            value = getattr(settings, name)
            select_data(box, value)
            box.say(SETTING_CHOICES[name][1][value])
            # A setting of other controllers keeps its place: no row moves when a controller is chosen.
            box.setVisible(name in of_any_controller)
            box.setEnabled(name in names)
        does_task = has_task(settings.controller)
        for label in (self._energy_name, self._energy):
            label.setEnabled(does_task)
        self._energy.setText(self._energy.text() if does_task else MIXED_VALUES)
        self._again.setEnabled(self.can_start_again)
        self._again.setText(RESTART_LABELS.get(settings.task, "Restart task"))
        self._reset.setEnabled(self._gains.reset(settings) != settings)

    def show_frame(self, frame: Frame) -> None:
        """Show the state of the task, what limits it, and the response to the last step of the goal."""
        self._limits.take(frame.time, frame.why_limited)
        if len(frame.posture):
            self._why.show_limits(self._limits.recent)
        else:
            self._why.say_no_joints()
        _set_text(self._state, task_status_text(self.settings, frame))
        if frame.task is not None:
            output = f"{round(frame.task.energy, 2) + 0.0:.2f}\u202fJ".replace("-", "−")  # + 0.0: no negative zero
            _set_text(self._energy, f"{output}, {frame.task.tank:.2f}\u202fJ left")
        goal = frame.task.force_goal if frame.task else None
        force = frame.strongest_force
        self._step.take(frame.time, force, goal)
        response = self._step.response
        _set_text(self._response, _NO_STEP if response is None else step_response_text(response))

    def choose_controller(self, controller: str, _checked: bool = False) -> None:
        """Use another controller, with the gains it had when it was last used."""
        if controller != self.settings.controller:
            self._edit(self._gains.switched(self.settings, controller))

    def take(self, settings: ControlSettings) -> None:
        """Use other settings; the gains of the previous controller are remembered."""
        self._gains.switched(self.settings, settings.controller)
        self._edit(settings)

    def choose_task(self, task: str, _checked: bool = False) -> None:
        """Set another task."""
        self._change("task", task)

    def start_again(self) -> None:
        """Start the path from its beginning, or hold the contact at its current place."""
        self._change("starts", self.settings.starts + 1)

    def reset_gains(self) -> None:
        """Reset all gains to the defaults of the scene; the task stays."""
        self._edit(self._gains.reset(self.settings))

    # Construction.

    def _state_part(self) -> QWidget:
        self._state = make(QLabel, self, objectName="task-state", wordWrap=True, alignment=Qt.AlignmentFlag.AlignTop)
        self._state.setFixedHeight(_LINES * self._state.fontMetrics().lineSpacing() + 2)
        self._why = LimitStatusLine(self)
        self._energy = value_label("", self, right=True, objectName="energy")
        grid = make(QGridLayout, horizontalSpacing=12)
        self._energy_name = add_fact(grid, 0, "Net energy output", _ENERGY_TIP, self._energy)
        self._response = self._fixed_caption("step-response", _LINES)
        self._response.setToolTip(_STEP_TIP)
        part = QWidget(self)
        column_layout(self._state, self._why, grid, self._response, parent=part)
        return part

    def _fixed_caption(self, name: str, lines: int) -> QLabel:
        label = make(RichLabel, self, objectName=name, role="caption", wordWrap=True, minimumWidth=1)
        label.setFixedHeight(lines * label.fontMetrics().lineSpacing() + 2)
        label.setAlignment(Qt.AlignmentFlag.AlignTop)
        return label

    def _show_difference(self, controller: str) -> None:
        """Show the difference of a controller, with a link to the scene that shows it."""
        scene = CONTROLLER_SCENES.get(controller)
        link = "" if scene is None else f' <a href="{scene}">Show in its scene</a>'
        _set_text(self._difference, f"{escape(CONTROLLERS[controller].tip)}.{link}")

    def _controller_button(self, controller: str) -> QPushButton:
        entry = CONTROLLERS[controller]
        choose = partial(self.choose_controller, controller)
        button = push_button(self, f"controller-{controller}", entry.title, entry.tip, choose, checkable=True)
        self._group.addButton(button)
        return button

    def _command_buttons(self) -> QGridLayout:
        self._again = push_button(self, "task-again", "", "Restart task", self.start_again)
        self._reset = push_button(self, "reset-gains", "Reset gains", _GAINS_TIP, self.reset_gains)
        compare = push_button(self, "compare-controllers", "Compare…", _COMPARE_TIP, self.comparison_requested)
        grid = make(QGridLayout, spacing=4)
        grid.addWidget(self._again, 0, 0, 1, 2)
        grid.addWidget(self._reset, 1, 0)
        grid.addWidget(compare, 1, 1)
        return grid

    def _choice_box(self, name: str) -> FlatComboBox:
        tip, words = SETTING_CHOICES[name]
        box = make(FlatComboBox, self, objectName=f"choice-{name}", accessibleName=tip, toolTip=tip)
        add_items(box, ((text, value, "") for value, text in words.items()))
        box.activated.connect(partial(self._on_choice_made, name))
        return box

    def _on_choice_made(self, name: str, index: int) -> None:
        self._change(name, self._boxes[name].itemData(index))

    def _change(self, name: str, value: object) -> None:
        changed: dict[str, Any] = {name: value}
        self._edit(replace(self.settings, **changed))

    def _edit(self, settings: ControlSettings) -> None:
        self.show_settings(settings)
        self.settings_edited.emit(settings)


def _set_text(label: QLabel, words: str) -> None:
    if words != label.text():
        label.setText(words)
