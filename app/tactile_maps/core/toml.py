"""TOML written by people: read as typed values; every mistake is reported with line, key and remedy.

``TomlReader`` builds dataclasses from tables by their annotations. ``key_lines`` finds the line of each key, which
``tomllib`` does not report. ``number_remedy`` handles text in place of a number, such as "5 mm": units are not
accepted, but the message says what to write instead. ``toml_lines`` writes values that read back equal, to the last
digit.
"""

from __future__ import annotations

import json
import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import MISSING, fields
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path
from types import UnionType
from typing import Any, Literal, TypeAlias, TypeVar, Union, get_args, get_origin, get_type_hints

from tactile_maps.core.errors import SceneError, TactileMapsError, did_you_mean

KeyPath: TypeAlias = tuple[str | int, ...]
"""Keys from the top, with the number of the element in a list of tables: ``("objects", 0, "mass")``."""

_TOKEN = re.compile(
    r'"""(?:[^\\]|\\.)*?"{3,5}'  # strings of all four kinds, so that nothing inside them is taken for a key
    r"|'''.*?'{3,5}"
    r'|"(?:[^"\\\n]|\\.)*"'
    r"|'[^'\n]*'"
    r"|#[^\n]*"
    r"|[A-Za-z0-9_+:-]+"
    r"|[ \t\r]+"
    r"|\n|.",
    re.DOTALL,
)


MAX_KEYS = 32
"""Parts of a dotted key. The time of ``tomllib`` grows with the square of their number."""
_PART = r"""(?:[A-Za-z0-9_-]+|"(?:[^"\\\n]|\\.)*"|'[^'\n]*')"""
_LONG_KEY = re.compile(rf"(?<![A-Za-z0-9_-]){_PART}(?:[ \t]*\.[ \t]*{_PART}){{{MAX_KEYS}}}")


def check_key_depth(text: str, *, file: str | Path, error: type[TactileMapsError] = SceneError) -> None:
    """Reject dotted keys of more than ``MAX_KEYS`` parts, before the text is read.

    Raises:
        TactileMapsError: A key has too many parts; raised as ``error``, with the line.
    """
    if _LONG_KEY.search(text) is None:
        return  # the usual case; the code below distinguishes keys from the contents of strings and comments
    parts = 0
    joined = False
    for token, line in _tokens(text):
        if token == ".":
            joined = True
        elif token.strip(" \t"):
            parts = parts + 1 if joined else 1
            joined = False
            if parts > MAX_KEYS:
                remedy = f"The maximum is {MAX_KEYS} parts"
                raise error(
                    "a key has too many parts",
                    file=file,
                    place=f"line {line}",
                    value=f"more than {MAX_KEYS}",
                    remedy=remedy,
                )


_MOST_DIGITS = 4300
"""Digits above which Python refuses to read a whole number."""


def parse_toml(text: str, *, file: str | Path, error: type[TactileMapsError] = SceneError) -> dict[str, Any]:
    """Return the values of a TOML text, with limits on the length of keys and whole numbers.

    Raises:
        TactileMapsError: A dotted key has too many parts, a whole number has more than 64 bits, or lists or tables are
            nested too deep; raised as ``error``.
        ValueError: The text is not TOML.
    """
    check_key_depth(text, file=file, error=error)
    try:
        values = tomllib.loads(text)
    except RecursionError as cause:
        problem = "lists or tables are nested too deep"
        remedy = "Write them as tables with names"
        raise error(problem, file=file, remedy=remedy) from cause
    except tomllib.TOMLDecodeError:
        raise
    except ValueError:  # a decimal number that Python does not read: its first digits are enough to find its key
        text = re.sub(rf"[0-9_]{{{_MOST_DIGITS},}}", lambda match: match[0].replace("_", "")[:40], text)
        values = tomllib.loads(text)
    _check_whole_numbers(values, text, file, error)
    return values


