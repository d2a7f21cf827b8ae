"""Asks what an episode of a recording is called, what was to be done in it, and how it ended."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QComboBox, QDialog, QDialogButtonBox, QFormLayout, QLineEdit, QPlainTextEdit, QWidget

from tactile_maps.recording.encoding.annotations import MOST_TEXT, LabelledEpisode, Outcome

OUTCOMES: dict[str, Outcome | None] = {"Not said": None, "Success": Outcome.SUCCESS, "Failure": Outcome.FAILURE}
"""By what a person reads."""
_TEXT_HEIGHT = 72


class EpisodeDialog(QDialog):
    """Asks; emits the episode when that is accepted.

    Args:
        episode: As it is now, or as it is proposed.
        parent: Qt parent.
    """

    chosen = Signal(LabelledEpisode)
    """The episode to train with."""

    def __init__(self, episode: LabelledEpisode, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._episode = episode
        self.setObjectName("episode-dialog")
        self.setWindowTitle("Episode")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.label, self.instruction = QLineEdit(episode.label, self), QPlainTextEdit(episode.instruction, self)
        self.outcome = QComboBox(self)
        self._set_up()
        buttons = QDialogButtonBox(self)
        buttons.setStandardButtons(QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel)
        buttons.accepted.connect(self._on_accepted)
        buttons.rejected.connect(self.reject)
        form = QFormLayout(self)
        form.setSpacing(8)
        form.addRow("&Label", self.label)
        form.addRow("&Instruction", self.instruction)
        form.addRow("&Outcome", self.outcome)
        form.addRow(buttons)

    def _set_up(self) -> None:
        self.label.setObjectName("episode-label")
        self.label.setMaxLength(MOST_TEXT)
        self.label.setPlaceholderText("Like: press the forearm")
        self.label.setMinimumWidth(320)
        self.label.selectAll()
        self.instruction.setObjectName("episode-instruction")
        self.instruction.setPlaceholderText("What was to be done, in words; data sets give it to a policy")
        self.instruction.setFixedHeight(_TEXT_HEIGHT)
        self.instruction.setTabChangesFocus(True)
        self.outcome.setObjectName("episode-outcome")
        self.outcome.addItems(list(OUTCOMES))
        self.outcome.setCurrentIndex(list(OUTCOMES.values()).index(self._episode.outcome))

    def _on_accepted(self) -> None:
        one = self._episode
        label = self.label.text().strip() or one.label
        instruction = self.instruction.toPlainText().strip()[:MOST_TEXT]
        outcome = OUTCOMES[self.outcome.currentText()]
        self.accept()
        self.chosen.emit(LabelledEpisode(one.first, one.last, label, instruction, outcome))
