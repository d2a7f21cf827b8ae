"""Figures for papers: asks for content and size, stores the choice, and writes the file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtWidgets import QWidget

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import DisplayError, TactileMapsError
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.dialogs.figures.figure_dialog import FigureDialog
from tactile_widgets.dialogs.figures.figure_file import FIGURE_KINDS, FigureColours, FigurePart, FigureSpec
from tactile_widgets.dialogs.figures.plot_figure import (
    plots_spec,
    recording_spec,
    write_plot_figure,
    write_recording_figure,
)
from tactile_widgets.dialogs.figures.view_figure import ShownInViews, left_out_text, write_view_figure
from tactile_widgets.plots.choice.plot_choice import PlotKey


class FigurePresenter(Presenter):
    """Implements *Save figure*.

    Args:
        context: Session, views, panels and services of the window.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._settings = ControlSettings()
        self._plots: Sequence[PlotKey] | None = None
        self.dialog: FigureDialog | None = None
        context.session.settings_changed.connect(self._on_settings_changed)
        context.actions.bind(save_figure=self.ask)

    def ask(self, plots: Sequence[PlotKey] | None = None) -> None:
        """Ask for content and size; starts with the last choice, or with these plots."""
        part, spec = read_choice(self._context.settings.figure)
        self._plots = plots
        if self.dialog is None:
            self.dialog = FigureDialog(self._context.theme.theme, self.check, self._window)
            self.dialog.requested.connect(self._on_requested)
            self.dialog.finished.connect(self._on_closed)
        self.dialog.show_choice(part if plots is None else FigurePart.PLOTS, spec)
        self.dialog.open()

    def _on_closed(self) -> None:
        self.dialog = None

    def _on_settings_changed(self, settings: ControlSettings) -> None:
        self._settings = settings

    def _on_requested(self, part: FigurePart, spec: FigureSpec) -> None:
        self._context.settings.figure = choice_text(part, spec)
        path = self._context.dialogs.save_file("Save figure", f"{part.value}.pdf", ";;".join(FIGURE_KINDS.values()))
        if path:
            self.write(part, Path(path), spec)

    def write(self, part: FigurePart, path: Path, spec: FigureSpec) -> None:
        """Write the present content; show the result."""
        with self._notifier.errors_shown("save figure"):
            left_out = self.save(part, path, spec)
            words = f"Saved {path}: {spec.width:g} × {spec.height:g}\u202fmm, {spec.dpi}\u202fdpi"
            self._notifier.say(". ".join(filter(None, (words, left_out_text(left_out)))))

    def save(self, part: FigurePart, path: Path, spec: FigureSpec) -> tuple[str, ...]:
        """Write the present content; return the texts that are left out of a small figure.

        Raises:
            DisplayError: No robot is open, plots are not read yet or do not fit, or the file cannot be written.
        """
        context = self._context
        if part is FigurePart.PLOTS:
            if self._of_recording:
                write_recording_figure(context.recording_plots, path, spec)
            else:
                write_plot_figure(context.plots, self._keys, path, spec)
            return ()
        if self._session.prepared is None:
            raise DisplayError("no robot is open", remedy="Open a robot or a scene first")
        document = context.editor.document if context.editor.enabled else None
        shown = ShownInViews(context.views, self._session.prepared, document, self._settings, self._session.shown)
        return write_view_figure(shown, part, path, spec)

    def check(self, part: FigurePart, spec: FigureSpec) -> None:
        """Check the size of a figure.

        Raises:
            DisplayError: The figure is too small for the plots.
        """
        if part is FigurePart.PLOTS and self._of_recording:
            recording_spec(self._context.recording_plots, spec)
        elif part is FigurePart.PLOTS:
            plots_spec(self._context.plots, self._keys, spec)

    @property
    def _of_recording(self) -> bool:
        """Whether the plots are those of a whole recording."""
        replaying = self._session.replay.player is not None
        return self._plots is None and replaying and self._context.settings.whole_recording

    @property
    def _keys(self) -> Sequence[PlotKey]:
        return self._context.plots.shown_keys if self._plots is None else self._plots


def choice_text(part: FigurePart, spec: FigureSpec) -> str:
    """Return the text for the settings file."""
    return f"{part.value} {spec.width:g} {spec.height:g} {spec.dpi} {spec.colours.value}"


def read_choice(text: str) -> tuple[FigurePart, FigureSpec]:
    """Read the text of the settings file; return the default for an unknown text."""
    try:
        part, width, height, dpi, colours = text.split()
        return FigurePart(part), FigureSpec(float(width), float(height), int(dpi), FigureColours(colours))
    except (ValueError, TactileMapsError):
        return FigurePart.VIEWS, FigureSpec()
