"""Preferences: their dialog, and their effects."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import RecordingError, TactileMapsError
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.settings import Preferences, usual_recordings_folder
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.dialogs.preferences_dialog import PreferencesDialog
from tactile_widgets.panels.control.posture_panel import PosturePanel
from tactile_widgets.session.recording_writer import IN_PREFERENCES, make_recording_folder


class PreferencesPresenter(Presenter):
    """Applies the stored preferences, and changes that the user makes in the dialog.

    The folder of recordings and the questions are read from the settings where they are needed.

    Args:
        context: Session, views, panels and services of the window.
        parent: Window over which dialogs open.

    Attributes:
        dialog: The open dialog; None while it is closed.
    """

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        super().__init__(context, parent)
        self.dialog: PreferencesDialog | None = None
        context.actions.bind(preferences=self.show)
        context.theme.changed.connect(self._on_theme_changed)
        self._apply(context.settings.preferences)

    def show(self) -> None:
        """Open the dialog, or bring it to the front."""
        if self.dialog is None:
            self.dialog = PreferencesDialog(self._context.settings.preferences, usual_recordings_folder(), self._window)
            self.dialog.changed.connect(self.use)
            self.dialog.folder_requested.connect(self._choose_folder)
            self.dialog.folder_entered.connect(self._enter_folder)
            self.dialog.finished.connect(self._on_closed)
        self.dialog.show()
        self.dialog.activateWindow()

    def use(self, preferences: Preferences) -> None:
        """Store preferences and apply them."""
        theme = self._context.theme
        changes_theme = preferences.theme != theme.theme.name
        self._context.settings.preferences = preferences
        self._apply(preferences)
        if changes_theme:
            theme.use(preferences.theme)

    def _apply(self, preferences: Preferences) -> None:
        views = self._context.views
        if preferences.navigation is not views.navigation:
            views.set_navigation(preferences.navigation)
        views.robot.display.set_frame_rate(preferences.frame_rate)
        self._context.panels.get(PosturePanel).set_angles(radians=preferences.radians)

    def _choose_folder(self) -> None:
        folder = self._context.dialogs.open_folder("Folder of recordings")
        if folder and self._enter_folder(folder):
            self._context.dialogs.remember_opened(folder)

    def _enter_folder(self, text: str) -> bool:
        """Use a folder, which is made if it does not exist; return False and show the current one if that fails."""
        folder = Path(text).expanduser()
        if not text:
            self._use_folder("")
            return True
        try:
            if not folder.is_absolute():
                raise RecordingError(
                    "recordings need a complete path", value=text, remedy="Begin at the root or with ~"
                )
            make_recording_folder(folder)
        except TactileMapsError as error:
            self._use_folder(self._context.settings.preferences.recordings)
            if self.dialog is not None:
                self.dialog.show_problem(str(error).replace(IN_PREFERENCES, ""))
            return False
        self._use_folder(str(folder))
        return True

    def _use_folder(self, folder: str) -> None:
        if self.dialog is not None:
            chosen = replace(self._context.settings.preferences, recordings=folder)
            self.dialog.show_problem("")
            self.dialog.show_preferences(chosen)
            self.use(chosen)

    def _on_theme_changed(self, _theme: Theme) -> None:
        if self.dialog is not None:
            self.dialog.show_preferences(self._context.settings.preferences)

    def _on_closed(self) -> None:
        self.dialog = None
