"""Tree of the links of a robot with a check box for each that can be covered, its area and its number of taxels."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QKeyEvent, QShowEvent
from PySide6.QtWidgets import QHeaderView, QTreeWidget, QTreeWidgetItem, QWidget

from tactile_maps.skin.fitting.cover import CoverCandidate
from tactile_widgets.common.lists import flat_list

_MOST_ROWS = 9
_INDENTATION = 10
_LINK, _AREA, _TAXELS = range(3)
_WIDTHS = {_AREA: 52, _TAXELS: 52}
_OWN_TIP = int(Qt.ItemDataRole.UserRole)
"""Role of the tool tip of a row without the reason why it has no taxels."""
PENDING = "…"
"""Text in place of a number of taxels that is being computed."""


class LinkTree(QTreeWidget):
    """Rows of links, nested where the robot branches: a chain of links is a plain list."""

    links_changed = Signal()
    """The user checked or unchecked a link."""
    became_visible = Signal()
    """The tree is shown, after it was hidden."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        flat_list(self, "skin-links", "Links")
        self.setHeaderLabels(["Link", "cm²", "Taxels"])
        self.headerItem().setToolTip(_LINK, "Space checks or unchecks the selected link, Delete unchecks it")
        self.headerItem().setToolTip(_AREA, "Outer area of the link that no other link covers")
        for column in (_AREA, _TAXELS):
            self.headerItem().setTextAlignment(column, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        header = self.header()
        header.setStretchLastSection(False)
        header.setSectionResizeMode(_LINK, QHeaderView.ResizeMode.Stretch)
        for column, width in _WIDTHS.items():
            header.setSectionResizeMode(column, QHeaderView.ResizeMode.Fixed)
            header.resizeSection(column, width)
        self.setIndentation(_INDENTATION)
        self.setRootIsDecorated(False)
        self.setItemsExpandable(False)
        self.setUniformRowHeights(True)
        self.setTextElideMode(Qt.TextElideMode.ElideMiddle)  # names of a robot often begin alike
        self.setTabKeyNavigation(False)
        self.rows: dict[str, QTreeWidgetItem] = {}
        self._reserved = False
        self.itemChanged.connect(self._on_item_changed)

    def show_candidates(self, candidates: Sequence[CoverCandidate]) -> None:
        """List the links of a robot, all unchecked."""
        children = Counter(candidate.parent for candidate in candidates)
        self.rows = {}
        with QSignalBlocker(self):
            self.clear()
            for candidate in candidates:
                above = self.rows.get(candidate.parent)
                if above is not None and children[candidate.parent] == 1:
                    above = above.parent()
                row = self.rows[candidate.link] = _row(candidate)
                if above is None:
                    self.addTopLevelItem(row)
                else:
                    above.addChild(row)
            self.expandAll()
        self._reserved = self._reserved and bool(self.rows)
        self._fit(_MOST_ROWS if self._reserved else len(self.rows))

    def reserve(self) -> None:
        """Give the empty list its maximum height until the links of another robot are listed.

        What is below does not move then when the links appear.
        """
        self._reserved = True
        with QSignalBlocker(self):
            self.addTopLevelItem(_row(CoverCandidate("", 0.0, moves=False)))
            self._fit(_MOST_ROWS)
            self.clear()

    def _fit(self, rows: int) -> None:
        """Give the list the height of a number of rows, as high as the first one, up to the maximum."""
        rows = min(max(rows, 1), _MOST_ROWS)
        self.setFixedHeight(self.header().sizeHint().height() + rows * max(self.sizeHintForRow(0), 1) + 2)

    def show_areas(self, candidates: Sequence[CoverCandidate]) -> None:
        """Show the areas of the links that are listed."""
        with QSignalBlocker(self):
            for candidate in candidates:
                self.rows[candidate.link].setText(_AREA, _area_text(candidate))

    @property
    def checked(self) -> tuple[str, ...]:
        """Checked links, in the order of the robot."""
        return tuple(link for link, row in self.rows.items() if row.checkState(_LINK) is Qt.CheckState.Checked)

    def check(self, links: Iterable[str]) -> None:
        """Check these links, and no others, without emitting."""
        chosen = set(links)
        with QSignalBlocker(self):
            for link, row in self.rows.items():
                if row.flags() & Qt.ItemFlag.ItemIsUserCheckable:
                    row.setCheckState(_LINK, Qt.CheckState.Checked if link in chosen else Qt.CheckState.Unchecked)

    def show_counts(self, counts: Mapping[str, int] | None, bare: Mapping[str, str] | None = None) -> None:
        """Show the number of taxels of each link, in tool tips the reasons why links have none.

        Args:
            counts: Number of taxels by link; None while those of the checked links are being computed.
            bare: Reasons by link.
        """
        checked = self.checked
        with QSignalBlocker(self):
            for link, row in self.rows.items():
                known = "" if link not in checked else PENDING if counts is None else f"{counts.get(link, 0):,}"
                row.setText(_TAXELS, f"{counts[link]:,}" if counts is not None and link in counts else known)
                own = row.data(_LINK, _OWN_TIP)
                tip = f"{own}; {bare[link]}" if bare is not None and link in bare else own
                for column in range(3):
                    row.setToolTip(column, tip)

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.became_visible.emit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Uncheck the selected link at Delete and Backspace."""
        row = self.currentItem()
        if event.key() not in (Qt.Key.Key_Delete, Qt.Key.Key_Backspace):
            super().keyPressEvent(event)
        elif row is not None and row.checkState(_LINK) is Qt.CheckState.Checked:
            row.setCheckState(_LINK, Qt.CheckState.Unchecked)

    def _on_item_changed(self, _row: QTreeWidgetItem, column: int) -> None:
        if column == _LINK:
            self.links_changed.emit()


def _area_text(candidate: CoverCandidate) -> str:
    return f"{1e4 * candidate.area:.0f}" if candidate.area else ""


def _row(candidate: CoverCandidate) -> QTreeWidgetItem:
    row = QTreeWidgetItem([candidate.link, _area_text(candidate), ""])
    flags = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable | Qt.ItemFlag.ItemIsUserCheckable
    moves = "moves" if candidate.moves else "does not move"
    if candidate.reason:
        row.setFlags(Qt.ItemFlag.NoItemFlags)
        tip = f"{candidate.link} cannot be covered: {candidate.reason}"
    else:
        row.setFlags(flags)
        row.setCheckState(_LINK, Qt.CheckState.Unchecked)
        tip = f"{candidate.link} {moves}"
    row.setData(_LINK, _OWN_TIP, tip)
    for column in range(3):
        row.setToolTip(column, tip)
        if column:
            row.setTextAlignment(column, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
    return row
