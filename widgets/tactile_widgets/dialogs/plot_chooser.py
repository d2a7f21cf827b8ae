"""Chooser of plots: a filter above a list with a check box for each plot; it can stay open next to the window."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QFont, QPalette
from PySide6.QtWidgets import QCheckBox, QDialog, QLineEdit, QListWidget, QListWidgetItem, QWidget

from tactile_widgets.common.make import STYLE_SPACING, caption_label, column_layout, make, resize_on_screen
from tactile_widgets.plots.choice.plot_choice import PlotKey
from tactile_widgets.plots.live_plots import PlotGroup

_KEY = Qt.ItemDataRole.UserRole
_SIZE = 360, 520


class PlotChooser(QDialog):
    """List of all plots with a filter; a taxel is found by its number or hardware id.

    Args:
        find_taxels: Returns the plots of the taxels that a text names.
        parent: The window.
    """

    toggled = Signal(PlotKey, bool)
    """Plot, and whether to show it."""
    automatic_toggled = Signal(bool)
    """True if the standard plots are to follow the controller."""

    def __init__(self, find_taxels: Callable[[str], Sequence[PlotKey]], parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("plot-chooser")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle("Plots")
        self._find_taxels = find_taxels
        self._groups = tuple[PlotGroup, ...]()
        self._shown: frozenset[PlotKey] = frozenset()
        self._pressed: Qt.CheckState | None = None
        self.automatic = make(
            QCheckBox,
            "Standard plots follow the controller",
            self,
            toolTip="Show the standard plots that apply to the controller",
            clicked=self.automatic_toggled,
        )
        self.field = make(
            QLineEdit,
            self,
            objectName="plot-field",
            placeholderText="Joint, link, limit, event, or the number of a taxel",
            clearButtonEnabled=True,
            textChanged=self._fill,
        )
        self.list = make(
            QListWidget,
            self,
            objectName="plot-list",
            accessibleName="Plots",
            frameShape=QListWidget.Shape.NoFrame,
            horizontalScrollBarPolicy=Qt.ScrollBarPolicy.ScrollBarAlwaysOff,
            itemChanged=self._on_item_changed,
            itemPressed=self._on_item_pressed,
            itemClicked=self._on_item_clicked,
        )
        self.list.viewport().setBackgroundRole(QPalette.ColorRole.Window)  # unchecked boxes have the colour of a list
        note = caption_label(self, text="Drag a plot to move it, double-click to enlarge it, right-click for more.")
        parts = (self.field, self.automatic, self.list, note)
        column_layout(*parts, parent=self, spacing=STYLE_SPACING, margins=None)
        resize_on_screen(self, *_SIZE)

    def offer(self, groups: Sequence[PlotGroup], shown: Collection[PlotKey], *, automatic: bool) -> None:
        """List plots; ``shown`` are checked."""
        self._groups = tuple(groups)
        self._shown = frozenset(shown)
        self.automatic.setChecked(automatic)
        self._fill()

    def _fill(self, _text: str = "") -> None:
        bar = self.list.verticalScrollBar()
        typed = self.field.text().strip().lower()
        row = self.list.currentRow()
        place = bar.value()
        with QSignalBlocker(self.list):
            self.list.clear()
            for group in self._with_taxels(typed):
                whole = typed in group.title.lower()
                keys = [key for key in group.keys if whole or typed in key.title.lower() or group.title == "Taxels"]
                if keys:
                    self._add_heading(group.title)
                    for key in keys:
                        self._add(key)
            self.list.setCurrentRow(row)
        bar.setValue(place)

    def _with_taxels(self, typed: str) -> tuple[PlotGroup, ...]:
        """Return the groups, with a group of the taxels that are shown, or that the typed text finds."""
        shown = {key for key in self._shown if key.text.startswith("taxel:")}
        found = self._find_taxels(typed) if typed else sorted(shown, key=lambda key: int(key.of))
        taxels = (PlotGroup("Taxels", tuple(found)),) if found else ()
        return (*self._groups, *taxels) if not typed else (*taxels, *self._groups)

    def _add_heading(self, title: str) -> None:
        item = QListWidgetItem(title, self.list)
        item.setFlags(Qt.ItemFlag.NoItemFlags)
        font = QFont(self.list.font())
        font.setWeight(QFont.Weight.DemiBold)
        item.setFont(font)

    def _add(self, key: PlotKey) -> None:
        item = QListWidgetItem(key.title, self.list)
        item.setData(_KEY, key.text)
        item.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable | Qt.ItemFlag.ItemIsUserCheckable)
        item.setCheckState(Qt.CheckState.Checked if key in self._shown else Qt.CheckState.Unchecked)

    def _on_item_changed(self, item: QListWidgetItem) -> None:
        key = PlotKey.parse(str(item.data(_KEY)))
        if key is not None:
            self.toggled.emit(key, item.checkState() is Qt.CheckState.Checked)

    def _on_item_pressed(self, item: QListWidgetItem) -> None:
        self._pressed = item.checkState()

    def _on_item_clicked(self, item: QListWidgetItem | None) -> None:
        """Check or uncheck an entry by a click on its text; a click on its box has done that already.

        There is no entry where the click on the box filled the list again.
        """
        if item is not None and item.data(_KEY) and item.checkState() is self._pressed:
            checked = item.checkState() is Qt.CheckState.Checked
            item.setCheckState(Qt.CheckState.Unchecked if checked else Qt.CheckState.Checked)
