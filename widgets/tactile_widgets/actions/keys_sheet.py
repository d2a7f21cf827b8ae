"""Dialog that lists mouse gestures and shortcuts, searches them and changes shortcuts; it can stay open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import QEvent, QModelIndex, QObject, Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QDialog, QHeaderView, QLineEdit, QTreeWidget, QTreeWidgetItem, QWidget

from tactile_widgets.actions.key_editor import KeyEditor
from tactile_widgets.actions.keymap import KeyMap
from tactile_widgets.actions.registry import key_text
from tactile_widgets.common.make import STYLE_SPACING, column_layout, make, resize_on_screen

WIDTH = 860
HEIGHT = 640
"""Fits a screen of 768 rows together with the window frame and a desktop bar [px]."""

Row = tuple[str, str]
"""Keys or gesture and their effect; for actions, name and text."""
_NAME = int(Qt.ItemDataRole.UserRole)


class KeysSheet(QDialog):
    """Groups of rows below a search field. Not modal; deleted when closed.

    Args:
        gestures: Mouse gestures and their effects.
        groups: Title of each menu, with names and texts of its actions.
        keymap: Shortcuts of the actions.
        reserved: Keys that cannot be shortcuts, each with its use.
        parent: Window over which the dialog opens.
    """

    keys_changed = Signal(KeyMap)
    """Changed shortcuts."""

    def __init__(
        self,
        gestures: Sequence[Row],
        groups: Sequence[tuple[str, Sequence[Row]]],
        keymap: KeyMap,
        reserved: Mapping[str, str],
        parent: QWidget,
    ) -> None:
        super().__init__(parent)
        self.setObjectName("keys")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle("Keys and gestures")
        self.search = self._make_search()
        self.list = self._make_list()
        titles = {name: text for _, rows in groups for name, text in rows}
        self.editor = KeyEditor(keymap, titles, reserved, self)
        self.editor.changed.connect(self._on_changed)
        self.editor.done.connect(self.search.setFocus)
        parts = (self.search, self.list, self.editor)
        column_layout(*parts, parent=self, spacing=STYLE_SPACING, stretch=self.list, margins=None)
        resize_on_screen(self, WIDTH, HEIGHT)
        self._rows: dict[str, QTreeWidgetItem] = {}
        self._groups = [self._add_group("Mouse", gestures)]
        for heading, rows in groups:
            group, own = self._add_group(heading, [("", text) for _, text in rows])
            for item, (name, _) in zip(own, rows, strict=True):
                item.setData(0, _NAME, name)
                item.setFlags(item.flags() | Qt.ItemFlag.ItemIsSelectable)
                self._rows[name] = item
            self._groups.append((group, own))
        self._write_keys()
        self.search.textChanged.connect(self._on_text_changed)
        self.list.currentItemChanged.connect(self._on_current_changed)
        self.list.itemDoubleClicked.connect(self._on_double_clicked)

    def _make_search(self) -> QLineEdit:
        search = make(
            QLineEdit,
            self,
            objectName="keys-search",
            accessibleName="Search keys and gestures",
            placeholderText="Search",
            clearButtonEnabled=True,
        )
        search.installEventFilter(self)
        return search

    def _make_list(self) -> QTreeWidget:
        tree = make(
            QTreeWidget,
            self,
            objectName="keys-list",
            accessibleName="Keys and gestures",
            headerHidden=True,
            columnCount=2,
            rootIsDecorated=False,
            indentation=8,
            wordWrap=True,
            expandsOnDoubleClick=False,
            focusPolicy=Qt.FocusPolicy.NoFocus,
        )
        tree.header().setSectionResizeMode(0, QHeaderView.ResizeMode.ResizeToContents)
        tree.header().setMaximumSectionSize(WIDTH // 2 - 60)
        return tree

    def _add_group(self, heading: str, rows: Sequence[Row]) -> tuple[QTreeWidgetItem, list[QTreeWidgetItem]]:
        group = QTreeWidgetItem([heading])
        font = group.font(0)
        font.setBold(True)
        group.setFont(0, font)
        group.setFlags(group.flags() & ~Qt.ItemFlag.ItemIsSelectable)
        self.list.addTopLevelItem(group)
        group.setFirstColumnSpanned(True)
        own = [QTreeWidgetItem(list(row)) for row in rows]
        for row in own:
            row.setToolTip(1, row.text(1))
            row.setFlags(row.flags() & ~Qt.ItemFlag.ItemIsSelectable)
        group.addChildren(own)
        group.setExpanded(True)
        return group, own

    @property
    def shown(self) -> list[Row]:
        """Rows that match the search, in order: keys or gesture, and effect."""
        rows = (row for _, rows in self._groups for row in rows)
        return [(row.text(0), row.text(1)) for row in rows if not row.isHidden()]

    def choose(self, name: str) -> None:
        """Select an action and scroll to it."""
        self.list.setCurrentItem(self._rows[name])
        self.list.scrollToItem(self._rows[name])

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Move in the list while the search field has the focus; Return records a key."""
        if not isinstance(event, QKeyEvent) or event.type() != QEvent.Type.KeyPress:
            return False
        steps = {Qt.Key.Key_Down: 1, Qt.Key.Key_Up: -1, Qt.Key.Key_PageDown: 10, Qt.Key.Key_PageUp: -10}
        if event.key() in steps:
            self._step(steps[Qt.Key(event.key())])
            return True
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.editor.begin()
            return True
        return False

    def _step(self, by: int) -> None:
        names = [name for name, row in self._rows.items() if not row.isHidden()]
        if not names:
            return
        now = self.list.currentItem()
        at = names.index(now.data(0, _NAME)) if now is not None and now.data(0, _NAME) in names else -1 if by > 0 else 0
        self.choose(names[min(max(at + by, 0), len(names) - 1)])

    def _write_keys(self) -> None:
        keymap = self.editor.keymap
        for name, row in self._rows.items():
            row.setText(0, ", ".join(map(key_text, keymap.keys(name))) or "–")
            font = row.font(0)
            font.setItalic(keymap.changed(name))
            row.setFont(0, font)
            row.setToolTip(0, "Changed; Reset restores the default key" if keymap.changed(name) else "")

    def _on_changed(self, keymap: KeyMap) -> None:
        self._write_keys()
        self._on_text_changed(self.search.text())
        self.keys_changed.emit(keymap)

    def _on_current_changed(self, now: QTreeWidgetItem | None, _before: QTreeWidgetItem | None) -> None:
        self.editor.choose(None if now is None else now.data(0, _NAME))

    def _on_double_clicked(self, item: QTreeWidgetItem) -> None:
        if item.data(0, _NAME) is not None:
            self.editor.begin()

    def _on_text_changed(self, text: str) -> None:
        words = text.lower().split()
        for group, rows in self._groups:
            for row in rows:
                words_of_row = f"{group.text(0)} {row.text(0)} {row.text(1)}".lower()
                row.setHidden(not all(word in words_of_row for word in words))
            group.setHidden(all(row.isHidden() for row in rows))
        now = self.list.currentItem()
        if now is not None and now.isHidden():
            self.list.setCurrentIndex(QModelIndex())
