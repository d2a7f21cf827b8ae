"""The contact regions now: where, how hard, how large, how well told; a click on one selects it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QGridLayout, QLabel, QPushButton, QWidget

from app.contacts.estimators.estimate import ForceEstimate
from app.contacts.reading_settings import ReadingSettings
from app.contacts.region import ContactRegion
from app.scene.effects import Effects
from app.session.frame import Frame
from widgets.panels.estimate_words import estimate_words
from widgets.panels.panel import Panel, fact
from widgets.panels.reading_box import ReadingBox
from widgets.panels.reading_choices import SHEAR, SHEAR_TIP
from widgets.selection import Selection, region_ink

_ROWS = 3
"""More than that is rare; the line above counts and sums all of them."""
_FORCE_TIP = "Normal force, as the way chosen above finds it; control sees the same."
_ESTIMATE_TIP = (
    "Of the same contact: how many of the forces on its taxels the readings tell apart above their noise,\n"
    "how many times errors may grow on the way, and what the answer leaves unexplained. A residual near the\n"
    "noise is as good as can be; far above it, the model of the cover is wrong. Where less than half can be\n"
    "told apart, no distribution is given, and the contact keeps the sum of pressure times area."
)
_FACTS_TIP = (
    "Of the selected contact, or else the strongest: force and place with their standard uncertainties\n"
    "(the sensor's noise, gains and the taxels' spacing), mean pressure, and the size of the ellipse it covers."
)
_NO_FACTS = "\n"
"""As high as facts."""
_ESTIMATE_LINES = 4
"""As high as the longest estimate; the rows below never jump."""
_ROW_STYLE = """
    QPushButton { border: 0; border-radius: 4px; padding: 0; margin: -2px -6px; background: transparent; }
    QPushButton:enabled:hover { background: rgba(128, 140, 152, 40); }
    QPushButton:checked { background: rgba(34, 184, 207, 70); }
    QPushButton:focus { border: 1px solid #22b8cf; }
"""


_ROW_TIP = "Highlight the trace of this contact; once more, of none"
_NAME_PX = 96
"""What the column leaves for a link's name."""


class ContactRow:
    """One row of the panel's grid: a button under the facts about one region.

    Args:
        row: Number in the grid.
        grid: Where to stand.
        parent: Qt parent.
    """

    def __init__(self, row: int, grid: QGridLayout, parent: QWidget) -> None:
        self.region: int | None = None
        self.button = QPushButton(parent)
        self.button.setObjectName(f"contact-{row}")
        self.button.setCheckable(True)
        self.button.setStyleSheet(_ROW_STYLE)
        grid.addWidget(self.button, row, 0, 1, 5)
        self._mark = fact("", parent)
        self._cells = [fact("", parent, right=column > 0) for column in range(4)]
        for column, cell in enumerate((self._mark, *self._cells)):
            cell.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
            cell.setFixedHeight(cell.fontMetrics().height() + 2)
            grid.addWidget(cell, row, column)
        self.button.setFixedHeight(self._mark.height())
        for cell in self._cells:
            cell.setMinimumWidth(48)

    def show(self, region: ContactRegion | None, *, selected: bool, estimate: ForceEstimate | None = None) -> None:
        """Say what is known of a region; None empties the row. Where its force was estimated, the tip says how well."""
        texts, ink = ["", "", "", ""], ""
        if region is not None:
            metrics = self._cells[0].fontMetrics()
            name = metrics.elidedText(region.link, Qt.TextElideMode.ElideMiddle, _NAME_PX)
            texts = [name, f"{region.force:.2f}", f"{1e-3 * region.peak:.1f}", f"{1e6 * region.area:.0f}"]
            ink = f'<span style="color:{region_ink(region.id)}">●</span>'
        self.region = None if region is None else region.id
        self.button.setEnabled(region is not None)
        self.button.setChecked(selected)
        self.button.setToolTip(f"{estimate_words(estimate)}\n\n{_ROW_TIP}" if estimate else _ROW_TIP)
        self.button.setAccessibleName("" if region is None else f"Contact on {region.link}, {texts[1]} N")
        for cell, text in zip((self._mark, *self._cells), (ink, *texts), strict=True):
            if cell.text() != text:
                cell.setText(text)


def facts(region: ContactRegion, among: Sequence[ContactRegion]) -> str:
    """What is known of a region, in two lines; a third names the one among ``among`` that it touches."""
    long, short = 2e3 * np.linalg.norm(region.axes, axis=1)
    size = f"{long:.0f} × {short:.0f}\u2009mm" if long > 0 else "of unknown shape"
    lines = [
        f"{region.force:.2f} ± {region.force_error:.2f}\u2009N, centre ± {1e3 * region.place_error:.1f}\u2009mm",
        f"Mean {1e-3 * region.mean:.1f}\u2009kPa, {size}",
    ]
    lines += [f"Touches {other.link.replace('_', ' ')}" for other in among if other.id == region.partner]
    return "\n".join(lines)


class ContactsPanel(Panel):
    """A few rows that never jump: fixed in number, the older region above the younger, tabular in digits."""

    region_selected = Signal(object)
    """The row of a region was clicked: its id; None if it was selected already."""
    reading_edited = Signal(object)
    """ReadingSettings wanted."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Contacts", "contacts-panel", parent)
        self._summary: QLabel = self.caption()
        self._summary.setObjectName("contacts-summary")
        self._selected: int | None = None
        self._regions: tuple[ContactRegion, ...] = ()
        self._estimates: Mapping[int, ForceEstimate] = {}
        grid = self.grid()
        grid.setHorizontalSpacing(8)
        for column, text in enumerate(("On", "N", "kPa", "mm²"), start=1):
            head = fact(text, self, right=column > 1)
            head.setProperty("role", "caption")
            head.setToolTip(_FORCE_TIP if text == "N" else "")
            grid.addWidget(head, 0, column)
        self._rows = [ContactRow(row + 1, grid, self) for row in range(_ROWS)]
        for row in self._rows:
            row.button.clicked.connect(self._on_row_clicked)
        grid.setColumnStretch(1, 1)
        self._facts: QLabel = self.caption()
        self._facts.setObjectName("contacts-facts")
        self._facts.setToolTip(_FACTS_TIP)
        self._told: QLabel = self.caption()
        self._told.setObjectName("contacts-estimate")
        self._told.setToolTip(_ESTIMATE_TIP)
        self._told.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.reading = ReadingBox(self)
        self.reading.reading_edited.connect(self._on_reading_edited)
        self.column.addWidget(self.reading)
        shear = self.caption(SHEAR)
        shear.setObjectName("contacts-shear")
        shear.setToolTip(SHEAR_TIP)
        self.show_reading(ReadingSettings())
        self.clear()

    def show_reading(self, settings: ReadingSettings) -> None:
        """Show how contacts are read; what that says of its own answers has its place, or takes none."""
        self.reading.show_reading(settings)
        self._told.setVisible(settings.estimator != "area-sum")
        self._told.setFixedHeight(_ESTIMATE_LINES * self._told.fontMetrics().lineSpacing())

    def show_effects(self, effects: Effects) -> None:
        """The noise in force is part of what the usual threshold means."""
        self.reading.show_effects(effects)

    def set_editable(self, *, editable: bool) -> None:
        """Let a person change how contacts are read, or not; they may be selected anyhow."""
        self.reading.setEnabled(editable)

    def follow(self, selection: Selection) -> None:
        """Select there, and highlight what is selected there, from now on."""
        self.region_selected.connect(selection.select_region)
        selection.region_changed.connect(self.select_region)
        self.select_region(selection.region)

    def clear(self) -> None:
        """Nothing is touched."""
        self._regions, self._estimates = (), {}
        self._summary.setText("Nothing touches the skin: press it in a view.")
        self._fill()

    def show_frame(self, frame: Frame) -> None:
        """The strongest regions of a frame, and the selected one."""
        self._regions, self._estimates = frame.regions, frame.estimates
        if not frame.regions:
            self.clear()
            return
        noun = "contact" if len(frame.regions) == 1 else "contacts"
        force = sum(region.force for region in frame.regions)
        self._summary.setText(f"{len(frame.regions)} {noun}, {force:.1f}\u2009N in all")
        self._fill()

    def select_region(self, region: int | None) -> None:
        """Highlight the row of the region with this id; None for none."""
        self._selected = region
        self._fill()

    def _fill(self) -> None:
        first = sorted(self._regions, key=lambda region: region.id != self._selected)[:_ROWS]
        shown = sorted(first, key=lambda region: region.id)
        for number, row in enumerate(self._rows):
            region = shown[number] if number < len(shown) else None
            known = None if region is None else self._estimates.get(region.id)
            row.show(region, selected=region is not None and region.id == self._selected, estimate=known)
        self._facts.setText(facts(first[0], self._regions) if first else _NO_FACTS)
        told = self._estimates.get(first[0].id) if first else None
        self._told.setEnabled(told is not None and not told.refused)
        self._told.setText(estimate_words(told) if told is not None else "")

    def _on_reading_edited(self, settings: ReadingSettings) -> None:
        self.show_reading(settings)
        self.reading_edited.emit(settings)

    def _on_row_clicked(self) -> None:
        row = next(row for row in self._rows if row.button is self.sender())
        again = row.region == self._selected
        self._fill()  # the button has turned by itself; only the selection decides
        self.region_selected.emit(None if again else row.region)
