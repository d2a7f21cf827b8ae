"""Tables in files that people write: CSV and TOML, with errors that name file and line."""

from __future__ import annotations

import csv
import re
import tomllib
from pathlib import Path
from typing import Any

from tactile_maps.core.errors import LiveError
from tactile_maps.core.files import read_bounded_text
from tactile_maps.core.toml import parse_toml


def read_toml(path: Path) -> dict[str, Any]:
    """Return the values of a TOML file; raises LiveError for a file that cannot be read."""
    try:
        return parse_toml(read_bounded_text(path, error=LiveError), file=path, error=LiveError)
    except tomllib.TOMLDecodeError as error:
        raise LiveError("the file is not TOML", file=path, value=error) from error


def read_rows(path: Path, needed: tuple[str, ...]) -> list[tuple[int, dict[str, str]]]:
    """Return the rows of a CSV table by its header, with their line numbers; lines that begin with # are comments.

    Raises:
        LiveError: The file cannot be read, a column of ``needed`` is missing, or a row has too many or too few cells.
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


def whole_number(text: str, path: str | Path, line: int, column: str) -> int:
    """Return the integer in a table cell; raises LiveError for anything else and for more than 18 digits."""
    if not re.fullmatch(r"\s*[+-]?[0-9]{1,18}\s*", text):
        remedy = "Give a whole number of at most 18 digits"
        raise LiveError("expected a whole number", file=path, place=f"line {line}, {column}", value=text, remedy=remedy)
    return int(text)
