"""On what laws are compared: what was done, a recording, or the scene's script; whose task; and for how long."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QDoubleSpinBox, QFileDialog, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from app.errors import TactileMapsError
from app.recording.player import Player
from app.session.side_by_side import MOST_SECONDS
from widgets.law_comparison.occasion import Occasion
from widgets.opening import RECORDING_FILTER
from widgets.panels.choice_box import ChoiceBox

DONE, SCRIPT, FILE = "done", "script", "file"
_SOURCES = {
    DONE: ("What was done since the last reset", "All touches, edits and wishes since then, tick by tick"),
    SCRIPT: ("The scene's own script", "The scripted hand, from the scene's start"),
    FILE: ("A recording…", "What was done in a recording of any scene"),
}
_TASKS = {
    "recorded": ("The task as it was then", "Task, path and force goal come with the stimulus"),
    "own": ("The task set now", "All do the task that the controller has now; changes of the force goal stay"),
}
_LEFT_OUT = "Its changes of law and gains are left out: those are the contenders'."


class StimulusChoice(QWidget):
    """Keeps what there is to compare on; ``show_live`` tells it those of the running session."""

    changed = Signal()
    """Another stimulus, task or time is wanted."""
    failed = Signal(str)
    """A recording cannot be taken."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._known: dict[str, Occasion] = {}
        self._source, self._task, self._file_name = DONE, "recorded", ""
        self._seconds_chosen = False
        self._box, self._tasks = self._choice("stimulus", _SOURCES), self._choice("stimulus-task", _TASKS)
        self._box.activated.connect(self._on_source_chosen)
        self._tasks.activated.connect(self._on_task_chosen)
        self._note, self.seconds = QLabel(self), QDoubleSpinBox(self)
        self._note.setProperty("role", "caption")
        self._note.setWordWrap(True)
        self._note.setObjectName("stimulus-note")
        self.seconds.setRange(0.1, MOST_SECONDS)
        self.seconds.setDecimals(1)
        self.seconds.setSuffix("\u2009s")
        self.seconds.setAccessibleName("Seconds")
        self.seconds.setToolTip("How long each law runs; the stimulus is cut off there, or followed by rest")
        self.seconds.valueChanged.connect(self._on_seconds_changed)
        self._lay_out()
        self._show()

    @property
    def occasion(self) -> Occasion | None:
        """The one chosen; None where there is none of that kind yet."""
        return self._known.get(self._source)

    @property
    def own_task(self) -> bool:
        """Whether the contenders do the task set now."""
        return self._source == SCRIPT or self._task == "own"

    def show_live(self, done: Occasion | None, script: Occasion | None) -> None:
        """What the session has by now: all that was done in it, and its scene's script."""
        for source, occasion in ((DONE, done), (SCRIPT, script)):
            self._known.pop(source, None)
            if occasion is not None:
                self._known[source] = occasion
        if not self._seconds_chosen:
            self._take_seconds()
        self._show()

    def begin(self) -> None:
        """Choose what there is to compare on: what was done, or the script while that is no touch."""
        done = self._known.get(DONE)
        self._source = DONE if done is not None and done.touches else SCRIPT
        self._take_seconds()
        self._show()

    def open_recording(self, path: str | Path) -> None:
        """Take the stimulus from a recording; one that cannot be read changes nothing."""
        try:
            player = Player(path)
        except TactileMapsError as error:
            self.failed.emit(str(error))
            self._show()
            return
        self._known[FILE] = Occasion(player.prepared, tuple(player.inputs), float(player.times[-1]))
        self._file_name = Path(path).name
        self._take(FILE)

    def _choice(self, name: str, words: dict[str, tuple[str, str]]) -> ChoiceBox:
        box = ChoiceBox(self)
        box.setObjectName(name)
        box.setSizeAdjustPolicy(ChoiceBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        box.setAccessibleName({"stimulus": "Stimulus", "stimulus-task": "Task"}[name])
        for value, (text, tip) in words.items():
            box.addItem(text, value)
            box.setItemData(box.count() - 1, tip, Qt.ItemDataRole.ToolTipRole)
        return box

    def _lay_out(self) -> None:
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(8)
        row = QHBoxLayout()
        name = QLabel("For", self)
        name.setBuddy(self.seconds)
        row.addWidget(name)
        row.addWidget(self.seconds, 1)
        for part in (self._box, self._note, self._tasks):
            column.addWidget(part)
        column.addLayout(row)

    def _on_source_chosen(self, row: int) -> None:
        source = self._box.itemData(row)
        if source != FILE:
            self._take(source)
            return
        path, _ = QFileDialog.getOpenFileName(self, "Stimulus from a recording", "", RECORDING_FILTER)
        if path:
            self.open_recording(path)
        else:
            self._show()

    def _on_task_chosen(self, row: int) -> None:
        self._task = self._tasks.itemData(row)
        self._show()
        self.changed.emit()

    def _on_seconds_changed(self, _seconds: float) -> None:
        self._seconds_chosen = True
        self.changed.emit()

    def _take(self, source: str) -> None:
        self._source = source
        self._take_seconds()
        self._show()
        self.changed.emit()

    def _take_seconds(self) -> None:
        self._seconds_chosen = False
        if self.occasion is not None:
            blocked = self.seconds.blockSignals(True)
            self.seconds.setValue(self.occasion.seconds)
            self.seconds.blockSignals(blocked)

    def _show(self) -> None:
        occasion = self.occasion
        self._box.setCurrentIndex(self._box.findData(self._source))
        self._box.say(self._file_name if self._source == FILE else _SOURCES[self._source][0])
        self._tasks.setCurrentIndex(self._tasks.findData(self._task))
        self._tasks.say(_TASKS[self._task][0])
        self._tasks.setVisible(self._source != SCRIPT)
        words = _sentence(occasion.words) if occasion else "Open a robot first."
        self._note.setText(words if self._source == SCRIPT or not occasion else f"{words} {_LEFT_OUT}")


def _sentence(words: str) -> str:
    return f"{words[:1].upper()}{words[1:]}."
