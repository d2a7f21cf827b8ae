"""Sensors of GenTact in URDF: links ``NAME_sensor_NUMBER``, fixed to the skin's link, without a shape or as a sphere.

The shape is that of the files that GenTact's Blender add-on and its xacro macros make (cKohl10/gentact_ros_tools,
``urdf``; cKohl10/PyGenTact): the origin of the fixed joint is the place of the sensor, and the ``axis`` of the joint is
the normal in the frame of the parent, which is also the z-axis of the origin.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
from scipy.spatial.transform import Rotation

from tactile_maps.core.errors import Finding, RobotError, SkinError, errors_in_file
from tactile_maps.core.files import read_bounded_file
from tactile_maps.robots.files.safe_files import parse_xml
from tactile_maps.skin.formats.vendors.field_mapping import FieldMapping, taxel_sets_of
from tactile_maps.skin.formats.vendors.taxel_format import TaxelFormat
from tactile_maps.skin.model.taxel_set import TaxelSet

_NAME = re.compile(r"(?:.*[/_])?(?:sensor|taxel)_?(\d{1,9})")
_CHILD = re.compile(r'<child\s+link="(?:[^"]*[/_])?(?:sensor|taxel)_?\d{1,9}"')
_FEWEST = 3
_FIELDS = FieldMapping(("position",), unit="m", normal=("normal",), id="id", link="link", name="name")
_ASSUMED = "GenTact: links with a number, fixed to the skin; the axes are the normals, the numbers the ids"


def _recognises(document: object) -> bool:
    return isinstance(document, str) and "<tactile" not in document and len(_CHILD.findall(document)) >= _FEWEST


def read_gentact(path: Path) -> tuple[TaxelSet, ...]:
    """Return the sensors of a URDF, one set for each link that they are fixed to.

    Raises:
        SkinError: The file is not valid XML, has too few sensors, or an origin is invalid; names the joint.
    """
    try:
        root = parse_xml(read_bounded_file(path, error=SkinError), file=path)
    except RobotError as error:
        raise error.at(kind=SkinError, file=path) from error
    shapes = {
        link.get("name", ""): {shape.tag.split("}")[-1] for shape in link.iterfind(".//{*}geometry/*")}
        for link in root.iterfind("{*}link")
    }
    with errors_in_file(path):
        found = [
            _record(joint)
            for joint in root.iterfind("{*}joint[@type='fixed']")
            if _NAME.fullmatch(_link(joint, "child")) and shapes.get(_link(joint, "child"), set()) <= {"sphere"}
        ]
        if len(found) < _FEWEST:
            remedy = "Sensors are links NAME_sensor_NUMBER with a fixed joint, without a shape or with a sphere"
            raise SkinError(f"the file has fewer than {_FEWEST} sensors", value=len(found), remedy=remedy)
        fields = _FIELDS if all("normal" in record for record in found) else replace(_FIELDS, normal=())
        first, *others = taxel_sets_of(found, fields, name=path.stem, where=path.name)
    return (first.with_findings(Finding("vendor-layout", path.name, _ASSUMED, len(found))), *others)


def _record(joint: Element) -> dict[str, object]:
    """Return the fields of a sensor, in the frame of the link that carries it; no normal if the joint states none."""
    child = _link(joint, "child")
    number = _NAME.fullmatch(child)
    assert number is not None
    found: dict[str, object] = {"id": int(number[1]), "link": _link(joint, "parent"), "name": child}
    found["position"] = _floats(joint, "origin", "xyz") or [0.0, 0.0, 0.0]
    if axis := _floats(joint, "axis", "xyz"):
        found["normal"] = axis
    elif turn := _floats(joint, "origin", "rpy"):
        found["normal"] = Rotation.from_euler("xyz", turn).as_matrix()[:, 2].tolist()
    return found


def _link(joint: Element, end: str) -> str:
    element = joint.find(f"{{*}}{end}")
    return "" if element is None else element.get("link", "")


def _floats(joint: Element, tag: str, name: str) -> list[float]:
    """Return the three numbers of an attribute; empty without it."""
    element = joint.find(f"{{*}}{tag}")
    text = None if element is None else element.get(name)
    if text is None:
        return []
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != 3 or not np.isfinite(values).all():
        raise SkinError(f"{tag} {name} must be 3 finite numbers", place=f"joint {joint.get('name')}", value=text)
    return values


GENTACT = TaxelFormat("gentact", "GenTact", (".urdf",), read_gentact, _recognises)
