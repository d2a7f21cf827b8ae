"""Probes of Tactile Genesis in JSON: for each link a list or grid of probes with ``pos``, ``normal`` and ``radius``.

The shape is that of neuroagents-lab/tactile-genesis (``dexterous-hands/src/assets/sensors``): a list of objects with
``link_name``, ``kind`` (``grid`` or ``list``) and ``probes``, in metres in the frame of the link. Probes of a grid are
read by rows. A probe feels within its radius, so that the area of its circle is kept as the stated area. Probes of
radius 0 fill up a grid and feel nothing: they are left out, and the others keep their place in the stream as their id.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from tactile_maps.core.errors import Finding, SkinError, errors_in_file
from tactile_maps.skin.formats.vendors.documents import content_of
from tactile_maps.skin.formats.vendors.field_mapping import FieldMapping, taxel_sets_of
from tactile_maps.skin.formats.vendors.taxel_format import TaxelFormat
from tactile_maps.skin.model.taxel_set import TaxelSet

_MAPPING = FieldMapping(("pos",), records="probes", unit="m", normal=("normal",), radius="radius", link="link_name")
_ASSUMED = "Tactile Genesis: metres in the frame of each link; probes of a grid by rows, without ids"
_FILLERS = "probes of radius 0 only fill up a grid: left out; the id of each other probe is its place in the stream"
_PLACE = "place in the stream"


def _read(path: Path) -> tuple[TaxelSet, ...]:
    document = content_of(path)
    with errors_in_file(path):
        active, fillers = _without_fillers(document)
        mapping = replace(_MAPPING, id=_PLACE) if fillers else _MAPPING
        sets = taxel_sets_of(active if fillers else document, mapping, name=path.stem, where=path.name)
    findings = [Finding("vendor-layout", path.name, _ASSUMED, sum(map(len, sets)))]
    if fillers:
        findings.append(Finding("unfitted-taxel", path.name, _FILLERS, fillers))
    return (sets[0].with_findings(*findings), *sets[1:])


def _without_fillers(document: object) -> tuple[list[object], int]:
    """Return the document with a list of the active probes of each link, and the number of the others.

    Raises:
        SkinError: No probe is active.
    """
    active = list[object]()
    fillers = 0
    for link in document if isinstance(document, list) else []:
        probes = list(_flat(link.get("probes"))) if isinstance(link, dict) else []
        kept = [
            {**probe, _PLACE: place} if isinstance(probe, dict) else probe
            for place, probe in enumerate(probes)
            if not (isinstance(probe, dict) and probe.get("radius") == 0)
        ]
        fillers += len(probes) - len(kept)
        if kept:
            active.append({**link, "probes": kept})
    if fillers and not active:
        raise SkinError("every probe has the radius 0", value=fillers, remedy="Choose a file with active probes")
    return active, fillers


def _flat(probes: object) -> Iterator[object]:
    if isinstance(probes, list):
        for probe in probes:
            yield from _flat(probe)
    else:
        yield probes


def _recognises(document: object) -> bool:
    first = document[0] if isinstance(document, list) and document else None
    return isinstance(first, dict) and isinstance(first.get("probes"), list) and "link_name" in first


TACTILE_GENESIS = TaxelFormat("tactile-genesis", "Tactile Genesis", (".json",), _read, _recognises)
