"""Icons of the toolbar: SVG files in the folder ``icons``, drawn in a colour of the theme."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPixmap
from PySide6.QtSvg import QSvgRenderer

_SIZE = 16
_FOLDER = Path(__file__).with_name("icons")


def icon(name: str, colour: str, *, disabled: str) -> QIcon:
    """Return an icon.

    Args:
        name: Name of a file in ``icons``; for any other name the icon is its first letter.
        colour: Colour of the icon.
        disabled: Colour while the action is disabled.
    """
    result = QIcon()
    for scale in (1, 2):
        result.addPixmap(_pixmap(name, colour, scale), QIcon.Mode.Normal)
        result.addPixmap(_pixmap(name, disabled, scale), QIcon.Mode.Disabled)
    return result


def _pixmap(name: str, colour: str, scale: int) -> QPixmap:
    pixmap = QPixmap(_SIZE * scale, _SIZE * scale)
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    painter.scale(scale, scale)
    area = QRectF(0, 0, _SIZE, _SIZE)
    file = _FOLDER / f"{name}.svg"
    if file.is_file():
        drawing = file.read_text(encoding="utf8").replace("currentColor", colour)
        QSvgRenderer(drawing.encode()).render(painter, area)
    else:
        painter.setPen(QColor(colour))
        painter.drawText(area, Qt.AlignmentFlag.AlignCenter, name[:1].upper())
    painter.end()
    pixmap.setDevicePixelRatio(scale)
    return pixmap
