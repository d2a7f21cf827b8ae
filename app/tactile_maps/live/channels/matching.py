"""Assignment of the values of a reading to taxels: by hardware id, by module and channel, or by their order.

An id that several links have is addressed as ``link:id``. A taxel whose place several ids share shows the largest of
their values, or the smallest where values fall under pressure. Values without labels are those of all taxels in order,
or the vendor's stream, in which value k is that of id k. NaN is the value of a taxel that did not report. An optional
table maps the stream's ids to taxels, for a skin whose file does not contain them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, readonly
from tactile_maps.core.errors import LiveError, counted
from tactile_maps.live.readings.readings import MalformedReadingError, Reading, split_id
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
        places: (v,) indices of the known values in the reading, by taxel.
        starts: (k,) first of these values of each taxel.
        taxels: (k,) their taxels.
        unknown: Labels that belong to no taxel.
        ambiguous: Labels that belong to several taxels.
    """

    places: IntArray
    starts: IntArray
    taxels: IntArray
    unknown: tuple[str, ...] = ()
    ambiguous: tuple[str, ...] = ()

    def values(self, readings: FloatArray, falls: BoolArray | None) -> FloatArray:
        """Return (k,) the value of each taxel; NaN if none was reported.

        It is the largest of several, or the smallest where values fall under pressure (``falls``, (taxels,)).
        """
        values = readings[self.places]
        if len(self.starts) == len(values):
            return values
        largest = np.fmax.reduceat(values, self.starts)
        if falls is None or not falls.any():
            return largest
        return np.where(falls[self.taxels], np.fmin.reduceat(values, self.starts), largest)

    def chosen(self, readings: FloatArray, falls: BoolArray | None) -> IntArray:
        """Return (k,) the place in the reading of the value of each taxel, see ``values``."""
        if len(self.starts) == len(self.places):
            return self.places
        several = np.diff(np.append(self.starts, len(self.places)))
        values = readings[self.places]
        if falls is not None:
            values = np.where(np.repeat(falls[self.taxels], several), -values, values)
        of = np.repeat(np.arange(len(several)), several)
        order = np.lexsort((np.where(np.isnan(values), -np.inf, values), of))
        return self.places[order[self.starts + several - 1]]


