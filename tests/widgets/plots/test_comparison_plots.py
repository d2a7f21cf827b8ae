"""Traces of compared controllers: what is drawn agrees with the metrics next to it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pyqtgraph as pg
import pytest
from PySide6.QtCore import QRect, Qt
from PySide6.QtWidgets import QApplication, QWidget

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.studies.controller_comparison import TRACE_COLUMNS, ControllerTrace, controller_metrics
from tactile_widgets.common.colours import DARK
from tactile_widgets.dialogs.controller_comparison.comparison_plots import ComparisonPlots, contender_pen
from tactile_widgets.dialogs.controller_comparison.comparison_view import ComparisonDialog
from tactile_widgets.dialogs.controller_comparison.metrics_table import ROWS

TICKS = 4000
ADAPTED = Limit(LimitKind.FORCE_GAIN_HELD)
UNMET = Limit(LimitKind.ENERGY_TANK)


def trace(limits):
    """A trace with these limits."""
    columns = dict.fromkeys(TRACE_COLUMNS, np.zeros(TICKS)) | {"time": 0.005 * np.arange(1, TICKS + 1)}
    return ControllerTrace("A", ControlSettings(), **columns, touched=np.zeros(TICKS, bool), limits=limits)


@pytest.fixture
def plots(qtbot):
    made = ComparisonPlots(DARK)
    qtbot.addWidget(made)
    made.resize(640, 600)
    made.show()
    return made


@pytest.mark.parametrize("period", [1, 13], ids=["one span", "single ticks"])
def test_bars_of_limits_last_as_long_as_the_metric_states(plots, period):
    """Adapted gains are neither drawn nor counted."""
    acts = [800 <= tick < 1120 and tick % period == 0 for tick in range(TICKS)]
    drawn = trace(tuple((ADAPTED, UNMET) if act else (ADAPTED,) for act in acts))
    plots.show_traces([drawn])
    (bars,) = [item for item in plots.plots["limits"].getPlotItem().items if isinstance(item, pg.BarGraphItem)]
    share = controller_metrics(drawn).limited
    assert share == np.mean(acts)
    assert (bars.opts["x1"] - bars.opts["x0"]).sum() / drawn.time[-1] == pytest.approx(share)
    QApplication.processEvents()
    picture = plots.plots["limits"].grab().toImage()
    ink = contender_pen(DARK, "A").color().name()
    columns = [
        x
        for x in range(picture.width())
        if any(picture.pixelColor(x, y).name() == ink for y in range(picture.height()))
    ]
    box = plots.plots["limits"].getPlotItem().getViewBox().sceneBoundingRect()
    (first, last) = ((x - box.left()) / box.width() for x in (columns[0], columns[-1]))
    assert (first, last) == pytest.approx((0.2, 0.28), abs=0.02)
    assert (len(columns) > 0.05 * picture.width()) == (period == 1)


@pytest.mark.parametrize("width", [700, 1320])
@pytest.mark.parametrize("closed", [False, True], ids=["open", "closed during the run"])
def test_table_shows_titles_and_both_columns(qtbot, width, closed):
    parent = QWidget()
    qtbot.addWidget(parent)
    parent.resize(1366, 768)
    dialog = ComparisonDialog(DARK, parent)
    board = dialog.board
    board.begin((ControlSettings(), ControlSettings(controller="qp")))
    dialog.show()
    dialog.resize(width, 700)
    dialog.setVisible(not closed)
    longest = Limit(max(LimitKind, key=lambda kind: len(kind.title)))
    first = trace(((longest,),) * TICKS)
    board.show_compared((first, replace(first, name="B")))
    dialog.show()
    QApplication.processEvents()
    table = board.table
    for column in range(2):
        left = table.columnViewportPosition(column)
        assert left >= 0
        assert left + table.columnWidth(column) <= table.viewport().width()
    assert table.horizontalHeader().isVisible()
    assert table.verticalHeader().visibleRegion().boundingRect().width() >= 150
    titles = table.verticalHeader()
    for row in range(len(ROWS)):
        room = QRect(0, 0, titles.width() - 8, table.rowHeight(row))
        text = table.verticalHeaderItem(row).text()
        assert room.contains(titles.fontMetrics().boundingRect(room, Qt.TextFlag.TextWordWrap, text)), text
    row = [row.name for row in ROWS].index("limit")
    assert table.rowHeight(row) > 2 * table.rowHeight(0), "long values are wrapped"
    assert not table.horizontalScrollBar().isVisible()
