"""Where in a TOML text each key stands: ``tomllib`` reads values but forgets their lines."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from typing import TypeAlias

Path: TypeAlias = tuple[str | int, ...]
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


def key_lines(text: str) -> Mapping[Path, int]:
    """The line, from 1, of every key and table header of a TOML text that ``tomllib`` accepts.

    Keys of inline tables are found as well; elements of plain lists are not: ask for the nearest key above.
    """
    return _Locator(text).lines


def line_of(lines: Mapping[Path, int], path: Path) -> int | None:
    """The line of ``path``, or of the nearest table above it that has one."""
    for length in range(len(path), 0, -1):
        if path[:length] in lines:
            return lines[path[:length]]
    return None


class _Locator:
    """Walks through a valid text statement by statement."""

    def __init__(self, text: str) -> None:
        self._tokens = list(_tokens(text))
        self._at = 0
        self._table: Path = ()
        self._counts: dict[Path, int] = {}
        self.lines: dict[Path, int] = {}
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

    def _inside_arrays(self, keys: Path) -> Path:
        """The path of a header: each list of tables on the way means its newest element."""
        path: Path = ()
        for number, key in enumerate(keys):
            path = (*path, key)
            if path in self._counts and number < len(keys) - 1:
                path = (*path, self._counts[path] - 1)
        return path

    def _pair(self, table: Path) -> None:
        line = self._tokens[self._at][1]
        path = table
        for key in self._keys("="):
            path = (*path, key)
            self.lines.setdefault(path, line)
        self._at += 1
        self._value(path)

    def _keys(self, end: str) -> Path:
        """The keys of a dotted name up to the token ``end``."""
        keys: list[str] = []
        while self._tokens[self._at][0] != end:
            token = self._tokens[self._at][0]
            if token != ".":
                keys += _plain(token)
            self._at += 1
        return tuple(keys)

    def _value(self, path: Path) -> None:
        """Step over a value; inside an inline table each key is noted."""
        token = self._tokens[self._at][0]
        if token == "{":
            self._inline_table(path)
        elif token == "[":
            self._list(path)
        else:
            while self._at < len(self._tokens) and self._tokens[self._at][0] not in ("\n", ",", "]", "}"):
                self._at += 1

    def _inline_table(self, path: Path) -> None:
        self._at += 1
        while self._tokens[self._at][0] != "}":
            if self._tokens[self._at][0] in (",", "\n"):
                self._at += 1
            else:
                self._pair(path)
        self._at += 1

    def _list(self, path: Path) -> None:
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
    """Everything but blanks and comments, each with its line."""
    line = 1
    for match in _TOKEN.finditer(text):
        token = match[0]
        if not (token.startswith("#") or (token.isspace() and token != "\n")):
            yield token, line
        line += token.count("\n")


def _plain(token: str) -> list[str]:
    """A key as its value holds it: quotes and escapes undone."""
    return list(tomllib.loads(f"{token} = 0")) if token[0] in "\"'" else [token]
