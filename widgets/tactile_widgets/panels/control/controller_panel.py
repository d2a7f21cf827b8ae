"""The controller panel: which controller does which task, with which gains, what it is doing, and what limits it.

Beside the buttons, lists and sliders it shows three lines: the state of the task in one sentence
(``task_status_text``), the limits that act now or ended just before (``LimitStatusLine``: shape and words, never colour
alone), and the response to the last step of the force goal (``StepResponseMonitor``: overshoot, settling time, ripple).
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
from PySide6.QtWidgets import QButtonGroup, QGridLayout, QHBoxLayout, QLabel, QPushButton, QWidget

from tactile_maps.control.controller_registry import CONTROLLERS, effective_settings, has_task, settings_from
from tactile_maps.control.force_loop.loop_stability import StepResponse, step_response
from tactile_maps.control.limit_texts import limit_text
from tactile_maps.control.motion.command import ControlSettings, RegraspState
from tactile_maps.control.motion.limits import LimitKind
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
from tactile_widgets.common.panel import MIXED_VALUES, FlatComboBox, Panel, value_label
from tactile_widgets.plots.traces.history import LimitHistory, ShownLimit

STEP_DURATION = 10.0
"""A step is watched for so long [s]."""
_SMALLEST_STEP = 0.05
"""Of a step [N]: less is no step."""
_MERGE_STEPS_WITHIN = 0.5
"""A goal that changes again so soon is a slider on its way [s]: one step, which begins when it rests."""


class StepResponseMonitor:
    """Keeps what followed the last step while it lasted. Mutable: ``take`` and ``clear``."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Nothing has been seen."""
        self._goal: float | None = None
        self._time: float | None = None
        self._began = 0.0
        self._step: tuple[float, float] | None = None
        self._samples: list[tuple[float, float]] = []
        self._held = False

    def hold(self) -> None:
        """Something else was changed: what follows is no answer to the step any more; what was seen stays."""
        self._held = True

    def take(self, time: float, force: float, goal: float | None) -> None:
        """The force at ``time`` [s], and what is wanted [N]; None ends the watch, and keeps what it saw."""
        if self._time is not None and time < self._time:
            self.clear()  # time ran backwards
        self._time = time
        before = self._goal
        self._goal = goal
        if goal is None:
            return
        if before is not None and abs(goal - before) > _SMALLEST_STEP:
            going_on = self._step is not None and time - self._began < _MERGE_STEPS_WITHIN
            self._step = (self._step[0] if going_on and self._step else before, goal)
            self._began = time
            self._samples = []
            self._held = False
        if self._step is not None and not self._held and time - self._began <= STEP_DURATION:
            self._samples.append((time - self._began, force))

    @property
    def response(self) -> StepResponse | None:
        """Of the last step; None before there was one. Cost: 50 µs."""
        if self._step is None or abs(self._step[1] - self._step[0]) <= _SMALLEST_STEP:
            return None
        times, forces = np.array(self._samples).T
        return step_response(times, forces, before=self._step[0], goal=self._step[1])


def step_response_text(response: StepResponse) -> str:
    """Like "Goal 3.0 → 6.0 N: 12 % overshoot, settled in 0.42 s, ripple 0.05 N"."""
    parts = [f"{100 * response.overshoot:.0f}\u202f% overshoot"]
    if response.settling is not None and response.ripple is not None:
        parts += [f"settled in {response.settling:.2f}\u202fs", f"ripple {response.ripple:.2f}\u202fN"]
    else:
        parts.append("not settled yet")
    return f"Goal {response.before:.1f} → {response.goal:.1f}\u202fN: {', '.join(parts)}"


_STILL = 0.02
"""A joint slower than this [rad/s] stands still for the eye."""
_KEPT_N = 0.3
_KEPT = 0.1
"""A force within so many newtons of its goal, or such a share of it, is kept."""

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
"""The other states are steps of the regrasp."""


