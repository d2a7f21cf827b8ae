"""Layers of View > Overlay on the map, one class each, in the drawing order of ``ZOrder``.

====================  ===========  =============================================
class                 z-order      drawn as
====================  ===========  =============================================
``BorderLines``       BORDER       children of the patches
``SeamLines``         SEAMS        children of the patches
``TaxelDots``         DOTS         a canvas item, in place of the image
``TaxelNumbers``      NUMBERS      a canvas item
``TouchContours``     CONTOURS     painted over the canvas
``PinMarks``          PINS         painted over the canvas
``FrictionDots``      SHAPES       painted over the canvas
``ShearArrows``       SHAPES       painted over the canvas
``ContactEllipses``   SHAPES       painted over the canvas
====================  ===========  =============================================
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPen, QPolygonF, QTransform

from tactile_maps.contacts.detection.detection import TOUCH_THRESHOLD
from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.contacts.detection.shear_estimation import TAXEL_SLIPS
from tactile_maps.core.arrays import FloatArray
from tactile_maps.editing.pins import pin_places
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.model.taxel_frames import map_directions
from tactile_maps.session.frame import Frame
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.views.map.items.map_canvas import CONTACT_KPA, MapCanvas, MapLayer
from tactile_widgets.views.map.items.map_items import LineBuffer, MapItem, PatchItem, ZOrder, cosmetic_pen, draw_dots
from tactile_widgets.views.map.items.map_shapes import ChartShape
from tactile_widgets.views.overlays.callouts import LABELLED
from tactile_widgets.views.overlays.friction_marks import draw_slip, frame_friction, friction_legend, friction_rgb
from tactile_widgets.views.overlays.legend import MarkLegend
from tactile_widgets.views.overlays.paint_cache import PaintCache
from tactile_widgets.views.overlays.painting import RIM, WHITE, draw_pin, draw_strokes, faint, make_pen, polygon
from tactile_widgets.views.overlays.shear_arrows import (
    ARROW_PX,
    TaxelGroups,
    arrow_ends,
    draw_arrows,
    full_arrow,
    shear_legend,
    sheared_taxels,
)


class _OutlineItem(MapItem):
    """Lines along the outline of one patch, in its chart's frame; a child of the patch's item."""

    def __init__(self, parent: PatchItem, layer: BorderLines) -> None:
        super().__init__(layer.order, parent)
        self._layer = layer
        self._cache = PaintCache()
        self._shape: ChartShape | None = None
        self._lines: list[QPolygonF] = []

    def show_chart(self, shape: ChartShape, scale: float) -> None:
        """Draw the lines of a chart, ``scale`` scene units per metre; does nothing for the same chart."""
        if shape is not self._shape:
            self._shape = shape
            self.set_bounds(scale * shape.outline)
            self._lines = [polygon(scale * line) for line in self._layer.lines_of(shape)]

    def draw(self, painter: QPainter, pixels_per_unit: float) -> None:
        if self._lines:
            self._cache.paint(painter, (self._lines, self._layer.canvas.theme), self.bounds, self._draw_lines)

    def _draw_lines(self, painter: QPainter) -> None:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        draw_strokes(painter, self._lines, self._layer.pens(painter))


class BorderLines(MapLayer):
    """A hairline along the border of the skin."""

    order = ZOrder.BORDER

    def __init__(self, canvas: MapCanvas) -> None:
        super().__init__(canvas)
        # Not ``items``: as children of the patches they are on the canvas already.
        self._lines = [_OutlineItem(patch, self) for patch in canvas.patches]
        self.set_shown(shown=False)

    def set_shown(self, *, shown: bool) -> None:
        """Show or hide the lines of patches that are shown."""
        super().set_shown(shown=shown)
        for item in self._lines:
            item.setVisible(shown)

    def show_document(self) -> None:
        for item, patch in zip(self._lines, self.canvas.shapes.patches, strict=True):
            item.show_chart(patch.chart, self.canvas.shapes.frame.scale)

    def lines_of(self, shape: ChartShape) -> Sequence[FloatArray]:
        """Polylines (k, 2) of a chart [m]."""
        return shape.border

    def pens(self, painter: QPainter) -> Sequence[QPen]:
        """Pens of the lines, lowest first."""
        return [cosmetic_pen(painter, QColor(self.canvas.theme.quiet), 1.2)]


class SeamLines(BorderLines):
    """Dashes on the background's colour where a patch was cut."""

    order = ZOrder.SEAMS

    def lines_of(self, shape: ChartShape) -> Sequence[FloatArray]:
        return shape.seam

    def pens(self, painter: QPainter) -> Sequence[QPen]:
        theme = self.canvas.theme
        dashes = cosmetic_pen(painter, QColor(theme.quiet), 1.6)
        dashes.setCapStyle(Qt.PenCapStyle.FlatCap)
        dashes.setDashPattern([4.0, 3.0])
        return [cosmetic_pen(painter, QColor(theme.window), 4.0), dashes]


