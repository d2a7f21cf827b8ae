"""The contact regions now: where, how hard, how large."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

from app.session.frame import Frame
from widgets.panels.panel import Panel, fact

_ROWS = 3
"""More than that is rare; the line above counts and sums all of them."""


class ContactsPanel(Panel):
    """A few rows that never jump: fixed in number, tabular in digits."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Contacts", "contacts-panel", parent)
        self._summary = self.caption()
        self._summary.setObjectName("contacts-summary")
        grid = self.grid()
        self._cells = []
        for column, text in enumerate(("On", "N", "kPa", "mm²")):
            head = fact(text, self, right=column > 0)
            head.setProperty("role", "caption")
            grid.addWidget(head, 0, column)
        for row in range(_ROWS):
            cells = [fact("", self, right=column > 0) for column in range(4)]
            for column, cell in enumerate(cells):
                grid.addWidget(cell, row + 1, column)
                cell.setMinimumWidth(48)
                cell.setFixedHeight(cell.fontMetrics().height() + 2)
            self._cells.append(cells)
        grid.setColumnStretch(0, 1)
        self.clear()

    def clear(self) -> None:
        """Nothing is touched."""
        self._summary.setText("Nothing touches the skin: press it in a view.")
        for cells in self._cells:
            for cell in cells:
                cell.setText("")

    def show_frame(self, frame: Frame) -> None:
        """The strongest regions of a frame."""
        regions = frame.regions
        if not regions:
            self.clear()
            return
        noun = "contact" if len(regions) == 1 else "contacts"
        self._summary.setText(f"{len(regions)} {noun}, {sum(region.force for region in regions):.1f}\u2009N in all")
        for number, cells in enumerate(self._cells):
            texts = ["", "", "", ""]
            if number < len(regions):
                region = regions[number]
                texts = [region.link, f"{region.force:.2f}", f"{1e-3 * region.peak:.1f}", f"{1e6 * region.area:.0f}"]
            for cell, text in zip(cells, texts, strict=True):
                if cell.text() != text:
                    cell.setText(text)
