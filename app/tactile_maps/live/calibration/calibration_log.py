"""Logs of a calibration: known loads and the readings under them, as a CSV table.

A column states the load: ``force`` [N], ``mass`` [kg] or ``pressure`` [Pa], or with a unit, such as ``force_mN``,
``mass_g``, ``pressure_kPa``. The readings are in one of two forms:

- one per row: ``reading``, and the taxel by its number (``taxel``), its ``id`` (or ``link:id``), or the place that was
  pressed: ``x``, ``y``, ``z`` [m] (or ``x_mm``, ...) and, where the skin has several links, ``link``;
- one column for each taxel, by id (``87012``, ``l_hand:12``) or module and channel (``14.3``). An empty cell is a taxel
  that did not report.

Rows are in the order of the measurement. Columns ``time`` and ``sequence`` are ignored.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import compress
from pathlib import Path

import numpy as np

from tactile_maps.core.arrays import ArrayFields, FloatArray
from tactile_maps.core.errors import LiveError
from tactile_maps.live.calibration.calibration import GRAVITY
from tactile_maps.live.channels.matching import TaxelMatcher, taxel_in_row
from tactile_maps.live.readings.readings import Reading, Unit, labels_of
from tactile_maps.live.readings.tables import decimal_number, read_cells
from tactile_maps.skin.model.skin import Skin

_LOAD = re.compile(r"(force|load|fz|mass|weight|pressure)(?:[ _]*[\[(]?(n|mn|kg|g|pa|kpa)[\])]?)?")
_USUAL_UNIT = {"force": "n", "load": "n", "fz": "n", "mass": "kg", "weight": "kg", "pressure": "pa"}
_UNITS = {"n": 1.0, "mn": 1e-3, "kg": GRAVITY, "g": 1e-3 * GRAVITY, "pa": 1.0, "kpa": 1e3}
PLACE_COLUMN = re.compile(r"([xyz])(?:[ _]*[\[(]?(m|mm)[\])]?)?")
_READING = ("reading", "value", "raw", "counts")
_IGNORED = ("time", "timestamp", "stamp", "t", "time_ms", "sequence")
TAXEL_ID = re.compile(r"(?:[^:]+:)?\d{1,18}")
TAXEL_CHANNEL = re.compile(r"(\d{1,18})\.(\d{1,18})")
_COLUMNS = (
    "Columns are a load (force, mass_g, pressure_kPa), and reading with taxel, id or x, y, z, "
    "or a column for each taxel by id or module.channel"
)


@dataclass(frozen=True, eq=False)
class CalibrationLog(ArrayFields):
    """Loads and the readings under them, in the order of the measurement.

    Attributes:
        loads: (m,) forces on the whole skin [N], or pressures on each of its taxels [Pa].
        readings: (m, taxels) readings in the unit of the sensors; NaN where none was logged.
        pressure: Whether the loads are pressures.

    Raises:
        LiveError: There are no rows, a load is not finite, or loads are negative.
    """

    loads: FloatArray
    readings: FloatArray
    pressure: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if not len(self.loads) or self.readings.shape[:1] != self.loads.shape:
            raise LiveError("the log has no rows, or not a load for each", value=self.readings.shape)
        if not np.isfinite(self.loads).all():
            row = int(np.isfinite(self.loads).argmin())
            raise LiveError("a load is not finite", place=f"row {row}", value=self.loads[row])
        if not self.loads.max() > 0 or -self.loads.min() > 0.05 * self.loads.max():
            found = f"{self.loads.min():g} to {self.loads.max():g}"
            raise LiveError("loads are negative, or all 0", value=found, remedy="State loads that press as positive")


def read_calibration_log(path: str | Path, skin: Skin) -> CalibrationLog:
    """Read a calibration log from CSV; see this module for its columns.

    Args:
        path: The file.
        skin: Skin of the named taxels.

    Raises:
        LiveError: The file cannot be read, a column is unknown or missing, or a row names an unknown taxel or place.
    """
    file = Path(path)
    (_, header), *rows = read_cells(file)
    columns = _Columns.of_header(header, file)
    loads = np.empty(len(rows))
    readings = np.full((len(rows), len(skin)), np.nan)
    matcher = TaxelMatcher(skin)
    for row, (line, cells) in enumerate(rows):
        loads[row] = columns.scale * decimal_number(cells[columns.load], file, line, header[columns.load])
        if columns.reading is not None:
            taxel = columns.taxel(cells, skin, file, line)
            readings[row, taxel] = decimal_number(cells[columns.reading], file, line, header[columns.reading])
        else:
            values = [decimal_number(cells[at], file, line, header[at]) for at in columns.taxels.values()]
            taxels, found = matcher.match(columns.wide(np.array(values)))
            readings[row, taxels] = found
    if wrong := sorted(matcher.unknown | matcher.ambiguous):
        raise LiveError("columns name unknown or ambiguous taxels", file=file, place="header", value=", ".join(wrong))
    try:
        return CalibrationLog(loads, readings, columns.pressure)
    except LiveError as error:
        raise error.at(file=file) from error


@dataclass(frozen=True, eq=False)
class _Columns:
    """Columns of a log by their index.

    Attributes:
        load: Column of the load.
        scale: Newtons or pascals per unit of the load.
        pressure: Whether the load is a pressure.
        reading: Column of the reading; None if each taxel has a column.
        taxels: Columns of the taxels by label.
        names: Columns of ``taxel``, ``id`` and ``link``, as far as there are.
        place: Columns of x, y and z with their scale [m]; empty without.
    """

    load: int
    scale: float
    pressure: bool
    reading: int | None
    taxels: Mapping[str, int]
    names: Mapping[str, int]
    place: Sequence[tuple[int, float]]

    @classmethod
    def of_header(cls, header: Sequence[str], path: Path) -> _Columns:
        lower = [word.lower() for word in header]
        loads = [(at, match) for at, word in enumerate(lower) if (match := _LOAD.fullmatch(word))]
        readings = [at for at, word in enumerate(lower) if word in _READING]
        names = {word: at for at, word in enumerate(lower) if word in ("taxel", "id", "link")}
        places = {match[1]: (at, match[2]) for at, word in enumerate(lower) if (match := PLACE_COLUMN.fullmatch(word))}
        taxels = {
            word: at for at, word in enumerate(header) if TAXEL_ID.fullmatch(word) or TAXEL_CHANNEL.fullmatch(word)
        }
        known = {at for at, _ in (*loads, *places.values())} | {*readings, *names.values(), *taxels.values()}
        for at, word in enumerate(lower):
            if at not in known and word not in _IGNORED:
                raise LiveError("unknown column", file=path, place="header", value=header[at], remedy=_COLUMNS)
        if len(loads) != 1:
            problem = "several columns state the load" if loads else "no column states the load"
            raise LiveError(problem, file=path, place="header", value=", ".join(header), remedy=_COLUMNS)
        named = bool(names.keys() & {"taxel", "id"}) or len(places) == 3
        if not (len(readings) == 1 and named and not taxels) and not (taxels and not readings):
            problem = "the columns do not state the reading of each taxel"
            raise LiveError(problem, file=path, place="header", value=", ".join(header), remedy=_COLUMNS)
        if len({bool(TAXEL_CHANNEL.fullmatch(word)) for word in taxels}) > 1:
            remedy = "Name all taxels by id, or all by module.channel"
            raise LiveError("taxels are named in two ways", file=path, place="header", remedy=remedy)
        ((load, match),) = loads
        unit = match[2] or _USUAL_UNIT[match[1]]
        place = [(at, 1e-3 if unit == "mm" else 1.0) for at, unit in (places[axis] for axis in sorted(places))]
        if names.keys() & {"taxel", "id"}:
            place = []
        return cls(load, _UNITS[unit], unit.endswith("pa"), readings[0] if readings else None, taxels, names, place)

    def wide(self, values: FloatArray) -> Reading:
        """Return the reading of a row with a column for each taxel."""
        there = ~np.isnan(values)
        words = list(compress(self.taxels, there.tolist()))
        if words and TAXEL_CHANNEL.fullmatch(words[0]):
            pairs = [[int(number) for number in word.split(".")] for word in words]
            return Reading(0.0, values[there], Unit.COUNTS, channels=np.array(pairs))
        links, numbers = labels_of(words)
        return Reading(0.0, values[there], Unit.COUNTS, numbers, links=links)

    def taxel(self, cells: Sequence[str], skin: Skin, path: Path, line: int) -> int:
        """Return the taxel of a row, by its number, id or place."""
        if self.names.keys() & {"taxel", "id"}:
            return taxel_in_row(cells, self.names, skin, path, line)
        point = [scale * decimal_number(cells[at], path, line, "place") for at, scale in self.place]
        link = cells[self.names["link"]] if "link" in self.names else None
        try:
            return nearest_taxel(skin, np.array(point), link)
        except LiveError as error:
            raise error.at(file=path, place=f"line {line}") from error


def nearest_taxel(skin: Skin, point: FloatArray, link: str | None = None) -> int:
    """Return the taxel nearest to a point (3,) [m] in the frame of its link.

    Args:
        skin: The skin.
        point: The point.
        link: The link; may be omitted if only one link has skin.

    Raises:
        LiveError: The link is unknown or missing, or no taxel is within two of its own widths.
    """
    if link is None and len(skin.links) > 1:
        raise LiveError("the place names no link", remedy=f"Add a column link: {', '.join(skin.links)}")
    if link is not None and link not in skin.links:
        raise LiveError("a link has no skin", value=link, remedy=f"Links with skin: {', '.join(skin.links)}")
    on_link = np.array([link in (None, patch.link) for patch in skin.patches])[skin.patch_of]
    away = np.where(on_link, np.linalg.norm(skin.positions - point, axis=1), np.inf)
    taxel = int(away.argmin())
    if away[taxel] > 2 * np.sqrt(skin.areas[taxel]):
        found = f"the nearest is {1e3 * away[taxel]:.1f} mm away"
        remedy = "Give places in the frame of the link [m], or name the taxel"
        raise LiveError("no taxel is at the place", value=found, remedy=remedy)
    return taxel
