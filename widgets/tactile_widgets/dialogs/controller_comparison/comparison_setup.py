"""Settings of a comparison: controllers with their gains, stimulus, task and duration."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import (
    QDoubleSpinBox,
    QLabel,
    QToolButton,
    QWidget,
)

from tactile_maps.control.controller_registry import CONTROLLERS, effective_settings
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.studies.controller_comparison import MOST_SECONDS
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.controller_settings import GAIN_SETTINGS, SLIDERS, ControllerSliders
from tactile_widgets.common.make import (
    add_items,
    caption_label,
    column_layout,
    make,
    push_button,
    row_layout,
    select_data,
)
from tactile_widgets.common.number_field import guard_wheel
from tactile_widgets.common.panel import FlatComboBox
from tactile_widgets.common.sentence import as_sentence
from tactile_widgets.dialogs.controller_comparison.comparison_plots import LineSample
from tactile_widgets.session.comparison_stimulus import ComparisonStimulus

_SHORTEST = 8
"""Visible letters of a controller's name; the tool tip shows the whole name."""


class ContenderCard(QWidget):
    """Controller and gains of a contender; the task cannot be changed here."""

    edited = Signal()
    """The user changed the controller or its gains."""
    removed = Signal(str)
    """Letter of the contender that the user removes."""

    def __init__(self, letter: str, settings: ControlSettings, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.letter = letter
        self.setObjectName(f"contender-{letter}")
        self._stroke = LineSample(letter, theme, self)
        self._controller = make(
            FlatComboBox,
            self,
            objectName=f"contender-controller-{letter}",
            accessibleName=f"Controller of {letter}",
            minimumContentsLength=_SHORTEST,
            activated=self._on_controller_chosen,
        )
        add_items(self._controller, ((entry.title, name, entry.tip) for name, entry in CONTROLLERS.items()))
        tip = f"Show the gains of {letter}"
        gains = self._gains = push_button(self, f"contender-gains-{letter}", "Gains", tip, checkable=True)
        tip = f"Leave {letter} out"
        remove = self._remove = make(
            QToolButton,
            self,
            text="×",
            objectName=f"contender-remove-{letter}",
            accessibleName=tip,
            toolTip=tip,
            clicked=self._on_remove_clicked,
        )
        self.sliders = ControllerSliders([name for name in GAIN_SETTINGS if name in SLIDERS], self)
        self.sliders.hide()
        self.sliders.settings_edited.connect(self._edit)
        gains.toggled.connect(self.sliders.setVisible)
        name = QLabel(f"<b>{letter}</b>", self)
        row = row_layout(name, self._stroke, self._controller, gains, remove, stretch=self._controller)
        column_layout(row, self.sliders, parent=self)
        self.show_settings(settings)

    @property
    def settings(self) -> ControlSettings:
        """Chosen controller and gains."""
        return self._settings

    @property
    def title(self) -> str:
        """Letter and controller, for legends."""
        return f"{self.letter}: {CONTROLLERS[self._settings.controller].title}"

    def set_theme(self, theme: Theme) -> None:
        """Use another theme."""
        self._stroke.set_theme(theme)

    def set_removable(self, removable: bool) -> None:
        """Show or hide the button that removes it; two contenders must remain."""
        self._remove.setVisible(removable)

    def show_settings(self, settings: ControlSettings) -> None:
        """Show a controller and its gains."""
        self._settings = settings
        select_data(self._controller, settings.controller)
        entry = CONTROLLERS[settings.controller]
        self._controller.say(entry.title)
        self._controller.setToolTip(f"{entry.title}: {entry.tip}")
        self.sliders.show_settings(settings)
        self._gains.setEnabled(any(name in effective_settings(settings) for name in self.sliders.by_name))

    def _edit(self, settings: ControlSettings) -> None:
        self.show_settings(settings)
        self.edited.emit()

    def _on_controller_chosen(self, row: int) -> None:
        self._edit(replace(self._settings, controller=self._controller.itemData(row)))

    def _on_remove_clicked(self) -> None:
        self.removed.emit(self.letter)


DONE = "done"
SCRIPT = "script"
FILE = "file"
_SOURCES = {
    DONE: ("Session since the last reset", "All pokes, edits and settings since then, tick by tick"),
    SCRIPT: ("The scene's own script", "The scripted stimuli, from the scene's start"),
    FILE: ("A recording…", "The inputs of a recording of any scene"),
}
_TASKS = {
    "recorded": ("Task of the stimulus", "Task, path and force goal come with the stimulus"),
    "own": ("Current task", "All controllers do the current task; changes of the force goal are kept"),
}
NO_STIMULUS = "No stimulus to compare controllers on: open a robot, or choose a recording."
_LEFT_OUT = "Its changes of controller and gains are ignored; each controller keeps its own."


class StimulusChoice(QWidget):
    """Choice of the stimulus, the task and the duration."""

    changed = Signal()
    """The user chose another stimulus, task or duration."""
    occasion_changed = Signal()
    """``occasion`` may have changed, by the user or with the session."""
    recording_requested = Signal()
    """The user chooses a recording; the receiver asks for its file and calls ``take_recording``."""
    refresh_requested = Signal()
    """The user updates the stimulus of the session; the receiver calls ``show_live``."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._known: dict[str, ComparisonStimulus] = {}
        self._source = DONE
        self._task = "recorded"
        self._file_name = ""
        self._seconds_chosen = False
        self._box = make(
            FlatComboBox, self, objectName="stimulus", accessibleName="Stimulus", activated=self._on_source_chosen
        )
        self._tasks = make(
            FlatComboBox, self, objectName="stimulus-task", accessibleName="Task", activated=self._on_task_chosen
        )
        for box, words in ((self._box, _SOURCES), (self._tasks, _TASKS)):
            add_items(box, ((text, value, tip) for value, (text, tip) in words.items()))
        self._note = caption_label(self, "stimulus-note")
        tip = "Duration for each controller; a longer stimulus is cut off"
        self.seconds = make(
            QDoubleSpinBox,
            self,
            minimum=0.1,
            maximum=MOST_SECONDS,
            decimals=1,
            suffix="\u202fs",
            accessibleName="Seconds",
            toolTip=tip,
            valueChanged=self._on_seconds_changed,
        )
        guard_wheel(self.seconds)
        tip = "Use all inputs of the session until now"
        self.refresh = push_button(self, "stimulus-refresh", "Update", tip, self._on_refresh)
        name = make(QLabel, "For", self, buddy=self.seconds)
        row = row_layout(name, self.seconds, self.refresh, stretch=self.seconds)
        column_layout(self._box, self._note, self._tasks, row, parent=self)
        self._show()

    @property
    def occasion(self) -> ComparisonStimulus | None:
        """Chosen stimulus; None if it does not exist yet."""
        return self._known.get(self._source)

    @property
    def own_task(self) -> bool:
        """Whether the contenders do the current task."""
        return self._source == SCRIPT or self._task == "own"

    def show_live(self, done: ComparisonStimulus | None, script: ComparisonStimulus | None) -> None:
        """Take the stimuli of the session: all inputs until now, and the script of its scene."""
        for source, occasion in ((DONE, done), (SCRIPT, script)):
            self._known.pop(source, None)
            if occasion is not None:
                self._known[source] = occasion
        if not self._seconds_chosen:
            self._take_seconds()
        self._show()

    def begin(self) -> None:
        """Choose the initial stimulus: the inputs of the session if they contain a touch, otherwise the script."""
        done = self._known.get(DONE)
        self._source = DONE if done is not None and done.touches else SCRIPT
        self._take_seconds()
        self._show()

    def take_recording(self, stimulus: ComparisonStimulus) -> None:
        """Take the stimulus of a recording."""
        self._known[FILE] = stimulus
        self._file_name = stimulus.file
        self._take(FILE)

    def _on_refresh(self) -> None:
        self._seconds_chosen = False
        self.refresh_requested.emit()
        self.changed.emit()

    def _on_source_chosen(self, row: int) -> None:
        source = self._box.itemData(row)
        if source != FILE:
            self._take(source)
            return
        self._show()  # the previous choice, until the recording is read
        self.recording_requested.emit()

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
            with QSignalBlocker(self.seconds):
                self.seconds.setValue(self.occasion.seconds)

    def _show(self) -> None:
        occasion = self.occasion
        select_data(self._box, self._source)
        self._box.say(self._file_name if self._source == FILE else _SOURCES[self._source][0])
        select_data(self._tasks, self._task)
        self._tasks.say(_TASKS[self._task][0])
        self._tasks.setVisible(self._source != SCRIPT)
        self.refresh.setEnabled(self._source == DONE)
        words = f"{as_sentence(occasion.words)}." if occasion else NO_STIMULUS
        self._note.setText(words if self._source == SCRIPT or not occasion else f"{words} {_LEFT_OUT}")
        self.occasion_changed.emit()
