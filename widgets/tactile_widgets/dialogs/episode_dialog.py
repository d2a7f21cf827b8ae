"""Dialog for the label, instruction and outcome of an episode of a recording."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QComboBox, QDialog, QDialogButtonBox, QFormLayout, QLineEdit, QPlainTextEdit, QWidget

from tactile_maps.recording.encoding.annotations import MOST_TEXT, LabelledEpisode, Outcome

OUTCOMES: dict[str, Outcome | None] = {"Not set": None, "Success": Outcome.SUCCESS, "Failure": Outcome.FAILURE}
"""Outcomes by their displayed names."""
_TEXT_HEIGHT = 72


class EpisodeDialog(QDialog):
    """Label, instruction and outcome of an episode.

    Args:
        episode: The current or proposed episode.
        parent: Qt parent.
    """

    chosen = Signal(LabelledEpisode)
    """The episode as entered by the user."""

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
        self.instruction.setPlaceholderText("The task in words, as given to a policy by data sets")
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
