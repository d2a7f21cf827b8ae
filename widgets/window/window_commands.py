"""The commands about the window itself: what of it is shown, in which theme, its picture, its help, its end."""

from __future__ import annotations

from importlib.metadata import version

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QDockWidget, QMainWindow

from app.cli.commands.guide import find_page
from app.core.errors import DisplayError
from widgets.actions.registry import shortcuts_html
from widgets.actions.table import MOUSE_GESTURES
from widgets.common.guide_window import GuideWindow
from widgets.context.app_context import AppContext
from widgets.window.window_picture import save_window_picture

_PACKAGES = ("tactile-maps", "mujoco", "libigl", "pyvista", "PySide6-Essentials", "numpy")


class WindowCommands(QObject):
    """Binds them.

    Args:
        context: What the presenters have too.
        window: What is commanded.
        panels: Right of the views.
        bottom: Below the views.
    """

    def __init__(self, context: AppContext, window: QMainWindow, panels: QDockWidget, bottom: QDockWidget) -> None:
        super().__init__(window)
        self._context, self._window, self._docks = context, window, {"panels": panels, "plots": bottom}
        self._guide: GuideWindow | None = None
        for name, handler in (
            ("save_picture", self.choose_picture_file),
            ("quit", window.close),
            ("theme", self.toggle_theme),
            ("panels", self._show_docks),
            ("plots", self._show_docks),
            ("reset_layout", self.reset_layout),
            ("full_screen", self.toggle_full_screen),
            ("guide", self.show_guide),
            ("keys", self.tell_keys),
            ("about", self.tell_about),
        ):
            context.actions.bind(name, handler)
        for name in self._docks:
            context.actions[name].setChecked(True)

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

    def show_panels(self) -> None:
        """Show the panels."""
        self._context.actions["panels"].setChecked(True)
        self._show_docks()

    def reset_layout(self) -> None:
        """The window as it first was."""
        for name in self._docks:
            self._context.actions[name].setChecked(True)
        self._show_docks()
        self._context.views.level()

    def toggle_full_screen(self) -> None:
        """The whole screen, or not."""
        full = self._context.actions["full_screen"].isChecked()
        (self._window.showFullScreen if full else self._window.showNormal)()

    def show_guide(self) -> None:
        """Open the guide beside the window; asked for again, it comes to the front at the page it was left at."""
        if self._guide is None:
            self._guide = GuideWindow(find_page("index"), self._window)
        self._guide.show()
        self._guide.activateWindow()

    def tell_keys(self) -> None:
        """List keys and gestures."""
        keys = shortcuts_html(self._context.actions.specs, MOUSE_GESTURES)
        self._context.dialogs.tell("keys", "Keys", keys)

    def tell_about(self) -> None:
        """Name versions."""
        versions = "<br>".join(f"{name} {version(name)}" for name in _PACKAGES)
        text = f"A robot's skin beside its live tactile map.<br><br>{versions}"
        self._context.dialogs.tell("about", "About Tactile Maps", text)
