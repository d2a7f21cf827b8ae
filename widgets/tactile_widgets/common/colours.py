"""Colours of the two themes, and the scales of pressure, stretch and differences."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.arrays import FloatArray


@dataclass(frozen=True)
class Theme:
    """Colours of a theme, in hex: neutral greys and accents.

    Attributes:
        name: ``dark`` or ``light``.
        window: Background of the views.
        panel: Background of panels.
        text: Text.
        quiet: Less important text; contrast of at least 4.5:1 on the panel.
        line: Hairlines.
        accent: Selected or dragged items.
        link: Text of links: the accent, dark enough to be read on the panel.
        intent: Goals of the controller.
        warning: Warnings.
        fault: Faults.
        body: Links without skin.
        thing: Objects of a scene: green, unlike robot, touch and marks.
    """

    name: str
    window: str
    panel: str
    text: str
    quiet: str
    line: str
    accent: str = "#22b8cf"
    link: str = "#22b8cf"
    intent: str = "#845ef7"
    warning: str = "#f59f00"
    fault: str = "#e03131"
    body: str = "#5a636d"
    thing: str = "#6c9672"


DARK = Theme("dark", "#1d2126", "#252a31", "#e6e8eb", "#9aa3ad", "#343b44")
LIGHT = Theme(
    "light", "#f4f5f7", "#ffffff", "#1d2126", "#5b6570", "#d8dce1", link="#0b7285", body="#8b949e", thing="#7fae86"
)
THEMES = {theme.name: theme for theme in (DARK, LIGHT)}

DEFAULT_MAXIMUM = 30.0
"""Default maximum of the pressure scale [kPa].

On the arm's skin an 8 mm fingertip reads about 15 kPa at 4 N, 30 at 8, 58 at 15.
"""

# Light neutral (the untouched skin) through yellow and orange to deep red: lightness decreases throughout, so that the
# order is visible in grey and to colour-blind users (tested by simulation).
_STOPS = np.array([0.0, 0.14, 0.35, 0.6, 0.8, 1.0])
_COLOURS = np.array(
    [[224, 227, 230], [243, 209, 122], [243, 165, 58], [222, 95, 34], [172, 36, 32], [92, 6, 22]], dtype=np.float64
)


@dataclass(frozen=True)
class PressureScale:
    """Colours of pressures from zero to ``maximum`` [kPa]; higher pressures have the last colour."""

    maximum: float = DEFAULT_MAXIMUM

    @cached_property
    def table(self) -> NDArray[np.uint8]:
        """(256, 3) red, green, blue."""
        at = np.linspace(0, 1, 256)
        return np.stack([np.interp(at, _STOPS, _COLOURS[:, k]) for k in range(3)], axis=1).round().astype(np.uint8)

    @cached_property
    def lut(self) -> NDArray[np.uint32]:
        """(256,) the same as opaque 0xffRRGGBB words, for QImage."""
        return words32(self.table)

    def rgb(self, kilopascals: FloatArray) -> NDArray[np.uint8]:
        """(k, 3) colours of pressures (k,) [kPa]."""
        index = np.clip(np.asarray(kilopascals) * (255.0 / self.maximum), 0, 255).astype(np.uint8)
        colours: NDArray[np.uint8] = self.table[index]
        return colours


BETWEEN_DOTS = (140, 149, 159)
"""Red, green, blue of the skin between taxels shown as dots; darker than an untouched dot."""

# Blue for shown smaller, brown for larger, the neutral of the skin for unchanged: dull, so that touch stands out.
_STRETCH = np.array(
    [[31, 75, 128], [84, 132, 178], [163, 190, 214], [224, 227, 230], [204, 183, 160], [158, 119, 84], [101, 65, 36]],
    dtype=np.float64,
)


@dataclass(frozen=True)
class StretchScale:
    """Colours of stretch factors, linear in their logarithm from 1 / ``most`` through 1 to ``most``."""

    most: float = 2.0

    @property
    def table(self) -> NDArray[np.uint8]:
        """(255, 3) red, green, blue; the middle one is for 1."""
        return _diverging_table()

    def rgb(self, factors: FloatArray) -> NDArray[np.uint8]:
        """(k, 3) colours of factors (k,); factors outside the range have the colour of its end."""
        with np.errstate(divide="ignore"):
            share = np.log(np.asarray(factors)) / np.log(self.most)
        colours: NDArray[np.uint8] = self.table[np.rint(127 * (1 + np.clip(share, -1, 1))).astype(np.int64)]
        return colours


@dataclass(frozen=True)
class DifferenceScale:
    """Colours of differences from ``-most`` through 0 to ``most``; differences outside have the colour of the end."""

    most: float

    @property
    def table(self) -> NDArray[np.uint8]:
        """(255, 3) red, green, blue; the middle one is for 0."""
        return _diverging_table()

    def rgb(self, differences: FloatArray) -> NDArray[np.uint8]:
        """(k, 3) colours of differences (k,)."""
        share = np.clip(np.asarray(differences) / self.most, -1, 1)
        colours: NDArray[np.uint8] = self.table[np.rint(127 * (1 + share)).astype(np.int64)]
        return colours


@cache
def _diverging_table() -> NDArray[np.uint8]:
    """(255, 3) colours from less through neutral to more."""
    at = np.linspace(-1, 1, 255)
    stops = np.linspace(-1, 1, len(_STRETCH))
    return np.stack([np.interp(at, stops, _STRETCH[:, k]) for k in range(3)], axis=1).round().astype(np.uint8)


def words32(colours: NDArray[np.uint8]) -> NDArray[np.uint32]:
    """Return colours (..., 3) as opaque 0xffRRGGBB words (...), for QImage."""
    red, green, blue = np.moveaxis(colours.astype(np.uint32), -1, 0)
    return np.uint32(0xFF000000) | red << np.uint32(16) | green << np.uint32(8) | blue


def rgb(colour: str) -> tuple[float, float, float]:
    """Return red, green and blue, 0 to 1, of a hex colour."""
    return tuple(int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))  # type: ignore[return-value]


def mixed(first: str, second: str, share: float) -> str:
    """Return the hex colour at a ``share`` of the way from ``first`` to ``second``."""
    pairs = zip(rgb(first), rgb(second), strict=True)
    return "#" + "".join(f"{round(255 * (a + share * (b - a))):02x}" for a, b in pairs)
