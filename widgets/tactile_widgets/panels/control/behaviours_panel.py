"""The behaviours panel: what contact events make the controller do, each chosen as a sentence of combo boxes.

When what happens, where, what follows, for how long.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QToolButton, QVBoxLayout, QWidget

from tactile_maps.control.behaviours import ENDING_EVENTS, Behaviour, ControlTrigger, SettingValue, trigger_text
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.panel import FlatComboBox, Panel

ANYWHERE = "anywhere"
EVENT_CHOICES = {
    ("tap", 1): "tap",
    ("tap", 2): "double tap",
    ("touch", 1): "touch",
    ("press", 1): "press",
    ("stroke", 1): "stroke",
    ("grasp", 1): "grasp",
    ("self-touch", 1): "self-touch",
    ("release", 1): "release",
}
"""Words by event and how often it must happen."""
DURATION_CHOICES = {False: "permanently", True: "until released"}
"""Words by whether the settings from before come back."""
_TASKS = {
    "retreat": "retreat",
    "guide": "hand guiding",
    "keep_force": "keep force",
    "hold_point": "hold position",
    "follow_path": "follow the path",
    "balance": "balance contacts",
}
_CONTROLLERS = {"impedance": "impedance", "hold_force": "hold force"}
RESPONSE_CHOICES: list[tuple[dict[str, str], str]] = [
    *(({"controller": "hybrid", "task": task}, text) for task, text in _TASKS.items()),
    *(({"controller": controller}, text) for controller, text in _CONTROLLERS.items()),
]
"""Settings that change, and their words: the tasks, by a controller that does them all, and the two controllers without
a task.
"""


def event_text(behaviour: Behaviour) -> str:
    """The event that triggers it, without where."""
    known = EVENT_CHOICES.get((behaviour.on, behaviour.times), f"{behaviour.times} times {behaviour.on}")
    return known + (f" > {behaviour.above:g}\u202fN" if behaviour.above else "")


def response_text(then: Mapping[str, SettingValue]) -> str:
    """What it changes: as the list calls it, else setting by setting."""
    for known, text in RESPONSE_CHOICES:
        if known == dict(then):
            return text
    return ", ".join(f"{name.replace('_', ' ')} {_value_text(value)}" for name, value in then.items())


def _value_text(value: SettingValue) -> str:
    if isinstance(value, tuple):
        return f"of {len(value)} points"
    return value.replace("_", " ") if isinstance(value, str) else f"{value:g}"


_REMOVE_SIGN = "\N{MULTIPLICATION SIGN}"
_GAP_PX = 4
_LEAST_PX = 40
_SCROLL_PX = 16
_CROSS_PX = 24
_NAMES = {"when": "Event", "where": "Location", "then": "Response", "lasts": "Duration"}


class BehaviourRow(QWidget):
    """Shows a behaviour and lets each of its parts be chosen anew.

    Args:
        behaviour: What it shows.
        places: Names of the links and patches that may be touched.
        parent: Qt parent.
    """

    edited = Signal(Behaviour)
    """The behaviour as edited by the user."""
    removed = Signal()
    """It shall go."""

    def __init__(self, behaviour: Behaviour, places: Sequence[str], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        named = [("", ANYWHERE), *((place, place.replace("_", " ")) for place in places)]
        self._offered: dict[str, list[tuple[Any, str]]] = {
            "when": list(EVENT_CHOICES.items()),
            "where": named,
            "then": RESPONSE_CHOICES,
            "lasts": list(DURATION_CHOICES.items()),
        }
        self._boxes = {part: self._box(part) for part in self._offered}
        whole = QVBoxLayout(self)
        whole.setContentsMargins(0, 0, 0, 0)
        whole.setSpacing(0)
        when, where, then, lasts = self._boxes.values()
        whole.addLayout(_row_layout(_caption_label("On", self), when, _caption_label("at", self), where, self._cross()))
        whole.addLayout(_row_layout(_caption_label("then", self), then, lasts))
        self.show_behaviour(behaviour)

    def show_behaviour(self, behaviour: Behaviour) -> None:
        """Show another one; the keys stay where they are."""
        self.behaviour = behaviour
        now: dict[str, tuple[Any, str]] = {
            "when": ((behaviour.on, behaviour.times), event_text(behaviour)),
            "where": (behaviour.where, behaviour.where.replace("_", " ") or ANYWHERE),
            "then": (dict(behaviour.then), response_text(behaviour.then)),
            "lasts": (behaviour.until_released, DURATION_CHOICES[behaviour.until_released]),
        }
        for part, (value, words) in now.items():
            values = [known for known, _ in self._offered[part]]
            self._boxes[part].setCurrentIndex(values.index(value) if value in values else -1)
            self._boxes[part].say(words)
        self._boxes["lasts"].setEnabled(behaviour.on not in ENDING_EVENTS)

    def _box(self, part: str) -> FlatComboBox:
        box = FlatComboBox(self)
        box.setObjectName(f"behaviour-{part}")
        box.setAccessibleName(_NAMES[part])
        box.setToolTip(_NAMES[part])
        box.setMinimumWidth(_LEAST_PX)
        for _, text in self._offered[part]:
            box.addItem(text)
        box.view().setMinimumWidth(box.view().sizeHintForColumn(0) + _SCROLL_PX)
        box.activated.connect(lambda row: self._choose(part, self._offered[part][row][0]))
        return box

    def _choose(self, part: str, value: Any) -> None:
        now = self.behaviour
        match part:
            case "when":
                lasts = now.until_released and value[0] not in ENDING_EVENTS
                wanted = replace(now, on=value[0], times=value[1], until_released=lasts)
            case "where":
                wanted = replace(now, where=value)
            case "then":
                wanted = replace(now, then=value)
            case _:
                wanted = replace(now, until_released=value)
        if wanted != now:
            self.edited.emit(wanted)

    def _cross(self) -> QToolButton:
        button = QToolButton(self)
        button.setObjectName("behaviour-remove")
        button.setText(_REMOVE_SIGN)
        button.setAutoRaise(True)
        button.setFixedWidth(_CROSS_PX)
        button.setAccessibleName("Remove this behaviour")
        button.setToolTip("Remove this behaviour")
        button.clicked.connect(self.removed)
        return button


def _row_layout(*parts: QWidget) -> QHBoxLayout:
    """Beside each other; boxes share what room there is, by what they have to say."""
    line = QHBoxLayout()
    line.setSpacing(_GAP_PX)
    for part in parts:
        line.addWidget(part, 1 if isinstance(part, FlatComboBox) else 0)
    return line


def _caption_label(text: str, parent: QWidget) -> QLabel:
    label = QLabel(text, parent)
    label.setProperty("role", "caption")
    return label


_EMPTY = "Contact events can switch the controller: add a behaviour."
_DEFAULT_BEHAVIOUR = Behaviour("tap", times=2, then={"controller": "hybrid", "task": "retreat"})
"""What a new one is until it is chosen otherwise."""


class BehavioursPanel(Panel):
    """Lists the behaviours in force; says which one acted last."""

    behaviours_edited = Signal(tuple)
    """All behaviours as edited by the user, ``Behaviour`` each."""

    simulates = True

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Behaviours", "behaviours-panel", parent)
        self._places: tuple[str, ...] = ()
        self._behaviours: tuple[Behaviour, ...] = ()
        self._rows: list[BehaviourRow] = []
        self._note = self.caption(_EMPTY)
        self._note.setObjectName("behaviours-note")
        self._add = QPushButton("Add behaviour", self)
        self._add.setObjectName("behaviour-add")
        self._add.setToolTip("Add a behaviour: by default, a double tap makes the arm retreat")
        self._add.clicked.connect(self._on_add_clicked)
        self.column.addWidget(self._add, alignment=Qt.AlignmentFlag.AlignLeft)

    @property
    def behaviours(self) -> tuple[Behaviour, ...]:
        """Those that are shown."""
        return self._behaviours

    def set_editable(self, *, editable: bool) -> None:
        """Let a person change it, or not."""
        self.setEnabled(editable)

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Another skin, with other places to touch."""
        links = dict.fromkeys(patch.link for patch in prepared.skin.patches)
        names = dict.fromkeys(patch.name for patch in prepared.skin.patches)
        self._places = tuple(links | names)
        self._build()

    def show_behaviours(self, behaviours: tuple[Behaviour, ...]) -> None:
        """Show those in force."""
        if behaviours == self._behaviours:
            return
        same = len(behaviours) == len(self._rows)
        self._behaviours = behaviours
        if not same:
            self._build()
        for row, behaviour in zip(self._rows, behaviours, strict=True):
            row.show_behaviour(behaviour)

    def show_triggered(self, trigger: ControlTrigger) -> None:
        """Say what changed the controller."""
        self._say(f"Last: {trigger_text(trigger)}")

    def _build(self) -> None:
        for row in self._rows:
            row.setParent(None)
            row.deleteLater()
        self._rows = [BehaviourRow(behaviour, self._places, self) for behaviour in self._behaviours]
        for number, row in enumerate(self._rows):
            self.column.insertWidget(number, row)
            row.edited.connect(partial(self._on_edited, number))
            row.removed.connect(partial(self._on_removed, number))
        self._say("" if self._behaviours else _EMPTY)

    def _say(self, text: str) -> None:
        self._note.setText(text)
        self._note.setVisible(bool(text))

    def _on_add_clicked(self) -> None:
        self._wish((*self._behaviours, _DEFAULT_BEHAVIOUR))

    def _on_edited(self, number: int, behaviour: Behaviour) -> None:
        self._wish((*self._behaviours[:number], behaviour, *self._behaviours[number + 1 :]))

    def _on_removed(self, number: int) -> None:
        self._wish((*self._behaviours[:number], *self._behaviours[number + 1 :]))

    def _wish(self, behaviours: tuple[Behaviour, ...]) -> None:
        self.show_behaviours(behaviours)
        self.behaviours_edited.emit(behaviours)
