"""Steps of map and skin: done steps, the current one, and undone steps that can be redone.

Of an earlier or later skin, one row is listed: the step that led to it. Edits of its map return with it.
"""

from __future__ import annotations

from PySide6.QtCore import QModelIndex, QObject, QRect, Qt
from PySide6.QtGui import QFont, QKeyEvent, QPainter, QPalette
from PySide6.QtWidgets import QListView, QStyle, QStyleOptionViewItem, QWidget

from tactile_widgets.common.lists import ModelIndex, RowDelegate, SequenceModel, read_only_list
from tactile_widgets.common.panel import Panel
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.document.skin_steps import SkinSteps

ROW = 24
_MAX_ROWS = 8
_MARGIN = 16
_EMPTY = "Edits of the map and the skin are listed here; click a step to go back to it."
_REPLAYING = "The timeline marks the edits of the recording; return to the session to see its own."
_UNDONE = int(Qt.ItemDataRole.UserRole)
_PRESENT = _UNDONE + 1
_TIPS = {"now": "Current state", "done": "Undo all later edits", "undone": "Redo"}


class HistoryModel(SequenceModel):
    """Item model with one row per step, oldest first."""

    def __init__(self, editor: MapEditor, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._editor = editor
        self._skins: SkinSteps | None = None
        self.position = -1
        self.refresh()

    def refresh(self) -> None:
        """Show the current steps."""
        history = self._editor.history
        skins = self._skins
        before = () if skins is None else skins.names_before
        after = () if skins is None else skins.names_after
        names = () if history is None else (*before, *history.names, *after)
        position = -1 if history is None else len(before) + history.position
        if names != self.items or position != self.position:
            self.position = position
            self.show_items(names)

    def follow_skin(self, skins: SkinSteps) -> None:
        """List the changes of the skin too."""
        self._skins = skins

    def go(self, row: int) -> None:
        """Return to the step of a row."""
        history = self._editor.history
        if row == self.position or history is None:
            return
        before = 0 if self._skins is None else len(self._skins.names_before)
        edits = len(history.names)
        if self._skins is None or before <= row < before + edits:
            self._editor.go(row - before)
        else:
            self._skins.go(row - before if row < before else row - before - edits + 1)

    def value(self, row: int, role: int) -> object:
        name = self.items[row]
        state = "now" if row == self.position else "undone" if row > self.position else "done"
        match role:
            case Qt.ItemDataRole.DisplayRole:
                return name
            case Qt.ItemDataRole.AccessibleTextRole:
                return f"{name}, {state}"
            case Qt.ItemDataRole.ToolTipRole:
                return f"{name}\n{_TIPS[state]}"
        return {_UNDONE: state == "undone", _PRESENT: state == "now"}.get(role)


class _StepDelegate(RowDelegate):
    """The present step is bold with a mark, undone steps are italic and dimmed."""

    def draw(self, painter: QPainter, option: QStyleOptionViewItem, index: ModelIndex) -> None:
        palette = option.palette
        rect = option.rect
        role = QPalette.ColorRole
        undone = bool(index.data(_UNDONE))
        accent = palette.color(role.Link)
        if option.state & (QStyle.StateFlag.State_MouseOver | QStyle.StateFlag.State_HasFocus):
            accent.setAlphaF(0.12)
            painter.fillRect(rect, accent)
        font = QFont(option.font)
        font.setItalic(undone)
        if index.data(_PRESENT):
            painter.fillRect(QRect(rect.left() + 4, rect.top() + 4, 3, rect.height() - 8), palette.color(role.Link))
            font.setWeight(QFont.Weight.DemiBold)
        if undone or index.data(_PRESENT):
            painter.setFont(font)
        painter.setPen(palette.color(role.PlaceholderText if undone else role.Text))
        words = rect.adjusted(_MARGIN, 0, -8, 0)
        text = painter.fontMetrics().elidedText(str(index.data()), Qt.TextElideMode.ElideRight, words.width())
        painter.drawText(words, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, text)


class _StepList(QListView):
    """Return, Enter and Space click the current step."""

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Space) and self.currentIndex().isValid():
            self.clicked.emit(self.currentIndex())
        else:
            super().keyPressEvent(event)


class HistoryPanel(Panel):
    """List of steps, scrolled to the current one; a click on a step goes to it.

    Args:
        editor: Editor whose history is shown.
        parent: Qt parent.
    """

    def __init__(self, editor: MapEditor, parent: QWidget | None = None) -> None:
        super().__init__("History", "history-panel", parent)
        self._editor = editor
        self._note = self.caption(name="history-note")
        self.list = read_only_list(_StepList(self), "history-list", "History")
        self.steps = HistoryModel(editor, self)
        self.list.setMouseTracking(True)
        self.list.setModel(self.steps)
        self.list.setItemDelegate(_StepDelegate(ROW, self.list))
        self.list.clicked.connect(self._on_clicked)
        self.column.addWidget(self.list)
        for signal in (editor.history_changed, editor.enabled_changed):
            signal.connect(self._update_state)
        self._update_state()

    def follow_skin(self, skins: SkinSteps) -> None:
        """List the changes of the skin too."""
        self.steps.follow_skin(skins)
        skins.changed.connect(self._update_state)

    def _update_state(self) -> None:
        self.steps.refresh()
        count = self.steps.rowCount()
        replaying = count > 0 and not self._editor.enabled
        self._note.setText(_REPLAYING if replaying else _EMPTY)
        self._note.setVisible(count < 2 or replaying)
        self.list.setVisible(count > 1 and not replaying)
        self.list.setFixedHeight(ROW * min(max(count, 1), _MAX_ROWS))
        self.list.setCurrentIndex(self.steps.index(self.steps.position))  # which scrolls there

    def _on_clicked(self, index: QModelIndex) -> None:
        self.steps.go(index.row())
