"""The behaviours panel: which contact events change the controller, each chosen as a sentence of combo boxes.

A sentence names the event, its location, the response and its duration.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QToolButton, QWidget

from tactile_maps.control.behaviours import ENDING_EVENTS, Behaviour, ControlTrigger, SettingValue, trigger_text
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.make import column_layout, make, push_button, row_layout, show_text
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
    ("incipient-slip", 1): "incipient slip",
    ("slip", 1): "slip",
    ("release", 1): "release",
}
"""Names by event and the number of times it must happen."""
DURATION_CHOICES = {False: "permanently", True: "until released"}
"""Names by whether the previous settings are restored."""
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
"""Changed settings and their names: the tasks, with a controller that supports them all, and the two controllers
without a task.
"""


def event_text(behaviour: Behaviour) -> str:
    """Return the event that triggers a behaviour, without its location."""
    known = EVENT_CHOICES.get((behaviour.on, behaviour.times), f"{behaviour.times} times {behaviour.on}")
    return known + (f" > {behaviour.above:g}\u202fN" if behaviour.above else "")


def response_text(then: Mapping[str, SettingValue]) -> str:
    """Return the name of a response, or its settings one by one if it is not in the list."""
    for known, text in RESPONSE_CHOICES:
        if known == dict(then):
            return text
    return ", ".join(f"{name.replace('_', ' ')} {_value_text(value)}" for name, value in then.items())


def _value_text(value: SettingValue) -> str:
    if isinstance(value, tuple):
        return f"of {len(value)} points"
    return value.replace("_", " ") if isinstance(value, str) else f"{value:g}"


_REMOVE_SIGN = "\N{MULTIPLICATION SIGN}"
_REMOVE_TIP = "Remove this behaviour"
_SCROLL_PX = 16
_NAMES = {"when": "Event", "where": "Location", "then": "Response", "lasts": "Duration"}


class BehaviourRow(QWidget):
    """Combo boxes that show the parts of a behaviour and change them.

    Args:
        behaviour: Behaviour to show.
        places: Names of the links and patches that can be touched.
        parent: Qt parent.
    """

    edited = Signal(Behaviour)
    """The behaviour as edited by the user."""
    removed = Signal()
    """The user removes the behaviour."""

    def __init__(self, behaviour: Behaviour, places: Sequence[str], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._offered: dict[str, list[tuple[Any, str]]] = {
            "when": list(EVENT_CHOICES.items()),
            "where": [("", ANYWHERE), *((place, place.replace("_", " ")) for place in places)],
            "then": RESPONSE_CHOICES,
            "lasts": list(DURATION_CHOICES.items()),
        }
        self._boxes = {part: self._box(part) for part in self._offered}
        when, where, then, lasts = self._boxes.values()
        remove = make(
            QToolButton,
            self,
            objectName="behaviour-remove",
            text=_REMOVE_SIGN,
            autoRaise=True,
            fixedWidth=24,
            accessibleName=_REMOVE_TIP,
            toolTip=_REMOVE_TIP,
            clicked=self.removed,
        )
        lines = (("On", when, "at", where, remove), ("then", then, lasts))
        column_layout(*(self._line(*parts) for parts in lines), parent=self, spacing=0)
        self.show_behaviour(behaviour)

    def show_behaviour(self, behaviour: Behaviour) -> None:
        """Show another behaviour; the keyboard focus stays."""
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
        name = _NAMES[part]
        box = make(
            FlatComboBox, self, objectName=f"behaviour-{part}", accessibleName=name, toolTip=name, minimumWidth=40
        )
        box.addItems([text for _, text in self._offered[part]])
        box.view().setMinimumWidth(box.view().sizeHintForColumn(0) + _SCROLL_PX)
        box.activated.connect(lambda row: self._choose(part, self._offered[part][row][0]))
        return box

    def _choose(self, part: str, value: Any) -> None:
        now = self.behaviour
        match part:
            case "when":
                lasts = now.until_released and value[0] not in ENDING_EVENTS
                chosen = replace(now, on=value[0], times=value[1], until_released=lasts)
            case "where":
                chosen = replace(now, where=value)
            case "then":
                chosen = replace(now, then=value)
            case _:
                chosen = replace(now, until_released=value)
        if chosen != now:
            self.edited.emit(chosen)

    def _line(self, *parts: QWidget | str) -> QHBoxLayout:
        """Lay out words and controls; combo boxes share the remaining space in proportion to their texts."""
        line = row_layout(
            *(make(QLabel, part, self, role="caption") if isinstance(part, str) else part for part in parts), spacing=4
        )
        for part in parts:
            if isinstance(part, FlatComboBox):
                line.setStretchFactor(part, 1)
        return line


_EMPTY = "Contact events can switch the controller: add a behaviour."
_DEFAULT_BEHAVIOUR = Behaviour("tap", times=2, then={"controller": "hybrid", "task": "retreat"})


class BehavioursPanel(Panel):
    """The current behaviours, and the last one that was triggered."""

    behaviours_edited = Signal(tuple)
    """All behaviours as edited by the user, ``Behaviour`` each."""

    simulates = True

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Behaviours", "behaviours-panel", parent)
        self._places: tuple[str, ...] = ()
        self.behaviours: tuple[Behaviour, ...] = ()
        self._rows: list[BehaviourRow] = []
        self._note = self.caption(_EMPTY, "behaviours-note")
        tip = "Add a behaviour: by default, a double tap makes the arm retreat"
        add = push_button(self, "behaviour-add", "Add behaviour", tip, self._on_add_clicked)
        self.column.addWidget(add, alignment=Qt.AlignmentFlag.AlignLeft)

    def set_editable(self, *, editable: bool) -> None:
        self._body.setEnabled(editable)  # heading and help stay enabled

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Offer the places of another skin."""
        names = (patch.name for patch in prepared.skin.patches)
        self._places = tuple(dict.fromkeys((*prepared.skin.links, *names)))
        self._build()

    def show_behaviours(self, behaviours: tuple[Behaviour, ...]) -> None:
        """Show the current behaviours."""
        if behaviours == self.behaviours:
            return
        same = len(behaviours) == len(self._rows)
        self.behaviours = behaviours
        if not same:
            self._build()
        for shown, behaviour in zip(self._rows, behaviours, strict=True):
            shown.show_behaviour(behaviour)

    def show_triggered(self, trigger: ControlTrigger) -> None:
        """Show what changed the controller."""
        show_text(self._note, f"Last: {trigger_text(trigger)}")

    def _build(self) -> None:
        for old in self._rows:
            old.setParent(None)
            old.deleteLater()
        self._rows = [BehaviourRow(behaviour, self._places, self) for behaviour in self.behaviours]
        for number, new in enumerate(self._rows):
            self.column.insertWidget(number, new)
            new.edited.connect(partial(self._on_edited, number))
            new.removed.connect(partial(self._on_edited, number))
        show_text(self._note, "" if self.behaviours else _EMPTY)

    def _on_add_clicked(self) -> None:
        self._edit((*self.behaviours, _DEFAULT_BEHAVIOUR))

    def _on_edited(self, number: int, *edited: Behaviour) -> None:
        """Replace a behaviour; remove it if there is no replacement."""
        self._edit((*self.behaviours[:number], *edited, *self.behaviours[number + 1 :]))

    def _edit(self, behaviours: tuple[Behaviour, ...]) -> None:
        self.show_behaviours(behaviours)
        self.behaviours_edited.emit(behaviours)
