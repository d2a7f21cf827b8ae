"""The controller: which law does which task, with which gains, what it is doing, and what limits it now."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QButtonGroup, QGridLayout, QLabel, QPushButton, QWidget

from app.control.command import ControlSettings
from app.control.contact_motion import settings_from
from app.control.laws import RULES, heeded
from app.session.frame import Frame
from app.session.prepare import Prepared
from widgets.panels.choice_box import ChoiceBox
from widgets.panels.controller_choices import AGAIN, CHOICES, LAWS
from widgets.panels.gain_memory import GainMemory
from widgets.panels.goal_step import GoalStep, step_words
from widgets.panels.limit_memory import LimitMemory
from widgets.panels.panel import Panel, fact
from widgets.panels.setting_sliders import SettingSliders
from widgets.panels.task_words import task_words
from widgets.panels.why_line import WhyLine


class ControllerPanel(Panel):
    """Emits settings as a person changes them; shows what the chosen law and task heed, and what becomes of it."""

    settings_edited = Signal(object)
    """ControlSettings wanted."""
    compare_asked = Signal()
    """Laws are to be compared."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Controller", "controller-panel", parent)
        self._settings, self._gains = ControlSettings(), GainMemory()
        self._limits, self._step = LimitMemory(), GoalStep()
        self._buttons: dict[str, QPushButton] = {}
        self._group = QButtonGroup(self)
        self.column.addLayout(self._law_buttons())
        self._boxes = {name: self._choice_box(name) for name in CHOICES}
        self.sliders = SettingSliders(parent=self)
        self.sliders.settings_edited.connect(self._edit)
        self.column.addWidget(self.sliders)
        self.column.addLayout(self._act_buttons())
        self._add_state()
        self.show_settings(self._settings)

    @property
    def settings(self) -> ControlSettings:
        """Those shown."""
        return self._settings

    @property
    def can_start_again(self) -> bool:
        """Whether there is a path to start again, or a place to choose again; one that was drawn stays."""
        settings = self._settings
        drawn_point = settings.task == "hold_point" and bool(settings.path)
        return settings.law in RULES and settings.task in AGAIN and not drawn_point

    def show_prepared(self, prepared: Prepared) -> None:
        """Another scene: gains go back to its own from now on."""
        self._gains.begin(settings_from(dict(prepared.scene.control)))
        self.sliders.set_defaults(self._gains.defaults)
        self._limits.clear()
        self._step.clear()

    def show_settings(self, settings: ControlSettings) -> None:
        """Show the settings in force."""
        if replace(settings, force_goal=self._settings.force_goal) != self._settings:
            self._step.hold()
        self._settings, names = settings, heeded(settings)
        self._buttons[settings.law].setChecked(True)
        self.sliders.show_settings(settings)
        for name, box in self._boxes.items():
            value = getattr(settings, name)
            box.setCurrentIndex(box.findData(value))
            box.say(CHOICES[name][1][value])
            box.setVisible(name in names)
        has_task = settings.law in RULES
        for label in (self._energy_name, self._energy):
            label.setVisible(has_task)
        self._again.setVisible(self.can_start_again)
        self._again.setText(AGAIN.get(settings.task, ""))
        self._reset.setEnabled(self._gains.reset(settings) != settings)

    def show_frame(self, frame: Frame) -> None:
        """Say what it does, what limits it, and what the last step of the goal showed."""
        self._limits.take(frame.time, frame.why_limited)
        if len(frame.posture):
            self._why.show_limits(self._limits.told)
        else:
            self._why.say_no_joints()
        _say(self._state, task_words(self._settings, frame))
        if frame.task is not None:
            _say(self._energy, f"{round(frame.task.energy, 2) + 0.0:.2f}\u2009J, {frame.task.tank:.2f}\u2009J left")
        goal = frame.task.force_goal if frame.task else None
        force = max((region.force for region in frame.regions), default=0.0)
        self._step.take(frame.time, force, goal)
        self._show_step()

    def choose_law(self, law: str, _checked: bool = False) -> None:
        """Put another law in force, with the gains it had when it last was."""
        if law != self._settings.law:
            self._edit(self._gains.switched(self._settings, law))

    def take(self, settings: ControlSettings) -> None:
        """Put these in force; the gains of the law before are remembered."""
        self._gains.switched(self._settings, settings.law)
        self._edit(settings)

    def choose_task(self, task: str, _checked: bool = False) -> None:
        """Give the law another task."""
        self._change("task", task)

    def start_again(self) -> None:
        """Start the task's path from its beginning, or hold the contact where it is now."""
        self._edit(replace(self._settings, starts=self._settings.starts + 1))

    def reset_gains(self) -> None:
        """All gains where they began; what the law is to do stays."""
        self._edit(self._gains.reset(self._settings))

    # Inside.

    def _add_state(self) -> None:
        self._state = QLabel(self)
        self._state.setObjectName("task-state")
        self._state.setWordWrap(True)
        self.column.addWidget(self._state)
        self._why = WhyLine(self)
        self.column.addWidget(self._why)
        grid = self.grid()
        self._energy_name, self._energy = fact("Energy given", self), fact("", self, right=True)
        self._energy_name.setToolTip(
            "Net energy the arm gave to what it touches, and what it may still give before it slows down"
        )
        self._energy.setObjectName("energy")
        grid.addWidget(self._energy_name, 0, 0)
        grid.addWidget(self._energy, 0, 1)
        self._response = self.caption()
        self._response.setObjectName("step-response")
        self._response.setToolTip("How the force answered the last step of its goal; settled within 5 % of the step")
        self._response.hide()

    def _show_step(self) -> None:
        response = self._step.response
        self._response.setVisible(response is not None)
        if response is not None:
            _say(self._response, step_words(response))

    def _law_buttons(self) -> QGridLayout:
        grid = QGridLayout()
        grid.setSpacing(4)
        for side in (0, 1):
            grid.setColumnStretch(side, 1)
        for number, (law, (text, tip)) in enumerate(LAWS.items()):
            button = QPushButton(text, self)
            button.setObjectName(f"law-{law}")
            button.setCheckable(True)
            button.setToolTip(tip)
            button.clicked.connect(partial(self.choose_law, law))
            self._group.addButton(button)
            self._buttons[law] = button
            grid.addWidget(button, *divmod(number, 2))
        return grid

    def _act_buttons(self) -> QGridLayout:
        grid = QGridLayout()
        grid.setSpacing(4)
        self._again = self._button("task-again", "", "Start the task afresh", self.start_again)
        self._reset = self._button("reset-gains", "Reset gains", _GAINS_TIP, self.reset_gains)
        self._compare = self._button("compare-laws", "Compare laws…", _COMPARE_TIP, self.compare_asked)
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

    def _choice_box(self, name: str) -> ChoiceBox:
        tip, words = CHOICES[name]
        box = ChoiceBox(self)
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


_GAINS_TIP = "All gains of this law go back to where they began; what it is to do stays"
_COMPARE_TIP = "Run several laws on the same touches, beside the simulation"


def _say(label: QLabel, words: str) -> None:
    if words != label.text():
        label.setText(words)
