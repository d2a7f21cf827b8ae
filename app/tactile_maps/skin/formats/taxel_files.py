"""Taxels in files of other programs: the format follows from the suffix, and from the content where formats share it.

A file with a mapping file is read by it. Otherwise the layouts of vendors and plug-ins are tried (``TAXEL_FORMATS``),
then the other built-in formats: iCub positions (.txt) and layouts (.ini), tables (.csv, .tsv), npz, Genoa's JSON, URDF
with tactile sensors. Positions, .csv, npz, JSON and URDF are also written, from a skin or from sets of taxels.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import SkinError, errors_in_file
from tactile_maps.core.file_kinds import ALL_SUFFIXES, FileKind
from tactile_maps.core.files import open_regular_file, read_bounded_file, text_encoding
from tactile_maps.core.plugins import Plugin, Registry, guard_call
from tactile_maps.skin.formats.csv_table import read_table, write_table
from tactile_maps.skin.formats.icub.layout import flat_taxels, read_icub_layout
from tactile_maps.skin.formats.icub.positions import read_icub_positions, write_icub_positions
from tactile_maps.skin.formats.npz import read_taxel_npz, write_taxel_npz
from tactile_maps.skin.formats.unige_json import UnigeFile, UnigeMap, read_unige, write_unige
from tactile_maps.skin.formats.urdf_tactile import read_urdf_taxels, write_urdf_taxels
from tactile_maps.skin.formats.vendors.documents import YAML, content_of
from tactile_maps.skin.formats.vendors.gentact import GENTACT
from tactile_maps.skin.formats.vendors.mapping_file import MAPPED, mapping_path, read_mapped, unknown_layout
from tactile_maps.skin.formats.vendors.orca import ORCA
from tactile_maps.skin.formats.vendors.paxini import PAXINI
from tactile_maps.skin.formats.vendors.rapid import RAPID
from tactile_maps.skin.formats.vendors.tactile_genesis import TACTILE_GENESIS
from tactile_maps.skin.formats.vendors.taxel_format import TaxelFormat
from tactile_maps.skin.model.skin import Skin, join_identities
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.skin.reconstruction.triangulation import triangulate

SPREADSHEETS = (".xlsx", ".xls", ".ods")
"""Suffixes of files that are refused with the columns to save as CSV."""
_COLUMN_UNIT = re.compile("_m{1,2}$")
_POSITIONS_BEGIN = (["name"], ["spatial_sampling"], ["taxel2repr"], ["[calibration]"])


def _guarded(plugin: Plugin, form: TaxelFormat) -> TaxelFormat:
    """Return a plug-in's format that returns sets of taxels or raises."""
    if not form.endings or not all(re.fullmatch(r"\.[a-z0-9_.]+", ending) for ending in form.endings):
        raise plugin.error("its suffixes must be like .taxels, in lower case")
    known = set(ALL_SUFFIXES).intersection(form.endings)
    if form.recognises is None and known:
        raise plugin.error(f"its suffix {min(known)} is that of a built-in format, so that it needs recognises")
    if other := known - set(FileKind.TAXELS.suffixes):
        raise plugin.error(f"its suffix {min(other)} is that of another kind of file")

    def read(function: Callable[[Path], Sequence[object]], path: Path) -> tuple[TaxelSet, ...]:
        read_bounded_file(path, error=SkinError)  # no device, nothing too large
        found = tuple(function(path))
        sets = tuple(one for one in found if isinstance(one, TaxelSet))
        if not sets or len(sets) < len(found):
            raise plugin.error("it gave no TaxelSet", [type(one).__name__ for one in found])
        return sets

    guarded = replace(form, read=guard_call(plugin, form.read, "path", check=read))
    if form.recognises is None:
        return guarded
    return replace(guarded, recognises=guard_call(plugin, form.recognises, "document"))


TAXEL_FORMATS: Registry[TaxelFormat] = Registry(
    "importers", TaxelFormat, (PAXINI, ORCA, TACTILE_GENESIS, GENTACT, RAPID), _guarded
)
"""Formats of vendors and of plug-ins by name. The other built-in formats read what none of these recognises."""


