"""Calibration of taxels: pressure = gain (value - offset - baseline), or gain times a curve of that change.

Gains, offsets and curves come from a file. The baseline is measured on the untouched skin (tare). If no gain is known,
a known weight on the skin gives one gain for all taxels, and ``force_calibration`` fits curves to a log.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np

from tactile_maps.contacts.detection.detection import NOISE_LIMIT
from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray, length
from tactile_maps.core.errors import LiveError
from tactile_maps.core.files import write_atomically
from tactile_maps.live.channels.matching import numbered_taxel, taxel_of
from tactile_maps.live.readings.readings import Unit
from tactile_maps.live.readings.tables import read_rows, read_toml, whole_number
from tactile_maps.skin.model.skin import Skin

GRAVITY = 9.80665
SHOWN_AS = 1000.0
"""Pressure [Pa] that displays one count of an uncalibrated skin; forces are meaningless then."""
_LARGEST_GAIN = 1e9
_LARGEST_CONDITION = 1e6
"""Condition number from which a matrix counts as singular: noise would be amplified as much."""


class FallingReadingsError(LiveError):
    """Readings that fall under a weight: the gain of the sensors is negative, or the skin was touched in the tare."""


class ValueMode(StrEnum):
    """Quantity that is displayed and from which contacts are detected."""

    RAW = "raw"
    BASELINE = "baseline"
    PRESSURE = "kPa"


@dataclass(frozen=True, eq=False)
class Calibration(ArrayFields):
    """Gain, offset and optionally curve of n taxels.

    Attributes:
        gain: (n,) pascals for each unit of the readings; negative where values fall under pressure, never 0. With
            curves, a factor of their pressures, 1 or -1 as fitted.
        offset: (n,) value of the untouched taxel, in the readings' unit.
        known: Whether the gains were measured; otherwise they only make values visible.
        curve: (n, 2, k) k points of each taxel's curve: changes of the reading in the direction of pressure, and
            pressures [Pa] at gain 1. Both increase, from 0. None if pressure is proportional to the change.
        deviation: (n,) standard deviation of the pressure in the log to which it was fitted [Pa], NaN where unknown;
            None if not measured.
        matrix: (n, 3, 3) matrix of each taxel with three axes: its changes of the three channels become pressure and
            shear along t1 and t2, to which gain and curve then apply. Its inverse is the cross-talk of the channels.
            None if all channels are independent.

    Raises:
        LiveError: A number is not finite, a gain is 0 or implausibly large, a curve does not increase from 0, or a
            matrix is singular.
    """

    gain: FloatArray
    offset: FloatArray
    known: bool = True
    curve: FloatArray | None = None
    deviation: FloatArray | None = None
    matrix: FloatArray | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, values in (("gain", self.gain), ("offset", self.offset)):
            bad = ~np.isfinite(values) | (np.abs(values) > _LARGEST_GAIN)
            if name == "gain":
                bad |= values == 0
            if bad.any():
                taxel = int(bad.argmax())
                problem = "invalid number in a calibration"
                raise LiveError(problem, place=f"{name}, taxel {taxel}", value=values[taxel], remedy="Measure it again")
        if self.curve is not None:
            _check_curve(self.curve, len(self.gain))
        if self.matrix is not None:
            _check_matrix(self.matrix, len(self.gain))

    @classmethod
    def plain(cls, taxels: int, unit: Unit) -> Calibration:
        """Return the default calibration for readings in ``unit`` of a skin without calibration."""
        scale = unit.pascals
        return cls(np.full(taxels, scale or SHOWN_AS), np.zeros(taxels), scale is not None)

    @property
    def inverted(self) -> Calibration:
        """Calibration with the opposite sign of the gains, for values that fall under pressure."""
        return replace(self, gain=-self.gain)

    def values(self, readings: FloatArray, baseline: FloatArray, mode: ValueMode) -> FloatArray:
        """Return the displayed values (n,) [Pa] of readings (n,).

        ``raw`` and ``baseline`` show one unit of the readings as 1 kPa, or unchanged if the unit is a pressure. Only
        ``kPa`` applies the gain, and ``baseline`` its sign. Negative values (suction) are kept.
        """
        if mode is ValueMode.PRESSURE:
            return self.pressures(readings - self.offset - baseline)
        return np.sign(self.gain) * (readings - baseline) if mode is ValueMode.BASELINE else readings

    @property
    def slope(self) -> FloatArray:
        """(n,) pascals for each unit of the readings near the untouched state, with the sign of the gain."""
        if self.curve is None:
            return self.gain
        return np.asarray(self.gain * self.curve[:, 1, 1] / self.curve[:, 0, 1])

    def independent(self, change: FloatArray, shear: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the changes (n,) against and (n, 2) along the skin after the matrices; those given without any."""
        if self.matrix is None:
            return change, shear
        found = np.einsum("nij,nj->ni", self.matrix, np.column_stack([change, shear]))
        return found[:, 0], found[:, 1:]

    def pressures(self, change: FloatArray) -> FloatArray:
        """Return the pressures (n,) [Pa] at changes (n,) of the readings; beyond a curve its last slopes continue."""
        if self.curve is None:
            return self.gain * change
        return np.abs(self.gain) * on_curves(self.curve, np.sign(self.gain) * change)

    def with_weight(
        self,
        change: FloatArray,
        areas: FloatArray,
        mass: float,
        *,
        taxels: IntArray | None = None,
        noise: FloatArray | None = None,
    ) -> Calibration:
        """Return a calibration with gains scaled so that the load on the skin has the weight ``mass``.

        With ``taxels``, only their readings count and only their gains change. If no gain was measured before, all
        gains are scaled. The force must exceed that of one reading's noise by ``NOISE_LIMIT`` standard deviations.
        A mean of many readings has less noise, which leaves room for drift.

        Args:
            change: (n,) values above those of the untouched skin, in the readings' unit.
            areas: (n,) areas of the taxels [m²].
            mass: Mass of the weight [kg].
            taxels: (k,) taxels under the weight; None for any.
            noise: (n,) standard deviations of the untouched taxels, in the readings' unit; None if unknown.

        Raises:
            FallingReadingsError: The readings fall under the weight.
            LiveError: The mass is out of range, or the readings do not change under the weight by more than noise.
        """
        check_mass(mass)
        under: IntArray | slice = slice(None) if taxels is None else taxels
        force = float((self.pressures(change) * areas)[under].sum())
        found = f"{force:.3g} N" if self.known else None
        deviation = 0.0 if noise is None else length((self.slope * areas * noise)[under])
        if 0 < abs(force) < NOISE_LIMIT * deviation:
            remedy = (
                "Put the weight on the skin; select the taxels under a light weight, so that only their noise counts"
            )
            ratio = (
                f"{abs(force) / deviation:.1f} of the {NOISE_LIMIT:g} standard deviations of noise that are required"
            )
            raise LiveError("nothing seems to rest on the skin", value=ratio, remedy=remedy)
        if force < 0:
            remedy = (
                "Check that nothing touched the skin during the tare. Where values fall under pressure, "
                "the gain is negative: add --inverted, or apply it in the dialog of the weight"
            )
            raise FallingReadingsError("the readings fall under the weight", value=found, remedy=remedy)
        if not force > 0:
            remedy = "Tare the skin while nothing touches it, then put the weight on it"
            raise LiveError("the readings do not change under the weight", value=found, remedy=remedy)
        gain = self.gain.copy()
        gain[under if self.known else slice(None)] *= mass * GRAVITY / force
        return replace(self, gain=gain, known=True)


