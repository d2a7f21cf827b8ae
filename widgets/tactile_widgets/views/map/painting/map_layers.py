"""The layers of View > Overlay as they are drawn on the map, a class each; ``ZOrder`` says which lies over which.

====================  ===========  =============================================
class                 z-order      drawn as
====================  ===========  =============================================
``BorderLines``       BORDER       children of the patches
``SeamLines``         SEAMS        children of the patches
``TaxelDots``         DOTS         an item of the scene, in place of the image
``TaxelNumbers``      NUMBERS      an item of the scene
``TouchContours``     CONTOURS     painted over the scene
``PinMarks``          PINS         painted over the scene
``ContactEllipses``   SHAPES       painted over the scene
====================  ===========  =============================================

Contours are iso-lines around touched areas: marching squares, as short unordered segments, exact on the bilinear grid
edges.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPen, QPolygonF, QTransform
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import BoolArray, FloatArray
from tactile_maps.editing.pins import pin_places
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.session.frame import Frame
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.common.colours import Theme
from tactile_widgets.views.map.items.map_items import LineBuffer, ZOrder, cosmetic_pen, padded_bounds, to_polygon
from tactile_widgets.views.map.items.map_scene import CONTACT_KPA, MapLayer, MapScene
from tactile_widgets.views.map.items.map_shapes import ChartShape
from tactile_widgets.views.overlays.paint_cache import PaintCache
from tactile_widgets.views.overlays.painting import draw_pin, polygon


class _OutlineItem(QGraphicsItem):
    """Lines along the outline of one patch, in its chart's frame: a child of the patch's item. Mutable."""

    def __init__(
        self,
        parent: QGraphicsItem,
        order: ZOrder,
        paint: Callable[[QPainter, Sequence[QPolygonF]], None],
        inks: Callable[[], Sequence[QColor]],
    ) -> None:
        super().__init__(parent)
        self._paint = paint
        self._inks = inks
        self._bounds = QRectF()
        self._cache = PaintCache()
        self._shape: ChartShape | None = None
        self._lines: list[QPolygonF] = []
        self.setZValue(order)

    def show_lines(self, shape: ChartShape, lines: Sequence[FloatArray], scale: float) -> None:
        """Draw ``lines`` (k, 2) [m] of a chart, ``scale`` scene units per metre; nothing to do for the same chart."""
        if shape is not self._shape:
            self.prepareGeometryChange()
            self._shape = shape
            self._bounds = padded_bounds(scale * shape.outline)
            self._lines = [to_polygon(scale * line) for line in lines]

    def boundingRect(self) -> QRectF:
        """Qt: the chart's rectangle."""
        return self._bounds

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Qt: draw the lines."""
        if self._lines:
            self._cache.paint(painter, (self._lines, *self._inks()), self._bounds, self._draw)

    def _draw(self, painter: QPainter) -> None:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self._paint(painter, self._lines)


class BorderLines(MapLayer):
    """A hairline where the skin ends."""

    order = ZOrder.BORDER

    def __init__(self, scene: MapScene) -> None:
        super().__init__(scene)
        self._lines = [_OutlineItem(patch, self.order, self._paint, self._inks) for patch in scene.patches]
        self.set_shown(shown=False)
        self.set_theme(scene.theme)

    def set_shown(self, *, shown: bool) -> None:
        """Show the lines of patches that are shown, or none."""
        super().set_shown(shown=shown)
        for item in self._lines:
            item.setVisible(shown)

    def show_document(self) -> None:
        """Follow the outlines."""
        for item, patch in zip(self._lines, self.scene.shapes.patches, strict=True):
            item.show_lines(patch.chart, self._lines_of(patch.chart), self.scene.shapes.frame.scale)

    def set_theme(self, theme: Theme) -> None:
        """Take the theme's line colours."""
        self._ink = QColor(theme.quiet)
        self._ground = QColor(theme.window)

    def _inks(self) -> Sequence[QColor]:
        return self._ink, self._ground

    def _lines_of(self, shape: ChartShape) -> Sequence[FloatArray]:
        return shape.border

    def _paint(self, painter: QPainter, lines: Sequence[QPolygonF]) -> None:
        painter.setPen(cosmetic_pen(painter, self._ink, 1.2))
        for line in lines:
            painter.drawPolyline(line)