class _TaxelLayer(MapLayer):
    """Layer with one item as large as all taxels."""

    def __init__(self, canvas: MapCanvas) -> None:
        super().__init__(canvas)
        self._item = _LayerItem(self.order, self.draw)
        self._item.setVisible(False)
        self.items = (self._item,)

    def show_document(self) -> None:
        self._item.set_bounds(self.canvas.shapes.taxels)

    @abstractmethod
    def draw(self, painter: QPainter, pixels_per_unit: float) -> None:
        """Draw the item at a zoom of so many pixels per scene unit."""


class _LayerItem(MapItem):
    """Item drawn by its layer."""

    def __init__(self, order: ZOrder, draw: Callable[[QPainter, float], None]) -> None:
        super().__init__(order)
        self._draw = draw

    def draw(self, painter: QPainter, pixels_per_unit: float) -> None:
        self._draw(painter, pixels_per_unit)


class TaxelDots(_TaxelLayer):
    """A dot for each taxel at every zoom, as large as their distance allows."""

    order = ZOrder.DOTS
    replaces_image = True

    def draw(self, painter: QPainter, pixels_per_unit: float) -> None:
        taxels = self.canvas.taxels
        draw_dots(painter, taxels.dots(), min(max(0.62 * taxels.pitch * pixels_per_unit, 3.0), 24.0))


_ID_PX = 10
_ABOVE_MARK = 10.0
"""Distance of a taxel's number above a mark at the taxel [px]."""


class TaxelNumbers(_TaxelLayer):
    """The taxels' hardware ids, or running numbers; where there is no room for all, selected taxels come first."""

    order = ZOrder.NUMBERS

    def __init__(self, canvas: MapCanvas) -> None:
        super().__init__(canvas)
        self._font = QFont()
        self._font.setPixelSize(_ID_PX)
        self._written: tuple[Skin, list[str]] | None = None

    def draw(self, painter: QPainter, pixels_per_unit: float) -> None:
        view = painter.worldTransform()
        above = _ABOVE_MARK if self.canvas.taxels.marked_at(pixels_per_unit) else 0.0
        room = QRectF(painter.viewport()).adjusted(-20, -10, 20, 10)
        painter.setWorldTransform(QTransform())
        painter.setFont(self._font)
        painter.setPen(RIM)
        metrics = QFontMetricsF(self._font)
        texts = self._texts()
        width = metrics.horizontalAdvance(max(texts, key=len, default="")) + 6
        height = metrics.height() + 1
        for taxel, at in self._with_room(view, room, width, height):
            tight = metrics.horizontalAdvance(texts[taxel]) + 4
            box = QRectF(at.x() - tight / 2, at.y() - above - height / 2, tight, height)
            painter.fillRect(box, faint(WHITE, 130))
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, texts[taxel])

    def _texts(self) -> Sequence[str]:
        """(taxels,) hardware ids; running numbers on patches without any."""
        skin = self.canvas.document.skin
        if self._written is None or self._written[0] is not skin:
            texts: list[str] = []
            for patch in skin.patches:
                ids = patch.taxels.identity.ids
                running = range(len(texts), len(texts) + len(patch.taxels))
                texts += map(str, running if ids is None else ids.tolist())
            self._written = skin, texts
        return self._written[1]

    def _with_room(self, view: QTransform, room: QRectF, width: float, height: float) -> list[tuple[int, QPointF]]:
        """Return taxels and their pixels so that no two numbers of this size overlap."""
        taxels = self.canvas.taxels
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
_CORNERS = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
"""Column and row of each corner, clockwise from the top left."""
_EDGES = np.array([[0, 1], [1, 2], [3, 2], [0, 3]])
"""Corners at the ends of each edge; the same direction in both cells of an edge, so that both compute one point."""


