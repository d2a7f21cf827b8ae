"""The patches of the editor's document as a list model: names, what is shown of them, and in which order."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from PySide6.QtCore import QAbstractListModel, QMimeData, QModelIndex, QObject, QPersistentModelIndex, Qt, Signal

from app.editing.document import MapDocument
from app.editing.patches import rename, reorder, show
from app.errors import MapError
from widgets.editor import Editor

Index = QModelIndex | QPersistentModelIndex
NUMBER, VISIBLE, PINS, SEAMS = (int(Qt.ItemDataRole.UserRole) + k for k in range(4))
MIME = "application/x-tactile-maps-patches"
_NOWHERE = QModelIndex()


class PatchModel(QAbstractListModel):
    """One row a patch, in the order of the patch tree; with ``wanted`` words only those whose names have them.

    Everything a hand does to it goes through the editor; the model only shows what comes.
    """

    refused = Signal(str)
    """Why a name was not taken; empty when one was."""

    def __init__(self, editor: Editor, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._editor, self._wanted = editor, ""
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

    def rowCount(self, parent: Index = _NOWHERE) -> int:
        """Qt."""
        return 0 if parent.isValid() else len(self._numbers)

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        """Qt."""
        if self._document is None or not index.isValid():
            return None
        number = self._numbers[index.row()]
        patch = self._document.patches[number]
        match role:
            case Qt.ItemDataRole.DisplayRole | Qt.ItemDataRole.EditRole:
                return patch.name
            case Qt.ItemDataRole.ToolTipRole:
                return _told(self._document, number)
            case Qt.ItemDataRole.AccessibleTextRole:
                return patch.name if patch.visible else f"{patch.name}, hidden"
        values = {
            NUMBER: number, VISIBLE: patch.visible, PINS: len(patch.pins),
            SEAMS: len(self._document.charts[number].seams),
        }  # fmt: skip
        return values.get(role)

    def flags(self, index: Index) -> Qt.ItemFlag:
        """Qt: rows can be named and dragged, and something dropped between them."""
        flag = Qt.ItemFlag
        if not index.isValid():
            return flag.ItemIsDropEnabled
        return flag.ItemIsEnabled | flag.ItemIsSelectable | flag.ItemIsEditable | flag.ItemIsDragEnabled

    def refusal(self, number: int, name: str) -> str:
        """Why ``name`` would not be taken; empty if it would."""
        try:
            if self._document is not None:
                rename(self._document, number, name)
        except MapError as error:
            return str(error)
        return ""

    def setData(self, index: Index, value: object, role: int = Qt.ItemDataRole.EditRole) -> bool:
        """Qt: a patch gets another name, unless that is refused."""
        if role != Qt.ItemDataRole.EditRole or not index.isValid():
            return False
        number, name = self._numbers[index.row()], str(value)
        why = self.refusal(number, name)
        self.refused.emit(why)
        return not why and self._editor.do("Rename a patch", partial(rename, number=number, name=name))

    # Dragging.

    def supportedDropActions(self) -> Qt.DropAction:
        """Qt."""
        return Qt.DropAction.MoveAction

    def mimeTypes(self) -> list[str]:
        """Qt."""
        return [MIME]

    def mimeData(self, indexes: Iterable[QModelIndex]) -> QMimeData:
        """Qt: the numbers of the rows, as text."""
        data = QMimeData()
        rows = sorted(index.row() for index in indexes)
        data.setData(MIME, " ".join(str(self._numbers[row]) for row in rows).encode())
        return data

    def dropMimeData(self, data: QMimeData, _action: Qt.DropAction, row: int, _column: int, parent: Index) -> bool:
        """Qt: patches dropped before ``row``, or on or below what is there."""
        moved = [int(word) for word in bytes(data.data(MIME).data()).split()]
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
            self._editor.do("Reorder patches", partial(moved_to, numbers=moved, to=to))

    # What comes from the editor.

    def _on_shown(self, document: MapDocument) -> None:
        before, self._document = self._document, document
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
            self._numbers = tuple(k for k in self._document.order if self._wanted in _words(self._document, k))
        self.endResetModel()


def moved_to(document: MapDocument, numbers: tuple[int, ...], to: int) -> MapDocument:
    """The patches one after the other, the first at place ``to`` of the others."""
    last = len(document.order) - 1
    for number in numbers:
        document = reorder(document, number, last)
    for place, number in enumerate(numbers, start=to):
        document = reorder(document, number, place)
    return document


def only(document: MapDocument, numbers: Iterable[int]) -> MapDocument:
    """Only these patches shown."""
    chosen = set(numbers)
    hidden = [k for k in range(len(document.patches)) if k not in chosen]
    return show(show(document, chosen), hidden, visible=False)


def _words(document: MapDocument, number: int) -> str:
    return f"{document.patches[number].name} {document.skin.patches[number].link}".casefold()


def _told(document: MapDocument, number: int) -> str:
    """All that a row has no room for."""
    patch, worn, chart = document.patches[number], document.skin.patches[number], document.charts[number]
    parts = [f"{patch.name}, on {worn.link}: {len(worn.taxels)} taxels, {len(chart.faces)} triangles"]
    if patch.pins:
        parts.append(f"{len(patch.pins)} pin" + "s" * (len(patch.pins) > 1))
    if len(chart.seams):
        parts.append(f"cut along {len(chart.seams)} edges, {len(patch.seams.drawn)} of them drawn")
    if not patch.visible:
        parts.append("hidden; it feels and is controlled all the same")
    return "\n".join(parts)
