"""The map as an SVG drawing in millimetres: outlines, seams, numbered taxels and names of the patches.

Each patch is a group with one subgroup per kind of element, so that a drawing program can hide or restyle each.
"""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import MapError
from tactile_maps.core.files import write_atomically
from tactile_maps.maps.model.tactile_map import TactileMap

MARGIN = 5.0
"""Margin around the drawing, with space for names [mm]."""
_STYLE = """
.outline { fill: #eef2f5; stroke: #33414e; stroke-width: 0.35; stroke-linejoin: round }
.seam { fill: none; stroke: #c0392b; stroke-width: 0.5; stroke-linecap: round }
.taxel { fill: #2c7fb8 }
.number { font-family: sans-serif; fill: #33414e; text-anchor: middle }
.name { font-family: sans-serif; font-size: 3.5px; fill: #33414e; text-anchor: middle }
"""
_RADIUS = 0.08
_DIGIT = 0.25
"""Radius of a taxel and height of its number, as shares of the distance between taxels."""
_DIGITS = 3


def write_svg(map_: TactileMap, path: str | Path, *, numbers: bool = True) -> None:
    """Write the map at its true size, with the same upward direction.

    Args:
        map_: Map with at least one patch.
        path: Usually ``.svg``.
        numbers: Whether taxels are numbered, by hardware id if known, else through the skin. Element ids
            (``taxel-13``) are always numbered through the skin.

    Raises:
        MapError: The file cannot be written.
    """
    write_atomically(Path(path), svg(map_, numbers=numbers), error=MapError)


def svg(map_: TactileMap, *, numbers: bool = True) -> bytes:
    """Return the drawing; equal maps give equal bytes."""
    page = _Page(map_.bounds)
    width, height = page.size
    root = Element(
        "svg",
        xmlns="http://www.w3.org/2000/svg",
        version="1.1",
        width=f"{width:.3f}mm",
        height=f"{height:.3f}mm",
        viewBox=f"0 0 {width:.3f} {height:.3f}",
    )
    SubElement(root, "title").text = "Tactile map"
    SubElement(root, "style").text = _STYLE
    for k in range(len(map_.charts)):
        _draw_taxels(_draw_patch(root, map_, k, page), map_, k, page, numbers=numbers)
    indent(root)
    return tostring(root, encoding="utf-8", xml_declaration=True)


class _Page:
    """Conversion of map points in metres to millimetres from the page's upper left corner."""

    def __init__(self, bounds: FloatArray) -> None:
        self._left = bounds[0, 0]
        self._top = bounds[1, 1]
        self.size = 1e3 * np.ptp(bounds, axis=0) + 2 * MARGIN

    def __call__(self, points: FloatArray) -> FloatArray:
        return 1e3 * np.stack([points[..., 0] - self._left, self._top - points[..., 1]], axis=-1) + MARGIN


def _draw_patch(root: Element, map_: TactileMap, k: int, page: _Page) -> Element:
    """Add the patch's group with outline, seams and name."""
    patch = map_.skin.patches[k]
    name = "".join(c for c in patch.name if c.isprintable())
    group = SubElement(root, "g", {"class": "patch"}, id=f"patch-{k}")
    SubElement(group, "title").text = f"{name} ({len(patch.taxels)} taxels)"
    outline = page(map_.outlines[k])
    segments = page(map_.seams[k])
    SubElement(group, "path", {"class": "outline"}, d=_path(outline) + " Z")
    seams = SubElement(group, "g", id=f"seams-{k}")
    if len(segments):
        SubElement(seams, "path", {"class": "seam"}, d=" ".join(map(_path, segments)))
    x = float(outline[:, 0].mean())
    y = float(outline[:, 1].min()) - 1.0
    label = SubElement(group, "text", {"class": "name"}, x=_text(x), y=_text(y), id=f"name-{k}-{_identifier(name)}")
    label.text = name
    return group


def _draw_taxels(group: Element, map_: TactileMap, k: int, page: _Page, *, numbers: bool) -> None:
    first, end = map_.skin.first[k : k + 2].tolist()
    # By the area of the patch per taxel, regardless of the area that a taxel senses.
    pitch = 1e3 * np.sqrt(map_.skin.patches[k].surface.area / max(end - first, 1))
    radius = _text(_RADIUS * pitch)
    height = _DIGIT * pitch
    taxels = SubElement(group, "g", id=f"taxels-{k}")
    labels = SubElement(group, "g", {"font-size": _text(height)}, id=f"numbers-{k}") if numbers else None
    ids = map_.skin.patches[k].taxels.identity.ids
    for number, (x, y) in enumerate(page(map_.taxel_points[first:end]).tolist(), start=first):
        place = {"cx": _text(x), "cy": _text(y), "r": radius}
        SubElement(taxels, "circle", place | {"class": "taxel"}, id=f"taxel-{number}")
        if labels is not None:
            label = SubElement(labels, "text", {"class": "number"}, x=_text(x), y=_text(y - 0.6 * height))
            label.text = str(number if ids is None else int(ids[number - first]))


def _path(points: FloatArray) -> str:
    return "M" + " L".join(f"{_text(x)},{_text(y)}" for x, y in points.tolist())


def _text(value: float) -> str:
    return f"{value:.{_DIGITS}f}"


def _identifier(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9]+", "-", name).strip("-") or "patch"