def taxel_format_for(path: Path) -> TaxelFormat | None:
    """Return the format of a vendor or plug-in for a file, by its suffix or content; None for other built-in formats.

    Raises:
        SkinError: A format must be recognised by content, and the file cannot be read.
    """
    name = path.name.lower()
    if "." not in name:
        return None
    forms = [form for form in TAXEL_FORMATS.values() if name.endswith(form.endings)]
    own = next((form for form in forms if form.recognises is None), None)
    if own is not None or not forms:
        return own
    document = content_of(path)
    return next((form for form in forms if form.recognises is not None and form.recognises(document)), None)


def read_taxels(path: str | Path) -> TaxelSet:
    """Return the taxels of one link in a file of any format, see ``read_taxel_sets``.

    Raises:
        SkinError: The file is of another kind or broken, or has several links.
    """
    first, *others = read_taxel_sets(path)
    if others:
        links = ", ".join(taxels.link or "no name" for taxels in (first, *others))
        raise SkinError("the file has several links", file=path, value=links, remedy="Give a file with one of them")
    return first


def read_taxel_sets(path: str | Path) -> tuple[TaxelSet, ...]:
    """Return the taxels in a file, one set for each link.

    Raises:
        SkinError: The file is of an unknown kind, or broken.
    """
    path = Path(path)
    ending = path.suffix.lower()
    if ending in SPREADSHEETS:
        remedy = (
            "Save the sheet as CSV with the columns x_mm, y_mm, z_mm (and nx, ny, nz, id, link), one taxel a row, "
            "or with one taxel (x, y, z) in each cell"
        )
        raise SkinError("a spreadsheet cannot be opened", file=path, value=ending, remedy=remedy)
    if ending in MAPPED and mapping_path(path).is_file():
        return read_mapped(path)
    form = taxel_format_for(path)
    if form is not None:
        return form.read(path)
    if ending in YAML:
        raise unknown_layout(path, content_of(path))
    return (_BY_ENDING.get(ending) or _by_content(path))(path)


def _by_content(path: Path) -> Callable[[Path], tuple[TaxelSet, ...]]:
    """Return the function that reads a file with an unknown suffix."""
    with open_regular_file(path, error=SkinError) as stream:
        start = stream.read(4096).lstrip()
    if start.startswith(b"PK"):
        return read_taxel_npz
    if start.startswith(b"{"):
        return _unige
    if start.startswith(b"<"):
        return read_urdf_taxels
    lines = start.decode(text_encoding(start), errors="replace").lower().splitlines()
    first = next((line for line in lines if line.strip() and not line.lstrip().startswith(("#", "//"))), "")
    if {"x", "y", "z"} <= {_COLUMN_UNIT.sub("", name.strip()) for name in first.split("\t")}:
        return read_table
    # An old positions file contains only numbers and blanks; a table without names has another separator.
    named = first.split()[:1] in _POSITIONS_BEGIN
    return read_table if ("," in first or ";" in first) and not named else _icub


def _icub(path: Path) -> tuple[TaxelSet, ...]:
    return (read_icub_positions(path),)


def _layout(path: Path) -> tuple[TaxelSet, ...]:
    return (flat_taxels(read_icub_layout(path)),)


def _unige(path: Path) -> tuple[TaxelSet, ...]:
    file = read_unige(path)
    return (file.with_points() if file.maps else file.taxels,)


_BY_ENDING: Mapping[str, Callable[[Path], tuple[TaxelSet, ...]]] = {
    ".csv": read_table,
    ".tsv": read_table,
    ".npz": read_taxel_npz,
    ".json": _unige,
    ".urdf": read_urdf_taxels,
    ".xml": read_urdf_taxels,
    ".ini": _layout,
}

WRITTEN_ENDINGS = (".txt", ".csv", ".npz", ".json", ".urdf")
_MANY_LINKS = {".csv": write_table, ".npz": write_taxel_npz, ".urdf": write_urdf_taxels}


