"""What the window can do to lead the arm: connects the tools for path and target to actions, session and views."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, get_args

from PySide6.QtCore import QObject, Signal

from app.control.command import PathKind
from app.editing.document import MapDocument
from widgets.control_tools.force_plate import ForcePlate
from widgets.control_tools.lead import Lead
from widgets.control_tools.path_tool import PathTool
from widgets.control_tools.target_tool import TargetTool
from widgets.edit_tool import EditTool
from widgets.tools import Tool

if TYPE_CHECKING:
    from widgets.main_window import MainWindow


class Leading(QObject):
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
        self._window, self.lead = window, Lead(self)
        self._path, self._force = PathTool(self.lead, self), ForcePlate(self.lead)
        self.tools: dict[Tool, EditTool] = {Tool.PATH: self._path, Tool.TARGET: TargetTool(self.lead, self)}
        live, lead = window.live, self.lead
        lead.wished.connect(live.set_settings)
        lead.told.connect(self._on_told)
        lead.changed.connect(self._dress)
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
        self._dress()

    @property
    def can_undo(self) -> bool:
        """Whether there is anything to take back."""
        lead = self.lead
        return lead.enabled and (self._path.drawing or bool(lead.gesture or lead.undo_name))

    @property
    def can_redo(self) -> bool:
        """Whether anything that was taken back can be done again."""
        return self.lead.enabled and bool(self.lead.redo_name) and not self._path.drawing

    def undo(self) -> None:
        """Take back the last corner of what is drawn, or the last step."""
        if self._path.drawing:
            self._path.take_back()
        else:
            self.lead.undo()

    def redo(self) -> None:
        """Do again what was taken back last."""
        self.lead.redo()

    def _choose_shape(self, kind: PathKind, _checked: bool = False) -> None:
        """The next path is drawn so, and the one in force is taken so."""
        self.lead.do("choose the path's shape", law=self.lead.settings.law, path_kind=kind)

    def _turn_force(self, steps: int, _checked: bool = False) -> None:
        self._force.turn(steps)

    def _on_mode_changed(self, mode: str) -> None:
        self.lead.set_enabled(enabled=mode in ("live", "paused"))

    def _on_shown(self, document: MapDocument) -> None:
        if not self._window.editor.gesture:
            self.lead.show_map(document.map)

    def _on_told(self, text: str) -> None:
        self._window.statusBar().showMessage(text, 5_000)

    def _dress(self) -> None:
        """Enable what can be done, and check the shape in force."""
        lead, action = self.lead, self._window.action
        enabled = lead.enabled and lead.map is not None
        for name in (*(tool.value for tool in self.tools), "more_force", "less_force"):
            action(name).setEnabled(enabled)
        for kind in get_args(PathKind):
            action(f"path_{kind}").setEnabled(enabled)
        action(f"path_{lead.settings.path_kind}").setChecked(True)
        action("clear_path").setEnabled(enabled and bool(lead.settings.path))
