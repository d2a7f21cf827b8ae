"""The list of patches: a row a patch, which can be renamed, shown and hidden, selected and dragged to another place.

Glyphs (eye, pin, seam), the item model over the editor's document, the delegate that paints and edits a row, and the
view.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from PySide6.QtCore import (
    QAbstractListModel,
    QEvent,
    QItemSelection,
    QItemSelectionModel,
    QMimeData,
    QModelIndex,
    QObject,
    QPersistentModelIndex,
    QPoint,
    QPointF,
    QRect,
    QRectF,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QColor, QDropEvent, QKeyEvent, QMouseEvent, QPainter, QPainterPath, QPalette, QPen
from PySide6.QtWidgets import (
    QAbstractItemView,
    QLineEdit,
    QListView,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QWidget,
)

from tactile_maps.core.errors import MapError
from tactile_maps.editing.document import LONGEST_NAME, MapDocument, rename_patch, reorder_patch, show_patches
from tactile_widgets.common.panel import SLIM_SCROLL_BAR
from tactile_widgets.document.map_editor import MapEditor

GLYPH_SIZE = 16


def draw_eye(painter: QPainter, box: QRectF, colour: QColor, *, open_: bool) -> None:
    """An eye in the middle of ``box``: open, or a closed lid with lashes."""
    painter.save()
    painter.translate(box.center())
    painter.setPen(QPen(colour, 1.4, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    lids = QPainterPath(QPointF(-6.5, 0))
    if open_:
        lids.quadTo(QPointF(0, -7), QPointF(6.5, 0))
        lids.quadTo(QPointF(0, 7), QPointF(-6.5, 0))
        painter.drawPath(lids)
        painter.setBrush(colour)
        painter.drawEllipse(QPointF(0, 0), 1.6, 1.6)
    else:
        lids.quadTo(QPointF(0, 7), QPointF(6.5, 0))
        painter.drawPath(lids)
        for x, y, dx, dy in ((-4.2, 2.3, -1.3, 2.0), (0.0, 3.5, 0.0, 2.2), (4.2, 2.3, 1.3, 2.0)):
            painter.drawLine(QPointF(x, y), QPointF(x + dx, y + dy))
    painter.restore()


def draw_pin(painter: QPainter, box: QRectF, colour: QColor) -> None:
    """A pin, head up."""
    painter.save()
    painter.translate(box.center())
    painter.setPen(QPen(colour, 1.4, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
    painter.drawLine(QPointF(0, -1), QPointF(0, 6))
    painter.setBrush(colour)
    painter.drawEllipse(QPointF(0, -3), 2.6, 2.6)
    painter.restore()


def draw_seam(painter: QPainter, box: QRectF, colour: QColor) -> None:
    """A dashed line, as seams are on the map."""
    painter.save()
    painter.translate(box.center())
    pen = QPen(colour, 1.4, Qt.PenStyle.CustomDashLine, Qt.PenCapStyle.FlatCap)
    pen.setDashPattern([2.4, 1.8])
    painter.setPen(pen)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    line = QPainterPath(QPointF(-6, 4))
    line.cubicTo(QPointF(-2, -5), QPointF(2, 5), QPointF(6, -4))
    painter.drawPath(line)
    painter.restore()


ModelIndex = QModelIndex | QPersistentModelIndex
NUMBER_ROLE, VISIBLE_ROLE, PINS_ROLE, SEAMS_ROLE = (int(Qt.ItemDataRole.UserRole) + k for k in range(4))
PATCHES_MIME = "application/x-tactile-maps-patches"
_NOWHERE = QModelIndex()


class PatchModel(QAbstractListModel):
    """One row a patch, in the order of the patch tree; with ``wanted`` words only those whose names have them.

    Everything a user does to it goes through the editor; the model only shows what comes.
    """

    refused = Signal(str)
    """Why a name was not taken; empty when one was."""

    def __init__(self, editor: MapEditor, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._editor = editor
        self._wanted = ""
        self._document: MapDocument | None = None
        self._numbers: tuple[int, ...] = ()
        editor.shown.connect(self._on_shown)
        if editor.document is not None:
            self._on_shown(editor.document)

    @property
    def numbers(self) -> tuple[int, ...]:
        """Of the patches in the rows."""
        return self._numbers

    def set_wanted(self, words: str) -> None:
        """Keep only patches whose name or link has these words."""
        self._wanted = words.strip().casefold()
        self._arrange()

    def row_of(self, number: int) -> int:
        """The row of a patch; -1 if it is filtered out."""
        return self._numbers.index(number) if number in self._numbers else -1

    def rowCount(self, parent: ModelIndex = _NOWHERE) -> int:
        """Qt."""
        return 0 if parent.isValid() else len(self._numbers)

    def data(self, index: ModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        """Qt."""
        if self._document is None or not index.isValid():
            return None
        number = self._numbers[index.row()]
        patch = self._document.patches[number]
        match role:
            case Qt.ItemDataRole.DisplayRole | Qt.ItemDataRole.EditRole:
                return patch.name
            case Qt.ItemDataRole.ToolTipRole:
                return _patch_tip(self._document, number)
            case Qt.ItemDataRole.AccessibleTextRole:
                return patch.name if patch.visible else f"{patch.name}, hidden"
        values = {
            NUMBER_ROLE: number, VISIBLE_ROLE: patch.visible, PINS_ROLE: len(patch.pins),
            SEAMS_ROLE: len(self._document.charts[number].seams),
        }  # fmt: skip
        return values.get(role)

    def flags(self, index: ModelIndex) -> Qt.ItemFlag:
        """Qt: rows can be named and dragged, and something dropped between them."""
        flag = Qt.ItemFlag
        if not index.isValid():
            return flag.ItemIsDropEnabled
        return flag.ItemIsEnabled | flag.ItemIsSelectable | flag.ItemIsEditable | flag.ItemIsDragEnabled

    def refusal(self, number: int, name: str) -> str:
        """Why ``name`` would not be taken; empty if it would."""
        try:
            if self._document is not None:
                rename_patch(self._document, number, name)
        except MapError as error:
            return str(error)
        return ""

    def setData(self, index: ModelIndex, value: object, role: int = Qt.ItemDataRole.EditRole) -> bool:
        """Qt: a patch gets another name, unless that is refused."""
        if role != Qt.ItemDataRole.EditRole or not index.isValid():
            return False
        number = self._numbers[index.row()]
        name = str(value)
        why = self.refusal(number, name)
        self.refused.emit(why)
        return not why and self._editor.do("Rename a patch", partial(rename_patch, number=number, name=name))

    # Dragging.

    def supportedDropActions(self) -> Qt.DropAction:
        """Qt."""
        return Qt.DropAction.MoveAction

    def mimeTypes(self) -> list[str]:
        """Qt."""
        return [PATCHES_MIME]

    def mimeData(self, indexes: Iterable[QModelIndex]) -> QMimeData:
        """Qt: the numbers of the rows, as text."""
        data = QMimeData()
        rows = sorted(index.row() for index in indexes)
        data.setData(PATCHES_MIME, " ".join(str(self._numbers[row]) for row in rows).encode())
        return data

    def dropMimeData(self, data: QMimeData, _action: Qt.DropAction, row: int, _column: int, parent: ModelIndex) -> bool:
        """Qt: patches dropped before ``row``, or on or below what is there."""
        moved = [int(word) for word in bytes(data.data(PATCHES_MIME).data()).split()]
        before = row if row >= 0 else parent.row() if parent.isValid() else len(self._numbers)
        self.move(moved, before)
        return False  # the editor has moved them; Qt must not remove anything

    def move(self, numbers: Iterable[int], before: int) -> None:
        """Have patches moved to stand before the row ``before``, in the order given."""
        if self._document is None:
            return
        moved = tuple(numbers)
        rest = [k for k in self._document.order if k not in moved]
        above, below = (
            [k for k in part if k not in moved] for part in (self._numbers[:before], self._numbers[before:])
        )
        if above or below:
            to = rest.index(below[0]) if below else rest.index(above[-1]) + 1
            self._editor.do("Reorder patches", partial(reordered, numbers=moved, to=to))

    # What comes from the editor.

    def _on_shown(self, document: MapDocument) -> None:
        before = self._document
        self._document = document
        if before is None or before.skin is not document.skin or before.order != document.order:
            self._arrange()
        elif before.patches != document.patches or before.charts != document.charts:
            if self._wanted:
                self._arrange()
            else:
                self.dataChanged.emit(self.index(0), self.index(len(self._numbers) - 1))

    def _arrange(self) -> None:
        self.beginResetModel()
        self._numbers = ()
        if self._document is not None:
            self._numbers = tuple(k for k in self._document.order if self._wanted in _search_text(self._document, k))
        self.endResetModel()


def reordered(document: MapDocument, numbers: tuple[int, ...], to: int) -> MapDocument:
    """The patches one after the other, the first at place ``to`` of the others."""
    last = len(document.order) - 1
    for number in numbers:
        document = reorder_patch(document, number, last)
    for place, number in enumerate(numbers, start=to):
        document = reorder_patch(document, number, place)
    return document


def show_only(document: MapDocument, numbers: Iterable[int]) -> MapDocument:
    """Only these patches shown."""
    chosen = set(numbers)
    hidden = [k for k in range(len(document.patches)) if k not in chosen]
    return show_patches(show_patches(document, chosen), hidden, visible=False)


def _search_text(document: MapDocument, number: int) -> str:
    return f"{document.patches[number].name} {document.skin.patches[number].link}".casefold()


def _patch_tip(document: MapDocument, number: int) -> str:
    """All that a row has no room for."""
    patch = document.patches[number]
    skin_patch = document.skin.patches[number]
    chart = document.charts[number]
    parts = [f"{patch.name}, on {skin_patch.link}: {len(skin_patch.taxels)} taxels, {len(chart.faces)} triangles"]
    if patch.pins:
        parts.append(f"{len(patch.pins)} pin" + "s" * (len(patch.pins) > 1))
    if len(chart.seams):
        parts.append(f"cut along {len(chart.seams)} edges, {len(patch.seams.drawn)} of them drawn")
    if not patch.visible:
        parts.append("hidden; keeps sensing")
    return "\n".join(parts)


ROW_HEIGHT = 28
EYE_WIDTH = 28
_GAP = 6


class PatchDelegate(QStyledItemDelegate):
    """Draws a row, and keeps the field open while it holds a name that is refused."""

    def __init__(self, model: PatchModel, parent: QObject) -> None:
        super().__init__(parent)
        self._model = model
        self.hovered = -1

    def sizeHint(self, _option: QStyleOptionViewItem, _index: ModelIndex) -> QSize:
        """Qt."""
        return QSize(120, ROW_HEIGHT)

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: ModelIndex) -> None:
        """Qt: eye, name, and at the end of the row seams and pins."""
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        palette = option.palette
        rect = option.rect
        state = option.state
        visible = bool(index.data(VISIBLE_ROLE))
        self._draw_ground(painter, palette, rect, state, hovered=index.data(NUMBER_ROLE) == self.hovered)
        text = palette.color(QPalette.ColorRole.Text)
        quiet = palette.color(QPalette.ColorRole.PlaceholderText) if state & QStyle.StateFlag.State_Enabled else text
        eye = QRectF(rect.left(), rect.top(), EYE_WIDTH, rect.height())
        draw_eye(painter, eye, text if visible else quiet, open_=visible)
        right = self._draw_signs(painter, index, rect, quiet)
        words = QRect(rect.left() + EYE_WIDTH, rect.top(), right - rect.left() - EYE_WIDTH, rect.height())
        name = painter.fontMetrics().elidedText(str(index.data()), Qt.TextElideMode.ElideMiddle, words.width())
        painter.setPen(text if visible else quiet)
        painter.drawText(words, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, name)
        painter.restore()

    def _draw_ground(
        self, painter: QPainter, palette: QPalette, rect: QRect, state: QStyle.StateFlag, *, hovered: bool
    ) -> None:
        accent = QColor(palette.color(QPalette.ColorRole.Link))
        selected = bool(state & QStyle.StateFlag.State_Selected)
        if selected or hovered:
            accent.setAlphaF(0.28 if selected else 0.12)
            painter.fillRect(rect, accent)
        if state & QStyle.StateFlag.State_HasFocus:
            painter.setPen(QPen(palette.color(QPalette.ColorRole.Link), 1))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRect(QRectF(rect).adjusted(0.5, 0.5, -0.5, -0.5))

    def _draw_signs(self, painter: QPainter, index: ModelIndex, rect: QRect, colour: QColor) -> int:
        """The left end of what it drew."""
        right = rect.right() - _GAP
        painted = painter.fontMetrics()
        pins = int(index.data(PINS_ROLE))
        painter.setPen(colour)
        if pins:
            width = painted.horizontalAdvance(f"{pins}")
            box = QRect(right - width, rect.top(), width, rect.height())
            painter.drawText(box, Qt.AlignmentFlag.AlignVCenter, f"{pins}")
            right -= width + GLYPH_SIZE - 2
            draw_pin(painter, QRectF(right, rect.top(), GLYPH_SIZE, rect.height()), colour)
            right -= _GAP
        if index.data(SEAMS_ROLE):
            right -= GLYPH_SIZE
            draw_seam(painter, QRectF(right, rect.top(), GLYPH_SIZE, rect.height()), colour)
            right -= _GAP
        return right

    def createEditor(self, parent: QWidget, _option: QStyleOptionViewItem, _index: ModelIndex) -> QWidget:
        """Qt: a field for the name."""
        field = QLineEdit(parent)
        field.setObjectName("patch-name")
        field.setMaxLength(LONGEST_NAME)
        field.setAccessibleName("Name of the patch")
        return field

    def updateEditorGeometry(self, editor: QWidget, option: QStyleOptionViewItem, _index: ModelIndex) -> None:
        """Qt: where the name is."""
        editor.setGeometry(option.rect.adjusted(EYE_WIDTH - 4, 1, 0, -1))

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

    def setEditorData(self, editor: QWidget, index: ModelIndex) -> None:
        """Qt: the name as it is."""
        self._named = int(index.data(NUMBER_ROLE))
        super().setEditorData(editor, index)


_MAX_ROWS = 9


class PatchList(QListView):
    """The rows; selection goes both ways between it and the editor.

    Args:
        editor: Whose document is shown.
        parent: Qt parent.
    """

    hovered = Signal(object)
    """The number of the patch under the pointer, or None."""

    def __init__(self, editor: MapEditor, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("patch-list")
        self.setAccessibleName("Patches")
        self._editor, self.patches = editor, PatchModel(editor, self)
        self._rows = PatchDelegate(self.patches, self)
        self._following = False
        self.setModel(self.patches)
        self.setItemDelegate(self._rows)
        self._behave()
        self.selectionModel().selectionChanged.connect(self._on_selection_changed)
        self.entered.connect(self._on_entered)
        self.patches.modelAboutToBeReset.connect(self._on_reset_began)
        self.patches.modelReset.connect(self._on_reset)
        editor.selection_changed.connect(self._follow)
        self._on_reset()

    def _behave(self) -> None:
        self.setFrameShape(QListView.Shape.NoFrame)
        self.setUniformItemSizes(True)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setDragDropMode(QAbstractItemView.DragDropMode.DragDrop)
        self.setDefaultDropAction(Qt.DropAction.MoveAction)
        trigger = QAbstractItemView.EditTrigger
        self.setEditTriggers(trigger.DoubleClicked | trigger.EditKeyPressed)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.setMouseTracking(True)
        self.verticalScrollBar().setStyleSheet(SLIM_SCROLL_BAR)

    def show_hover(self, number: int | None) -> None:
        """Tint the row of the patch that the pointer is on elsewhere."""
        marked = -1 if number is None else number
        if marked != self._rows.hovered:
            self._rows.hovered = marked
            self.viewport().update()

    def toggle_visible(self, number: int, *, alone: bool = False) -> None:
        """Show or hide a patch; ``alone``: show only it, or all where it is alone already."""
        document = self._editor.document
        if document is None:
            return
        everyone = range(len(document.patches))
        if not alone:
            visible = not document.patches[number].visible
            name = f"{'Show' if visible else 'Hide'} {document.patches[number].name}"
            self._editor.do(name, partial(show_patches, numbers=[number], visible=visible))
        elif all(document.patches[k].visible == (k == number) for k in everyone):
            self._editor.do("Show all patches", partial(show_patches, numbers=everyone))
        else:
            self._editor.do(f"Show only {document.patches[number].name}", partial(show_only, numbers=[number]))

    # Qt.

    def event(self, event: QEvent) -> bool:
        """Qt: F2 names a patch here, whatever it does in the window."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent) and _is_rename_key(event):
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Qt: Alt with up and down moves what is selected in the tree."""
        arrow = event.key() in (Qt.Key.Key_Up, Qt.Key.Key_Down)
        if event.modifiers() == Qt.KeyboardModifier.AltModifier and arrow:
            rows = sorted(index.row() for index in self.selectedIndexes())
            if rows:
                before = rows[0] - 1 if event.key() == Qt.Key.Key_Up else rows[-1] + 2
                self.patches.move([self.patches.numbers[row] for row in rows], max(before, 0))
        elif event.key() == Qt.Key.Key_F2 and not event.modifiers():
            self.edit(self.currentIndex())
        else:
            super().keyPressEvent(event)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Qt: a press on an eye is no selection."""
        index = self.indexAt(event.position().toPoint())
        if event.button() == Qt.MouseButton.LeftButton and self._on_eye(index, event.position().toPoint()):
            alone = bool(event.modifiers() & Qt.KeyboardModifier.AltModifier)
            self.toggle_visible(int(index.data(NUMBER_ROLE)), alone=alone)
        else:
            super().mousePressEvent(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Qt: the second press on an eye is another press on it."""
        if self._on_eye(self.indexAt(event.position().toPoint()), event.position().toPoint()):
            self.mousePressEvent(event)
        else:
            super().mouseDoubleClickEvent(event)

    def leaveEvent(self, event: QEvent) -> None:
        """Qt: the pointer is on no row."""
        super().leaveEvent(event)
        self._on_entered(QModelIndex())

    def dropEvent(self, event: QDropEvent) -> None:
        """Qt: patches dropped above, below or on a row, as the line shows."""
        if event.mimeData().hasFormat(PATCHES_MIME):
            at = self.indexAt(event.position().toPoint())
            below = self.dropIndicatorPosition() != QAbstractItemView.DropIndicatorPosition.AboveItem
            row = at.row() + below if at.isValid() else len(self.patches.numbers)
            self.patches.dropMimeData(event.mimeData(), event.dropAction(), row, 0, QModelIndex())
            event.accept()
        self.setState(QAbstractItemView.State.NoState)
        self.viewport().update()

    def sizeHint(self) -> QSize:
        """Qt: all rows, up to a few; then they scroll."""
        return QSize(200, ROW_HEIGHT * min(max(len(self.patches.numbers), 1), _MAX_ROWS))

    def _on_eye(self, index: QModelIndex, at: QPoint) -> bool:
        return index.isValid() and at.x() < self.visualRect(index).left() + EYE_WIDTH

    # Between the rows and the editor.

    def _on_entered(self, index: QModelIndex) -> None:
        number = int(index.data(NUMBER_ROLE)) if index.isValid() else None
        self.show_hover(number)
        self.hovered.emit(number)

    def _on_selection_changed(self) -> None:
        if not self._following:
            self._editor.select(int(index.data(NUMBER_ROLE)) for index in self.selectedIndexes())

    def _on_reset_began(self) -> None:
        self._following = True

    def _on_reset(self) -> None:
        self._following = False
        self.setFixedHeight(self.sizeHint().height())
        self._follow()

    def _follow(self) -> None:
        """Select what the editor has selected."""
        selection = QItemSelection()
        rows = [row for number in self._editor.selected if (row := self.patches.row_of(number)) >= 0]
        for row in rows:
            selection.select(self.patches.index(row), self.patches.index(row))
        self._following = True
        self.selectionModel().select(selection, QItemSelectionModel.SelectionFlag.ClearAndSelect)
        if rows and self.currentIndex().row() not in rows:
            self.selectionModel().setCurrentIndex(
                self.patches.index(rows[0]), QItemSelectionModel.SelectionFlag.NoUpdate
            )
        self._following = False


def _is_rename_key(event: QKeyEvent) -> bool:
    return event.key() == Qt.Key.Key_F2 and not event.modifiers()
