"""Dialog for the label, instruction and outcome of an episode of a recording."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QComboBox, QDialog, QDialogButtonBox, QFormLayout, QLineEdit, QPlainTextEdit, QWidget

from tactile_maps.recording.encoding.annotations import MOST_TEXT, LabelledEpisode, Outcome
from tactile_widgets.common.make import make

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
        self.label = make(
            QLineEdit,
            episode.label,
            self,
            objectName="episode-label",
            maxLength=MOST_TEXT,
            placeholderText="Like: press the forearm",
            minimumWidth=320,
        )
        self.label.selectAll()
        self.instruction = make(
            QPlainTextEdit,
            episode.instruction,
            self,
            objectName="episode-instruction",
            placeholderText="The task in words, as given to a policy by data sets",
            fixedHeight=_TEXT_HEIGHT,
            tabChangesFocus=True,
        )
        self.outcome = make(QComboBox, self, objectName="episode-outcome")
        self.outcome.addItems(list(OUTCOMES))
        self.outcome.setCurrentIndex(list(OUTCOMES.values()).index(episode.outcome))
        kinds = QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel
        buttons = make(QDialogButtonBox, kinds, self, accepted=self._on_accepted, rejected=self.reject)
        form = make(QFormLayout, self, spacing=8)
        form.addRow("&Label", self.label)
        form.addRow("&Instruction", self.instruction)
        form.addRow("&Outcome", self.outcome)
        form.addRow(buttons)

    def _on_accepted(self) -> None:
        one = self._episode
        label = self.label.text().strip() or one.label
        instruction = self.instruction.toPlainText().strip()[:MOST_TEXT]
        outcome = OUTCOMES[self.outcome.currentText()]
        self.accept()
        self.chosen.emit(LabelledEpisode(one.first, one.last, label, instruction, outcome))