class TaxelMatcher:
    """Assigns the values of readings to the taxels of a skin. Mutable: caches assignments.

    Args:
        skin: The skin.
        table: Taxel number by the stream's id; replaces the skin's own ids.

    Attributes:
        unknown: Labels that belong to no taxel, at most 1000 of them.
        unknown_values: Number of values with such a label.
        ambiguous: Labels that belong to several taxels, with the labels that state the link; at most 1000 of them.
        ambiguous_values: Number of values with such a label.
        heard: (taxels,) whether a value has arrived for each.
    """

    def __init__(self, skin: Skin, table: Mapping[int, int] | None = None) -> None:
        self._skin = skin
        self._table = table
        self.unknown: set[str] = set()
        self.unknown_values = 0
        self.ambiguous: set[str] = set()
        self.ambiguous_values = 0
        self.heard: BoolArray = np.zeros(len(skin), dtype=bool)
        self._layouts: dict[tuple[object, ...], _Rows] = {}
        self._everything = readonly(np.arange(len(skin)), np.int64)

    def match(self, reading: Reading, falls: BoolArray | None = None) -> tuple[IntArray, FloatArray]:
        """Return taxels (k,) and their values (k,) without those that did not report (NaN).

        The last value of a repeated label counts, and of aliases the one with the most pressure.

        Args:
            reading: The reading.
            falls: (taxels,) whether the values of a taxel fall under pressure; None if all rise.

        Raises:
            MalformedReadingError: The number of values without labels differs from the number of taxels.

        Cost: 10 µs for labels in the cache.
        """
        rows = self._rows(reading)
        taxels, values = self._reported(rows, reading, falls)
        self.heard[taxels] = True
        if rows is not None:
            self.unknown_values += len(rows.unknown)
            self.ambiguous_values += len(rows.ambiguous)
        return taxels, values

    def match_shear(self, reading: Reading, falls: BoolArray | None = None) -> tuple[IntArray, FloatArray]:
        """Return taxels (k,) and their channels (k, 3): value and shear, NaN for those that did not report.

        Args:
            reading: A reading with shear.
            falls: As for ``match``.
        """
        assert reading.shear is not None
        rows = self._rows(reading)
        channels = np.column_stack([reading.values, reading.shear])
        return (
            (self._everything, channels)
            if rows is None
            else (rows.taxels, channels[rows.chosen(reading.values, falls)])
        )

    def taxels(self, reading: Reading) -> IntArray:
        """Return the taxels (k,) of a reading without counting them; raises as ``match``."""
        return self._reported(self._rows(reading), reading)[0]

    def _reported(
        self, rows: _Rows | None, reading: Reading, falls: BoolArray | None = None
    ) -> tuple[IntArray, FloatArray]:
        taxels = self._everything if rows is None else rows.taxels
        values = reading.values if rows is None else rows.values(reading.values, falls)
        reported = ~np.isnan(values)
        return (taxels, values) if reported.all() else (taxels[reported], values[reported])

    def _rows(self, reading: Reading) -> _Rows | None:
        """Return the assignment of a reading's labels; None for values of all taxels in order."""
        labels = reading.ids if reading.ids is not None else reading.channels
        if labels is None:
            if len(reading.values) == len(self._skin):
                return None
            return self._cached(("stream", len(reading.values)), lambda: self._stream(len(reading.values)))
        kind = "ids" if reading.ids is not None else "channels"
        return self._cached((kind, labels.tobytes(), reading.links), lambda: self._look_up(reading, labels))

    def _cached(self, key: tuple[object, ...], make: Callable[[], _Rows]) -> _Rows:
        rows = self._layouts.get(key)
        if rows is None:
            if len(self._layouts) >= _MOST_LAYOUTS:
                self._layouts.clear()
            rows = self._layouts[key] = make()
            self.unknown.update(rows.unknown[: max(_MOST_NAMED - len(self.unknown), 0)])
            self.ambiguous.update(rows.ambiguous[: max(_MOST_NAMED - len(self.ambiguous), 0)])
        return rows

    def _stream(self, count: int) -> _Rows:
        """Return the assignment of a vendor's stream of ``count`` values without labels: value k is that of id k."""
        links = {patch.link for patch in self._skin.patches if patch.taxels.identity.stream == count}
        if len(links) != 1:
            found = f"{counted(count, 'value')} for {counted(len(self._skin), 'taxel')}"
            remedy = "Send ids, channels, or one value for each taxel in the skin's order"
            if links:
                remedy = f"Send ids with their link (link:id): {', '.join(sorted(links))} have such a stream"
            raise MalformedReadingError("values without ids do not fit the skin", value=found, remedy=remedy)
        (link,) = links
        known = self._by_link
        found_places = {(link, number): number for number in range(count) if (link, number) in known}
        return _assignment({label: (known[label], place) for label, place in found_places.items()})

    def _look_up(self, reading: Reading, labels: IntArray) -> _Rows:
        known, several = self._known(reading)
        found = dict[object, tuple[int, int]]()
        unknown = []
        ambiguous = []
        for place, label in enumerate(labels.tolist()):
            key: object = tuple(label) if isinstance(label, list) else label
            text = f"module {label[0]}, channel {label[1]}" if isinstance(label, list) else str(label)
            if reading.links is not None:
                key = (reading.links[place], label)
                text = f"{reading.links[place]}:{label}"
            if key in known:
                found[key] = known[key], place
            elif key in several:
                ambiguous.append(f"{text} ({several[key]})")
            elif reading.ids is None or not self._is_channel(key):
                unknown.append(text)
        rows = _assignment(found)
        return replace(rows, unknown=tuple(unknown), ambiguous=tuple(ambiguous))

    def _is_channel(self, label: object) -> bool:
        """Whether an id without a taxel is in the vendor's stream, such as that of a thermal or unfitted pad."""
        streams = {patch.link: patch.taxels.identity.stream or 0 for patch in self._skin.patches}
        link, number = label if isinstance(label, tuple) else (None, label)
        return number < max((count for name, count in streams.items() if link in (None, name)), default=0)

    def _known(self, reading: Reading) -> tuple[Mapping[Any, int], Mapping[Any, str]]:
        """Return taxels by label, and for each label of several taxels the labels that distinguish them."""
        if reading.ids is None:
            return self._by_channel
        if reading.links is not None:
            return self._by_link, {}
        return self._by_id

    @cached_property
    def _by_id(self) -> tuple[Mapping[Any, int], Mapping[Any, str]]:
        if self._table is not None:
            return dict(self._table.items()), {}
        labels = self._labels
        if not labels:
            return {taxel: taxel for taxel in range(len(self._skin))}, {}
        known, several = _unique((number, taxel) for _link, number, taxel in labels)
        links = dict[int, dict[str, None]]()
        for link, number, _taxel in labels:
            links.setdefault(number, {})[link] = None
        words = {
            number: " or ".join(f"{link}:{number}" for link in links[number]) if len(links[number]) > 1 else _SEVERAL
            for number in several
        }
        return known, words

    @cached_property
    def _by_link(self) -> Mapping[Any, int]:
        """Taxel by link and id."""
        return _unique(((link, number), taxel) for link, number, taxel in self._labels)[0]

    @cached_property
    def _by_channel(self) -> tuple[Mapping[Any, int], Mapping[Any, str]]:
        names = [self._skin.taxel_name(taxel) for taxel in range(len(self._skin))]
        pairs = (
            ((name.module, name.channel), taxel)
            for taxel, name in enumerate(names)
            if None not in (name.module, name.channel)
        )
        known, several = _unique(pairs)
        return known, dict.fromkeys(several, _SEVERAL)

    @cached_property
    def _labels(self) -> list[tuple[str, int, int]]:
        """Link, id and taxel of each id and alias of the skin."""
        found = []
        for patch, start in zip(self._skin.patches, self._skin.first[:-1].tolist(), strict=True):
            identity = patch.taxels.identity
            if identity.ids is None:
                continue
            found += [(patch.link, number, start + row) for row, number in enumerate(identity.ids.tolist())]
            if identity.aliases is not None:
                found += [(patch.link, number, start + row) for number, row in identity.aliases.tolist()]
        return found


