"""Dataclasses as JSON: equal when read back, strict when read, places named."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from typing_extensions import TypeAliasType

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.codec import (
    NON_FINITE,
    AnyFloat,
    dump_json,
    from_json,
    json_schema,
    load_json,
    parse_json,
    to_json,
)
from tactile_maps.core.errors import RecordingError, SceneError


class Colour(Enum):
    RED = "red"
    BLUE = "blue"


@dataclass(frozen=True)
class Ball:
    radius: float

    def __post_init__(self) -> None:
        if self.radius < 0:
            raise SceneError("a ball cannot be so small", place="radius", value=self.radius, remedy="Choose 0 or more")


@dataclass(frozen=True)
class Box:
    sides: tuple[float, float, float]


@dataclass(frozen=True)
class Region:
    force: float
    name: str


@dataclass(frozen=True)
class Everything:
    whole: int
    number: float
    free: AnyFloat
    flag: bool
    text: str
    data: bytes
    word: Literal["a", "b"]
    colour: Colour
    regions: tuple[Region, ...]
    pair: tuple[int, str]
    maybe: Region | None
    body: Ball | Box
    either: int | float | str | tuple[float, ...]
    by_name: Mapping[str, Region]
    by_number: dict[int, tuple[int, ...]] = field(default_factory=dict)


WHOLE = Everything(
    7,
    1 / 3,
    math.inf,
    True,
    "ü\u202f\n",
    b"\x00\xff",
    "b",
    Colour.BLUE,
    (Region(0.1, "x"), Region(0.2, "y")),
    (1, "one"),
    None,
    Box((1.0, 2.0, 3.0)),
    "word",
    {"left": Region(1e-300, "")},
    {-3: (1, 2), 10: ()},
)


@dataclass(frozen=True, eq=False)
class Arrays:
    floats: FloatArray
    whole: IntArray
    flags: BoolArray
    free: Annotated[FloatArray, NON_FINITE]


def read(raw: Any, kind: type = Everything) -> Any:
    return from_json(kind, raw, error=RecordingError, place="message", file="a.mcap", remedy="Mend it")


def test_written_value_reads_back_equal():
    again = load_json(Everything, dump_json(WHOLE), error=RecordingError)
    assert again == WHOLE
    assert type(again.by_number) is dict


def test_written_value_is_standard_json():
    raw = json.loads(dump_json(WHOLE), parse_constant=pytest.fail)
    assert raw["free"] == "inf"
    assert raw["body"] == {"kind": "Box", "sides": [1.0, 2.0, 3.0]}
    assert raw["by_number"] == {"-3": [1, 2], "10": []}


_Scalar = TypeVar("_Scalar", bound=np.generic)
_Alias = TypeAliasType("_Alias", np.ndarray[Any, np.dtype[_Scalar]], type_params=(_Scalar,))


@dataclass(frozen=True)
class Aliased:
    """Its hints are aliases, as NumPy 2.5 makes ``NDArray`` one."""

    counts: _Alias[np.int64]
    loose: Annotated[_Alias[np.float64], NON_FINITE]


def test_alias_of_an_array_type_is_supported():
    value = Aliased(np.arange(3), np.array([0.5, np.nan]))
    again = load_json(Aliased, dump_json(value), error=RecordingError)
    np.testing.assert_array_equal(again.counts, value.counts)
    np.testing.assert_array_equal(again.loose, value.loose)


@given(value=st.floats(), whole=st.integers(-(2**63), 2**63 - 1), text=st.text(), data=st.binary())
def test_every_value_reads_back(value, whole, text, data):
    raw = json.loads(dump_json(WHOLE)) | to_json(Some(value, whole, text, data))
    again = load_json(Everything, json.dumps(raw), error=RecordingError)
    assert (np.float64(again.free).tobytes(), again.whole) == (np.float64(value).tobytes(), whole) or math.isnan(value)
    assert math.isnan(again.free) == math.isnan(value)
    assert (again.text, again.data) == (text, data)


@dataclass(frozen=True)
class Some:
    free: AnyFloat
    whole: int
    text: str
    data: bytes


@given(values=arrays(np.float64, array_shapes(min_dims=0, max_dims=3, min_side=0)))
def test_every_array_reads_back_with_type_and_shape(values):
    finite = np.nan_to_num(values)
    value = Arrays(finite, finite.astype(bool).astype(np.int64), finite > 0, values)
    again = load_json(Arrays, dump_json(value), error=RecordingError)
    for name in ("floats", "whole", "flags", "free"):
        one = getattr(again, name)
        other = getattr(value, name)
        assert (one.dtype, one.shape) == (other.dtype, other.shape)
        assert np.array_equal(one, other, equal_nan=name == "free")


@pytest.mark.parametrize(
    ("changes", "place"),
    [
        ({"whole": 1.0}, "whole"),
        ({"whole": True}, "whole"),
        ({"whole": 2**63}, "whole"),
        ({"whole": "1"}, "whole"),
        ({"number": "1"}, "number"),
        ({"number": True}, "number"),
        ({"number": math.inf}, "number"),
        ({"number": "inf"}, "number"),
        ({"number": math.nan}, "number"),
        ({"number": 10**400}, "number"),
        ({"number": None}, "number"),
        ({"free": math.inf}, "free"),
        ({"free": "infinity"}, "free"),
        ({"flag": 1}, "flag"),
        ({"text": 1}, "text"),
        ({"text": None}, "text"),
        ({"data": "?"}, "data"),
        ({"data": 1}, "data"),
        ({"data": "ü"}, "data"),
        ({"word": "c"}, "word"),
        ({"word": ["a"]}, "word"),
        ({"colour": "green"}, "colour"),
        ({"colour": "RED"}, "colour"),
        ({"colour": True}, "colour"),
        ({"regions": {}}, "regions"),
        ({"regions": [{"force": 1, "name": ""}, {"force": "x", "name": ""}]}, "regions[1].force"),
        ({"regions": [{"force": 1}]}, "regions[0]"),
        ({"regions": [{"force": 1, "name": "", "more": 1}]}, "regions[0]"),
        ({"pair": [1]}, "pair"),
        ({"pair": [1, "a", 2]}, "pair"),
        ({"pair": ["a", 1]}, "pair[0]"),
        ({"maybe": 3}, "maybe"),
        ({"maybe": []}, "maybe"),
        ({"body": {"radius": 1}}, "body"),
        ({"body": {"kind": "Cone"}}, "body.kind"),
        ({"body": {"kind": ["Ball"], "radius": 1}}, "body.kind"),
        ({"body": {"kind": "Ball", "radius": -1}}, "body, radius"),
        ({"body": {"kind": "Box", "radius": 1}}, "body"),
        ({"body": {"kind": "Box", "sides": [1, 2]}}, "body.sides"),
        ({"either": None}, "either"),
        ({"either": True}, "either"),
        ({"either": [1, "a"]}, "either[1]"),
        ({"either": math.nan}, "either"),
        ({"by_name": []}, "by_name"),
        ({"by_name": {"left": 1}}, "by_name.left"),
        ({"by_number": {"x": []}}, "by_number.x"),
        ({"by_number": {"1.0": []}}, "by_number"),
        ({"by_number": {"01": []}}, "by_number"),
        ({"by_number": {"9" * 5000: []}}, "by_number"),
        ({"by_number": {"-": []}}, "by_number"),
        ({"more": 1}, ""),
    ],
)
def test_value_that_does_not_fit_its_hint_is_rejected_with_its_place(changes, place):
    assert read(to_json(WHOLE)) == WHOLE
    with pytest.raises(RecordingError) as refused:
        read(to_json(WHOLE) | changes)
    assert refused.value.file == "a.mcap"
    assert refused.value.place.startswith(f"message: {place}" if place else "message")
    assert refused.value.value is not None
    assert refused.value.remedy


@pytest.mark.parametrize("name", list(to_json(WHOLE)))
def test_missing_key_is_rejected_also_with_a_default(name):
    raw = to_json(WHOLE)
    del raw[name]
    with pytest.raises(RecordingError, match=f"a key is missing.*{name}"):
        read(raw)


def test_misspelt_key_is_rejected_with_the_nearest_one():
    with pytest.raises(RecordingError, match=r"regions\[0\]: there is no such key \(found: forze\).*mean force"):
        read(to_json(WHOLE) | {"regions": [{"forze": 1, "name": ""}]})


@pytest.mark.parametrize("raw", [None, 1, "x", [], True])
def test_other_value_than_an_object_is_rejected(raw):
    with pytest.raises(RecordingError, match="message: this must be an object"):
        read(raw)


@pytest.mark.parametrize(
    ("changes", "place"),
    [
        ({"floats": [1.0, "x"]}, "floats[1]"),
        ({"floats": [1.0, True]}, "floats[1]"),
        ({"floats": [1, math.inf]}, "floats[1]"),
        ({"floats": ["nan"]}, "floats[0]"),
        ({"floats": [[1.0]]}, "floats[0]"),
        ({"floats": 1.0}, "floats"),
        ({"floats": [10**400]}, "floats"),
        ({"floats": {"shape": [2], "values": [1.0]}}, "floats"),
        ({"floats": {"shape": [-1, -1], "values": [1.0]}}, "floats"),
        ({"floats": {"values": [1.0]}}, "floats"),
        ({"floats": {"shape": [10**13, 3], "values": []}}, "floats"),
        ({"floats": {"shape": [1] * 100, "values": [1]}}, "floats"),
        ({"floats": {"shape": [0, 10**18, 10**18], "values": []}}, "floats"),
        ({"whole": [1.5]}, "whole[0]"),
        ({"whole": [2**63]}, "whole"),
        ({"flags": [1]}, "flags[0]"),
        ({"free": ["in"]}, "free[0]"),
    ],
)
def test_damaged_arrays_are_rejected(changes, place):
    raw = to_json(Arrays(np.zeros(2), np.zeros(2, dtype=np.int64), np.zeros(2, dtype=bool), np.array([np.nan])))
    assert read(raw, Arrays).free.shape == (1,)
    with pytest.raises(RecordingError) as refused:
        read(raw | changes, Arrays)
    assert refused.value.place.startswith(f"message: {place}")


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\xff\xfe",
        b"{",
        b"NaN",
        b"[" * 200_000,
        b'{"a":' * 200_000,
        b"[" * 200_000 + b"]" * 200_000,
        b"1" * 5000,
        b"1e999",
        b'"\\ud800',
        "\ud800",
    ],
)
def test_invalid_text_is_rejected_with_a_short_error(data):
    with pytest.raises(RecordingError) as refused:
        load_json(Everything, data, error=RecordingError, place="message", file="a.mcap")
    assert refused.value.place == "message"
    assert len(str(refused.value)) < 400


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("[" * 200_000, "lists and objects are nested too deep"),
        ("9" * 5000, "a whole number has too many digits"),
        ('{"a": ', "Expecting value"),
    ],
)
def test_errors_of_the_parser_are_reworded(text, reason):
    with pytest.raises(RecordingError, match=rf"this JSON cannot be read \(found: {reason}"):
        load_json(Everything, text, error=RecordingError)
    with pytest.raises(ValueError, match=f"^{reason}"):
        parse_json(text)


@pytest.mark.parametrize("text", ['{"a": 1, "a": 1}', '[{"b": [{"a": 1, "c": 2, "a": 3}]}]'])
def test_duplicate_key_is_rejected_by_name(text):
    with pytest.raises(RecordingError, match="this JSON cannot be read.*has the key a twice"):
        load_json(Everything, text, error=RecordingError, place="message")


def test_messages_shorten_deep_values():
    deep: Any = []
    for _ in range(100_000):
        deep = [deep]
    with pytest.raises(RecordingError, match=r"found: a list of 1"):
        read(to_json(WHOLE) | {"text": deep})


def test_schemas_describe_written_values():
    schema = json_schema(Everything)
    assert schema["required"] == list(to_json(WHOLE))
    assert schema["additionalProperties"] is False
    assert schema["properties"]["word"] == {"enum": ["a", "b"]}
    assert schema["properties"]["colour"] == {"enum": ["red", "blue"]}
    kinds = [one["properties"]["kind"]["const"] for one in schema["properties"]["body"]["anyOf"][0]["oneOf"]]
    assert kinds == ["Ball", "Box"]
    assert json.loads(json.dumps(schema)) == schema


@dataclass(frozen=True)
class Kinded:
    kind: str


@pytest.mark.parametrize("hint", [complex, set[int], Mapping[float, int], str | Literal["a"], Kinded | Ball, list])
def test_ambiguous_hints_raise_type_error(hint):
    with pytest.raises(TypeError):
        json_schema(hint)
