"""The patches panel: the list of patches, and commands for the selected ones.

``PatchActions`` are the commands (mirror, align, true size, pack, show, hide) as buttons and as a context menu;
``FlatteningControls`` choose the flattening method and the trade-off between angles and lengths; ``EditProgress`` shows
the progress of a background computation for an edit, and cancels it.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, QPoint, Qt, QTimer, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QComboBox, QLabel, QLineEdit, QMenu, QPushButton, QSizePolicy, QToolButton, QWidget

from tactile_maps.editing.arrange import Edge, align, mirror, repack, true_size
from tactile_maps.editing.document import MapDocument, show_patches
from tactile_maps.editing.reflatten import set_lengths, set_method
from tactile_maps.flattening.methods import METHODS
from tactile_widgets.common.make import (
    add_items,
    button_grid,
    column_layout,
    make,
    progress_bar,
    row_layout,
    select_data,
    show_text,
)
from tactile_widgets.common.panel import MIXED_VALUES, LabelledSlider, Panel
from tactile_widgets.common.sentence import capitalized
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.panels.maps.patch_list import PatchList, show_only

SHOW_AFTER_MS = 500
"""Duration of an edit after which its progress is shown."""
_TEXT_WIDTH = 100
"""Width of the text until it is laid out [px]."""


class EditProgress(QWidget):
    """Progress of an edit that takes long; its place is reserved, so that nothing moves under the pointer."""

    def __init__(self, editor: MapEditor, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("edit-progress")
        self._text = make(QLabel, self, role="caption", minimumWidth=1)  # a long text is cut
        self._text.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self._bar = progress_bar(self)
        self._bar.setFixedWidth(72)
        cancel = make(
            QToolButton,
            self,
            text="Cancel",
            objectName="edit-cancel",
            toolTip="Keep the current map",
            clicked=editor.cancel_work,
        )
        line = row_layout(self._text, self._bar, cancel, parent=self, stretch=self._text)
        line.setAlignment(self._bar, Qt.AlignmentFlag.AlignVCenter)
        self._delay = make(QTimer, self, singleShot=True, interval=SHOW_AFTER_MS, timeout=self.show)
        kept = self.sizePolicy()
        kept.setRetainSizeWhenHidden(True)
        self.setSizePolicy(kept)
        self.hide()
        editor.working.connect(self._on_working)
        editor.rested.connect(self._on_rested)

    def _on_working(self, text: str, fraction: float) -> None:
        room = max(self._text.width(), _TEXT_WIDTH)
        self._text.setText(self._text.fontMetrics().elidedText(text, Qt.TextElideMode.ElideRight, room))
        self._text.setToolTip(text)
        self._bar.setValue(round(1000 * fraction))
        if self.isHidden() and not self._delay.isActive():
            self._delay.start()

    def _on_rested(self) -> None:
        self._delay.stop()
        self.hide()


_EDGE_TIPS: dict[Edge, str] = {
    "left": "Align the left edges of the patches",
    "centre": "Align the centres of the patches on a vertical line",
    "right": "Align the right edges of the patches",
    "top": "Align the upper edges of the patches",
    "middle": "Align the centres of the patches on a horizontal line",
    "bottom": "Align the lower edges of the patches",
}


class PatchActions(QObject):
    """Commands for patches, each enabled while it has an effect.

    Args:
        editor: Editor of the map.
        parent: Qt parent.
    """

    repack_unneeded = Signal()
    """Repacking moved nothing."""

    def __init__(self, editor: MapEditor, parent: QWidget) -> None:
        super().__init__(parent)
        self._editor = editor
        self.mirror = self._act("Mirror", "Mirror the selected patches horizontally", mirror)
        self.true_size = self._act("True size", "Draw the selected patches at their true size again", true_size)
        tip = "Arrange all patches, or those selected, as they are located on the body"
        self.repack = make(QAction, "Repack", self, toolTip=tip, triggered=self._on_repack)
        tip = "Arrange all patches as they are located on the body"
        self.repack_all = self._act("Repack all", tip, _repack_all, name="Repack")
        show = partial(show_patches, visible=True)
        self._show = self._act("Show", "Show the selected patches", show, name="Show patches")
        hide = partial(show_patches, visible=False)
        tip = "Hide the selected patches; hidden patches keep sensing"
        self.hide = self._act("Hide", tip, hide, name="Hide patches")
        self._only = self._act("Show only these", "Hide all other patches", show_only, name="Show only these patches")
        self.show_all = self._act("Show all", "Show every patch", _show_every, name="Show all patches")
        self.align = {
            edge: self._act(edge.capitalize(), tip, partial(align, edge=edge), name=f"Align {edge}")
            for edge, tip in _EDGE_TIPS.items()
        }
        for signal in (editor.settled, editor.selection_changed, editor.enabled_changed):
            signal.connect(self._update_state)
        self._update_state()

    def menu(self, parent: QWidget, first: QAction) -> QMenu:
        """Construct a menu of all commands after ``first``."""
        menu = make(QMenu, parent, toolTipsVisible=True)
        menu.addAction(first)
        menu.addSeparator()
        menu.addActions([self._show, self.hide, self._only, self.show_all])
        menu.addSeparator()
        menu.addAction(self.mirror)
        menu.addMenu(self._align_menu(menu)).setEnabled(self.align["left"].isEnabled())
        menu.addActions([self.true_size, self.repack])
        return menu

    def _align_menu(self, parent: QWidget) -> QMenu:
        menu = make(QMenu, "Align", parent, toolTipsVisible=True)
        actions = list(self.align.values())
        menu.addActions(actions[:3])
        menu.addSeparator()
        menu.addActions(actions[3:])
        return menu

    def buttons(self, parent: QWidget) -> QWidget:
        """Construct two rows of buttons for the most frequent commands."""
        whole = QWidget(parent)
        tip = "Align the selected patches; at least two"
        align_button = make(QPushButton, "Align", whole, objectName="patch-align", toolTip=tip)
        align_button.setMenu(self._align_menu(align_button))
        align_button.setEnabled(self.align["left"].isEnabled())
        self.align["left"].enabledChanged.connect(align_button.setEnabled)
        named = (("mirror", self.mirror), ("true-size", self.true_size), ("pack", self.repack))
        first, *others = [_ActionButton(action, f"patch-{name}", whole) for name, action in named]
        button_grid((first, align_button, *others), whole)
        return whole

    def _act(self, text: str, tip: str, edit: Any, *, name: str = "") -> QAction:
        """Construct a command that edits the selected patches; the undo step has its ``name``, by default ``text``."""
        return make(QAction, text, self, toolTip=tip, triggered=partial(self._do, name or text, edit))

    def _do(self, name: str, edit: Any, _checked: bool = False) -> None:
        if self._editor.document is not None:
            self._editor.do(name, partial(edit, numbers=self._editor.selected))

    def _on_repack(self) -> None:
        before = self._editor.document
        edit = partial(repack, numbers=self._editor.selected or None)
        if self._editor.do("Repack", edit) and self._editor.document is before:
            self.repack_unneeded.emit()

    def _update_state(self) -> None:
        editor = self._editor
        document = editor.document
        chosen = editor.selected
        on = document is not None and editor.enabled
        patches = [] if document is None else document.patches
        scales = [] if document is None else [document.layout.placements[k].scale for k in chosen]
        for action in (self.mirror, self._only):
            action.setEnabled(on and bool(chosen))
        for action in self.align.values():
            action.setEnabled(on and len(chosen) > 1)
        self.true_size.setEnabled(on and any(scale != 1 for scale in scales))
        self.repack.setEnabled(on)
        self.repack_all.setEnabled(on)
        self._show.setEnabled(on and any(not patches[k].visible for k in chosen))
        self.hide.setEnabled(on and any(patches[k].visible for k in chosen))
        self.show_all.setEnabled(on and not all(patch.visible for patch in patches))


def _repack_all(document: MapDocument, numbers: Iterable[int]) -> MapDocument:
    return repack(document)


def _show_every(document: MapDocument, numbers: Iterable[int]) -> MapDocument:
    return show_patches(document, range(len(document.patches)))


class _ActionButton(QPushButton):
    """A button for an action of the window, whose shortcut in the tool tip may change."""

    def __init__(self, action: QAction, name: str, parent: QWidget) -> None:
        super().__init__(action.text(), parent)
        self.setObjectName(name)
        self._action = action
        self.clicked.connect(action.trigger)
        action.changed.connect(self._on_action_changed)
        self._on_action_changed()

    def _on_action_changed(self) -> None:
        self.setToolTip(self._action.toolTip())
        self.setEnabled(self._action.isEnabled())


_METHOD_NAMES = {
    "symmetric-dirichlet": "Symmetric Dirichlet",
    "tutte": "Tutte",
    "harmonic": "Harmonic",
    "lscm": "Conformal (LSCM)",
    "arap": "As rigid as possible (ARAP)",
    "slim": "SLIM",
    "unroll": "Unroll",
}
_SLIDER_TIP = "Left preserves angles, right preserves lengths; the map is flattened again on release"


class FlatteningControls(QWidget):
    """Flattening method and trade-off of the selected patches; a dash if they differ.

    Args:
        editor: Editor of the map.
        parent: Qt parent.
    """

    def __init__(self, editor: MapEditor, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._editor = editor
        self._method = make(
            QComboBox, self, objectName="patch-method", accessibleName="Method", activated=self._on_method_chosen
        )
        add_items(self._method, ((_METHOD_NAMES.get(name, name), name, _method_tip(name)) for name in METHODS))
        label = make(QLabel, "Method", self, buddy=self._method)
        slider = ("Angle ↔ length preservation", "", 0.0, 1.0, 0.05, _SLIDER_TIP)
        self._lengths = make(LabelledSlider, *slider, self, objectName="patch-lengths", rested=self._on_lengths_rested)
        line = row_layout(label, self._method, stretch=self._method)
        column_layout(line, self._lengths, EditProgress(editor, self), parent=self)
        # After a rejected or cancelled edit, rested shows the old values again.
        for signal in (editor.settled, editor.selection_changed, editor.rested, editor.enabled_changed):
            signal.connect(self._show)
        self._show()

    def _show(self) -> None:
        document = self._editor.document
        patches = [] if document is None else [document.patches[k] for k in self._editor.selected]
        self._method.setEnabled(bool(patches))
        methods = {patch.method for patch in patches}
        self._show_method(methods)
        lengths = {patch.lengths for patch in patches}
        if not self._lengths.held:
            if len(lengths) == 1:
                self._lengths.set_value(lengths.pop())
            else:
                self._lengths.set_mixed()
        why = _why_slider_disabled(methods)
        self._lengths.setEnabled(not why)
        self._lengths.set_tip(why or _SLIDER_TIP)

    def _show_method(self, methods: set[str]) -> None:
        name = next(iter(methods)) if len(methods) == 1 else ""
        select_data(self._method, name)
        self._method.setPlaceholderText(name or MIXED_VALUES)  # the method of an imported chart may be unknown
        tip = _method_tip(name) if name in METHODS else "How the selected patches are flattened"
        self._method.setToolTip(tip if methods else "Select a patch to choose how it is flattened")

    def _on_method_chosen(self, index: int) -> None:
        self._ask(set_method, method=self._method.itemData(index))

    def _on_lengths_rested(self, value: float) -> None:
        self._ask(set_lengths, lengths=round(value, 3))

    def _ask(self, edit: Any, **setting: object) -> None:
        self._editor.ask(partial(edit, numbers=self._editor.selected, **setting))
        if not self._editor.busy:
            self._show()


def _method_tip(name: str) -> str:
    return f"Keeps {METHODS[name].title}"


def _why_slider_disabled(methods: Iterable[str]) -> str:
    """Return why the slider has no effect; empty if it has."""
    names = list(methods)
    if not names:
        return "Select a patch to choose what its map preserves"
    for name in names:
        method = METHODS.get(name)
        if method is None:
            return f"This map was imported, method {name}; choose a method first"
        if not method.slides:
            return f"{_METHOD_NAMES.get(name, name)} preserves {method.title}; Symmetric Dirichlet has a slider"
    return ""


FILTER_FROM = 13
"""Number of patches from which the list has a search field."""
_MARK = "▲"
_EMPTY = "Open a robot to arrange the patches of its map."
_REPLAYING = "These are the patches of the recording; return to the session to edit its map."
_SEARCH = "Find a patch or link"


class PatchesPanel(Panel):
    """Names, order and visibility of the patches, buttons to arrange the selected ones, and their flattening.

    Args:
        editor: Editor whose document is shown.
        parent: Qt parent.
    """

    hovered = Signal(object)
    """Number of the patch whose row is under the pointer, or None."""

    def __init__(self, editor: MapEditor, parent: QWidget | None = None) -> None:
        super().__init__("Patches", "patches-panel", parent)
        self._editor = editor
        self._note = self.caption(_EMPTY, "patches-note")
        self.list = PatchList(editor, self)
        self._filter = make(
            QLineEdit,
            self,
            objectName="patch-filter",
            accessibleName=_SEARCH,
            placeholderText=_SEARCH,
            clearButtonEnabled=True,
            textChanged=self.list.patches.set_filter,
        )
        self.column.addWidget(self._filter)
        self.column.addWidget(self.list)
        self._rejection = self.caption(name="name-refusal")
        self._rejection.hide()
        self.patch_actions = PatchActions(editor, self)
        self._parts = (self.list, self.patch_actions.buttons(self), FlatteningControls(editor, self))
        for part in self._parts[1:]:
            self.column.addWidget(part)
        self.list.hovered.connect(self.hovered)
        self.list.patches.rejected.connect(self._on_rejected)
        self.list.customContextMenuRequested.connect(self._on_menu_requested)
        editor.settled.connect(self._update_state)
        editor.enabled_changed.connect(self._update_state)
        self._update_state()

    def show_hover(self, number: int | None) -> None:
        """Highlight the row of the patch under the pointer in a view."""
        self.list.show_hover(number)

    def show_recorded(self, document: MapDocument | None) -> None:
        """List the patches of a replayed map; None lists those of the edited map again."""
        self.list.patches.show_recorded(document)
        self._update_state()

    def _update_state(self) -> None:
        """Show one of the states empty, editable, or disabled by a replay."""
        patches = self.list.patches
        document = patches.document if patches.recorded else self._editor.document
        count = 0 if document is None else len(document.patches)
        self._note.setText(_EMPTY if document is None else _REPLAYING)
        self._note.setHidden(document is not None and self._editor.enabled)
        self._filter.setVisible(count >= FILTER_FROM)
        if count < FILTER_FROM:
            self._filter.clear()
        for part in self._parts:
            part.setEnabled(self._editor.enabled)
            part.setHidden(document is None or (part is not self.list and patches.recorded))
        if document is None:
            self._rejection.hide()

    def _on_rejected(self, why: str) -> None:
        show_text(self._rejection, f"{_MARK} {capitalized(why)}" if why else "")

    def _on_menu_requested(self, at: QPoint) -> None:
        rename = make(QAction, "Rename", self, enabled=self.list.indexAt(at).isValid(), triggered=self._on_rename)
        menu = self.patch_actions.menu(self, rename)
        menu.setObjectName("patch-menu")
        menu.aboutToHide.connect(menu.deleteLater)
        rename.setParent(menu)
        menu.popup(self.list.viewport().mapToGlobal(at))

    def _on_rename(self) -> None:
        self.list.edit(self.list.currentIndex())
