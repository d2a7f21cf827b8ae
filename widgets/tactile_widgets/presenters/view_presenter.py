"""Menus Select and View: tools, selection, overlays and cameras."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from tactile_maps.core.arrays import IntArray
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.common.panel import Panel
from tactile_widgets.common.settings import BaseLayer, OverlayOptions
from tactile_widgets.common.tool_kinds import ToolKind
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.document.taxel_search import SEARCH_HINT, find_taxels
from tactile_widgets.panels.model.effects_panel import EffectsPanel
from tactile_widgets.panels.model.timing_panel import TimingPanel
from tactile_widgets.panels.registry import PanelTab
from tactile_widgets.tools.map_editing.interest_tool import InterestTool
from tactile_widgets.tools.registry import Tools
from tactile_widgets.views.layers import LAYERS

_HINT_MS = 15_000


class ViewPresenter(Presenter):
    """Implements the actions of the menus Select and View.

    Args:
        context: Session, views, panels and services of the window.
        tools: Tools of the views.
        parent: Window over which dialogs open.
    """

    panels_requested = Signal()
    """The panels must be shown."""

    def __init__(self, context: AppContext, tools: Tools, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._views = context.views
        self._tools = tools
        self._bind()
        tools.changed.connect(self._on_tool_changed)
        self._show(context.settings.overlays or self._views.overlays)

    def _bind(self) -> None:
        bind = self._context.actions.bind
        selection = self._views.selection
        for tool in self._tools.specs:
            bind(**{tool.kind.name: partial(self._tools.take, tool.kind)})
        for layer in BaseLayer:
            bind(**{f"ground_{layer.value}": partial(self.set_base_layer, layer)})
        for spec in LAYERS:
            bind(**{f"mark_{spec.name}": partial(self.toggle_layer, spec.name)})
        bind(
            smaller_brush=partial(self._resize_brush, -1),
            larger_brush=partial(self._resize_brush, 1),
            select_all=self._select_all,
            select_none=self._select_none,
            select_inverse=selection.invert,
            find_taxel=self._ask_for_taxel,
            morph=self._views.robot.morph.toggle,
            frame=self._views.frame_all,
            show_bodies=partial(self._views.robot.hide_bodies, frozenset()),
            timing=partial(self._reveal, self._context.panels.get(TimingPanel)),
            effects=partial(self._reveal, self._context.panels.get(EffectsPanel)),
        )

    def _ask_for_taxel(self) -> None:
        self._context.dialogs.ask_text("find-taxel", "Find taxel", f"Taxel ({SEARCH_HINT})", self.find_taxel)

    def find_taxel(self, text: str) -> None:
        """Select and show the taxels that ``text`` names, or report that they do not exist."""
        prepared = self._views.robot.display.prepared
        if prepared is None:
            return
        with self._notifier.errors_shown("find taxel"):
            found = find_taxels(prepared.skin, text)
            self._views.show_taxels(found.taxels)
            self._notifier.status(f"Found {found.words}{self._hidden_words(prepared.skin, found.taxels)}")

    def _hidden_words(self, skin: Skin, taxels: IntArray) -> str:
        """Return a note about hidden patches of the taxels; empty if all are shown."""
        document = self._context.editor.document
        if document is None or document.skin is not skin:
            return ""
        numbers = np.unique(skin.patch_of[taxels]).tolist()
        hidden = [skin.patches[number].name for number in numbers if not document.patches[number].visible]
        return f"; hidden on the map: {', '.join(hidden)} (Edit > Show all patches)" if hidden else ""

    def _select_all(self) -> None:
        """Select every taxel, or every patch while an editing tool is used."""
        editor = self._context.editor
        if self._tools.active.edits and editor.document is not None:
            editor.select(range(len(editor.document.patches)))
        else:
            self._views.selection.select_all()

    def _select_none(self) -> None:
        if self._tools.active.edits:
            self._context.editor.select(())
        else:
            self._views.selection.clear()

    def set_base_layer(self, layer: BaseLayer) -> None:
        """Choose the base layer."""
        self._show(replace(self._views.overlays, base=layer))

    def toggle_layer(self, name: str) -> None:
        """Show or hide a layer."""
        self._show(self._views.overlays.toggled(name))

    def _show(self, overlays: OverlayOptions) -> None:
        self._context.settings.overlays = overlays
        self._views.set_overlays(overlays)

    def set_tool(self, tool: ToolKind) -> None:
        """Select a tool."""
        self._tools.take(tool)

    def _on_tool_changed(self, tool: ToolKind) -> None:
        self._views.set_tool(tool)
        if tool.edits:
            self._context.panels.show_tab(PanelTab.MAP)
        taken = self._tools.view_tool
        self._views.set_view_tool(taken)
        self._notifier.status("" if taken is None else taken.hint, _HINT_MS)

    def _resize_brush(self, steps: int) -> None:
        """Change the size of the brush that selects taxels and paints areas of interest."""
        self._views.resize_brush(steps)
        self._tools.get(InterestTool).set_radius(self._views.brush)

    def _reveal(self, panel: Panel) -> None:
        """Show a panel."""
        self.panels_requested.emit()
        self._context.panels.reveal(panel)
