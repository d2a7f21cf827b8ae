"""Actions of the window itself: docks, theme, picture, help and quitting."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version

from PySide6.QtCore import QObject, Qt
from PySide6.QtWidgets import QDockWidget, QMainWindow, QMenu

from tactile_maps.cli.commands.guide import find_page
from tactile_widgets.actions.keymap import RESERVED, KeyMap
from tactile_widgets.actions.keys_sheet import KeysSheet
from tactile_widgets.actions.registry import key_rows, taken_by_menus
from tactile_widgets.actions.table import mouse_gestures
from tactile_widgets.common.guide_window import GuidePlace, GuideWindow
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.dialogs.palette import CommandPalette
from tactile_widgets.plots.choice.plot_choice import PlotChoice
from tactile_widgets.window.palette_commands import (
    ListFiller,
    action_commands,
    listed_commands,
    panel_commands,
    setting_commands,
)
from tactile_widgets.window.panel_docks import PanelDocks
from tactile_widgets.window.tour import Tour
from tactile_widgets.window.window_picture import save_window_picture

_PACKAGES = ("tactile-maps", "mujoco-core", "libigl", "pyvista", "PySide6-Essentials", "numpy")


class WindowCommands(QObject):
    """Implements the actions.

    Args:
        context: Session, views, panels and services of the window.
        window: The window.
        panels: Dock at the right of the views.
        bottom: Dock below the views.
        docks: Undocked panels and layouts.
    """

    def __init__(
        self, context: AppContext, window: QMainWindow, panels: QDockWidget, bottom: QDockWidget, docks: PanelDocks
    ) -> None:
        super().__init__(window)
        self._panel_docks = docks
        self._context = context
        self._window = window
        self._docks = {"panels": panels, "plots": bottom}
        self._guide: GuideWindow | None = None
        self._sheet: KeysSheet | None = None
        self.palette: CommandPalette | None = None
        self.tour = Tour(context, window, self.show_panels)
        self._lists: Mapping[str, ListFiller] = {}
        self._menus: dict[str, QMenu] = {}
        context.actions.bind(
            save_picture=self.choose_picture_file,
            quit=window.close,
            theme=self.toggle_theme,
            panels=self._show_docks,
            plots=self._show_docks,
            reset_layout=self.reset_layout,
            full_screen=self.toggle_full_screen,
            tour=self.start_tour,
            guide=self.show_guide,
            keys=self.show_keys,
            palette=self.open_palette,
            about=self.show_about,
        )
        for name in self._docks:
            context.actions[name].setChecked(True)
        docks.arranged.connect(self._on_arranged)

    def choose_picture_file(self) -> None:
        """Ask for a file, and save a picture of the window."""
        path = self._context.dialogs.save_file("Save picture", "tactile-maps.png", "PNG (*.png)")
        if path:
            with self._context.notifier.errors_shown("save picture"):
                save_window_picture(self._window, path)
                self._context.notifier.say(f"Saved {path}")

    def toggle_theme(self) -> None:
        """Switch between dark and light."""
        self._context.theme.use("light" if self._context.theme.theme.name == "dark" else "dark")

    def _show_docks(self) -> None:
        for name, dock in self._docks.items():
            dock.setVisible(self._context.actions[name].isChecked())

    def _on_arranged(self) -> None:
        for name, dock in self._docks.items():
            self._context.actions[name].setChecked(not dock.isHidden())

    def show_panels(self) -> None:
        """Show the panels."""
        self._context.actions["panels"].setChecked(True)
        self._show_docks()

    def reset_layout(self) -> None:
        """Restore the first arrangement of the window."""
        self._panel_docks.reset()
        for name in self._docks:
            self._context.actions[name].setChecked(True)
        self._show_docks()
        self._window.resizeDocks([self._docks["plots"]], [1], Qt.Orientation.Vertical)
        self._context.views.level()
        self._context.plots.choose(PlotChoice())

    def toggle_full_screen(self) -> None:
        """Switch full screen on or off."""
        full = self._context.actions["full_screen"].isChecked()
        (self._window.showFullScreen if full else self._window.showNormal)()

    def start_tour(self) -> None:
        """Start the tour, which replaces the first hints."""
        self._context.notifier.hints_dismissed.emit()
        self.tour.start()

    def show_guide(self) -> None:
        """Open the guide, or bring it to the front at its current page."""
        if self._guide is None:
            self._guide = GuideWindow(find_page("index"), self._window)
        self._guide.show()
        self._guide.activateWindow()

    def show_panel_guide(self, place: GuidePlace) -> None:
        """Open the guide at the description of a panel."""
        self.show_guide()
        if self._guide is not None:
            self._guide.show_page(find_page(place.page), place.heading)

    def show_keys(self) -> None:
        """Open the list of gestures and keys, or bring it to the front."""
        if self._sheet is None:
            actions = self._context.actions
            reserved = {**RESERVED, **taken_by_menus(actions.menus)}
            gestures = mouse_gestures(self._context.views.navigation)
            self._sheet = KeysSheet(gestures, key_rows(actions.menus), actions.keymap, reserved, self._window)
            self._sheet.keys_changed.connect(self._on_keys_changed)
            self._sheet.finished.connect(self._on_sheet_closed)
        self._sheet.show()
        self._sheet.activateWindow()
        self._sheet.search.setFocus()

    def _on_keys_changed(self, keymap: KeyMap) -> None:
        self._context.actions.use_keys(keymap)
        self._context.settings.keys = keymap.changes

    def _on_sheet_closed(self) -> None:
        self._sheet = None

    def _on_palette_closed(self) -> None:
        self.palette = None

    def offer_lists(self, lists: Mapping[str, ListFiller]) -> None:
        """Add listed menus such as ``scenes``, ``robots`` and ``recent`` to the palette."""
        self._lists = lists
        self._menus = {name: QMenu(self._window) for name in lists}

    def open_palette(self) -> None:
        """Open the palette with all commands."""
        self.palette = CommandPalette(self._window)
        self.palette.finished.connect(self._on_palette_closed)
        self.palette.ask(
            [
                *action_commands(self._context.actions),
                *panel_commands(self._context.panels, self.show_panels),
                *setting_commands(self._context.panels, self.show_panels),
                *listed_commands(self._menus, self._lists),
            ]
        )

    def show_about(self) -> None:
        """Show the versions of the program and its libraries."""
        versions = "<br>".join(f"{name} {version(name)}" for name in _PACKAGES)
        text = f"A robot's skin next to its live tactile map.<br><br>{versions}"
        self._context.dialogs.show_text("about", "About Tactile Maps", text)
