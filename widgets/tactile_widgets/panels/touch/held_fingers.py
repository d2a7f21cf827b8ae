"""Simulated fingers: force and speed of the mouse's finger, and fingers that stay until they are removed."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QGridLayout, QLabel, QToolButton, QWidget

from tactile_maps.session.frame import Frame
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.poke import Finger
from tactile_widgets.common.make import column_layout, make, row_layout, value_label
from tactile_widgets.common.number_field import NumberField
from tactile_widgets.common.sentence import capitalized

FIRST_HELD = 2
"""First id of the fingers that stay; the mouse's finger is 1, those of a script are 0 and below."""
HELD_FORCE = 3.0
"""Initial force of a finger that stays [N]."""
_FORCE = ("N", 0.1, 50.0, 0.1)
"""Unit, minimum, maximum and step of a force."""
_SPEED = ("mm/s", 1.0, 200.0, 1.0)
_HOW = "Shift-click the skin, or right-click it, to leave a finger there"

_DRAG_TIP = (
    "The mouse's finger sticks to the skin, drags it, and slides when friction does not hold it (also with Alt).\n"
    "It needs the effect Shear."
)


class HeldFingers(QWidget):
    """A line for the mouse's finger, one for the next finger that stays, and one for each finger that stays now.

    Attributes:
        finger: Finger of the mouse.
        held: Force of the next finger that stays [N].
        drags: Whether the mouse's finger drags the skin by friction instead of sliding freely.
    """

    force_edited = Signal(int, float)
    """Requested force of a finger that stays: its id and the force [N]."""
    removed = Signal(int)
    """Id of the finger that the user removes."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("held-fingers")
        self.finger = Finger()
        self._rows = dict[int, _Row]()
        self._skin: Skin | None = None
        self.drags = make(QCheckBox, "Drag", self, objectName="finger-drags", toolTip=_DRAG_TIP)
        name = "Force of the mouse's finger"
        self.most = NumberField(name, *_FORCE, "The force at which the mouse's finger stops", self)
        name = "Speed of the mouse's finger"
        self.speed = NumberField(name, *_SPEED, "How fast the mouse's finger presses in", self)
        tip = f"{_HOW}, which presses with this force"
        self.held = NumberField("Force of a finger that stays", *_FORCE, tip, self)
        for name, field, value in (
            ("finger-force", self.most, self.finger.max_force),
            ("finger-speed", self.speed, 1e3 * self.finger.speed),
            ("held-force", self.held, HELD_FORCE),
        ):
            field.setObjectName(name)
            field.show_number(value)
        self.most.valueChanged.connect(lambda force: self._edit(max_force=force))
        self.speed.valueChanged.connect(lambda speed: self._edit(speed=1e-3 * speed))
        self._grid = QGridLayout()
        self._grid.setColumnStretch(0, 1)
        mouse = QLabel("Mouse")
        shift_click = QLabel("Shift-click")
        column_layout(
            row_layout(mouse, self.drags, self.most, self.speed, spacing=2, stretch=mouse),
            row_layout(shift_click, self.held, spacing=2, stretch=shift_click),
            self._grid,
            parent=self,
            spacing=2,
        )

    def show_skin(self, skin: Skin) -> None:
        """Use another skin for the names of links."""
        self._skin = skin

    def show_frame(self, frame: Frame) -> None:
        """Show the fingers that stay now."""
        held = {poke.id: poke for poke in frame.pokes if poke.id >= FIRST_HELD}
        for number in self._rows.keys() - held.keys():
            self._rows.pop(number).remove()
        for number, poke in held.items():
            if number not in self._rows:
                self._rows[number] = self._make_row(number)
            where = "" if self._skin is None else self._skin.link(poke.at).replace("_", " ")
            self._rows[number].show(where, poke.force)

    def edit_force(self, number: int) -> None:
        """Move the keyboard focus to the force of a finger."""
        if number in self._rows:
            field = self._rows[number].field
            field.setFocus()
            field.selectAll()

    def _make_row(self, number: int) -> _Row:
        line = _Row(number, self._grid, self)
        line.field.valueChanged.connect(partial(self.force_edited.emit, number))
        line.away.clicked.connect(partial(self.removed.emit, number))
        return line

    def _edit(self, **changes: float) -> None:
        self.finger = replace(self.finger, **changes)


class _Row:
    """Row of one finger that stays."""

    def __init__(self, number: int, grid: QGridLayout, parent: QWidget) -> None:
        self._where = value_label("", parent)
        self.field = NumberField(f"Force of finger {number}", *_FORCE, "The force with which it presses", parent)
        self.field.setObjectName(f"held-{number}")
        self.field.show_number(HELD_FORCE)
        self.away = make(
            QToolButton,
            parent,
            text="✕",
            fixedWidth=24,
            objectName=f"held-{number}-away",
            toolTip="Remove this finger",
            accessibleName=f"Remove finger {number}",
        )
        self._all = (self._where, self.field, self.away)
        for place, part in enumerate(self._all):
            grid.addWidget(part, number, place)

    def show(self, where: str, force: float) -> None:
        """Show the touched link and the current force [N]."""
        words = f"{capitalized(where)}, {force:.1f}\u202fN of"
        if words != self._where.text():
            self._where.setText(words)
            self._where.setMinimumWidth(1)  # a long name is cut, and does not widen the panel

    def remove(self) -> None:
        """Delete the widgets of the row."""
        for part in self._all:
            part.hide()
            part.deleteLater()
