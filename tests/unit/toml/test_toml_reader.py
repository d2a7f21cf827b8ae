"""Typed values from TOML: each mistake with its line, its key and what would be right."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import pytest

from app.errors import SceneError
from app.toml.reader import TomlReader


@dataclass(frozen=True)
class Thing:
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
    return reader.build(Thing, reader.table("thing"), ("thing",))


def test_every_kind_of_value():
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
    assert thing == Thing("x", 2.0, 3, True, "green", (1.0, 2.5), ("a",), ((1.0, 2.0), (3.0, 4.0)), {"elbow": 1.0}, 2.0,
                          (), {"a": 1.5})  # fmt: skip
    assert type(thing.size) is float
    assert read('[thing]\nname = "x"\nposture = [1, 2]').posture == (1.0, 2.0)


@pytest.mark.parametrize(("line", "words"), [
    ('names = "y"', "line 3, thing.names: there is no such key .*Did you mean name"),
    ('zzzz = "y"', "thing.zzzz.*Choose one of: name, size"),
    ('title = "y"', "thing.title.*at the top, above the first table"),
    ("size = true", "line 3, thing.size: this must be a number"),
    ('size = "5 mm"', "thing.size.*metres: write 0.005"),
    ("size = nan", "thing.size: this must be a finite number"),
    ("size = inf", "finite"),
    ("size = -1", "line 3, thing.size: a thing cannot be so"),
    ("count = 1.5", "thing.count: this must be a whole number"),
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
])  # fmt: skip
def test_a_mistake_is_located(line, words):
    with pytest.raises(SceneError, match=f"(?s)f, .*{words}"):
        read(f'[thing]\nname = "x"\n{line}')


def test_what_is_missing_and_what_is_no_table():
    with pytest.raises(SceneError, match="line 2, thing: a key is missing .*name.*Write name"):
        read("\n[thing]")
    with pytest.raises(SceneError, match=r"line 1, thing: this must be a table.*\[thing\]"):
        read("thing = 1")
    with pytest.raises(SceneError, match=r"line 1, things: these must be tables.*\[\[things\]\]"):
        TomlReader("things = [1]", file="f").tables("things")
    assert TomlReader("", file="f").tables("things") == []


@pytest.mark.parametrize(("text", "words"), [
    ("a = ", "line 1"), ("a = 1\nb = [1,\n", "not valid TOML"), ("a = 1\na = 2", "line 2"),
    ("[" * 5000, "not valid TOML"),
])  # fmt: skip
def test_what_is_no_toml(text, words):
    with pytest.raises(SceneError, match=f"f.*{words}"):
        TomlReader(text, file="f")


def test_an_error_that_names_no_key_gets_the_line_of_its_table():
    reader = TomlReader("\n[thing]\nx = [{ y = 1 }]", file="f")
    with (
        pytest.raises(SceneError, match="line 2, thing: odd"),
        reader.locating(reader.table("thing"), ("thing",)),
    ):
        raise SceneError("odd", place="finger radius")
    with pytest.raises(SceneError, match="line 3, thing.x.y: odd"), reader.locating(reader.raw, ()):
        raise SceneError("odd", place="thing.x.0.y")
    with pytest.raises(SceneError, match="f, elsewhere: odd"), reader.locating(reader.raw, ()):
        raise SceneError("odd", place="elsewhere")
