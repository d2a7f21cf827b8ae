"""Taxels from any file that states them: the ending says which reader, and the content where the ending does not."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from app.errors import SkinError
from app.skin.exchange.foreign_file import read_bytes
from app.skin.exchange.icub import read_icub_positions
from app.skin.exchange.npz import read_npz
from app.skin.exchange.table import read_table
from app.skin.exchange.taxel_set import TaxelSet
from app.skin.exchange.unige_json import read_unige
from app.skin.exchange.urdf_tactile import read_urdf_taxels

ENDINGS = (".txt", ".csv", ".tsv", ".npz", ".json", ".urdf", ".xml")
_COLUMN_UNIT = re.compile("_m{1,2}$")
_POSITIONS_BEGIN = (["name"], ["spatial_sampling"], ["taxel2repr"], ["[calibration]"])


def read_taxels(path: str | Path, *, link: str | None = None) -> TaxelSet:
    """The taxels in the file at ``path``: iCub positions, table, npz, Genoa's JSON, or URDF with tactile sensors.

    Args:
        path: The file.
        link: Which link's, in a file that has several.

    Raises:
        SkinError: It is none of them, broken, or holds several links and none was chosen.
    """
    sets = read_taxel_sets(path)
    chosen = [taxels for taxels in sets if link is None or taxels.link == link]
    if len(chosen) != 1:
        links = ", ".join(taxels.link or "no name" for taxels in sets)
        problem = "the file has several links" if link is None else "the file has no such link"
        raise SkinError(problem, file=path, value=links if link is None else link, remedy=f"Choose one of: {links}")
    return chosen[0]


def read_taxel_sets(path: str | Path) -> tuple[TaxelSet, ...]:
    """The taxels in the file at ``path``, one set a link.

    Raises:
        SkinError: It is of no known kind, or broken.
    """
    path = Path(path)
    return _reader(path)(path)


def _reader(path: Path) -> Callable[[Path], tuple[TaxelSet, ...]]:
    ending = path.suffix.lower()
    by_ending: dict[str, Callable[[Path], tuple[TaxelSet, ...]]] = {
        ".csv": read_table, ".tsv": read_table, ".npz": read_npz, ".json": _unige,
        ".urdf": read_urdf_taxels, ".xml": read_urdf_taxels,
    }  # fmt: skip
    if ending in by_ending:
        return by_ending[ending]
    if ending == ".ini":
        remedy = "Open the positions file of the same patch, and give this one as its layout"
        raise SkinError("a layout states no places on the body", file=path, remedy=remedy)
    return _by_content(path)


def _by_content(path: Path) -> Callable[[Path], tuple[TaxelSet, ...]]:
    start = read_bytes(path)[:4096].lstrip()
    if start.startswith(b"PK"):
        return read_npz
    if start.startswith(b"{"):
        return _unige
    if start.startswith(b"<"):
        return read_urdf_taxels
    lines = start.decode("utf-8-sig", errors="replace").lower().splitlines()
    first = next((line for line in lines if line.strip() and not line.lstrip().startswith(("#", "//"))), "")
    if {"x", "y", "z"} <= {_COLUMN_UNIT.sub("", name.strip()) for name in first.split("\t")}:
        return read_table
    # An old positions file is nothing but numbers between blanks; a table without names has another separator.
    named = first.split()[:1] in _POSITIONS_BEGIN
    return read_table if ("," in first or ";" in first) and not named else _icub


def _icub(path: Path) -> tuple[TaxelSet, ...]:
    return (read_icub_positions(path),)


def _unige(path: Path) -> tuple[TaxelSet, ...]:
    file = read_unige(path)
    return (file.with_points() if file.maps else file.taxels,)
