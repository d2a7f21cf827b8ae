"""Mapping files: TOML that states which fields of another file hold the positions, ids and normals of its taxels.

The mapping of ``points.json`` is ``points.json.mapping.toml`` in the same folder; it is used wherever the file is
opened. ``mapping_template`` writes one to start from.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import fields
from pathlib import Path

from tactile_maps.core.errors import SkinError, did_you_mean, errors_in_file
from tactile_maps.core.files import read_bounded_text
from tactile_maps.core.toml import parse_toml
from tactile_maps.skin.formats.vendors.documents import TABLES, YAML, content_of
from tactile_maps.skin.formats.vendors.field_mapping import EVERY, FieldMapping, Node, taxel_sets_of
from tactile_maps.skin.model.taxel_axes import NUMBERS_OF_AXES
from tactile_maps.skin.model.taxel_set import METRES, TaxelSet

MAPPED = (".json", *YAML, *TABLES)
"""Suffixes of files that a mapping may describe."""
_ENDING = ".mapping.toml"
_MAX_BYTES = 2**16
_KEYS = tuple(field.name for field in fields(FieldMapping))
_TANGENTS = ("t1", "t2")
_VECTORS = ("position", "normal", *_TANGENTS)
_GUESSES: Mapping[str, tuple[str, ...]] = {
    "position": ("position", "pos", "xyz", "center", "centre", "point", "coordinates", "p"),
    "normal": ("normal", "n", "norm"),
    "id": ("id", "taxel_id", "index", "taxel", "number", "hw_id"),
    "module": ("module", "module_id", "board"),
    "channel": ("channel", "channel_id"),
    "area": ("area", "taxel_area"),
    "radius": ("radius",),
    "link": ("link", "link_name", "body", "frame", "frame_id", "parent"),
    "name": ("name", "label"),
    "axes": ("axes", "n_axes", "num_axes"),
    "t1": ("t1", "tangent"),
    "t2": ("t2",),
}
_EXAMPLES: Mapping[str, object] = {"unit": "mm", "axes": 3}
_ABOUT = {
    "position": "three fields, or one field of three numbers",
    "unit": "m, cm, mm or um",
    "normal": "three fields, or one field of three numbers; outward",
    "id": "hardware id; without it, taxels are numbered in order",
    "link": 'name of the link; "*" is the key that * in records stands for',
    "axes": "number of axes of every taxel, 1 or 3, or the field that holds it",
    "t1": "three fields, one field of three numbers, or three numbers for all; first tangent of the frame",
    "t2": "checked to be the normal x t1",
    "area": "area of the pad, in the square of the unit",
}


def mapping_path(path: Path) -> Path:
    """Return the path of the mapping file for a file."""
    return path.with_name(f"{path.name}{_ENDING}")


def mapping_remedy(path: Path) -> str:
    """Return the remedy for a file whose layout is unknown: the columns of a table, and the mapping file."""
    return (
        f"Write CSV with the columns x_mm, y_mm, z_mm (and nx, ny, nz, id, link), or name its fields in "
        f"{mapping_path(path).name} next to it; {template_command(path)}"
    )


def template_command(path: Path) -> str:
    """Return the command that prints a mapping file to start from, as part of a sentence."""
    return f"tactile-maps inspect {path.name} --mapping prints a template"


def unknown_layout(path: Path, document: object) -> SkinError:
    """Return the error about a file whose layout is unknown."""
    kind = "JSON" if path.suffix.lower() == ".json" else "YAML"
    found = "a list" if isinstance(document, list) else type(document).__name__
    if isinstance(document, dict):
        found = ", ".join(str(key)[:40] for key in list(document)[:12]) or "an empty object"
    problem = f"the layout of taxels in this {kind} file is unknown"
    return SkinError(problem, file=path, value=found, remedy=mapping_remedy(path))


def read_mapped(path: Path) -> tuple[TaxelSet, ...]:
    """Return the taxels of a file that has a mapping file, one set for each link.

    Raises:
        SkinError: The file or its mapping cannot be read, or a field is missing or invalid.
    """
    mapping = load_mapping(mapping_path(path))
    document = content_of(path)
    with errors_in_file(path):
        return taxel_sets_of(document, mapping, name=path.stem, where=path.name)


def load_mapping(path: Path) -> FieldMapping:
    """Read a mapping file.

    Raises:
        SkinError: The file cannot be read, a key is unknown or missing, or a value is of another kind.
    """
    text = read_bounded_text(path, most=_MAX_BYTES, error=SkinError)
    try:
        table = parse_toml(text, file=path, error=SkinError)
    except tomllib.TOMLDecodeError as error:
        raise SkinError("the file is not TOML", file=path, value=error) from error
    with errors_in_file(path):
        for key in table:
            if key not in _KEYS:
                raise SkinError("unknown key", place=key, remedy=did_you_mean(key, _KEYS))
        if "position" not in table:
            remedy = 'Name its fields, as in position = ["x", "y", "z"] or position = "pos"'
            raise SkinError("a key is missing", value="position", remedy=remedy)
        unit = table.get("unit")
        if unit is not None and unit not in METRES:
            raise SkinError("unknown unit", place="unit", value=unit, remedy=f"Choose one of: {', '.join(METRES)}")
        vectors = {key: _fields(key, value) for key, value in table.items() if key in _VECTORS}
        for key, value in table.items():
            if key in vectors:
                continue
            if key == "axes" and type(value) is int:
                if value not in NUMBERS_OF_AXES:
                    raise SkinError("must be 1, 3, or the name of a field", place=key, value=value)
            elif not isinstance(value, str):
                raise SkinError("must be the name of a field", place=key, value=value)
        return FieldMapping(**(table | vectors))


def _fields(key: str, value: object) -> tuple[str | float, ...]:
    """Return the names of one or three fields; for a tangent also three numbers."""
    if key in _TANGENTS and isinstance(value, list) and len(value) == 3 and all(type(x) in (int, float) for x in value):
        return tuple(value)
    names = (value,) if isinstance(value, str) else tuple(value) if isinstance(value, list) else ()
    if len(names) not in (1, 3) or not all(isinstance(name, str) for name in names):
        raise SkinError("must be the name of one field, or a list of three", place=key, value=value)
    return names


def mapping_template(path: Path) -> str:
    """Return a mapping file to start from: the fields of the file, and those that can be guessed from their names.

    Raises:
        SkinError: The file cannot be read, or is not one that a mapping may describe.
    """
    if path.suffix.lower() not in MAPPED:
        remedy = f"A mapping is for: {', '.join(MAPPED)}"
        raise SkinError("this type of file has no mapping", file=path, value=path.suffix.lower(), remedy=remedy)
    document = content_of(path)
    found = max(_candidates(Node(document), ""), key=_score, default=None)
    names = () if found is None else found[1]
    lines = [f"# Fields of {path.name}. Save this text as {mapping_path(path).name} next to it."]
    lines.append(f"# Fields of a record: {', '.join(names)[:200] or 'none were found'}")
    records = "" if found is None else found[0]
    lines.append(f"records = {json.dumps(records)}  # path to the records; empty if the file is the list")
    guessed = _guesses(names)
    for key in _KEYS:
        if key == "records":
            continue
        value = guessed.get(key)
        example = _EXAMPLES.get(key, ["x", "y", "z"] if key in _VECTORS else key)
        shown = example if value is None else value
        about = f"  # {_ABOUT[key]}" if key in _ABOUT else ""
        lines.append(f"{'' if value is not None or key == 'position' else '# '}{key} = {json.dumps(shown)}{about}")
    return "\n".join(lines) + "\n"


_Candidate = tuple[str, tuple[str, ...]]
"""Path to a list of records, and the fields of its first record."""


def _candidates(node: Node, path: str, *, depth: int = 0) -> Iterator[_Candidate]:
    """Yield the lists of records in a file, and the objects of parallel lists."""
    value = node.value
    if depth > 8:
        return
    if isinstance(value, list):
        first = next(node.children(), None)
        while (
            first is not None and isinstance(first.value, list) and any(isinstance(x, list | dict) for x in first.value)
        ):
            first = next(first.children(), None)
        if first is not None and isinstance(first.value, list):
            yield path, tuple(map(str, range(len(first.value))))
        elif first is not None and isinstance(first.value, dict):
            yield path, tuple(_field_names(first.value))
            yield from _candidates(first, path, depth=depth + 1)
    elif isinstance(value, dict):
        if any(isinstance(one, list) for one in value.values()):
            yield path, tuple(_field_names(value))
        for child in node.children():
            key = next(key for key, one in value.items() if one is child.value)
            yield from _candidates(child, f"{path}.{key}".lstrip("."), depth=depth + 1)
        if len(value) > 1 and all(isinstance(one, dict | list) for one in value.values()):
            yield from _candidates(next(node.children()), f"{path}.{EVERY}".lstrip("."), depth=depth + 1)


def _field_names(record: Mapping[str, object]) -> Iterator[str]:
    """Yield the fields of a record; those of nested objects with dots."""
    for key, value in record.items():
        if isinstance(value, dict):
            yield from (f"{key}.{name}" for name in _field_names(value))
        else:
            yield str(key)


def _score(candidate: _Candidate) -> tuple[bool, int]:
    guessed = _guesses(candidate[1])
    return "position" in guessed, len(guessed)


def _guesses(names: tuple[str, ...]) -> dict[str, object]:
    """Return the keys of a mapping that can be guessed from the names of the fields."""
    plain = {name.rpartition(".")[2].lower(): name for name in reversed(names)}
    found: dict[str, object] = {}
    for key, words in _GUESSES.items():
        word = next((word for word in words if word in plain), None)
        if word is not None:
            found[key] = plain[word]
    for key, letters in (("position", ("x", "y", "z")), ("normal", ("nx", "ny", "nz")), ("t1", ("t1x", "t1y", "t1z"))):
        for unit in ("", *METRES):
            columns = [f"{letter}_{unit}".rstrip("_") for letter in letters]
            if all(column in plain for column in columns):
                found[key] = [plain[column] for column in columns]
                found |= {"unit": unit} if unit else {}
    if names == ("0", "1", "2"):
        found["position"] = list(names)
    return found