def write_taxels(
    taxels: Skin | TaxelSet | Sequence[TaxelSet], path: str | Path, *, points: FloatArray | None = None
) -> None:
    """Write taxels as iCub positions (.txt), a table (.csv), .npz, Genoa's JSON (.json) or URDF sensors (.urdf).

    All formats store positions, normals if known, and hardware ids, or numbers without ids; all but .txt axes and
    tangents of taxels, and sets without a link; .csv, .npz and .json also modules, channels and map points; .npz and
    .json faces; .csv areas.

    Args:
        taxels: A skin, or sets of one link each.
        path: The file; its suffix selects the format.
        points: (n, 2) positions of all taxels on a map [m], in the order of the skin or of the sets.

    Raises:
        SkinError: The suffix is unknown, the format does not allow several links, or the file cannot be written.
    """
    path = Path(path)
    ending = path.suffix.lower()
    if ending not in WRITTEN_ENDINGS:
        remedy = f"Choose one of: {', '.join(WRITTEN_ENDINGS)}"
        raise SkinError(
            "taxels cannot be saved in this format", file=path, value=ending or "no file extension", remedy=remedy
        )
    with errors_in_file(path):
        sets = taxel_sets(taxels, points=points)
    if ending in _MANY_LINKS:
        _MANY_LINKS[ending](sets, path)
        return
    if len(sets) != 1:
        links = ", ".join(str(one.link) for one in sets)
        remedy = f"Write one file a link, or one of: {', '.join(_MANY_LINKS)}"
        raise SkinError(f"a {ending} file holds the taxels of one link", file=path, value=links, remedy=remedy)
    if ending == ".txt":
        write_icub_positions(sets[0], path)
    else:
        # In Genoa's library a skin is a mesh over its taxels.
        write_unige(unige_file(_with_faces(sets[0]) if isinstance(taxels, Skin) else sets[0]), path)


def taxel_sets(
    taxels: Skin | TaxelSet | Sequence[TaxelSet], *, points: FloatArray | None = None
) -> tuple[TaxelSet, ...]:
    """Return one set for each link, with the numbers of the skin and the identity of its taxels.

    Args:
        taxels: A skin, or sets.
        points: (n, 2) positions of all taxels on a map [m], in their order.

    Raises:
        SkinError: There are no taxels, or another number of points.
    """
    sets = (
        _of_skin(taxels) if isinstance(taxels, Skin) else (taxels,) if isinstance(taxels, TaxelSet) else tuple(taxels)
    )
    if not sets:
        raise SkinError("no taxels to write")
    if points is None:
        return sets
    if len(points) != sum(map(len, sets)):
        raise SkinError("map points and taxels differ in number", value=f"{len(points)} and {sum(map(len, sets))}")
    if isinstance(taxels, Skin):
        return tuple(replace(one, points=points[one.numbers]) for one in sets)
    starts = np.cumsum([0, *map(len, sets)])
    return tuple(replace(one, points=points[a:b]) for one, a, b in zip(sets, starts[:-1], starts[1:], strict=True))


def unige_file(taxels: TaxelSet) -> UnigeFile:
    """Return ``taxels`` in Genoa's format; their map points, if any, are its only map."""
    if taxels.points is None:
        return UnigeFile(taxels)
    shown = taxels.select(taxels.mapped)
    assert shown.points is not None
    faces = np.zeros((0, 3), dtype=np.int64) if shown.faces is None else shown.faces
    chart = UnigeMap(taxels.name, np.flatnonzero(taxels.mapped), shown.points, faces)
    return UnigeFile(replace(taxels, points=None), (chart,))


def _with_faces(taxels: TaxelSet) -> TaxelSet:
    joined = triangulate(taxels.positions, normals=taxels.normals, where=taxels.name)
    return replace(taxels, faces=joined.mesh.faces if len(joined.mesh.faces) else None)


def _of_skin(skin: Skin) -> tuple[TaxelSet, ...]:
    sets = []
    for link in skin.links:
        own = [k for k, patch in enumerate(skin.patches) if patch.link == link and len(patch.taxels)]
        if own:
            parts = [skin.patches[k].taxels for k in own]
            identity = join_identities([part.identity for part in parts])
            rows = np.concatenate([np.arange(skin.first[k], skin.first[k + 1]) for k in own])
            sets.append(
                TaxelSet(
                    name=skin.patches[own[0]].name if len(own) == 1 else link,
                    link=link,
                    numbers=rows,
                    positions=np.concatenate([part.positions for part in parts]),
                    normals=np.concatenate([part.normals for part in parts]),
                    ids=identity.ids,
                    modules=identity.modules,
                    channels=identity.channels,
                    names=identity.names,
                    aliases=identity.aliases,
                    stream=identity.stream,
                    axes=skin.axes[rows],
                    tangents=skin.tangents[rows],
                )
            )
    return tuple(sets)
