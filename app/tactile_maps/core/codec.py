"""Strict conversion of frozen dataclasses to JSON and back, driven by their type hints.

``to_json`` and ``from_json`` convert between values and the objects of ``json``; ``dump_json`` and ``load_json``
between values and bytes. ``json_schema`` describes the format to other programs. Values read back equal, bit for bit.

====================================  ==============================================================================
hint                                  in JSON
====================================  ==============================================================================
``bool``, ``str``, ``None``           the same value
``int``                               a whole number within 64 bits; not true or false
``float``                             a finite number
``AnyFloat``                          a number, or one of the words "inf", "-inf", "nan"
``bytes``                             base64
``Literal``, ``Enum``                 the value, which must be one of those listed
``tuple``, fixed or of any length     a list
``Mapping`` with str or int keys      an object; a whole number is a key in decimal
an array of one axis                  a list of numbers
an array of several axes or none      {"shape": [lengths], "values": [numbers, the last axis fastest]}
a dataclass                           an object that names exactly its fields (one marked ``LATER`` may be missing)
a union of dataclasses                the same, and a key "kind" with the class's name
any other union                       the member that matches the kind of JSON value: word, number, list or object
====================================  ==============================================================================

Cost: about 0.2 µs for each number or word, in either direction; a type's hints are read once.
"""

from __future__ import annotations

import base64
import binascii
import json
import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from functools import cache
from operator import attrgetter
from pathlib import Path
from types import MappingProxyType, NoneType, UnionType
from typing import Annotated, Any, Literal, TypeAlias, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from tactile_maps.core.errors import TactileMapsError, did_you_mean, parser_message

NON_FINITE = "infinity and NaN are allowed"
"""Mark of a hint ``Annotated[float, NON_FINITE]``, also of an array, that allows infinity and NaN."""
LATER: Mapping[str, bool] = MappingProxyType({"later": True})
"""The ``metadata`` of a field that is missing in older files and then gets its default. It is always written."""
AnyFloat: TypeAlias = Annotated[float, NON_FINITE]
"""A float that may be infinite or NaN."""
JsonValue: TypeAlias = Any
"""None, bool, int, float, str, a list of these or a dictionary from words to these."""
Value = TypeVar("Value")

_WORDS = {"inf": math.inf, "-inf": -math.inf, "nan": math.nan}
_HIGHEST = 2**63
_KIND = "kind"
_ENCODER = json.JSONEncoder(check_circular=False, allow_nan=False, separators=(",", ":"))


def to_json(value: object, kind: Any = None) -> JsonValue:
    """Return ``value`` as plain JSON values.

    Args:
        value: A dataclass, or a value of type ``kind``.
        kind: Type hint of the value; by default its class.
    """
    hint: Any = type(value) if kind is None else kind
    return _codec(hint).written(value)


def dump_json(value: object) -> bytes:
    """Return a dataclass as one line of JSON in ASCII."""
    return _ENCODER.encode(to_json(value)).encode("ascii")


def from_json(
    kind: type[Value],
    raw: JsonValue,
    *,
    error: type[TactileMapsError],
    place: str = "",
    file: str | Path | None = None,
    remedy: str | None = None,
) -> Value:
    """Return the value that ``to_json`` wrote.

    Args:
        kind: Type of the value: a dataclass or any other hint.
        raw: Untrusted objects as parsed by ``json``.
        error: Class of the error to raise.
        place: Location of ``raw`` in the file, for errors; the location within it, such as ``regions[2].force``, is
            appended.
        file: Source of the text, for errors.
        remedy: Remedy for mistakes without a specific one.

    Raises:
        TactileMapsError: A key is missing or unknown, a value has another type, is out of range or not finite, or the
            class rejects it; raised as ``error``.
    """
    hint: Any = kind
    try:
        value: Value = _codec(hint).read(raw)
    except _Mistake as mistake:
        inside = "".join(reversed(mistake.path)).removeprefix(".")
        where = ", ".join(filter(None, (": ".join(filter(None, (place, inside))), mistake.note)))
        remedy = mistake.remedy or remedy
        raise error(mistake.problem, file=file, place=where or None, value=mistake.found, remedy=remedy) from mistake
    return value


def load_json(
    kind: type[Value],
    data: bytes | str,
    *,
    error: type[TactileMapsError],
    place: str = "",
    file: str | Path | None = None,
    remedy: str | None = None,
) -> Value:
    """Return the value that ``dump_json`` wrote; arguments and errors as for ``from_json``, also for invalid JSON."""
    try:
        raw = parse_json(data)
    except ValueError as cause:  # includes bytes that are not text
        raise error("this JSON cannot be read", file=file, place=place or None, value=cause, remedy=remedy) from cause
    return from_json(kind, raw, error=error, place=place, file=file, remedy=remedy)


