"""Figures of robot and map as shown in the window, drawn at another size and in other colours."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import combinations
from operator import itemgetter
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
from tactile_widgets.common.make import small_font
from tactile_widgets.dialogs.figures.figure_file import FigureColours, FigurePart, FigureSpec, write_figure
from tactile_widgets.views.linked_views import LinkedViews
from tactile_widgets.views.map.items.map_coordinates import nice_floor

PAPER = replace(LIGHT, window="#ffffff", panel="#ffffff")
_LONGEST_BAR = 110.0
_EDGE = 12.0
_STEP = 1.1
"""Factor by which units shrink until all texts have room."""
_FOR_CAPTIONS = 1.5
"""Factor by which units shrink at most until the captions of contacts have room."""
_MOST_UNITS = 1000
"""Units per inch from which smaller ones are no longer tried."""


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
        fitted = _fitted(spec, views, part)
        if part is not FigurePart.MAP:
            views.robot.display.draw_now(quality=fitted.quality)
        write_figure(path, fitted, theme.window, lambda painter: _paint(painter, views, part, theme))


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
        yield views
    finally:
        views.robot.close_view()
        views.close()
        views.deleteLater()


def _look_alike(views: LinkedViews, other: LinkedViews) -> None:
    """Use the cameras and the selection of other views."""
    if not other.robot.display.framed:
        views.robot.display.look(other.robot.display.actors.viewpoint)
    if not other.map.camera.framed:
        views.map.look(other.map.camera)
    for part in (views.robot.display, views.map):
        part.set_selection(other.selection.taxels, other.selection.inks)


def _fitted(spec: FigureSpec, views: LinkedViews, part: FigurePart) -> FigureSpec:
    """Return the largest units at which the figure has room for its texts, and resize the views to it.

    Units shrink a little more if names then hide no skin, and captions of contacts no contact and no small patch.
    """
    whole_map = views.map.camera.framed
    if part is not FigurePart.MAP:
        views.robot.display.draw_now(quality=1.0)  # the orientation cube needs a picture
    found: list[tuple[tuple[bool, bool], FigureSpec]] = []  # legible ones, the largest first
    while True:
        fits = _resize(views, spec, whole_map=whole_map) and (part is FigurePart.ROBOT or views.map.legends_fit())
        if fits and (part is FigurePart.MAP or _robot_fits(views)):
            found.append(((True, True) if part is FigurePart.ROBOT else views.map.captions_fit(), spec))
            if all(found[-1][0]):
                return spec
        if spec.units_per_inch > (_FOR_CAPTIONS * found[0][1].units_per_inch if found else _MOST_UNITS):
            break
        spec = replace(spec, units_per_inch=round(_STEP * spec.units_per_inch))
    if found:
        _, spec = max(found, key=itemgetter(0))
        _resize(views, spec, whole_map=whole_map)
    return spec


def _resize(views: LinkedViews, spec: FigureSpec, *, whole_map: bool) -> bool:
    """Resize the views to the units of a figure; return whether they are not too small for their layout."""
    views.resize(*spec.units)
    if whole_map:  # the legends of a figure have another size, compared with the map
        views.map.frame_all(still=True)
    return views.size().toTuple() == spec.units


def _robot_fits(views: LinkedViews) -> bool:
    """Whether the captions of the robot view are in it and hide none of each other."""
    room = QRectF(views.robot.rect())
    _, _, line, text = _scale_bar(views)
    captions = [box for box in views.robot.display.overlay.caption_boxes() if not box.isEmpty()]
    boxes = [line.united(text), *captions]
    apart = not any(one.intersects(other) for one, other in combinations(boxes, 2))
    return apart and all(room.contains(box) for box in boxes)


def _paint(painter: QPainter, views: LinkedViews, part: FigurePart, theme: Theme) -> None:
    views.render(painter, QPoint(0, 0), renderFlags=QWidget.RenderFlag.DrawChildren)
    if part is not FigurePart.MAP:
        _paint_scale_bar(painter, views, theme)


def _scale_bar(views: LinkedViews) -> tuple[QFont, str, QRectF, QRectF]:
    """Return font and text of the robot view's scale bar, and the boxes of its line and text in that view [px]."""
    robot = views.robot
    pixel = robot.display.pixel_size(None)
    millimetres = nice_floor(min(_LONGEST_BAR, 0.25 * robot.width()) * pixel * 1e3)
    length = 1e-3 * millimetres / pixel
    text = f"{millimetres:g}\u202fmm at the middle of the view"
    font = small_font(robot.font())
    metrics = QFontMetricsF(font)
    line = QRectF(_EDGE, _EDGE, length, 5.0)
    words = QRectF(_EDGE, line.bottom() + 4, metrics.horizontalAdvance(text), metrics.height())
    return font, text, line, words


def _paint_scale_bar(painter: QPainter, views: LinkedViews, theme: Theme) -> None:
    """Draw a scale bar for the middle of the robot view; nearer objects appear larger."""
    corner = QPointF(views.robot.mapTo(views, QPoint(0, 0)))
    font, text, line, words = _scale_bar(views)
    line.translate(corner)
    words.translate(corner)
    painter.setPen(QPen(QColor(theme.text), 1.5, Qt.PenStyle.SolidLine, Qt.PenCapStyle.FlatCap))
    painter.drawPolyline([line.topLeft(), line.bottomLeft(), line.bottomRight(), line.topRight()])
    painter.setFont(font)
    painter.drawText(words, Qt.AlignmentFlag.AlignLeft | Qt.TextFlag.TextDontClip, text)
