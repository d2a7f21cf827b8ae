"""The map as an SVG drawing in millimetres: outlines, seams, numbered taxels and names of the patches.

Each patch is a group with one subgroup per kind of element, so that a drawing program can hide or restyle each. The
positions of the taxels are read again after patches were moved, rotated or scaled in such a program.
"""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import MapError, RobotError, counted, errors_in_file
from tactile_maps.core.files import read_bounded_file, write_atomically
from tactile_maps.maps.evaluation.comparison import TaxelLayout
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.robots.files.safe_files import parse_xml

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
ROUNDING = 2e-6
"""Distance within which positions in a drawing are the same [m]."""
_ORIGIN = "data-origin"
_TAXEL = re.compile(r"taxel-(\d{1,9})")
_TRANSFORM = re.compile(r"(\w+)\s*\(([^)]*)\)")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


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
        {_ORIGIN: page.origin},
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


def read_svg_taxels(path: str | Path) -> tuple[TaxelLayout, bool]:
    """Return the taxels of a drawing, and whether it states its place on the map.

    Only circles and ellipses with the names that ``write_svg`` gives (``taxel-13``) are read, wherever groups were
    moved, rotated or scaled. Without a stated place, the points are relative to the drawing.

    Raises:
        MapError: The file cannot be read, is not SVG, or has no such taxels.
    """
    path = Path(path)
    try:
        root = parse_xml(read_bounded_file(path, error=MapError), file=path)
    except RobotError as error:
        raise error.at(kind=MapError) from error
    found: dict[int, FloatArray] = {}
    with errors_in_file(path), np.errstate(invalid="ignore", over="ignore"):  # checked by the layout
        waiting = [(root, np.eye(3))]
        while waiting:
            element, outer = waiting.pop()
            pose = outer @ _matrix(element.get("transform", ""))
            name = _TAXEL.fullmatch(element.get("id", ""))
            if name is not None and element.tag.rpartition("}")[2] in ("circle", "ellipse"):
                place = np.array([*(_coordinate(element, key) for key in ("cx", "cy")), 1.0])
                found[int(name[1])] = (pose @ place)[:2]
            waiting += [(child, pose) for child in element]
        if not found:
            remedy = "Choose a drawing that this program exported, with its taxels"
            raise MapError("the drawing has no circles named taxel-0, taxel-1 and so on", remedy=remedy)
        drawn = np.array(list(found.values())) * _scale(root)
        corner = _NUMBER.findall(root.get(_ORIGIN, ""))
        left, top = (float(corner[0]), float(corner[1])) if len(corner) == 2 else (0.0, 0.0)
        points = 1e-3 * (drawn - MARGIN) * [1.0, -1.0] + [left, top]
        return TaxelLayout(points, np.array(list(found))), len(corner) == 2


def _coordinate(element: Element, key: str) -> float:
    try:
        return float(element.get(key, ""))
    except ValueError as error:
        raise MapError("a taxel has no position", place=element.get("id"), value=element.get(key)) from error


def _scale(root: Element) -> float:
    """Return the millimetres in a unit of the drawing, 1 unless its width says otherwise."""
    box = _NUMBER.findall(root.get("viewBox", ""))
    width = root.get("width", "")
    numbers = _NUMBER.findall(width)
    if len(box) != 4 or not numbers or not width.strip().endswith("mm") or float(box[2]) <= 0:
        return 1.0
    return float(numbers[0]) / float(box[2])


def _matrix(text: str) -> FloatArray:
    """Return the (3, 3) matrix of an attribute ``transform``; other functions than those of a plane are rejected."""
    matrix = np.eye(3)
    for name, inside in _TRANSFORM.findall(text):
        numbers = [float(number) for number in _NUMBER.findall(inside)]
        match name, numbers:
            case "translate", [x, *rest]:
                step = _moved(x, rest[0] if rest else 0.0)
            case "scale", [x, *rest]:
                step = np.diag([x, rest[0] if rest else x, 1.0])
            case "rotate", [degrees, *about]:
                cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
                x, y = about if len(about) == 2 else (0.0, 0.0)
                turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])
                step = _moved(x, y) @ turn @ _moved(-x, -y)
            case "matrix", [a, b, c, d, e, f]:
                step = np.array([[a, c, e], [b, d, f], [0, 0, 1]])
            case _:
                raise MapError("unknown transform", value=f"{name}({inside})", remedy="Apply it in the drawing program")
        matrix = matrix @ step
    return matrix


def _moved(x: float, y: float) -> FloatArray:
    return np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])


class _Page:
    """Conversion of map points in metres to millimetres from the page's upper left corner.

    Attributes:
        origin: Map coordinates of the upper left corner of the map, as text [m].
    """

    def __init__(self, bounds: FloatArray) -> None:
        self._left = bounds[0, 0]
        self._top = bounds[1, 1]
        self.origin = f"{self._left:.9g} {self._top:.9g}"
        self.size = 1e3 * np.ptp(bounds, axis=0) + 2 * MARGIN

    def __call__(self, points: FloatArray) -> FloatArray:
        return 1e3 * np.stack([points[..., 0] - self._left, self._top - points[..., 1]], axis=-1) + MARGIN


def _draw_patch(root: Element, map_: TactileMap, k: int, page: _Page) -> Element:
    """Add the patch's group with outline, seams and name."""
    patch = map_.skin.patches[k]
    name = "".join(c for c in patch.name if c.isprintable())
    group = SubElement(root, "g", {"class": "patch"}, id=f"patch-{k}")
    SubElement(group, "title").text = f"{name} ({counted(len(patch.taxels), 'taxel')})"
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
