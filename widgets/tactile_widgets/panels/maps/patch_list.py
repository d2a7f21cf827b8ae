"""The list of patches: one row per patch, which can be renamed, shown and hidden, selected and dragged.

Contains the glyphs (eye, pin, seam), the item model of the editor's document, the delegate that draws and edits a row,
and the view.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import partial

from PySide6.QtCore import (
    QEvent,
    QItemSelection,
    QItemSelectionModel,
    QMimeData,
    QModelIndex,
    QObject,
    QPoint,
    QPointF,
    QRect,
    QRectF,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QColor, QDropEvent, QKeyEvent, QMouseEvent, QPainter, QPainterPath, QPalette, QPen
from PySide6.QtWidgets import QLineEdit, QListView, QStyle, QStyleOptionViewItem, QWidget

from tactile_maps.core.errors import MapError, counted
from tactile_maps.editing.document import LONGEST_NAME, MapDocument, rename_patch, reorder_patch, show_patches
from tactile_widgets.common.lists import ModelIndex, RowDelegate, SequenceModel, flat_list
from tactile_widgets.common.make import make
from tactile_widgets.document.map_editor import MapEditor

GLYPH_SIZE = 16


@contextmanager
def _glyph(painter: QPainter, box: QRectF, colour: QColor) -> Iterator[None]:
    """Draw with lines of a colour about the centre of ``box``."""
    painter.save()
    painter.translate(box.center())
    painter.setPen(QPen(colour, 1.4, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    yield
    painter.restore()


def draw_eye(painter: QPainter, box: QRectF, colour: QColor, *, open_: bool) -> None:
    """Draw an open eye, or a closed lid with lashes."""
    with _glyph(painter, box, colour):
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


def draw_pin(painter: QPainter, box: QRectF, colour: QColor) -> None:
    """Draw a pin with its head up."""
    with _glyph(painter, box, colour):
        painter.drawLine(QPointF(0, -1), QPointF(0, 6))
        painter.setBrush(colour)
        painter.drawEllipse(QPointF(0, -3), 2.6, 2.6)


def draw_seam(painter: QPainter, box: QRectF, colour: QColor) -> None:
    """Draw a dashed line, as seams are drawn on the map."""
    with _glyph(painter, box, colour):
        pen = QPen(colour, 1.4, Qt.PenStyle.CustomDashLine, Qt.PenCapStyle.FlatCap)
        pen.setDashPattern([2.4, 1.8])
        painter.setPen(pen)
        line = QPainterPath(QPointF(-6, 4))
        line.cubicTo(QPointF(-2, -5), QPointF(2, 5), QPointF(6, -4))
        painter.drawPath(line)


NUMBER_ROLE, VISIBLE_ROLE, PINS_ROLE, SEAMS_ROLE = (int(Qt.ItemDataRole.UserRole) + k for k in range(4))
PATCHES_MIME = "application/x-tactile-maps-patches"


class PatchModel(SequenceModel):
    """Item model with one row per patch, in the order of the patch tree.

    With a filter, only patches are listed whose name or link contains it.

    The items are the numbers of the patches. All changes by the user go through the editor.

    Attributes:
        document: The document whose patches are listed.
    """

    rejected = Signal(str)
    """Why a name was rejected; empty after an accepted one."""

    def __init__(self, editor: MapEditor, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._editor = editor
        self._filter = ""
        self._recorded: MapDocument | None = None
        self.document: MapDocument | None = None
        editor.shown.connect(self._update)
        self._update()

    @property
    def recorded(self) -> bool:
        """True if the patches of a recording are listed, which cannot be changed."""
        return self._recorded is not None

    def show_recorded(self, document: MapDocument | None) -> None:
        """List the patches of a recording instead of those of the editor's document, or the latter again."""
        self._recorded = document
        self._update()

    def set_filter(self, words: str) -> None:
        """List only patches whose name or link contains this text."""
        self._filter = words.strip().casefold()
        self._arrange()

    def row_of(self, number: int) -> int:
        """Return the row of a patch; -1 if it is filtered out."""
        return self.items.index(number) if number in self.items else -1

    def value(self, row: int, role: int) -> object:
        if self.document is None:
            return None
        number = self.items[row]
        patch = self.document.patches[number]
        match role:
            case Qt.ItemDataRole.DisplayRole | Qt.ItemDataRole.EditRole:
                return patch.name
            case Qt.ItemDataRole.ToolTipRole:
                return _patch_tip(self.document, number)
            case Qt.ItemDataRole.AccessibleTextRole:
                return patch.name if patch.visible else f"{patch.name}, hidden"
        values = {
            NUMBER_ROLE: number,
            VISIBLE_ROLE: patch.visible,
            PINS_ROLE: len(patch.pins),
            SEAMS_ROLE: len(self.document.charts[number].seams),
        }
        return values.get(role)

    def flags(self, index: ModelIndex) -> Qt.ItemFlag:
        flag = Qt.ItemFlag
        if not index.isValid():
            return flag.ItemIsDropEnabled
        return flag.ItemIsEnabled | flag.ItemIsSelectable | flag.ItemIsEditable | flag.ItemIsDragEnabled

    def why_rejected(self, number: int, name: str) -> str:
        """Return why a name would be rejected; empty if it would be accepted."""
        try:
            if self.document is not None:
                rename_patch(self.document, number, name)
        except MapError as error:
            return str(error)
        return ""

    def setData(self, index: ModelIndex, value: object, role: int = Qt.ItemDataRole.EditRole) -> bool:
        """Rename a patch, unless the name is rejected."""
        if role != Qt.ItemDataRole.EditRole or not index.isValid():
            return False
        number = self.items[index.row()]
        name = str(value)
        why = self.why_rejected(number, name)
        self.rejected.emit(why)
        return not why and self._editor.do("Rename a patch", partial(rename_patch, number=number, name=name))

    # Dragging.

    def supportedDropActions(self) -> Qt.DropAction:
        return Qt.DropAction.MoveAction

    def mimeTypes(self) -> list[str]:
        return [PATCHES_MIME]

    def mimeData(self, indexes: Iterable[QModelIndex]) -> QMimeData:
        """Return the numbers of the patches, as text."""
        data = QMimeData()
        rows = sorted(index.row() for index in indexes)
        data.setData(PATCHES_MIME, " ".join(str(self.items[row]) for row in rows).encode())
        return data

    def dropMimeData(self, data: QMimeData, _action: Qt.DropAction, row: int, _column: int, parent: ModelIndex) -> bool:
        """Move patches before ``row``, or on or below the row of ``parent``."""
        moved = [int(word) for word in bytes(data.data(PATCHES_MIME).data()).split()]
        before = row if row >= 0 else parent.row() if parent.isValid() else len(self.items)
        self.move(moved, before)
        return False  # the editor has moved them, and Qt must not remove the old rows

    def move(self, numbers: Iterable[int], before: int) -> None:
        """Move patches before the row ``before``, in the given order."""
        if self.document is None:
            return
        moved = tuple(numbers)
        rest = [k for k in self.document.order if k not in moved]
        above, below = ([k for k in part if k not in moved] for part in (self.items[:before], self.items[before:]))
        if above or below:
            to = rest.index(below[0]) if below else rest.index(above[-1]) + 1
            self._editor.do("Reorder patches", partial(reordered, numbers=moved, to=to))

    def _update(self) -> None:
        before = self.document
        document = self.document = self._editor.document if self._recorded is None else self._recorded
        if before is None or document is None or before.skin is not document.skin or before.order != document.order:
            self._arrange()
        elif before.patches != document.patches or before.charts != document.charts:
            if self._filter:
                self._arrange()
            else:
                self.dataChanged.emit(self.index(0), self.index(len(self.items) - 1))

    def _arrange(self) -> None:
        document = self.document
        shown = () if document is None else (k for k in document.order if self._filter in _search_text(document, k))
        self.show_items(tuple(shown))


