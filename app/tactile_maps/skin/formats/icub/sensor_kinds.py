"""Kinds of modules in iCub's layout files, with the positions of their pads about the middle.

The numbers are those of the viewer iCubSkinGui (robotology/icub-main, src/tools/iCubSkinGui/plugin/include), in its
units of about a millimetre: triangles of the body, old and new; fingertips of four hands; palms; a square of sixteen;
and the hand of R1 (``cer_sh``). Names are case-sensitive, as in the viewer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, readonly

_MILLI = 1e-3
_FINGERTIP_SCALE = 2.7 / 15.3
_PALM_SCALE = 1.2


@dataclass(frozen=True, eq=False)
class SensorKind(ArrayFields):
    """Kind of module.

    Attributes:
        name: Name in layout files.
        pads: (n, 2) positions of its pads about its middle [m]; NaN for a channel without a pad.
        thermal: Pads that measure temperature.
        mirrors: Whether ``mirror`` applies; the fingertips of some right hands are already drawn as such.
        triangular: Whether it has six possible orientations, by thirds of a turn and mirrored.
    """

    name: str
    pads: FloatArray
    thermal: tuple[int, ...] = ()
    mirrors: bool = True
    triangular: bool = False

    @property
    def felt(self) -> BoolArray:
        """(n,) whether each channel is tactile."""
        return np.isfinite(self.pads[:, 0]) & ~np.isin(np.arange(len(self.pads)), self.thermal)


def _table(text: str, scale: float = 1.0) -> FloatArray:
    """Return positions (n, 2) [m] from ``x,y`` for each pad, and a dash for a channel without one."""
    rows = [(np.nan, np.nan) if word == "-" else tuple(map(float, word.split(","))) for word in text.split()]
    return readonly(np.array(rows) * scale * _MILLI)


def _old_triangle() -> FloatArray:
    """Return twelve pads in an equilateral triangle of 30 mm."""
    high = np.sin(np.pi / 3)
    away = 2 * high / 9  # distance of a pad from its corner or side, as a share of the side
    aside = away * np.cos(np.pi / 6)
    up = away / 2
    half = high / 2
    x = [0.75, 1 - aside, 0.5 + aside, 0.5, 0.5 - aside, aside, 0.25, 0.25 + aside, 0.25 + aside, 0.5, 0.75 - aside, 0.75 - aside]  # fmt: skip  # noqa: E501
    y = [half - away, up, up, away, up, up, half - away, half - up, half + up, high - away, half + up, half - up]
    return readonly(30 * _MILLI * (np.transpose([x, y]) - [0.5, high / 3]))


_TRIANGLE_10PAD = """257.2,0 385.83,-222.83 128.62,-222.83 0,0 -128.62,-222.83 -385.83,-222.83 -256.3,-147.64
    -257.2,0 -128.62,222.83 0,445.54 0,296.55 128.62,222.83"""
_FINGERTIP = "-15,10 -15,35 -41,35 -30,64 -11,58 0,82 11,58 30,64 41,35 15,35 15,10 41,10"
_FINGERTIP_2R = "15,10 15,35 41,35 30,64 11,58 0,82 -11,58 -30,64 -41,35 -15,35 -15,10 -41,10"
_FINGERTIP_3L = "30,-20 0,-20 -30,-20 -45,-39 45,-39 -30,-58 0,-58 30,-58 25,10 0,0 -25,10 0,40"
_FINGERTIP_3R = "0,40 25,10 0,0 -25,10 -30,-20 0,-20 30,-20 -45,-39 45,-39 30,-58 0,-58 -30,-58"
_FINGERTIP_4L = "20,-25 0,-25 -20,-25 -35,-39 35,-39 -20,-53 0,-53 20,-53 22,-2 5,10 -4,28 32,30"
_FINGERTIP_4R = "-32,30 4,28 -5,10 -22,-2 -20,-25 0,-25 20,-25 -35,-39 35,-39 20,-53 0,-53 -20,-53"
_FINGERTIP_MID = "0,-30 -15,-20 0,-10 -15,0 -35,10 0,10 -15,20 0,30 15,20 35,10 15,0 15,-20"
_PALM_L = """32,-3.5 32,1 27,-3.5 27,1 37,1 42,0 27,6 32,6 37,6 42,5.5 47,4.5 51.7,4
    47.5,-18 38,-14 32,-9 27,-9 37,-9 37.5,-4.5 43,-16 42,-10.5 42,-5.5 46.5,-8 47,-13 43.5,-20
    21.5,-4 14.5,-3.5 11.5,1 6.5,1 6.5,6 1.5,6.5 11.5,6 16.5,6 16.5,1 21.5,6 21.5,1 9.5,-2
    38,-19.5 43,-26 38,-24.5 40,-29.5 33,-24.5 35,-29 33,-19.5 37,-32.5 28,-24.5 28,-19.5 28,-14.5 33,-14.5"""
_PALM_R = """47,4.5 42,5.5 37,6 32,6 37,1 42,0 27,6 27,1 32,1 27,-3.5 32,-3.5 51.7,4
    47.5,-18 47,-13 46.5,-8 42,-5.5 37.5,-4.5 37,-9 43,-16 42,-10.5 27,-9 32,-9 38,-14 43.5,-20
    16.5,6 11.5,6 6.5,6 1.5,6.5 11.5,1 6.5,1 14.5,-3.5 21.5,6 16.5,1 21.5,1 21.5,-4 9.5,-2
    28,-19.5 28,-24.5 33,-24.5 35,-29 40,-29.5 38,-24.5 33,-19.5 37,-32.5 43,-26 38,-19.5 33,-14.5 28,-14.5"""
_PALM_THERMAL = (11, 23, 35, 43)
_CER_DISTAL_LEFT = """37.2,16.7 31.2,22.7 31.2,16.7 43.2,10.7 25.2,22.7 37.2,10.7 43.2,4.7 31.2,4.7 37.2,4.7 25.2,4.7
    31.2,10.7 - 25.2,10.7 13.2,4.7 7.2,4.7 19.2,4.7 7.2,10.7 13.2,10.7 7.2,16.7 13.2,16.7 19.2,10.7 19.2,16.7
    25.2,16.7 - 7.2,22.7 10.2,27.7 13.2,22.7 16.2,27.7 19.2,22.7 - - - - - - -"""
_CER_DISTAL_RIGHT = """11.2,16.7 17.2,22.7 17.2,16.7 5.2,10.7 23.2,22.7 11.2,10.7 5.2,4.7 17.2,4.7 11.2,4.7 23.2,4.7
    17.2,10.7 - 23.2,10.7 35.2,4.7 41.2,4.7 29.2,4.7 41.2,10.7 35.2,10.7 41.2,16.7 35.2,16.7 29.2,10.7 29.2,16.7
    23.2,16.7 - 41.2,22.7 38.2,27.7 35.2,22.7 32.2,27.7 29.2,22.7 - - - - - - -"""
_CER_PROXIMAL = """10,3.5 16,3.5 4,3.5 4,9.5 4,21.5 4,15.5 10,9.5 10,15.5 10,21.5 16,15.5 16,9.5 -
    16,33.5 16,39.5 10,33.5 16,27.5 10,39.5 16,21.5 10,27.5 4,27.5 4,33.5 4,39.5 - -"""
_CER_THUMB_DISTAL = """30,10.5 30,4.5 18,4.5 6.1,4.5 12,4.5 24,4.5 12,16.4 18,10.5 18,16.5 24,16.5 24,10.5 -
    12,10.5 6,10.5 - - - - - - - - - -"""
_CER_THUMB_PROXIMAL = "3,17 3,5 3,11 10,5 10,29 3,23 3,29 10,23 10,17 10,11 - -"

TRIANGLE = SensorKind("triangle_10pad", _table(_TRIANGLE_10PAD, 1 / 40), (6, 10), triangular=True)
"""Current module of the body."""
KINDS = {
    kind.name: kind
    for kind in (
        TRIANGLE,
        SensorKind("triangle", _old_triangle(), triangular=True),
        SensorKind("fingertip", _table(_FINGERTIP, _FINGERTIP_SCALE)),
        SensorKind("fingertip2L", _table(_FINGERTIP, _FINGERTIP_SCALE)[::-1]),
        SensorKind("fingertip2R", _table(_FINGERTIP_2R, _FINGERTIP_SCALE), mirrors=False),
        SensorKind("fingertip3L", _table(_FINGERTIP_3L, _FINGERTIP_SCALE)),
        SensorKind("fingertip3R", _table(_FINGERTIP_3R, _FINGERTIP_SCALE), mirrors=False),
        SensorKind("fingertip4L", _table(_FINGERTIP_4L, _FINGERTIP_SCALE)),
        SensorKind("fingertip4R", _table(_FINGERTIP_4R, _FINGERTIP_SCALE), mirrors=False),
        SensorKind("fingertipMID", _table(_FINGERTIP_MID, _FINGERTIP_SCALE)),
        SensorKind("palmL", _table(_PALM_L, _PALM_SCALE), _PALM_THERMAL),
        SensorKind("palmR", _table(_PALM_R, _PALM_SCALE), _PALM_THERMAL),
        SensorKind("quad16", _table(" ".join(f"{x},{y}" for y in (-12, -4, 4, 12) for x in (-12, -4, 4, 12)))),
        SensorKind("cer_sh_pdl", _table(_CER_DISTAL_LEFT)),
        SensorKind("cer_sh_pdr", _table(_CER_DISTAL_RIGHT)),
        SensorKind("cer_sh_pp", _table(_CER_PROXIMAL)),
        SensorKind("cer_sh_td", _table(_CER_THUMB_DISTAL)),
        SensorKind("cer_sh_tp", _table(_CER_THUMB_PROXIMAL)),
    )
}
"""Kinds of modules by name."""
