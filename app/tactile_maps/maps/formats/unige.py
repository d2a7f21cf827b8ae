"""A tactile map in the JSON format of the University of Genoa's robot skin library, whose mesh vertices are taxels.

Maps of this program use finer surfaces, so triangles over the taxels are created here: on the body from neighbourhoods,
and on the map by dropping those across a seam.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import MapError, errors_in_file
from tactile_maps.flattening.bijectivity import signed_areas
from tactile_maps.maps.model.tactile_map import SEAM_RATIO, TactileMap
from tactile_maps.skin.formats.taxel_files import taxel_sets
from tactile_maps.skin.formats.unige_json import UnigeFile, UnigeMap, write_unige
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.skin.reconstruction.triangulation import triangulate


def write_unige_map(map_: TactileMap, path: str | Path, *, name: str = "tactile map") -> None:
    """Write the taxels of ``map_`` with their map points.

    Args:
        map_: Map of a skin on one link: a file contains one rigid body.
        path: Usually ``.json``.
        name: Name of the map for users.

    Raises:
        MapError: The skin covers several links.
        SkinError: Two taxels coincide, or the file cannot be written.
    """
    with errors_in_file(path):
        file = unige_file_of(map_, name=name)
    write_unige(file, path)


def unige_file_of(map_: TactileMap, *, name: str = "tactile map") -> UnigeFile:
    """Return the skin and its map in Genoa's format; errors as ``write_unige_map``."""
    sets = taxel_sets(map_.skin)
    if len(sets) != 1:
        links = ", ".join(str(taxels.link) for taxels in sets)
        raise MapError("this format holds the skin of one link", value=links, remedy="Map one link at a time")
    taxels = sets[0]
    faces = _triangles(taxels)
    points = map_.taxel_points[taxels.numbers]
    shown = faces[_uncut(taxels.positions, points, faces)]
    methods = ", ".join(dict.fromkeys(chart.method for chart in map_.charts))
    chart = UnigeMap(name, np.arange(len(taxels)), points, shown, f"made by Tactile Maps: {methods}")
    return UnigeFile(replace(taxels, faces=faces if len(faces) else None), (chart,))


def _triangles(taxels: TaxelSet) -> IntArray:
    return triangulate(taxels.positions, normals=taxels.normals, where=taxels.name).mesh.faces


def _uncut(positions: FloatArray, points: FloatArray, faces: IntArray) -> np.ndarray:
    """Return a mask (f,) of faces that are face up on the map without a side stretched across a seam."""
    body = positions[faces]
    flat = points[faces]
    true = np.linalg.norm(body - np.roll(body, 1, axis=1), axis=2)
    drawn = np.linalg.norm(flat - np.roll(flat, 1, axis=1), axis=2)
    return np.asarray((drawn <= SEAM_RATIO * true).all(axis=1) & (signed_areas(points, faces) > 0))
