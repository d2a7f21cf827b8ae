"""TOML that people write: every key has its line, every mistake its place and remedy, and what is written is read."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactile_maps.core.errors import Finding, LiveError, SceneError
from tactile_maps.core.toml import (
    MAX_KEYS,
    TomlReader,
    as_float,
    check_keys,
    key_lines,
    line_of,
    number_remedy,
    parse_toml,
    toml_lines,
    toml_value,
)

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


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("title",), 2),
        (("robot",), 3),
        (("cover",), 7),
        (("cover", "links"), 8),
        (("cover", "links", 1), 10),
        (("cover", "taxels"), 12),
        (("cover", "odd key"), 13),
        (("effects", "noise"), 14),
        (("effects", "noise", "sd"), 15),
        (("objects",), 16),
        (("objects", 0), 16),
        (("objects", 0, "name"), 17),
        (("objects", 1), 19),
        (("objects", 1, "path"), 21),
        (("objects", 1, "path", 1), 23),
        (("objects", 1, "more", "deep", "er"), 26),
        (("objects", 1, "more", "deep", "er", "b", "c"), 26),
        (("objects", 1, "parts", 1, "x"), 30),
    ],
)
def test_every_key_is_found(path, line):
    assert key_lines(TEXT)[path] == line


def test_text_that_looks_like_a_key_is_not_a_key():
    lines = key_lines(TEXT)
    assert ("task",) not in lines
    assert ("effects",) not in lines


def test_missing_key_has_the_line_of_its_table():
    lines = key_lines(TEXT)
    assert line_of(lines, ("cover", "thickness")) == 7
    assert line_of(lines, ("nothing",)) is None
    assert line_of(lines, ()) is None


@pytest.mark.parametrize(
    "text", ["", "\n\n", "# only\n", "a=1", "a=1\r\nb=2\r\n", 'a = """x"""""\nb = 1', "a = ''''x''''\n"]
)
def test_keys_are_found_in_unusual_toml_syntax(text):
    raw = tomllib.loads(text)
    assert {key for (key, *rest) in key_lines(text) if not rest} == set(raw)


KEYS = st.text("abc.#[]'= ", min_size=1, max_size=4)


@given(st.dictionaries(KEYS, st.one_of(st.integers(), KEYS, st.lists(KEYS, max_size=3)), max_size=6), st.integers(0, 3))
def test_any_keys_and_values_are_found(table, blank):
    """Each pair on a line of its own, quoted, with comments between."""
    lines = ["# x = 1"]
    for pair in table.items():
        lines += [*["# y = ["] * blank, toml_lines(dict([pair]))]
    expected = {key: 2 + number * (blank + 1) + blank for number, key in enumerate(table)}
    assert {path[0]: line for path, line in key_lines("\n".join(lines)).items() if len(path) == 1} == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("5 mm", "Lengths are in metres: write 0.005"),
        ("1.5cm", "write 0.015"),
        ("250 g", "kilograms: write 0.25"),
        ("-3e2 ms", "seconds: write -0.3"),
        ("20 kN/m", "newtons per metre: write 20000"),
        (".1 MPa", "pascals: write 100000"),
        ("50 Hz", "hertz: write 50"),
        ("180 deg", "radians: write 3.14159265359"),
        ("12", "Write 12, without quotes"),
        ("5 furlongs", "no such unit"),
        ("5 kpa", "Did you mean kPa"),
        ("soon", "Write a number, without quotes"),
        ("", "Write a number"),
        ("1 2", "Write a number"),
    ],
)
def test_remedy_states_the_number_to_write(text, expected):
    assert expected.lower() in number_remedy(text).lower()


def test_numbers_of_any_size_become_floats():
    assert as_float(3) == 3.0
    assert as_float(10**400) == math.inf
    assert as_float(-(10**400)) == -math.inf


def test_remedy_for_angles_in_degrees():
    assert "write 90" in number_remedy("90 deg", degrees=True)


PLAIN = st.one_of(
    st.text(st.characters(exclude_categories=["Cs"])),
    st.booleans(),
    st.integers(-(2**62), 2**62),
    st.floats(allow_nan=False),
)
VALUES = st.recursive(
    PLAIN,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(st.text(st.characters(exclude_categories=["Cs"])), inner, max_size=3),
    ),
    max_leaves=8,
)


@given(st.dictionaries(st.text(st.characters(exclude_categories=["Cs"])), VALUES, max_size=5))
def test_written_values_read_back(values):
    assert tomllib.loads(toml_lines(values)) == values


def test_tuples_become_lists_and_floats_stay_floats():
    assert toml_value((1.0, (2, "x"))) == '[1.0, [2, "x"]]'
    assert tomllib.loads(f"x = {toml_value(1e300)}")["x"] == 1e300
    assert tomllib.loads(f"x = {toml_value(math.inf)}")["x"] == math.inf


@dataclass(frozen=True)
class Settings:
    """Every kind of field there is."""

    name: str
    size: float = 1.0
    count: int = 1
    wide: bool = False
    colour: Literal["red", "green"] = "red"
    ends: tuple[float, float] = (0.0, 1.0)
    words: tuple[str, ...] = ()
    rows: tuple[tuple[float, float], ...] = ()
    posture: Mapping[str, float] | tuple[float, ...] = ()
    begin: float | None = None
    turn: tuple[float, ...] = ()
    more: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.size < 0:
            raise SceneError("a thing cannot be so", place="things.size", value=self.size)


def read(text):
    reader = TomlReader(text, file="f", top=("title",))
    return reader.build(Settings, reader.table("thing"), ("thing",))


def test_every_kind_of_value_is_read():
    thing = read("""[thing]
