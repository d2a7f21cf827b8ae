"""The lines of an iCub positions file, taken apart and checked; what they mean is said in ``icub``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.arrays import FloatArray, IntArray
from app.errors import SkinError
from app.skin.exchange.foreign_file import MAX_TAXELS, read_text
from app.skin.exchange.taxel_set import FARTHEST

MAX_BYTES = 16 * 2**20
MAX_ROWS = MAX_TAXELS


@dataclass(frozen=True, eq=False)
class Rows:
    """What a positions file says.

    Attributes:
        name: The link it names, or None.
        representatives: The list ``taxel2Repr``, or None.
        values: (n, 6) or (n, 3), finite.
    """

    name: str | None
    representatives: IntArray | None
    values: FloatArray


def read_rows(path: Path) -> Rows:
    """Read the file at ``path``; tabs, spaces and any line ends separate.

    Raises:
        SkinError: It cannot be read, or a line is not what the format allows.
    """
    name: str | None = None
    representatives: IntArray | None = None
    rows: list[list[float]] = []
    for number, line in enumerate(read_text(path, most=MAX_BYTES).splitlines(), start=1):
        words = line.split()
        if not words or words[0].startswith(("//", "#", "[")):
            continue
        if _is_number(words[0]):
            rows.append(_row(words, rows, path, number))
        elif rows:
            raise _bad("a row must be 3 or 6 numbers", path, number, line)
        elif words[0] == "name":
            name = " ".join(words[1:]) or None
        elif words[0] == "taxel2Repr":
            representatives = _list(line, path, number)
    if not rows:
        raise SkinError("the file has no taxel rows", file=path, remedy="Choose an iCub skin positions file")
    most = max(len(rows), 0 if representatives is None else len(representatives))
    if representatives is not None and (representatives >= most).any():
        raise SkinError(
            "taxel2Repr names a taxel that does not exist",
            file=path,
            place="taxel2Repr",
            value=int(representatives.max()),
            remedy=f"The file has {len(rows)} rows",
        )
    return Rows(name, representatives, np.array(rows))


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _row(words: list[str], rows: list[list[float]], path: Path, number: int) -> list[float]:
    if len(words) not in (3, 6) or not all(_is_number(word) for word in words):
        raise _bad("a row must be 3 or 6 numbers", path, number, " ".join(words))
    if rows and len(words) != len(rows[0]):
        raise _bad(f"the rows before have {len(rows[0])} numbers", path, number, " ".join(words))
    if len(rows) >= MAX_ROWS:
        raise _bad(f"more than {MAX_ROWS} rows", path, number, None)
    row = [float(word) for word in words]
    if not np.isfinite(row).all():
        raise _bad("a number is not finite", path, number, " ".join(words))
    if max(abs(x) for x in row[:3]) > FARTHEST:
        raise _bad(
            f"a taxel is more than {FARTHEST:g} m from its link; positions are in metres",
            path,
            number,
            " ".join(words[:3]),
        )
    return row


def _list(line: str, path: Path, number: int) -> IntArray:
    """The whole numbers between the brackets, each -2 or more."""
    inside = line.split("taxel2Repr", 1)[1].strip()
    if not (inside.startswith("(") and inside.endswith(")")):
        raise _bad("taxel2Repr must be a list in brackets", path, number, inside)
    words = inside[1:-1].split()
    for word in words:
        if not word.lstrip("-").isdecimal() or len(word) > 9 or int(word) < -2:
            raise _bad("taxel2Repr holds something that is not a taxel number, -1 or -2", path, number, word)
    if len(words) > MAX_ROWS:
        raise _bad(f"taxel2Repr has more than {MAX_ROWS} entries", path, number, len(words))
    return np.array([int(word) for word in words], dtype=np.int64)


def _bad(problem: str, path: Path, line: int, value: object) -> SkinError:
    return SkinError(problem, file=path, place=f"line {line}", value=value, remedy="Correct the line, or leave it out")
