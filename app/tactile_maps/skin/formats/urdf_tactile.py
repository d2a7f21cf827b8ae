"""Taxels in URDF: ``<sensor><tactile>`` as defined by tactile_toolbox of Bielefeld University (urdf_tactile).

A sensor states its parent link and its origin there, and contains either ``<taxel idx xyz rpy>`` elements, whose z-axes
are the normals, or one ``<array rows cols order size spacing offset>``: taxel (row, column) is at ``(row, column) *
spacing - offset`` in the plane of the sensor, as in the code of the toolbox.

The attribute ``axes`` (1 or 3) of taxels and arrays is an addition of this program. With it, the x-axis is the first
tangent t1 of the taxel, unless ``t1="map"`` states that t1 follows the map.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np
from scipy.spatial.transform import Rotation

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import Finding, RobotError, SkinError, add_finding, errors_in_file
from tactile_maps.core.files import read_bounded_file, write_atomically
from tactile_maps.robots.files.safe_files import parse_xml
from tactile_maps.skin.model.taxel_axes import NUMBERS_OF_AXES
from tactile_maps.skin.model.taxel_set import MAX_TAXELS, TaxelSet, distinct_numbers

_COLUMN_MAJOR = ("col-major", "column-major")
_ORDERS = ("row-major", *_COLUMN_MAJOR)
_DRAWN_RADIUS = 0.002
_LARGEST_NUMBER = 2**31
_FROM_MAP = "map"
_LEVEL = 1e-12


def read_urdf_taxels(path: str | Path) -> tuple[TaxelSet, ...]:
    """Return the taxels of all tactile sensors in a URDF, one set for each link, in the order of the file.

    A link whose taxels do not state ``rpy`` has no normals.

    Raises:
        SkinError: The file is not valid XML or has no tactile sensor, or an attribute is invalid; names the sensor.
    """
    path = Path(path)
    try:
        root = parse_xml(read_bounded_file(path, error=SkinError), file=path)
    except RobotError as error:
        raise error.at(kind=SkinError, file=path) from error
    by_link = dict[str, list[_Sensor]]()
    with errors_in_file(path):
        for element in root.iterfind(".//{*}sensor"):
            if element.find("{*}tactile") is not None:
                sensor = _Sensor(element)
                by_link.setdefault(sensor.link, []).append(sensor)
        if not by_link:
            raise SkinError("the file has no tactile sensor", remedy="Choose a URDF with <sensor><tactile>")
        if sum(len(sensor.positions) for sensors in by_link.values() for sensor in sensors) > MAX_TAXELS:
            raise SkinError(f"the file has more than {MAX_TAXELS} taxels")
        return tuple(map(_joined, by_link.values()))


def write_urdf_taxels(sets: Sequence[TaxelSet], path: str | Path) -> None:
    """Write ``sets`` as sensors of a URDF with only their links; ``idx`` is the id, or the number without ids.

    Raises:
        SkinError: The file cannot be written.
    """
    robot = Element("robot", name="skin")
    for link in dict.fromkeys(_link_name(taxels) for taxels in sets):
        SubElement(robot, "link", name=link)
    for taxels in sets:
        name = _plain(taxels.name) or "skin"
        sensor = SubElement(robot, "sensor", name=name, update_rate="100")
        SubElement(sensor, "parent", link=_link_name(taxels))
        SubElement(sensor, "origin", xyz="0 0 0", rpy="0 0 0")
        tactile = SubElement(sensor, "tactile", channel=name)
        turns = None if taxels.normals is None else _turns(taxels.normals, taxels.tangents)
        places = zip(taxels.stated_ids.tolist(), taxels.positions.tolist(), strict=True)
        for row, (number, position) in enumerate(places):
            taxel = SubElement(tactile, "taxel", idx=str(number), xyz=" ".join(map(repr, position)))
            if turns is not None:
                taxel.set("rpy", " ".join(map(repr, turns[row].tolist())))
            if taxels.axes is not None or taxels.tangents is not None:
                taxel.set("axes", str(1 if taxels.axes is None else taxels.axes[row]))
                if turns is None or taxels.tangents is None or np.isnan(taxels.tangents[row, 0]):
                    taxel.set("t1", _FROM_MAP)
            SubElement(SubElement(taxel, "geometry"), "sphere", radius=str(_DRAWN_RADIUS))
    indent(robot)
    write_atomically(Path(path), tostring(robot, encoding="utf-8", xml_declaration=True), error=SkinError)


class _Sensor:
    """A sensor of the file, its taxels in the frame of its parent link."""

    def __init__(self, element: Element) -> None:
        self.name = element.get("name") or "tactile"
        parent = element.find("{*}parent")
        tactile = element.find("{*}tactile")
        self.link = parent.get("link", "") if parent is not None else ""
        if not self.link:
            raise self._refuse("the sensor has no parent link", None)
        self.findings: list[Finding] = []
        taxels = [] if tactile is None else tactile.findall("{*}taxel")
        array = None if tactile is None else tactile.find("{*}array")
        if taxels:
            add_finding(
                self.findings, "array-left-out", self.name, "not read: the sensor lists its taxels", array is not None
            )
            local, turns = self._listed(taxels)
            states = list(map(self._axes, taxels))
        elif array is not None:
            local = self._array(array)
            turns = np.tile(np.eye(3), (len(local), 1, 1))
            states = [self._axes(array)] * len(local)
        else:
            raise self._refuse("the sensor has neither taxels nor an array", None)
        turn, offset = self._pose(element.find("{*}origin"))
        self.positions = local @ turn.T + offset
        self.normals = (turn @ turns)[:, :, 2]
        self.axes = np.array([axes for axes, _ in states])
        stated = np.array([tangent for _, tangent in states]) & self.has_normals
        self.tangents = np.where(stated[:, None], (turn @ turns)[:, :, 0], np.nan)

    def _listed(self, taxels: Sequence[Element]) -> tuple[FloatArray, FloatArray]:
        self.numbers = np.array([self._whole(taxel, "idx") for taxel in taxels])
        self.has_normals = any(taxel.get("rpy") is not None for taxel in taxels)
        poses = [self._pose(taxel) for taxel in taxels]
        return np.array([position for _, position in poses]), np.array([turn for turn, _ in poses])

    def _axes(self, element: Element) -> tuple[int, bool]:
        """Return the number of axes, and whether the x-axis is the first tangent."""
        stated = element.get("axes")
        if stated is None:
            return 1, False
        number = self._whole(element, "axes")
        if number not in NUMBERS_OF_AXES:
            raise self._refuse("axes must be 1 or 3", stated)
        return number, element.get("t1") != _FROM_MAP

    def _array(self, array: Element) -> FloatArray:
        rows = self._whole(array, "rows")
        columns = self._whole(array, "cols")
        if not 1 <= rows * columns <= MAX_TAXELS:
            raise self._refuse(f"an array must have 1 to {MAX_TAXELS} taxels", f"{rows} x {columns}")
        order = array.get("order", "row-major")
        if order not in _ORDERS:
            raise self._refuse(f"order must be {_ORDERS[0]} or {_ORDERS[1]}", order)
        size = self._floats(array, "size", 2)
        spacing = self._floats(array, "spacing", 2, default=size)
        offset = self._floats(array, "offset", 2, default=np.zeros(2))
        add_finding(self.findings, "array-offset", self.name, "subtracted, as urdf_tactile does it", bool(offset.any()))
        self.numbers = np.arange(rows * columns)
        self.has_normals = True
        row, column = np.divmod(self.numbers, columns)
        if order in _COLUMN_MAJOR:
            column, row = np.divmod(self.numbers, rows)
        flat = np.stack([row, column], axis=1) * spacing - offset
        return np.column_stack([flat, np.zeros(len(flat))])

    def _pose(self, element: Element | None) -> tuple[FloatArray, FloatArray]:
        """Return the rotation (3, 3) and position (3,) [m] of ``rpy`` and ``xyz``; fixed axes, roll first."""
        if element is None:
            return np.eye(3), np.zeros(3)
        rpy = self._floats(element, "rpy", 3, default=np.zeros(3))
        return Rotation.from_euler("xyz", rpy).as_matrix(), self._floats(element, "xyz", 3, default=np.zeros(3))

    def _floats(self, element: Element, name: str, count: int, default: FloatArray | None = None) -> FloatArray:
        text = element.get(name)
        if text is None and default is not None:
            return default
        try:
            values = np.array([float(word) for word in (text or "").split()])
        except ValueError as error:
            raise self._refuse(f"{name} must be numbers", text) from error
        if len(values) != count or not (np.abs(values) < 1e6).all():
            raise self._refuse(f"{name} must be {count} finite numbers", text)
        return values

    def _whole(self, element: Element, name: str) -> int:
        text = (element.get(name) or "").strip()
        if not re.fullmatch(r"[0-9]{1,10}", text) or int(text) >= _LARGEST_NUMBER:
            raise self._refuse(f"{name} must be a whole number, not negative", text or "nothing")
        return int(text)

    def _refuse(self, problem: str, value: object) -> SkinError:
        return SkinError(problem, place=f"sensor {self.name}", value=value)


def _joined(sensors: Sequence[_Sensor]) -> TaxelSet:
    """Return the taxels of the sensors of one link."""
    findings = [finding for sensor in sensors for finding in sensor.findings]
    first = sensors[0]
    joined = ", ".join(sensor.name for sensor in sensors[1:])
    add_finding(findings, "sensors-joined", first.link, f"on one link with {first.name}: {joined}", len(sensors) - 1)
    bare = sum(not sensor.has_normals for sensor in sensors)
    if bare and bare < len(sensors):
        add_finding(findings, "normals-missing", first.link, "no normals are used: a sensor states none", bare)
    numbers: IntArray = np.concatenate([sensor.numbers for sensor in sensors])
    return TaxelSet(
        name=first.name,
        link=first.link,
        numbers=distinct_numbers(numbers, first.link, findings),
        ids=numbers,
        positions=np.concatenate([sensor.positions for sensor in sensors]),
        normals=None if bare else np.concatenate([sensor.normals for sensor in sensors]),
        axes=np.concatenate([sensor.axes for sensor in sensors]),
        tangents=np.concatenate([sensor.tangents for sensor in sensors]),
        findings=tuple(findings),
    )


def _turns(normals: FloatArray, tangents: FloatArray | None) -> FloatArray:
    """Return (n, 3) roll, pitch and yaw that rotate z to each normal and x to each tangent; yaw is 0 without one."""
    x, y, z = normals.T
    turns = np.stack([np.arctan2(-y, np.hypot(x, z)), np.arctan2(x, z), np.zeros(len(x))], axis=1)
    if tangents is None:
        return turns
    others = np.cross(normals, tangents)
    level = np.hypot(tangents[:, 0], tangents[:, 1])
    upright = level < _LEVEL  # x is rotated to z: only the sum of roll and yaw is defined
    roll = np.where(upright, np.arctan2(-normals[:, 1], others[:, 1]), np.arctan2(others[:, 2], z))
    yaw = np.where(upright, 0.0, np.arctan2(tangents[:, 1], tangents[:, 0]))
    framed = np.stack([roll, np.arctan2(-tangents[:, 2], level), yaw], axis=1)
    return np.where(np.isnan(tangents), turns, framed)


def _link_name(taxels: TaxelSet) -> str:
    return _plain(taxels.link or "") or "skin"


def _plain(text: str) -> str:
    """Return ``text`` in one line, without the characters that XML does not allow."""
    return "".join(c for c in " ".join(text.split()) if c.isprintable())
