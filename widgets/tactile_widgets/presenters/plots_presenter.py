"""Plots: choosing, storing and exporting them, and jumping to the time of a click."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import chain, count
from pathlib import Path

import numpy as np
from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import ExportError, SkinError
from tactile_maps.core.files import write_atomically
from tactile_widgets.common.tool_kinds import SelectionMode
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.dialogs.plot_chooser import PlotChooser
from tactile_widgets.document.taxel_search import find_taxels
from tactile_widgets.document.taxel_selection import SelectionUpdate
from tactile_widgets.panels.touch.events_panel import EventsPanel
from tactile_widgets.plots.choice.plot_choice import PlotChoice, PlotKey, PlotKind, TaxelGroup
from tactile_widgets.plots.timeline.lanes import OVER_A_RECORDING

_MOST_TAXELS = 20
"""Maximum number of taxels listed for a search text."""


class PlotsPresenter(Presenter):
    """Implements the actions for plots.

    Args:
        context: Session, views, panels and services of the window.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._plots = context.plots
        self.chooser: PlotChooser | None = None
        context.actions.bind(
            choose_plots=self.ask,
            automatic_plots=self._plots.show_called_for,
            export_plots=self.save_table,
        )
        self._plots.offer([context.actions[name] for name in ("choose_plots", "export_plots")])
        self._plots.choose(PlotChoice.from_text(context.settings.plots))
        self._plots.choice_changed.connect(self._on_choice_changed)
        self._plots.time_clicked.connect(self.go_to)
        self._plots.taxel_clicked.connect(self.select_taxel)
        context.recording_plots.taxel_chosen.connect(self.select_taxel)
        context.panels.get(EventsPanel).event_clicked.connect(self.go_to)
        context.session.prepared_changed.connect(self._show_choice)

    def close(self) -> None:
        """Store the shown plots and the positions of their windows."""
        self._context.settings.plots = self._plots.choice.to_text()
        if self.chooser is not None:
            self.chooser.close()

    # Choosing.

    def ask(self) -> None:
        """Show the list of all plots, or bring it to the front."""
        if self.chooser is None:
            self.chooser = PlotChooser(self._find_taxels, self._window)
            self.chooser.toggled.connect(self._on_toggled)
            self.chooser.automatic_toggled.connect(self._on_automatic_requested)
            self.chooser.finished.connect(self._on_chooser_closed)
        self._show_choice()
        self.chooser.show()
        self.chooser.activateWindow()
        self.chooser.field.setFocus()

    def plot(self, key: PlotKey) -> None:
        """Show a plot, and the area of the plots."""
        self._show_plots(key)
        self._plots.add_plot(key)

    def ask_group(self, taxels: Sequence[int]) -> None:
        """Ask for a name of a group of taxels, then plot the force on them and their pressure."""
        text = f"Name of these {len(taxels)} taxels:"
        name = f"{len(taxels)} taxels"
        used = {key.title for key in self._plots.choice.order}
        name = next(one for one in chain((name,), (f"{name} ({n})" for n in count(2))) if f"Force on {one}" not in used)
        then = partial(self._plot_group, tuple(taxels))
        self._context.dialogs.ask_text("group-name", "Plot this group", text, then, value=name)

    def _plot_group(self, taxels: tuple[int, ...], name: str) -> None:
        if name.strip():
            group = TaxelGroup(name.strip(), taxels).text
            for kind in (PlotKind.GROUP_FORCE, PlotKind.GROUP_PRESSURE):
                self.plot(PlotKey(kind, group))

    def _show_plots(self, key: PlotKey) -> None:
        """Show the plots, instead of the curves of a whole recording unless those include this plot."""
        actions = self._context.actions
        replaying = self._session.replay.player is not None
        if not actions["plots"].isChecked():
            actions["plots"].trigger()
        if replaying and actions["whole_recording"].isChecked() and key.kind not in OVER_A_RECORDING:
            actions["whole_recording"].trigger()

    def _on_toggled(self, key: PlotKey, on: bool) -> None:
        if on:
            self.plot(key)
        else:
            self._plots.remove_plot(key)

    def _on_automatic_requested(self, on: bool) -> None:
        if on:
            self._plots.show_called_for()
        else:
            self._plots.keep_standard()

    def _on_chooser_closed(self) -> None:
        self.chooser = None

    def _on_choice_changed(self) -> None:
        self._context.settings.plots = self._plots.choice.to_text()
        self._show_choice()

    def _show_choice(self, _changed: object = None) -> None:
        if self.chooser is not None:
            choice = self._plots.choice
            self.chooser.offer(self._plots.offered, self._plots.shown_keys, automatic=choice.chosen is None)

    def _find_taxels(self, text: str) -> list[PlotKey]:
        prepared = self._session.prepared
        if prepared is None:
            return []
        try:
            found = find_taxels(prepared.skin, text)
        except SkinError:
            return []
        return [PlotKey(PlotKind.TAXEL, str(taxel)) for taxel in found.taxels[:_MOST_TAXELS].tolist()]

    def go_to(self, seconds: float) -> None:
        """Show the time of a clicked plot or event in a recording."""
        session = self._session
        notifier = self._notifier
        if session.replay.player is None:
            notifier.status(f"Time {seconds:.2f}\u202fs; in a recording, a click goes to that time")
            return
        self._context.timeline.go_to(seconds - float(session.replay.player.times[0]))

    def select_taxel(self, taxel: int) -> None:
        """Select the taxel of a row that was clicked."""
        self._context.views.selection.take(SelectionUpdate(np.array([taxel]), SelectionMode.REPLACE))

    def save_table(self, keys: Sequence[PlotKey] | None = None) -> None:
        """Ask for a file, and write the samples of these plots, or of all shown plots."""
        name = "plots.csv" if keys is None else f"{keys[0].title.lower().replace(' ', '-')}.csv"
        table = self._plots.table(keys)  # before the dialog opens, while which time passes
        path = self._context.dialogs.save_file("Export plots", name, "CSV (*.csv)")
        if path:
            with self._notifier.errors_shown("save plots"):
                write_atomically(Path(path), table.encode(), error=ExportError)
                self._notifier.say(f"Saved {path}")