def on_curves(curves: FloatArray, values: FloatArray) -> FloatArray:
    """Return (n,) the value of each of n piecewise linear curves (n, 2, k) at ``values`` (n,).

    Beyond the points of a curve its first and last slopes continue. Cost: 0.2 ms for 5,000 curves of 12 points.
    """
    start = (values[:, None] >= curves[:, 0, 1:-1]).sum(axis=1)
    rows = np.arange(len(values))
    x, y = curves[rows, :, start].T
    next_x, next_y = curves[rows, :, start + 1].T
    return np.asarray(y + (values - x) * (next_y - y) / (next_x - x))


def _check_curve(curve: FloatArray, taxels: int) -> None:
    """Raise LiveError unless ``curve`` (taxels, 2, k) has two points or more that increase from 0."""
    if curve.shape[:2] != (taxels, 2) or curve.shape[2:] < (2,):
        raise LiveError("the curves of a calibration have a wrong shape", place="curve", value=curve.shape)
    with np.errstate(all="ignore"):
        slope = np.diff(curve[:, 1]) / np.diff(curve[:, 0])
        good = (curve[:, :, 0] == 0).all(axis=1) & (np.diff(curve) > 0).all(axis=(1, 2))
        good &= (slope < _LARGEST_GAIN).all(axis=1)
    if not good.all():
        taxel = int(good.argmin())
        found = " ".join(f"{x:g}:{y:g}" for x, y in curve[taxel].T)
        remedy = "Give points change:pressure that both increase from 0:0"
        raise LiveError("a curve does not increase from 0", place=f"points, taxel {taxel}", value=found, remedy=remedy)


