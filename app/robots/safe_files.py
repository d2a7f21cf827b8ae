"""Reading files that strangers wrote: bounded in size, inside their folder, and free of XML tricks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, ParseError

from defusedxml import ElementTree as SafeXml
from defusedxml.common import DefusedXmlException

from app.core.errors import RobotError
from app.core.files import read_bounded_file

MAX_BYTES = 64 * 2**20
MAX_ELEMENTS = 200_000
MAX_DEPTH = 200


def read_bytes(path: Path) -> bytes:
    """The whole file, at most 64 MiB.

    Raises:
        RobotError: It is missing, a folder, too large, or not readable.
    """
    try:
        return read_bounded_file(path, error=RobotError, most=MAX_BYTES)
    except RobotError as error:
        if error.value == "a folder":
            remedy = "Choose the robot's main file inside it"
            raise error.at(problem="this is a folder, not a file", remedy=remedy) from error
        if isinstance(error.__cause__, FileNotFoundError):
            raise RobotError("there is no such file", file=path, remedy="Check the path") from error
        if error.problem == "the file is too large":
            remedy = "Simplify its meshes or split it"
            raise error.at(problem="the file is larger than 64 MB", remedy=remedy) from error
        raise


def parse_xml(data: bytes, *, file: Path | str) -> Element:
    """The root element of an XML document without document type, entities or absurd size.

    Raises:
        RobotError: It is not XML, or it declares entities.
    """
    try:
        root: Element = SafeXml.fromstring(data, forbid_dtd=True)
    except DefusedXmlException as error:
        raise RobotError(
            "the XML declares a document type or entities, which are not allowed",
            file=file,
            remedy="Remove the <!DOCTYPE ...> part",
        ) from error
    except (ParseError, ValueError, LookupError) as error:
        raise RobotError(
            "the file is not valid XML",
            file=file,
            value=error,
            remedy="Open it in an editor at that line, or export it again",
        ) from error
    count = sum(1 for _ in root.iter())
    if count > MAX_ELEMENTS:
        raise RobotError(f"the XML has more than {MAX_ELEMENTS} elements", file=file, value=count)
    level, depth = [root], 0
    while level:
        level, depth = [child for element in level for child in element], depth + 1
    if depth > MAX_DEPTH:
        raise RobotError(f"the XML is nested more than {MAX_DEPTH} deep", file=file, value=depth)
    return root


def resolve_inside(path: Path, roots: Sequence[Path], *, file: Path, named: str) -> Path:
    """``path`` without links and ``..``, which must lie inside one of ``roots``.

    Args:
        path: The place a file names.
        roots: Folders it may lie in.
        file: The file that names it.
        named: How it is written there.

    Raises:
        RobotError: It climbs out of all of them.
    """
    try:
        resolved = path.resolve()
        inside = any(resolved.is_relative_to(root.resolve()) for root in roots)
    except (OSError, ValueError, RuntimeError) as error:
        raise RobotError("the path cannot be followed", file=file, place=named, value=error) from error
    if not inside:
        raise RobotError(
            "the path leaves the robot's folder",
            file=file,
            value=named,
            remedy="Put the file inside that folder, or give its folder as a package root",
        )
    return resolved
