"""Dialog for the preferences of the program. Each change acts at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import cast

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QWidget,
)

from tactile_widgets.common.make import (
    STYLE_SPACING,
    add_items,
    column_layout,
    make,
    row_layout,
    select_data,
    show_text,
)
from tactile_widgets.common.sentence import as_sentence
from tactile_widgets.common.settings import FRAME_RATES, NavigationStyle, Preferences, Question

_THEMES = {"Dark": "dark", "Light": "light"}
_STYLES = {
    "Tactile Maps: right turns, middle moves": NavigationStyle.STANDARD,
    "MuJoCo: right moves, middle zooms": NavigationStyle.MUJOCO,
    "Blender: middle turns, Shift-middle moves, Ctrl-middle zooms": NavigationStyle.BLENDER,
}
_RATES = {f"At most {rate} pictures a second": rate for rate in FRAME_RATES}
_ANGLES = {"Degrees": False, "Radians": True}
_QUESTIONS = {
    Question.IMPORT: (
        "Ask whether imported taxels replace those of other files",
        "Without the question, they replace them",
    ),
    Question.RESTORE: ("Ask before restored edits replace newer ones", "Undo brings the newer ones back"),
    Question.TRASH: (
        "Ask before a recording is moved to the trash",
        "Undo moves it back from the system's trash",
    ),
}
_FOLDER_TIP = "New recordings are written here, also those of stopped sessions and of replayed runs"


class PreferencesDialog(QDialog):
    """Controls of all preferences.

    Args:
        preferences: Current values.
        default_folder: Folder of recordings unless another one is chosen.
        parent: The window.
    """

    changed = Signal(Preferences)
    """The user changed a value."""
    folder_requested = Signal()
    """The user requested to choose the folder of recordings."""
    folder_entered = Signal(str)
    """The user entered another folder of recordings; empty for the default one."""

    def __init__(self, preferences: Preferences, default_folder: Path, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("preferences")
        self.setWindowTitle("Preferences")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._default_folder = default_folder
        self._shown = preferences
        self.folder = make(QLineEdit, self, objectName="recordings-folder", editingFinished=self._on_folder_edited)
        self.problem = make(QLabel, self, objectName="folder-problem", wordWrap=True, visible=False)
        self.problem.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.choose = make(QPushButton, "Choose…", self, autoDefault=False, clicked=self.folder_requested)
        self.theme = self._choice("theme", _THEMES, "Colours of the window")
        self.navigation = self._choice("navigation", _STYLES, "Mouse buttons that move both views; the wheel zooms")
        self.rate = self._choice("frame-rate", _RATES, "Fewer pictures of the robot leave more time for the simulation")
        self.angles = self._choice("angles", _ANGLES, "Unit of revolute joints in the panel Posture")
        self.questions = {
            question: make(QCheckBox, words, self, objectName=f"ask-{question.value}", toolTip=tip)
            for question, (words, tip) in _QUESTIONS.items()
        }
        self._lay_out()
        self.show_preferences(preferences)
        for box in (self.theme, self.navigation, self.rate, self.angles):
            box.activated.connect(self._on_changed)
        for check in self.questions.values():
            check.clicked.connect(self._on_changed)

    def _choice(self, name: str, choices: Mapping[str, object], tip: str) -> QComboBox:
        box = make(QComboBox, self, objectName=name, toolTip=tip)
        add_items(box, ((words, value, "") for words, value in choices.items()))
        return box

    def _lay_out(self) -> None:
        form = QFormLayout()
        self.folder.setAccessibleName("Recordings")
        row = row_layout(self.folder, self.choose, spacing=STYLE_SPACING, stretch=self.folder)
        form.addRow("Recordings", column_layout(row, self.problem, spacing=STYLE_SPACING))
        rows = {"Theme": self.theme, "Mouse": self.navigation, "Robot view": self.rate, "Joint angles": self.angles}
        for words, control in rows.items():
            control.setAccessibleName(words)
            form.addRow(words, control)
        for number, check in enumerate(self.questions.values()):
            form.addRow("" if number else "Questions", check)
        buttons = make(QDialogButtonBox, QDialogButtonBox.StandardButton.Close, self, rejected=self.reject)
        self.restore = make(QPushButton, "Restore defaults", self, clicked=self._on_restore)
        buttons.addButton(self.restore, QDialogButtonBox.ButtonRole.ResetRole)
        for button in buttons.buttons():  # Return enters the folder, and presses no button
            cast("QPushButton", button).setAutoDefault(False)
        self._column = column_layout(form, buttons, parent=self, spacing=STYLE_SPACING, margins=None)
        self.resize(600, 0)

    def show_preferences(self, preferences: Preferences) -> None:
        """Show other values."""
        self._shown = preferences
        self.folder.setText(preferences.recordings or str(self._default_folder))
        self.folder.setToolTip(f"{self.folder.text()}\n{_FOLDER_TIP}")
        values = (preferences.theme, preferences.navigation, preferences.frame_rate, preferences.radians)
        for box, value in zip((self.theme, self.navigation, self.rate, self.angles), values, strict=True):
            select_data(box, value)
        for question, check in self.questions.items():
            check.setChecked(preferences.asks(question))

    def show_problem(self, text: str) -> None:
        """Show why a folder cannot be used, below its field; an empty text hides it."""
        show_text(self.problem, text and f"▲ {as_sentence(text)}")
        self._column.activate()
        self.resize(self.width(), self.heightForWidth(self.width()))

    def _on_folder_edited(self) -> None:
        text = self.folder.text().strip()
        if text != (self._shown.recordings or str(self._default_folder)):
            self.folder_entered.emit(text)

    def _on_changed(self, _changed: object = None) -> None:
        self._shown = replace(
            self._shown,
            theme=self.theme.currentData(),
            navigation=self.navigation.currentData(),
            frame_rate=self.rate.currentData(),
            radians=self.angles.currentData(),
            unasked=frozenset(question for question, check in self.questions.items() if not check.isChecked()),
        )
        self.changed.emit(self._shown)

    def _on_restore(self) -> None:
        self.show_preferences(Preferences())
        self.changed.emit(self._shown)