name = "x"
size = 2
count = 3
wide = true
colour = "green"
ends = [1, 2.5]
words = ["a"]
rows = [[1, 2], [3, 4]]
posture = { elbow = 1 }
begin = 2
more = { a = 1.5 }""")
    assert thing == Settings(
        "x", 2.0, 3, True, "green", (1.0, 2.5), ("a",), ((1.0, 2.0), (3.0, 4.0)), {"elbow": 1.0}, 2.0, (), {"a": 1.5}
    )
    assert type(thing.size) is float
    assert read('[thing]\nname = "x"\nposture = [1, 2]').posture == (1.0, 2.0)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('names = "y"', "line 3, thing.names: there is no such key .*Did you mean name"),
        ('zzzz = "y"', "thing.zzzz.*Choose one of: name, size"),
        ('title = "y"', "thing.title.*at the top, above the first table"),
        ("size = true", "line 3, thing.size: this must be a number"),
        ('size = "5 mm"', "thing.size.*metres: write 0.005"),
        ("size = nan", "thing.size: this must be a finite number .*Write a number, or leave the key out"),
        ("size = inf", "finite"),
        ("size = -1", "line 3, thing.size: a thing cannot be so"),
        ("count = 100.5", "thing.count: this must be a whole number .found: 100.5.. Write 100"),
        ("count = true", "whole number"),
        ("wide = 1", "thing.wide: this must be true or false"),
        ('colour = "gren"', "thing.colour.*Did you mean green\\? Choose one of: red, green"),
        ("ends = [1]", "list of 2, but it has 1"),
        ("ends = 1", r"thing.ends: this must be a list"),
        ("words = [1]", "thing.words: this must be a word in quotes"),
        ("rows = [\n  [1, 2],\n  [3],\n]", "line 5, thing.rows: this must be a list of 2"),
        ("rows = [1]", "thing.rows: this must be a list"),
        ("posture = { elbow = true }", "thing.posture.elbow: this must be a number"),
        ('posture = "up"', "thing.posture"),
        ('begin = "soon"', "thing.begin: this must be a number"),
        ('turn = ["90 deg"]', "thing.turn.*degrees here: write 90"),
        ("more = 1", "thing.more: this must be a table"),
    ],
)
def test_invalid_value_is_rejected_with_its_place(line, words):
    with pytest.raises(SceneError, match=f"(?s)f, .*{words}"):
        read(f'[thing]\nname = "x"\n{line}')


def test_key_with_too_many_parts_is_rejected_with_its_line():
    longest = ".".join("a" * MAX_KEYS)
    assert parse_toml(f'# {longest}.a\nb = "{longest}.a"\n{longest} = 1\n', file="a.toml")["b"] == f"{longest}.a"
    with pytest.raises(SceneError, match="line 2: a key has too many parts"):
        parse_toml(f"b = 1\n{longest} . a = 1\n", file="a.toml")


def test_missing_keys_and_tables_are_rejected():
    with pytest.raises(SceneError, match="line 2, thing: a key is missing .*name.*Write name"):
        read("\n[thing]")
    with pytest.raises(SceneError, match=r"line 1, thing: this must be a table.*\[thing\]"):
        read("thing = 1")
    with pytest.raises(SceneError, match=r"line 1, things: these must be tables.*\[\[things\]\]"):
        TomlReader("things = [1]", file="f").tables("things")
    assert TomlReader("", file="f").tables("things") == []


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a = ", "line 1"),
        ("a = 1\nb = [1,\n", "not valid TOML.*Write name = value on each line"),
        ("a = 1\na = 2", "line 2"),
        ("[" * 5000, "not valid TOML"),
    ],
)
def test_invalid_toml_is_rejected(text, words):
    with pytest.raises(SceneError, match=f"f.*{words}"):
        TomlReader(text, file="f")


def test_error_without_key_has_the_line_of_its_table():
    reader = TomlReader("\n[thing]\nx = [{ y = 1 }]", file="f")
    with (
        pytest.raises(SceneError, match="line 2, thing: odd"),
        reader.locating_errors(reader.table("thing"), ("thing",)),
    ):
        raise SceneError("odd", place="finger radius")
    with pytest.raises(SceneError, match="line 3, thing.x.y: odd"), reader.locating_errors(reader.raw, ()):
        raise SceneError("odd", place="thing.x.0.y")
    with pytest.raises(SceneError, match="f, elsewhere: odd"), reader.locating_errors(reader.raw, ()):
        raise SceneError("odd", place="elsewhere")


def test_unknown_key_is_rejected_with_its_place():
    check_keys({"where": 1}, Finding, place="thing")
    with pytest.raises(SceneError, match=r"thing\.counts: there is no such key .*Did you mean count"):
        check_keys({"counts": 1}, Finding, place="thing")


@pytest.mark.parametrize("digits", ["9" * 20, "9" * 5000, "9" * 200_000, "0x" + "f" * 200_000, "-1" + "0" * 20])
def test_integers_of_more_than_64_bits_are_rejected_with_line_and_key(digits):
    with pytest.raises(SceneError, match=r"line 2, b\.seed: a whole number has more than 64 bits .*Choose one from"):
        parse_toml(f"[b]\nseed = {digits}", file="scene.toml")
    assert parse_toml("least = -9223372036854775808", file="scene.toml") == {"least": -(2**63)}


@pytest.mark.parametrize("text", ["a = " + "[" * 100_000, "a = " + "{a = " * 100_000])
def test_toml_nested_too_deep_is_rejected_with_file_and_remedy(text):
    with pytest.raises(LiveError, match=r"c\.toml: lists or tables are nested too deep\. Write them"):
        parse_toml(text, file="c.toml", error=LiveError)
