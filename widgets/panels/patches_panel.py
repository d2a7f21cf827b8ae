"""The patch tree, and what can be done to the patches selected in it."""

from __future__ import annotations

from PySide6.QtCore import QPoint, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QLineEdit, QWidget

from widgets.editor import Editor
from widgets.panels.panel import Panel
from widgets.panels.patch_acts import PatchActs
from widgets.panels.patch_list import PatchList
from widgets.panels.patch_wishes import PatchWishes

FILTER_FROM = 13
"""With so many patches a name is found by writing it sooner than by looking."""
_MARK = "▲"
_EMPTY = "Open a robot to arrange the patches of its map."
_REPLAYING = "A replay shows the map as it was; go back to live to edit it."


class PatchesPanel(Panel):
    """Names, order and visibility of the patches, buttons to arrange those selected, and how they are laid flat.

    Args:
        editor: Whose document is shown and edited.
        parent: Qt parent.
    """

    hovered = Signal(object)
    """The number of the patch whose row is under the pointer, or None."""

    def __init__(self, editor: Editor, parent: QWidget | None = None) -> None:
        super().__init__("Patches", "patches-panel", parent)
        self._editor = editor
        self._note = self.caption(_EMPTY)
        self._note.setObjectName("patches-note")
        self._filter = QLineEdit(self)
        self._filter.setObjectName("patch-filter")
        self._filter.setPlaceholderText("Find a patch or link")
        self._filter.setClearButtonEnabled(True)
        self.list = PatchList(editor, self)
        self._acts, self._wishes = PatchActs(editor, self), PatchWishes(editor, self)
        self.column.addWidget(self._filter)
        self.column.addWidget(self.list)
        self._refusal = self.caption()
        self._refusal.setObjectName("name-refusal")
        self._refusal.hide()
        self._tools = self._acts.buttons(self)
        for part in (self._tools, self._wishes):
            self.column.addWidget(part)
        self._filter.textChanged.connect(self.list.patches.set_wanted)
        self.list.hovered.connect(self.hovered)
        self.list.patches.refused.connect(self._on_refused)
        self.list.customContextMenuRequested.connect(self._on_menu_requested)
        editor.settled.connect(self._dress)
        editor.enabled_changed.connect(self._dress)
        self._dress()

    def show_hover(self, number: int | None) -> None:
        """Tint the row of the patch that the pointer is on in a view."""
        self.list.show_hover(number)

    def _dress(self) -> None:
        """Empty, live, or shut while a recording is replayed."""
        document = self._editor.document
        count = 0 if document is None else len(document.patches)
        self._note.setText(_EMPTY if document is None else _REPLAYING)
        self._note.setHidden(document is not None and self._editor.enabled)
        self._filter.setVisible(count >= FILTER_FROM)
        if count < FILTER_FROM:
            self._filter.clear()
        for part in (self.list, self._tools, self._wishes):
            part.setEnabled(self._editor.enabled)
        for part in (self.list, self._tools, self._wishes):
            part.setHidden(document is None)
        if document is None:
            self._refusal.hide()

    def _on_refused(self, why: str) -> None:
        self._refusal.setText(f"{_MARK} {why[:1].upper()}{why[1:]}")
        self._refusal.setVisible(bool(why))

    def _on_menu_requested(self, at: QPoint) -> None:
        index = self.list.indexAt(at)
        rename = QAction("Rename", self)
        rename.setEnabled(index.isValid())
        rename.triggered.connect(self._on_rename)
        menu = self._acts.menu(self, [rename])
        menu.setObjectName("patch-menu")
        menu.aboutToHide.connect(menu.deleteLater)
        rename.setParent(menu)
        menu.popup(self.list.viewport().mapToGlobal(at))

    def _on_rename(self, _checked: bool = False) -> None:
        self.list.edit(self.list.currentIndex())
