"""The Touch menu: what a hand did becomes a script, a script becomes touch, and a known load is weighed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog

from app.core.errors import TactileMapsError
from app.simulation.known_load_check import WeighingResult
from app.stimuli.stimulus_file import load_stimuli, save_stimuli
from widgets.common.file_types import SCRIPT_FILTER
from widgets.workers.cost_worker import MASS

if TYPE_CHECKING:
    from widgets.window.main_window import MainWindow


class TouchScriptPresenter(QObject):
    """Connects the Touch menu's actions to what they do.

    Args:
        window: The window, with its actions, session, message bar and loading bar made.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window, self._live = window, window.live
        for name, act in (
            ("save_script", self.choose_save),
            ("play_script", self.choose_play),
            ("weigh", self.weigh),
        ):
            window.action(name).triggered.connect(act)
        self._live.mode_changed.connect(self._on_mode_changed)
        cost_worker, bar = self._live.cost_worker, window.loading_bar
        cost_worker.weighing.connect(self._on_weighing)
        cost_worker.weighed.connect(self._on_weighed)
        cost_worker.failed.connect(bar.clear)
        cost_worker.dropped.connect(bar.clear)
        bar.cancelled.connect(cost_worker.cancel_weighing)
        self._on_mode_changed(self._live.mode)

    def choose_save(self) -> None:
        """Ask where to keep what the hand did since the reset; say so where it did nothing."""
        if not self._live.touches():
            self._window.notification_bar.say("There is nothing to save yet: press the skin first.")
            return
        path, _ = QFileDialog.getSaveFileName(self._window, "Save script", "touches.toml", SCRIPT_FILTER)
        if path:
            self.save(path if Path(path).suffix else f"{path}.toml")

    def save(self, path: str) -> None:
        """Keep what the hand did since the reset as a script."""
        try:
            stimuli = self._live.touches()
            save_stimuli(stimuli, path)
        except TactileMapsError as error:
            self._window.notification_bar.say(str(error), fault=True)
        else:
            touches = "1 touch" if len(stimuli) == 1 else f"{len(stimuli)} touches"
            self._window.notification_bar.say(f"Saved {touches} to {path}")

    def choose_play(self) -> None:
        """Ask for a script."""
        path, _ = QFileDialog.getOpenFileName(self._window, "Play script", "", f"{SCRIPT_FILTER};;All files (*)")
        if path:
            self.play(path)

    def play(self, path: str) -> None:
        """Start the scene again, with its effects as they were chosen, touched as a script says."""
        prepared, scene = self._live.prepared, self._window.effects_presenter.scene
        if prepared is None or scene is None:
            return
        try:
            stimuli = load_stimuli(path)
        except TactileMapsError as error:
            self._window.notification_bar.say(str(error), fault=True)
            return
        self._live.show_prepared(replace(prepared, scene=replace(scene, stimuli=stimuli)))

    def weigh(self) -> None:
        """Lay a known load on a copy of the scene beside, and say what it reads."""
        prepared, scene = self._live.prepared, self._window.effects_presenter.scene
        if prepared is not None and scene is not None and not self._live.cost_worker.busy_weighing:
            self._live.cost_worker.weigh(prepared, scene.effects)

    def _on_weighing(self) -> None:
        self._window.loading_bar.show_progress(f"Weighing {MASS:g} kg", None)

    def _on_weighed(self, weighed: WeighingResult) -> None:
        self._window.loading_bar.clear()
        self._window.notification_bar.say(
            f"{MASS:g}\u2009kg reads {weighed.read_N:.3f}\u2009N (wanted {weighed.wanted_N:.3f}\u2009N), "
            f"with {weighed.model} on {weighed.patch}"
        )

    def _on_mode_changed(self, mode: str) -> None:
        for name in ("save_script", "play_script", "weigh"):
            self._window.action(name).setEnabled(mode in ("live", "paused"))