def parse_json(data: bytes | str, *, constants: bool = False) -> JsonValue:
    """Parse an untrusted JSON text; all JSON of this program is parsed here.

    Args:
        data: The text.
        constants: Accept NaN, Infinity and -Infinity, for a caller that rejects them with their place.

    Raises:
        ValueError: The text is not JSON, is nested too deep, has a number of too many digits, has a duplicate key in an
            object, or has a constant that JSON does not define.
    """
    refuse = None if constants else _refuse_constant
    try:
        return json.loads(data, parse_constant=refuse, object_pairs_hook=_without_duplicates)
    except (ValueError, RecursionError) as error:
        if (message := parser_message(error)) == str(error):
            raise
        raise ValueError(message) from error


def json_schema(kind: Any) -> dict[str, Any]:
    """Return the JSON Schema of the output of ``to_json`` for the hint ``kind``."""
    return dict(_codec(kind).schema)


def _without_duplicates(pairs: list[tuple[str, JsonValue]]) -> dict[str, JsonValue]:
    values = dict(pairs)
    if len(values) < len(pairs):
        twice = Counter(key for key, _ in pairs).most_common(1)[0][0]
        raise ValueError(f"an object has the key {_described(twice[:80])} twice")
    return values


def _refuse_constant(word: str) -> float:
    raise ValueError(f"{word} is not a number in JSON")


class _Mistake(Exception):
    """Mistake in a value; ``path`` is extended from the inside out."""

    def __init__(self, problem: str, value: JsonValue, remedy: str | None = None, *, note: str = "") -> None:
        super().__init__(problem)
        self.problem = problem
        self.found = _described(value)
        self.remedy = remedy
        self.note = note
        self.path: list[str] = []


def _described(value: JsonValue) -> str:
    """Return a value for a message; objects and lists are summarised."""
    if isinstance(value, dict):
        return f"an object of {len(value)} keys"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    if type(value) is int and abs(value) >= _HIGHEST:
        return f"a whole number of {value.bit_length()} bits"
    if value is None or isinstance(value, bool):
        return json.dumps(value)
    return str(value)


@dataclass(frozen=True, eq=False)
class _Codec:
    """Conversions of one hint.

    Attributes:
        read: Converts a JSON value; raises ``_Mistake``.
        schema: JSON Schema.
        shapes: Python types of the JSON values that it reads.
        types: Python types of the values that it writes.
        write: The JSON value of a value; None where they are the same.
    """

    read: Callable[[JsonValue], Any]
    schema: dict[str, Any]
    shapes: tuple[type, ...]
    types: tuple[type, ...]
    write: Callable[[Any], JsonValue] | None = None

    def written(self, value: object) -> JsonValue:
        """Return a value as JSON value."""
        return value if self.write is None else self.write(value)


@cache
def _codec(hint: Any) -> _Codec:
    """Return the codec of a hint.

    Raises:
        TypeError: The hint is not supported, which is a mistake in the program.
    """
    hint = _without_alias(hint)
    origin = get_origin(hint)
    inner = get_args(hint)
    if origin is Annotated:
        return _annotated(inner[0], loose=NON_FINITE in inner[1:])
    if hint in _PLAIN:
        return _PLAIN[hint]
    if origin is Literal:
        return _choice({value: value for value in inner})
    if origin in (Union, UnionType):
        return _union(inner)
    if origin is tuple:
        return _list(_codec(inner[0])) if inner[-1] is Ellipsis else _row(tuple(map(_codec, inner)))
    if origin is np.ndarray:
        return _array(np.dtype(get_args(inner[1])[0]), loose=False)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return _mapping(*inner)
    if isinstance(hint, type) and issubclass(hint, Enum):
        return _choice({member.value: member for member in hint})
    if is_dataclass(hint) and isinstance(hint, type):
        return _object(hint)
    raise TypeError(f"there is no way to write {hint} as JSON")


def _without_alias(hint: Any) -> Any:
    """Return the hint behind an alias: from NumPy 2.5 on, with Python 3.12, ``NDArray`` is a ``TypeAliasType``."""
    meant = getattr(get_origin(hint), "__value__", None)
    return hint if meant is None else meant[get_args(hint)]


