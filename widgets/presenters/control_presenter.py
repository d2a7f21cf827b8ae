"""The Control menu: tools for path and target, the contact force, and the choice of controller, task and gains.

``ControlToolsPresenter`` connects the tools that set path, target and force to actions, session and views;
``ControlPresenter`` connects the actions of controllers, tasks and gains to the controller panel, which decides.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, get_args

from PySide6.QtCore import QObject, Signal

from app.control.command import ControlSettings
from app.control.controllers import CONTROL_SCHEMES
from app.editing.document import MapDocument
from app.maps.paths import PathKind
from widgets.common.colours import Theme
from widgets.common.controller_settings import CONTROLLERS, SETTING_CHOICES
from widgets.common.tool_kinds import ToolKind
from widgets.interaction.view_tool import ViewTool
from widgets.presenters.comparison_presenter import ComparisonPresenter
from widgets.tools.control_settings_editor import ControlSettingsEditor
from widgets.tools.control_tool import ForceHandle
from widgets.tools.path_tool import PathTool
from widgets.tools.target_tool import TargetTool
from widgets.workers.comparison_worker import ComparisonWorker

if TYPE_CHECKING:
    from widgets.window.main_window import MainWindow


class ControlToolsPresenter(QObject):
    """The commands of the Control menu.

    Args:
        window: The window, with its actions, views, editor and session made.

    Attributes:
        lead: Whom the tools ask.
        tools: By what takes them.
    """

    undo_changed = Signal()
    """What can be taken back or done again may be something else."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window, self.settings_editor = window, ControlSettingsEditor(self)
        self._path, self._force = PathTool(self.settings_editor, self), ForceHandle(self.settings_editor)
        self.tools: dict[ToolKind, ViewTool] = {
            ToolKind.PATH: self._path,
            ToolKind.TARGET: TargetTool(self.settings_editor, self),
        }
        live, lead = window.live, self.settings_editor
        lead.wished.connect(live.set_settings)
        lead.told.connect(self._on_told)
        lead.changed.connect(self._update_state)
        for signal in (lead.changed, self._path.drawn):
            signal.connect(self.undo_changed)
        live.settings_changed.connect(lead.show_settings)
        live.settings_changed.connect(window.views.show_settings)
        live.mode_changed.connect(self._on_mode_changed)
        window.editor.shown.connect(self._on_shown)
        for name, act in (
            ("clear_path", lead.clear_path),
            ("more_force", partial(self._turn_force, 1)),
            ("less_force", partial(self._turn_force, -1)),
            *((f"path_{kind}", partial(self._choose_shape, kind)) for kind in get_args(PathKind)),
        ):
            window.action(name).triggered.connect(act)
        self._update_state()

    @property
    def can_undo(self) -> bool:
        """Whether there is anything to take back."""
        lead = self.settings_editor
        return lead.enabled and (self._path.drawing or bool(lead.gesture or lead.undo_name))

    @property
    def can_redo(self) -> bool:
        """Whether anything that was taken back can be done again."""
        return self.settings_editor.enabled and bool(self.settings_editor.redo_name) and not self._path.drawing

    def undo(self) -> None:
        """Take back the last corner of what is drawn, or the last step."""
        if self._path.drawing:
            self._path.take_back()
        else:
            self.settings_editor.undo()

    def redo(self) -> None:
        """Redo what was undone last."""
        self.settings_editor.redo()

    def _choose_shape(self, kind: PathKind, _checked: bool = False) -> None:
        """The next path is drawn so, and the one in force is taken so."""
        self.settings_editor.do(
            "choose the path's shape", controller=self.settings_editor.settings.controller, path_kind=kind
        )

    def _turn_force(self, steps: int, _checked: bool = False) -> None:
        self._force.turn(steps)

    def _on_mode_changed(self, mode: str) -> None:
        self.settings_editor.set_enabled(enabled=mode in ("live", "paused"))

    def _on_shown(self, document: MapDocument) -> None:
        if not self._window.editor.gesture:
            self.settings_editor.show_map(document.map)

    def _on_told(self, text: str) -> None:
        self._window.statusBar().showMessage(text, 5_000)

    def _update_state(self) -> None:
        """Enable what can be done, and check the shape in force."""
        lead, action = self.settings_editor, self._window.action
        enabled = lead.enabled and lead.map is not None
        for name in (*(tool.value for tool in self.tools), "more_force", "less_force"):
            action(name).setEnabled(enabled)
        for kind in get_args(PathKind):
            action(f"path_{kind}").setEnabled(enabled)
        action(f"path_{lead.settings.path_kind}").setChecked(True)
        action("clear_path").setEnabled(enabled and bool(lead.settings.path))


TASKS = SETTING_CHOICES["task"][1]


class ControlPresenter(QObject):
    """Connects the actions of controllers, tasks and gains to the controller panel, which decides.

    Args:
        window: With its actions, session and column made.
        make_comparer: What runs controllers side by side.
    """

    def __init__(self, window: MainWindow, make_comparer: Callable[[QObject], ComparisonWorker]) -> None:
        super().__init__(window)
        self._window, self._panel = window, window.column.controller
        self.comparison = ComparisonPresenter(window, make_comparer)
        for controller in CONTROLLERS:
            window.action(f"controller_{controller}").triggered.connect(
                partial(self._panel.choose_controller, controller)
            )
        for task in TASKS:
            window.action(f"task_{task}").triggered.connect(partial(self._panel.choose_task, task))
        window.action("start_again").triggered.connect(self._panel.start_again)
        window.action("reset_gains").triggered.connect(self._panel.reset_gains)
        window.live.settings_changed.connect(self._on_settings_changed)
        window.live.mode_changed.connect(self._on_mode_changed)
        self._on_mode_changed(window.live.mode)

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self.comparison.set_theme(theme)

    def close(self) -> None:
        """End what runs beside."""
        self.comparison.close()

    def _on_settings_changed(self, settings: ControlSettings) -> None:
        self._window.action(f"controller_{settings.controller}").setChecked(True)
        self._window.action(f"task_{settings.task}").setChecked(True)
        self._update_state(settings)

    def _on_mode_changed(self, _mode: str) -> None:
        self._update_state(self._panel.settings)

    def _update_state(self, settings: ControlSettings) -> None:
        """Disable what cannot be done now: all while a recording is replayed, tasks for a controller without one."""
        mode = self._window.live.mode
        on, has_task = mode in ("live", "paused"), settings.controller in CONTROL_SCHEMES
        for name, enabled in (
            *((f"controller_{controller}", on) for controller in CONTROLLERS),
            *((f"task_{task}", on and has_task) for task in TASKS),
            ("start_again", on and self._panel.can_start_again),
            ("reset_gains", on),
            ("compare_controllers", mode != "empty"),
        ):
            self._window.action(name).setEnabled(enabled)
