"""Which taxel each value of a reading is of: by hardware id, by module and channel, or by the order of the values.

A table from the stream's own ids to taxels may stand between, for a skin whose file does not know them.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, readonly
from tactile_maps.core.errors import LiveError
from tactile_maps.core.files import read_bounded_text
from tactile_maps.live.readings.readings import MalformedReadingError, Reading
from tactile_maps.skin.model.skin import Skin

_MOST_LAYOUTS = 4096
"""Different lists of ids that are remembered: boards of one skin send as many; beyond, they are looked up again."""
_MOST_NAMED = 1000
"""Unknown ids that are kept by name; all are counted."""


@dataclass(frozen=True, eq=False)
class _Rows:
    """Of one list of labels: where in the reading, and of which taxel, each value that is known is."""

    places: IntArray
    taxels: IntArray
    unknown: tuple[str, ...]


class TaxelMatcher:
    """Ties readings to a skin's taxels. Mutable: it remembers what it was told.

    Args:
        skin: Whose taxels.
        table: Running number of the taxel by the stream's id, instead of the skin's own ids.

    Attributes:
        unknown: Labels that no taxel has, at most 1000 of them.
        unknown_values: How many values had such a label.
        heard: (taxels,) whether a value came for each.
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
        """(k,) taxels and (k,) their values; of a label named twice the last value counts.

        Raises:
            MalformedReadingError: Values without labels are not as many as the taxels.

        Cost: 10 µs for labels that came before.
        """
        rows = self._rows(reading)
        if rows is None:
            self.heard[:] = True
            return self._everything, reading.values
        self.heard[rows.taxels] = True
        self.unknown_values += len(rows.unknown)
        return rows.taxels, reading.values[rows.places]

    def taxels(self, reading: Reading) -> IntArray:
        """(k,) taxels that a reading has values of, which are not counted; raises as ``match``."""
        rows = self._rows(reading)
        return self._everything if rows is None else rows.taxels

    def _rows(self, reading: Reading) -> _Rows | None:
        """The places of a reading's values; None for those of all taxels in their order."""
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
        return _Rows(
            readonly(list(found.values()), np.int64), readonly(list(found), np.int64), tuple(unknown)
        )  # fmt: skip

    def _ids(self) -> tuple[Mapping[Any, int], set[Any]]:
        """Taxel by the stream's id, and the ids that several taxels have, which name none of them."""
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
    """Taxel by the stream's id, from a CSV table with the columns ``id`` (as sent) and ``taxel`` (running number).

    Raises:
        LiveError: The table cannot be read, or names what there is not.
    """
    found: dict[int, int] = {}
    for line, row in read_rows(Path(path), ("id", "taxel")):
        number = whole(row["id"], path, line, "id")
        taxel = whole(row["taxel"], path, line, "taxel")
        if not 0 <= taxel < len(skin):
            remedy = f"The skin has taxels 0 to {len(skin) - 1}"
            raise LiveError("there is no such taxel", file=path, place=f"line {line}", value=taxel, remedy=remedy)
        if found.setdefault(number, taxel) != taxel:
            raise LiveError("an id is given two taxels", file=path, place=f"line {line}", value=number)
    return found


def read_rows(path: Path, needed: tuple[str, ...]) -> list[tuple[int, dict[str, str]]]:
    """Rows of a CSV table by its header, with their line numbers; lines that begin with # are remarks.

    Raises:
        LiveError: The file cannot be read, or a column of ``needed`` is missing, or a row has too many or too few.
    """
    lines = read_bounded_text(path, error=LiveError).splitlines()
    kept = [(number, line) for number, line in enumerate(lines, start=1) if line.strip() and line.lstrip()[0] != "#"]
    if not kept:
        raise LiveError("the table is empty", file=path)
    parsed = list(csv.reader(line for _, line in kept))
    header = [name.strip().lower() for name in parsed[0]]
    for name in needed:
        if name not in header:
            remedy = f"Its header needs: {', '.join(needed)}"
            raise LiveError("a column is missing", file=path, place=f"line {kept[0][0]}", value=name, remedy=remedy)
    rows = []
    for (line, _), cells in zip(kept[1:], parsed[1:], strict=True):
        if len(cells) != len(header):
            found = f"{len(cells)} of {len(header)} columns"
            raise LiveError("a row does not fit the header", file=path, place=f"line {line}", value=found)
        rows.append((line, dict(zip(header, (cell.strip() for cell in cells), strict=True))))
    return rows


def whole(text: str, path: str | Path, line: int, column: str) -> int:
    """Return the whole number in a cell. Raises LiveError naming it, also where it has more than 18 digits."""
    if not re.fullmatch(r"\s*[+-]?[0-9]{1,18}\s*", text):
        remedy = "Write a whole number of at most 18 digits"
        raise LiveError("expected a whole number", file=path, place=f"line {line}, {column}", value=text, remedy=remedy)
    return int(text)
