"""Export of a map in the format of the file extension."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import TypeVar

from tactile_maps.core.errors import MapError, TactileMapsError
from tactile_maps.core.files import open_regular_file
from tactile_maps.maps.formats.map_file import save_map
from tactile_maps.maps.formats.obj import write_map_obj
from tactile_maps.maps.formats.png import write_distortion_png
from tactile_maps.maps.formats.svg import write_svg
from tactile_maps.maps.formats.unige import write_unige_map
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.formats.taxel_files import write_taxels
from tactile_maps.skin.model.skin import Skin

E = TypeVar("E", bound=TactileMapsError)

_WRITERS: dict[str, Callable[[TactileMap, Path], None]] = {
    ".npz": partial(save_map, overwrite=True),
    ".obj": write_map_obj,
    ".svg": write_svg,
    ".png": write_distortion_png,
    ".json": write_unige_map,
    ".csv": lambda map_, path: write_taxels(map_.skin, path, points=map_.taxel_points),
}
ENDINGS = tuple(_WRITERS)
SENSORS_ENDING = ".xml"
"""Ending of the robot as MJCF with a touch sensor for each taxel, which ``write_touch_sensors`` writes."""
TITLES: Mapping[str, str] = {
    ".npz": "Complete map of this program",
    ".obj": "Mesh with the map as UV",
    ".svg": "Drawing at true size",
    ".png": "Picture of the distortion",
    ".json": "JSON skin and map of Genoa (CySkin)",
    ".csv": "Table of taxels on body and map",
    SENSORS_ENDING: "MuJoCo XML of the robot with a touch sensor a taxel",
}
"""Displayed names of the formats."""
_HEAD = b"# tactile map"


def is_exported_map(path: str | Path) -> bool:
    """Whether a file is a drawing, or a mesh with the map as UV that this program wrote."""
    suffix = Path(path).suffix.lower()
    if suffix != ".obj":
        return suffix == ".svg"
    try:
        with open_regular_file(Path(path), error=MapError) as stream:
            return stream.read(len(_HEAD)) == _HEAD
    except MapError:
        return False  # reported by the function that reads the mesh


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
        raise unknown_format(target, ENDINGS, MapError)
    writer(map_, target)


def unknown_format(target: Path, endings: Iterable[str], error: type[E]) -> E:
    """Return the error that the file extension is not one of ``endings``."""
    return error(
        "a map cannot be exported in this format",
        file=target,
        value=target.suffix or "no file extension",
        remedy=f"Choose one of: {', '.join(endings)}",
    )


def unsuitable_formats(skin: Skin) -> Mapping[str, str]:
    """Return why formats cannot hold the map of a skin, by file extension."""
    links = len(skin.links)
    return {} if links == 1 else {".json": f"only for a skin on one link, and this one is on {links}"}