def _annotated(hint: Any, *, loose: bool) -> _Codec:
    hint = _without_alias(hint)
    if loose and hint is float:
        return _ANY_FLOAT
    if loose and get_origin(hint) is np.ndarray:
        return _array(np.dtype(get_args(get_args(hint)[1])[0]), loose=True)
    return _codec(hint)


def _plain(kind: type, name: str, problem: str) -> _Codec:
    def read(raw: JsonValue) -> Any:
        if type(raw) is not kind:
            raise _Mistake(problem, raw)
        return raw

    return _Codec(read, {"type": name}, (kind,), (kind,))


def _read_int(raw: JsonValue) -> int:
    if type(raw) is not int or not -_HIGHEST <= raw < _HIGHEST:
        raise _Mistake("this must be a whole number within 64 bits", raw)
    return raw


def _read_float(raw: JsonValue) -> float:
    if type(raw) is float and raw - raw == 0.0:
        return raw
    if type(raw) is not int or abs(raw) >= _HIGHEST:
        raise _Mistake("this must be a finite number", raw)
    return float(raw)


def _read_any_float(raw: JsonValue) -> float:
    return _WORDS[raw] if isinstance(raw, str) and raw in _WORDS else _read_float(raw)


def _write_float(value: float) -> float | str:
    """Return a finite number unchanged, and the word for any other. Where that is not allowed, reading fails."""
    return value if value - value == 0.0 else str(float(value))


def _read_bytes(raw: JsonValue) -> bytes:
    try:
        return base64.b64decode(raw if isinstance(raw, str) else "?", validate=True)
    except (binascii.Error, ValueError) as cause:
        raise _Mistake("this must be bytes in base64", f"{len(raw)} characters" if isinstance(raw, str) else raw) from (
            cause
        )


_ANY_FLOAT = _Codec(
    _read_any_float,
    {"anyOf": [{"type": "number"}, {"enum": list(_WORDS)}]},
    (float, int, str),
    (float, int),
    _write_float,
)
_PLAIN: dict[Any, _Codec] = {
    bool: _plain(bool, "boolean", "this must be true or false"),
    str: _plain(str, "string", "this must be text"),
    NoneType: _plain(NoneType, "null", "this must be null"),
    int: _Codec(_read_int, {"type": "integer"}, (int,), (int,)),
    float: _Codec(_read_float, {"type": "number"}, (float, int), (float, int), _write_float),
    bytes: _Codec(
        _read_bytes,
        {"type": "string", "contentEncoding": "base64"},
        (str,),
        (bytes,),
        lambda value: base64.b64encode(value).decode("ascii"),
    ),
}


def _choice(values: Mapping[Any, Any]) -> _Codec:
    """Return the codec of a choice between words or whole numbers; ``values`` are by their JSON values."""
    shapes = tuple({type(value) for value in values})

    def read(raw: JsonValue) -> Any:
        if type(raw) not in shapes or raw not in values:
            remedy = did_you_mean(_described(raw)[:80], tuple(map(str, values)))
            raise _Mistake("this is not one of the choices", raw, remedy)
        return values[raw]

    enum = any(isinstance(value, Enum) for value in values.values())
    types = tuple({type(value) for value in values.values()})
    return _Codec(read, {"enum": list(values)}, shapes, types, attrgetter("value") if enum else None)


def _list(item: _Codec) -> _Codec:
    """Return the codec of a tuple of any length."""
    read_item = item.read
    write_item = item.write

    def read(raw: JsonValue) -> tuple[Any, ...]:
        if type(raw) is not list:
            raise _Mistake("this must be a list", raw)
        values: list[Any] = []
        try:
            for value in raw:
                values.append(read_item(value))  # noqa: PERF401 (their number is the place of a mistake)
        except _Mistake as mistake:
            mistake.path.append(f"[{len(values)}]")
            raise
        return tuple(values)

    write = list if write_item is None else (lambda value: [write_item(one) for one in value])
    return _Codec(read, {"type": "array", "items": item.schema}, (list,), (tuple, list), write)


def _row(items: tuple[_Codec, ...]) -> _Codec:
    """Return the codec of a tuple of fixed length."""

    def read(raw: JsonValue) -> tuple[Any, ...]:
        if type(raw) is not list or len(raw) != len(items):
            raise _Mistake(f"this must be a list of {len(items)}", raw)
        values: list[Any] = []
        try:
            for item, value in zip(items, raw, strict=True):
                values.append(item.read(value))
        except _Mistake as mistake:
            mistake.path.append(f"[{len(values)}]")
            raise
        return tuple(values)

    def write(value: tuple[Any, ...]) -> list[JsonValue]:
        return [item.written(one) for item, one in zip(items, value, strict=True)]

    schemas = [item.schema for item in items]
    schema = {"type": "array", "prefixItems": schemas, "minItems": len(items), "maxItems": len(items)}
    return _Codec(read, schema, (list,), (tuple, list), write)