def _check_matrix(matrix: FloatArray, taxels: int) -> None:
    """Raise LiveError unless ``matrix`` (taxels, 3, 3) is finite and invertible for every taxel."""
    if matrix.shape != (taxels, 3, 3):
        raise LiveError("the matrices of a calibration have a wrong shape", place="matrix", value=matrix.shape)
    remedy = "Give nine finite numbers, row by row, of channels that differ from each other"
    finite = np.asarray((np.abs(matrix) <= _LARGEST_GAIN).all(axis=(1, 2)))
    singular = np.linalg.cond(np.where(finite[:, None, None], matrix, np.eye(3))) > _LARGEST_CONDITION
    for problem, bad in (("invalid number in a calibration", ~finite), ("a matrix is singular", singular)):
        if bad.any():
            taxel = int(bad.argmax())
            found = " ".join(f"{one:g}" for one in matrix[taxel].ravel())
            raise LiveError(problem, place=f"matrix, taxel {taxel}", value=found, remedy=remedy)


def check_mass(mass: float) -> None:
    """Raise LiveError for a mass [kg] that is out of range."""
    if not (math.isfinite(mass) and 0 < mass < 1000):
        raise LiveError("the weight is out of range", value=f"{mass} kg", remedy="Choose above 0 and below 1000 kg")


def load_calibration(path: str | Path, skin: Skin) -> Calibration:
    """Read a calibration from CSV (``id`` or ``taxel``, ``gain``, ``offset``; every taxel needs a row) or TOML.

    TOML: ``gain`` and ``offset`` for all taxels, and ``[[taxel]]`` tables with ``id`` or ``taxel`` for single ones.
    An id that several links have is ``link:id``. Taxels with three axes may have a ``matrix``: nine numbers as text,
    row by row, that turn the changes of the channels into p, t1 and t2, with ``gain`` as a factor. Optional are
    ``points``, a curve as text ``0:0 120:800 400:4000`` of
    changes of the reading and pressures [Pa], which the gain multiplies, and ``deviation`` [Pa].

    Args:
        path: The file; gains in Pa per unit of the readings, offsets in that unit.
        skin: Skin of the named taxels.

    Raises:
        LiveError: The file cannot be read, or names an unknown taxel.
    """
    file = Path(path)
    if file.suffix.lower() == ".toml":
        return _from_toml(file, skin)
    rows = [
        (f"line {line}", {name: _cell(text, file, line, name) for name, text in row.items() if text != ""})
        for line, row in read_rows(file, ("gain",))
    ]
    return _of_rows(file, skin, rows, gain=None, offset=0.0)


def save_calibration(calibration: Calibration, path: str | Path) -> None:
    """Write a calibration as CSV by taxel number.

    Raises:
        LiveError: The file cannot be written.
    """
    columns: dict[str, Iterable[str]] = {
        "gain": map(repr, calibration.gain.tolist()),
        "offset": map(repr, calibration.offset.tolist()),
    }
    if calibration.curve is not None:
        columns["points"] = map(_points_text, calibration.curve)
    if calibration.matrix is not None:
        columns["matrix"] = (" ".join(map(repr, one.ravel().tolist())) for one in calibration.matrix)
    if calibration.deviation is not None:
        columns["deviation"] = ("" if math.isnan(one) else repr(one) for one in calibration.deviation.tolist())
    rows = (",".join((str(taxel), *cells)) for taxel, cells in enumerate(zip(*columns.values(), strict=True)))
    write_atomically(Path(path), "\n".join([",".join(("taxel", *columns)), *rows, ""]).encode(), error=LiveError)


def _points_text(curve: FloatArray) -> str:
    return " ".join(f"{change!r}:{pressure!r}" for change, pressure in curve.T.tolist())


def _points(text: object, path: Path, place: str) -> FloatArray:
    """Return the points (2, k) of a curve in a file."""
    try:
        pairs = [tuple(map(float, word.split(":"))) for word in str(text).split()]
        points = np.array(pairs).T
    except ValueError:
        points = np.zeros(0)
    if points.ndim != 2 or points.shape[0] != 2 or points.shape[1] < 2:
        remedy = "Write at least two points change:pressure, such as 0:0 400:4000"
        raise LiveError("expected the points of a curve", file=path, place=place, value=text, remedy=remedy)
    return points


def _matrix(text: object, path: Path, place: str, *, axes: int) -> FloatArray:
    """Return the matrix (3, 3) of a taxel with ``axes`` in a file."""
    remedy = "Write nine numbers row by row, such as 2 0 0 0 1 0 0 0 1"
    try:
        numbers = np.array([float(word) for word in str(text).split()])
    except ValueError:
        numbers = np.zeros(0)
    if numbers.shape != (9,):
        raise LiveError("expected a matrix", file=path, place=place, value=text, remedy=remedy)
    matrix = numbers.reshape(3, 3)
    if axes != 3 and (matrix != np.eye(3)).any():
        remedy = "Leave its matrix out, or state three axes in the skin"
        raise LiveError("a taxel with one axis has no matrix", file=path, place=place, value=text, remedy=remedy)
    return matrix


