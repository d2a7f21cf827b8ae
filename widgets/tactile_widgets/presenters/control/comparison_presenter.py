"""Comparison of controllers: runs it on the stimuli of the session, and applies a chosen controller."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtWidgets import QWidget

from tactile_maps.control.controller_registry import has_task
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import RecordingError, TactileMapsError
from tactile_maps.core.files import write_atomically
from tactile_maps.scene.scene import Scene
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.studies.controller_comparison import ControllerTrace, trace_csv, with_fields
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.controller_settings import GAIN_SETTINGS
from tactile_widgets.common.file_dialogs import RECORDING_FILTER
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.dialogs.controller_comparison.comparison_run import run_comparison
from tactile_widgets.dialogs.controller_comparison.comparison_view import ComparisonDialog, ComparisonView
from tactile_widgets.jobs.executor import Job
from tactile_widgets.panels.control.controller_panel import ControllerPanel
from tactile_widgets.presenters.session.effects_presenter import EffectsPresenter
from tactile_widgets.session.comparison_stimulus import ComparisonStimulus, read_stimulus

CSV_FILTER = "Table (*.csv)"
_DIED = "The comparison ended unexpectedly; earlier results are kept. Run it again, for fewer seconds."


class ComparisonPresenter(Presenter):
    """Controls the window of the comparison, created at first use.

    Args:
        context: Session, views, panels and services of the window.
        effects: Scene with the chosen effects.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, effects: EffectsPresenter, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._effects = effects
        self._panel = context.panels.get(ControllerPanel)
        self.executor = context.backends.executor("compare controllers", self)
        self.dialog: ComparisonDialog | None = None
        self._scene: Scene | None = None  # shown when the comparison was started
        self._panel.comparison_requested.connect(self.open)
        context.actions.bind(compare_controllers=self.open)
        context.theme.changed.connect(self._on_theme_changed)
        self._session.prepared_changed.connect(self._on_prepared_changed)

    @property
    def board(self) -> ComparisonView | None:
        """Content of the window; None before it was first opened."""
        return self.dialog.board if self.dialog is not None else None

    def open(self) -> None:
        """Show the window with the current stimuli of the session."""
        first = self.dialog is None
        if self.dialog is None:
            self.dialog = ComparisonDialog(self._context.theme.theme, self._window)
            board = self.dialog.board
            board.run_requested.connect(self.run)
            board.cancelled.connect(self._on_cancelled)
            board.stimulus.recording_requested.connect(self.choose_recording)
            board.stimulus.refresh_requested.connect(self._refresh)
            board.used.connect(self.use)
            board.export_requested.connect(self.choose_export)
            board.begin(_first_two(self._panel.settings))
        self._refresh()
        if first:
            self.dialog.board.stimulus.begin()
        self.dialog.show()
        self.dialog.activateWindow()

    def run(self) -> None:
        """Run the contenders on the current stimulus."""
        board = self.board
        if board is None:
            return
        self._refresh()
        occasion = board.stimulus.occasion
        if occasion is None:
            return
        assert self._session.prepared is not None
        self._scene = self._session.prepared.scene
        task = self._panel.settings
        contenders = tuple(replace(one, settings=with_controller(task, one.settings)) for one in board.contenders)
        self.executor.close()
        self._on_progressed("starting", 0.0)
        seconds = board.stimulus.seconds.value()
        job = Job(run_comparison, occasion, contenders, seconds, board.stimulus.own_task, died=_DIED)
        self.executor.start(job, self._on_compared, self._on_failed, progressed=self._on_progressed)

    def choose_recording(self) -> None:
        """Ask for a recording, and use it as stimulus."""
        path = self._context.dialogs.open_file("Stimulus from a recording", RECORDING_FILTER, over=self.dialog)
        if path:
            self.read_stimulus(path)

    def read_stimulus(self, path: str) -> None:
        """Use a recording as stimulus; one that cannot be read changes nothing."""
        self.executor.close()
        self._on_reading("starting", 0.0)
        job = Job(read_stimulus, Path(path), died=_DIED)
        self.executor.start(job, partial(self._on_read, path), self._on_failed, progressed=self._on_reading)

    def use(self, settings: ControlSettings) -> None:
        """Apply controller and gains of a contender; task and goals stay."""
        self._panel.take(with_controller(self._panel.settings, settings))

    def choose_export(self) -> None:
        """Ask for a file, and write the traces."""
        path = self._context.dialogs.save_file("Export traces", "controllers.csv", CSV_FILTER, over=self.dialog)
        if path:
            self.export(path)

    def export(self, path: str) -> None:
        """Write all traces as CSV."""
        board = self.board
        if board is None:
            return
        try:
            write_atomically(Path(path), trace_csv(board.traces), error=RecordingError)
        except TactileMapsError as error:
            board.show_failed(str(error))
        else:
            self._notifier.say(f"Saved {path}", of="compare controllers")

    def _on_prepared_changed(self, prepared: PreparedScene) -> None:
        """Drop results, or stop the comparison, if another scene is shown than when it was started."""
        if self.board is not None and self._scene is not None and prepared.scene != self._scene:
            self._scene = None
            self.executor.close()
            self.board.drop_results()

    def _on_theme_changed(self, theme: Theme) -> None:
        if self.board is not None:
            self.board.set_theme(theme)

    def close(self) -> None:
        """Cancel the comparison and close the window."""
        self.executor.close()
        if self.dialog is not None:
            self.dialog.close()

    def _refresh(self) -> None:
        if self.board is not None:
            scene = self._effects.scene
            self.board.stimulus.show_live(self._session.done(), self._session.scripted(scene) if scene else None)

    def _on_progressed(self, text: str, fraction: float) -> None:
        if self.board is not None:
            self.board.show_progress(text, fraction)

    def _on_reading(self, _text: str, fraction: float) -> None:
        if self.board is not None:
            self.board.show_reading(fraction)

    def _on_read(self, path: str, stimulus: ComparisonStimulus) -> None:
        self.executor.close()
        self._context.dialogs.remember_opened(path)
        if self.board is not None:
            self.board.show_stimulus(stimulus)

    def _on_compared(self, traces: tuple[ControllerTrace, ...]) -> None:
        self.executor.close()
        if self.board is not None:
            self.board.show_compared(traces)

    def _on_failed(self, text: str) -> None:
        self.executor.close()
        if self.board is not None:
            self.board.show_failed(text)

    def _on_cancelled(self) -> None:
        self.executor.close()
        if self.board is not None:
            self.board.rest()


def with_controller(settings: ControlSettings, controller: ControlSettings) -> ControlSettings:
    """Return settings with the controller and gains of other settings."""
    return with_fields(settings, controller, ("controller", *GAIN_SETTINGS))


def _first_two(settings: ControlSettings) -> tuple[ControlSettings, ControlSettings]:
    """Return the current settings, and the same with another controller."""
    first = settings if has_task(settings.controller) else replace(settings, controller="hybrid")
    return first, replace(first, controller="qp" if first.controller != "qp" else "hybrid")
