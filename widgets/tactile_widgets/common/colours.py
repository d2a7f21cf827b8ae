"""Colours: two themes, and the one scale that means pressure in both views."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.arrays import FloatArray


@dataclass(frozen=True)
class Theme:
    """Neutral greys and four accents, as hex.

    Attributes:
        name: ``dark`` or ``light``.
        window: Ground of the views.
        panel: Ground of panels.
        text: Words.
        quiet: Words of less weight; 4.5:1 on the panel at least.
        line: Hairlines.
        accent: What the user holds or selected.
        link: Words that lead somewhere: the accent, dark enough to be read on the panel.
        intent: What the controller wants.
        warning: Amber.
        fault: Red.
        body: Links without skin.
        thing: Objects of a scene: green, which neither the robot nor touch nor a mark is.
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
"""Top of the pressure scale [kPa]: on the arm's skin an 8 mm fingertip reads about 15 kPa at 4 N, 30 at 8, 58 at 15."""

# Light neutral (the bare skin) through yellow and orange to deep red: lightness falls all the way, so that the order
# can be read in grey and by colour-blind eyes (tested by simulation).
_STOPS = np.array([0.0, 0.14, 0.35, 0.6, 0.8, 1.0])
_COLOURS = np.array(
    [[224, 227, 230], [243, 209, 122], [243, 165, 58], [222, 95, 34], [172, 36, 32], [92, 6, 22]], dtype=np.float64
)


@dataclass(frozen=True)
class PressureScale:
    """Pressure to colour, from zero to ``maximum`` [kPa]; what lies above has the last colour."""

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
"""Red, green, blue of the skin between taxels that are shown as dots: darker than any untouched dot."""

# Blue for shown smaller, brown for larger, the skin's own neutral for kept: dull, so that touch stays the loudest.
_STRETCH = np.array(
    [[31, 75, 128], [84, 132, 178], [163, 190, 214], [224, 227, 230], [204, 183, 160], [158, 119, 84], [101, 65, 36]],
    dtype=np.float64,
)


@dataclass(frozen=True)
class StretchScale:
    """Factors of stretch to colour, evenly in their logarithm from 1 / ``most`` through 1 to ``most``."""

    most: float = 2.0

    @property
    def table(self) -> NDArray[np.uint8]:
        """(255, 3) red, green, blue; the middle one is for 1."""
        return _diverging_table()

    def rgb(self, factors: FloatArray) -> NDArray[np.uint8]:
        """(k, 3) colours of factors (k,); what lies beyond an end has its colour."""
        with np.errstate(divide="ignore"):
            share = np.log(np.asarray(factors)) / np.log(self.most)
        colours: NDArray[np.uint8] = self.table[np.rint(127 * (1 + np.clip(share, -1, 1))).astype(np.int64)]
        return colours


@dataclass(frozen=True)
class DifferenceScale:
    """Differences to colour, from ``-most`` through 0 to ``most``; what lies beyond an end has its colour."""

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
    """(255, 3) from the colour of less through the skin's own to that of more."""
    at = np.linspace(-1, 1, 255)
    stops = np.linspace(-1, 1, len(_STRETCH))
    return np.stack([np.interp(at, stops, _STRETCH[:, k]) for k in range(3)], axis=1).round().astype(np.uint8)


def words32(colours: NDArray[np.uint8]) -> NDArray[np.uint32]:
    """Colours (..., 3) as opaque 0xffRRGGBB words (...), for QImage."""
    red, green, blue = np.moveaxis(colours.astype(np.uint32), -1, 0)
    return np.uint32(0xFF000000) | red << np.uint32(16) | green << np.uint32(8) | blue


def rgb(colour: str) -> tuple[float, float, float]:
    """Red, green, blue, 0 to 1, of a hex colour."""
    return tuple(int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))  # type: ignore[return-value]


def mixed(first: str, second: str, share: float) -> str:
    """The hex colour ``share`` of the way from ``first`` to ``second``."""
    pairs = zip(rgb(first), rgb(second), strict=True)
    return "#" + "".join(f"{round(255 * (a + share * (b - a))):02x}" for a, b in pairs)
