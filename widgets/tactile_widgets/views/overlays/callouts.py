"""Placement of captions next to marked points of a picture, with a leader line if they are far away.

Geometry in pixels, the same for both views.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from operator import itemgetter

from PySide6.QtCore import QLineF, QPointF, QRectF, QSizeF
from PySide6.QtGui import QPolygonF

from tactile_maps.core.errors import counted

_GAPS = (4.0, 24.0, 48.0, 84.0, 130.0)
"""Candidate distances between the rim of a spot and its caption [px]."""
LABELLED = 5
"""Number of contacts with a caption, the strongest ones; ``more_contacts`` counts the others."""
_LED_FROM = 12.0
"""Distance from which a caption has a leader line [px]."""
_SIDES = ((1, -1), (-1, -1), (1, 1), (-1, 1), (1, 0), (-1, 0), (0, -1), (0, 1))
_DIAGONAL = 0.7071


def more_contacts(count: int) -> tuple[str, ...]:
    """Return the text about the contacts without a caption among ``count`` contacts; empty if there are none."""
    return (f"+{counted(count - LABELLED, 'more contact')}",) if count > LABELLED else ()


@dataclass(frozen=True)
class Spot:
    """Marked point with a caption, which no caption may cover.

    Attributes:
        at: The point.
        radius: Radius around the point that is kept free.
        size: Size of its caption.
        preferred: Preferred box of the caption; None for upper right.
        foreign: Outlines, such as those of other patches, that its caption hides only if there is no other room.
    """

    at: QPointF
    radius: float
    size: QSizeF
    preferred: QRectF | None = None
    foreign: tuple[QPolygonF, ...] = ()

    @property
    def box(self) -> QRectF:
        """Square around the point that is kept free."""
        return QRectF(self.at.x() - self.radius, self.at.y() - self.radius, 2 * self.radius, 2 * self.radius)


Leader = tuple[QPointF, QPointF]
"""Ends of a leader line."""


@dataclass(frozen=True)
class Callout:
    """Place of a caption.

    Attributes:
        box: Box of the caption.
        leader: Line from the rim of its spot to the caption; None if the caption is next to it.
    """

    box: QRectF
    leader: Leader | None = None


def place_callouts(
    spots: Sequence[Spot], room: QRectF, others: Sequence[QRectF] = (), kept: Sequence[QRectF] = ()
) -> list[Callout]:
    """Place the caption of each spot within ``room``, over no other caption, and if possible over no spot.

    If possible, leader lines cross no caption, no other spot and no other line, and captions are not over what
    is foreign to their spot.

    Args:
        spots: Spots, the most important first.
        room: Where captions may be.
        others: Boxes of captions that do not belong to spots, such as legends.
        kept: Boxes that are kept free like spots if possible.

    Cost: 0.1 ms for five spots.
    """
    kept = [*(spot.box for spot in spots), *kept]
    placed: list[Callout] = []
    for spot in spots:
        taken = [*others, *(one.box for one in placed)]
        crossed = [*taken, *(other.box for other in spots if other is not spot)]
        lines = [one.leader for one in placed if one.leader is not None]
        found = list[tuple[tuple[bool, bool, bool], Callout]]()
        for box in _candidates(spot):
            if not room.contains(box) or any(map(box.intersects, taken)):
                continue
            callout = _led(spot, box)
            over = any(map(box.intersects, kept))
            led = callout.leader is not None and any(map(partial(_meets, callout.leader), crossed))
            led = led or any(_meets(line, box) or _cross(line, callout.leader) for line in lines)
            found.append(((over, any(hides(box, one) for one in spot.foreign), led), callout))
            if not any(found[-1][0]):
                break
        best = min(found, key=itemgetter(0), default=None)
        placed.append(_led(spot, _into(next(_candidates(spot)), room)) if best is None else best[1])
    return placed


def hides(box: QRectF, outline: QPolygonF) -> bool:
    """Whether a caption hides more of an outlined area than its own edge does."""
    inner = box.adjusted(1.0, 1.0, -1.0, -1.0)
    return outline.boundingRect().intersects(inner) and outline.intersects(QPolygonF(inner))


def _led(spot: Spot, box: QRectF) -> Callout:
    """Return a caption at ``box`` with its leader line, if it needs one."""
    end = QPointF(
        min(max(spot.at.x(), box.left()), box.right()),
        min(max(spot.at.y(), box.top()), box.bottom()),
    )
    away = end - spot.at
    distance = (away.x() ** 2 + away.y() ** 2) ** 0.5
    if distance - spot.radius < _LED_FROM or box == spot.preferred:
        return Callout(box)
    return Callout(box, (spot.at + away * (spot.radius / distance), end))


def _cross(line: Leader, other: Leader | None) -> bool:
    """Whether two lines cross."""
    bounded = QLineF.IntersectionType.BoundedIntersection
    return other is not None and QLineF(*line).intersects(QLineF(*other))[0] == bounded


def _meets(line: Leader, box: QRectF) -> bool:
    """Whether a line from one point to another meets a box."""
    first, last = 0.0, 1.0  # shares of the line between which it is in the box
    for start, end, low, high in (
        (line[0].x(), line[1].x(), box.left(), box.right()),
        (line[0].y(), line[1].y(), box.top(), box.bottom()),
    ):
        if start == end:
            if not low <= start <= high:
                return False
            continue
        one, other = (low - start) / (end - start), (high - start) / (end - start)
        first = max(first, min(one, other))
        last = min(last, max(one, other))
    return first <= last


def _candidates(spot: Spot) -> Iterator[QRectF]:
    if spot.preferred is not None:
        yield spot.preferred
    width = spot.size.width()
    height = spot.size.height()
    for gap, (dx, dy) in product(_GAPS, _SIDES):
        # On a diagonal, the corner of the caption is as far from the rim as its edge is in other directions.
        away = (spot.radius + gap) * (_DIAGONAL if dx and dy else 1.0)
        left = spot.at.x() + dx * away - (width if dx < 0 else width / 2 if dx == 0 else 0)
        top = spot.at.y() + dy * away - (height if dy < 0 else height / 2 if dy == 0 else 0)
        yield QRectF(left, top, width, height)


def _into(box: QRectF, room: QRectF) -> QRectF:
    left = max(min(box.left(), room.right() - box.width()), room.left())
    top = max(min(box.top(), room.bottom() - box.height()), room.top())
    return QRectF(left, top, box.width(), box.height())
