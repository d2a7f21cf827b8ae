"""Tables in files that people write: CSV and TOML, with errors that name file and line."""

from __future__ import annotations

import csv
import math
import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tactile_maps.core.errors import LiveError, names_text
from tactile_maps.core.files import read_bounded_text
from tactile_maps.core.toml import parse_toml
from tactile_maps.skin.formats.vendors.documents import refuse_decimal_comma, separator_of


def read_toml(path: Path) -> dict[str, Any]:
    """Return the values of a TOML file; raises LiveError for a file that cannot be read."""
    try:
        return parse_toml(read_bounded_text(path, error=LiveError), file=path, error=LiveError)
    except tomllib.TOMLDecodeError as error:
        raise LiveError("the file is not TOML", file=path, value=error) from error


def read_cells(path: Path) -> list[tuple[int, list[str]]]:
    """Return the rows of a CSV table with their line numbers, first its header; lines that begin with # are comments.

    Raises:
        LiveError: The file cannot be read or is empty, or a row has too many or too few cells.
    """
    lines = read_bounded_text(path, error=LiveError).splitlines()
    kept = [(number, line) for number, line in enumerate(lines, start=1) if line.strip() and line.lstrip()[0] != "#"]
    if not kept:
        raise LiveError("the table is empty", file=path)
    separator = separator_of(kept[0][1])
    rows: list[tuple[int, list[str]]] = []
    for (line, _), cells in zip(kept, csv.reader((line for _, line in kept), delimiter=separator), strict=True):
        if rows and len(cells) != len(rows[0][1]):
            found = f"{len(cells)} of {len(rows[0][1])} columns"
            raise LiveError("a row does not fit the header", file=path, place=f"line {line}", value=found)
        rows.append((line, [cell.strip() for cell in cells]))
    return rows


def read_rows(path: Path, needed: tuple[str, ...]) -> list[tuple[int, dict[str, str]]]:
    """Return the rows of a CSV table by its header in lower case, with their line numbers.

    Raises:
        LiveError: As ``read_cells``, or a column of ``needed`` is missing.
    """
    (first, header), *rows = read_cells(path)
    names = [name.lower() for name in header]
    for name in needed:
        if name not in names:
            remedy = f"Its header needs: {', '.join(needed)}"
            raise missing_column(name, header, path, remedy, place=f"line {first}")
    return [(line, dict(zip(names, cells, strict=True))) for line, cells in rows]


def missing_column(
    name: str, header: Sequence[str], path: Path, remedy: str | None = None, *, place: str = "header"
) -> LiveError:
    """Return the error about a column that a table does not have, with the columns that it has."""
    found = names_text(header)
    return LiveError(f"a column is missing: {name}", file=path, place=place, value=found, remedy=remedy)


def decimal_number(text: str, path: str | Path, line: int, column: str) -> float:
    """Return the number in a table cell, NaN for an empty one; raises LiveError for anything else."""
    try:
        return float(text) if text else math.nan
    except ValueError as error:
        refuse_decimal_comma(text, place=f"line {line}, {column}", error=LiveError, file=Path(path))
        raise LiveError("expected a number", file=path, place=f"line {line}, {column}", value=text) from error


def whole_number(text: str, path: str | Path, line: int, column: str) -> int:
    """Return the integer in a table cell; raises LiveError for anything else and for more than 18 digits."""
    if not re.fullmatch(r"\s*[+-]?[0-9]{1,18}\s*", text):
        remedy = "Give a whole number of at most 18 digits"
        raise LiveError("expected a whole number", file=path, place=f"line {line}, {column}", value=text, remedy=remedy)
    return int(text)