class SeamLines(BorderLines):
    """Dashes on the ground's colour where a patch was cut."""

    order = ZOrder.SEAMS

    def _lines_of(self, shape: ChartShape) -> Sequence[FloatArray]:
        return shape.seam

    def _paint(self, painter: QPainter, lines: Sequence[QPolygonF]) -> None:
        dashes = cosmetic_pen(painter, self._ink, 1.6)
        dashes.setCapStyle(Qt.PenCapStyle.FlatCap)
        dashes.setDashPattern([4.0, 3.0])
        for pen in (cosmetic_pen(painter, self._ground, 4.0), dashes):
            painter.setPen(pen)
            for line in lines:
                painter.drawPolyline(line)


class _OverTaxels(QGraphicsItem):
    """An item as large as all taxels, drawn by its layer with the painter and the pixels per scene unit."""

    def __init__(self, scene: MapScene, order: ZOrder, paint: Callable[[QPainter, float], None]) -> None:
        super().__init__()
        self._taxels = scene.taxels
        self._paint = paint
        self.setZValue(order)
        self.setVisible(False)

    def follow(self) -> None:
        """The taxels lie elsewhere."""
        self.prepareGeometryChange()

    def boundingRect(self) -> QRectF:
        """Qt: around all taxels."""
        return self._taxels.bounds

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Qt: draw."""
        self._paint(painter, option.levelOfDetailFromTransform(painter.worldTransform()))


class TaxelDots(MapLayer):
    """A dot for each taxel at every zoom, as large as their distance allows."""

    order = ZOrder.DOTS
    replaces_image = True

    def __init__(self, scene: MapScene) -> None:
        super().__init__(scene)
        self._item = _OverTaxels(scene, self.order, self._paint)
        self.items = (self._item,)

    def show_document(self) -> None:
        """Follow the taxels."""
        self._item.follow()

    def _paint(self, painter: QPainter, pixels_per_unit: float) -> None:
        size = min(max(0.62 * self.scene.taxels.pitch * pixels_per_unit, 3.0), 24.0)
        for colour, dots in self.scene.taxels.by_colour():
            painter.setPen(cosmetic_pen(painter, colour, size))
            painter.drawPoints(dots)


_ID_PX = 10
_ABOVE_MARK = 10.0
"""From a taxel's middle to that of its number [px], where there is a mark at the taxel."""