def padded(curves: Sequence[FloatArray]) -> FloatArray:
    """Return n curves (2, k), of different lengths, as one array (n, 2, k): their last slopes continue."""
    most = max(one.shape[1] for one in curves)
    steps = (np.arange(1, most - one.shape[1] + 1) for one in curves)
    pairs = zip(curves, steps, strict=True)
    return np.array([np.hstack([one, one[:, -1:] + more * (one[:, -1:] - one[:, -2:-1])]) for one, more in pairs])


def _cell(text: str, path: Path, line: int, column: str) -> float | int | str:
    if column in ("points", "matrix") or (column == "id" and ":" in text):
        return text
    if column in ("id", "taxel"):
        return whole_number(text, path, line, column)
    try:
        return float(text)
    except ValueError as error:
        raise LiveError("expected a number", file=path, place=f"line {line}, {column}", value=text) from error


def _from_toml(path: Path, skin: Skin) -> Calibration:
    table = read_toml(path)
    if more := table.keys() - {"gain", "offset", "taxel"}:
        raise LiveError("unknown key", file=path, place=min(more), remedy="Allowed keys: gain, offset, taxel")
    entries = table.get("taxel", [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise LiveError("expected tables", file=path, place="taxel", remedy="Write [[taxel]] above each of them")
    rows = [(f"taxel {number}", entry) for number, entry in enumerate(entries, start=1)]
    offset = _toml_number(path, table, "offset") or 0.0
    return _of_rows(path, skin, rows, gain=_toml_number(path, table, "gain"), offset=offset)


def _toml_number(path: Path, table: Mapping[str, Any], key: str) -> float | None:
    value = table.get(key)
    if value is not None and (isinstance(value, bool) or not isinstance(value, int | float)):
        raise LiveError("expected a number", file=path, place=key, value=value)
    return None if value is None else float(value)


def _of_rows(
    path: Path, skin: Skin, rows: list[tuple[str, dict[str, Any]]], *, gain: float | None, offset: float
) -> Calibration:
    gains = np.full(len(skin), 1.0 if gain is None else gain)
    offsets = np.full(len(skin), offset)
    deviations = np.full(len(skin), np.nan)
    points: dict[int, FloatArray] = {}
    matrices: dict[int, FloatArray] = {}
    seen: set[int] = set()
    for place, row in rows:
        if more := row.keys() - {"id", "taxel", "gain", "offset", "points", "deviation", "matrix"}:
            remedy = "Allowed columns: id or taxel, gain, offset, points, deviation, matrix"
            raise LiveError("unknown column", file=path, place=place, value=min(more), remedy=remedy)
        taxel = _taxel(path, place, row, skin)
        if taxel in seen:
            raise LiveError("a taxel is calibrated twice", file=path, place=place, value=taxel)
        seen.add(taxel)
        for name, values in (("gain", gains), ("offset", offsets), ("deviation", deviations)):
            value = _toml_number(path, row, name)
            if value is not None:
                values[taxel] = value
        if "points" in row:
            points[taxel] = _points(row["points"], path, f"{place}, points")
        if "matrix" in row:
            where = f"{place}, matrix of {skin.taxel_text(taxel)}"
            matrices[taxel] = _matrix(row["matrix"], path, where, axes=int(skin.axes[taxel]))
    if gain is None and len(seen) < len(skin):
        found = f"{len(seen)} of {len(skin)}"
        remedy = "Name every taxel, or in TOML a gain for all others"
        raise LiveError("some taxels have no gain", file=path, value=found, remedy=remedy)
    try:
        measured = None if np.isnan(deviations).all() else deviations
        proportional = np.array([[0.0, 1.0], [0.0, 1.0]])
        curve = padded([points.get(taxel, proportional) for taxel in range(len(skin))]) if points else None
        matrix = np.array([matrices.get(taxel, np.eye(3)) for taxel in range(len(skin))]) if matrices else None
        return Calibration(gains, offsets, curve=curve, deviation=measured, matrix=matrix)
    except LiveError as error:
        raise error.at(file=path) from error


def _taxel(path: Path, place: str, row: Mapping[str, Any], skin: Skin) -> int:
    number = row.get("taxel", row.get("id"))
    by_id = "taxel" not in row
    if isinstance(number, bool) or not isinstance(number, int | str if by_id else int):
        raise LiveError("the row names no taxel", file=path, place=place, value=number, remedy="Give its id or taxel")
    if by_id:
        return taxel_of(str(number), skin, place=place, file=path)
    return numbered_taxel(int(number), skin, place=place, file=path)
