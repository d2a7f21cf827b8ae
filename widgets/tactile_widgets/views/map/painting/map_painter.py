"""What lies over the map, drawn in pixels: contacts with their force, fingertips, the hover mark, names, a scale."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPen, QTransform

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.reading_units import THIN
from tactile_maps.session.frame import Frame
from tactile_widgets.common.colours import Theme
from tactile_widgets.overlays.taxel_faults import FaultLegend
from tactile_widgets.views.map.items.background import Legend, legend_size, paint_legend
from tactile_widgets.views.map.items.map_coordinates import MARGIN_PX, nice_floor
from tactile_widgets.views.map.items.map_items import ZOrder
from tactile_widgets.views.map.items.map_scene import CONTACT_KPA, MapScene
from tactile_widgets.views.map.items.map_shapes import MapShapes, PatchShape
from tactile_widgets.views.map.items.taxel_faults import fault_legend_size, paint_fault_legend
from tactile_widgets.views.map.painting.legend_place import LegendPlace
from tactile_widgets.views.map.painting.map_layers import ellipses_on_map
from tactile_widgets.views.map.painting.task_layer import (
    TaskLegend,
    TaskPainter,
    task_legend_entries,
    task_legend_size,
)
from tactile_widgets.views.overlays.callouts import Callout, Spot, place_callouts
from tactile_widgets.views.overlays.painting import polygon
from tactile_widgets.views.overlays.task_overlay import NO_TASK, TaskOverlay

EDGE = 12.0
"""Distance of captions from the viewport's edge [px]."""
_LOW_EDGE = 6.0
"""Distance of the scale from the lower edge [px]: it is below the map while all of that is shown."""
_LONGEST_SCALE = 100.0
"""Of the scale bar [px]."""
_RING_GAP = 4.0
_SMALLEST_RING = 8.0
"""Between a touch and the ring around it, and the ring's smallest radius [px]: nothing is drawn over the touch."""
_CENTRE_FROM = 36.0
"""The centre of pressure is a dot only in rings at least as large [px]: in smaller ones it would be the picture."""

_SMALLEST_OUTLINE = 9.0
"""Half-axis of the outline of a second recording's contact [px]."""
_ANGLES = np.linspace(0, 2 * np.pi, 49)[:, None]


@dataclass(frozen=True)
class ContactMark:
    """A contact region.

    Attributes:
        at: Its centre of pressure [scene units].
        text: Its force in words.
        reach: How far from there the skin is touched [scene units].
    """

    at: QPointF
    text: str
    reach: float = 0.0

    def ring(self, view: QTransform) -> float:
        """Radius [px] of the ring that leaves the touch free."""
        return max(self.reach * view.m11() + _RING_GAP, _SMALLEST_RING)


@dataclass(frozen=True)
class FingerMark:
    """A fingertip: where it touches and its radius, both in scene units."""

    at: QPointF
    radius: float


@dataclass(frozen=True)
class MapMarks:
    """What is drawn over the map at one instant besides the layers, in scene units.

    Attributes:
        contacts: Centres of pressure.
        fingers: Fingertips on the skin.
        hover: What the pointer is over, in either view.
        readout: The words for it.
        replaying: Whether all this comes from a recording; said by the word and a coloured edge.
        paused: Whether time stands still; said by the word.
        legend: What the overlay's colours mean.
        faults: What marks on single taxels mean.
        task: What a controller with a task wants, and what came of it.
        target: Where that is now.
        overlaid: Contacts of a second recording: centre, and half-axes (2, 2) of the ellipse.
    """

    contacts: tuple[ContactMark, ...] = ()
    fingers: tuple[FingerMark, ...] = ()
    hover: QPointF | None = None
    readout: str = ""
    replaying: bool = False
    paused: bool = False
    legend: Legend | None = None
    faults: FaultLegend = ()
    task: TaskOverlay = NO_TASK
    target: QPointF | None = None
    overlaid: tuple[tuple[QPointF, FloatArray], ...] = ()

    def of_frame(self, frame: Frame, picture: MapScene) -> MapMarks:
        """The same view with the contacts of ``frame`` where the map of ``picture`` has them.

        The frame's own map points are those of the map that the session had then.
        """
        contacts = []
        for region in frame.regions:
            if (at := picture.mark_of(region.at)) is not None:
                words = self.task.force_words(region, frame.units)
                contacts.append(ContactMark(at, words, _reach(region, at, frame, picture)))
        tips = ((picture.mark_of(poke.at), poke.radius * picture.shapes.frame.scale) for poke in frame.pokes)
        return replace(
            self,
            contacts=tuple(contacts),
            fingers=tuple(FingerMark(at, radius) for at, radius in tips if at is not None),
        )


