"""Reads typed values from a scene's text; a mistake is named with its line, its key and what would be right."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import MISSING, fields
from functools import cached_property
from types import UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from app.errors import SceneError, TactileMapsError
from app.toml.line_numbers import Path, key_lines, line_of
from app.toml.nearest import nearest
from app.toml.units import as_float, number_instead

T = TypeVar("T")
_NAMES = {float: "a number", int: "a whole number", str: "a word in quotes", bool: "true or false"}
_DEGREES = ("turn", "heading", "angle")


class TomlReader:
    """One scene's text.

    Args:
        text: TOML.
        file: What to call it in messages.
        top: Keys that stand above the first table, to be recognised where they slipped below one.

    Attributes:
        raw: What TOML makes of it.

    Raises:
        SceneError: It is not TOML; line and column are named.
    """

    def __init__(self, text: str, *, file: str, top: tuple[str, ...] = ()) -> None:
        self._text, self._file, self._top = text, file, top
        try:
            self.raw: dict[str, Any] = tomllib.loads(text)
        except (ValueError, RecursionError) as error:
            problem, _, place = str(error).partition(" (at ")
            place = place.rstrip(")").replace("end of document", f"line {len(text.splitlines())}")
            raise SceneError("the scene is not valid TOML", file=file, place=place or None, value=problem) from error

    def mistake(
        self, problem: str, path: Path, *, value: object = None, remedy: str | None = None, note: str = ""
    ) -> SceneError:
        """The error for what stands at ``path``; ``note`` says which part of it, where no key does."""
        line = line_of(self._lines, path)
        words = [f"line {line}"] if line else []
        words += [".".join(key for key in path if isinstance(key, str))] if path else []
        place = ", ".join([*words, note] if note else words)
        return SceneError(problem, file=self._file, place=place or None, value=value, remedy=remedy)

    @contextmanager
    def locating(self, table: Mapping[str, Any], path: Path) -> Iterator[None]:
        """Give errors of values made from ``table`` at ``path`` their line: their place is looked for in the table."""
        try:
            yield
        except TactileMapsError as error:
            found = self._walk(table, path, re.split(r"[ .]+", error.place or ""))
            note = (error.place or "") if found == path and not path else ""
            raise self.mistake(error.problem, found, value=error.value, remedy=error.remedy, note=note) from error

    def table(self, key: str) -> dict[str, Any]:
        """The table of that name; empty where there is none."""
        value = self.raw.get(key, {})
        if not isinstance(value, dict):
            raise self.mistake("this must be a table", (key,), value=value, remedy=f"Write [{key}] above its lines")
        return value

    def tables(self, key: str) -> list[tuple[dict[str, Any], Path]]:
        """All tables of a list of that name, with their paths."""
        value = self.raw.get(key, [])
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            remedy = f"Write [[{key}]] above each one's lines"
            raise self.mistake("these must be tables", (key,), value=value, remedy=remedy)
        return [(item, (key, number)) for number, item in enumerate(value)]

    def build(self, kind: type[T], table: Mapping[str, Any], path: Path) -> T:
        """A dataclass from its table."""
        values = self.fields(kind, table, path)
        with self.locating(table, path):
            return kind(**values)

    def fields(self, kind: type, table: Mapping[str, Any], path: Path, *, skip: tuple[str, ...] = ()) -> dict[str, Any]:
        """Keyword arguments for a dataclass: known keys, each of its field's kind, none missing."""
        known = tuple(field.name for field in fields(kind))
        hints = get_type_hints(kind)
        for key in table:
            if key not in known:
                raise self.mistake("there is no such key", (*path, key), value=key, remedy=self._instead(key, known))
        for field in fields(kind):
            if field.default is MISSING and field.default_factory is MISSING and field.name not in table:
                remedy = f"Write {field.name} = ..."
                raise self.mistake("a key is missing", path, value=field.name, remedy=remedy)
        read = (key for key in table if key not in skip)
        return {key: self.value(table[key], hints[key], (*path, key)) for key in read}

    def value(self, value: Any, hint: Any, path: Path) -> Any:
        """A TOML value as the type that an annotation names."""
        origin, inner = get_origin(hint), get_args(hint)
        if origin in (Union, UnionType):
            return self._one_of(value, inner, path)
        if origin is Literal:
            if value not in inner:
                raise self.mistake("there is no such choice", path, value=value, remedy=nearest(str(value), inner))
            return value
        if origin is tuple:
            return self._several(value, inner, path)
        if isinstance(origin, type) and issubclass(origin, Mapping):
            return self._named(value, inner[1], path)
        return self._plain(value, hint, path)

    @cached_property
    def _lines(self) -> Mapping[Path, int]:
        return key_lines(self._text)

    def _instead(self, key: str, known: tuple[str, ...]) -> str:
        if key in self._top:
            return f"Write it at the top, above the first table. {nearest(key, known)}"
        return nearest(key, known)

    def _walk(self, table: Any, path: Path, words: list[str]) -> Path:
        for word in words:
            if isinstance(table, dict) and word in table:
                table, path = table[word], (*path, word)
            elif isinstance(table, list) and word.isdigit() and int(word) < len(table):
                table, path = table[int(word)], (*path, int(word))
        return path

    def _one_of(self, value: Any, hints: tuple[Any, ...], path: Path) -> Any:
        """The first alternative that takes such a value at all; its own mistakes are told."""
        shape = Mapping if isinstance(value, dict) else tuple if isinstance(value, list) else None
        fitting = [hint for hint in hints if (get_origin(hint) or hint) in (shape, type(value))]
        fitting += [hint for hint in hints if isinstance(get_origin(hint), type) and shape is Mapping]
        plain = [hint for hint in hints if hint is not type(None)]
        return self.value(value, (fitting or plain)[0], path)

    def _several(self, value: Any, inner: tuple[Any, ...], path: Path) -> tuple[Any, ...]:
        if not isinstance(value, list):
            raise self.mistake("this must be a list", path, value=value, remedy="Write [a, b, ...]")
        if inner[-1] is Ellipsis:
            inner = (inner[0],) * len(value)
        if len(value) != len(inner):
            problem = f"this must be a list of {len(inner)}, but it has {len(value)}"
            raise self.mistake(problem, path, value=value)
        return tuple(self.value(value[n], hint, (*path, n)) for n, hint in enumerate(inner))

    def _named(self, value: Any, hint: Any, path: Path) -> dict[str, Any]:
        if not isinstance(value, dict):
            raise self.mistake("this must be a table", path, value=value, remedy="Write { name = value, ... }")
        return {key: self.value(item, hint, (*path, key)) for key, item in value.items()}

    def _plain(self, value: Any, kind: type, path: Path) -> Any:
        if kind is float and type(value) in (int, float):
            if math.isfinite(as_float(value)):
                return float(value)
            raise self.mistake("this must be a finite number", path, value=value)
        if type(value) is kind:
            return value
        number = kind in (float, int) and isinstance(value, str)
        remedy = number_instead(value, degrees=bool({*path} & {*_DEGREES})) if number else None
        raise self.mistake(f"this must be {_NAMES[kind]}", path, value=value, remedy=remedy)
