"""The commands about the window itself: what of it is shown, in which theme, its picture, its help, its end."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QDockWidget, QMainWindow, QMenu

from tactile_maps.cli.commands.guide import find_page
from tactile_maps.core.errors import DisplayError
from tactile_widgets.actions.keymap import RESERVED, KeyMap
from tactile_widgets.actions.keys_sheet import KeysSheet
from tactile_widgets.actions.registry import key_rows, taken_by_menus
from tactile_widgets.actions.table import MOUSE_GESTURES
from tactile_widgets.common.guide_window import GuidePlace, GuideWindow
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.dialogs.palette import CommandPalette
from tactile_widgets.plots.choice.plot_choice import PlotChoice
from tactile_widgets.window.palette_commands import ListFiller, action_commands, listed_commands, setting_commands
from tactile_widgets.window.panel_docks import PanelDocks
from tactile_widgets.window.tour import Tour
from tactile_widgets.window.window_picture import save_window_picture

_PACKAGES = ("tactile-maps", "mujoco-core", "libigl", "pyvista", "PySide6-Essentials", "numpy")


class WindowCommands(QObject):
    """Binds them.

    Args:
        context: What the presenters have too.
        window: What is commanded.
        panels: Right of the views.
        bottom: Below the views.
        docks: The panels in windows of their own.
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
        for name, handler in (
            ("save_picture", self.choose_picture_file),
            ("quit", window.close),
            ("theme", self.toggle_theme),
            ("panels", self._show_docks),
            ("plots", self._show_docks),
            ("reset_layout", self.reset_layout),
            ("full_screen", self.toggle_full_screen),
            ("tour", self.start_tour),
            ("guide", self.show_guide),
            ("keys", self.tell_keys),
            ("palette", self.ask_command),
            ("about", self.tell_about),
        ):
            context.actions.bind(name, handler)
        for name in self._docks:
            context.actions[name].setChecked(True)
        docks.arranged.connect(self._on_arranged)

    def choose_picture_file(self) -> None:
        """Ask where to save a picture of the window."""
        path = self._context.dialogs.save_file("Save picture", "tactile-maps.png", "PNG (*.png)")
        if path:
            try:
                save_window_picture(self._window, path)
            except DisplayError as error:
                self._context.notifier.fault(str(error))
            else:
                self._context.notifier.say(f"Saved {path}")

    def toggle_theme(self) -> None:
        """Dark or light."""
        self._context.theme.use("light" if self._context.theme.theme.name == "dark" else "dark")

    def _show_docks(self) -> None:
        """As their actions say."""
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
        """The window as it first was."""
        self._panel_docks.reset()
        for name in self._docks:
            self._context.actions[name].setChecked(True)
        self._show_docks()
        self._context.views.level()
        self._context.plots.choose(PlotChoice())

    def toggle_full_screen(self) -> None:
        """The whole screen, or not."""
        full = self._context.actions["full_screen"].isChecked()
        (self._window.showFullScreen if full else self._window.showNormal)()

    def start_tour(self) -> None:
        """Begin it; whoever takes it needs the first hints no more."""
        self._context.notifier.hints_dismissed.emit()
        self.tour.start()

    def show_guide(self) -> None:
        """Open the guide beside the window; asked for again, it comes to the front at the page it was left at."""
        if self._guide is None:
            self._guide = GuideWindow(find_page("index"), self._window)
        self._guide.show()
        self._guide.activateWindow()

    def tell_of_panel(self, place: GuidePlace) -> None:
        """Open the guide where it says what a panel is."""
        self.show_guide()
        if self._guide is not None:
            self._guide.show_page(find_page(place.page), place.heading)

    def tell_keys(self) -> None:
        """List gestures and keys beside the window, to be changed; asked for again, the list comes to the front."""
        if self._sheet is None:
            actions = self._context.actions
            taken = {**RESERVED, **taken_by_menus(actions.menus)}
            self._sheet = KeysSheet(MOUSE_GESTURES, key_rows(actions.menus), actions.keymap, taken, self._window)
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
        """The palette offers what these list too: ``scenes``, ``robots`` and ``recent``."""
        self._lists = lists
        self._menus = {name: QMenu(self._window) for name in lists}

    def ask_command(self) -> None:
        """Offer everything that can be asked for."""
        self.palette = CommandPalette(self._window)
        self.palette.finished.connect(self._on_palette_closed)
        self.palette.ask(
            [
                *action_commands(self._context.actions),
                *setting_commands(self._context.panels, self.show_panels),
                *listed_commands(self._menus, self._lists),
            ]
        )

    def tell_about(self) -> None:
        """Name versions."""
        versions = "<br>".join(f"{name} {version(name)}" for name in _PACKAGES)
        text = f"A robot's skin beside its live tactile map.<br><br>{versions}"
        self._context.dialogs.show_text("about", "About Tactile Maps", text)
