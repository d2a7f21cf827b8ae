"""What the window can do to see and select: connects tools, selection and overlays to actions, settings and words."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QLabel

from widgets.actions.registry import add_view_shortcuts
from widgets.common.settings import MARKS, BaseLayer, OverlayOptions
from widgets.common.tool_kinds import ToolKind

if TYPE_CHECKING:
    from widgets.window.main_window import MainWindow


class ViewPresenter(QObject):
    """The commands of the Select menu and of View > Overlay.

    Args:
        window: The window, with its actions, views and status bar made.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window, self._views = window, window.views
        add_view_shortcuts(self._views, window.actions_by_name)
        self._count = QLabel()
        self._count.setObjectName("selection-count")
        self._count.setContentsMargins(12, 0, 12, 0)
        window.statusBar().addWidget(self._count)
        self._connect_selection()
        window.action(ToolKind.POKE.value).setChecked(True)
        self._connect_overlays()
        self._show(window.settings.overlays)

    def _connect_selection(self) -> None:
        selection = self._views.selection
        for tool in ToolKind:
            self._window.action(tool.value).triggered.connect(partial(self.set_tool, tool))
        for name, act in (
            ("smaller_brush", self.shrink_brush),
            ("larger_brush", self.grow_brush),
            ("select_all", self._select_all),
            ("select_none", self._select_none),
            ("select_inverse", selection.invert),
        ):
            self._window.action(name).triggered.connect(act)
        self._window.action("morph").triggered.connect(self._views.robot.morph.toggle)
        selection.changed.connect(self._on_selection_changed)

    def _select_all(self) -> None:
        """Every taxel, or with a tool that edits every patch."""
        editor = self._window.editor
        if self._views.tool.edits and editor.document is not None:
            editor.select(range(len(editor.document.patches)))
        else:
            self._views.selection.select_all()

    def _select_none(self) -> None:
        if self._views.tool.edits:
            self._window.editor.select(())
        else:
            self._views.selection.clear()

    def _connect_overlays(self) -> None:
        for ground in BaseLayer:
            self._window.action(f"ground_{ground.value}").triggered.connect(partial(self.set_ground, ground))
        for name in MARKS:
            self._window.action(f"mark_{name}").triggered.connect(partial(self.toggle_mark, name))

    def set_ground(self, ground: BaseLayer, _checked: bool = False) -> None:
        """Show another ground under the touch."""
        self._show(replace(self._views.overlays, ground=ground))

    def toggle_mark(self, name: str, _checked: bool = False) -> None:
        """Show or hide one kind of marks, as its action now says."""
        shown = self._window.action(f"mark_{name}").isChecked()
        self._show(self._views.overlays.with_mark(name, shown=shown))

    def _show(self, overlays: OverlayOptions) -> None:
        self._window.settings.overlays = overlays
        self._views.set_overlays(overlays)
        self._window.action(f"ground_{overlays.ground.value}").setChecked(True)
        for name in MARKS:
            self._window.action(f"mark_{name}").setChecked(getattr(overlays, name))

    def set_tool(self, tool: ToolKind, _checked: bool = False) -> None:
        """Take a tool."""
        self._window.action(tool.value).setChecked(True)
        self._views.set_tool(tool)
        self._window.map_edit_presenter.take_tool(tool)

    def shrink_brush(self) -> None:
        """A smaller brush."""
        self._resize_brush(-1)

    def grow_brush(self) -> None:
        """A larger brush."""
        self._resize_brush(1)

    def _resize_brush(self, steps: int) -> None:
        self._views.resize_brush(steps)
        self._window.map_edit_presenter.set_brush(self._views.brush)

    def _on_selection_changed(self) -> None:
        taxels = self._views.selection.taxels
        words = f"{len(taxels)} taxels selected" if len(taxels) != 1 else f"Taxel {taxels[0]} selected"
        self._count.setText(words if len(taxels) else "")
