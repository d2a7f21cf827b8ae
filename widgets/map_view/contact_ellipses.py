"""How contacts lie on the map that is shown: the ellipse of a region, and the circle in which its centre lies."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QTransform

from app.contacts.regions import ContactRegion
from app.core.arrays import FloatArray
from app.maps.tactile_map import TactileMap
from widgets.overlays.painting import polygon

SMALLEST_ELLIPSE_PX, SMALLEST_ERROR_PX = 7.0, 4.0
"""Half-axes below are hidden by the mark of the centre."""
_ANGLES = np.linspace(0, 2 * np.pi, 49)[:, None]
_INK = QColor(29, 33, 38, 150)


def ellipses_on_map(region: ContactRegion, map_: TactileMap) -> tuple[FloatArray, FloatArray]:
    """Half-axes (2, 2) each [m] of a region's ellipse and of its centre's error circle, as a map distorts them there.

    Asked of the map that is shown: the frame's own axes are those of the map that the session had then.

    Cost: 30 µs.
    """
    chart, surface = map_.charts[region.at.patch], map_.skin.patches[region.at.patch].surface
    body = surface.vertices[surface.faces[region.at.face]]
    plane = map_.uv[region.at.patch][chart.faces[region.at.face]]
    # Columns: what a step along the body is on the map; nothing where the triangle has no area.
    jacobian = (plane[1:] - plane[0]).T @ np.linalg.pinv(body[1:] - body[0], rcond=1e-6).T
    across = np.linalg.svd(body[1:] - body[0])[2][:2]
    return region.link_axes @ jacobian.T, region.place_error * across @ jacobian.T


def paint_ellipse(
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
