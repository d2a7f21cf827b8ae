"""The sheet of gestures and keys: searched, scrolled, and left open beside the window."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QHeaderView, QLineEdit, QTreeWidget, QTreeWidgetItem, QVBoxLayout, QWidget

WIDTH, HEIGHT = 860, 640
"""It fits a screen of 768 rows with its frame and a bar of the desktop's [px]."""

Row = tuple[str, str]
"""Keys or gesture, and what they do."""


class KeysSheet(QDialog):
    """Groups of rows below a field that keeps those with all its words. Not modal; closed, it is gone.

    Args:
        groups: Heading and rows of each, in order.
        parent: Over which it stays.
    """

    def __init__(self, groups: Sequence[tuple[str, Sequence[Row]]], parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("keys")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle("Keys and gestures")
        self.search = QLineEdit(self)
        self.search.setObjectName("keys-search")
        self.search.setPlaceholderText("Search")
        self.search.setClearButtonEnabled(True)
        self.search.textChanged.connect(self._on_text_changed)
        self.list = QTreeWidget(self)
        self.list.setObjectName("keys-list")
        self.list.setHeaderHidden(True)
        self.list.setColumnCount(2)
        self.list.setRootIsDecorated(False)
        self.list.setIndentation(8)
        self.list.setWordWrap(True)
        self.list.setSelectionMode(QTreeWidget.SelectionMode.NoSelection)
        self.list.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.list.header().setSectionResizeMode(0, QHeaderView.ResizeMode.ResizeToContents)
        self.list.header().setMaximumSectionSize(WIDTH // 2 - 60)
        column = QVBoxLayout(self)
        column.addWidget(self.search)
        column.addWidget(self.list, 1)
        self.resize(WIDTH, HEIGHT)
        self.show_groups(groups)

    def show_groups(self, groups: Sequence[tuple[str, Sequence[Row]]]) -> None:
        """List these instead."""
        self.list.clear()
        self._groups: list[tuple[QTreeWidgetItem, list[QTreeWidgetItem]]] = []
        for heading, rows in groups:
            group = QTreeWidgetItem([heading])
            font = group.font(0)
            font.setBold(True)
            group.setFont(0, font)
            self.list.addTopLevelItem(group)
            group.setFirstColumnSpanned(True)
            own = [QTreeWidgetItem([keys, does]) for keys, does in rows]
            for row in own:
                row.setToolTip(1, row.text(1))
            group.addChildren(own)
            group.setExpanded(True)
            self._groups.append((group, own))
        self._on_text_changed(self.search.text())

    @property
    def shown(self) -> list[Row]:
        """The rows that the search leaves, in order."""
        rows = (row for _, rows in self._groups for row in rows)
        return [(row.text(0), row.text(1)) for row in rows if not row.isHidden()]

    def _on_text_changed(self, text: str) -> None:
        words = text.lower().split()
        for group, rows in self._groups:
            for row in rows:
                told = f"{group.text(0)} {row.text(0)} {row.text(1)}".lower()
                row.setHidden(not all(word in told for word in words))
            group.setHidden(all(row.isHidden() for row in rows))
