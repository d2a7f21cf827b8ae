"""Context of the presenters: session and documents, views and panels, messages and dialogs."""

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
    """The current theme, stored in the settings.

    Args:
        settings: Settings that store it.
        parent: Qt parent.

    Attributes:
        theme: The current theme.
    """

    changed = Signal(Theme)
    """The current Theme."""

    def __init__(self, settings: Settings, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._settings = settings
        self.theme: Theme = THEMES[settings.theme]

    def use(self, name: str) -> None:
        """Apply the theme ``dark`` or ``light``."""
        self.theme = THEMES[name]
        self._settings.theme = name
        apply_theme(QApplication.instance(), self.theme)  # type: ignore[arg-type]
        self.changed.emit(self.theme)


@dataclass(frozen=True, eq=False)
class AppContext:
    """Everything that a presenter may use; it has no access to the window.

    Attributes:
        session: The only code that changes the running session.
        editor: The only code that changes the map document.
        notes: The only code that changes the annotations of a recording.
        views: Robot view and map view.
        panels: The column of panels next to the views.
        plots: The current plots below the views.
        recording_plots: The plots of a whole recording, shown instead of the current plots.
        timeline: The timeline of a recording.
        actions: All actions of the window.
        notifier: Shows messages.
        dialogs: Opens dialogs.
        settings: Settings stored between launches.
        backends: Factories of runners, writers and executors.
        theme: The current theme.
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
