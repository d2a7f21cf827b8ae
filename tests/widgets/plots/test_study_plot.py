"""Plot and table of a study: axes fit the values, labels fit the axis, and headings are over their values."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QFontMetrics
from PySide6.QtWidgets import QApplication

from tactile_maps.core.assets import asset
from tactile_maps.studies.running.study_table import read_study_table
from tactile_widgets.common.colours import DARK
from tactile_widgets.dialogs.study_dialog import StudyDialog


@pytest.fixture(scope="module")
def table():
    """Study with positive measures, and names of different lengths as factor."""
    return read_study_table(asset("findings", "representation.csv"))


@pytest.fixture
def dialog(qtbot, table):
    made = StudyDialog(table, DARK)
    qtbot.addWidget(made)
    made.show()
    QApplication.processEvents()
    return made


def test_axis_of_positive_values_begins_at_zero(dialog):
    (low, high) = dialog.plot.canvas.getPlotItem().viewRange()[1]
    highest = max(
        end
        for p in dialog.points
        for end in (p.interval.middle, p.interval.high)
        if dialog.plot.place(p) and np.isfinite(end)
    )
    assert -0.1 * highest < low < 0
    assert highest < high < 1.15 * highest
    axis = dialog.plot.canvas.getAxis("left")
    assert len(axis.tickValues(low, high, axis.height())[0][1]) >= 3
    assert not axis.autoSIPrefix


@pytest.mark.parametrize("width", [pytest.param(700, marks=pytest.mark.long), 1120])
def test_named_values_are_labelled_as_densely_as_the_axis_has_room(dialog, width):
    dialog.resize(width, 620)
    QApplication.processEvents()
    (ticks,) = dialog.plot.canvas.getAxis("bottom")._tickLevels
    box = dialog.plot.canvas.getPlotItem().getViewBox()
    first, last = box.viewRange()[0]
    measure = QFontMetrics(dialog.plot.canvas.small).horizontalAdvance
    middles = np.array([(place - first) / (last - first) * box.width() for place, _ in ticks])
    halves = np.array([measure(text) / 2 for _, text in ticks])
    assert ((middles + halves)[:-1] < (middles - halves)[1:]).all()
    assert middles[0] >= halves[0]
    assert middles[-1] + halves[-1] <= box.width()
    assert halves.sum() * 2 > 0.4 * box.width()


def test_heading_of_a_wide_column_is_over_its_values(dialog):
    header = dialog.view.horizontalHeader()
    assert dialog.view.columnWidth(2) > 180, "a column partly out of view"
    assert header.defaultAlignment() & Qt.AlignmentFlag.AlignLeft
    assert header.sectionViewportPosition(2) + 40 < header.viewport().width()
