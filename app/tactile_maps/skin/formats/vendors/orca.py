"""Touch sensors of the ORCA hand in YAML: ``coordinates`` with ``x``, ``y``, ``z`` in the unit that ``units`` names.

The shape is that of orca_core (orcahand/orca_core, ``orca_core/hardware/sensing/models``): one file for each model of
sensor, taxels in the order of the stream of forces. The frame is the sensor's: x across, y towards the fingertip, z
outward; the pose of the sensor on its finger is not in the file. Taxels have three axes: the stream contains fx, fy and
fz of each along the axes of the sensor, so that t1 is the x-axis, projected onto the surface.
"""

from __future__ import annotations

from tactile_maps.core.errors import SkinError
from tactile_maps.skin.formats.vendors.field_mapping import FieldMapping
from tactile_maps.skin.formats.vendors.taxel_format import TaxelFormat, read_with
from tactile_maps.skin.model.taxel_set import METRES

_FIELDS = ("x", "y", "z")
_ASSUMED = (
    "ORCA: positions in the frame of the sensor, whose link the file does not name; no normals; three axes, "
    "with t1 along the x-axis of the sensor"
)


def _recognises(document: object) -> bool:
    records = document.get("coordinates") if isinstance(document, dict) else None
    return isinstance(records, list) and bool(records) and isinstance(records[0], dict) and {*_FIELDS} <= {*records[0]}


def _mapping(document: object) -> FieldMapping:
    stated = document if isinstance(document, dict) else {}
    unit = stated.get("units", "mm")
    if unit not in METRES:
        raise SkinError("unknown unit", place="units", value=unit, remedy=f"Choose one of: {', '.join(METRES)}")
    count = len(stated.get("coordinates", ()))
    if stated.get("num_taxels", count) != count:
        found = f"{stated['num_taxels']} and {count}"
        raise SkinError("num_taxels and the coordinates differ in number", place="num_taxels", value=found)
    return FieldMapping(_FIELDS, records="coordinates", unit=str(unit), axes=3, t1=(1.0, 0.0, 0.0))


ORCA = TaxelFormat("orca", "ORCA hand", (".yaml", ".yml"), read_with(_mapping, _ASSUMED), _recognises)
