"""Figures of robot and map as shown in the window, drawn at another size and in other colours."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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
_FOR_CAPTIONS = 1.7
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


def write_view_figure(shown: ShownInViews, part: FigurePart, path: str | Path, spec: FigureSpec) -> tuple[str, ...]:
    """Write both views, or one of them, with the scale of pressures and scale bars; the window does not change.

    Texts and lines of the map are vectors in SVG and PDF, touch on it and the robot are pictures of ``spec.dpi``.

    Returns:
        Names of patches and forces that are left out of a small figure, because they would hide other patches.

    Raises:
        DisplayError: The file cannot be written, or the part is ``PLOTS``.

    Cost: about 1 s for the robot.
    """
    if part is FigurePart.PLOTS:
        raise DisplayError("plots are not a view", value=part.value, remedy="Write them with write_plot_figure")
    theme = theme_of(spec.colours)
    with _copied(shown, part, theme, spec) as views:
        fitted, left_out = _fitted(spec, views, part)
        if part is not FigurePart.MAP:
            views.robot.display.draw_now(quality=fitted.quality)
        write_figure(path, fitted, theme.window, lambda painter: _paint(painter, views, part, theme))
    return tuple(sorted(left_out))


def left_out_text(texts: Sequence[str]) -> str:
    """Return the statement about texts that ``write_view_figure`` left out; empty if there are none."""
    words = f"Too small for {', '.join(texts)}, which would hide patches; a larger figure shows them"
    return words if texts else ""


@contextmanager
def _copied(shown: ShownInViews, part: FigurePart, theme: Theme, spec: FigureSpec) -> Iterator[LinkedViews]:
    views = LinkedViews(theme, shown.views.scale, off_screen=True)
    try:
        views.show_only(robot=part is not FigurePart.MAP, map_=part is not FigurePart.ROBOT)
        views.resize(*spec.units)
        views.show()
        views.show_prepared(shown.prepared)
        views.robot.hide_morph()
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


def _fitted(spec: FigureSpec, views: LinkedViews, part: FigurePart) -> tuple[FigureSpec, frozenset[str]]:
    """Resize the views to the largest units at which the figure has room for its texts; return them and what has none.

    Units shrink a little more if fewer captions cover the robot then, fewer forces hide another patch, captions of
    contacts hide no contact and no small patch, and fewer names hide skin. Forces and names that still do are left out,
    and at any size an orientation cube that covers the robot.
    """
    whole_map = views.map.camera.framed
    if part is not FigurePart.MAP:
        views.robot.display.draw_now(quality=1.0)  # the orientation cube needs a picture
    found: list[tuple[tuple[int, int, bool, int], FigureSpec]] = []  # legible ones, the largest first
    while True:
        fits = _resize(views, spec, whole_map=whole_map)
        names, forces = views.map.leave_out_hiding()
        covering = 0 if part is FigurePart.MAP else _captions_over_robot(views)
        fits = fits and (part is FigurePart.ROBOT or views.map.legends_fit())
        if fits and (part is FigurePart.MAP or _robot_fits(views)):
            of_map = (0, True, 0)
            if part is not FigurePart.ROBOT:
                of_map = (-len(forces), views.map.callouts_fit(), -len(names))
            found.append(((-covering, *of_map), spec))
            if found[-1][0] == (0, 0, True, 0):
                return spec, frozenset()
        if spec.units_per_inch > (_FOR_CAPTIONS * found[0][1].units_per_inch if found else _MOST_UNITS):
            break
        spec = replace(spec, units_per_inch=round(_STEP * spec.units_per_inch))
    if found:
        _, spec = max(found, key=itemgetter(0))
        _resize(views, spec, whole_map=whole_map)
        names, forces = views.map.leave_out_hiding()
        if part is not FigurePart.MAP:
            _captions_over_robot(views)
    return spec, frozenset() if part is FigurePart.ROBOT else names | forces


def _resize(views: LinkedViews, spec: FigureSpec, *, whole_map: bool) -> bool:
    """Resize the views to the units of a figure; return whether they are not too small for their layout."""
    views.resize(*spec.units)
    if whole_map:  # the legends of a figure have another size, compared with the map
        views.map.frame_all(still=True)
    return views.size().toTuple() == spec.units


def _captions_over_robot(views: LinkedViews) -> int:
    """Return how many captions cover a part of the robot; leave out the orientation cube if it does."""
    display = views.robot.display
    overlay = display.overlay
    pixels = display.actors.viewpoint.pixels(display.actors.surface_points(), display.size)
    overlay.cube_shown = not overlay.cube_covers(pixels)
    boxes = [box for box in overlay.caption_boxes() if box != overlay.cube_box]
    corners = [(box.topLeft().toTuple(), box.bottomRight().toTuple()) for box in boxes]
    return sum(bool(((pixels > first) & (pixels < last)).all(axis=1).any()) for first, last in corners)


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
