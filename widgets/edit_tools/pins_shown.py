"""The pins of a document: all of them by their place of the body, their numbers, and how they look on the map."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from PySide6.QtCore import QPointF
from PySide6.QtGui import QColor, QPainter, QPen

from app.arrays import FloatArray
from app.editing.document import MapDocument
from app.editing.pins import add_pin, pin_places
from app.geometry.surface_point import SurfacePoint
from app.maps.pin import Pin
from widgets.body_marks import Role
from widgets.colours import Theme
from widgets.edit_tool import ToPixels
from widgets.edit_tools.drawing import RIM, draw_pin, draw_words

_LAG_PX = 3.0


def pinned(document: MapDocument, *, seen: bool = False) -> dict[SurfacePoint, Pin]:
    """All pins by their place of the body; ``seen``: of the patches that the map view shows."""
    return {pin.at: pin for patch in document.patches if patch.visible or not seen for pin in patch.pins}


def numbers(document: MapDocument, pins: frozenset[SurfacePoint]) -> dict[int, list[int]]:
    """Pins by their places, as numbers by patch."""
    found = {
        number: [k for k, pin in enumerate(patch.pins) if pin.at in pins]
        for number, patch in enumerate(document.patches)
    }
    return {number: own for number, own in found.items() if own}


def with_pins(document: MapDocument, at: Iterable[SurfacePoint]) -> MapDocument:
    for place in at:
        document = add_pin(document, place)
    return document


def sound(at: SurfacePoint) -> SurfacePoint:
    """The place with weights that are exactly what they should be, as the document keeps them."""
    weights = np.clip(at.weights, 0, None)
    a, b, c = (weights / weights.sum()).tolist()
    return SurfacePoint(int(at.patch), int(at.face), (a, b, c))


def draw_pins(
    painter: QPainter,
    document: MapDocument,
    to_pixels: ToPixels,
    theme: Theme,
    *,
    chosen: frozenset[SurfacePoint] = frozenset(),
    hovered: SurfacePoint | None = None,
) -> None:
    """Diamonds where the pins are, and a line and words where one is not where it is wanted."""
    for number, patch in enumerate(document.patches):
        if patch.pins and patch.visible:
            places, wanted = np.array([document.map.to_map(p.at) for p in patch.pins]), pin_places(document, number)
            lags = np.linalg.norm(wanted - places, axis=1)
            for pin, at, goal, lag in zip(patch.pins, to_pixels(places), to_pixels(wanted), lags, strict=True):
                _draw_lag(painter, at, goal, float(lag), theme)
                role = Role.HELD if pin.at in chosen else Role.PIN
                draw_pin(painter, QPointF(*at), QColor(role.ink(theme)), large=pin.at == hovered)


def _draw_lag(painter: QPainter, at: FloatArray, goal: FloatArray, lag: float, theme: Theme) -> None:
    if np.linalg.norm(goal - at) > _LAG_PX:
        for ink, width in ((RIM, 3.0), (QColor(theme.accent), 1.2)):
            painter.setPen(QPen(ink, width))
            painter.drawLine(QPointF(*at), QPointF(*goal))
            painter.drawEllipse(QPointF(*goal), 2.5, 2.5)
        draw_words(painter, f"{1e3 * lag:.1f}\u2009mm off", theme, at=QPointF(*goal))
