"""iCub skin positions files (.txt): read with all known defects counted, and written.

The format is that of iCubSkinGui (robotology/icub-main, app/skinGui/conf/positions): a few named values, then one row
``x y z [nx ny nz]`` per taxel, in metres in the link frame. Twelve rows are a triangular module. ``taxel2Repr`` lists
for each taxel the one that represents its module, -1 if the pad is not fitted and -2 if it measures temperature. An
older form has rows only. All rows are read here; the original program loses the last one, so zero rows are appended.

``read_position_rows`` parses and checks the lines, once for files of the same content; ``read_icub_positions``
interprets them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import Finding, SkinError, add_finding, errors_in_file
from tactile_maps.core.files import read_bounded_text, write_lines
from tactile_maps.skin.model.skin import number_ranges
from tactile_maps.skin.model.taxel_set import (
    MAX_COORDINATE,
    MAX_TAXELS,
    TaxelSet,
    is_number,
    line_error,
    unit_normals,
)

ROWS_PER_MODULE = 12
THERMAL_PADS = (6, 10)
THERMAL = -2
UNFITTED = -1
FITTED = 0
UNKNOWN = 1
"""States of a row; the first two are written in the list ``taxel2Repr``."""
REPRESENTATIVE_PAD = 3
"""The pad in the middle of its module."""
COINCIDENT_DISTANCE = 1e-5
"""Distance [m] below which taxels are the same one: the files state tenths of a millimetre."""
_MAX_PLANE_OFFSET = 1e-3
"""Thickness of a set of taxels [m] above which one normal for all of them is a dummy."""


def read_icub_positions(path: str | Path) -> TaxelSet:
    """Return the usable taxels of a positions file; ids are rows of the file, channels rows of a module.

    Raises:
        SkinError: The file cannot be read, or a line is invalid; names the line and the value.
    """
    path = Path(path)
    rows = read_position_rows(path)
    findings: list[Finding] = []
    usable = _fitted(rows, path, findings)
    number = np.flatnonzero(usable)
    first, place = _places(rows.values[number, :3])
    merged = np.setdiff1d(np.arange(len(number)), first)
    action = "merged with another at the same position, which also receives the readings of rows "
    add_finding(findings, "duplicate-taxel", path.name, action + number_ranges(number[merged]), len(merged))
    aliases = np.column_stack([number, place])[merged]
    number = number[first]
    if not len(number):
        raise SkinError(
            "the file has no usable taxel",
            file=path,
            value=f"{len(rows.values)} rows",
            remedy="Choose a positions file with rows that are not all zero",
        )
    positions = rows.values[number, :3]
    normals = _normals(positions, rows.values[number, 3:], path, findings)
    with errors_in_file(path):
        return TaxelSet(
            path.stem,
            rows.name,
            number,
            positions,
            normals,
            modules=number // ROWS_PER_MODULE,
            ids=number,
            channels=number % ROWS_PER_MODULE,
            aliases=aliases if len(aliases) else None,
            stream=len(rows.values),
            findings=tuple(findings),
        )


def write_icub_positions(taxels: TaxelSet, path: str | Path) -> None:
    """Write ``taxels`` as a positions file, each in the row of its id; the other rows are zero and not fitted.

    Raises:
        SkinError: A taxel has three axes, an id is too large or repeated, a taxel would look like an unused row, or
            the file cannot be written.
    """
    path = Path(path)
    if taxels.axes is not None:
        problem = "this format has no axes of taxels"
        count = int((taxels.axes > 1).sum())
        remedy = "Write .csv, .json or .npz, or remove the axes first"
        raise SkinError(problem, file=path, value=f"{count} taxels with three axes", remedy=remedy)
    ids = taxels.stated_ids
    row_of = np.arange(len(ids))
    if taxels.aliases is not None:
        ids = np.concatenate([ids, taxels.aliases[:, 0]])
        row_of = np.concatenate([row_of, taxels.aliases[:, 1]])
    problem = "a taxel's number is its row in this format"
    if ids.max() >= MAX_ROWS:
        raise SkinError(problem, file=path, value=int(ids.max()), remedy="Renumber the taxels, or write .csv")
    values, counts = np.unique(ids, return_counts=True)
    if (counts > 1).any():
        repeated = f"{number_ranges(values[counts > 1])} are repeated"
        raise SkinError(problem, file=path, value=repeated, remedy="Write .csv, which keeps repeated ids")
    count = ROWS_PER_MODULE * (int(ids.max()) // ROWS_PER_MODULE + 2)
    if taxels.stream is not None and taxels.stream > ids.max() + 1:
        count = min(taxels.stream, MAX_ROWS)  # its last row is not used
    rows = np.zeros((count, 6))
    rows[ids, :3] = taxels.positions[row_of]
    if taxels.normals is not None:
        rows[ids, 3:] = taxels.normals[row_of]
    if not rows[ids].any(axis=1).all():
        raise SkinError("a taxel at the origin without a normal would read as unused", file=path)
    lines = [f"name {' '.join((taxels.link or '').split())}".rstrip(), "spatial_sampling taxel"]
    lines += [f"taxel2Repr ( {' '.join(map(str, _representatives(ids, count).tolist()))} )", "[calibration]"]
    lines += [" ".join(map(repr, row)) for row in rows.tolist()]
    write_lines(path, lines, error=SkinError)


def _representatives(numbers: IntArray, count: int) -> IntArray:
    """Return the list ``taxel2Repr``: the middle pad of the module, or its first taxel if that pad has none."""
    listed = np.full(count, UNFITTED)
    listed[np.flatnonzero(np.isin(np.arange(count) % ROWS_PER_MODULE, THERMAL_PADS))] = THERMAL
    numbers = np.sort(numbers)
    modules, first = np.unique(numbers // ROWS_PER_MODULE, return_index=True)
    middle = modules * ROWS_PER_MODULE + REPRESENTATIVE_PAD
    chosen = np.where(np.isin(middle, numbers), middle, numbers[first])
    listed[numbers] = chosen[np.searchsorted(modules, numbers // ROWS_PER_MODULE)]
    return listed


def _fitted(rows: PositionRows, path: Path, findings: list[Finding]) -> BoolArray:
    """Return (n,) whether each row has a tactile taxel: fitted according to the list, not thermal, not all zero."""
    where = path.name
    count = len(rows.values)
    placed = (rows.values != 0).any(axis=1)
    state = _states(rows)
    listed = 0 if rows.representatives is None else len(rows.representatives)
    if listed:
        action = f"taxel2Repr has {listed} entries for {count} rows; rows without an entry are fitted if not zero"
        add_finding(findings, "list-length", where, action, abs(listed - count))
    left_out = {
        "unused-row": ("the row is all zero", ~placed),
        "thermal-pad": ("it measures temperature", placed & (state == THERMAL)),
        "unfitted-taxel": (
            "it has a position, but is not fitted according to taxel2Repr",
            placed & (state == UNFITTED),
        ),
        "missing-position": ("fitted according to taxel2Repr, but its row is all zero", ~placed & (state == FITTED)),
    }
    for kind, (reason, which) in left_out.items():
        add_finding(findings, kind, where, f"left out: {reason}", int(which.sum()))
    return np.asarray(placed & ((state == FITTED) | (state == UNKNOWN)))


def _states(rows: PositionRows) -> IntArray:
    """Return (n,) the state of each row: FITTED, UNFITTED, THERMAL, or UNKNOWN beyond the end of the list."""
    count = len(rows.values)
    state = np.full(count, UNKNOWN)
    if rows.representatives is not None:
        listed = rows.representatives[:count]
        state[: len(listed)] = np.where(listed >= 0, FITTED, listed)
    if count % ROWS_PER_MODULE == 0:
        # Older files list thermal pads as -1 or not at all; they are known by their position in the module.
        pad = np.isin(np.arange(count) % ROWS_PER_MODULE, THERMAL_PADS)
        state[pad & (state != FITTED)] = THERMAL
    return state


def _places(positions: FloatArray) -> tuple[IntArray, IntArray]:
    """Return (k,) the first taxel at each position, in their order, and (n,) the position of each taxel."""
    places = np.rint(positions / COINCIDENT_DISTANCE)
    _, first, place = np.unique(places, axis=0, return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(first))
    return np.sort(first), rank[place.reshape(-1)]


def _normals(positions: FloatArray, normals: FloatArray, path: Path, findings: list[Finding]) -> FloatArray | None:
    """Return unit normals; None if they are missing, or the same dummy for all taxels."""
    if not normals.shape[1]:
        return None
    same = bool((normals == normals[0]).all())
    if same and normals[0].any() and np.ptp(positions @ (normals[0] / np.linalg.norm(normals[0]))) > _MAX_PLANE_OFFSET:
        action = "not used: one normal for taxels that are not in one plane"
        add_finding(findings, "dummy-normals", path.name, action, len(normals))
        return None
    return unit_normals(normals, path.name, findings)


MAX_BYTES = 16 * 2**20
MAX_ROWS = MAX_TAXELS


@dataclass(frozen=True, eq=False)
class PositionRows(ArrayFields):
    """Parsed lines of a positions file.

    Attributes:
        name: Name of the link, or None.
        representatives: The list ``taxel2Repr``, or None.
        values: (n, 6) or (n, 3), finite.
    """

    name: str | None
    representatives: IntArray | None
    values: FloatArray


def read_position_rows(path: Path) -> PositionRows:
    """Read the file at ``path``; tabs and spaces separate words.

    Raises:
        SkinError: The file cannot be read, or a line is invalid.
    """
    text = read_bounded_text(path, most=MAX_BYTES, error=SkinError)
    with errors_in_file(path):
        return _parsed(text)


@lru_cache(maxsize=32)  # a folder with all files of an iCub has 27
def _parsed(text: str) -> PositionRows:
    name: str | None = None
    representatives: IntArray | None = None
    rows = list[list[float]]()
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split()
        if not words or words[0].startswith(("//", "#", "[")):
            continue
        if rows or is_number(words[0]):
            rows.append(_row(words, rows, number))
        elif words[0] == "name":
            name = " ".join(words[1:]) or None
        elif words[0] == "taxel2Repr":
            representatives = _representatives_list(line, number)
    if not rows:
        raise SkinError("the file has no taxel rows", remedy="Choose an iCub skin positions file")
    most = max(len(rows), 0 if representatives is None else len(representatives))
    if representatives is not None and (representatives >= most).any():
        remedy = f"The file has {len(rows)} rows"
        problem = "taxel2Repr names a taxel that does not exist"
        raise SkinError(problem, place="taxel2Repr", value=int(representatives.max()), remedy=remedy)
    return PositionRows(name, representatives, np.array(rows))


def _row(words: list[str], rows: list[list[float]], number: int) -> list[float]:
    line = " ".join(words)
    if len(words) not in (3, 6) or not all(map(is_number, words)):
        raise line_error("a row must be 3 or 6 numbers", number, line)
    if rows and len(words) != len(rows[0]):
        raise line_error(f"the rows before have {len(rows[0])} numbers", number, line)
    if len(rows) >= MAX_ROWS:
        raise line_error(f"more than {MAX_ROWS} rows", number, None)
    row = [float(word) for word in words]
    if not np.isfinite(row).all():
        raise line_error("a number is not finite", number, line)
    if max(map(abs, row[:3])) > MAX_COORDINATE:
        problem = f"a taxel is more than {MAX_COORDINATE:g} m from its link; positions are in metres"
        raise line_error(problem, number, line)
    return row


def _representatives_list(line: str, number: int) -> IntArray:
    """Return the whole numbers between the brackets, each -2 or more."""
    inside = line.split("taxel2Repr", 1)[1].strip()
    if not (inside.startswith("(") and inside.endswith(")")):
        raise line_error("taxel2Repr must be a list in brackets", number, inside)
    words = inside[1:-1].split()
    for word in words:
        if not word.removeprefix("-").isdecimal() or len(word) > 9 or int(word) < -2:
            raise line_error("an entry of taxel2Repr is not a taxel number, -1 or -2", number, word)
    if len(words) > MAX_ROWS:
        raise line_error(f"taxel2Repr has more than {MAX_ROWS} entries", number, len(words))
    return np.array([int(word) for word in words], dtype=np.int64)
