"""Base widget of all plots: its background follows the theme."""

from __future__ import annotations

from PySide6.QtWidgets import QApplication, QVBoxLayout, QWidget

from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.common.colours import DARK, LIGHT
from tactile_widgets.plots.traces.plot_canvas import PlotCanvas


def test_background_follows_the_theme(qtbot):
    panel = QWidget()
    qtbot.addWidget(panel)
    QVBoxLayout(panel).addWidget(PlotCanvas(panel))
    panel.resize(300, 200)
    panel.show()
    qtbot.waitExposed(panel)
    grounds = []
    for theme in (DARK, LIGHT):
        apply_theme(QApplication.instance(), theme)
        picture = panel.grab().toImage()
        outside = picture.pixelColor(2, 2)
        within = picture.pixelColor(panel.width() - 20, 14)
        assert within == outside
        grounds.append(within.name())
    assert grounds[0] != grounds[1]
