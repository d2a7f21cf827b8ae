"""How contacts are read, for the hand: the way to a force, and from where a taxel counts as touched."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QVBoxLayout, QWidget

from app.contacts.accuracy import ReadingErrors
from app.contacts.reading_settings import ReadingSettings
from app.scene.effects import Effects
from widgets.panels.choice_box import ChoiceBox
from widgets.panels.reading_choices import (
    ESTIMATOR_TIP,
    ESTIMATORS,
    THRESHOLD_TIP,
    THRESHOLDS,
    threshold_words,
)


class ReadingBox(QWidget):
    """Two choices; it shows what is in force, and tells what a person wants."""

    reading_edited = Signal(object)
    """ReadingSettings wanted."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._settings, self._usual = ReadingSettings(), ReadingSettings().threshold_for(ReadingErrors())
        self.estimator = self._choice("choice-estimator", ESTIMATOR_TIP)
        for name, (words, tip) in ESTIMATORS.items():
            self.estimator.addItem(words, name)
            self.estimator.setItemData(self.estimator.count() - 1, tip, Qt.ItemDataRole.ToolTipRole)
        self.threshold = self._choice("choice-threshold", THRESHOLD_TIP)
        self.threshold.setToolTip(THRESHOLD_TIP)
        for threshold in THRESHOLDS:
            self.threshold.addItem("", threshold)
        self.estimator.activated.connect(self._on_estimator_chosen)
        self.threshold.activated.connect(self._on_threshold_chosen)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addWidget(self.estimator)
        column.addWidget(self.threshold)
        self.show_reading(self._settings)

    def show_reading(self, settings: ReadingSettings) -> None:
        """Show the settings in force."""
        self._settings = settings
        words, tip = ESTIMATORS[settings.estimator]
        self.estimator.setCurrentIndex(self.estimator.findData(settings.estimator))
        self.estimator.say(words)
        self.estimator.setToolTip(f"{ESTIMATOR_TIP}.\n\n{tip}")
        for row, threshold in enumerate(THRESHOLDS):
            self.threshold.setItemText(row, threshold_words(threshold, self._usual))
        known = settings.threshold in THRESHOLDS  # a scene may name any
        self.threshold.setCurrentIndex(THRESHOLDS.index(settings.threshold) if known else -1)
        self.threshold.say(threshold_words(settings.threshold, self._usual))

    def show_effects(self, effects: Effects) -> None:
        """The noise in force says what automatic means."""
        self._usual = ReadingSettings().threshold_for(ReadingErrors.of_sensor(effects.sensor))
        self.show_reading(self._settings)

    def _choice(self, name: str, tip: str) -> ChoiceBox:
        box = ChoiceBox(self)
        box.setObjectName(name)
        box.setAccessibleName(tip.split("\n")[0])
        return box

    def _on_estimator_chosen(self, row: int) -> None:
        self._edit(replace(self._settings, estimator=self.estimator.itemData(row)))

    def _on_threshold_chosen(self, row: int) -> None:
        self._edit(replace(self._settings, threshold=THRESHOLDS[row]))

    def _edit(self, settings: ReadingSettings) -> None:
        if settings != self._settings:
            self.show_reading(settings)
            self.reading_edited.emit(settings)
