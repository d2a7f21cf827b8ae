"""A figure as a file: SVG, PDF or PNG of a stated size, drawn by a painter in units of 1/96 inch."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from PySide6.QtCore import QBuffer, QByteArray, QMarginsF, QRect, QRectF, QSize, QSizeF
from PySide6.QtGui import QColor, QImage, QPageSize, QPainter, QPdfWriter
from PySide6.QtSvg import QSvgGenerator, QSvgRenderer

from tactile_maps.core.errors import DisplayError
from tactile_maps.core.files import write_atomically

MM_PER_INCH = 25.4
UNITS_PER_INCH = 96
"""Units of drawing, the pixels of a standard screen, so that text has the same size on paper."""
_SMALLEST_MM = 20.0
_LARGEST_MM = 1000.0
_LEAST_DPI = 50
_MOST_DPI = 2400
_MOST_PIXELS = 200e6


class FigurePart(Enum):
    """Part of the window that a figure shows."""

    VIEWS = "views"
    ROBOT = "robot"
    MAP = "map"
    PLOTS = "plots"


class FigureColours(Enum):
    """Colours of a figure."""

    PAPER = "paper"
    """The light theme on white."""
    LIGHT = "light"
    DARK = "dark"


@dataclass(frozen=True)
class FigureSpec:
    """Size, resolution and colours of a figure.

    Attributes:
        width: Width [mm].
        height: Height [mm].
        dpi: Pixels per inch of a PNG, and of pictures within SVG and PDF: the robot, and touch on the map.
        colours: Colours of the figure.
        units_per_inch: Units of drawing per inch; more of them make texts, marks and lines smaller.

    Raises:
        DisplayError: A size or resolution is out of range.
    """

    width: float = 170.0
    height: float = 85.0
    dpi: int = 300
    colours: FigureColours = FigureColours.PAPER
    units_per_inch: int = UNITS_PER_INCH

    def __post_init__(self) -> None:
        for name, side in (("width", self.width), ("height", self.height)):
            if not _SMALLEST_MM <= side <= _LARGEST_MM:
                remedy = f"Choose {_SMALLEST_MM:g} to {_LARGEST_MM:g} mm"
                raise DisplayError(f"a figure cannot have this {name}", value=f"{side:g} mm", remedy=remedy)
        if not _LEAST_DPI <= self.dpi <= _MOST_DPI:
            raise DisplayError(
                "a figure cannot have this resolution",
                value=f"{self.dpi} dpi",
                remedy=f"Choose {_LEAST_DPI} to {_MOST_DPI}",
            )
        width, height = self.pixels
        if width * height > _MOST_PIXELS:
            raise DisplayError(
                "this figure would have too many pixels",
                value=f"{width} x {height}",
                remedy="Choose a lower resolution",
            )

    @property
    def pixels(self) -> tuple[int, int]:
        """Width and height of a PNG [px]."""
        return round(self.width / MM_PER_INCH * self.dpi), round(self.height / MM_PER_INCH * self.dpi)

    @property
    def units(self) -> tuple[int, int]:
        """Width and height in units of drawing."""
        unit = MM_PER_INCH / self.units_per_inch
        return round(self.width / unit), round(self.height / unit)

    @property
    def quality(self) -> float:
        """Pixels per unit of pictures."""
        return self.dpi / self.units_per_inch


FIGURE_KINDS = {".svg": "SVG, vector (*.svg)", ".pdf": "PDF, vector (*.pdf)", ".png": "PNG, pixels (*.png)"}


_EMPTY_PATH = re.compile(rb'<path [^<>]*\bd=""[^<>]*/>')
"""Path without points, such as that of a curve with one sample: it draws nothing, and programs warn about it."""


def write_figure(path: str | Path, spec: FigureSpec, background: str, paint: Callable[[QPainter], None]) -> None:
    """Write a figure that ``paint`` draws into ``spec.units``; an existing file is replaced.

    Args:
        path: File, whose extension selects the format: ``.svg``, ``.pdf`` or ``.png``.
        spec: Size and resolution.
        background: Background colour, as hex.
        paint: Draws in units; vectors remain vectors in SVG and PDF.

    Raises:
        DisplayError: Another extension, or the file cannot be written.
    """
    kind = check_figure_kind(path)
    writers = {".svg": _svg_file, ".pdf": _pdf, ".png": _png}
    write_atomically(Path(path), writers[kind](spec, QColor(background), paint), error=DisplayError)


def check_figure_kind(path: str | Path) -> str:
    """Return the extension of a figure's file.

    Raises:
        DisplayError: The format cannot be written.
    """
    kind = Path(path).suffix.lower()
    if kind not in FIGURE_KINDS:
        raise DisplayError(
            "figures of this kind cannot be written",
            file=path,
            value=kind or "no extension",
            remedy="Choose .svg, .pdf or .png",
        )
    return kind


def _draw(painter: QPainter, spec: FigureSpec, background: QColor, paint: Callable[[QPainter], None]) -> None:
    painter.setRenderHints(QPainter.RenderHint.Antialiasing | QPainter.RenderHint.SmoothPixmapTransform)
    painter.fillRect(QRect(0, 0, *spec.units), background)
    paint(painter)
    painter.end()


def _svg(spec: FigureSpec, background: QColor, paint: Callable[[QPainter], None]) -> bytes:
    written = QBuffer()
    written.open(QBuffer.OpenModeFlag.WriteOnly)
    page = QSvgGenerator()
    page.setOutputDevice(written)
    page.setResolution(spec.units_per_inch)
    page.setSize(QSize(*spec.units))
    page.setViewBox(QRect(0, 0, *spec.units))
    page.setTitle("Tactile Maps")
    _draw(QPainter(page), spec, background, paint)
    # Qt rounds the size to its units.
    size = f'width="{spec.width:g}mm" height="{spec.height:g}mm"'.encode()
    drawn = re.sub(rb'width="[\d.]+mm" height="[\d.]+mm"', size, bytes(written.data().data()), count=1)
    return _EMPTY_PATH.sub(b"", drawn)


def _svg_file(spec: FigureSpec, background: QColor, paint: Callable[[QPainter], None]) -> bytes:
    """Return the SVG with pens in proportion to texts; programs draw unscaled pens in pixels of 1/96 inch."""
    return _with_wider_pens(_svg(spec, background, paint), UNITS_PER_INCH / spec.units_per_inch)


def _pdf(spec: FigureSpec, background: QColor, paint: Callable[[QPainter], None]) -> bytes:
    written = QBuffer()
    written.open(QBuffer.OpenModeFlag.WriteOnly)
    page = QPdfWriter(written)
    page.setCreator("Tactile Maps")
    size = QPageSize(
        QSizeF(spec.width, spec.height), QPageSize.Unit.Millimeter, "", QPageSize.SizeMatchPolicy.ExactMatch
    )
    page.setPageSize(size)
    page.setPageMargins(QMarginsF(0, 0, 0, 0))
    page.setResolution(spec.units_per_inch)
    _draw(QPainter(page), spec, background, paint)
    return bytes(written.data().data())


def _png(spec: FigureSpec, background: QColor, paint: Callable[[QPainter], None]) -> bytes:
    """Render the SVG, whose pens are scaled to the width on paper; unscaled pens would be hairlines at 300 dpi."""
    image = QImage(*spec.pixels, QImage.Format.Format_RGB32)
    image.fill(background)
    drawn = _with_wider_pens(_svg(spec, background, paint), spec.quality)
    vectors = QSvgRenderer(QByteArray(drawn))
    painter = QPainter(image)
    painter.setRenderHints(QPainter.RenderHint.Antialiasing | QPainter.RenderHint.SmoothPixmapTransform)
    vectors.render(painter, QRectF(image.rect()))
    painter.end()
    per_metre = round(spec.dpi / MM_PER_INCH * 1000)
    image.setDotsPerMeterX(per_metre)
    image.setDotsPerMeterY(per_metre)
    written = QBuffer()
    written.open(QBuffer.OpenModeFlag.WriteOnly)
    image.save(written, "PNG")  # type: ignore[call-overload]  # Qt's stubs require bytes
    return bytes(written.data().data())


def _with_wider_pens(drawn: bytes, factor: float) -> bytes:
    """Return the SVG with the pens and dashes that do not scale with it scaled by ``factor``."""

    def scaled(found: re.Match[bytes]) -> bytes:
        return (
            found[1] + b'="' + re.sub(rb"[\d.]+", lambda number: b"%.4g" % (factor * float(number[0])), found[2]) + b'"'
        )

    groups = drawn.split(b"<g ")  # one group for each pen
    for number, group in enumerate(groups):
        if b"non-scaling-stroke" in group:
            tag, rest = group.split(b">", 1)
            wider = re.sub(rb'(stroke-width|stroke-dasharray|stroke-dashoffset)="([^"]*)"', scaled, tag)
            groups[number] = wider + b">" + rest
    return b"<g ".join(groups)
