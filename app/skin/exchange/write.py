"""A skin's taxels as a file for other programs; the ending says which."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from app.arrays import FloatArray
from app.errors import SkinError
from app.skin.exchange.foreign_file import naming
from app.skin.exchange.icub import write_icub_positions
from app.skin.exchange.npz import write_npz
from app.skin.exchange.table import write_table
from app.skin.exchange.taxel_set import TaxelSet
from app.skin.exchange.unige_json import UnigeFile, UnigeMap, write_unige
from app.skin.exchange.urdf_tactile import write_urdf_taxels
from app.skin.skin import Skin
from app.skin.triangulate import triangulate

ENDINGS = (".txt", ".csv", ".npz", ".json", ".urdf")
_MANY_LINKS = {".csv": write_table, ".npz": write_npz, ".urdf": write_urdf_taxels}


def write_taxels(
    taxels: Skin | TaxelSet | Sequence[TaxelSet], path: str | Path, *, points: FloatArray | None = None
) -> None:
    """Write taxels as iCub positions (.txt), a table (.csv), .npz, Genoa's JSON (.json) or URDF sensors (.urdf).

    A format keeps what it has a place for: all of them numbers and positions; all but .txt a missing link; normals too
    where they are known; .csv, .npz and .json map points; .npz and .json faces.

    Args:
        taxels: A skin, or sets of at most one link each.
        path: Its ending decides.
        points: (n, 2) places of all taxels on a map [m], in the order of the skin or of the sets.

    Raises:
        SkinError: An unknown ending, several links in a format for one, or the file cannot be written.
    """
    path = Path(path)
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        remedy = f"Choose one of: {', '.join(ENDINGS)}"
        raise SkinError("taxels cannot be written as this", file=path, value=ending or "no ending", remedy=remedy)
    with naming(path):
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
        # Genoa's library knows a skin as a mesh over its taxels, which ours has none of by itself.
        write_unige(unige_file(_with_faces(sets[0]) if isinstance(taxels, Skin) else sets[0]), path)


def taxel_sets(
    taxels: Skin | TaxelSet | Sequence[TaxelSet], *, points: FloatArray | None = None
) -> tuple[TaxelSet, ...]:
    """One set a link; the numbers are those of the skin.

    Args:
        taxels: A skin, or sets already.
        points: (n, 2) places of all taxels on a map [m], in their order.

    Raises:
        SkinError: No taxels, or another number of points.
    """
    sets = (
        _of_skin(taxels) if isinstance(taxels, Skin) else (taxels,) if isinstance(taxels, TaxelSet) else tuple(taxels)
    )
    if not sets:
        raise SkinError("there are no taxels to write")
    if points is None:
        return sets
    if len(points) != sum(map(len, sets)):
        raise SkinError("map points and taxels differ in number", value=f"{len(points)} and {sum(map(len, sets))}")
    if isinstance(taxels, Skin):
        return tuple(replace(one, points=points[one.numbers]) for one in sets)
    starts = np.cumsum([0, *map(len, sets)])
    return tuple(replace(one, points=points[a:b]) for one, a, b in zip(sets, starts[:-1], starts[1:], strict=True))


def unige_file(taxels: TaxelSet) -> UnigeFile:
    """``taxels`` in Genoa's form; their points, if any, become its one map."""
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
    for link in dict.fromkeys(patch.link for patch in skin.patches):
        own = [k for k, patch in enumerate(skin.patches) if patch.link == link and len(patch.taxels)]
        if own:
            parts = [skin.patches[k].taxels for k in own]
            sets.append(
                TaxelSet(
                    name=skin.patches[own[0]].name if len(own) == 1 else link,
                    link=link,
                    numbers=np.concatenate([np.arange(skin.first[k], skin.first[k + 1]) for k in own]),
                    positions=np.concatenate([part.positions for part in parts]),
                    normals=np.concatenate([part.normals for part in parts]),
                )
            )
    return tuple(sets)
