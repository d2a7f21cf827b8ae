"""The table of a study: measures against factors, and the rows of each point."""

from __future__ import annotations

import math
from collections.abc import Sequence

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, Qt, Signal
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QDialog,
    QFormLayout,
    QLabel,
    QLineEdit,
    QSplitter,
    QTableView,
    QWidget,
)

from tactile_maps.core.errors import UsageError, counted
from tactile_maps.studies.base.rows import Row, distinct
from tactile_maps.studies.running.study_table import StudyTable, TablePoint, only, table_points
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.make import STYLE_SPACING, column_layout, make, push_button, resize_on_screen, row_layout
from tactile_widgets.plots.study_plot import StudyPlot, cell_text

_Index = QModelIndex | QPersistentModelIndex
_NONE = "(one curve)"
_MOST_CURVES = 12
_TOP = QModelIndex()


class RowsModel(QAbstractTableModel):
    """Item model of the rows of a study."""

    def __init__(self, columns: Sequence[str], parent: QWidget) -> None:
        super().__init__(parent)
        self._columns = list(columns)
        self.rows = list[Row]()

    def show_rows(self, rows: Sequence[Row]) -> None:
        """Show other rows."""
        self.beginResetModel()
        self.rows = list(rows)
        self.endResetModel()

    def rowCount(self, parent: _Index = _TOP) -> int:
        return 0 if parent.isValid() else len(self.rows)

    def columnCount(self, parent: _Index = _TOP) -> int:
        return 0 if parent.isValid() else len(self._columns)

    def data(self, index: _Index, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        if role not in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.ToolTipRole):
            return None
        return cell_text(self.rows[index.row()][self._columns[index.column()]])

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        if role != Qt.ItemDataRole.DisplayRole:
            return None
        return self._columns[section] if orientation == Qt.Orientation.Horizontal else section + 1