_SEVERAL = "of several taxels"


def _assignment(found: Mapping[object, tuple[int, int]]) -> _Rows:
    """Return the assignment of known labels, given the taxel and the place in the reading of each."""
    by_taxel = dict[int, list[int]]()
    for taxel, place in found.values():
        by_taxel.setdefault(taxel, []).append(place)
    places = list(chain.from_iterable(by_taxel.values()))
    starts = np.cumsum([0, *map(len, by_taxel.values())])[:-1]
    return _Rows(readonly(places, np.int64), readonly(starts, np.int64), readonly(list(by_taxel), np.int64))


def _unique(labels: Iterable[tuple[Any, int]]) -> tuple[dict[Any, int], set[Any]]:
    """Return the taxel of each label that only one taxel has, and the labels of several."""
    found: dict[Any, int] = {}
    twice = set()
    for label, taxel in labels:
        if found.setdefault(label, taxel) != taxel:
            twice.add(label)
    return {label: taxel for label, taxel in found.items() if label not in twice}, twice


def taxel_of(text: str, skin: Skin, *, place: str, file: Path) -> int:
    """Return the taxel that a file names by its id, or by ``link:id``.

    Raises:
        LiveError: No taxel or several have the id.
    """
    try:
        link, number = split_id(text)
    except MalformedReadingError as error:
        raise error.at(kind=LiveError, file=file, place=place) from error
    found = skin.taxels_with_id(number, link=link).tolist()
    if len(found) == 1:
        return int(found[0])
    problem = "several taxels have that id" if found else "unknown taxel"
    links = dict.fromkeys(skin.patches[int(skin.patch_of[taxel])].link for taxel in found)
    remedy = f"Give its number (taxel), 0 to {len(skin) - 1}"
    if len(links) > 1:
        remedy = f"Give its link too: {' or '.join(f'{link}:{number}' for link in links)}"
    raise LiveError(problem, file=file, place=place, value=text, remedy=remedy)


def numbered_taxel(number: int, skin: Skin, *, place: str, file: Path) -> int:
    """Return the number of a taxel in a file; raises LiveError if the skin has no such taxel."""
    if not 0 <= number < len(skin):
        remedy = f"Give its number (taxel), 0 to {len(skin) - 1}"
        raise LiveError("unknown taxel", file=file, place=place, value=number, remedy=remedy)
    return number


def taxel_in_row(cells: Sequence[str], columns: Mapping[str, int], skin: Skin, file: Path, line: int) -> int:
    """Return the taxel of a row of a table by its column ``taxel``, or else ``id``; raises LiveError."""
    place = f"line {line}"
    if "taxel" in columns:
        number = whole_number(cells[columns["taxel"]], file, line, "taxel")
        return numbered_taxel(number, skin, place=place, file=file)
    return taxel_of(cells[columns["id"]], skin, place=place, file=file)


def load_matching(path: str | Path, skin: Skin) -> dict[int, int]:
    """Read taxel numbers by the stream's id from a CSV table with the columns ``id`` (as sent) and ``taxel``: its
    number, or ``link:id``.

    Raises:
        LiveError: The table cannot be read, or names an unknown taxel.
    """
    found: dict[int, int] = {}
    file = Path(path)
    for line, row in read_rows(file, ("id", "taxel")):
        number = whole_number(row["id"], file, line, "id")
        name = "id" if ":" in row["taxel"] else "taxel"
        taxel = taxel_in_row([row["taxel"]], {name: 0}, skin, file, line)
        if found.setdefault(number, taxel) != taxel:
            raise LiveError("an id is assigned to two taxels", file=file, place=f"line {line}", value=number)
    return found
