"""Probes of Tactile Genesis in JSON: for each link a list or grid of probes with ``pos``, ``normal`` and ``radius``.

The shape is that of neuroagents-lab/tactile-genesis (``dexterous-hands/src/assets/sensors``): a list of objects with
``link_name``, ``kind`` (``grid`` or ``list``) and ``probes``, in metres in the frame of the link. Probes of a grid are
read by rows. A probe feels within its radius, so that the area of its circle is kept as the stated area.
"""

from __future__ import annotations

from tactile_maps.skin.formats.vendors.field_mapping import FieldMapping
from tactile_maps.skin.formats.vendors.taxel_format import TaxelFormat, read_with

_MAPPING = FieldMapping(("pos",), records="probes", unit="m", normal=("normal",), radius="radius", link="link_name")
_ASSUMED = "Tactile Genesis: metres in the frame of each link; probes of a grid by rows, without ids"


def _recognises(document: object) -> bool:
    first = document[0] if isinstance(document, list) and document else None
    return isinstance(first, dict) and isinstance(first.get("probes"), list) and "link_name" in first


TACTILE_GENESIS = TaxelFormat(
    "tactile-genesis", "Tactile Genesis", (".json",), read_with(lambda document: _MAPPING, _ASSUMED), _recognises
)