def reordered(document: MapDocument, numbers: tuple[int, ...], to: int) -> MapDocument:
    """Move patches, one after the other, to the place ``to`` among the others."""
    last = len(document.order) - 1
    for number in numbers:
        document = reorder_patch(document, number, last)
    for place, number in enumerate(numbers, start=to):
        document = reorder_patch(document, number, place)
    return document


def show_only(document: MapDocument, numbers: Iterable[int]) -> MapDocument:
    """Show these patches, and hide the others."""
    chosen = set(numbers)
    hidden = [k for k in range(len(document.patches)) if k not in chosen]
    return show_patches(show_patches(document, chosen), hidden, visible=False)


def _search_text(document: MapDocument, number: int) -> str:
    return f"{document.patches[number].name} {document.skin.patches[number].link}".casefold()


def _patch_tip(document: MapDocument, number: int) -> str:
    """Return the facts that do not fit into a row."""
    patch = document.patches[number]
    skin_patch = document.skin.patches[number]
    chart = document.charts[number]
    size = f"{counted(len(skin_patch.taxels), 'taxel')}, {counted(len(chart.faces), 'triangle')}"
    parts = [f"{patch.name}, on {skin_patch.link}: {size}"]
    if patch.pins:
        parts.append(counted(len(patch.pins), "pin"))
    if len(chart.seams):
        parts.append(f"cut along {counted(len(chart.seams), 'edge')}, {len(patch.seams.drawn)} of them drawn")
    if not patch.visible:
        parts.append("hidden; keeps sensing")
    return "\n".join(parts)


