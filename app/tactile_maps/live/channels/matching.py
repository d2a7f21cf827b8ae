"""Assignment of the values of a reading to taxels: by hardware id, by module and channel, or by their order.

An optional table maps the stream's ids to taxels, for a skin whose file does not contain them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, readonly
from tactile_maps.core.errors import LiveError
from tactile_maps.live.readings.readings import MalformedReadingError, Reading
from tactile_maps.live.readings.tables import read_rows, whole_number
from tactile_maps.skin.model.skin import Skin

_MOST_LAYOUTS = 4096
"""Number of different label lists that are cached: as many as the boards of one skin send."""
_MOST_NAMED = 1000
"""Number of unknown labels that are kept by name; all are counted."""


@dataclass(frozen=True, eq=False)
class _Rows:
    """Assignment for one list of labels.

    Attributes:
        places: (k,) indices of the known values in the reading.
        taxels: (k,) their taxels.
        unknown: Labels that belong to no taxel.
    """

    places: IntArray
    taxels: IntArray
    unknown: tuple[str, ...]


class TaxelMatcher:
    """Assigns the values of readings to the taxels of a skin. Mutable: caches assignments.

    Args:
        skin: The skin.
        table: Taxel number by the stream's id; replaces the skin's own ids.

    Attributes:
        unknown: Labels that belong to no taxel, at most 1000 of them.
        unknown_values: Number of values with such a label.
        heard: (taxels,) whether a value has arrived for each.
    """

    def __init__(self, skin: Skin, table: Mapping[int, int] | None = None) -> None:
        self._skin = skin
        self._table = table
        self.unknown: set[str] = set()
        self.unknown_values = 0
        self.heard: BoolArray = np.zeros(len(skin), dtype=bool)
        self._layouts: dict[tuple[str, bytes], _Rows] = {}
        self._everything = readonly(np.arange(len(skin)), np.int64)

    def match(self, reading: Reading) -> tuple[IntArray, FloatArray]:
        """Return taxels (k,) and their values (k,); the last value of a repeated label counts.

        Raises:
            MalformedReadingError: The number of values without labels differs from the number of taxels.

        Cost: 10 µs for labels in the cache.
        """
        rows = self._rows(reading)
        if rows is None:
            self.heard[:] = True
            return self._everything, reading.values
        self.heard[rows.taxels] = True
        self.unknown_values += len(rows.unknown)
        return rows.taxels, reading.values[rows.places]

    def taxels(self, reading: Reading) -> IntArray:
        """Return the taxels (k,) of a reading without counting them; raises as ``match``."""
        rows = self._rows(reading)
        return self._everything if rows is None else rows.taxels

    def _rows(self, reading: Reading) -> _Rows | None:
        """Return the assignment of a reading's labels; None for values of all taxels in order."""
        labels = reading.ids if reading.ids is not None else reading.channels
        if labels is None:
            if len(reading.values) != len(self._skin):
                found = f"{len(reading.values)} values for {len(self._skin)} taxels"
                remedy = "Send ids, channels, or one value for each taxel in the skin's order"
                raise MalformedReadingError("values without ids do not fit the skin", value=found, remedy=remedy)
            return None
        kind = "ids" if reading.ids is not None else "channels"
        key = kind, labels.tobytes()
        rows = self._layouts.get(key)
        if rows is None:
            if len(self._layouts) >= _MOST_LAYOUTS:
                self._layouts.clear()
            rows = self._layouts[key] = self._look_up(kind, labels)
            self.unknown.update(rows.unknown[: max(_MOST_NAMED - len(self.unknown), 0)])
        return rows

    def _look_up(self, kind: str, labels: IntArray) -> _Rows:
        known, ambiguous = self._ids() if kind == "ids" else self._channels()
        found = dict[int, int]()
        unknown = []
        for place, label in enumerate(labels.tolist()):
            key = label if kind == "ids" else tuple(label)
            taxel = known.get(key)
            if taxel is None:
                text = str(label) if kind == "ids" else f"module {label[0]}, channel {label[1]}"
                unknown.append(f"{text} (of several taxels)" if key in ambiguous else text)
            else:
                found[taxel] = place
        return _Rows(readonly(list(found.values()), np.int64), readonly(list(found), np.int64), tuple(unknown))

    def _ids(self) -> tuple[Mapping[Any, int], set[Any]]:
        """Return taxel by id, and ambiguous ids, which are assigned to no taxel."""
        if self._table is not None:
            return dict(self._table.items()), set()
        ids = [self._skin.taxel_name(taxel).id for taxel in range(len(self._skin))]
        if all(one is None for one in ids):
            return {taxel: taxel for taxel in range(len(ids))}, set()
        return _unique(ids)

    def _channels(self) -> tuple[Mapping[Any, int], set[Any]]:
        names = [self._skin.taxel_name(taxel) for taxel in range(len(self._skin))]
        pairs = [None if None in (name.module, name.channel) else (name.module, name.channel) for name in names]
        return _unique(pairs)


def _unique(labels: Sequence[object]) -> tuple[dict[object, int], set[object]]:
    found: dict[object, int] = {}
    twice = set()
    for taxel, label in enumerate(labels):
        if label is not None and found.setdefault(label, taxel) != taxel:
            twice.add(label)
    return {label: taxel for label, taxel in found.items() if label not in twice}, twice


def load_matching(path: str | Path, skin: Skin) -> dict[int, int]:
    """Read taxel numbers by the stream's id from a CSV table with the columns ``id`` (as sent) and ``taxel`` (number).

    Raises:
        LiveError: The table cannot be read, or names an unknown taxel.
    """
    found: dict[int, int] = {}
    for line, row in read_rows(Path(path), ("id", "taxel")):
        number = whole_number(row["id"], path, line, "id")
        taxel = whole_number(row["taxel"], path, line, "taxel")
        if not 0 <= taxel < len(skin):
            remedy = f"The skin has taxels 0 to {len(skin) - 1}"
            raise LiveError("unknown taxel", file=path, place=f"line {line}", value=taxel, remedy=remedy)
        if found.setdefault(number, taxel) != taxel:
            raise LiveError("an id is assigned to two taxels", file=path, place=f"line {line}", value=number)
    return found