def _mapping(key: Any, value: Any) -> _Codec:
    """Return the codec of a mapping from words, or from whole numbers in decimal."""
    if key not in (str, int):
        raise TypeError(f"a key in JSON cannot be {key}")
    item = _codec(value)

    def read(raw: JsonValue) -> dict[Any, Any]:
        if type(raw) is not dict:
            raise _Mistake("this must be an object", raw)
        values: dict[Any, Any] = {}
        for name, one in raw.items():
            try:
                values[name if key is str else _read_key(name)] = item.read(one)
            except _Mistake as mistake:
                mistake.path.append(f".{name[:40]}")
                raise
        return values

    def write(values: Mapping[Any, Any]) -> dict[str, JsonValue]:
        return {str(name): item.written(one) for name, one in values.items()}

    return _Codec(read, {"type": "object", "additionalProperties": item.schema}, (dict,), (Mapping,), write)


def _read_key(name: str) -> int:
    digits = name.removeprefix("-")
    if not (digits.isascii() and digits.isdigit() and len(digits) < 20 and str(int(name)) == name):
        raise _Mistake("this key must be a whole number", name)
    return _read_int(int(name))


def _array(dtype: np.dtype[Any], *, loose: bool) -> _Codec:
    """Return the codec of an array of numbers or truth values."""
    kinds: set[type] = {"f": {float, int}, "i": {int}, "b": {bool}}[dtype.kind]  # type: ignore[assignment]

    def read_values(raw: JsonValue) -> Any:
        if type(raw) is not list:
            raise _Mistake("this must be a list of numbers", raw)
        if loose:
            raw = [_WORDS.get(value, value) if type(value) is str else value for value in raw]
        for number, value in enumerate(raw) if not {*map(type, raw)} <= kinds else ():
            if type(value) not in kinds:
                mistake = _Mistake("this must be a number", value)
                mistake.path.append(f"[{number}]")
                raise mistake
        try:
            values = np.array(raw, dtype=dtype)
        except OverflowError as cause:
            raise _Mistake("a number is too large", raw) from cause
        if dtype.kind == "f" and not loose and not np.isfinite(values).all():
            first = int(np.flatnonzero(~np.isfinite(values))[0])
            mistake = _Mistake("this must be a finite number", raw[first])
            mistake.path.append(f"[{first}]")
            raise mistake
        return values

    def read(raw: JsonValue) -> Any:
        if type(raw) is not dict:
            return read_values(raw)
        if raw.keys() != {"shape", "values"}:
            raise _Mistake("an array must have a shape and values", raw)
        shape = _SHAPE.read(raw["shape"])
        values = read_values(raw["values"])
        try:
            if min(shape, default=0) >= 0 and math.prod(shape) == len(values):
                return values.reshape(shape)
        except ValueError:  # more axes or longer ones than numpy has, though one has no length
            pass
        raise _Mistake("the array's shape does not fit its values", str(shape))

    def write(value: Any) -> JsonValue:
        values = value.ravel().tolist()
        if dtype.kind == "f" and not math.isfinite(sum(values)):  # for short arrays quicker than numpy
            values = [_write_float(one) for one in values]
        return values if value.ndim == 1 else {"shape": list(value.shape), "values": values}

    schema = {"type": ["array", "object"], "description": f"an array of {dtype.name}"}
    return _Codec(read, schema, (list, dict), (np.ndarray,), write)


_SHAPE = _list(_PLAIN[int])


