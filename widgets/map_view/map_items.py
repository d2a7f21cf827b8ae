"""What lies still in the map's scene: the patches with their live image."""

from __future__ import annotations

from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QPainter, QPainterPath, QPen, QPolygonF, QTransform
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from app.arrays import FloatArray
from widgets.colours import Theme
from widgets.map_view.live_image import LiveImage
from widgets.map_view.map_shapes import MapShapes


def points(places: FloatArray) -> list[QPointF]:
    """Points at ``places`` (n, 2)."""
    return [QPointF(x, y) for x, y in places.tolist()]


def lines(segments: FloatArray) -> list[QLineF]:
    """Lines of ``segments`` (s, 2, 2)."""
    return [QLineF(x0, y0, x1, y1) for (x0, y0), (x1, y1) in segments.tolist()]


def cosmetic(painter: QPainter, colour: QColor, width: float) -> QPen:
    """A round pen as wide as asked in logical pixels, whatever the zoom and the display's scale."""
    device = painter.device()
    pen = QPen(colour, width * device.devicePixelRatio())  # cosmetic widths are in the device's own pixels
    pen.setCapStyle(Qt.PenCapStyle.RoundCap)
    pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    pen.setCosmetic(True)
    return pen


class PatchesItem(QGraphicsItem):
    """All patches: the live image cut out along their borders, a hairline around, seams dashed.

    Args:
        shapes: The map's shapes.
        live: Its image is drawn as it is at each paint; it may change in place.
        place: Where the image lies [scene units].
    """

    def __init__(self, shapes: MapShapes, live: LiveImage, place: QRectF, theme: Theme) -> None:
        super().__init__()
        self._area = QPainterPath()
        for patch in shapes.patches:
            self._area.addPolygon(QPolygonF(points(patch.outline)))
            self._area.closeSubpath()
        self._area.setFillRule(Qt.FillRule.WindingFill)
        self._borders = [points(line) for patch in shapes.patches for line in patch.border]
        self._seams = [points(line) for patch in shapes.patches for line in patch.seam]
        self._live = live  # keeps the memory behind the brush
        self._brush, image = QBrush(live.image), live.image
        to_scene = QTransform.fromTranslate(place.x(), place.y())
        self._brush.setTransform(to_scene.scale(place.width() / image.width(), place.height() / image.height()))
        self._bounds = QRectF(0, 0, *shapes.frame.size).adjusted(-2, -2, 2, 2)
        self._show_border = self._show_seams = True
        self.set_theme(theme)

    def line(self, *, border: bool, seams: bool) -> None:
        """Line the skin's end and dash its cuts, or do not."""
        self._show_border, self._show_seams = border, seams
        self.update()

    def set_theme(self, theme: Theme) -> None:
        """Take the theme's line colour."""
        self._border_ink, self._ground = QColor(theme.quiet), QColor(theme.window)
        self.update()

    def boundingRect(self) -> QRectF:
        """Qt: the map's rectangle."""
        return self._bounds

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Qt: draw image and borders."""
        painter.setRenderHints(QPainter.RenderHint.Antialiasing | QPainter.RenderHint.SmoothPixmapTransform)
        painter.fillPath(self._area, self._brush)
        if self._show_border:
            painter.setPen(cosmetic(painter, self._border_ink, 1.2))
            for border in self._borders:
                painter.drawPolyline(border)
        if self._show_seams:
            self._paint_seams(painter)

    def _paint_seams(self, painter: QPainter) -> None:
        painter.setPen(cosmetic(painter, self._ground, 4.0))
        for seam in self._seams:
            painter.drawPolyline(seam)
        dashes = cosmetic(painter, self._border_ink, 1.6)
        dashes.setCapStyle(Qt.PenCapStyle.FlatCap)
        dashes.setDashPattern([4.0, 3.0])
        painter.setPen(dashes)
        for seam in self._seams:
            painter.drawPolyline(seam)
