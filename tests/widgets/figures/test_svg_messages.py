"""SVG files of the program and SVG that it writes are read without a warning of Qt, which would fail the test."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyqtgraph as pg
import pytest
from PySide6.QtGui import QImage, QPainter
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtTest import QTest

from tactile_maps.core.assets import asset
from tactile_maps.maps.formats.svg import svg
from tactile_widgets.actions import icons
from tactile_widgets.dialogs.figures.figure_file import FigureSpec, write_figure
from tactile_widgets.plots.traces.plot_canvas import dashed_pen

ICONS = sorted(Path(icons.__file__).with_name("icons").glob("*.svg"))
SPEC = FigureSpec(170.0, 85.0)


def draw(data):
    """Draw an SVG; return whether anything was drawn."""
    image = QImage(64, 64, QImage.Format.Format_ARGB32)
    image.fill(0)
    painter = QPainter(image)
    renderer = QSvgRenderer(data)
    assert renderer.isValid()
    renderer.render(painter)
    painter.end()
    blank = QImage(image.size(), image.format())
    blank.fill(0)
    return image != blank


@pytest.mark.parametrize("path", [*ICONS, asset("icon.svg")], ids=lambda path: path.stem)
def test_icons_are_valid_and_draw_something(qapp, path):
    assert draw(path.read_bytes().replace(b"currentColor", b"#ff0000"))


def test_drawing_of_a_map_is_valid(qapp, prepared):
    assert draw(svg(prepared.map))


@pytest.mark.parametrize("values", [[2.0], [np.nan, np.nan], [np.nan, 2.0, np.nan], []], ids=str)
def test_figure_of_a_curve_without_a_line_is_valid(qtbot, tmp_path, values):
    """A single sample and a gap are no line; Qt writes them as a path without points."""
    plot = pg.PlotWidget(background=None)
    qtbot.addWidget(plot)
    for pen in (pg.mkPen("#ff0000"), pg.mkPen("#ff0000", width=1.5), dashed_pen("#ff0000")):
        curve = pg.PlotCurveItem(connect="finite", pen=pen)
        plot.addItem(curve)
        curve.setData(np.arange(len(values)), np.array(values))
    plot.show()
    assert QTest.qWaitForWindowExposed(plot)
    for kind in ("svg", "png"):
        write_figure(tmp_path / f"plot.{kind}", SPEC, "#ffffff", plot.render)
    drawn = (tmp_path / "plot.svg").read_bytes()
    assert b"<text" in drawn
    assert draw(drawn)
