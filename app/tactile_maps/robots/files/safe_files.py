"""Safe reading of untrusted files: limited in size, inside their folder, and XML without entities."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, ParseError

from defusedxml import ElementTree as SafeXml
from defusedxml.common import DefusedXmlException

from tactile_maps.core.errors import Finding, RobotError
from tactile_maps.core.files import read_bounded_file

MAX_BYTES = 64 * 2**20
MAX_ELEMENTS = 200_000
MAX_DEPTH = 200


def read_bytes(path: Path) -> bytes:
    """Return the content of a file of at most 64 MiB.

    Raises:
        RobotError: The file is missing, a folder, too large, or not readable.
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
    """Return the root element of an XML document.

    Raises:
        RobotError: The document is not XML, declares a document type or entities, or is too large or nested too deep.
    """
    try:
        root: Element = SafeXml.fromstring(data, forbid_dtd=True)
    except DefusedXmlException as error:
        problem = "the XML declares a document type or entities, which are not allowed"
        raise RobotError(problem, file=file, remedy="Remove the <!DOCTYPE ...> part") from error
    except (ParseError, ValueError, LookupError) as error:
        remedy = "Open it in an editor at that line, or export it again"
        raise RobotError("the file is not valid XML", file=file, value=error, remedy=remedy) from error
    count = sum(1 for _ in root.iter())
    if count > MAX_ELEMENTS:
        raise RobotError(f"the XML has more than {MAX_ELEMENTS} elements", file=file, value=count)
    level = [root]
    depth = 0
    while level:
        level = [child for element in level for child in element]
        depth = depth + 1
    if depth > MAX_DEPTH:
        raise RobotError(f"the XML is nested more than {MAX_DEPTH} deep", file=file, value=depth)
    return root


_DECLARED_PREFIX = re.compile(rb"xmlns:([\w.-]+)")
_ENCODING = re.compile(rb"""encoding\s*=\s*["']([A-Za-z0-9._-]+)""")
_PREFIX = re.compile(rb"<([A-Za-z_][\w.-]*):|\s([A-Za-z_][\w.-]*):[\w.-]+\s*=")
_FOUND_IN_NAMES = "http://undeclared.prefix/"


def parse_model_xml(data: bytes, *, file: Path | str, findings: list[Finding] | None = None) -> Element:
    """Parse a model file like ``parse_xml``, with repairs; names lose their namespace, except those of xacro.

    In an invalid document, parts without meaning are repaired and reported: zero bytes and blanks around it, a
    declaration that is not at the start, comments, bytes that are not UTF-8, and undeclared prefixes. If the result is
    still invalid, the first error is raised.

    Args:
        data: The document.
        file: The file, for errors and findings.
        findings: Receives the repairs.

    Raises:
        RobotError: The document is rejected by ``parse_xml`` also after repairs.
    """
    try:
        root = parse_xml(data, file=file)
    except RobotError as error:
        repaired, what = _repaired(data)
        if not what:
            raise
        try:
            root = parse_xml(repaired, file=file)
        except RobotError:
            raise error from None
        if findings is not None:
            findings.append(Finding("xml-repaired", str(file), ", ".join(what)))
    for element in root.iter():
        if "}" in element.tag and "xacro" not in element.tag.split("}")[0]:
            element.tag = element.tag.split("}", 1)[1]
    return root


def _repaired(data: bytes) -> tuple[bytes, list[str]]:
    """Return the repaired document and the list of repairs."""
    what = []
    text = data.removeprefix(b"\xef\xbb\xbf").strip(b"\0 \t\r\n")
    if b"\0" in text or not text.startswith(b"<"):
        return data, []
    if text != data:
        what.append("blanks or zero bytes around the document were left out")
    if (bare := _without_comments(text)) != text:
        text = bare.strip()
        what.append("comments were left out")
    start = text.find(b"<?xml")
    end = text.find(b"?>", start) + 2
    declaration = text[start:end] if 0 <= start < end else b""
    text = text.replace(declaration, b"", 1) if declaration else text
    stated = _ENCODING.search(declaration)
    if stated is None or stated[1].lower() in (b"utf-8", b"utf8", b"us-ascii", b"ascii"):
        try:
            text.decode("utf-8")
        except UnicodeDecodeError:
            text = text.decode("latin-1").encode("utf-8")
            what.append("bytes that are not UTF-8 were read as Latin-1")
    else:
        text = declaration + text  # another encoding stays as stated
    return _with_prefixes_declared(text, what), what


def _without_comments(text: bytes) -> bytes:
    """Return the document without its comments, in linear time: a search by a pattern takes quadratic time where many
    of them are not closed.
    """
    kept = []
    at = 0
    while (start := text.find(b"<!--", at)) >= 0 and (end := text.find(b"-->", start + 4)) >= 0:
        kept.append(text[at:start])
        at = end + 3
    return b"".join([*kept, text[at:]])


def _with_prefixes_declared(text: bytes, what: list[str]) -> bytes:
    used = {name for pair in _PREFIX.findall(text) for name in pair if name} - {b"xml", b"xmlns"}
    missing = sorted(used - set(_DECLARED_PREFIX.findall(text)))
    start = re.search(rb"<[A-Za-z_][\w.-]*", text)
    if not missing or start is None or len(missing) > 20:
        return text
    what.append(f"prefixes were not declared: {', '.join(name.decode('ascii', 'replace') for name in missing)}")
    place = _FOUND_IN_NAMES.encode()
    declared = b"".join(b' xmlns:%s="%s%s"' % (name, place, name) for name in missing)
    return text[: start.end()] + declared + text[start.end() :]


def resolve_inside(path: Path, roots: Sequence[Path], *, file: Path, named: str) -> Path:
    """Return ``path`` without links and ``..``; it must be inside one of ``roots``.

    Args:
        path: The path.
        roots: Folders in which it may be.
        file: The file that names it.
        named: The name in that file.

    Raises:
        RobotError: The path is outside all of them.
    """
    try:
        resolved = path.resolve()
        inside = any(resolved.is_relative_to(root.resolve()) for root in roots)
    except (OSError, ValueError, RuntimeError) as error:
        raise RobotError("the path cannot be followed", file=file, place=named, value=error) from error
    if not inside:
        remedy = "Put the file inside that folder, or give its folder as a package root"
        raise RobotError("the path leaves the robot's folder", file=file, value=named, remedy=remedy)
    return resolved
