"""Lines of keys: found where they stand, whatever stands around them."""

from __future__ import annotations

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.toml.line_numbers import key_lines, line_of
from app.toml.lines import toml_lines

TEXT = '''# title = "no"
title = "a # b [x]"
robot = """
task = "inside"
""" # here

[cover]
links = [
  "a", # ]
  "b",
]
taxels = 5
"odd key" = 'c:\\x'
[effects.noise]
sd = 1.5
[[objects]]
name = "one"
size = [0.1, 0.2]
[[objects]]
name = "two"
path = [
  [0, 1],
  [1, 2],
]
[objects.more]
deep.er = { a = 1, b = { c = [2] } }
[[objects.parts]]
x = 2026-01-01T00:00:00Z
[[objects.parts]]
x = -1_000
'''


@pytest.mark.parametrize(("path", "line"), [
    (("title",), 2), (("robot",), 3), (("cover",), 7), (("cover", "links"), 8), (("cover", "links", 1), 10),
    (("cover", "taxels"), 12), (("cover", "odd key"), 13), (("effects", "noise"), 14), (("effects", "noise", "sd"), 15),
    (("objects",), 16), (("objects", 0), 16), (("objects", 0, "name"), 17), (("objects", 1), 19),
    (("objects", 1, "path"), 21), (("objects", 1, "path", 1), 23), (("objects", 1, "more", "deep", "er"), 26),
    (("objects", 1, "more", "deep", "er", "b", "c"), 26), (("objects", 1, "parts", 1, "x"), 30),
])  # fmt: skip
def test_every_key_is_found(path, line):
    assert key_lines(TEXT)[path] == line


def test_what_is_no_key_is_not_found():
    lines = key_lines(TEXT)
    assert ("task",) not in lines
    assert ("effects",) not in lines


def test_the_nearest_table_stands_in():
    lines = key_lines(TEXT)
    assert line_of(lines, ("cover", "thickness")) == 7
    assert line_of(lines, ("nothing",)) is None
    assert line_of(lines, ()) is None


@pytest.mark.parametrize(
    "text", ["", "\n\n", "# only\n", "a=1", "a=1\r\nb=2\r\n", 'a = """x"""""\nb = 1', "a = ''''x''''\n"]
)
def test_odd_ends(text):
    raw = tomllib.loads(text)
    assert {key for (key, *rest) in key_lines(text) if not rest} == set(raw)


KEYS = st.text("abc.#[]'= ", min_size=1, max_size=4)


@given(st.dictionaries(KEYS, st.one_of(st.integers(), KEYS, st.lists(KEYS, max_size=3)), max_size=6), st.integers(0, 3))
def test_any_keys_and_values(table, blank):
    """Each pair on a line of its own, quoted, with comments between."""
    lines = ["# x = 1"]
    for pair in table.items():
        lines += [*["# y = ["] * blank, toml_lines(dict([pair]))]
    expected = {key: 2 + number * (blank + 1) + blank for number, key in enumerate(table)}
    assert {path[0]: line for path, line in key_lines("\n".join(lines)).items() if len(path) == 1} == expected
