"""Base widget of all plots."""

from __future__ import annotations

from typing import Any

import pyqtgraph as pg
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QPen
from PySide6.QtWidgets import QGraphicsView, QWidget

from tactile_widgets.common.colours import Theme
from tactile_widgets.common.make import small_font


class PlotCanvas(pg.PlotWidget):
    """pyqtgraph plot without menu, buttons, mouse interaction and drops, with small digits on the theme's background.

    Args:
        parts: Custom axes or view box, passed to ``pyqtgraph.PlotWidget``.

    Attributes:
        small: Font of the digits, also for labels next to them.
    """

    def __init__(self, parent: QWidget, **parts: Any) -> None:
        super().__init__(parent, background=None, **parts)
        self.setCacheMode(QGraphicsView.CacheModeFlag.CacheNone)  # a cached background would keep the previous theme
        self.setAcceptDrops(False)  # the window handles dropped files
        self.setMouseEnabled(x=False, y=False)
        self.setMenuEnabled(False)
        self.hideButtons()
        menu = self.getPlotItem().ctrlMenu  # without a parent, it would outlive the plot
        menu.setParent(self, menu.windowFlags())
        self.small = small_font(self.font())
        for side in ("left", "bottom"):
            self.getAxis(side).setTickFont(self.small)

    def colour_axes(self, theme: Theme) -> None:
        """Draw the axes in the colours of a theme."""
        for side in ("left", "bottom"):
            self.getAxis(side).setPen(theme.line)
            self.getAxis(side).setTextPen(theme.quiet)


def dashed_pen(colour: str | QColor, width: float = 1.5) -> QPen:
    """Return the pen of a bound or a goal."""
    return pg.mkPen(colour, width=width, style=Qt.PenStyle.DashLine)
