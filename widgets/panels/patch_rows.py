"""How a row of the patch tree looks, and the field in which its name is written."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QRect, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QKeyEvent, QPainter, QPalette, QPen
from PySide6.QtWidgets import QLineEdit, QStyle, QStyledItemDelegate, QStyleOptionViewItem, QWidget

from app.editing.patches import LONGEST
from widgets.panels.patch_glyphs import SIZE, draw_eye, draw_pin, draw_seam
from widgets.panels.patch_model import NUMBER, PINS, SEAMS, VISIBLE, Index, PatchModel

ROW = 28
EYE = 28
_GAP = 6


class PatchRows(QStyledItemDelegate):
    """Draws a row, and keeps the field open while it holds a name that is refused."""

    def __init__(self, model: PatchModel, parent: QObject) -> None:
        super().__init__(parent)
        self._model = model
        self.hovered = -1

    def sizeHint(self, _option: QStyleOptionViewItem, _index: Index) -> QSize:
        """Qt."""
        return QSize(120, ROW)

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        """Qt: eye, name, and at the end of the row seams and pins."""
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        palette, rect, state = option.palette, option.rect, option.state
        visible = bool(index.data(VISIBLE))
        self._draw_ground(painter, palette, rect, state, hovered=index.data(NUMBER) == self.hovered)
        text = palette.color(QPalette.ColorRole.Text)
        quiet = palette.color(QPalette.ColorRole.PlaceholderText) if state & QStyle.StateFlag.State_Enabled else text
        eye = QRectF(rect.left(), rect.top(), EYE, rect.height())
        draw_eye(painter, eye, text if visible else quiet, open_=visible)
        right = self._draw_signs(painter, index, rect, quiet)
        words = QRect(rect.left() + EYE, rect.top(), right - rect.left() - EYE, rect.height())
        name = painter.fontMetrics().elidedText(str(index.data()), Qt.TextElideMode.ElideMiddle, words.width())
        painter.setPen(text if visible else quiet)
        painter.drawText(words, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, name)
        painter.restore()

    def _draw_ground(
        self, painter: QPainter, palette: QPalette, rect: QRect, state: QStyle.StateFlag, *, hovered: bool
    ) -> None:
        accent, selected = QColor(palette.color(QPalette.ColorRole.Link)), bool(state & QStyle.StateFlag.State_Selected)
        if selected or hovered:
            accent.setAlphaF(0.28 if selected else 0.12)
            painter.fillRect(rect, accent)
        if state & QStyle.StateFlag.State_HasFocus:
            painter.setPen(QPen(palette.color(QPalette.ColorRole.Link), 1))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRect(QRectF(rect).adjusted(0.5, 0.5, -0.5, -0.5))

    def _draw_signs(self, painter: QPainter, index: Index, rect: QRect, colour: QColor) -> int:
        """The left end of what it drew."""
        right, painted = rect.right() - _GAP, painter.fontMetrics()
        pins = int(index.data(PINS))
        painter.setPen(colour)
        if pins:
            width = painted.horizontalAdvance(f"{pins}")
            box = QRect(right - width, rect.top(), width, rect.height())
            painter.drawText(box, Qt.AlignmentFlag.AlignVCenter, f"{pins}")
            right -= width + SIZE - 2
            draw_pin(painter, QRectF(right, rect.top(), SIZE, rect.height()), colour)
            right -= _GAP
        if index.data(SEAMS):
            right -= SIZE
            draw_seam(painter, QRectF(right, rect.top(), SIZE, rect.height()), colour)
            right -= _GAP
        return right

    def createEditor(self, parent: QWidget, _option: QStyleOptionViewItem, _index: Index) -> QWidget:
        """Qt: a field for the name."""
        field = QLineEdit(parent)
        field.setObjectName("patch-name")
        field.setMaxLength(LONGEST)
        field.setAccessibleName("Name of the patch")
        return field

    def updateEditorGeometry(self, editor: QWidget, option: QStyleOptionViewItem, _index: Index) -> None:
        """Qt: where the name is."""
        editor.setGeometry(option.rect.adjusted(EYE - 4, 1, 0, -1))

    def eventFilter(self, editor: QObject, event: QEvent) -> bool:
        """Qt: Enter with a name that is refused says why, and the field stays."""
        enter = (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Tab)
        if isinstance(event, QKeyEvent) and event.type() == QEvent.Type.KeyPress and isinstance(editor, QLineEdit):
            if event.key() == Qt.Key.Key_Escape:
                self._model.refused.emit("")
            elif event.key() in enter and (why := self._model.refusal(self._named, editor.text())):
                self._model.refused.emit(why)
                editor.selectAll()
                return True
        return super().eventFilter(editor, event)

    def setEditorData(self, editor: QWidget, index: Index) -> None:
        """Qt: the name as it is."""
        self._named = int(index.data(NUMBER))
        super().setEditorData(editor, index)