def task_status_text(settings: ControlSettings, frame: Frame) -> str:
    """One sentence.

    Args:
        settings: In force.
        frame: Shown now.
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
    """The goal is kept only where the strongest contact has it; else what is read is said beside."""
    goal = settings.force_goal
    read = max((region.force for region in frame.regions), default=0.0)
    if abs(read - goal) <= max(_KEPT_N, _KEPT * goal):
        count = 1 if frame.task is None else len(frame.task.controlled)
        return f"Keeping {goal:.1f}\u202fN" + (f" at {count} contacts" if count > 1 else "")
    return f"Approaching {goal:.1f}\u202fN, now {read:.1f}\u202fN"


def _status_of_task(settings: ControlSettings, frame: Frame) -> str:
    task = frame.task
    off = "" if task is None or task.error is None else f", error {1e3 * task.error:.1f}\u202fmm"
    count = len(frame.regions)
    if settings.task == "follow_path":
        waits = any(limit.kind is LimitKind.PATH_WAITS for limit in frame.why_limited)
        way = 0.0 if task is None else 1e3 * task.way
        return f"Waiting for the contact{off}" if waits else f"Following path, {way:.0f}\u202fmm along it{off}"
    if settings.task == "balance" and count > 1:
        return f"Balancing {count} contacts"
    return {
        "hold_point": f"Holding the point{off}",
        "guide": f"Hand guiding{off}",
        "retreat": f"Retreating from {count} contact{'s' * (count > 1)}",
    }.get(settings.task) or _force_text(settings, frame)


_SIZE = 14
_LINES = 2
_LAW_LINES = 3
_LIMIT_LINES = 3
"""Room that is kept, so that nothing below moves when limits come and go, or another controller is chosen."""
_NO_STEP = "Step response: none yet"
_GAIN_UNIT = "mm/s per N"
_WHOLE_GAIN_UNIT = "mm/\u2060s\u00a0per\u00a0N"
"""Not broken over two lines."""


class LimitState(Enum):
    """How free the controller is."""

    FREE = "Not limited"
    ENDED = "Recently limited"
    LIMITED = "Limited"
    STOPPED = "Stopped"


class LimitStatusLine(QWidget):
    """Shows limits as ``LimitHistory.told`` has them."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("why-limited")
        self._sign, self._words = _LimitIcon(self), QLabel(self)
        self._words.setWordWrap(True)
        self._words.setTextFormat(Qt.TextFormat.RichText)
        self._words.setAlignment(Qt.AlignmentFlag.AlignTop)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(8)
        row.addWidget(self._sign, 0, Qt.AlignmentFlag.AlignTop)
        row.addWidget(self._words, 1)
        self._words.setFixedHeight(_LIMIT_LINES * (self._words.fontMetrics().lineSpacing() + 1))
        self._said: tuple[str, ...] = ("",)
        self.show_limits(())

    @property
    def state(self) -> LimitState:
        """How free the controller is."""
        return self._sign.state

    @property
    def words(self) -> str:
        """All that is said, as plain text."""
        return self.accessibleName()

    def show_limits(self, limits: tuple[ShownLimit, ...]) -> None:
        """Say these."""
        now = [limit_text(shown.limit) for shown in limits if shown.active]
        ended = [limit_text(shown.limit) for shown in limits if not shown.active]
        self._say(_limit_state(limits), now, ended)

    def say_no_joints(self) -> None:
        """There is nothing to limit."""
        self._say(LimitState.FREE, [], [], head="The robot has no actuated joints")

    def _say(self, state: LimitState, now: list[str], ended: list[str], *, head: str = "") -> None:
        stopped = state is LimitState.STOPPED
        head = head or ("" if stopped else state.value + (": " if now or ended else ""))
        told = [escape(words[:1].upper() + words[1:] if stopped else words) for words in now]
        quiet = self.palette().color(QPalette.ColorRole.PlaceholderText).name()
        faded = [f'<span style="color:{quiet}">{escape(words)}</span>' for words in ended]
        said = (head, *(words.replace(_GAIN_UNIT, _WHOLE_GAIN_UNIT) for words in told + faded))
        if said != self._said:
            self._said = said
            self._fit()
            self.setAccessibleName(f"{head}{'; '.join([*now, *ended])}")
            self.setToolTip(self.words)  # what has no room
        self._sign.set_state(state)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """As many limits as there is room for now."""
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        """Say as many as have room, and how many more there are."""
        head, *parts = self._said
        for count in range(len(parts), -1, -1):
            more = f"{len(parts) - count}\u00a0more"
            self._words.setText(head + "; ".join(parts[:count] + [more] * (count < len(parts))))
            if count <= 1 or self._words.heightForWidth(self._words.width()) <= self._words.height():
                return


