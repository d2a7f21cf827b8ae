"""The steps of the editor's history: what was done, where we are, and what could be redone."""

from __future__ import annotations

from PySide6.QtCore import QAbstractListModel, QModelIndex, QObject, QPersistentModelIndex, QRect, QSize, Qt
from PySide6.QtGui import QFont, QKeyEvent, QPainter, QPalette
from PySide6.QtWidgets import QAbstractItemView, QListView, QStyle, QStyledItemDelegate, QStyleOptionViewItem, QWidget

from tactile_widgets.common.panel import SLIM_SCROLL_BAR, Panel
from tactile_widgets.document.map_editor import MapEditor

ROW = 24
_MAX_ROWS = 8
_MARGIN = 16
_EMPTY = "Edits of the map are listed here; click a step to go back to it."
_UNDONE = int(Qt.ItemDataRole.UserRole)
_PRESENT = _UNDONE + 1
_NOWHERE = QModelIndex()


class HistoryModel(QAbstractListModel):
    """One row a step, oldest first; rows share the history's own list."""

    def __init__(self, editor: MapEditor, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._editor = editor
        self._names: tuple[str, ...] = ()
        self.position = -1
        self.refresh()

    def refresh(self) -> None:
        """Show the steps as they are now."""
        history = self._editor.history
        names = () if history is None else history.names
        position = -1 if history is None else history.position
        if names == self._names and position == self.position:
            return
        self.beginResetModel()
        self._names = names
        self.position = position
        self.endResetModel()

    def rowCount(self, parent: QModelIndex | QPersistentModelIndex = _NOWHERE) -> int:
        """Qt."""
        return 0 if parent.isValid() else len(self._names)

    def data(self, index: QModelIndex | QPersistentModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        """Qt."""
        if not index.isValid():
            return None
        row = index.row()
        name = self._names[index.row()]
        state = "now" if row == self.position else "undone" if row > self.position else "done"
        match role:
            case Qt.ItemDataRole.DisplayRole:
                return name
            case Qt.ItemDataRole.AccessibleTextRole:
                return f"{name}, {state}"
            case Qt.ItemDataRole.ToolTipRole:
                tips = {"now": "Current state", "done": "Undo all later edits", "undone": "Redo"}
                return f"{name}\n{tips[state]}"
        return {_UNDONE: row > self.position, _PRESENT: row == self.position}.get(role)


class _StepDelegate(QStyledItemDelegate):
    """The present step bold with a mark, those undone dimmed."""

    def sizeHint(self, _option: QStyleOptionViewItem, _index: QModelIndex | QPersistentModelIndex) -> QSize:
        """Qt."""
        return QSize(120, ROW)

    def paint(
        self, painter: QPainter, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex
    ) -> None:
        """Qt."""
        painter.save()
        palette = option.palette
        rect = option.rect
        role = QPalette.ColorRole
        present = bool(index.data(_PRESENT))
        accent = palette.color(role.Link)
        if option.state & (QStyle.StateFlag.State_MouseOver | QStyle.StateFlag.State_HasFocus):
            accent.setAlphaF(0.12)
            painter.fillRect(rect, accent)
        if present:
            painter.fillRect(QRect(rect.left() + 4, rect.top() + 4, 3, rect.height() - 8), palette.color(role.Link))
            font = QFont(option.font)
            font.setWeight(QFont.Weight.DemiBold)
            painter.setFont(font)
        painter.setPen(palette.color(role.PlaceholderText if index.data(_UNDONE) else role.Text))
        if index.data(_UNDONE):
            font = QFont(option.font)
            font.setItalic(True)
            painter.setFont(font)
        words = rect.adjusted(_MARGIN, 0, -8, 0)
        text = painter.fontMetrics().elidedText(str(index.data()), Qt.TextElideMode.ElideRight, words.width())
        painter.drawText(words, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, text)
        painter.restore()


class _StepList(QListView):
    """Enter goes to the step that the keys are on."""

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Qt."""
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Space) and self.currentIndex().isValid():
            self.clicked.emit(self.currentIndex())
        else:
            super().keyPressEvent(event)


class HistoryPanel(Panel):
    """A click on a step goes there; the list stays scrolled to the present one.

    Args:
        editor: Whose history.
        parent: Qt parent.
    """

    def __init__(self, editor: MapEditor, parent: QWidget | None = None) -> None:
        super().__init__("History", "history-panel", parent)
        self._editor = editor
        self._note = self.caption(_EMPTY)
        self.list, self.steps = _StepList(self), HistoryModel(editor, self)
        self.list.setObjectName("history-list")
        self.list.setAccessibleName("History")
        self.list.setFrameShape(QListView.Shape.NoFrame)
        self.list.setUniformItemSizes(True)
        self.list.setMouseTracking(True)
        self.list.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        self.list.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.verticalScrollBar().setStyleSheet(SLIM_SCROLL_BAR)
        self.list.setModel(self.steps)
        self.list.setItemDelegate(_StepDelegate(self.list))
        self.list.clicked.connect(self._on_clicked)
        self.column.addWidget(self.list)
        editor.history_changed.connect(self._on_history_changed)
        editor.enabled_changed.connect(self.list.setEnabled)
        self.list.setEnabled(editor.enabled)
        self._on_history_changed()

    def _on_history_changed(self) -> None:
        self.steps.refresh()
        count = self.steps.rowCount()
        self._note.setVisible(count < 2)
        self.list.setVisible(count > 1)
        self.list.setFixedHeight(ROW * min(max(count, 1), _MAX_ROWS))
        self.list.setCurrentIndex(self.steps.index(self.steps.position))  # which scrolls there

    def _on_clicked(self, index: QModelIndex) -> None:
        if index.row() != self.steps.position:
            self._editor.go(index.row())
