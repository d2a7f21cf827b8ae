"""One contender: its letter and stroke, its law, and its gains, folded away until they are wanted."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QToolButton, QVBoxLayout, QWidget

from app.control.command import ControlSettings
from app.control.laws import heeded
from widgets.colours import Theme
from widgets.law_comparison.strokes import Stroke
from widgets.panels.choice_box import ChoiceBox
from widgets.panels.controller_choices import LAWS, SLIDERS
from widgets.panels.gain_memory import GAINS
from widgets.panels.setting_sliders import SettingSliders

_SHORTEST = 8
"""Letters of a law's name that are always seen; the tool tip has all."""


class ContenderCard(QWidget):
    """Shows settings and emits others; the task among them is not the card's to change."""

    edited = Signal()
    """Another law, or other gains."""
    removed = Signal(str)
    """This contender is not wanted any more: its letter."""

    def __init__(self, letter: str, settings: ControlSettings, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.letter = letter
        self.setObjectName(f"contender-{letter}")
        self._stroke, self._law = Stroke(letter, theme, self), ChoiceBox(self)
        self._gains, self._remove = QPushButton("Gains", self), QToolButton(self)
        names = [name for name in GAINS if name in SLIDERS]
        self.sliders = SettingSliders(names, self)
        self.sliders.hide()
        self._lay_out()
        self._law.activated.connect(self._on_law_chosen)
        self._gains.toggled.connect(self.sliders.setVisible)
        self._remove.clicked.connect(self._on_remove_clicked)
        self.sliders.settings_edited.connect(self._edit)
        self.show_settings(settings)

    @property
    def settings(self) -> ControlSettings:
        """Law and gains as they are chosen."""
        return self._settings

    @property
    def title(self) -> str:
        """Letter and law, for legends."""
        return f"{self.letter}: {LAWS[self._settings.law][0]}"

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._stroke.set_theme(theme)

    def set_removable(self, removable: bool) -> None:
        """Whether it may be taken out: two must stay."""
        self._remove.setVisible(removable)

    def show_settings(self, settings: ControlSettings) -> None:
        """Show a law and its gains."""
        self._settings = settings
        self._law.setCurrentIndex(self._law.findData(settings.law))
        words, tip = LAWS[settings.law]
        self._law.say(words)
        self._law.setToolTip(f"{words}: {tip}")
        self.sliders.show_settings(settings)
        self._gains.setEnabled(any(name in heeded(settings) for name in self.sliders.by_name))

    def _lay_out(self) -> None:
        for law, (text, tip) in LAWS.items():
            self._law.addItem(text, law)
            self._law.setItemData(self._law.count() - 1, tip, Qt.ItemDataRole.ToolTipRole)
        self._law.setObjectName(f"contender-law-{self.letter}")
        self._law.setAccessibleName(f"Law of {self.letter}")
        self._law.setSizeAdjustPolicy(ChoiceBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self._law.setMinimumContentsLength(_SHORTEST)
        self._gains.setObjectName(f"contender-gains-{self.letter}")
        self._gains.setCheckable(True)
        self._gains.setToolTip(f"Show the gains of {self.letter}")
        self._remove.setText("×")
        self._remove.setObjectName(f"contender-remove-{self.letter}")
        self._remove.setAccessibleName(f"Leave {self.letter} out")
        self._remove.setToolTip(f"Leave {self.letter} out")
        row = QHBoxLayout()
        row.setSpacing(8)
        row.addWidget(QLabel(f"<b>{self.letter}</b>", self))
        for widget in (self._stroke, self._law, self._gains, self._remove):
            row.addWidget(widget, int(widget is self._law))
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(8)
        column.addLayout(row)
        column.addWidget(self.sliders)

    def _edit(self, settings: ControlSettings) -> None:
        self.show_settings(settings)
        self.edited.emit()

    def _on_law_chosen(self, row: int) -> None:
        self._edit(replace(self._settings, law=self._law.itemData(row)))

    def _on_remove_clicked(self) -> None:
        self.removed.emit(self.letter)
