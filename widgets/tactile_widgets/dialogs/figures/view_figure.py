"""Figures of robot and map as shown in the window, drawn at another size and in other colours."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from PySide6.QtCore import QPoint, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPen
from PySide6.QtWidgets import QApplication, QWidget

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import DisplayError
from tactile_maps.editing.document import MapDocument
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import DARK, LIGHT, Theme
from tactile_widgets.dialogs.figures.figure_file import FigureColours, FigurePart, FigureSpec, write_figure
from tactile_widgets.views.linked_views import LinkedViews
from tactile_widgets.views.map.items.map_coordinates import nice_floor

PAPER = replace(LIGHT, window="#ffffff", panel="#ffffff")
_LONGEST_BAR = 110.0
_EDGE = 12.0


def theme_of(colours: FigureColours) -> Theme:
    """Return the theme in which a figure is drawn."""
    return {FigureColours.PAPER: PAPER, FigureColours.LIGHT: LIGHT, FigureColours.DARK: DARK}[colours]


@dataclass(frozen=True, eq=False)
class ShownInViews:
    """Content of both views.

    Attributes:
        views: Views of the window, whose cameras, overlays, selection and colour scale are used.
        prepared: Robot and skin.
        document: The map being edited; None for that of ``prepared``.
        settings: Settings of the controller.
        frame: Current frame; None before the first.
    """

    views: LinkedViews
    prepared: PreparedScene
    document: MapDocument | None
    settings: ControlSettings
    frame: Frame | None


def write_view_figure(shown: ShownInViews, part: FigurePart, path: str | Path, spec: FigureSpec) -> None:
    """Write both views, or one of them, with the scale of pressures and scale bars; the window does not change.

    Texts and lines of the map are vectors in SVG and PDF, touch on it and the robot are pictures of ``spec.dpi``.

    Raises:
        DisplayError: The file cannot be written, or the part is ``PLOTS``.

    Cost: about 1 s for the robot.
    """
    if part is FigurePart.PLOTS:
        raise DisplayError("plots are not a view", value=part.value, remedy="Write them with write_plot_figure")
    theme = theme_of(spec.colours)
    with _copied(shown, part, theme, spec) as views:
        write_figure(path, spec, theme.window, lambda painter: _paint(painter, views, part, theme))


@contextmanager
def _copied(shown: ShownInViews, part: FigurePart, theme: Theme, spec: FigureSpec) -> Iterator[LinkedViews]:
    views = LinkedViews(theme, shown.views.scale, off_screen=True)
    try:
        views.show_only(robot=part is not FigurePart.MAP, map_=part is not FigurePart.ROBOT)
        views.resize(*spec.units)
        views.show()
        views.show_prepared(shown.prepared)
        views.robot.morph.hide()
        views.set_overlays(shown.views.overlays)
        views.set_faults(shown.views.faults)
        if shown.document is not None and shown.document.skin is shown.prepared.skin:
            views.show_document(shown.document)
        views.show_settings(shown.settings)
        if shown.frame is not None:
            views.show_frame(shown.frame)
        QApplication.sendPostedEvents(views)
        _look_alike(views, shown.views)
        if part is not FigurePart.MAP:
            views.robot.display.draw_now(quality=spec.quality)
        yield views
    finally:
        views.robot.close_view()
        views.close()
        views.deleteLater()


def _look_alike(views: LinkedViews, other: LinkedViews) -> None:
    """Use the cameras and the selection of other views."""
    if not other.robot.display.framed:
        views.robot.display.look(other.robot.display.actors.viewpoint)
    if other.map.camera.framed:
        views.map.frame_all()  # the legends of a figure have another size, compared with the map
    else:
        views.map.look(other.map.camera)
    for part in (views.robot.display, views.map):
        part.set_selection(other.selection.taxels, other.selection.inks)


def _paint(painter: QPainter, views: LinkedViews, part: FigurePart, theme: Theme) -> None:
    views.render(painter, QPoint(0, 0), renderFlags=QWidget.RenderFlag.DrawChildren)
    if part is not FigurePart.MAP:
        _paint_scale_bar(painter, views, theme)


def _paint_scale_bar(painter: QPainter, views: LinkedViews, theme: Theme) -> None:
    """Draw a scale bar for the middle of the robot view; nearer objects appear larger."""
    robot = views.robot
    corner = QPointF(robot.mapTo(views, QPoint(0, 0)))
    pixel = robot.display.pixel_size(None)
    millimetres = nice_floor(min(_LONGEST_BAR, 0.25 * robot.width()) * pixel * 1e3)
    length = 1e-3 * millimetres / pixel
    text = f"{millimetres:g}\u202fmm at the middle of the view"
    font = QFont(robot.font())
    font.setPixelSize(11)
    metrics = QFontMetricsF(font)
    box = QRectF(corner.x() + _EDGE, corner.y() + _EDGE, length, metrics.height() + 10)
    painter.setPen(QPen(QColor(theme.text), 1.5, Qt.PenStyle.SolidLine, Qt.PenCapStyle.FlatCap))
    low = box.top() + 5
    painter.drawPolyline([QPointF(box.left() + x, low + y) for x, y in ((0, -5), (0, 0), (length, 0), (length, -5))])
    painter.setFont(font)
    painter.drawText(QPointF(box.left(), low + metrics.ascent() + 4), text)
