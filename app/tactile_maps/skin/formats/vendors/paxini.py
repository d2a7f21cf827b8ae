"""PaXini sensors in JSON: a list ``points`` with ``index``, ``x_mm``, ``y_mm``, ``z_mm``, or a list ``taxels_mm``.

``taxels_mm`` is the shape of the open program paxini-toolkit (yknxh/paxini-toolkit, ``paxkit/device/geometry``): three
numbers for each taxel in the order of the sensor's stream, counted from 1 in the tables of PaXini. Taxels have three
axes: the stream contains fx, fy and fz of each (``paxkit/device/codec.py``).
"""

from __future__ import annotations

from tactile_maps.skin.formats.vendors.field_mapping import FieldMapping
from tactile_maps.skin.formats.vendors.taxel_format import TaxelFormat, read_with

_COLUMNS = ("x_mm", "y_mm", "z_mm")
_POINTS = FieldMapping(_COLUMNS, records="points", unit="mm", id="index", axes=3)
_BARE = FieldMapping(("0", "1", "2"), records="taxels_mm", unit="mm", axes=3)
_ASSUMED = (
    "PaXini: positions in the frame of the sensor, whose link the file does not name; no normals; three axes, "
    "as in the sensor's stream, with t1 from the map"
)


def _recognises(document: object) -> bool:
    if not isinstance(document, dict):
        return False
    points = document.get("points")
    listed = (
        isinstance(points, list) and points and isinstance(points[0], dict) and {*_COLUMNS, "index"} <= {*points[0]}
    )
    return bool(listed) or isinstance(document.get("taxels_mm"), list)


def _mapping(document: object) -> FieldMapping:
    return _BARE if isinstance(document, dict) and "taxels_mm" in document else _POINTS


PAXINI = TaxelFormat("paxini", "PaXini", (".json",), read_with(_mapping, _ASSUMED), _recognises)
