"""The fingers of a person: how the one of the mouse presses, and those that stay until they are taken away."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QToolButton, QVBoxLayout, QWidget

from tactile_maps.session.frame import Frame
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.poke import Finger
from tactile_widgets.common.number_field import NumberField
from tactile_widgets.common.panel import value_label

FIRST_HELD = 2
"""Ids of fingers that stay; the mouse's is 1, those of a script are 0 and below."""
HELD_FORCE = 3.0
"""Of the next finger that stays, at first [N]."""
_FORCE = ("N", 0.1, 50.0, 0.1)
"""Unit, least, most and step of a force."""
_SPEED = ("mm/s", 1.0, 200.0, 1.0)
_HOW = "Shift-click the skin, or right-click it, to leave a finger there"


class HeldFingers(QWidget):
    """A line for the mouse's finger, one for the next finger that stays, and one for each that stays now.

    Attributes:
        finger: Finger of the mouse.
        held: Force of the next finger that stays [N].
    """

    force_edited = Signal(int, float)
    """Requested force of a finger that stays: its id and the force [N]."""
    removed = Signal(int)
    """The finger of this id is to be removed."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("held-fingers")
        self.finger = Finger()
        self._rows = dict[int, _Row]()
        self._skin: Skin | None = None
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(2)
        most = NumberField("Force of the mouse's finger", *_FORCE, "The force at which the mouse's finger stops", self)
        speed = NumberField("Speed of the mouse's finger", *_SPEED, "How fast the mouse's finger presses in", self)
        held = NumberField("Force of a finger that stays", *_FORCE, f"{_HOW}, which presses with this force", self)
        self.most = most
        self.speed = speed
        self.held = held
        for name, field, value in (
            ("finger-force", most, self.finger.max_force),
            ("finger-speed", speed, 1e3 * self.finger.speed),
            ("held-force", held, HELD_FORCE),
        ):
            field.setObjectName(name)
            field.show_number(value)
        most.valueChanged.connect(lambda force: self._edit(max_force=force))
        speed.valueChanged.connect(lambda speed: self._edit(speed=1e-3 * speed))
        column.addLayout(_line("Mouse", most, speed))
        column.addLayout(_line("Shift-click", held))
        self._grid = QGridLayout()
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setColumnStretch(0, 1)
        column.addLayout(self._grid)

    def show_skin(self, skin: Skin) -> None:
        """Fingers are on this skin from now on."""
        self._skin = skin

    def show_frame(self, frame: Frame) -> None:
        """The fingers that stay now."""
        held = {poke.id: poke for poke in frame.pokes if poke.id >= FIRST_HELD}
        for number in self._rows.keys() - held.keys():
            self._rows.pop(number).remove()
        for number, poke in held.items():
            if number not in self._rows:
                self._rows[number] = self._make_row(number)
            where = "" if self._skin is None else self._skin.link(poke.at).replace("_", " ")
            self._rows[number].show(where, poke.force)

    def show_force(self, number: int, force: float) -> None:
        """The finger of an id was asked to press with this force."""
        if number not in self._rows:
            self._rows[number] = self._make_row(number)
        self._rows[number].field.show_number(force)

    def edit_force(self, number: int) -> None:
        """Let a person type the force of a finger."""
        if number in self._rows:
            field = self._rows[number].field
            field.setFocus()
            field.selectAll()

    def _make_row(self, number: int) -> _Row:
        row = _Row(number, self._grid, self)
        row.field.valueChanged.connect(partial(self.force_edited.emit, number))
        row.away.clicked.connect(partial(self.removed.emit, number))
        return row

    def _edit(self, **changes: float) -> None:
        self.finger = replace(self.finger, **changes)


class _Row:
    """One finger that stays."""

    def __init__(self, number: int, grid: QGridLayout, parent: QWidget) -> None:
        self._where = value_label("", parent)
        self.field = NumberField(f"Force of finger {number}", *_FORCE, "The force with which it presses", parent)
        self.field.setObjectName(f"held-{number}")
        self.field.show_number(HELD_FORCE)
        self.away = QToolButton(parent)
        self.away.setText("✕")
        self.away.setFixedWidth(24)
        self.away.setObjectName(f"held-{number}-away")
        self.away.setToolTip("Take this finger away")
        self.away.setAccessibleName(f"Take finger {number} away")
        self._all = (self._where, self.field, self.away)
        for column, part in enumerate(self._all):
            grid.addWidget(part, number, column)

    def show(self, where: str, force: float) -> None:
        """Say on which link it presses, and how hard now."""
        words = f"{where[:1].upper()}{where[1:]}, {force:.1f}\u202fN of"
        if words != self._where.text():
            self._where.setText(words)
            self._where.setMinimumWidth(1)  # a long name is cut, and does not widen the panel

    def remove(self) -> None:
        """It is gone."""
        for part in self._all:
            part.hide()
            part.deleteLater()


def _line(words: str, *fields: NumberField) -> QHBoxLayout:
    row = QHBoxLayout()
    row.addWidget(QLabel(words), 1)
    for field in fields:
        row.addWidget(field)
    return row