class StudyDialog(QDialog):
    """Plot of a study, and a list of the rows of the clicked point.

    Args:
        table: Table of the study.
        theme: Theme of the plot.
        no_replay: Why runs cannot be replayed; empty if they can.
        parent: Qt parent.
    """

    replay_requested = Signal(object)
    """Row whose run is to be simulated again."""

    def __init__(self, table: StudyTable, theme: Theme, *, no_replay: str = "", parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("study-dialog")
        self.setWindowTitle(f"Study: {table.file.name}")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        resize_on_screen(self, 1120, 620)
        self.study = table
        self._no_replay = no_replay
        self.points: list[TablePoint] = []
        self._rows: list[Row] = list(table.rows)
        self.factor, self.measure, self.curves = (self._choice(name) for name in ("factor", "measure", "curves"))
        self.only = make(
            QLineEdit,
            self,
            objectName="study-only",
            placeholderText="all; or column=value, column=value",
            toolTip="Draw and list only rows that meet all conditions, e.g. robot=arm, factor=pitch",
            clearButtonEnabled=True,
        )
        self.note = make(QLabel, self, objectName="study-note", wordWrap=True)
        self.plot = StudyPlot(theme, self)
        self.model = RowsModel(table.columns, self)
        self.view = self._make_view()
        self.all_rows = push_button(
            self, "study-all-rows", "All rows", "", lambda: self.show_point(None), autoDefault=False
        )
        tip = no_replay or "Simulate the run of the selected row again, and open it as a recording"
        self.replay = push_button(self, "study-replay", "Replay this run", tip, self._replay, autoDefault=False)
        self._lay_out()
        self._fill()
        for box in (self.factor, self.measure, self.curves):
            box.currentIndexChanged.connect(self._draw)
        self.only.editingFinished.connect(self._draw)
        self.plot.chosen.connect(self.show_point)
        self._draw()

    def _choice(self, name: str) -> QComboBox:
        return make(
            QComboBox,
            self,
            objectName=f"study-{name}",
            sizeAdjustPolicy=QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon,
            minimumContentsLength=14,
        )

    def _make_view(self) -> QTableView:
        view = make(
            QTableView,
            self,
            model=self.model,
            objectName="study-rows",
            accessibleName="Rows of the study",
            selectionMode=QAbstractItemView.SelectionMode.SingleSelection,
            selectionBehavior=QAbstractItemView.SelectionBehavior.SelectRows,
            showGrid=False,
            wordWrap=False,
        )
        view.selectionModel().selectionChanged.connect(self._enable_replay)
        view.verticalHeader().setDefaultSectionSize(22)
        # Centred in a wide column, a heading would be out of view while the values are not.
        view.horizontalHeader().setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        return view

    def _lay_out(self) -> None:
        form = QFormLayout()
        form.addRow("Factor", self.factor)
        form.addRow("Measure", self.measure)
        form.addRow("Curves by", self.curves)
        form.addRow("Only rows", self.only)
        foot = row_layout(self.note, self.all_rows, self.replay, spacing=STYLE_SPACING, stretch=self.note)
        drawn = QWidget(self)
        listed = QWidget(self)
        column_layout(form, self.plot, parent=drawn, spacing=STYLE_SPACING, stretch=self.plot, margins=None)
        column_layout(self.view, foot, parent=listed, spacing=STYLE_SPACING, stretch=self.view, margins=None)
        ends = QSplitter(Qt.Orientation.Horizontal, self)
        ends.addWidget(drawn)
        ends.addWidget(listed)
        ends.setSizes([620, 500])
        column_layout(ends, parent=self, spacing=STYLE_SPACING, margins=None)

    def _fill(self) -> None:
        """List the columns, and choose the most informative factor and curves."""
        table = self.study
        varied = [name for name in table.case_columns if len(distinct(table.rows, name)) > 1]
        self.factor.addItems(table.factors)
        self.measure.addItems(table.measures)
        self.curves.addItems([_NONE, *table.factors])
        factor = next((name for name in ("level", "x", *reversed(varied)) if name in varied), table.factors[0])
        self.factor.setCurrentText(factor)
        apart = [name for name in varied if name != factor and len(distinct(table.rows, name)) <= _MOST_CURVES]
        self.curves.setCurrentText("factor" if "factor" in apart else apart[0] if apart else _NONE)

    def set_theme(self, theme: Theme) -> None:
        """Use another theme."""
        self.plot.set_theme(theme)

    def show_point(self, point: TablePoint | None) -> None:
        """List the rows of a point; None for all drawn rows."""
        self.plot.mark(point)
        self._list(point)

    def _list(self, point: TablePoint | None) -> None:
        self.model.show_rows(self._rows if point is None else point.rows)
        self.view.resizeColumnsToContents()
        self.all_rows.setEnabled(point is not None)
        if len(self.model.rows) == 1:
            self.view.selectRow(0)
        self._enable_replay()
        self.note.setText(self._table_text() if point is None else self._point_text(point))

    @property
    def selected(self) -> Row | None:
        """Selected row; None if there is none."""
        rows = self.view.selectionModel().selectedRows()
        return self.model.rows[rows[0].row()] if rows else None

    def _enable_replay(self) -> None:
        self.replay.setEnabled(not self._no_replay and self.selected is not None)

    def _replay(self) -> None:
        if (row := self.selected) is not None:
            self.replay_requested.emit(row)

    def _draw(self) -> None:
        by = None if self.curves.currentText() == _NONE else self.curves.currentText()
        try:
            self._rows = only(self.study.rows, self.only.text())
            self.points = table_points(
                self.study, self._rows, self.factor.currentText(), self.measure.currentText(), by
            )
        except UsageError as error:
            self.points = []
            self.plot.show_points((), self.factor.currentText(), self.measure.currentText())
            self._list(None)
            self.note.setText(str(error))
            return
        measure = self.measure.currentText()
        self.plot.show_points(self.points, self.factor.currentText(), measure, self.study.theory(measure))
        self._list(None)

    def _table_text(self) -> str:
        """Return the number of rows, what is not drawn, and the factors over which points pool rows."""
        cannot = sum(not math.isfinite(point.interval.middle) for point in self.points)
        pooled = dict.fromkeys(name for point in self.points for name in point.pooled)
        sizes = f"{counted(len(self._rows), 'row')}, {counted(len(self.points), 'point')}"
        parts = [f"{sizes}: median over seeds and its 95 % bootstrap interval"]
        if cannot:
            parts.append(f"{cannot} not drawn: most of their seeds fail")
        if missing := sum(point.missing for point in self.points):
            parts.append(f"{counted(missing, 'row')} without a value")
        if pooled:
            parts.append(f"Points combine rows with different {', '.join(pooled)}: add conditions on these columns")
        return ". ".join(parts) + "."

    def _point_text(self, point: TablePoint) -> str:
        of = f", {self.curves.currentText()} {cell_text(point.series)}" if point.series is not None else ""
        what = f"{self.factor.currentText()} {cell_text(point.x)}{of}"
        measured = f"{what}: {self.measure.currentText()}"
        if len(point.rows) == 1:
            return f"{measured} {point.interval.middle:.3g}, of one row: no interval."
        mixed = f", which differ in {', '.join(point.pooled)} too: no interval over seeds" if point.pooled else ""
        return f"{measured} {point.interval} of {len(point.rows)} rows{mixed}."