def _check_whole_numbers(values: dict[str, Any], text: str, file: str | Path, error: type[TactileMapsError]) -> None:
    """Reject whole numbers of more than 64 bits: TOML does not allow them, and they are slow to process."""
    waiting: list[tuple[KeyPath, Any]] = [((), values)]
    while waiting:
        path, value = waiting.pop()
        if isinstance(value, dict):
            waiting += [((*path, key), item) for key, item in value.items()]
        elif isinstance(value, list):
            waiting += [((*path, number), item) for number, item in enumerate(value)]
        elif isinstance(value, int) and not -(2**63) <= value < 2**63:
            line = line_of(key_lines(text), path)
            name = ".".join(key for key in path if isinstance(key, str))
            digits = str(value) if value.bit_length() < 1000 else hex(value)  # text of hexadecimal digits takes no time
            raise error(
                "a whole number has more than 64 bits",
                file=file,
                place=f"line {line}, {name}",
                value=f"{digits[:24]}…",
                remedy="Choose one from -2^63 to 2^63 - 1",
            )


def key_lines(text: str) -> Mapping[KeyPath, int]:
    """Return the line, from 1, of every key and table header of a TOML text that ``tomllib`` accepts.

    Keys of inline tables are included; elements of plain lists are not, see ``line_of``.
    """
    return _KeyLocator(text).lines


def line_of(lines: Mapping[KeyPath, int], path: KeyPath) -> int | None:
    """Return the line of ``path``, or of the nearest table above it that has one."""
    for length in range(len(path), 0, -1):
        if path[:length] in lines:
            return lines[path[:length]]
    return None


class _KeyLocator:
    """Walks through a valid text statement by statement."""

    def __init__(self, text: str) -> None:
        self._tokens = list(_tokens(text))
        self._at = 0
        self._table: KeyPath = ()
        self._counts: dict[KeyPath, int] = {}
        self.lines: dict[KeyPath, int] = {}
        while self._at < len(self._tokens):
            self._statement()

    def _statement(self) -> None:
        token, line = self._tokens[self._at]
        if token == "\n":
            self._at += 1
        elif token == "[":
            self._header(line)
        else:
            self._pair(self._table)

    def _header(self, line: int) -> None:
        double = self._tokens[self._at + 1][0] == "["
        self._at += 2 if double else 1
        path = self._inside_arrays(self._keys("]"))
        self._at += 2 if double else 1
        if double:
            number = self._counts.get(path, 0)
            self._counts[path] = number + 1
            self.lines.setdefault(path, line)
            path = (*path, number)
        self.lines.setdefault(path, line)
        self._table = path

    def _inside_arrays(self, keys: KeyPath) -> KeyPath:
        """Return the path of a header; each list of tables on the way refers to its last element."""
        path: KeyPath = ()
        for number, key in enumerate(keys):
            path = (*path, key)
            if path in self._counts and number < len(keys) - 1:
                path = (*path, self._counts[path] - 1)
        return path

    def _pair(self, table: KeyPath) -> None:
        line = self._tokens[self._at][1]
        path = table
        for key in self._keys("="):
            path = (*path, key)
            self.lines.setdefault(path, line)
        self._at += 1
        self._value(path)

    def _keys(self, end: str) -> KeyPath:
        """The keys of a dotted name up to the token ``end``."""
        keys: list[str] = []
        while self._tokens[self._at][0] != end:
            token = self._tokens[self._at][0]
            if token != ".":
                keys += _unquoted_key(token)
            self._at += 1
        return tuple(keys)

    def _value(self, path: KeyPath) -> None:
        """Step over a value; inside an inline table each key is noted."""
        token = self._tokens[self._at][0]
        if token == "{":
            self._inline_table(path)
        elif token == "[":
            self._list(path)
        else:
            while self._at < len(self._tokens) and self._tokens[self._at][0] not in ("\n", ",", "]", "}"):
                self._at += 1

    def _inline_table(self, path: KeyPath) -> None:
        self._at += 1
        while self._tokens[self._at][0] != "}":
            if self._tokens[self._at][0] in (",", "\n"):
                self._at += 1
            else:
                self._pair(path)
        self._at += 1

    def _list(self, path: KeyPath) -> None:
        self._at += 1
        number = 0
        while self._tokens[self._at][0] != "]":
            if self._tokens[self._at][0] in (",", "\n"):
                self._at += 1
            else:
                self.lines.setdefault((*path, number), self._tokens[self._at][1])
                self._value((*path, number))
                number += 1
        self._at += 1