class _LimitIcon(QWidget):
    """A ring while free, a triangle while limited (hollow where it only was), a square when stopped."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.state = LimitState.FREE
        self.setFixedSize(_SIZE, _SIZE + 4)

    def set_state(self, state: LimitState) -> None:
        if state is not self.state:
            self.state = state
            self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Qt."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        box = QRectF(1.5, 3.5, _SIZE - 3, _SIZE - 3)
        colour = {
            LimitState.FREE: self.palette().color(QPalette.ColorRole.PlaceholderText),
            LimitState.STOPPED: QColor(DARK.fault),
        }.get(self.state, QColor(DARK.warning))
        painter.setPen(QPen(colour, 1.6))
        painter.setBrush(colour if self.state in (LimitState.LIMITED, LimitState.STOPPED) else Qt.BrushStyle.NoBrush)
        if self.state is LimitState.FREE:
            painter.drawEllipse(box.adjusted(1, 1, -1, -1))
        elif self.state is LimitState.STOPPED:
            painter.drawRect(box)
        else:
            painter.drawPolygon(QPolygonF([box.bottomLeft(), QPointF(box.center().x(), box.top()), box.bottomRight()]))


def _limit_state(limits: tuple[ShownLimit, ...]) -> LimitState:
    if any(shown.active and shown.limit.kind.stops for shown in limits):
        return LimitState.STOPPED
    if any(shown.active for shown in limits):
        return LimitState.LIMITED
    return LimitState.ENDED if limits else LimitState.FREE


def can_restart_task(settings: ControlSettings) -> bool:
    """Whether there is a path to start again, or a place to choose again; one that was drawn stays."""
    drawn_point = settings.task == "hold_point" and bool(settings.path)
    return has_task(settings.controller) and settings.task in RESTART_LABELS and not drawn_point


class ControllerPanel(Panel):
    """Emits settings as a person changes them; shows those that the chosen controller and task use, and the outcome."""

    settings_edited = Signal(ControlSettings)
    """Controller settings entered by the user."""
    comparison_requested = Signal()
    """Controllers are to be compared."""
    scene_requested = Signal(str)
    """The scene is wanted in which the controller shows what is different about it: its name."""

    simulates = True

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Controller", "controller-panel", parent)
        self._settings = ControlSettings()
        self._gains = GainsByController()
        self._limits = LimitHistory()
        self._step = StepResponseMonitor()
        self._buttons: dict[str, QPushButton] = {}
        self._group = QButtonGroup(self)
        self.column.addLayout(self._law_buttons())
        self._add_state()
        self._boxes = {name: self._choice_box(name) for name in SETTING_CHOICES}
        self.column.addLayout(self._act_buttons())
        self.sliders = ControllerSliders(parent=self)
        self.sliders.settings_edited.connect(self._edit)
        self.column.addWidget(self.sliders)
        self.show_settings(self._settings)

    @property
    def settings(self) -> ControlSettings:
        """Those shown."""
        return self._settings

    @property
    def can_start_again(self) -> bool:
        """Whether the task in force can start from its beginning."""
        return can_restart_task(self._settings)

    def set_editable(self, *, editable: bool) -> None:
        """Let a person change it, or not."""
        self.setEnabled(editable)

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Another scene: gains go back to its own from now on."""
        self._gains.begin(settings_from(dict(prepared.scene.control)))
        self.sliders.set_defaults(self._gains.defaults)
        self._limits.clear()
        self._step.clear()

    def show_settings(self, settings: ControlSettings) -> None:
        """Show the settings in force."""
        if replace(settings, force_goal=self._settings.force_goal) != self._settings:
            self._step.hold()
        self._settings = settings
        names = effective_settings(settings)
        self._buttons[settings.controller].setChecked(True)
        self._tell_law(settings.controller)
        self.sliders.show_settings(settings)
        of_any_controller = frozenset[str]().union(*settings_by_controller(settings).values())
        for name, box in self._boxes.items():
            value = getattr(settings, name)
            box.setCurrentIndex(box.findData(value))
            box.say(SETTING_CHOICES[name][1][value])
            # What only other controllers use keeps its place: no row moves when one is chosen.
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
        """Say what it does, what limits it, and what the last step of the goal showed."""
        self._limits.take(frame.time, frame.why_limited)
        if len(frame.posture):
            self._why.show_limits(self._limits.told)
        else:
            self._why.say_no_joints()
        _set_text(self._state, task_status_text(self._settings, frame))
        if frame.task is not None:
            _set_text(
                self._energy, f"{round(frame.task.energy, 2) + 0.0:.2f}\u202fJ, {frame.task.tank:.2f}\u202fJ left"
            )
        goal = frame.task.force_goal if frame.task else None
        force = max((region.force for region in frame.regions), default=0.0)
        self._step.take(frame.time, force, goal)
        self._show_step()

    def choose_controller(self, controller: str, _checked: bool = False) -> None:
        """Put another controller in force, with the gains it had when it last was."""
        if controller != self._settings.controller:
            self._edit(self._gains.switched(self._settings, controller))

    def take(self, settings: ControlSettings) -> None:
        """Put these in force; the gains of the controller before are remembered."""
        self._gains.switched(self._settings, settings.controller)
        self._edit(settings)

    def choose_task(self, task: str, _checked: bool = False) -> None:
        """Give the controller another task."""
        self._change("task", task)

    def start_again(self) -> None:
        """Start the task's path from its beginning, or hold the contact where it is now."""
        self._edit(replace(self._settings, starts=self._settings.starts + 1))

    def reset_gains(self) -> None:
        """All gains where they began; what the controller is to do stays."""
        self._edit(self._gains.reset(self._settings))

    # Inside.

    def _add_state(self) -> None:
        self._law = self.caption()
        self._law.setObjectName("controller-difference")
        self._law.setFixedHeight(_LAW_LINES * self._law.fontMetrics().lineSpacing() + 2)
        self._law.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._law.linkActivated.connect(self.scene_requested)
        self._state = QLabel(self)
        self._state.setObjectName("task-state")
        self._state.setWordWrap(True)
        self._state.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._state.setFixedHeight(_LINES * self._state.fontMetrics().lineSpacing() + 2)
        self.column.addWidget(self._state)
        self._why = LimitStatusLine(self)
        self.column.addWidget(self._why)
        grid = self.grid()
        self._energy_name, self._energy = value_label("Net energy output", self), value_label("", self, right=True)
        self._energy_name.setToolTip(
            "Net energy output to contacts, and what the energy tank (passivity) has left before the arm slows down"
        )
        self._energy.setObjectName("energy")
        grid.addWidget(self._energy_name, 0, 0)
        grid.addWidget(self._energy, 0, 1)
        self._response = self.caption()
        self._response.setObjectName("step-response")
        self._response.setToolTip("Step response of the force, once its goal is changed in contact; settling band 5 %")
        self._response.setFixedHeight(_LINES * self._response.fontMetrics().lineSpacing() + 2)
        self._response.setAlignment(Qt.AlignmentFlag.AlignTop)

    def _show_step(self) -> None:
        response = self._step.response
        _set_text(self._response, _NO_STEP if response is None else step_response_text(response))

    def _tell_law(self, controller: str) -> None:
        """What is different about it, and where that shows."""
        difference = CONTROLLERS[controller].tip
        scene = CONTROLLER_SCENES.get(controller)
        where = "" if scene is None else f' <a href="{scene}">Show in its scene</a>'
        colour = self.palette().color(QPalette.ColorRole.Link).name()
        _set_text(self._law, f"{escape(difference)}.{where}".replace("<a ", f'<a style="color:{colour}" '))

    def _law_buttons(self) -> QGridLayout:
        grid = QGridLayout()
        grid.setSpacing(4)
        for side in (0, 1):
            grid.setColumnStretch(side, 1)
        for number, (controller, entry) in enumerate(CONTROLLERS.items()):
            button = QPushButton(entry.title, self)
            button.setObjectName(f"controller-{controller}")
            button.setCheckable(True)
            button.setToolTip(entry.tip)
            button.clicked.connect(partial(self.choose_controller, controller))
            self._group.addButton(button)
            self._buttons[controller] = button
            grid.addWidget(button, *divmod(number, 2))
        return grid

    def _act_buttons(self) -> QGridLayout:
        grid = QGridLayout()
        grid.setSpacing(4)
        self._again = self._button("task-again", "", "Restart task", self.start_again)
        self._reset = self._button("reset-gains", "Reset gains", _GAINS_TIP, self.reset_gains)
        self._compare = self._button("compare-controllers", "Compare…", _COMPARE_TIP, self.comparison_requested)
        grid.addWidget(self._again, 0, 0, 1, 2)
        grid.addWidget(self._reset, 1, 0)
        grid.addWidget(self._compare, 1, 1)
        return grid

    def _button(self, name: str, text: str, tip: str, act: Any) -> QPushButton:
        button = QPushButton(text, self)
        button.setObjectName(name)
        button.setToolTip(tip)
        button.clicked.connect(act)
        return button

    def _choice_box(self, name: str) -> FlatComboBox:
        tip, words = SETTING_CHOICES[name]
        box = FlatComboBox(self)
        box.setObjectName(f"choice-{name}")
        box.setAccessibleName(tip)
        box.setToolTip(tip)
        for value, text in words.items():
            box.addItem(text, value)
        box.activated.connect(partial(self._on_choice_made, name))
        self.column.addWidget(box)
        return box

    def _on_choice_made(self, name: str, row: int) -> None:
        self._change(name, self._boxes[name].itemData(row))

    def _change(self, name: str, value: object) -> None:
        changed: dict[str, Any] = {name: value}
        self._edit(replace(self._settings, **changed))

    def _edit(self, settings: ControlSettings) -> None:
        self.show_settings(settings)
        self.settings_edited.emit(settings)


_GAINS_TIP = "Reset all gains of this controller to the scene's values; the task stays"
_COMPARE_TIP = "Run several controllers on the same stimulus and compare their metrics"


def _set_text(label: QLabel, words: str) -> None:
    if words != label.text():
        label.setText(words)
