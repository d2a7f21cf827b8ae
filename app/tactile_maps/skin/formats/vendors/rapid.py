"""Table of the taxels of a RAPID hand's fingertip: each cell has the position ``(x, y, z)`` of one taxel [mm].

The shape is that of ``tactile_relative_position.xlsx`` of SYSU-RoboticsLab/RAPID-Hand, saved as CSV: 12 rows of 8 cells
without headings, with the brackets and commas of Chinese or Latin text. The frame is that of the last link of a finger;
the program of the hand adds 12 mm to z on the thumb, and reverses rows and columns of the raw readings before it
assigns them to the cells.
"""

from __future__ import annotations

import re
from pathlib import Path

from tactile_maps.core.errors import Finding, SkinError, errors_in_file
from tactile_maps.core.files import read_bounded_text
from tactile_maps.skin.formats.vendors.documents import TABLES, table_rows
from tactile_maps.skin.formats.vendors.field_mapping import FieldMapping, taxel_sets_of
from tactile_maps.skin.formats.vendors.taxel_format import TaxelFormat
from tactile_maps.skin.model.taxel_set import TaxelSet

_NUMBER = r"([+-]?\d+\.?\d*)"
_APART = r"[^\w.+-]+"  # also the replacement characters of brackets in another encoding
_CELL = re.compile(_APART + _NUMBER + _APART + _NUMBER + _APART + _NUMBER + _APART)
_MAPPING = FieldMapping(("0", "1", "2"), unit="mm")
_ASSUMED = "RAPID: positions by rows in the frame of a finger's last link, which the file does not name; no normals"


def _recognises(document: object) -> bool:
    first = document[0] if isinstance(document, list) and document else None
    return isinstance(first, dict) and bool(first) and all(_CELL.fullmatch(str(cell)) for cell in first)


def read_rapid(path: Path) -> tuple[TaxelSet, ...]:
    """Return the taxels of a table, by rows.

    Raises:
        SkinError: The table cannot be read, or a cell is not a position; names the line.
    """
    text = read_bounded_text(path, error=SkinError)
    with errors_in_file(path):
        cells = [(line, column, cell) for line, row in table_rows(text) for column, cell in enumerate(row, start=1)]
        positions = []
        for line, column, cell in cells:
            found = _CELL.fullmatch(cell)
            if found is None:
                place = f"line {line}, column {column}"
                raise SkinError("must be a position (x, y, z)", place=place, value=cell[:40] or None)
            positions.append([float(number) for number in found.groups()])
        (taxels,) = taxel_sets_of(positions, _MAPPING, name=path.stem, where=path.name)
    return (taxels.with_findings(Finding("vendor-layout", path.name, _ASSUMED, len(taxels))),)


RAPID = TaxelFormat("rapid", "RAPID hand", TABLES, read_rapid, _recognises)
