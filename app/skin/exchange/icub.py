"""Reads iCub taxel positions files (``skinGui/positions/*.txt``), with every defect that real ones have.

A file holds ``name``, ``spatial_sampling``, ``taxel2Repr ( ... )`` and, under ``[calibration]``, one row a taxel:
``x y z nx ny nz`` in metres, link frame; an older form has the rows alone, of three or six numbers. Taxel i is pad
i mod 12 of triangle i div 12; pads 6 and 10 measure temperature; an all-zero row or a negative entry of taxel2Repr is no
taxel. The reference reader drops the last row; this one does not.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.arrays import BoolArray, FloatArray, readonly
from app.errors import Finding, SkinError

_MAX_BYTES = 16_000_000
_PADS = 12
_THERMAL = (6, 10)


@dataclass(frozen=True, eq=False)
class IcubTaxels:
    """The usable taxels of one positions file.

    Attributes:
        link: The name in the file; empty when it has none.
        positions: (n, 3) [m], in the frame the file was made for; no two equal.
        normals: (n, 3) as written, not to be trusted (many files hold one constant for all).
        rows: (n,) row of each taxel in the file, from 0.
        findings: Every defect met, counted.
    """

    link: str
    positions: FloatArray
    normals: FloatArray
    rows: FloatArray
    findings: tuple[Finding, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "positions", readonly(self.positions))
        object.__setattr__(self, "normals", readonly(self.normals))
        object.__setattr__(self, "rows", readonly(self.rows, int))


def read_icub_positions(path: str | Path) -> IcubTaxels:
    """Read a positions file.

    Raises:
        SkinError: It cannot be read, a row is not numbers (the line is named), or no taxel is usable.
    """
    path = Path(path)
    try:
        if path.stat().st_size > _MAX_BYTES:
            raise SkinError("the file is too large for taxel positions", file=path, value=path.stat().st_size)
        text = path.read_text(encoding="utf8")
    except (OSError, UnicodeDecodeError) as error:
        raise SkinError("the taxel file cannot be read", file=path, value=error,
                        remedy="Give an iCub positions file (text)") from error
    name, representative, rows = _parse(text, path)
    if not len(rows):
        raise SkinError("the file has no taxel rows", file=path, remedy="Rows of x y z nx ny nz belong under "
                        "[calibration]")
    return _usable(name, representative, rows, str(path))


def _parse(text: str, path: Path) -> tuple[str, list[int], FloatArray]:
    name, representative, rows = "", [], []
    in_list = False
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.replace("(", " ( ").replace(")", " ) ").split()
        if not words or words[0].startswith(("#", "//", "[")):
            continue
        if words[0] == "name" and len(words) > 1:
            name = words[1].strip('"')
        elif words[0] == "taxel2Repr" or in_list:
            in_list = ")" not in words
            representative += [_integer(word, path, number) for word in words if word not in ("taxel2Repr", "(", ")")]
        elif words[0][0].isalpha() and _is_key(words[0]):
            continue
        else:
            rows.append(_row(words, path, number))
    return name, representative, np.array(rows, dtype=np.float64).reshape(-1, 6)


def _is_key(word: str) -> bool:
    """Words such as ``spatial_sampling``; but not nan or inf, which are broken numbers."""
    return word.replace("_", "").isalnum() and word.lower() not in ("nan", "inf", "infinity")


def _integer(word: str, path: Path, line: int) -> int:
    try:
        return int(word)
    except ValueError as error:
        raise SkinError("taxel2Repr must hold whole numbers", file=path, place=f"line {line}", value=word) from error


def _row(words: list[str], path: Path, line: int) -> list[float]:
    try:
        row = [float(word) for word in words]
    except ValueError as error:
        raise SkinError("a taxel row must be numbers", file=path, place=f"line {line}",
                        value=" ".join(words)) from error
    if len(row) not in (3, 6) or not np.isfinite(row).all():
        raise SkinError("a taxel row must be 3 or 6 finite numbers", file=path, place=f"line {line}",
                        value=" ".join(words))
    return row + [0.0] * (6 - len(row))


def _usable(name: str, representative: list[int], rows: FloatArray, where: str) -> IcubTaxels:
    findings: list[Finding] = []

    def note(kind: str, action: str, count: int) -> None:
        if count:
            findings.append(Finding(kind, where, action, int(count)))

    placed: BoolArray = (rows[:, :3] != 0).any(axis=1)
    listed = np.ones(len(rows), dtype=bool)
    if representative:
        common = min(len(representative), len(rows))
        note("list-length", f"taxel2Repr has {len(representative)} entries for {len(rows)} rows; rows beyond it count "
             "as taxels where they have a position", abs(len(representative) - len(rows)))
        listed[:common] = np.array(representative[:common]) >= 0
    thermal = np.isin(np.arange(len(rows)) % _PADS, _THERMAL) & (len(rows) % _PADS == 0) & bool(representative)
    note("unused-row", "left out: no position", (~placed).sum())
    note("thermal-pad", "left out: pads 6 and 10 measure temperature", (placed & thermal & ~listed).sum())
    note("disputed-row", "left out: has a position but taxel2Repr says it is not fitted",
         (placed & ~listed & ~thermal).sum())
    note("missing-position", "left out: taxel2Repr lists it but it has no position", (listed & ~placed).sum()
         if representative else 0)
    rows_used = np.flatnonzero(placed & listed)
    if not len(rows_used):
        raise SkinError("no taxel of the file is usable", file=where, value=f"{len(rows)} rows")
    _, first = np.unique(np.round(rows[rows_used, :3], 7), axis=0, return_index=True)
    kept = rows_used[np.sort(first)]
    note("duplicate-taxel", "merged with the taxel at the same position", len(rows_used) - len(kept))
    if len(np.unique(np.round(rows[kept, 3:], 6), axis=0)) == 1:
        note("dummy-normals", "all normals are equal; taken from the surface instead", len(kept))
    return IcubTaxels(name, rows[kept, :3], rows[kept, 3:], kept, tuple(findings))
