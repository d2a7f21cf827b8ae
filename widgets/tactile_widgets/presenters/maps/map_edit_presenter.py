"""Menu Edit: connects map editor, tools, actions, files and views."""

from __future__ import annotations

from functools import partial
from weakref import WeakSet

from PySide6.QtWidgets import QWidget

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.history import History
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.path_on_body import share_off_skin
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.mode import Mode
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.context.proposal_bar import ProposalBar
from tactile_widgets.panels.maps.compare_panel import ComparePanel
from tactile_widgets.panels.maps.patches_panel import PatchesPanel
from tactile_widgets.presenters.maps.map_file_presenter import MapFilePresenter
from tactile_widgets.tools.map_editing.arrange_tool import ArrangeTool
from tactile_widgets.tools.map_editing.pin_tool import PinTool
from tactile_widgets.tools.map_editing.seam_tool import SeamTool
from tactile_widgets.tools.registry import SEAMS, Tools

_OFF_SKIN = 0.01
"""Share of a path that may get off the skin without a message."""
_COMPARED = "Maps and drawings (*.npz *.json *.csv *.tsv *.txt *.ini *.urdf *.xml)"


class MapEditPresenter(Presenter):
    """Implements the actions of the menu Edit, and passes the document to views and session.

    Args:
        context: Session, views, panels and services of the window.
        tools: Tools of the views.
        files: File of the map.
        parent: Window over which dialogs open.

    Attributes:
        proposal: Bar with the proposed edit.
    """

    def __init__(self, context: AppContext, tools: Tools, files: MapFilePresenter, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._views = context.views
        self._editor = context.editor
        self._tools = tools
        self._files = files
        self._pins = tools.get(PinTool)
        self._seams = tools.get(SeamTool)
        self.proposal = ProposalBar(context.theme.theme, context.views.map)
        self._overlapping: tuple[str, ...] = ()
        self._histories: WeakSet[History] = WeakSet()
        self._off_skin = 0.0, 0.0  # shares of the path off the skin before and after the last edit
        self._connect()
        self._bind()

    def _connect(self) -> None:
        editor = self._editor
        live = self._session
        panels = self._context.panels
        editor.shown.connect(self._on_shown)
        editor.settled.connect(self._on_settled)
        editor.failed.connect(partial(self._notifier.fault, of="edit map"))
        editor.history_changed.connect(partial(self._notifier.succeed, "edit map"))
        editor.history_changed.connect(self._report_overlaps)
        editor.history_changed.connect(self._report_path)
        editor.notified.connect(self._notifier.status)
        editor.proposal_changed.connect(self._on_proposal_changed)
        self.proposal.accepted.connect(editor.accept)
        self.proposal.declined.connect(editor.decline)
        self._context.theme.changed.connect(self.proposal.set_theme)
        compare = panels.get(ComparePanel)
        measurements = live.measurements
        compare.files_requested.connect(self._choose_compared)
        compare.compare_requested.connect(measurements.compare)
        compare.shown_other.connect(self._on_shown_other)
        measurements.compared.connect(compare.show_comparison)
        measurements.map_failed.connect(compare.show_failed)
        for gestures in self._views.interactions:
            gestures.hovered.connect(self._on_hovered)
        panels.get(PatchesPanel).patch_actions.repack_unneeded.connect(self._on_repack_unneeded)
        panels.get(PatchesPanel).hovered.connect(self._tools.get(ArrangeTool).point_at)
        live.replay.map_changed.connect(self._on_map_changed)
        live.mode_changed.connect(self._on_mode_changed)

    def _bind(self) -> None:
        patches = self._context.panels.get(PatchesPanel).patch_actions
        self._context.actions.bind(
            undo=lambda: self._tools.undo_stack.undo(),
            redo=lambda: self._tools.undo_stack.redo(),
            add_pin=self._add_pin,
            remove_pin=self._pins.remove,
            select_pins=self._pins.select_pinned,
            propose_seam=self._propose,
            mirror=patches.mirror.trigger,
            true_size=patches.true_size.trigger,
            repack=patches.repack.trigger,
            hide_patches=patches.hide.trigger,
            show_patches=patches.show_all.trigger,
            cancel_edit=self._editor.cancel_work,
            compare=self._toggle_other,
        )
        self._context.actions.bind(**{f"align_{edge}": action.trigger for edge, action in patches.align.items()})

    # The document.

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Edit the map of another scene. After a replay, the document that was edited before is shown again.

        When a recording is continued, the edits that its map has by then are one step, which can be undone.
        """
        patches = self._context.panels.get(PatchesPanel)
        if self._session.replay.player is not None or self._session.run is None:
            patches.show_recorded(MapDocument.of(prepared.map))
            return
        patches.show_recorded(None)
        document = self._editor.document
        if document is not None and document.skin is prepared.map.skin:
            self._session.edit_map(document.map, "")
            self._session.measurements.measure(document.map)
            self._on_shown(document)
            return
        if self._files.show_skin(prepared):
            return
        self._files.end()
        first = MapDocument.of(prepared.map)
        map_ = self._session.run.map
        edits = None if map_ is prepared.map else ("Recorded edits", MapDocument.of(map_))
        own = self._files.own_map(prepared, first) if edits is None else None
        self._editor.open(first, edits=edits if own is None else ("Open map", own))
        self._files.begin(prepared, first, own)

    def _report_overlaps(self) -> None:
        """Name the patches that overlap others after an edit, and offer to arrange them; only when they change."""
        picture = self._views.map.picture
        names = () if picture is None else picture.overlapping
        if names == self._overlapping:
            return
        self._overlapping = names
        if names:
            text = f"These patches overlap on the map: {', '.join(names)}."
            self._notifier.say(text, fault=True, remedies=[self._context.actions["repack"]], of="arrange patches")
        else:
            self._notifier.succeed("arrange patches")

    def _on_repack_unneeded(self) -> None:
        """State why *Repack* moved nothing, and offer to arrange all patches if it was about some of them."""
        document = self._editor.document
        assert document is not None
        patches = document.patches
        chosen = self._editor.selected
        text = "The patches are already arranged as on the body."
        if len(chosen) == 1:
            text = f"{patches[chosen[0]].name} stays in place: it overlaps no other patch."
        elif chosen:
            text = "The selected patches stay in place: they are already arranged and overlap no other patch."
        some = 0 < len(chosen) < len(patches)
        repack_all = self._context.panels.get(PatchesPanel).patch_actions.repack_all
        self._notifier.say(text, remedies=[repack_all] if some else [], of="repack")

    def _on_map_changed(self, map_: TactileMap) -> None:
        """Show a recorded edit in a replay, and measure the map with it."""
        document = MapDocument.of(map_)
        self._views.show_document(document)
        self._context.panels.get(PatchesPanel).show_recorded(document)
        self._session.measurements.measure(map_)

    def _on_mode_changed(self, mode: Mode) -> None:
        self._editor.set_enabled(enabled=mode.takes_input)

    def _on_shown(self, document: MapDocument) -> None:
        self._views.show_document(document, in_gesture=self._editor.gesture)

    def _on_settled(self, document: MapDocument, name: str) -> None:
        self._session.edit_map(document.map, name, self._carried_settings(document.map))
        self._session.measurements.measure(document.map)

    def _carried_settings(self, after: TactileMap) -> ControlSettings | None:
        """Return the controller settings with the path at the same place on the body; None if it is on this map.

        The path of a scene is on the map with which it was opened.
        """
        run = self._session.shown_run
        history = self._editor.history
        assert history is not None
        opened = history not in self._histories
        self._histories.add(history)
        self._off_skin = 0.0, 0.0
        if run is None or opened or run.map is after:
            return None
        before = run.settings.settings
        settings = self._tools.control.carry_path(before, run.map, after)
        if before.path:
            self._off_skin = (
                share_off_skin(before.path_kind, before.path, run.map),
                share_off_skin(settings.path_kind, settings.path, after),
            )
        return settings

    def _report_path(self) -> None:
        """Report that an edit, such as a patch that was moved away, left a part of the path without skin."""
        before, after = self._off_skin
        self._off_skin = 0.0, 0.0
        if after > before + _OFF_SKIN:
            text = f"After this edit of the map, {after:.0%} of the path is off the skin and cannot be followed."
            self._notifier.say(text, warning=True, remedies=[self._context.actions["undo"]], of="path on skin")
        elif after < before - _OFF_SKIN:
            self._notifier.succeed("path on skin")

    def _on_proposal_changed(self) -> None:
        self.proposal.show_proposal(self._editor.proposal)

    def _choose_compared(self) -> None:
        """Ask for the files of another layout, and compare with it."""
        paths = self._context.dialogs.open_files("Compare with", _COMPARED)
        if paths and self._context.panels.get(ComparePanel).open_paths(paths):
            self._context.dialogs.remember_opened(*paths)

    def _on_shown_other(self, other: bool) -> None:
        """Show the compared layout without the editing tools, or the own map again."""
        document = self._context.panels.get(ComparePanel).other if other else self._editor.document
        if isinstance(document, MapDocument):
            self._views.show_document(document, led=not other)
        self._views.set_view_tool(None if other else self._tools.view_tool)

    def _on_hovered(self, at: SurfacePoint | None) -> None:
        self._context.panels.get(PatchesPanel).show_hover(None if at is None else at.patch)

    # Actions.

    def _toggle_other(self) -> None:
        panel = self._context.panels.get(ComparePanel)
        if not panel.can_show_other:
            self._notifier.status("No other layout to show: open or keep one in the panel Compare")
        panel.toggle()

    def _add_pin(self) -> None:
        taxels = self._views.selection.taxels
        if len(taxels):
            self._pins.pin_taxels(taxels)
        else:
            self._pins.add_here()

    def _propose(self) -> None:
        """Propose a seam with the tool that shows proposals."""
        self._tools.take(SEAMS)
        self._seams.propose()
