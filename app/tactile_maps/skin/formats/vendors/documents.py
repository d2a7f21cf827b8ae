"""Content of JSON, YAML and table files as plain values: lists, mappings, numbers and texts."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias

from tactile_maps.core.codec import parse_json
from tactile_maps.core.errors import SkinError, TactileMapsError, errors_in_file
from tactile_maps.core.files import read_bounded_file, read_bounded_text
from tactile_maps.robots.files.plain_yaml import parse_yaml
from tactile_maps.skin.model.taxel_set import MAX_TAXELS, line_error

YAML = (".yaml", ".yml")
TABLES = (".csv", ".tsv")
MAX_COLUMNS = 1000
_SEPARATORS = (";", "\t", ",")
_GROUPED = re.compile(r'"[^"]*"|[(（][^)）]*[)）]')
"""Quoted or bracketed text, whose commas do not separate cells."""
_DECIMAL_COMMA = re.compile(r"\s*[-+]?\d+,\d+(?:[eE][-+]?\d+)?\s*", re.ASCII)
_TIME = re.compile(r"(?:time|timestamp|stamp|t)(?:[ _(\[].*)?")
_TAXEL = re.compile(r"(?:.+:)?\d+(?:\.\d+)?(?:[._ ]f?[xyz])?")
TableRows: TypeAlias = Sequence[tuple[int, Sequence[str]]]
"""Line numbers and cells of rows."""


def content_of(path: Path) -> object:
    """Return the content of a file: values of JSON or YAML, a record by heading for each row of a table, else the text.

    Raises:
        SkinError: The file cannot be read, or is not of the kind that its suffix names.
    """
    suffix = path.suffix.lower()
    if suffix in YAML:
        return parse_yaml(read_bounded_file(path, error=SkinError), path, error=SkinError)
    text = read_bounded_text(path, error=SkinError)
    with errors_in_file(path):
        if suffix == ".json":
            return parse_json_file(text)
        if suffix in TABLES:
            (_, headings), *rows = table_rows(text)
            return [dict(zip(map(str.strip, headings), cells, strict=True)) for _, cells in rows]
    return text


def parse_json_file(text: str) -> object:
    """Return the values of a JSON text; NaN and infinity are accepted.

    Raises:
        SkinError: The text is not JSON.
    """
    try:
        document: object = parse_json(text, constants=True)
    except ValueError as error:
        remedy = "Open it in an editor at that line, or export it again"
        raise SkinError("the file is not valid JSON", value=error, remedy=remedy) from error
    return document


def separator_of(header: str) -> str:
    """Return the character that separates the cells of a table: semicolon, tab or comma, by its first line."""
    return max(_SEPARATORS, key=_GROUPED.sub("", header).count)


def names_readings(columns: Sequence[str]) -> bool:
    """Whether the columns of a table are those of readings: a time, and taxels by number."""
    words = [column.strip().lower() for column in columns]
    return any(map(_TIME.fullmatch, words)) and any(map(_TAXEL.fullmatch, words))


def refuse_decimal_comma(text: str, *, place: str, error: type[TactileMapsError], file: Path | None = None) -> None:
    """Raise an ``error`` if a cell is a number with a decimal comma."""
    if _DECIMAL_COMMA.fullmatch(text):
        remedy = "Replace them by decimal points, or export the table with decimal points"
        raise error("the table uses decimal commas", file=file, place=place, value=text.strip(), remedy=remedy)


def table_rows(text: str) -> TableRows:
    """Return the rows of a table, all of the same length; lines that start with # are comments.

    Empty rows after the last one, which spreadsheets write, are left out.

    Raises:
        SkinError: The table is empty, too large, or cannot be parsed; names the line.
    """
    lines = text.splitlines()
    numbers = [number for number, line in enumerate(lines) if (bare := line.lstrip()) and bare[0] != "#"]
    while numbers and not lines[numbers[-1]].strip("".join(_SEPARATORS) + " "):
        numbers.pop()
    lines = [lines[number] for number in numbers]
    numbers = [number + 1 for number in numbers]
    if not lines:
        raise SkinError("the table has no rows")
    if len(lines) > MAX_TAXELS + 1:
        raise SkinError(f"the table has more than {MAX_TAXELS} rows", value=len(lines))
    separator = separator_of(lines[0])
    if (width := lines[0].count(separator) + 1) > MAX_COLUMNS:
        problem = f"the table has more than {MAX_COLUMNS} columns"
        remedy = "Keep the columns of positions, normals and ids"
        raise SkinError(problem, place=f"line {numbers[0]}", value=width, remedy=remedy)
    try:
        cells = list(csv.reader(lines, delimiter=separator, strict=True))
    except csv.Error as error:
        raise SkinError("the table cannot be parsed", value=error) from error
    if len(cells) != len(lines):
        raise SkinError("a quoted cell runs over several lines", remedy="Close the quotes")
    rows = list(zip(numbers, cells, strict=True))
    width = len(cells[0])
    for number, row in rows:
        if len(row) != width:
            raise line_error(f"the row must have {width} cells", number, separator.join(row))
    return rows
