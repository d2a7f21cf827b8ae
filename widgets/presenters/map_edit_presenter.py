"""What the window can do to the map: connects editor, tools, actions, files and what is shown."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from app.control.command import ControlSettings
from app.editing import arrange
from app.editing.document import MapDocument, show_patches
from app.geometry.mesh import SurfacePoint
from app.maps.tactile_map import TactileMap
from app.session.prepare import PreparedScene
from app.studies.stages.control import stage_setting_of, with_stage_setting
from app.studies.stages.registry import edits_map
from app.studies.work_precision import Setting
from widgets.common.tool_kinds import ToolKind
from widgets.document.map_editor import MapEditor
from widgets.document.stage_settings import reflatten_for
from widgets.interaction.view_tool import ViewTool
from widgets.map_view.live_image import ImageSettings
from widgets.presenters.map_file_presenter import MapFilePresenter
from widgets.tools.arrange_tool import ArrangeTool
from widgets.tools.interest_tool import InterestTool
from widgets.tools.pin_tool import PinTool
from widgets.tools.seam_tool import SeamTool

if TYPE_CHECKING:
    from widgets.window.main_window import MainWindow


_WITH_EDITOR = (
    "arrange", "pins", "seams", "interest", "add_pin", "remove_pin", "select_pins", "propose_seam", "repack",
    "show_patches", "open_map", "save_map", "save_map_as", "export_map",
)  # fmt: skip
_WITH_PATCHES = ("mirror", "true_size", "hide_patches", *(f"align_{edge}" for edge in arrange.EDGES))


class MapEditPresenter(QObject):
    """The commands of the Edit menu, and where the document goes.

    Args:
        window: The window, with its actions, views and panels made.

    Attributes:
        files: Where the map is kept.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window, self._live, self._views = window, window.live, window.views
        self._editor: MapEditor = window.editor
        self.files = MapFilePresenter(window, self._editor)
        self._arrange = ArrangeTool(self._editor, self)
        self._pins = PinTool(self._editor, self)
        self._seams = SeamTool(self._editor, self)
        self._interest = InterestTool(self._editor, self)
        self._tools: dict[ToolKind, ViewTool] = {
            ToolKind.ARRANGE: self._arrange,
            ToolKind.PINS: self._pins,
            ToolKind.SEAMS: self._seams,
            ToolKind.INTEREST: self._interest,
            **window.control_tools_presenter.tools,
        }
        self._connect_editor()
        self._connect_actions()
        look = ImageSettings()
        window.column.accuracy.show_present(Setting("image", look.interpolation, {"pixels": look.pixels}))
        self._update_state()

    def _connect_editor(self) -> None:
        editor, live = self._editor, self._live
        editor.shown.connect(self._on_shown)
        editor.settled.connect(self._on_settled)
        for signal in (editor.history_changed, editor.selection_changed, editor.enabled_changed, editor.rested):
            signal.connect(self._update_state)
        editor.working.connect(self._update_state)
        editor.failed.connect(self._on_failed)
        editor.told.connect(self._on_told)
        self.files.changed.connect(self._update_state)
        self._window.control_tools_presenter.undo_changed.connect(self._update_undo)
        compare, map_quality_worker = self._window.column.compare, live.map_quality_worker
        compare.compare_requested.connect(map_quality_worker.compare)
        compare.shown_other.connect(self._on_shown_other)
        map_quality_worker.compared.connect(compare.show_comparison)
        map_quality_worker.failed.connect(compare.show_failed)
        self._views.hovered.connect(self._on_hovered)
        self._window.column.patches.hovered.connect(self._arrange.point_at)
        self._window.column.accuracy.chosen.connect(self._on_setting_chosen)
        editor.selection_changed.connect(self._tell_accuracy)
        live.prepared_changed.connect(self._on_prepared_changed)
        live.map_changed.connect(self._on_map_changed)
        live.mode_changed.connect(self._on_mode_changed)
        live.settings_changed.connect(self._on_settings_changed)

    def _connect_actions(self) -> None:
        editor, files = self._editor, self.files
        for name, act in (
            ("undo", self._undo),
            ("redo", self._redo),
            ("add_pin", self._add_pin),
            ("remove_pin", self._pins.remove),
            ("select_pins", self._pins.select_pinned),
            ("propose_seam", self._propose),
            ("mirror", self._mirror),
            ("true_size", self._true_size),
            ("repack", self._repack),
            ("hide_patches", self._hide),
            ("show_patches", self._show_all),
            ("cancel_edit", editor.cancel_work),
            ("compare", self._window.column.compare.toggle),
            ("open_map", files.choose_open),
            ("save_map", files.save),
            ("save_map_as", files.choose_save),
            ("export_map", files.choose_export),
            ("restore_map", files.restore),
            *((f"align_{edge}", partial(self._align, edge)) for edge in arrange.EDGES),
        ):
            self._window.action(name).triggered.connect(act)

    def take_tool(self, tool: ToolKind) -> None:
        """Give the views the edit tool for ``tool``, or none."""
        taken = self._tools.get(tool)
        self._views.set_view_tool(taken)
        self._update_undo()
        if taken is not None:
            self._window.statusBar().showMessage(taken.hint, 15_000)
        else:
            self._window.statusBar().clearMessage()

    # The document's way.

    def _on_prepared_changed(self, prepared: PreparedScene) -> None:
        """Another scene: its map is another document. Back from a replay, the document is the one edited before."""
        if self._live.player is not None:
            return
        document = self._editor.document
        if document is not None and document.skin is prepared.map.skin:
            self._on_settled(document, "")
            self._on_shown(document)
            return
        self._editor.open(MapDocument.of(prepared.map))
        self.files.begin(prepared)

    def _on_map_changed(self, map_: TactileMap) -> None:
        """A recorded edit was passed in a replay."""
        self._views.show_document(MapDocument.of(map_))

    def _on_mode_changed(self, mode: str) -> None:
        self._editor.set_enabled(enabled=mode in ("live", "paused"))

    def _on_shown(self, document: MapDocument) -> None:
        self._views.show_document(document, in_hand=self._editor.gesture)

    def _on_settled(self, document: MapDocument, name: str) -> None:
        self._live.edit_map(document.map, name)
        self._live.map_quality_worker.measure(document.map)
        self._tell_accuracy()

    def _on_shown_other(self, other: bool) -> None:
        """The layout that is compared with is looked at, not edited: tools that edit wait until ours is back."""
        document = self._window.column.compare.other if other else self._editor.document
        if isinstance(document, MapDocument):
            self._views.show_document(document, led=not other)
        self._views.set_view_tool(None if other else self._tools.get(self._views.tool))

    def _tell_accuracy(self) -> None:
        self._window.column.accuracy.show_document(self._editor.document, self._editor.selected)

    def _on_setting_chosen(self, setting: Setting) -> None:
        """A point of the Accuracy and time panel was clicked: take its setting."""
        if edits_map(setting):
            self._editor.ask(lambda document: reflatten_for(document, setting))
        elif setting.stage == "touch":
            self._window.effects_presenter.wish("skin", setting.method)
        elif setting.stage == "simulation":
            self._window.effects_presenter.wish("integrator", setting.method)
            self._window.effects_presenter.wish("timestep", 1e-3 * float(setting.values["timestep_ms"]))
        elif setting.stage == "control":
            self._live.set_settings(with_stage_setting(self._window.column.controller.settings, setting))
        elif setting.stage == "image":
            self._views.map.set_image(ImageSettings(setting.method, int(setting.values["pixels"])))
            self._window.column.accuracy.show_present(setting)
        else:
            self._on_told("How touch is computed is the scene's: choose the skin's model among its effects")

    def _on_settings_changed(self, settings: ControlSettings) -> None:
        self._window.column.accuracy.show_present(stage_setting_of(settings))

    def _on_hovered(self, at: SurfacePoint | None) -> None:
        self._window.column.patches.show_hover(None if at is None else at.patch)

    def _on_failed(self, text: str) -> None:
        self._window.notification_bar.say(text, fault=True)

    def _on_told(self, text: str) -> None:
        self._window.statusBar().showMessage(text, 5_000)

    # Commands.

    def _undo(self) -> None:
        """With a tool that leads the arm, what was drawn for it; else the last edit of the map."""
        (self._window.control_tools_presenter if self._views.tool.leads else self._editor).undo()

    def _redo(self) -> None:
        (self._window.control_tools_presenter if self._views.tool.leads else self._editor).redo()

    def _add_pin(self) -> None:
        taxels = self._views.selection.taxels
        if len(taxels):
            self._pins.pin_taxels(taxels)
        else:
            self._pins.add_here()

    def _propose(self) -> None:
        """With the tool that shows what is proposed."""
        self._window.view_presenter.set_tool(ToolKind.SEAMS)
        self._seams.propose()

    def set_brush(self, radius: float) -> None:
        """The brush that paints areas of interest is as wide as the one that selects [px]."""
        self._interest.set_radius(radius)

    def _mirror(self) -> None:
        selected = self._editor.selected
        self._editor.do("Mirror", lambda document: arrange.mirror(document, selected))

    def _true_size(self) -> None:
        selected = self._editor.selected
        self._editor.do("True size", lambda document: arrange.true_size(document, selected))

    def _repack(self) -> None:
        selected = self._editor.selected or None
        self._editor.do("Repack", lambda document: arrange.repack(document, selected))

    def _align(self, edge: arrange.Edge) -> None:
        selected = self._editor.selected
        self._editor.do("Align", lambda document: arrange.align(document, selected, edge))

    def _hide(self) -> None:
        selected = self._editor.selected
        self._editor.do("Hide patches", lambda document: show_patches(document, selected, visible=False))

    def _show_all(self) -> None:
        self._editor.do("Show all patches", lambda document: show_patches(document, range(len(document.patches))))

    def _update_state(self) -> None:
        """Enable what can be done, and say what undo would undo."""
        editor, action = self._editor, self._window.action
        enabled = editor.enabled and editor.document is not None
        for name in _WITH_EDITOR:
            action(name).setEnabled(enabled)
        for name in _WITH_PATCHES:
            action(name).setEnabled(enabled and bool(editor.selected))
        action("cancel_edit").setEnabled(editor.busy)
        self._update_undo()
        self._window.setWindowModified(self.files.unsaved)
        name = self.files.path.name if self.files.path is not None else "Tactile Maps"
        self._window.setWindowTitle(f"{name}[*]" if name == "Tactile Maps" else f"{name}[*] – Tactile Maps")

    def _update_undo(self) -> None:
        """Enable undo and redo where there is something to take back, and say what."""
        leading = self._window.control_tools_presenter
        if self._views.tool.leads:
            can_undo, can_redo = leading.can_undo, leading.can_redo
            undo, redo = leading.settings_editor.undo_name, leading.settings_editor.redo_name
        else:
            history, editor = self._editor.history, self._editor
            enabled = history is not None and editor.enabled and editor.document is not None
            can_undo = enabled and history is not None and (history.can_undo or editor.busy)
            can_redo = enabled and history is not None and history.can_redo
            undo = history.names[history.position] if history is not None and history.position else ""
            redo = history.names[history.position + 1] if history is not None and history.can_redo else ""
        for name, word, what, can in (("undo", "Undo", undo, can_undo), ("redo", "Redo", redo, can_redo)):
            self._window.action(name).setEnabled(can)
            self._window.action(name).setText(f"{word} {what[:1].lower()}{what[1:]}" if what else word)
