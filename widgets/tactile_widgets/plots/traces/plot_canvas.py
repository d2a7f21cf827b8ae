"""pyqtgraph's plot as all panels show it."""

from __future__ import annotations

from typing import Any

import pyqtgraph as pg
from PySide6.QtGui import QFont
from PySide6.QtWidgets import QGraphicsView, QWidget


class PlotCanvas(pg.PlotWidget):
    """Without pyqtgraph's menu, buttons, dragging and drops, with small digits, on the ground of the theme.

    Args:
        parts: Axes or a view box of one's own, as ``pyqtgraph.PlotWidget`` takes them.

    Attributes:
        small: The digits' font, for labels beside them.
    """

    def __init__(self, parent: QWidget, **parts: Any) -> None:
        super().__init__(parent, background=None, **parts)
        self.setCacheMode(QGraphicsView.CacheModeFlag.CacheNone)  # or the ground would stay that of the theme before
        self.setAcceptDrops(False)  # a file dropped here is the window's
        self.setMouseEnabled(x=False, y=False)
        self.setMenuEnabled(False)
        self.hideButtons()
        menu = self.getPlotItem().ctrlMenu  # made without a parent, it would outlive the plot
        menu.setParent(self, menu.windowFlags())
        self.small = QFont(self.font())
        self.small.setPixelSize(11)
        for side in ("left", "bottom"):
            self.getAxis(side).setTickFont(self.small)