def outlines(regions: Sequence[ContactRegion], picture: MapScene) -> tuple[tuple[QPointF, FloatArray], ...]:
    """Centre and half-axes (2, 2) of the ellipse of each region, where the map of ``picture`` has it [scene units]."""
    scale = picture.shapes.frame.scale * np.array([1.0, -1.0])
    found = []
    for region in regions:
        at = picture.mark_of(region.at)
        if at is not None:
            found.append((at, ellipses_on_map(region, picture.map)[0] * scale))
    return tuple(found)


def _reach(region: ContactRegion, at: QPointF, frame: Frame, picture: MapScene) -> float:
    """How far the touched skin goes from a region's centre [scene units]; what a seam took away is not counted."""
    taxels = region.taxels
    shapes = picture.shapes
    own = picture.document.skin.patch_of[taxels] == region.at.patch if len(taxels) else np.zeros(0, bool)
    touched = taxels[own & (frame.pressures[taxels] >= 1e3 * CONTACT_KPA)]
    apart = np.linalg.norm(shapes.taxels[touched] - [at.x(), at.y()], axis=1)
    widest = 2 * float(np.sqrt(region.area / np.pi)) * shapes.frame.scale
    return min(float(apart.max(initial=0.0)), widest) + shapes.pitch  # the image carries a touch to the next taxels


