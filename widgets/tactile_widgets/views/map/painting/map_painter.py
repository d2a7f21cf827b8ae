"""Painting over the map in pixels: contacts with their force, fingertips, the hover mark, names, scale and legends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPainterPath, QPen, QPolygonF, QTransform

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.reading_units import THIN
from tactile_maps.session.frame import Frame
from tactile_widgets.common.colours import Theme
from tactile_widgets.overlays.taxel_faults import FaultLegend
from tactile_widgets.views.interaction.view_tool import NO_BOXES, ToolBoxes
from tactile_widgets.views.map.items.background import BackgroundLegend
from tactile_widgets.views.map.items.map_canvas import CONTACT_KPA, MapCanvas
from tactile_widgets.views.map.items.map_coordinates import MapCamera, nice_floor
from tactile_widgets.views.map.items.map_items import ZOrder
from tactile_widgets.views.map.items.map_shapes import MapShapes
from tactile_widgets.views.map.items.taxel_faults import fault_marks_legend
from tactile_widgets.views.map.painting.legend_place import LegendPlace
from tactile_widgets.views.map.painting.map_layers import ellipse_polygon, ellipses_on_map
from tactile_widgets.views.map.painting.name_place import Name, NamePlace
from tactile_widgets.views.map.painting.task_layer import TaskPainter, task_legend, task_legend_entries
from tactile_widgets.views.overlays.callouts import LABELLED, Callout, Spot, hides, more_contacts, place_callouts
from tactile_widgets.views.overlays.legend import Legend
from tactile_widgets.views.overlays.paint_cache import PaintCache
from tactile_widgets.views.overlays.painting import (
    EDGE,
    PRESENT,
    RIM,
    WHITE,
    ViewState,
    caption_fonts,
    chip_size,
    draw_cross,
    faint,
    make_pen,
    paint_box,
    paint_chip,
    paint_state,
    polygon,
    state_chips,
)
from tactile_widgets.views.overlays.task_overlay import NO_TASK, TaskOverlay

_LOW_EDGE = 6.0
"""Distance of the scale bar from the lower edge [px]: it is below the map while the whole map is in view."""
_LONGEST_SCALE = 100.0
"""Maximum length of the scale bar [px]."""
_RING_GAP = 4.0
_SMALLEST_RING = 8.0
"""Gap between a touch and the ring around it, and the ring's minimum radius [px]: nothing is drawn over the touch."""
_WIDEST_LEGEND = 0.6
"""Share of the viewport's width from which the lines of a legend are wrapped."""
_CENTRE_FROM = 36.0
"""Radius of the ring from which the centre of pressure is a dot [px]: in a smaller ring it would hide the touch."""

_SMALL_PATCH = 8.0
"""Area of a patch's box, relative to that of a caption, below which the captions of contacts keep it free."""
_ALL_HIDDEN = "All patches are hidden.\nEdit > Show all patches shows them."
_SMALLEST_OUTLINE = 9.0
"""Half-axis of the outline of a second recording's contact [px]."""


@dataclass(frozen=True)
class ContactMark:
    """Mark of a contact region.

    Attributes:
        at: Centre of pressure [scene units].
        text: Force as text.
        reach: Radius of the touched skin [scene units].
        patch: Number of the patch; -1 if unknown.
    """

    at: QPointF
    text: str
    reach: float = 0.0
    patch: int = -1

    def ring(self, view: QTransform) -> float:
        """Radius of the ring around the touch [px]."""
        return max(self.reach * view.m11() + _RING_GAP, _SMALLEST_RING)


@dataclass(frozen=True)
class FingerMark:
    """Mark of a fingertip: location and radius [scene units]."""

    at: QPointF
    radius: float


