"""Icons of the file dialog and the docks of Qt in the text colour; those of Qt are dark on a dark background.

A style sheet loads icons from files only, so they are drawn into a folder that is removed with the process.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

from PySide6.QtCore import QPointF, QRectF, Qt, QTemporaryDir
from PySide6.QtGui import QColor, QPainter, QPen, QPixmap, QPolygonF

from tactile_widgets.common.colours import Theme

_SIZE = 16
_SCALES = {"": 1, "@2x": 2}
"""Scale of the icons by the suffix that Qt uses for high-resolution displays."""


def dialog_icons(theme: Theme) -> dict[str, str]:
    """Return the paths of the icons of the file dialog, by their names in style sheets; drawn once per theme."""
    return _drawn_icons(theme, _SHAPES)


def dock_icons(theme: Theme) -> dict[str, str]:
    """Return the paths of the icons in the title of a dock, by their names in style sheets."""
    return _drawn_icons(theme, _DOCK_SHAPES)


def check_icons(theme: Theme) -> dict[str, str]:
    """Return the paths of the icons of check boxes, by the state in style sheets."""
    return _drawn_icons(theme, _CHECK_SHAPES)


def _drawn_icons(theme: Theme, shapes: dict[str, Callable[[QPainter], None]]) -> dict[str, str]:
    folder = Path(_folder().path())
    paths = {}
    for name, shape in shapes.items():
        for ending, scale in _SCALES.items():
            path = folder / f"{theme.name}-{name}{ending}.png"
            if not path.exists():
                _drawn(shape, theme, scale).save(str(path))
        paths[name] = (folder / f"{theme.name}-{name}.png").as_posix()
    return paths


@cache
def _folder() -> QTemporaryDir:
    return QTemporaryDir()


def _drawn(shape: Callable[[QPainter], None], theme: Theme, scale: int) -> QPixmap:
    pixmap = QPixmap(_SIZE * scale, _SIZE * scale)
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.scale(scale, scale)
    painter.setPen(QPen(QColor(theme.text), 1.6, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
    shape(painter)
    painter.end()
    return pixmap


def _lines(painter: QPainter, *points: tuple[float, float]) -> None:
    painter.drawPolyline(QPolygonF([QPointF(x, y) for x, y in points]))


def _back(painter: QPainter) -> None:
    _lines(painter, (13, 8), (3, 8))
    _lines(painter, (7, 4), (3, 8), (7, 12))


def _forward(painter: QPainter) -> None:
    _lines(painter, (3, 8), (13, 8))
    _lines(painter, (9, 4), (13, 8), (9, 12))


def _up(painter: QPainter) -> None:
    _lines(painter, (8, 13), (8, 3))
    _lines(painter, (4, 7), (8, 3), (12, 7))


def _new_folder(painter: QPainter) -> None:
    _lines(painter, (14, 9), (14, 4.5), (8, 4.5), (6.5, 3), (2, 3), (2, 13), (9, 13))
    _lines(painter, (12.5, 10.5), (12.5, 14.5))
    _lines(painter, (10.5, 12.5), (14.5, 12.5))


def _box(painter: QPainter) -> None:
    painter.setPen(QPen(painter.pen().color(), 1.0))
    painter.setOpacity(0.6)
    painter.drawRoundedRect(QRectF(2.5, 2.5, 11, 11), 2.5, 2.5)
    painter.setOpacity(1.0)


def _checked_box(painter: QPainter) -> None:
    pen = QPen(painter.pen())
    _box(painter)
    painter.setPen(pen)
    _lines(painter, (5, 8.2), (7.2, 10.6), (11, 5.4))


def _list(painter: QPainter) -> None:
    for x in (2.5, 9.5):
        for y in (3.0, 9.5):
            painter.drawRect(QRectF(x, y, 4.0, 3.5))


def _details(painter: QPainter) -> None:
    for y in (4, 8, 12):
        _lines(painter, (2.5, y), (3.0, y))
        _lines(painter, (6.5, y), (13.5, y))


def _close(painter: QPainter) -> None:
    _lines(painter, (4, 4), (12, 12))
    _lines(painter, (12, 4), (4, 12))


def _float(painter: QPainter) -> None:
    painter.drawRect(QRectF(3.0, 6.0, 7.0, 7.0))
    _lines(painter, (6.5, 3), (13, 3), (13, 9.5))


_DOCK_SHAPES: dict[str, Callable[[QPainter], None]] = {
    "titlebar-close-icon": _close,
    "titlebar-normal-icon": _float,
}
_SHAPES: dict[str, Callable[[QPainter], None]] = {
    "backward-icon": _back,
    "forward-icon": _forward,
    "filedialog-parent-directory-icon": _up,
    "filedialog-new-directory-icon": _new_folder,
    "filedialog-listview-icon": _list,
    "filedialog-detailedview-icon": _details,
}
_CHECK_SHAPES: dict[str, Callable[[QPainter], None]] = {"unchecked": _box, "checked": _checked_box}
