"""The Control menu's laws and tasks: the controller panel by keys, and the comparison of laws."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from app.control.command import ControlSettings
from app.control.laws import RULES
from widgets.colours import Theme
from widgets.law_comparison.comparer import Comparer
from widgets.law_comparison.comparing import Comparing
from widgets.panels.controller_choices import CHOICES, LAWS

if TYPE_CHECKING:
    from widgets.main_window import MainWindow

TASKS = CHOICES["task"][1]


class Controlling(QObject):
    """Connects the actions of laws, tasks and gains to the controller panel, which decides.

    Args:
        window: With its actions, session and column made.
        make_comparer: What runs laws side by side.
    """

    def __init__(self, window: MainWindow, make_comparer: Callable[[QObject], Comparer]) -> None:
        super().__init__(window)
        self._window, self._panel = window, window.column.controller
        self.comparing = Comparing(window, make_comparer)
        for law in LAWS:
            window.action(f"law_{law}").triggered.connect(partial(self._panel.choose_law, law))
        for task in TASKS:
            window.action(f"task_{task}").triggered.connect(partial(self._panel.choose_task, task))
        window.action("start_again").triggered.connect(self._panel.start_again)
        window.action("reset_gains").triggered.connect(self._panel.reset_gains)
        window.live.settings_changed.connect(self._on_settings_changed)
        window.live.mode_changed.connect(self._on_mode_changed)
        self._on_mode_changed(window.live.mode)

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self.comparing.set_theme(theme)

    def close(self) -> None:
        """End what runs beside."""
        self.comparing.close()

    def _on_settings_changed(self, settings: ControlSettings) -> None:
        self._window.action(f"law_{settings.law}").setChecked(True)
        self._window.action(f"task_{settings.task}").setChecked(True)
        self._dress(settings)

    def _on_mode_changed(self, _mode: str) -> None:
        self._dress(self._panel.settings)

    def _dress(self, settings: ControlSettings) -> None:
        """What cannot be done now is grey: nothing while a recording is replayed, no task for a law without one."""
        mode = self._window.live.mode
        on, has_task = mode in ("live", "paused"), settings.law in RULES
        for name, enabled in (
            *((f"law_{law}", on) for law in LAWS),
            *((f"task_{task}", on and has_task) for task in TASKS),
            ("start_again", on and self._panel.can_start_again),
            ("reset_gains", on),
            ("compare_laws", mode != "empty"),
        ):
            self._window.action(name).setEnabled(enabled)