class TaxelNumbers(MapLayer):
    """The taxels' hardware ids, or else numbers; where there is no room for all, those that are selected go first."""

    order = ZOrder.NUMBERS

    def __init__(self, scene: MapScene) -> None:
        super().__init__(scene)
        self._font = QFont()
        self._font.setPixelSize(_ID_PX)
        self._item = _OverTaxels(scene, self.order, self._paint)
        self.items = (self._item,)
        self._written: tuple[Skin, list[str]] | None = None

    def show_document(self) -> None:
        """Follow the taxels."""
        self._item.follow()

    def _paint(self, painter: QPainter, pixels_per_unit: float) -> None:
        taxels = self.scene.taxels
        view = painter.worldTransform()
        above = _ABOVE_MARK if taxels.marked_at(pixels_per_unit) else 0.0
        room = QRectF(painter.viewport()).adjusted(-20, -10, 20, 10)
        painter.setWorldTransform(QTransform())
        painter.setFont(self._font)
        painter.setPen(QColor(29, 33, 38))
        metrics = QFontMetricsF(self._font)
        texts = self._texts()
        width = metrics.horizontalAdvance(max(texts, key=len, default="")) + 6
        height = metrics.height() + 1
        for taxel, at in self._with_room(view, room, width, height):
            text = texts[taxel]
            tight = metrics.horizontalAdvance(text) + 4
            box = QRectF(at.x() - tight / 2, at.y() - above - height / 2, tight, height)
            painter.fillRect(box, QColor(255, 255, 255, 130))
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)

    def _texts(self) -> Sequence[str]:
        """(taxels,) the hardware ids, where a patch states none the running numbers."""
        skin = self.scene.document.skin
        if self._written is None or self._written[0] is not skin:
            texts: list[str] = []
            for patch in skin.patches:
                ids = patch.taxels.identity.ids
                running = range(len(texts), len(texts) + len(patch.taxels))
                texts += map(str, running if ids is None else ids.tolist())
            self._written = skin, texts
        return self._written[1]

    def _with_room(self, view: QTransform, room: QRectF, width: float, height: float) -> list[tuple[int, QPointF]]:
        """Taxels and their pixels, such that no two numbers of this size overlap."""
        taxels = self.scene.taxels
        others = np.setdiff1d(taxels.drawn, taxels.selected)
        taken: dict[tuple[int, int], QPointF] = {}
        found = []
        for taxel in np.concatenate([np.intersect1d(taxels.selected, taxels.drawn), others]).tolist():
            at = view.map(QPointF(*taxels.places[taxel].tolist()))
            column = int(at.x() // width)
            row = int(at.y() // height)
            around = [taken.get((column + dx, row + dy)) for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
            if room.contains(at) and all(
                other is None or abs(other.x() - at.x()) >= width or abs(other.y() - at.y()) >= height
                for other in around
            ):
                taken[column, row] = at
                found.append((taxel, at))
        return found


# Edges of a cell: 0 top, 1 right, 2 bottom, 3 left.
# Bits of its corners: 1 top left, 2 top right, 4 bottom right, 8 bottom left.
_SEGMENTS = {
    1: [(3, 0)], 2: [(0, 1)], 3: [(3, 1)], 4: [(1, 2)], 5: [(3, 0), (1, 2)], 6: [(0, 2)], 7: [(3, 2)],
    8: [(2, 3)], 9: [(0, 2)], 10: [(0, 1), (2, 3)], 11: [(1, 2)], 12: [(3, 1)], 13: [(0, 1)], 14: [(3, 0)],
}  # fmt: skip
_TABLE = np.full((16, 2, 2), -1)
for _case, _pairs in _SEGMENTS.items():
    _TABLE[_case, : len(_pairs)] = _pairs


def contour_segments(image: NDArray[Any], level: float) -> FloatArray:
    """The line ``image == level``.

    Args:
        image: (h, w) finite values at pixel centres.
        level: Values at or above it are inside.

    Returns:
        (s, 2, 2) segments as (column, row) with the first pixel's centre at (0, 0). Cost: 0.05 ms for a touch within
        512² pixels; 0.3 ms where all of them are around the level.
    """
    above = image >= level
    taken_rows, taken_columns = (np.flatnonzero(above.any(axis=axis)) for axis in (1, 0))
    if not len(taken_rows):
        return np.zeros((0, 2, 2))
    top = max(int(taken_rows[0]) - 1, 0)
    left = max(int(taken_columns[0]) - 1, 0)
    around = slice(top, int(taken_rows[-1]) + 2), slice(left, int(taken_columns[-1]) + 2)
    return _segments_around(image[around], above[around], level) + [left, top]


def _segments_around(image: NDArray[Any], above: BoolArray, level: float) -> FloatArray:
    """(s, 2, 2) segments of ``image`` (h, w) as above, by the four corners of each cell."""
    inside = above.view(np.uint8)
    upper = inside[:-1, :-1] | inside[:-1, 1:] << 1
    lower = inside[1:, 1:] << 2 | inside[1:, :-1] << 3
    cases = upper | lower
    rows, columns = np.nonzero((cases > 0) & (cases < 15))
    edges = _TABLE[cases[rows, columns]]
    crossings = _crossings(image, rows, columns, level)
    cell, pair = np.nonzero(edges[..., 0] >= 0)
    ends = edges[cell, pair]
    return crossings[cell[:, None], ends]


def _crossings(image: NDArray[Any], rows: NDArray[np.intp], columns: NDArray[np.intp], level: float) -> FloatArray:
    """(cells, 4, 2) where the level crosses each edge; meaningless for edges it does not cross."""
    corner = [image[rows + dr, columns + dc].astype(np.float64) for dr, dc in ((0, 0), (0, 1), (1, 1), (1, 0))]
    points = np.empty((len(rows), 4, 2))
    points[:, 0] = np.stack([columns + _interpolation(corner[0], corner[1], level), rows], axis=1)
    points[:, 1] = np.stack([columns + 1, rows + _interpolation(corner[1], corner[2], level)], axis=1)
    points[:, 2] = np.stack([columns + _interpolation(corner[3], corner[2], level), rows + 1], axis=1)
    points[:, 3] = np.stack([columns, rows + _interpolation(corner[0], corner[3], level)], axis=1)
    return points


def _interpolation(start: FloatArray, end: FloatArray, level: float) -> FloatArray:
    step = end - start
    return np.divide(level - start, step, out=np.full_like(start, 0.5), where=step != 0)


class TouchContours(MapLayer):
    """Lines around the touched areas, while there is a contact."""

    order = ZOrder.CONTOURS

    def __init__(self, scene: MapScene) -> None:
        super().__init__(scene)
        self._touched = False
        self._lines: list[QLineF] | None = None
        self._buffer = LineBuffer()

    def show_document(self) -> None:
        """Follow the patches."""
        self._lines = None

    def show_frame(self, frame: Frame) -> None:
        """Take the touch of another instant."""
        self._touched = bool(frame.regions)
        self._lines = None

    @property
    def lines(self) -> list[QLineF]:
        """What is drawn [scene units]; none on a patch that is hidden or held."""
        if self._lines is None:
            self._lines = self._buffer.fill(self._found()) if self._touched else []
        return self._lines

    def _found(self) -> FloatArray:
        """(s, 2, 2) [scene units]."""
        found = [np.zeros((0, 2, 2))]
        for number, shape in enumerate(self.scene.shapes.patches):
            tile, values = self.scene.tile(number)
            if shape.shown and number not in self.scene.held:
                found.append(shape.to_scene(tile.chart_points(contour_segments(values, CONTACT_KPA))))
        return np.concatenate(found)

    def paint(self, painter: QPainter, view: QTransform) -> None:
        """Draw the lines."""
        painter.setTransform(view, True)
        painter.setPen(cosmetic_pen(painter, QColor(29, 33, 38, 190), 1.3))
        painter.drawLines(self.lines)


class PinMarks(MapLayer):
    """A diamond where each pin of the patches shown is wanted."""

    order = ZOrder.PINS

    def __init__(self, scene: MapScene) -> None:
        super().__init__(scene)
        self._places: tuple[QPointF, ...] | None = None

    def show_document(self) -> None:
        """Take the document's pins."""
        self._places = None

    def paint(self, painter: QPainter, view: QTransform) -> None:
        """Draw the diamonds."""
        if self._places is None:
            self._places = self._found()
        for place in self._places:
            draw_pin(painter, view.map(place), QColor(255, 255, 255), large=False)

    def _found(self) -> tuple[QPointF, ...]:
        document = self.scene.document
        frame = self.scene.shapes.frame
        places = [pin_places(document, k) for k, patch in enumerate(document.patches) if patch.visible]
        return tuple(QPointF(x, y) for part in places for x, y in frame.to_scene(part).tolist())


_SMALLEST_ELLIPSE_PX = 7.0
_SMALLEST_ERROR_PX = 4.0
"""Half-axes below are hidden by the mark of the centre."""
_ANGLES = np.linspace(0, 2 * np.pi, 49)[:, None]
_INK = QColor(29, 33, 38, 150)


def ellipses_on_map(region: ContactRegion, map_: TactileMap) -> tuple[FloatArray, FloatArray]:
    """Half-axes (2, 2) each [m] of a region's ellipse and of its centre's error circle, as a map distorts them there.

    Asked of the map that is shown: the frame's own axes are those of the map that the session had then.

    Cost: 30 µs.
    """
    chart = map_.charts[region.at.patch]
    surface = map_.skin.patches[region.at.patch].surface
    body = surface.vertices[surface.faces[region.at.face]]
    plane = map_.uv[region.at.patch][chart.faces[region.at.face]]
    # Columns: what a step along the body is on the map; nothing where the triangle has no area.
    jacobian = (plane[1:] - plane[0]).T @ np.linalg.pinv(body[1:] - body[0], rcond=1e-6).T
    across = np.linalg.svd(body[1:] - body[0])[2][:2]
    return region.link_axes @ jacobian.T, region.place_error * across @ jacobian.T


def _paint_ellipse(
    painter: QPainter, at: QPointF, axes: FloatArray, view: QTransform, *, dotted: bool, least: float
) -> None:
    """An ellipse around ``at`` [px] with half-axes (2, 2) [scene units], thin; none where it is smaller than ``least``.

    Dotted is where the centre lies, whole how the contact does.
    """
    pixels = axes * [view.m11(), view.m22()]
    if np.linalg.norm(pixels, axis=1).max() < least:
        return
    round_ = np.cos(_ANGLES) * pixels[0] + np.sin(_ANGLES) * pixels[1] + [at.x(), at.y()]
    pen = QPen(_INK, 1.0, Qt.PenStyle.CustomDashLine, Qt.PenCapStyle.FlatCap)
    pen.setDashPattern([1.0, 3.0] if dotted else [5.0, 3.0])
    painter.setPen(pen)
    painter.drawPolygon(polygon(round_))


class ContactEllipses(MapLayer):
    """Each contact's ellipse, dashed, and the error circle of its centre, dotted."""

    order = ZOrder.SHAPES

    def __init__(self, scene: MapScene) -> None:
        super().__init__(scene)
        self._frame: Frame | None = None
        self._ellipses: list[tuple[QPointF, FloatArray, FloatArray]] | None = None

    def show_document(self) -> None:
        """The map distorts them otherwise."""
        self._ellipses = None

    def show_frame(self, frame: Frame) -> None:
        """Take the contacts of another instant."""
        self._frame = frame
        self._ellipses = None

    def paint(self, painter: QPainter, view: QTransform) -> None:
        """Draw those that are large enough."""
        if self._ellipses is None:
            self._ellipses = [] if self._frame is None else self._found(self._frame)
        for centre, ellipse, error in self._ellipses:
            at = view.map(centre)
            _paint_ellipse(painter, at, ellipse, view, dotted=False, least=_SMALLEST_ELLIPSE_PX)
            _paint_ellipse(painter, at, error, view, dotted=True, least=_SMALLEST_ERROR_PX)

    def _found(self, frame: Frame) -> list[tuple[QPointF, FloatArray, FloatArray]]:
        """Centre and half-axes (2, 2) each of ellipse and error circle [scene units], of the contacts to be seen."""
        scale = self.scene.shapes.frame.scale * np.array([1.0, -1.0])
        found = []
        for region in frame.regions:
            at = self.scene.mark_of(region.at)
            if at is not None and region.link_axes.any():
                ellipse, error = ellipses_on_map(region, self.scene.map)
                found.append((at, ellipse * scale, error * scale))
        return found