@dataclass(frozen=True)
class MapMarks:
    """Everything drawn over the map at one instant except the layers, in scene units.

    Attributes:
        contacts: Centres of pressure.
        fingers: Fingertips on the skin.
        hover: Location under the pointer in either view.
        state: State of the view, such as paused or replaying.
        legend: Meaning of the background's colours.
        layers: Legends of the layers.
        faults: Meaning of the marks on faulty taxels.
        task: The controller's task.
        target: Current target of the task.
        overlaid: Contacts of a second recording: centre, and half-axes (2, 2) of the ellipse.
    """

    contacts: tuple[ContactMark, ...] = ()
    fingers: tuple[FingerMark, ...] = ()
    hover: QPointF | None = None
    state: ViewState = PRESENT
    legend: BackgroundLegend | None = None
    layers: tuple[Legend, ...] = ()
    faults: FaultLegend = ()
    task: TaskOverlay = NO_TASK
    target: QPointF | None = None
    overlaid: tuple[tuple[QPointF, FloatArray], ...] = ()

    def of_frame(self, frame: Frame, picture: MapCanvas) -> MapMarks:
        """Return these marks with the contacts of ``frame``, placed on the map of ``picture``.

        The map points in the frame belong to the map that the session had then.
        """
        contacts = []
        for region in frame.regions:
            if (at := picture.mark_of(region.at)) is not None:
                words = self.task.force_words(region, frame.units, frame.notes)
                contacts.append(ContactMark(at, words, _reach(region, at, frame, picture), region.at.patch))
        tips = ((picture.mark_of(poke.at), poke.radius * picture.shapes.frame.scale) for poke in frame.pokes)
        return replace(
            self,
            contacts=tuple(contacts),
            fingers=tuple(FingerMark(at, radius) for at, radius in tips if at is not None),
        )


@dataclass(frozen=True, eq=False)
class Captions:
    """Captions of one picture except those of contacts, placed.

    Attributes:
        names: Box and text of each patch's name.
        state: Boxes of the chips with the view's state.
        scale: Box of the scale bar, length of its line [px], and its text.
        legends: Legends of colours and marks with their boxes, one below the other.
        tool: Boxes of the active tool.
    """

    names: Sequence[Name]
    state: Sequence[QRectF]
    scale: tuple[QRectF, float, str]
    legends: Sequence[tuple[Legend, QRectF]]
    tool: ToolBoxes = NO_BOXES

    @property
    def boxes(self) -> list[QRectF]:
        """All boxes, those of the scale bar and the legends last."""
        names = (box for box, _ in self.names)
        return [*names, *self.tool.labels, *self.state, self.scale[0], *(box for _, box in self.legends)]


def outlines(regions: Sequence[ContactRegion], picture: MapCanvas) -> tuple[tuple[QPointF, FloatArray], ...]:
    """Return centre and half-axes (2, 2) of each region's ellipse on the map of ``picture`` [scene units]."""
    scale = picture.shapes.frame.scale * np.array([1.0, -1.0])
    found = []
    for region in regions:
        at = picture.mark_of(region.at)
        if at is not None:
            found.append((at, ellipses_on_map(region, picture.map)[0] * scale))
    return tuple(found)


def _reach(region: ContactRegion, at: QPointF, frame: Frame, picture: MapCanvas) -> float:
    """Radius of the touched skin around a region's centre [scene units], without parts behind a seam."""
    taxels = region.taxels
    shapes = picture.shapes
    own = picture.document.skin.patch_of[taxels] == region.at.patch if len(taxels) else np.zeros(0, bool)
    touched = taxels[own & (frame.pressures[taxels] >= 1e3 * CONTACT_KPA)]
    apart = np.linalg.norm(shapes.taxels[touched] - [at.x(), at.y()], axis=1)
    widest = 2 * float(np.sqrt(region.area / np.pi)) * shapes.frame.scale
    return min(float(apart.max(initial=0.0)), widest) + shapes.pitch  # the image interpolates up to the next taxels


