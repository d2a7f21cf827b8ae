"""Colours and legend of the friction in use, shown as dots on pressed taxels in both views."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QColor, QPainter

from tactile_maps.contacts.detection.shear_estimation import friction_in_use
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.reading_units import THIN
from tactile_maps.session.frame import Frame
from tactile_widgets.common.colours import Theme
from tactile_widgets.views.overlays.legend import MarkLegend
from tactile_widgets.views.overlays.painting import RIM, WHITE, make_pen

# Greens, monotone in lightness: neither touch nor stretch has them.
_STEPS = np.array([[232, 240, 234], [163, 214, 187], [88, 170, 138], [28, 114, 92], [6, 54, 46]], dtype=np.float64)
_KEY_PX = 10.0
_SHARES = (0.0, 0.5, 1.0)


def friction_rgb(used: FloatArray) -> NDArray[np.uint8]:
    """Return the colours (k, 3) of friction in use (k,); above 1 the colour is that of 1."""
    place = np.clip(used, 0.0, 1.0) * (len(_STEPS) - 1)
    channels = [np.interp(place, np.arange(len(_STEPS)), channel) for channel in _STEPS.T]
    return np.rint(np.stack(channels, axis=1)).astype(np.uint8)


def frame_friction(frame: Frame | None) -> FloatArray | None:
    """Return the friction in use (taxels,) of a frame, NaN off the contacts; None without shear."""
    if frame is None or frame.shear is None:
        return None
    return friction_in_use(frame.regions, frame.pressures, frame.shear)


def draw_slip(painter: QPainter, middle: QPointF, size: float) -> None:
    """Draw the mark of a taxel that slips: a white ring with a dark rim, around a dot ``size`` wide [px]."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for ink, width in ((RIM, 3.4), (WHITE, 1.8)):
        painter.setPen(make_pen(ink, width))
        painter.drawEllipse(middle, size / 2, size / 2)


def friction_legend() -> MarkLegend:
    """Make the legend: colours of the friction in use, and the mark of taxels that slip."""
    shares = [(partial(_draw_dot, share), f"{100 * share:.0f}{THIN}% of the friction") for share in _SHARES]
    return MarkLegend((*shares, (_draw_slip_key, "slips")), _KEY_PX + 4)


def _draw_dot(share: float, painter: QPainter, middle: QPointF, theme: Theme) -> None:
    painter.setPen(make_pen(QColor(theme.quiet), 1.0))
    painter.setBrush(QColor(*friction_rgb(np.array([share]))[0].tolist()))
    painter.drawEllipse(middle, _KEY_PX / 2, _KEY_PX / 2)


def _draw_slip_key(painter: QPainter, middle: QPointF, theme: Theme) -> None:
    _draw_dot(1.0, painter, middle, theme)
    draw_slip(painter, middle, _KEY_PX)