def _tokens(text: str) -> Iterator[tuple[str, int]]:
    """Iterate over all tokens except blanks and comments, each with its line."""
    line = 1
    for match in _TOKEN.finditer(text):
        token = match[0]
        if not (token.startswith("#") or (token.isspace() and token != "\n")):
            yield token, line
        line += token.count("\n")


def _unquoted_key(token: str) -> list[str]:
    """Return a key without quotes and escapes."""
    return list(tomllib.loads(f"{token} = 0")) if token[0] in "\"'" else [token]


_UNITS: dict[str, dict[str, float]] = {
    "lengths are in metres": {"m": 1, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "km": 1e3, "in": 0.0254},
    "masses are in kilograms": {"kg": 1, "g": 1e-3, "mg": 1e-6, "t": 1e3, "lb": 0.45359237},
    "times are in seconds": {"s": 1, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60, "h": 3600},
    "forces are in newtons": {"N": 1, "mN": 1e-3, "kN": 1e3},
    "pressures are in pascals": {"Pa": 1, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "bar": 1e5},
    "stiffness is in newtons per metre": {"N/m": 1, "kN/m": 1e3, "MN/m": 1e6, "N/mm": 1e3, "N/cm": 1e2},
    "speeds are in metres per second": {"m/s": 1, "mm/s": 1e-3, "cm/s": 1e-2},
    "rates are in hertz": {"Hz": 1, "kHz": 1e3},
    "angles are in radians": {"rad": 1, "deg": 0.017453292519943295, "°": 0.017453292519943295},
}
_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\d\s].*?)?\s*")


def as_float(value: float) -> float:
    """Return a number of any size as a float; infinity if it is too large."""
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def number_remedy(text: str, *, degrees: bool = False) -> str:
    """Return the remedy for text in place of a number, such as "5 mm".

    Args:
        text: The text in place of the number.
        degrees: The number is an angle in degrees.
    """
    match = _QUANTITY.fullmatch(text)
    if match is None:
        return "Write a number, without quotes"
    number = float(match[1])
    unit = match[2]
    if unit is None:
        return f"Write {number:.12g}, without quotes"
    if unit in ("deg", "°") and degrees:
        return f"Angles are in degrees here: write {number:.12g}"
    for words, scales in _UNITS.items():
        if unit in scales:
            return f"{words.capitalize()}: write {number * scales[unit]:.12g}"
    known = [unit for scales in _UNITS.values() for unit in scales]
    close = get_close_matches(unit, known, n=1)
    return "There is no such unit; numbers are in SI units" + (f". Did you mean {close[0]}?" if close else "")


def toml_lines(values: Mapping[str, Any]) -> str:
    """Return one line for each key: words, numbers, lists and tables of these."""
    return "\n".join(f"{_key_text(key)} = {toml_value(value)}" for key, value in values.items())


