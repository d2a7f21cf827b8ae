"""Behaviours: what contact events make the controller do, chosen as sentences."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QPushButton, QWidget

from app.control.behaviour import Behaviour
from app.session.prepare import Prepared
from widgets.panels.behaviour_row import BehaviourRow
from widgets.panels.panel import Panel

_EMPTY = "A tap, press or stroke can change what the arm does: add a behaviour and choose."
_FIRST = Behaviour("tap", times=2, then={"law": "hybrid", "task": "retreat"})
"""What a new one is until it is chosen otherwise."""


class BehavioursPanel(Panel):
    """Lists the behaviours in force; says which one acted last."""

    behaviours_edited = Signal(object)
    """The tuple of Behaviour wanted."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Behaviours", "behaviours-panel", parent)
        self._places: tuple[str, ...] = ()
        self._behaviours: tuple[Behaviour, ...] = ()
        self._rows: list[BehaviourRow] = []
        self._note = self.caption(_EMPTY)
        self._note.setObjectName("behaviours-note")
        self._add = QPushButton("Add behaviour", self)
        self._add.setObjectName("behaviour-add")
        self._add.setToolTip("A double tap anywhere makes the arm retreat; choose otherwise in its boxes")
        self._add.clicked.connect(self._on_add_clicked)
        self.column.addWidget(self._add, alignment=Qt.AlignmentFlag.AlignLeft)

    @property
    def behaviours(self) -> tuple[Behaviour, ...]:
        """Those that are shown."""
        return self._behaviours

    def show_prepared(self, prepared: Prepared) -> None:
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

    def show_triggered(self, words: str) -> None:
        """Say what changed the controller."""
        self._say(f"Last: {words}")

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
        self._wish((*self._behaviours, _FIRST))

    def _on_edited(self, number: int, behaviour: Behaviour) -> None:
        self._wish((*self._behaviours[:number], behaviour, *self._behaviours[number + 1 :]))

    def _on_removed(self, number: int) -> None:
        self._wish((*self._behaviours[:number], *self._behaviours[number + 1 :]))

    def _wish(self, behaviours: tuple[Behaviour, ...]) -> None:
        self.show_behaviours(behaviours)
        self.behaviours_edited.emit(behaviours)
