"""Export of a map in the format of the file extension."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tactile_maps.core.errors import MapError
from tactile_maps.maps.formats.map_file import save_map
from tactile_maps.maps.formats.obj import write_map_obj
from tactile_maps.maps.formats.png import write_distortion_png
from tactile_maps.maps.formats.svg import write_svg
from tactile_maps.maps.formats.unige import write_unige_map
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.formats.taxel_files import write_taxels

_WRITERS: dict[str, Callable[[TactileMap, Path], None]] = {
    ".npz": save_map,
    ".obj": write_map_obj,
    ".svg": write_svg,
    ".png": write_distortion_png,
    ".json": write_unige_map,
    ".csv": lambda map_, path: write_taxels(map_.skin, path, points=map_.taxel_points),
}
ENDINGS = tuple(_WRITERS)


def write_map(map_: TactileMap, path: str | Path) -> None:
    """Write ``map_`` in the format of the file extension.

    The formats are the complete map (.npz), the mesh with UV coordinates (.obj), a drawing (.svg), a picture of the
    distortion (.png), Genoa's skin and map (.json), and the taxels' positions on body and map (.csv).

    Raises:
        MapError: The file extension is unknown, or the file cannot be written.
        SkinError: The taxels cannot be written.
    """
    target = Path(path)
    writer = _WRITERS.get(target.suffix.lower())
    if writer is None:
        remedy = f"Choose one of: {', '.join(ENDINGS)}"
        raise MapError(
            "a map cannot be exported in this format",
            file=target,
            value=target.suffix or "no file extension",
            remedy=remedy,
        )
    writer(map_, target)