class MapPainter:
    """Paints ``MapMarks`` over a viewport.

    Args:
        theme: Colours of everything except the skin; may be replaced.
        font: Font of the window, from which those of captions are derived.

    Attributes:
        left_out: Texts of names and forces that are not painted; see ``leave_out_hiding``.
    """

    def __init__(self, theme: Theme, font: QFont) -> None:
        self.theme = theme
        self._task = TaskPainter()
        self._legend_cache = PaintCache(at_once=True)
        self._legends = LegendPlace(EDGE)
        self._caption, self._figure = caption_fonts(font)
        self._names = NamePlace(self._caption)
        self.left_out = frozenset[str]()

    def paint(
        self,
        painter: QPainter,
        marks: MapMarks,
        picture: MapCanvas,
        view: QTransform,
        room: QRectF,
        tool: ToolBoxes = NO_BOXES,
    ) -> None:
        """Paint all marks, and the layers over the canvas.

        Args:
            painter: Painter of the viewport.
            marks: Current marks.
            picture: Map and layers.
            view: Conversion of scene units to pixels.
            room: The viewport.
            tool: Boxes in which the active tool draws afterwards.
        """
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        captions = replace(self.captions(marks, picture, view, room), tool=tool)
        own = {
            ZOrder.TASK: partial(self._paint_task, painter, marks, picture, view),
            ZOrder.NAMES: partial(self._paint_names, painter, captions.names),
            ZOrder.FINGERS: partial(self._paint_fingers, painter, marks, view),
            ZOrder.SHAPES: partial(self._paint_overlaid, painter, marks, view),
            ZOrder.CONTACTS: partial(self._paint_contacts, painter, marks, picture, view, room, captions),
            ZOrder.CAPTIONS: partial(self._paint_captions, painter, marks, picture, view, room, captions),
        }
        layers = [layer for layer in picture.layers.values() if layer.shown]
        for order in ZOrder:
            for layer in layers:
                if layer.order is order:
                    painter.save()
                    layer.paint(painter, view)
                    painter.restore()
            if order in own:
                own[order]()

    def _paint_task(self, painter: QPainter, marks: MapMarks, picture: MapCanvas, view: QTransform) -> None:
        if marks.task:
            target = None if marks.target is None else view.map(marks.target)
            self._task.paint(painter, marks.task, target, picture.shapes, picture.still, view, self.theme)

    def _paint_names(self, painter: QPainter, names: Sequence[Name]) -> None:
        for box, text in names:
            paint_chip(painter, box, text, self._caption, self.theme.quiet, self.theme.window)

    def captions(self, marks: MapMarks, picture: MapCanvas, view: QTransform, room: QRectF) -> Captions:
        """Place all captions except those of contacts: names, state, scale bar and legends."""
        legends = self._all_legends(marks, room)
        sizes = [legend.size(self._caption) for legend in legends]
        boxes = self._legends.boxes(sizes, picture.shapes, room, view)
        state = [box for box, *_ in state_chips(self._caption, marks.state, more_contacts(len(marks.contacts)))]
        met = [chip.bottom() + 6 - boxes[0].top() for chip in state if any(chip.intersects(box) for box in boxes)]
        down = max(met, default=0.0)  # in a narrow view
        boxes = [box.translated(0, down) for box in boxes]
        scale = self._scale(picture.shapes.frame.scale * view.m11(), room)
        names = self._names.names(picture.shapes, view, room, boxes, scale[0])
        names = [(box, text) for box, text in names if text not in self.left_out]
        return Captions(names, state, scale, list(zip(legends, boxes, strict=True)))

    def legends_fit(
        self, marks: MapMarks, picture: MapCanvas, view: QTransform, room: QRectF, *, whole_map: bool
    ) -> bool:
        """Whether the legends and the scale bar are in the viewport and hide no other caption.

        Args:
            marks: Current marks.
            picture: Map and layers.
            view: Conversion of scene units to pixels.
            room: The viewport.
            whole_map: Whether they must not hide a patch either.
        """
        placed = self.captions(marks, picture, view, room)
        legends = [box for _, box in placed.legends]
        *captions, scale = placed.boxes[: -len(legends) or None]
        boxes = [scale, *legends]
        if not all(room.contains(box) for box in boxes):
            return False
        if any(one.intersects(other) for one in legends for other in (*captions, scale)):
            return False
        patches = QPainterPath()
        for patch in picture.shapes.patches if whole_map else ():
            if patch.shown:
                patches.addPolygon(view.map(polygon(patch.outline)))
        return not any(patches.intersects(box) for box in legends)

    def callouts(
        self, marks: MapMarks, picture: MapCanvas, view: QTransform, room: QRectF
    ) -> list[tuple[Callout, str]]:
        """Return place and text of the captions of the strongest contacts."""
        captions = self.captions(marks, picture, view, room)
        return [(callout, mark.text) for callout, mark in self._callouts(marks, picture, view, room, captions)]

    def _callouts(
        self, marks: MapMarks, picture: MapCanvas, view: QTransform, room: QRectF, captions: Captions
    ) -> list[tuple[Callout, ContactMark]]:
        captioned = [mark for mark in marks.contacts[:LABELLED] if mark.text not in self.left_out]
        seen = [mark for mark in captioned if room.contains(view.map(mark.at))]
        if not seen:
            return []
        skin = _outlines(picture, view)
        spots = [
            Spot(
                view.map(mark.at),
                mark.ring(view),
                chip_size(mark.text, self._figure),
                foreign=tuple(outline for number, outline in skin.items() if number != mark.patch),
            )
            for mark in seen
        ]
        inner = room.adjusted(EDGE, EDGE, -EDGE, -EDGE)
        kept = [*captions.tool.handles, *_small_patches([spot.size for spot in spots], skin)]
        return list(zip(place_callouts(spots, inner, captions.boxes, kept), seen, strict=True))

    def leave_out_hiding(
        self, marks: MapMarks, picture: MapCanvas, view: QTransform, room: QRectF
    ) -> tuple[frozenset[str], frozenset[str]]:
        """Stop painting names that hide skin, then forces that still hide another patch than theirs; return both."""
        self.left_out = frozenset()
        skin = _outlines(picture, view)
        chips = self.captions(marks, picture, view, room).names
        names = frozenset(text for box, text in chips if any(hides(box, one) for one in skin.values()))
        self.left_out = names
        captions = self.captions(marks, picture, view, room)
        forces = frozenset(
            mark.text
            for callout, mark in self._callouts(marks, picture, view, room, captions)
            if any(hides(callout.box, one) for number, one in skin.items() if number != mark.patch)
        )
        self.left_out = names | forces
        return names, forces

    def callouts_fit(self, marks: MapMarks, picture: MapCanvas, view: QTransform, room: QRectF) -> bool:
        """Whether the captions of contacts hide no other caption, no contact and no small patch."""
        captions = self.captions(marks, picture, view, room)
        boxes = [callout.box for callout, _ in self._callouts(marks, picture, view, room, captions)]
        kept = [Spot(view.map(mark.at), mark.ring(view), QSizeF()).box for mark in marks.contacts]
        kept += captions.boxes
        kept += _small_patches([box.size() for box in boxes], _outlines(picture, view))
        return not any(box.intersects(other) for box in boxes for other in kept)

    def _paint_fingers(self, painter: QPainter, marks: MapMarks, view: QTransform) -> None:
        for finger in marks.fingers:
            at = view.map(finger.at)
            around = (contact.ring(view) for contact in marks.contacts if _near(view.map(contact.at), at))
            radius = max(finger.radius * view.m11(), *around, _SMALLEST_RING)
            # Around the touch, never over it.
            for pen in (QPen(faint(RIM, 110), 2.8), QPen(QColor(self.theme.accent), 1.4)):
                painter.setPen(pen)
                painter.drawEllipse(at, radius, radius)

    def _paint_overlaid(self, painter: QPainter, marks: MapMarks, view: QTransform) -> None:
        """Paint a dashed outline with a cross for each contact of the second recording, dark on a light halo."""
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for centre, axes in marks.overlaid:
            at = view.map(centre)
            pixels = axes * [view.m11(), view.m22()]
            sizes = np.maximum(np.linalg.norm(pixels, axis=1, keepdims=True), 1e-9)
            ring = ellipse_polygon(at, pixels * np.maximum(_SMALLEST_OUTLINE / sizes, 1.0))
            for pen in (QPen(faint(WHITE, 200), 4.0), QPen(RIM, 1.75, Qt.PenStyle.DashLine)):
                painter.setPen(pen)
                painter.drawPolygon(ring)
            painter.drawLine(at - QPointF(4, 0), at + QPointF(4, 0))
            painter.drawLine(at - QPointF(0, 4), at + QPointF(0, 4))

    def _paint_contacts(
        self,
        painter: QPainter,
        marks: MapMarks,
        picture: MapCanvas,
        view: QTransform,
        room: QRectF,
        captions: Captions,
    ) -> None:
        """Paint the centre of each large contact, and the forces next to the strongest ones, over none of these."""
        for contact in marks.contacts:
            at = view.map(contact.at)
            if contact.ring(view) >= _CENTRE_FROM:
                painter.setPen(QPen(RIM, 1.0))
                painter.setBrush(WHITE)
                painter.drawEllipse(at, 2.0, 2.0)
                painter.setBrush(Qt.BrushStyle.NoBrush)
        callouts = self._callouts(marks, picture, view, room, captions)
        leaders = [callout.leader for callout, _ in callouts if callout.leader is not None]
        if leaders:
            behind = QPainterPath()
            behind.addRect(room)
            for box, _ in captions.names:
                behind.addRect(box)  # odd-even: leader lines pass behind the names
            painter.save()
            painter.setClipPath(behind)
            for leader in leaders:
                for pen in (QPen(faint(RIM, 110), 2.8), QPen(QColor(self.theme.text), 1.0)):
                    painter.setPen(pen)
                    painter.drawLine(*leader)
            painter.restore()
        for callout, mark in callouts:
            paint_chip(painter, callout.box, mark.text, self._figure, self.theme.text, self.theme.panel)

    def _paint_captions(
        self,
        painter: QPainter,
        marks: MapMarks,
        picture: MapCanvas,
        view: QTransform,
        room: QRectF,
        captions: Captions,
    ) -> None:
        """Paint the hover mark, and captions along the edges."""
        hover = None if marks.hover is None else view.map(marks.hover)
        # Not where the skin is touched: the cross would hide the touch.
        if hover is not None and not any(
            _near(view.map(mark.at), hover, mark.ring(view) + 10.0) for mark in marks.contacts
        ):
            draw_cross(painter, hover, 4, 10, self._halo_and_accent())
        if picture.shapes.patches and not picture.shapes.numbers:
            painter.setFont(self._figure)
            painter.setPen(QColor(self.theme.quiet))
            wrapped = int(Qt.TextFlag.TextWordWrap | Qt.AlignmentFlag.AlignCenter)
            painter.drawText(room.adjusted(EDGE, EDGE, -EDGE, -EDGE), wrapped, _ALL_HIDDEN)
        self._paint_scale_bar(painter, *captions.scale)
        self._paint_legends(painter, marks, captions.legends)
        counts = more_contacts(len(marks.contacts))
        paint_state(painter, room, self.theme, marks.state, counts)

    def framing(self, marks: MapMarks, shapes: MapShapes, room: QRectF, *, still: bool = False) -> MapCamera | None:
        """Return the camera with the whole map in view, which the legend of the background does not hide.

        None if no patch is shown. The map does not move for legends that come and go while the session runs; in a
        ``still`` picture no legend hides it.
        """
        legends = self._all_legends(marks, room) if still or marks.legend is not None else []
        return self._legends.framing([legend.size(self._caption) for legend in legends], shapes, room)

    def _all_legends(self, marks: MapMarks, room: QRectF) -> list[Legend]:
        entries = task_legend_entries(marks.task)
        task = task_legend(entries) if entries else None
        faults = fault_marks_legend(marks.faults) if marks.faults else None
        legends = [legend for legend in (marks.legend, task, faults, *marks.layers) if legend is not None]
        return [legend.fitted(_WIDEST_LEGEND * room.width(), self._caption) for legend in legends]

    def _paint_legends(self, painter: QPainter, marks: MapMarks, legends: Sequence[tuple[Legend, QRectF]]) -> None:
        entries = task_legend_entries(marks.task)
        for number, (legend, box) in enumerate(legends):
            draw = partial(legend.paint, box=box, font=self._caption, theme=self.theme)
            if entries and number == int(marks.legend is not None):
                self._legend_cache.paint(painter, (entries, self.theme), box, draw)
            else:
                draw(painter)

    def _halo_and_accent(self) -> tuple[QPen, QPen]:
        """Pens of the accent over a wider dark line: without it, the accent has no contrast with light skin."""
        return make_pen(faint(RIM, 130), 4.6), make_pen(self.theme.accent, 2.6)

    def _scale(self, pixels_per_metre: float, room: QRectF) -> tuple[QRectF, float, str]:
        """Return the box of the scale bar, the length of its line [px], and its text."""
        longest = min(_LONGEST_SCALE, 0.2 * room.width())
        millimetres = nice_floor(longest / pixels_per_metre * 1e3)
        length = millimetres * 1e-3 * pixels_per_metre
        text = f"{millimetres:g}{THIN}mm"
        metrics = QFontMetricsF(self._caption)
        height = metrics.height() + 4
        box = QRectF(EDGE, room.bottom() - _LOW_EDGE - height, length + metrics.horizontalAdvance(text) + 20, height)
        return box, length, text

    def _paint_scale_bar(self, painter: QPainter, box: QRectF, length: float, text: str) -> None:
        paint_box(painter, box, self.theme.panel)
        left = box.left() + 6
        bottom = box.bottom() - 6
        painter.setPen(make_pen(self.theme.quiet, 1.5, Qt.PenCapStyle.FlatCap))
        painter.drawPolyline([QPointF(left + x, bottom + y) for x, y in ((0, -5), (0, 0), (length, 0), (length, -5))])
        painter.setFont(self._caption)
        painter.drawText(QPointF(left + length + 8, bottom), text)


def _outlines(picture: MapCanvas, view: QTransform) -> dict[int, QPolygonF]:
    """Return the outlines of the patches that are shown [px], by number."""
    return {
        number: view.map(polygon(patch.outline)) for number, patch in enumerate(picture.shapes.patches) if patch.shown
    }


def _small_patches(captions: Sequence[QSizeF], skin: Mapping[int, QPolygonF]) -> list[QRectF]:
    """Return the boxes of the patches of which a caption would hide much."""
    largest = max((size.width() * size.height() for size in captions), default=0.0)
    boxes = [outline.boundingRect() for outline in skin.values()]
    return [box for box in boxes if box.width() * box.height() < _SMALL_PATCH * largest]


def _near(one: QPointF, other: QPointF, distance: float = 20.0) -> bool:
    away = one - other
    return bool(np.hypot(away.x(), away.y()) <= distance)
