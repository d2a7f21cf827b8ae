"""Reading files that strangers wrote: bounded in size, inside their folder, and free of XML tricks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, ParseError

from defusedxml import ElementTree as SafeXml
from defusedxml.common import DefusedXmlException

from app.core.errors import RobotError

MAX_BYTES = 64 * 2**20
MAX_ELEMENTS = 200_000
MAX_DEPTH = 200


def read_bytes(path: Path) -> bytes:
    """The whole file, at most 64 MiB.

    Raises:
        RobotError: It is missing, a folder, too large, or not readable.
    """
    try:
        if path.is_dir():
            raise RobotError("this is a folder, not a file", file=path, remedy="Choose the robot's main file inside it")
        if path.stat().st_size > MAX_BYTES:
            raise RobotError(
                "the file is larger than 64 MB",
                file=path,
                value=f"{path.stat().st_size} bytes",
                remedy="Simplify its meshes or split it",
            )
        return path.read_bytes()
    except FileNotFoundError as error:
        raise RobotError("there is no such file", file=path, remedy="Check the path") from error
    except (OSError, ValueError) as error:
        raise RobotError("the file cannot be read", file=path, value=error) from error


def parse_xml(data: bytes, *, file: Path) -> Element:
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