ROW_HEIGHT = 28
EYE_WIDTH = 28
_GAP = 6


class PatchDelegate(RowDelegate):
    """Draws a row, and keeps the name field open while it contains a name that is rejected."""

    def __init__(self, model: PatchModel, parent: QObject) -> None:
        super().__init__(ROW_HEIGHT, parent)
        self._model = model
        self.hovered = -1

    def draw(self, painter: QPainter, option: QStyleOptionViewItem, index: ModelIndex) -> None:
        """Draw the eye, the name, and at the end of the row seams and pins."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        palette = option.palette
        rect = option.rect
        state = option.state
        visible = bool(index.data(VISIBLE_ROLE))
        self._draw_background(painter, palette, rect, state, hovered=index.data(NUMBER_ROLE) == self.hovered)
        text = palette.color(QPalette.ColorRole.Text)
        quiet = palette.color(QPalette.ColorRole.PlaceholderText) if state & QStyle.StateFlag.State_Enabled else text
        eye = QRectF(rect.left(), rect.top(), EYE_WIDTH, rect.height())
        draw_eye(painter, eye, text if visible else quiet, open_=visible)
        right = self._draw_signs(painter, index, rect, quiet)
        words = QRect(rect.left() + EYE_WIDTH, rect.top(), right - rect.left() - EYE_WIDTH, rect.height())
        name = painter.fontMetrics().elidedText(str(index.data()), Qt.TextElideMode.ElideMiddle, words.width())
        painter.setPen(text if visible else quiet)
        painter.drawText(words, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, name)

    def _draw_background(
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
        """Draw pins and seams, and return their left end."""
        right = rect.right() - _GAP
        pins = int(index.data(PINS_ROLE))
        painter.setPen(colour)
        if pins:
            width = painter.fontMetrics().horizontalAdvance(f"{pins}")
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
        return make(
            QLineEdit, parent, objectName="patch-name", maxLength=LONGEST_NAME, accessibleName="Name of the patch"
        )

    def updateEditorGeometry(self, editor: QWidget, option: QStyleOptionViewItem, _index: ModelIndex) -> None:
        editor.setGeometry(option.rect.adjusted(EYE_WIDTH - 4, 1, 0, -1))

    def eventFilter(self, editor: QObject, event: QEvent) -> bool:
        """Keep the field open, and show the reason, when Enter or Tab confirms a name that is rejected."""
        enter = (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Tab)
        if isinstance(event, QKeyEvent) and event.type() == QEvent.Type.KeyPress and isinstance(editor, QLineEdit):
            if event.key() == Qt.Key.Key_Escape:
                self._model.rejected.emit("")
            elif event.key() in enter and (why := self._model.why_rejected(self._named, editor.text())):
                self._model.rejected.emit(why)
                editor.selectAll()
                return True
        return super().eventFilter(editor, event)

    def setEditorData(self, editor: QWidget, index: ModelIndex) -> None:
        self._named = int(index.data(NUMBER_ROLE))
        super().setEditorData(editor, index)


_MAX_ROWS = 9


class PatchList(QListView):
    """The list; its selection and that of the editor follow each other.

    Args:
        editor: Editor whose document is shown.
        parent: Qt parent.
    """

    hovered = Signal(object)
    """Number of the patch under the pointer, or None."""

    def __init__(self, editor: MapEditor, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        flat_list(self, "patch-list", "Patches")
        self._editor = editor
        self.patches = PatchModel(editor, self)
        self._rows = PatchDelegate(self.patches, self)
        self._following = False
        self.setModel(self.patches)
        self.setItemDelegate(self._rows)
        self.setUniformItemSizes(True)
        self.setSelectionMode(QListView.SelectionMode.ExtendedSelection)
        self.setDragDropMode(QListView.DragDropMode.DragDrop)
        self.setDefaultDropAction(Qt.DropAction.MoveAction)
        self.setEditTriggers(QListView.EditTrigger.DoubleClicked | QListView.EditTrigger.EditKeyPressed)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.setMouseTracking(True)
        self.selectionModel().selectionChanged.connect(self._on_selection_changed)
        self.entered.connect(self._on_entered)
        self.patches.modelAboutToBeReset.connect(self._on_reset_began)
        self.patches.modelReset.connect(self._on_reset)
        editor.selection_changed.connect(self._follow)
        self._on_reset()

    def show_hover(self, number: int | None) -> None:
        """Highlight the row of the patch under the pointer in a view."""
        marked = -1 if number is None else number
        if marked != self._rows.hovered:
            self._rows.hovered = marked
            self.viewport().update()

    def toggle_visible(self, number: int, *, alone: bool = False) -> None:
        """Show or hide a patch; with ``alone``, show only this patch, or all if no other is visible."""
        document = self._editor.document
        if document is None:
            return
        every = range(len(document.patches))
        if not alone:
            visible = not document.patches[number].visible
            name = f"{'Show' if visible else 'Hide'} {document.patches[number].name}"
            self._editor.do(name, partial(show_patches, numbers=[number], visible=visible))
        elif all(document.patches[k].visible == (k == number) for k in every):
            self._editor.do("Show all patches", partial(show_patches, numbers=every))
        else:
            self._editor.do(f"Show only {document.patches[number].name}", partial(show_only, numbers=[number]))

    def event(self, event: QEvent) -> bool:
        """Reserve F2 for the name of a patch, whatever its action in the window."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent) and _is_rename_key(event):
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Move the selected patches with Alt+Up and Alt+Down; rename with F2."""
        arrow = event.key() in (Qt.Key.Key_Up, Qt.Key.Key_Down)
        if event.modifiers() == Qt.KeyboardModifier.AltModifier and arrow:
            rows = sorted(index.row() for index in self.selectedIndexes())
            if rows:
                before = rows[0] - 1 if event.key() == Qt.Key.Key_Up else rows[-1] + 2
                self.patches.move([self.patches.items[row] for row in rows], max(before, 0))
        elif _is_rename_key(event):
            self.edit(self.currentIndex())
        else:
            super().keyPressEvent(event)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Show or hide a patch by a press on its eye, which does not select it."""
        index = self.indexAt(event.position().toPoint())
        if event.button() == Qt.MouseButton.LeftButton and self._on_eye(index, event.position().toPoint()):
            alone = bool(event.modifiers() & Qt.KeyboardModifier.AltModifier)
            self.toggle_visible(int(index.data(NUMBER_ROLE)), alone=alone)
        else:
            super().mousePressEvent(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Treat the second press on an eye as another press."""
        if self._on_eye(self.indexAt(event.position().toPoint()), event.position().toPoint()):
            self.mousePressEvent(event)
        else:
            super().mouseDoubleClickEvent(event)

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        self._on_entered(QModelIndex())

    def dropEvent(self, event: QDropEvent) -> None:
        """Move dropped patches above, below or onto a row, as the drop indicator shows."""
        if event.mimeData().hasFormat(PATCHES_MIME):
            at = self.indexAt(event.position().toPoint())
            below = self.dropIndicatorPosition() != QListView.DropIndicatorPosition.AboveItem
            row = at.row() + below if at.isValid() else len(self.patches.items)
            self.patches.dropMimeData(event.mimeData(), event.dropAction(), row, 0, QModelIndex())
            event.accept()
        self.setState(QListView.State.NoState)
        self.viewport().update()

    def sizeHint(self) -> QSize:
        """Return the height of all rows, up to a maximum from which they scroll."""
        return QSize(200, ROW_HEIGHT * min(max(len(self.patches.items), 1), _MAX_ROWS))

    def _on_eye(self, index: QModelIndex, at: QPoint) -> bool:
        return index.isValid() and at.x() < self.visualRect(index).left() + EYE_WIDTH

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
        """Select the patches that are selected in the editor."""
        selection = QItemSelection()
        selected = () if self.patches.recorded else self._editor.selected
        rows = [row for number in selected if (row := self.patches.row_of(number)) >= 0]
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
