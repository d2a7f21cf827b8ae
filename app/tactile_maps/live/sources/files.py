"""Recorded readings, played back at their original speed or as fast as they are processed.

A table has one row per reading; commas, semicolons or tabs separate its cells. Its columns: ``time`` [s], also named
``timestamp``, ``stamp`` or ``t`` and with a unit (``time_ms``); optionally ``sequence``; for each taxel its hardware id
(``87012``) or module and channel (``14.3``); ``joint:NAME`` for positions. A first line ``# unit: kPa`` states the
unit. An empty cell means that the taxel sent no value. With three columns per taxel (``87012_x``, ``87012_y``,
``87012_z``), a line ``# component: z`` states which is its value, or ``norm``; with ``xyz``, z is its pressure, x and y
are its shear.
"""

from __future__ import annotations

import csv
import math
import re
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, compress
from pathlib import Path

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray, readonly
from tactile_maps.core.errors import LiveError, install_line
from tactile_maps.core.files import text_encoding
from tactile_maps.live.readings.readings import (
    COMPONENTS,
    MalformedReadingError,
    Reading,
    SourceEndedError,
    Unit,
    labels_of,
    unit_of,
)
from tactile_maps.live.readings.tables import missing_column
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.session.frame import MeasuredValues
from tactile_maps.session.inputs import CalibrationUsed
from tactile_maps.skin.formats.vendors.documents import refuse_decimal_comma, separator_of

Item = Reading | MalformedReadingError
"""A row: a reading, or why it cannot be used."""


class FileSource:
    """Readings of a file at their times. Mutable.

    Args:
        path: The file.
        read: Reads the file and yields its readings.
        speed: Playback speed relative to the recording; None for as fast as possible.
        clock: Wall time [s].
        wait: Waits for a number of seconds.

    Attributes:
        address: The path.
        finite: True.
        slow: Whether opening reads more than the first lines.
    """

    finite = True

    def __init__(
        self,
        path: Path,
        read: Callable[[Path], Iterable[Item]],
        *,
        speed: float | None = 1.0,
        clock: Callable[[], float] = time.monotonic,
        wait: Callable[[float], None] = time.sleep,
    ) -> None:
        self.address = str(path)
        self._path = path
        self._read = read
        self.slow = path.suffix.lower() not in (".csv", ".txt")
        self._speed = speed
        self._clock = clock
        self._wait = wait
        self._items: Iterator[Item] | None = None
        self._next: Item | None = None
        self._start: tuple[float, float] | None = None

    def open(self) -> None:
        """Start at the first reading; raises LiveError if the file cannot be read."""
        items = iter(self._read(self._path))
        first = next(items, None)
        if first is None:
            raise LiveError("the file contains no readings", file=self._path)
        self._items = items
        self._next = first
        self._start = None

    def receive(self, timeout: float) -> Reading | None:
        """Return the next reading when its time has come."""
        if self._items is None:
            raise LiveError("the file is not open", file=self._path)
        item = self._next
        if item is None:
            raise SourceEndedError("the file is read to its end", file=self._path)
        if isinstance(item, Reading) and (early := self._early(item.time)) > 0:
            self._wait(min(early, timeout))
            if early > timeout:
                return None
        self._next = next(self._items, None)
        if isinstance(item, MalformedReadingError):
            raise item
        return item

    def close(self) -> None:
        """Release the file."""
        self._items = self._next = None

    def _early(self, at: float) -> float:
        """Return the time until a reading is due [s]."""
        if self._speed is None:
            return 0.0
        if self._start is None:
            self._start = at, self._clock()
        return (at - self._start[0]) / self._speed - (self._clock() - self._start[1])


def read_recording(path: Path) -> Iterator[Item]:
    """Yield values and posture of a recording of this program: as sent by a real skin, otherwise simulated pressures.

    The first reading of a real skin contains the calibration and baseline at the end of the recording.

    Raises:
        RecordingError: The recording cannot be read.
    """
    player = RecordingPlayer(path)
    names = player.prepared.robot.joint_names
    ids = player.prepared.skin.identity.ids
    ids = ids if ids is not None and len(np.unique(ids)) == len(ids) else None
    one_axis = ~player.prepared.skin.three_axis[:, None]
    used = [found for _, found in player.inputs if isinstance(found, CalibrationUsed)]
    recorded = used[-1] if used else None
    for number, frame in enumerate(player):
        joints = dict(zip(names, frame.posture.tolist(), strict=True))
        if frame.measured is None:
            shear = None if frame.shear is None else np.where(one_axis, np.nan, frame.shear)
            yield Reading(frame.time, frame.pressures, Unit.PASCAL, ids, joints=joints, sequence=number, shear=shear)
        elif frame.measured.sent is not None:
            yield _as_sent(frame.measured, ids, joints, recorded)
            recorded = None


