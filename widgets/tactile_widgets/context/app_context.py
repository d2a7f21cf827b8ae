"""What every presenter is given, instead of the window: the owners of change, what shows, and the ways to speak."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QApplication

from tactile_widgets.actions.registry import ActionRegistry
from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.common.colours import THEMES, Theme
from tactile_widgets.common.settings import Settings
from tactile_widgets.context.notifier import Notifier
from tactile_widgets.dialogs.dialogs import Dialogs
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.document.recording_notes import RecordingNotes
from tactile_widgets.panels.panel_column import PanelColumn
from tactile_widgets.plots.live_plots import LivePlots
from tactile_widgets.plots.timeline.recording_plots import RecordingPlots
from tactile_widgets.plots.timeline.timeline import Timeline
from tactile_widgets.session.backends import Backends
from tactile_widgets.session.session_host import SessionHost
from tactile_widgets.views.linked_views import LinkedViews


class ThemeHolder(QObject):
    """The theme in force, remembered in the settings.

    Args:
        settings: Where it is remembered.
        parent: Qt parent.

    Attributes:
        theme: In force.
    """

    changed = Signal(Theme)
    """Another theme applies."""

    def __init__(self, settings: Settings, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._settings = settings
        self.theme: Theme = THEMES[settings.theme]

    def use(self, name: str) -> None:
        """Take ``dark`` or ``light``."""
        self.theme = THEMES[name]
        self._settings.theme = name
        apply_theme(QApplication.instance(), self.theme)  # type: ignore[arg-type]
        self.changed.emit(self.theme)


@dataclass(frozen=True, eq=False)
class AppContext:
    """All that a presenter may reach; it never sees the window.

    Attributes:
        session: The only caller that changes the running session.
        editor: The only caller that changes the map document.
        notes: The only caller that changes what is said of a recording.
        views: Robot and map.
        panels: The column beside them.
        plots: The curves below them.
        recording_plots: The curves over a whole recording, in their place.
        timeline: Of a recording.
        actions: Everything a person can ask for.
        notifier: Says what happened.
        dialogs: Asks.
        settings: What is remembered between launches.
        backends: What does the work beside.
        theme: The colours in force.
    """

    session: SessionHost
    editor: MapEditor
    notes: RecordingNotes
    views: LinkedViews
    panels: PanelColumn
    plots: LivePlots
    recording_plots: RecordingPlots
    timeline: Timeline
    actions: ActionRegistry
    notifier: Notifier
    dialogs: Dialogs
    settings: Settings
    backends: Backends
    theme: ThemeHolder
