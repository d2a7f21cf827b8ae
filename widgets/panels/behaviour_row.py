"""One behaviour in its panel, as a sentence of boxes: when what happens, where, what follows, for how long."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QToolButton, QVBoxLayout, QWidget

from app.control.behaviour import TOLD_LATE, Behaviour
from widgets.panels.behaviour_choices import ANYWHERE, LASTS, THEN, WHEN, then_words, when_words
from widgets.panels.choice_box import ChoiceBox

_CROSS = "\N{MULTIPLICATION SIGN}"
_GAP_PX, _LEAST_PX, _SCROLL_PX, _CROSS_PX = 4, 40, 16, 24
_NAMES = {"when": "What must happen", "where": "Where", "then": "What follows", "lasts": "For how long"}


class BehaviourRow(QWidget):
    """Shows a behaviour and lets each of its parts be chosen anew.

    Args:
        behaviour: What it shows.
        places: Names of the links and patches that may be touched.
        parent: Qt parent.
    """

    edited = Signal(object)
    """The Behaviour that it shall be."""
    removed = Signal()
    """It shall go."""

    def __init__(self, behaviour: Behaviour, places: Sequence[str], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        named = [("", ANYWHERE), *((place, place.replace("_", " ")) for place in places)]
        self._offered: dict[str, list[tuple[Any, str]]] = {
            "when": list(WHEN.items()),
            "where": named,
            "then": THEN,
            "lasts": list(LASTS.items()),
        }
        self._boxes = {part: self._box(part) for part in self._offered}
        whole = QVBoxLayout(self)
        whole.setContentsMargins(0, 0, 0, 0)
        whole.setSpacing(0)
        when, where, then, lasts = self._boxes.values()
        whole.addLayout(_line(_quiet("On", self), when, _quiet("at", self), where, self._cross()))
        whole.addLayout(_line(_quiet("then", self), then, lasts))
        self.show_behaviour(behaviour)

    def show_behaviour(self, behaviour: Behaviour) -> None:
        """Show another one; the keys stay where they are."""
        self.behaviour = behaviour
        now: dict[str, tuple[Any, str]] = {
            "when": ((behaviour.on, behaviour.times), when_words(behaviour)),
            "where": (behaviour.where, behaviour.where.replace("_", " ") or ANYWHERE),
            "then": (dict(behaviour.then), then_words(behaviour.then)),
            "lasts": (behaviour.until_released, LASTS[behaviour.until_released]),
        }
        for part, (value, words) in now.items():
            values = [known for known, _ in self._offered[part]]
            self._boxes[part].setCurrentIndex(values.index(value) if value in values else -1)
            self._boxes[part].say(words)
        self._boxes["lasts"].setEnabled(behaviour.on not in TOLD_LATE)

    def _box(self, part: str) -> ChoiceBox:
        box = ChoiceBox(self)
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
                lasts = now.until_released and value[0] not in TOLD_LATE
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
        button.setText(_CROSS)
        button.setAutoRaise(True)
        button.setFixedWidth(_CROSS_PX)
        button.setAccessibleName("Remove this behaviour")
        button.setToolTip("Remove this behaviour")
        button.clicked.connect(self.removed)
        return button


def _line(*parts: QWidget) -> QHBoxLayout:
    """Beside each other; boxes share what room there is, by what they have to say."""
    line = QHBoxLayout()
    line.setSpacing(_GAP_PX)
    for part in parts:
        line.addWidget(part, 1 if isinstance(part, ChoiceBox) else 0)
    return line


def _quiet(text: str, parent: QWidget) -> QLabel:
    label = QLabel(text, parent)
    label.setProperty("role", "caption")
    return label