class MapPainter:
    """Draws ``MapMarks`` over a viewport. Mutable only in its theme.

    Args:
        theme: Colours of everything that is not skin.
        font: The window's font; captions are a smaller cut of it.
    """

    def __init__(self, theme: Theme, font: QFont) -> None:
        self.theme = theme
        self._task = TaskPainter()
        self._keys = TaskLegend()
        self._legends = LegendPlace(EDGE)
        self._caption = QFont(font)
        self._figure = QFont(font)
        self._caption.setPixelSize(11)
        self._figure.setPixelSize(13)
        self._figure.setWeight(QFont.Weight.DemiBold)

    def paint(self, painter: QPainter, marks: MapMarks, picture: MapScene, view: QTransform, room: QRectF) -> None:
        """Draw all of ``marks``, and the layers that lie over the scene.

        Args:
            painter: Of the viewport.
            marks: At this instant.
            picture: Whose map, and whose layers.
            view: Takes scene units to pixels of the viewport.
            room: The viewport.
        """
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        own = {
            ZOrder.TASK: self._paint_task,
            ZOrder.NAMES: self._paint_names,
            ZOrder.FINGERS: self._paint_fingers,
            ZOrder.SHAPES: self._paint_overlaid,
            ZOrder.CONTACTS: self._paint_contacts,
            ZOrder.CAPTIONS: self._paint_captions,
        }
        layers = [layer for layer in picture.layers.values() if layer.shown]
        for order in ZOrder:
            for layer in layers:
                if layer.order is order:
                    painter.save()
                    layer.paint(painter, view)
                    painter.restore()
            if order in own:
                own[order](painter, marks, picture, view, room)

    def _paint_task(
        self, painter: QPainter, marks: MapMarks, picture: MapScene, view: QTransform, room: QRectF
    ) -> None:
        if marks.task:
            target = None if marks.target is None else view.map(marks.target)
            self._task.paint(painter, marks.task, target, picture.shapes, (view, room), self.theme)

    def _paint_names(
        self, painter: QPainter, _marks: MapMarks, picture: MapScene, view: QTransform, room: QRectF
    ) -> None:
        for patch in picture.shapes.patches:
            self._paint_name(painter, patch, view, room)

    def _paint_fingers(
        self, painter: QPainter, marks: MapMarks, _picture: MapScene, view: QTransform, _room: QRectF
    ) -> None:
        for finger in marks.fingers:
            at = view.map(finger.at)
            around = (contact.ring(view) for contact in marks.contacts if _near(view.map(contact.at), at))
            self._paint_ring(painter, at, max(finger.radius * view.m11(), *around, _SMALLEST_RING))

    def _paint_overlaid(
        self, painter: QPainter, marks: MapMarks, picture: MapScene, view: QTransform, room: QRectF
    ) -> None:
        """A dashed outline with a cross for each contact of the second recording, dark on a light halo."""
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for centre, axes in marks.overlaid:
            at = view.map(centre)
            pixels = axes * [view.m11(), view.m22()]
            sizes = np.maximum(np.linalg.norm(pixels, axis=1, keepdims=True), 1e-9)
            pixels = pixels * np.maximum(_SMALLEST_OUTLINE / sizes, 1.0)
            ring = polygon(np.cos(_ANGLES) * pixels[0] + np.sin(_ANGLES) * pixels[1] + [at.x(), at.y()])
            for ink, width, style in (
                (QColor(255, 255, 255, 200), 4.0, Qt.PenStyle.SolidLine),
                (QColor(29, 33, 38), 1.75, Qt.PenStyle.DashLine),
            ):
                painter.setPen(QPen(ink, width, style))
                painter.drawPolygon(ring)
            painter.drawLine(at - QPointF(4, 0), at + QPointF(4, 0))
            painter.drawLine(at - QPointF(0, 4), at + QPointF(0, 4))

    def _paint_contacts(
        self, painter: QPainter, marks: MapMarks, _picture: MapScene, view: QTransform, room: QRectF
    ) -> None:
        """The dot of each large one, and the forces beside them: over none of the touches."""
        metrics = QFontMetricsF(self._figure)
        spots = []
        for contact in marks.contacts:
            at = view.map(contact.at)
            ring = contact.ring(view)
            size = QSizeF(metrics.horizontalAdvance(contact.text) + 16, metrics.height() + 6)
            spots.append(Spot(at, ring, size))
            if ring >= _CENTRE_FROM:
                painter.setPen(QPen(QColor(29, 33, 38), 1.0))
                painter.setBrush(QColor(255, 255, 255))
                painter.drawEllipse(at, 2.0, 2.0)
                painter.setBrush(Qt.BrushStyle.NoBrush)
        inner = room.adjusted(EDGE, EDGE, -EDGE, -EDGE)
        seen = [number for number, spot in enumerate(spots) if room.contains(spot.at)]
        callouts = place_callouts([spots[number] for number in seen], inner)
        for number, callout in zip(seen, callouts, strict=True):
            self._paint_force(painter, marks.contacts[number].text, callout)

    def _paint_captions(
        self, painter: QPainter, marks: MapMarks, picture: MapScene, view: QTransform, room: QRectF
    ) -> None:
        """The hover mark, and words along the edges."""
        if marks.hover is not None and not self._in_touch(view.map(marks.hover), marks, view):
            self._paint_hover(painter, view.map(marks.hover))
        taken = self._paint_scale_bar(painter, picture.shapes.frame.scale * view.m11(), room)
        if marks.readout:
            self._paint_readout(painter, marks.readout, room, taken)
        self._paint_keys(painter, marks, picture.shapes, room)
        if marks.replaying:
            self._paint_edge(painter, room)
            self._paint_chip(painter, QPointF(EDGE, EDGE), "Replaying", self._figure, QColor(self.theme.text))
        elif marks.paused:
            self._paint_chip(painter, QPointF(EDGE, EDGE), "Paused", self._figure, QColor(self.theme.text))

    def _paint_keys(self, painter: QPainter, marks: MapMarks, shapes: MapShapes, room: QRectF) -> None:
        """What colours and marks mean, one below the other."""
        font = self._caption
        theme = self.theme
        legend = marks.legend
        keys = task_legend_entries(marks.task)
        faults = marks.faults
        sizes = [] if legend is None else [legend_size(legend, font)]
        sizes += [task_legend_size(keys, font)] if keys else []
        sizes += [fault_legend_size(faults, font)] if faults else []
        boxes = iter(self._legends.boxes(sizes, shapes, room))
        if legend is not None:
            paint_legend(painter, legend, next(boxes), font, theme)
        if keys:
            self._keys.paint(painter, keys, next(boxes), font, theme, room)
        if faults:
            paint_fault_legend(painter, faults, next(boxes), font, theme)

    def _paint_name(self, painter: QPainter, patch: PatchShape, view: QTransform, room: QRectF) -> None:
        low, high = patch.box
        box = view.mapRect(QRectF(*low, *(high - low)))
        if not (patch.shown and box.intersects(room)) or box.width() < 24:
            return
        metrics = QFontMetricsF(self._caption)
        text = metrics.elidedText(patch.name, Qt.TextElideMode.ElideMiddle, max(box.width() + 16, 40))
        width = metrics.horizontalAdvance(text) + 12
        height = metrics.height() + 4
        middle = box.intersected(room).center().x()
        left = min(max(middle - width / 2, EDGE), room.right() - EDGE - width)
        # Above its patch, also where the patch is framed; at the viewport's top while the patch reaches beyond it.
        corner = QPointF(left, max(box.top() - height - 2, EDGE if box.top() < MARGIN_PX - 1 else 0.0))
        self._paint_chip(painter, corner, text, self._caption, QColor(self.theme.quiet), QColor(self.theme.window))

    def _in_touch(self, at: QPointF, marks: MapMarks, view: QTransform) -> bool:
        """Whether a pixel is where the skin is touched: the pointer's cross would hide it."""
        return any(_near(view.map(contact.at), at, contact.ring(view) + 10.0) for contact in marks.contacts)

    def _paint_ring(self, painter: QPainter, at: QPointF, radius: float) -> None:
        """Around the touch, never over it: the pressure is the picture."""
        for colour, width in ((QColor(29, 33, 38, 110), 2.8), (QColor(self.theme.accent), 1.4)):
            painter.setPen(QPen(colour, width))
            painter.drawEllipse(at, radius, radius)

    def _paint_force(self, painter: QPainter, text: str, callout: Callout) -> None:
        if callout.leader is not None:
            for colour, width in ((QColor(29, 33, 38, 110), 2.8), (QColor(self.theme.text), 1.0)):
                painter.setPen(QPen(colour, width))
                painter.drawLine(*callout.leader)
        self._paint_chip(painter, callout.box.topLeft(), text, self._figure, QColor(self.theme.text))

    def _paint_hover(self, painter: QPainter, at: QPointF) -> None:
        for colour, width in self._halo_and_accent():
            painter.setPen(QPen(colour, width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
            for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                painter.drawLine(at + QPointF(4 * dx, 4 * dy), at + QPointF(10 * dx, 10 * dy))

    def _halo_and_accent(self) -> tuple[tuple[QColor, float], ...]:
        """The accent alone would drown in light skin, so it is drawn over a wider dark line."""
        return (QColor(29, 33, 38, 130), 4.6), (QColor(self.theme.accent), 2.6)

    def _paint_scale_bar(self, painter: QPainter, pixels_per_metre: float, room: QRectF) -> QRectF:
        """Draw the scale; returns where, so that nothing else is written there."""
        longest = min(_LONGEST_SCALE, 0.2 * room.width())  # the words beside it need room too
        millimetres = nice_floor(longest / pixels_per_metre * 1e3)
        length = millimetres * 1e-3 * pixels_per_metre
        text = f"{millimetres:g}{THIN}mm"
        metrics = QFontMetricsF(self._caption)
        height = metrics.height() + 4
        box = QRectF(EDGE, room.bottom() - _LOW_EDGE - height, length + metrics.horizontalAdvance(text) + 20, height)
        self._paint_ground(painter, box, QColor(self.theme.panel))
        left = box.left() + 6
        bottom = box.bottom() - 6
        painter.setPen(QPen(QColor(self.theme.quiet), 1.5, Qt.PenStyle.SolidLine, Qt.PenCapStyle.FlatCap))
        painter.drawPolyline([QPointF(left + x, bottom + y) for x, y in ((0, -5), (0, 0), (length, 0), (length, -5))])
        painter.setFont(self._caption)
        painter.drawText(QPointF(left + length + 8, bottom), text)
        return box

    def _paint_readout(self, painter: QPainter, text: str, room: QRectF, taken: QRectF) -> None:
        """Beside the scale, where there is room for all of it: the window's lower edge says it too."""
        left = room.right() - EDGE - QFontMetricsF(self._caption).horizontalAdvance(text) - 12
        if left > taken.right() + 8:
            self._paint_chip(painter, QPointF(left, taken.top()), text, self._caption, QColor(self.theme.text))

    def _paint_edge(self, painter: QPainter, room: QRectF) -> None:
        pen = QPen(QColor(self.theme.accent), 3)
        pen.setJoinStyle(Qt.PenJoinStyle.MiterJoin)
        painter.setPen(pen)
        painter.drawRect(room.adjusted(1.5, 1.5, -1.5, -1.5))

    def _paint_chip(
        self, painter: QPainter, corner: QPointF, text: str, font: QFont, ink: QColor, ground: QColor | None = None
    ) -> None:
        metrics = QFontMetricsF(font)
        pad = 8.0 if font.pixelSize() > 11 else 6.0
        box = QRectF(corner.x(), corner.y(), metrics.horizontalAdvance(text) + 2 * pad, metrics.height() + pad - 2)
        self._paint_ground(painter, box, ground or QColor(self.theme.panel))
        painter.setFont(font)
        painter.setPen(ink)
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)

    def _paint_ground(self, painter: QPainter, box: QRectF, ground: QColor) -> None:
        ground.setAlpha(225)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(ground)
        painter.drawRoundedRect(box, 4, 4)
        painter.setBrush(Qt.BrushStyle.NoBrush)


def _near(one: QPointF, other: QPointF, distance: float = 20.0) -> bool:
    away = one - other
    return bool(np.hypot(away.x(), away.y()) <= distance)
