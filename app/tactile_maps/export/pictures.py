"""Pictures of fixed size with the tactile image, its colour bar and contacts, drawn without a display."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.pressure_colours import COLOURS, colour_image
from tactile_maps.session.frame import Frame

WIDTH = 640
"""Length of the longer side of the tactile image [px]."""
_MARGIN = 16
_TOP = 40
_BAR = 18
_BAR_SPACE = 96
_INK = (40, 40, 40)
_OUTLINE = (90, 90, 90)
_CONTACT = (31, 119, 180)
_PAPER = (255, 255, 255)
_TURN = np.linspace(0, 2 * np.pi, 49)


class FilmFrame:
    """Draws one picture after another. ``use_map`` follows edits.

    Args:
        map_: The map, which defines the size.
        full_scale: Pressure of the darkest colour [kPa].
        begins: Session time that is shown as 0 [s].

    Attributes:
        size: Width and height [px], both even, as films require.
    """

    def __init__(self, map_: TactileMap, full_scale: float, *, begins: float = 0.0) -> None:
        self._scale = full_scale
        self._begins = begins
        extent = np.subtract(*map_.bounds[::-1])
        self._room = np.maximum(np.ceil(WIDTH * extent / extent.max()), 64).astype(int)
        width, height = self._room + (2 * _MARGIN + _BAR_SPACE, _TOP + _MARGIN)
        self.size = (int(width + width % 2), int(height + height % 2))
        self._font = ImageFont.load_default(15)
        self.use_map(map_)

    def use_map(self, map_: TactileMap) -> None:
        """Use ``map_`` from now on, scaled to fit the picture."""
        extent = np.subtract(*map_.bounds[::-1])
        self._image = TactileImage(map_, resolution=float((extent / self._room).max()))
        self._map = map_
        self._background = self._draw_background()

    def picture(self, frame: Frame) -> NDArray[np.uint8]:
        """Return the picture (height, width, 3) of a frame. Cost: 4 ms."""
        shown = self._background.copy()
        colours = colour_image(self._image, frame.pressures, self._scale)
        shown.paste(Image.fromarray(colours), (_MARGIN, _TOP))
        pen = ImageDraw.Draw(shown)
        self._draw_outlines(pen)
        for region in frame.regions:
            self._draw_contact(pen, region, frame.units)
        force = frame.units.force_words(sum(region.force for region in frame.regions), 2, space=" ")
        total = "not calibrated" if force is None else force
        words = f"{frame.time - self._begins:.2f} s    contacts: {len(frame.regions)}, {total}"
        pen.text((_MARGIN, 10), words, _INK, self._font)
        pen.text((self.size[0] - _BAR_SPACE, 10), frame.units.unit, _INK, self._font)
        return np.asarray(shown)

    def _draw_background(self) -> Image.Image:
        background = Image.new("RGB", self.size, _PAPER)
        pen = ImageDraw.Draw(background)
        left = self.size[0] - _BAR_SPACE
        bottom = self.size[1] - _MARGIN
        height = bottom - _TOP
        bar = COLOURS[np.linspace(255, 0, height).astype(int)]
        background.paste(Image.fromarray(np.repeat(bar[:, None], _BAR, axis=1)), (left, _TOP))
        for share in (0.0, 0.25, 0.5, 0.75, 1.0):
            y = bottom - 1 - share * (height - 1)
            pen.line([(left + _BAR, y), (left + _BAR + 4, y)], _INK)
            pen.text((left + _BAR + 8, y), f"{share * self._scale:g}", _INK, self._font, anchor="lm")
        return background

    def _draw_outlines(self, pen: ImageDraw.ImageDraw) -> None:
        for outline in self._map.outlines:
            pen.line(self._pixels(np.concatenate([outline, outline[:1]])), _OUTLINE)

    def _draw_contact(self, pen: ImageDraw.ImageDraw, region: ContactRegion, units: ReadingUnits) -> None:
        ring = np.outer(np.cos(_TURN), region.map_axes[0]) + np.outer(np.sin(_TURN), region.map_axes[1])
        pen.line(self._pixels(region.map_point + ring), _CONTACT, width=2)
        ((x, y),) = self._pixels(region.map_point[None])
        pen.line([(x - 5, y), (x + 5, y)], _CONTACT)
        pen.line([(x, y - 5), (x, y + 5)], _CONTACT)
        words = units.contact_words(region.force, region.peak, 2, space=" ")
        pen.text((x + 8, y - 8), words, _CONTACT, self._font, anchor="ls")

    def _pixels(self, points: FloatArray) -> list[tuple[float, float]]:
        """Return the positions in the picture of map points (k, 2) [m]."""
        (left, _), (_, top) = self._image.extent
        x = _MARGIN + (points[:, 0] - left) / self._image.resolution
        y = _TOP + (top - points[:, 1]) / self._image.resolution
        return list(zip(x.tolist(), y.tolist(), strict=True))