def toml_value(value: Any) -> str:
    """Return a value as TOML; a tuple becomes a list, a mapping an inline table."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        # TOML has the escapes of JSON, and requires that DEL is escaped.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, tuple | list):
        return "[" + ", ".join(toml_value(item) for item in value) + "]"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key_text(key)} = {toml_value(item)}" for key, item in value.items()) + "}"
    return repr(value)


def _key_text(key: str) -> str:
    return key if re.fullmatch("[A-Za-z0-9_-]+", key) else toml_value(key)


T = TypeVar("T")
_NAMES = {float: "a number", int: "a whole number", str: "a word in quotes", bool: "true or false"}
_DEGREES = ("turn", "heading", "angle")


def check_keys(table: Mapping[str, object], kind: type, *, place: str) -> None:
    """Check that every key of a table is a field of the dataclass ``kind``.

    Args:
        table: Values by key.
        kind: The dataclass.
        place: Place of the table, for the error.

    Raises:
        SceneError: A key is unknown; the message lists the known keys.
    """
    known = tuple(field.name for field in fields(kind))
    for key in table:
        if key not in known:
            remedy = did_you_mean(str(key), known)
            raise SceneError("there is no such key", place=f"{place}.{key}", value=key, remedy=remedy)


class TomlReader:
    """Reader of the text of a scene.

    Args:
        text: TOML.
        file: Name in messages.
        top: Keys that belong above the first table, to be recognised when they are below one.

    Attributes:
        raw: The parsed tables.

    Raises:
        SceneError: The text is not TOML; the error states line and column.
    """

    def __init__(self, text: str, *, file: str, top: tuple[str, ...] = ()) -> None:
        self._text = text
        self._file = file
        self._top = top
        try:
            self.raw: dict[str, Any] = parse_toml(text, file=file)
        except ValueError as error:
            problem, _, place = str(error).partition(" (at ")
            place = place.rstrip(")").replace("end of document", f"line {len(text.splitlines())}")
            remedy = 'Write name = value on each line, words in "quotes", and the names of tables in [brackets]'
            raise SceneError(
                "the scene is not valid TOML", file=file, place=place or None, value=problem, remedy=remedy
            ) from error

    def error_at(
        self, problem: str, path: KeyPath, *, value: object = None, remedy: str | None = None, note: str = ""
    ) -> SceneError:
        """Return the error for the value at ``path``; ``note`` describes the part without a key."""
        line = line_of(self._lines, path)
        words = [f"line {line}"] if line else []
        words += [".".join(key for key in path if isinstance(key, str))] if path else []
        place = ", ".join([*words, note] if note else words)
        return SceneError(problem, file=self._file, place=place or None, value=value, remedy=remedy)

    @contextmanager
    def locating_errors(self, table: Mapping[str, Any], path: KeyPath) -> Iterator[None]:
        """Add the line to errors of values made from ``table`` at ``path``, by looking up their place in the table."""
        try:
            yield
        except TactileMapsError as error:
            found = self._walk(table, path, re.split(r"[ .]+", error.place or ""))
            note = (error.place or "") if found == path and not path else ""
            raise self.error_at(error.problem, found, value=error.value, remedy=error.remedy, note=note) from error

    def table(self, key: str) -> dict[str, Any]:
        """Return the table of that name; empty if missing."""
        value = self.raw.get(key, {})
        if not isinstance(value, dict):
            raise self.error_at("this must be a table", (key,), value=value, remedy=f"Write [{key}] above its lines")
        return value

    def tables(self, key: str) -> list[tuple[dict[str, Any], KeyPath]]:
        """Return the tables in the list of that name, with their paths."""
        value = self.raw.get(key, [])
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            remedy = f"Write [[{key}]] above each one's lines"
            raise self.error_at("these must be tables", (key,), value=value, remedy=remedy)
        return [(item, (key, number)) for number, item in enumerate(value)]

    def build(self, kind: type[T], table: Mapping[str, Any], path: KeyPath) -> T:
        """Return a dataclass built from its table."""
        values = self.fields(kind, table, path)
        with self.locating_errors(table, path):
            return kind(**values)

    def check_keys(self, table: Mapping[str, Any], known: tuple[str, ...], path: KeyPath) -> None:
        """Raise an error for the first key of a table that is not in ``known``."""
        for key in table:
            if key not in known:
                raise self.error_at("there is no such key", (*path, key), value=key, remedy=self._instead(key, known))

    def fields(self, kind: type, table: Mapping[str, Any], path: KeyPath) -> dict[str, Any]:
        """Return the keyword arguments of a dataclass; checks keys, types and required fields."""
        self.check_keys(table, tuple(field.name for field in fields(kind)), path)
        hints = get_type_hints(kind)
        for field in fields(kind):
            if field.default is MISSING and field.default_factory is MISSING and field.name not in table:
                remedy = f"Write {field.name} = ..."
                raise self.error_at("a key is missing", path, value=field.name, remedy=remedy)
        return {key: self.value(value, hints[key], (*path, key)) for key, value in table.items()}

    def value(self, value: Any, hint: Any, path: KeyPath) -> Any:
        """Return a TOML value converted to the type of an annotation."""
        origin = get_origin(hint)
        inner = get_args(hint)
        if origin in (Union, UnionType):
            return self._one_of(value, inner, path)
        if origin is Literal:
            if value not in inner:
                problem = f"unknown value of {path[-1]}" if path else "unknown value"
                raise self.error_at(problem, path, value=value, remedy=did_you_mean(str(value), inner))
            return value
        if origin is tuple:
            return self._several(value, inner, path)
        if isinstance(origin, type) and issubclass(origin, Mapping):
            return self._named(value, inner[1], path)
        return self._plain(value, hint, path)

    @cached_property
    def _lines(self) -> Mapping[KeyPath, int]:
        return key_lines(self._text)

    def _instead(self, key: str, known: tuple[str, ...]) -> str:
        if key in self._top:
            return f"Write it at the top, above the first table. {did_you_mean(key, known)}"
        return did_you_mean(key, known)

    def _walk(self, table: Any, path: KeyPath, words: list[str]) -> KeyPath:
        for word in words:
            if isinstance(table, dict) and word in table:
                table = table[word]
                path = (*path, word)
            elif isinstance(table, list) and word.isdecimal() and int(word) < len(table):
                table = table[int(word)]
                path = (*path, int(word))
        return path

    def _one_of(self, value: Any, hints: tuple[Any, ...], path: KeyPath) -> Any:
        """Convert to the first alternative that accepts this kind of value, whose mistakes are reported."""
        shape = Mapping if isinstance(value, dict) else tuple if isinstance(value, list) else None
        fitting = [hint for hint in hints if (get_origin(hint) or hint) in (shape, type(value))]
        fitting += [hint for hint in hints if isinstance(get_origin(hint), type) and shape is Mapping]
        plain = [hint for hint in hints if hint is not type(None)]
        return self.value(value, (fitting or plain)[0], path)

    def _several(self, value: Any, inner: tuple[Any, ...], path: KeyPath) -> tuple[Any, ...]:
        if not isinstance(value, list):
            raise self.error_at("this must be a list", path, value=value, remedy="Write [a, b, ...]")
        if inner[-1] is Ellipsis:
            inner = (inner[0],) * len(value)
        if len(value) != len(inner):
            problem = f"this must be a list of {len(inner)}, but it has {len(value)}"
            raise self.error_at(problem, path, value=value)
        return tuple(self.value(value[n], hint, (*path, n)) for n, hint in enumerate(inner))

    def _named(self, value: Any, hint: Any, path: KeyPath) -> dict[str, Any]:
        if not isinstance(value, dict):
            raise self.error_at("this must be a table", path, value=value, remedy="Write { name = value, ... }")
        return {key: self.value(item, hint, (*path, key)) for key, item in value.items()}

    def _plain(self, value: Any, kind: type, path: KeyPath) -> Any:
        if kind is float and type(value) in (int, float):
            if math.isfinite(as_float(value)):
                return float(value)
            finite = "Write a number, or leave the key out if it has a default"
            raise self.error_at("this must be a finite number", path, value=value, remedy=finite)
        if type(value) is kind:
            return value
        remedy: str | None = None
        if kind in (float, int) and isinstance(value, str):
            remedy = number_remedy(value, degrees=bool({*path} & {*_DEGREES}))
        elif kind is int and isinstance(value, float) and math.isfinite(value):
            remedy = f"Write {round(value)}"
        raise self.error_at(f"this must be {_NAMES[kind]}", path, value=value, remedy=remedy)