def contour_segments(image: NDArray[Any], level: float) -> FloatArray:
    """Find the line ``image == level`` by marching squares.

    Args:
        image: (h, w) finite values at pixel centres.
        level: Values at or above it are inside.

    Returns:
        (s, 2, 2) unordered segments as (column, row), with the first pixel's centre at (0, 0); exact on the edges of
        the bilinear grid. Cost: 0.05 ms for a touch within 512² pixels; 0.3 ms if all of them are near the level.
    """
    above = image >= level
    rows, columns = (np.flatnonzero(above.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return np.zeros((0, 2, 2))
    top = max(int(rows[0]) - 1, 0)
    left = max(int(columns[0]) - 1, 0)
    around = slice(top, int(rows[-1]) + 2), slice(left, int(columns[-1]) + 2)
    image = image[around]
    inside = above[around].view(np.uint8)
    cases = inside[:-1, :-1] | inside[:-1, 1:] << 1 | inside[1:, 1:] << 2 | inside[1:, :-1] << 3
    rows, columns = np.nonzero((cases > 0) & (cases < 15))
    corners = np.stack([columns, rows], axis=1)[:, None] + _CORNERS
    values = image[corners[..., 1], corners[..., 0]].astype(np.float64)
    start = values[:, _EDGES[:, 0]]
    step = values[:, _EDGES[:, 1]] - start
    share = np.divide(level - start, step, out=np.full_like(start, 0.5), where=step != 0)
    side = _CORNERS[_EDGES[:, 1]] - _CORNERS[_EDGES[:, 0]]
    crossings = corners[:, _EDGES[:, 0]] + share[..., None] * side
    edges = _TABLE[cases[rows, columns]]
    cell, pair = np.nonzero(edges[..., 0] >= 0)
    return crossings[cell[:, None], edges[cell, pair]] + [left, top]


class _PaintedLayer(MapLayer):
    """Layer painted over the canvas, whose marks are found when it is first painted after a change."""

    def __init__(self, canvas: MapCanvas) -> None:
        super().__init__(canvas)
        self._frame: Frame | None = None
        self._found: list[Any] | None = None

    def show_document(self) -> None:
        self._found = None

    def show_frame(self, frame: Frame) -> None:
        self._frame = frame
        self._found = None

    @property
    def marks(self) -> list[Any]:
        """Marks to paint [scene units]."""
        if self._found is None:
            self._found = self.find()
        return self._found

    @abstractmethod
    def find(self) -> list[Any]:
        """Find the marks on the current document and tick."""


def _contour_level(region: ContactRegion, pressures: FloatArray) -> float:
    """Pressure [Pa] at the contour of a contact: that of touch, or more where noise of its untouched taxels exceeds it.

    Its touched taxels have the highest readings.
    """
    untouched = 0 if region.touched is None else len(region.taxels) - region.touched
    if not 0 < untouched < len(region.taxels):
        return TOUCH_THRESHOLD
    below, above = np.sort(pressures[region.taxels])[untouched - 1 : untouched + 1].tolist()
    return TOUCH_THRESHOLD if below < TOUCH_THRESHOLD else 0.5 * (below + above)


class TouchContours(_PaintedLayer):
    """Contour lines around the touched areas of contacts; none on hidden and held patches.

    Readings outside contacts have none: the noise of a real skin may exceed the pressure of touch.
    """

    order = ZOrder.CONTOURS

    def __init__(self, canvas: MapCanvas) -> None:
        super().__init__(canvas)
        self._buffer = LineBuffer()

    def find(self) -> list[QLineF]:
        if self._frame is None or not self._frame.regions:
            return []
        canvas = self.canvas
        image, level = self._image(self._frame)
        taxels = np.concatenate([region.taxels for region in self._frame.regions])
        found = [np.zeros((0, 2, 2))]
        for number in np.unique(canvas.document.skin.patch_of[taxels]).tolist():
            shape = canvas.shapes.patches[number]
            if shape.shown and number not in canvas.held:
                segments = contour_segments(image[canvas.atlas.window(number)], level)
                found.append(shape.to_scene(canvas.atlas.tiles[number].chart_points(segments)))
        return self._buffer.fill(np.concatenate(found))

    def _image(self, frame: Frame) -> tuple[NDArray[np.float32], float]:
        """Return an image without the readings outside contacts, and its level at the contours."""
        canvas = self.canvas
        pressures = np.maximum(np.nan_to_num(frame.pressures), 0.0)
        levels = np.full(len(pressures), np.inf)
        for region in frame.regions:
            levels[region.taxels] = np.minimum(levels[region.taxels], _contour_level(region, pressures))
        if (levels[pressures > 0] == TOUCH_THRESHOLD).all() and np.array_equal(pressures, frame.pressures):
            return canvas.kilopascals, CONTACT_KPA  # nothing is left out
        image = np.zeros(canvas.atlas.shape, np.float32)
        relative = pressures / levels  # 1 at the contours
        canvas.atlas.render(1e3 * relative, image, changed=np.flatnonzero(relative))
        return image, 1.0

    def paint(self, painter: QPainter, view: QTransform) -> None:
        painter.setTransform(view, True)
        pen = cosmetic_pen(painter, faint(RIM, 190), 1.3)
        pen.setCapStyle(Qt.PenCapStyle.SquareCap)  # 2 ms for 2,500 segments; with round caps 36 ms
        painter.setPen(pen)
        painter.drawLines(self.marks)


class PinMarks(_PaintedLayer):
    """A diamond at the target of each pin of the patches that are shown."""

    order = ZOrder.PINS

    def show_frame(self, frame: Frame) -> None:
        """Do nothing: pins do not change with a tick."""

    def paint(self, painter: QPainter, view: QTransform) -> None:
        for place in self.marks:
            draw_pin(painter, view.map(place), WHITE, large=False)

    def find(self) -> list[QPointF]:
        document = self.canvas.document
        places = [pin_places(document, k) for k, patch in enumerate(document.patches) if patch.visible]
        return [QPointF(x, y) for part in places for x, y in self.canvas.shapes.frame.to_scene(part).tolist()]


class FrictionDots(_PaintedLayer):
    """Dots in the colour of the friction in use on pressed taxels, with a ring around those that slip."""

    order = ZOrder.SHAPES

    @property
    def legend(self) -> MarkLegend | None:
        return None if self._frame is None or self._frame.shear is None else friction_legend()

    def find(self) -> list[tuple[int, float]]:
        """Find pressed taxels and their friction in use."""
        used = frame_friction(self._frame)
        drawn = self.canvas.taxels.drawn
        return [] if used is None else [(k, used[k]) for k in drawn[np.isfinite(used[drawn])].tolist()]

    def paint(self, painter: QPainter, view: QTransform) -> None:
        size = min(max(0.62 * self.canvas.taxels.pitch * view.m11(), 4.0), 24.0)
        for taxel, used in self.marks:
            at = view.map(QPointF(*self.canvas.shapes.taxels[taxel].tolist()))
            painter.setPen(make_pen(QColor(*friction_rgb(np.array([used]))[0].tolist()), size))
            painter.drawPoint(at)
            if used >= TAXEL_SLIPS:
                draw_slip(painter, at, size)


class ShearArrows(MapLayer):
    """Arrows of the traction on pressed taxels while frames have shear; see ``shear_arrows``."""

    order = ZOrder.SHAPES

    def __init__(self, canvas: MapCanvas) -> None:
        super().__init__(canvas)
        self._frame: Frame | None = None

    def show_frame(self, frame: Frame) -> None:
        self._frame = None if frame.shear is None else frame

    @property
    def legend(self) -> MarkLegend | None:
        return None if self._frame is None else shear_legend(self.canvas.scale, self._frame.units)

    def paint(self, painter: QPainter, view: QTransform) -> None:
        draw_arrows(painter, self.ends(view))

    def ends(self, view: QTransform) -> FloatArray:
        """Return tail and tip (k, 2, 2) of the arrows [px]."""
        frame = self._frame
        if frame is None or frame.shear is None:
            return np.zeros((0, 2, 2))
        taxels = sheared_taxels(frame)
        shapes = self.canvas.shapes
        taxels = taxels[shapes.on_shown()[taxels]]
        map_ = self.canvas.map
        shear = frame.shear[taxels]
        on_map = np.einsum("kij,kj->ki", map_directions(map_)[taxels], shear)
        # The map distorts the length; that of an arrow is the traction.
        on_map *= np.linalg.norm(shear, axis=1, keepdims=True) / np.linalg.norm(on_map, axis=1, keepdims=True)
        cells = np.full(len(taxels), ARROW_PX / (shapes.frame.scale * view.m11()))
        patches = map_.skin.patch_of[taxels]
        groups = TaxelGroups.of(map_.taxel_points[taxels], patches, map_.skin.areas[taxels], cells)
        places = groups.means(shapes.taxels[taxels]) * [view.m11(), view.m22()] + [view.dx(), view.dy()]
        steps = groups.means(on_map) * [1.0, -1.0] * (ARROW_PX / full_arrow(self.canvas.scale))
        return arrow_ends(places, steps)


_SMALLEST_ELLIPSE_PX = 7.0
_SMALLEST_ERROR_PX = 4.0
"""Half-axes below which the mark of the centre would hide the ellipse."""
_ANGLES = np.linspace(0, 2 * np.pi, 49)[:, None]


def ellipse_polygon(at: QPointF, axes: FloatArray) -> QPolygonF:
    """Return the ellipse around ``at`` with half-axes (2, 2), all in pixels."""
    return polygon(np.cos(_ANGLES) * axes[0] + np.sin(_ANGLES) * axes[1] + [at.x(), at.y()])


def ellipses_on_map(region: ContactRegion, map_: TactileMap) -> tuple[FloatArray, FloatArray]:
    """Return a region's ellipse and the error circle of its centre, as distorted by a map there: half-axes (2, 2) [m].

    The map is that which is shown; the axes in the frame belong to the map that the session had then. Cost: 30 µs.
    """
    chart = map_.charts[region.at.patch]
    surface = map_.skin.patches[region.at.patch].surface
    body = surface.vertices[surface.faces[region.at.face]]
    plane = map_.uv[region.at.patch][chart.faces[region.at.face]]
    # Columns: image on the map of a unit step along the body; zero where the triangle has no area.
    jacobian = (plane[1:] - plane[0]).T @ np.linalg.pinv(body[1:] - body[0], rcond=1e-6).T
    across = np.linalg.svd(body[1:] - body[0])[2][:2]
    return region.link_axes @ jacobian.T, region.place_error * across @ jacobian.T


class ContactEllipses(_PaintedLayer):
    """Ellipses of the contacts with captions, dashed, and error circles of their centres, dotted, if large enough."""

    order = ZOrder.SHAPES

    def paint(self, painter: QPainter, view: QTransform) -> None:
        styles = (([5.0, 3.0], _SMALLEST_ELLIPSE_PX), ([1.0, 3.0], _SMALLEST_ERROR_PX))
        for centre, *shapes in self.marks:
            for axes, (dashes, least) in zip(shapes, styles, strict=True):
                pixels = axes * [view.m11(), view.m22()]
                if np.linalg.norm(pixels, axis=1).max() >= least:
                    painter.setPen(make_pen(faint(RIM, 150), 1.0, Qt.PenCapStyle.FlatCap, dashes=dashes))
                    painter.drawPolygon(ellipse_polygon(view.map(centre), pixels))

    def find(self) -> list[tuple[QPointF, FloatArray, FloatArray]]:
        """Find centre and half-axes (2, 2) of ellipse and error circle of each contact [scene units]."""
        scale = self.canvas.shapes.frame.scale * np.array([1.0, -1.0])
        found = []
        for region in () if self._frame is None else self._frame.regions[:LABELLED]:
            at = self.canvas.mark_of(region.at)
            if at is not None and region.link_axes.any():
                ellipse, error = ellipses_on_map(region, self.canvas.map)
                found.append((at, ellipse * scale, error * scale))
        return found