def _as_sent(
    measured: MeasuredValues, ids: IntArray | None, joints: dict[str, float], recorded: CalibrationUsed | None
) -> Item:
    """Return the values of a measured frame with the sender's time and number; taxels without a value are left out."""
    there = ~np.isnan(measured.raw)
    labels = np.arange(len(there)) if ids is None else ids
    assert measured.sent is not None
    return Reading(
        measured.sent,
        measured.raw[there],
        Unit(measured.unit),
        None if there.all() and ids is None else labels[there],
        joints=joints,
        sequence=measured.sequence,
        recorded=recorded,
        shear=None if measured.raw_shear is None else measured.raw_shear[there],
    )


_TIME = re.compile(r"(?:time|timestamp|stamp|t)(?:[ _]*[\[(]?(s|sec|seconds|ms|us|µs|ns)[\])]?)?")
_AXIS = re.compile(r"(.+)[._ ]f?([xyz])")
_SECONDS = {"s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9}
_EPOCHS = ((1e17, 1e-9), (1e14, 1e-6), (1e11, 1e-3))
"""Times from which a clock without a unit counts nanoseconds, microseconds and milliseconds since 1970: in seconds,
these are after the year 5000.
"""


def _scale_of(time: float) -> float:
    """Return the seconds per unit of a time without a stated unit."""
    return next((scale for least, scale in _EPOCHS if abs(time) >= least), 1.0)


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _is_id(word: str) -> bool:
    return word.isdecimal() and len(word) <= 18


@dataclass(frozen=True, eq=False)
class _Columns:
    """Columns of a table by their index.

    Attributes:
        time: Column of the time.
        sequence: Column of the running number; None if there is none.
        seconds: Seconds per unit of the time; None if no unit is stated.
        values: (k,) columns of the taxels, or (k, 3) columns of x, y and z.
        ids: Hardware ids of the taxels; None if they are not named by id.
        links: Links of the ids; None if they are not stated.
        channels: Modules and channels of the taxels; None if they are not named so.
        joints: Columns of joint positions by joint name.
        sheared: Whether z of three columns is the pressure, and x and y the shear; otherwise the value is their norm.
    """

    time: int
    seconds: float | None
    sequence: int | None
    values: IntArray
    ids: list[int] | None
    links: tuple[str, ...] | None
    channels: list[tuple[int, int]] | None
    joints: dict[str, int]
    sheared: bool = False

    @classmethod
    def of_header(cls, names: Sequence[str], path: Path, component: str | None = None) -> _Columns:
        words = [name.strip() for name in names]
        lower = [word.lower() for word in words]
        time, seconds = _time_column(lower, path)
        taxels = [word for at, word in enumerate(words) if at != time and not word.startswith("joint:")]
        vectors = _vectors(words, component, path) if any(_AXIS.fullmatch(word.lower()) for word in taxels) else {}
        ids: dict[str, int] = {}
        channels: dict[tuple[int, int], int] = {}
        joints = {word[len("joint:") :]: at for at, word in enumerate(words) if word.startswith("joint:")}
        skipped = {time} | {at for vector in vectors.values() for at in vector.values()}
        columns = [(at, word) for at, word in enumerate(words) if at not in skipped]
        for at, word in [*columns, *((vector["x"], label) for label, vector in vectors.items())]:
            if lower[at] == "sequence" or word.startswith("joint:"):
                continue
            module, dot, channel = word.partition(".")
            link, colon, number = word.rpartition(":")
            paired = _is_id(module) and _is_id(channel)
            if not (paired if dot and not colon else _is_id(number) and bool(link) == bool(colon)):
                remedy = (
                    "Columns are time, sequence, joint:NAME, and taxels by id (87012, link:12) or module.channel (14.3)"
                )
                raise LiveError("unknown column", file=path, place="header", value=word, remedy=remedy)
            dot = "" if colon else dot
            label = (int(module), int(channel)) if dot else f"{link}{colon}{int(number)}"
            target: dict = channels if dot else ids  # type: ignore[type-arg]
            if target.setdefault(label, at) != at:
                raise LiveError("a taxel has two columns", file=path, place="header", value=word)
        if ids and channels:
            remedy = "Name all taxels by id, or all by module.channel"
            raise LiveError("taxels are named in two ways", file=path, place="header", remedy=remedy)
        try:
            links, numbers = labels_of(list(ids))
        except MalformedReadingError as error:
            raise error.at(kind=LiveError, file=path, place="header") from error
        return cls(
            time,
            seconds,
            lower.index("sequence") if "sequence" in lower else None,
            _value_columns(list(ids.values() or channels.values()), vectors, component),
            numbers.tolist() or None,
            links,
            list(channels) or None,
            joints,
            bool(vectors) and component == "xyz",
        )

    def reading(self, cells: FloatArray, unit: Unit) -> Reading:
        """Return the reading of a row (columns,), NaN where a cell is empty."""
        found = cells[self.values]
        shear = None
        if self.sheared:
            there = np.asarray(~np.isnan(found).all(axis=1))
            values = found[:, 2]
            alone = self.values[:, 0] == self.values[:, 2]
            shear = np.where(alone[:, None], np.nan, found[:, :2])
        else:
            values = np.linalg.norm(found, axis=1) if self.values.ndim == 2 else found
            there = ~np.isnan(values)
        time = float(cells[self.time])
        sequence = None if self.sequence is None else cells[self.sequence]
        if sequence is not None and not (float(sequence).is_integer() and 0 <= sequence < 2**32):
            raise MalformedReadingError("expected a whole number", place="sequence", value=sequence)
        joints = {name: float(cells[at]) for name, at in self.joints.items() if not math.isnan(cells[at])}
        labels = np.array(self.ids if self.ids is not None else self.channels or [])
        labels = labels.reshape(-1, 2) if self.channels is not None else labels
        return Reading(
            time * (_scale_of(time) if self.seconds is None else self.seconds),
            values[there],
            unit,
            None if self.ids is None else labels[there],
            None if self.channels is None else labels[there],
            joints,
            None if sequence is None else int(sequence),
            links=None if self.links is None else tuple(compress(self.links, there.tolist())),
            shear=None if shear is None else shear[there],
        )


def _time_column(names: Sequence[str], path: Path) -> tuple[int, float | None]:
    """Return the column of the time in a header (lower case), and its seconds per unit if the name states a unit.

    Raises:
        LiveError: There is no header, no time, or several.
    """
    found = [(at, match[1]) for at, name in enumerate(names) if (match := _TIME.fullmatch(name))]
    if len(found) == 1:
        at, unit = found[0]
        return at, None if unit is None else _SECONDS[unit]
    if found:
        columns = ", ".join(names[at] for at, _ in found)
        remedy = "Keep one of them"
        raise LiveError("several columns state the time", file=path, place="header", value=columns, remedy=remedy)
    if names and all(map(_is_number, names)):
        remedy = "Add a first line with the names of the columns, such as time,0,1,2"
        raise LiveError("the table has no header", file=path, place="line 1", value=names[0], remedy=remedy)
    if not names:
        raise LiveError("the table is empty", file=path)
    remedy = "The header needs: time (or timestamp, stamp, t, time_ms), then one column per taxel"
    raise missing_column("time", names, path, remedy)


def _vectors(words: Sequence[str], component: str | None, path: Path) -> dict[str, dict[str, int]]:
    """Return the columns of x, y and z by the label of their taxel.

    Raises:
        LiveError: The component that is the value of a taxel is not stated, or a column is missing.
    """
    if component not in COMPONENTS:
        remedy = f"Add a line above the header, such as # component: z (one of {', '.join(COMPONENTS)})"
        problem = "three columns per taxel need a component"
        raise LiveError(problem, file=path, place="component", value=component, remedy=remedy)
    found: dict[str, dict[str, int]] = {}
    for at, word in enumerate(words):
        if match := _AXIS.fullmatch(word.lower()):
            found.setdefault(word[: match.end(1)], {})[match[2]] = at
    for label, columns in found.items():
        if missing := set("xyz") - columns.keys():
            raise missing_column(f"{label}_{min(missing)}", words, path)
    return found


def _value_columns(firsts: list[int], vectors: Mapping[str, Mapping[str, int]], component: str | None) -> IntArray:
    """Return the columns of the values in the order of the taxels, given the column (of x) of each."""
    by_first = {columns["x"]: columns for columns in vectors.values()}
    if not by_first:
        return readonly(firsts, np.int64)
    axes = "xyz" if component == "norm" else str(component)
    found = [[by_first[at][axis] for axis in axes] if at in by_first else [at] * len(axes) for at in firsts]
    return readonly(found if len(axes) == 3 else [one for (one,) in found], np.int64)


def read_table(path: Path) -> Iterator[Item]:
    """Yield the rows of a CSV or Parquet table.

    Raises:
        LiveError: The file or its header cannot be read.
    """
    yield from _read_parquet(path) if path.suffix.lower() == ".parquet" else _read_csv(path)


def _read_csv(path: Path) -> Iterator[Item]:
    try:
        with path.open("rb") as file:
            encoding = text_encoding(file.read(2))
        with path.open(newline="", encoding=encoding) as stream:
            unit = Unit.COUNTS
            component = None
            line = stream.readline()
            number = 1
            while line.startswith("#"):
                key, _, value = line[1:].partition(":")
                unit = unit_of(value.strip()) if key.strip().lower() == "unit" else unit
                component = value.strip() if key.strip().lower() == "component" else component
                line = stream.readline()
                number += 1
            rows = csv.reader(chain([line], stream), delimiter=separator_of(line))
            columns = _Columns.of_header(next(rows, []), path, component)
            used = [columns.time, *columns.values.ravel().tolist(), *columns.joints.values(), columns.sequence or 0]
            width = max(used) + 1
            for place, row in enumerate(rows, start=number + 1):
                if row:
                    yield _item(columns, row, unit, width, f"line {place}")
    except MalformedReadingError as error:
        raise error.at(kind=LiveError, file=path) from error
    except OSError as error:
        raise LiveError("the file cannot be read", file=path, value=error.strerror) from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise LiveError("the file is not a table", file=path, value=error) from error


def _item(columns: _Columns, row: Sequence[str], unit: Unit, width: int, place: str) -> Item:
    try:
        if len(row) < width:
            raise MalformedReadingError("a row is too short", place=place, value=f"{len(row)} columns")
        return columns.reading(_numbers(row, place), unit)
    except MalformedReadingError as error:
        return error


def _numbers(row: Sequence[str], place: str) -> FloatArray:
    """Return the numbers of a row, NaN for empty cells."""
    try:
        return np.array([float(cell) if cell.strip() else np.nan for cell in row])
    except ValueError as error:
        for cell in row:
            refuse_decimal_comma(cell, place=place, error=MalformedReadingError)
        raise MalformedReadingError("expected numbers", place=place, value=error) from error


def _read_parquet(path: Path) -> Iterator[Item]:
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise LiveError(
            "Parquet files need pyarrow", file=path, remedy=f"Install it with: {install_line('pyarrow')}"
        ) from error
    try:
        with pyarrow.parquet.ParquetFile(path) as file:
            metadata = {k.decode(): v.decode(errors="replace") for k, v in (file.schema_arrow.metadata or {}).items()}
            columns = _Columns.of_header(file.schema_arrow.names, path, metadata.get("component"))
            unit = unit_of(metadata.get("unit", "counts"))
            for batch in file.iter_batches(1000):
                cells = np.column_stack([_floats(column, path) for column in batch.columns])
                for row in cells:
                    try:
                        yield columns.reading(row, unit)
                    except MalformedReadingError as error:
                        yield error
    except MalformedReadingError as error:
        raise error.at(kind=LiveError, file=path) from error
    except (OSError, pyarrow.ArrowException) as error:
        raise LiveError("the file cannot be read as Parquet", file=path, value=error) from error


def _floats(column: object, path: Path) -> FloatArray:
    """Return a column as numbers, NaN where it is null."""
    import pyarrow
    import pyarrow.compute

    try:
        cast = pyarrow.compute.cast(column, pyarrow.float64())
        return np.asarray(cast.to_numpy(zero_copy_only=False), dtype=np.float64)
    except pyarrow.ArrowException as error:
        raise LiveError("a column does not contain numbers", file=path, value=error) from error


def read_text(path: Path) -> Iterator[Item]:
    """Yield the readings of a text file of CySkin's acquisition: a line of ids, then on each line a running number, the
    time [s] and one value for each id, in counts.

    Raises:
        LiveError: The file has another format.
    """
    try:
        with path.open(encoding="utf8") as stream:
            words = stream.readline().split()
            if not words or not all(map(_is_id, words)):
                remedy = "Its first line has one hardware id for each value of the lines below"
                raise LiveError("this is not a file of readings", file=path, place="line 1", remedy=remedy)
            ids = [int(word) for word in words]
            columns = _Columns(1, 1.0, 0, readonly(2 + np.arange(len(ids)), np.int64), ids, None, None, {})
            for number, line in enumerate(stream, start=2):
                if cells := line.split():
                    yield _item(columns, cells, Unit.COUNTS, 2 + len(words), f"line {number}")
    except OSError as error:
        raise LiveError("the file cannot be read", file=path, value=error.strerror) from error
    except UnicodeDecodeError as error:
        raise LiveError("the file is not text", file=path) from error