def _object(kind: type) -> _Codec:
    """Return the codec of a dataclass, an object of its fields."""
    hints = get_type_hints(kind, include_extras=True)
    names = tuple(field.name for field in fields(kind) if field.init)
    codecs = {name: _codec(hints[name]) for name in names}
    later = frozenset(field.name for field in fields(kind) if field.metadata.get("later"))
    known = frozenset(names)
    readers = [(name, codec.read) for name, codec in codecs.items()]
    writers = [(name, codec.write) for name, codec in codecs.items() if codec.write is not None]
    taken = attrgetter(*names) if len(names) > 1 else lambda value: [getattr(value, name) for name in names]

    def read(raw: JsonValue) -> Any:
        if type(raw) is not dict:
            raise _Mistake("this must be an object", raw)
        if raw.keys() != known and not known - later <= raw.keys() <= known:
            raise _key_mistake(raw, names)
        values: dict[str, Any] = {}
        name = ""
        try:
            for name, reader in readers:
                if name in raw:
                    values[name] = reader(raw[name])
        except _Mistake as mistake:
            mistake.path.append(f".{name}")
            raise
        try:
            return kind(**values)
        except TactileMapsError as cause:  # the class knows its ranges
            raise _Mistake(cause.problem, cause.value or "", cause.remedy, note=cause.place or "") from cause
        except (ValueError, TypeError) as cause:
            raise _Mistake("these values are inconsistent", str(cause)) from cause

    def write(value: Any) -> dict[str, JsonValue]:
        result = dict(zip(names, taken(value), strict=True))
        for name, writer in writers:
            result[name] = writer(result[name])
        return result

    schema = {
        "type": "object",
        "required": [name for name in names if name not in later],
        "properties": {name: codec.schema for name, codec in codecs.items()},
        "additionalProperties": False,
    }
    return _Codec(read, schema, (dict,), (kind,), write)


def _key_mistake(raw: dict[str, JsonValue], names: tuple[str, ...]) -> _Mistake:
    for key in raw:
        if key not in names:
            return _Mistake("there is no such key", key[:80], did_you_mean(key[:80], names))
    missing = next(name for name in names if name not in raw)  # one that must be there: the others come last
    return _Mistake("a key is missing", missing)


def _union(hints: tuple[Any, ...]) -> _Codec:
    """Return the codec of a union: dataclasses have a tag, other types differ in the kind of JSON value."""
    classes = [hint for hint in hints if isinstance(hint, type) and is_dataclass(hint)]
    options = [_codec(hint) for hint in hints if hint not in classes]
    options += [_tagged(classes) if len(classes) > 1 else _codec(classes[0])] if classes else []
    by_shape: dict[type, _Codec] = {}
    for option in sorted(options, key=lambda option: len(option.shapes)):  # an int goes before a float
        for shape in option.shapes:
            if shape in by_shape and shape is not int:
                raise TypeError(f"JSON cannot distinguish {hints}")
            by_shape.setdefault(shape, option)
    problem = f"this must be {' or '.join(sorted({_NAMES[shape] for shape in by_shape}))}"

    def read(raw: JsonValue) -> Any:
        option = by_shape.get(type(raw))
        if option is None:
            raise _Mistake(problem, raw)
        return option.read(raw)

    def write(value: Any) -> JsonValue:
        # bool is an int to isinstance: the exact type goes first
        exact = (option for option in options if type(value) in option.types)
        option = next(exact, None) or next(option for option in options if isinstance(value, option.types))
        return option.written(value)

    types = tuple(kind for option in options for kind in option.types)
    return _Codec(read, {"anyOf": [option.schema for option in options]}, tuple(by_shape), types, write)


_NAMES = {
    NoneType: "null",
    bool: "true or false",
    int: "a number",
    float: "a number",
    str: "text",
    list: "a list",
    dict: "an object",
}


def _tagged(kinds: list[type]) -> _Codec:
    """Return the codec of several dataclasses, tagged with their names."""
    codecs = {kind.__name__: _codec(kind) for kind in kinds}
    if len(codecs) < len(kinds) or any(_KIND in codec.schema["properties"] for codec in codecs.values()):
        raise TypeError(f"{[*codecs]} cannot be distinguished by a key {_KIND!r}")
    choice = _choice({name: name for name in codecs})

    def read(raw: JsonValue) -> Any:
        if type(raw) is not dict or _KIND not in raw:
            raise _Mistake(f"this must be an object with a key {_KIND}", raw)
        try:
            name = choice.read(raw[_KIND])
        except _Mistake as mistake:
            mistake.path.append(f".{_KIND}")
            raise
        return codecs[name].read({key: value for key, value in raw.items() if key != _KIND})

    def write(value: Any) -> dict[str, JsonValue]:
        name = type(value).__name__
        return {_KIND: name, **codecs[name].written(value)}

    schemas = []
    for name, codec in codecs.items():
        properties = {_KIND: {"const": name}, **codec.schema["properties"]}
        schemas.append({**codec.schema, "required": [_KIND, *codec.schema["required"]], "properties": properties})
    return _Codec(read, {"oneOf": schemas}, (dict,), tuple(kinds), write)
