"""Arrays belong to their values and are read-only for others."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from tactile_maps.core.arrays import (
    ArrayFields,
    BoolArray,
    FloatArray,
    IntArray,
    all_finite,
    any_true,
    dot,
    largest,
    length,
    readonly,
    refreeze,
    seal,
    set_fields,
)


@dataclass(frozen=True, eq=False)
class Box:
    content: Any


def test_read_only_array_is_not_copied():
    first = readonly([1.0, 2.0])
    assert readonly(first) is first
    assert readonly(first, np.int64) is not first
    assert readonly(first[:1]) is not first


@pytest.mark.parametrize(
    "wrap",
    [
        lambda a: a,
        lambda a: (a,),
        lambda a: [a],
        lambda a: {"a": a},
        lambda a: Box(a),
        lambda a: Box((Box({"deep": a}),)),
    ],
)
def test_refreeze_makes_pickled_arrays_read_only(wrap):
    def array_in(value):
        while not isinstance(value, np.ndarray):
            value = vars(value)["content"] if isinstance(value, Box) else value
            value = next(iter(value.values())) if isinstance(value, dict) else value
            value = value[0] if isinstance(value, tuple | list) else value
        return value

    copy = pickle.loads(pickle.dumps(wrap(readonly([1.0]))))
    assert array_in(copy).flags.writeable, "a read-only copy would leave nothing to restore"
    refreeze(copy)
    assert not array_in(copy).flags.writeable


def test_dot_equals_the_matrix_product():
    rng = np.random.default_rng(0)
    for count in (0, 1, 7, 20_001):
        a, b = rng.normal(size=(2, count))
        assert dot(a, b) == pytest.approx(float(a @ b), rel=1e-12, abs=1e-12)
        assert isinstance(dot(a, b), float)


@pytest.mark.parametrize("vector", [[], [3.0, 4.0], [1.0, -2.0, 2.0]])
def test_length_equals_the_euclidean_norm(vector):
    assert length(np.array(vector)) == pytest.approx(np.linalg.norm(vector))


@dataclass(frozen=True, eq=False)
class Samples(ArrayFields, points=2):
    times: FloatArray
    points: IntArray | None = None
    names: Any = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        set_fields(self, names=tuple(self.names))


@dataclass(frozen=True, eq=False)
class MarkedSamples(Samples):
    marked: BoolArray | None = None


def test_frozen_value_copies_its_arrays():
    times = np.zeros(3)
    samples = Samples(times, [1, 2, 3, 4], ["a"])
    times[0] = 1
    assert samples.times[0] == 0
    assert not samples.times.flags.writeable
    assert samples.points.tolist() == [[1, 2], [3, 4]]
    assert samples.points.dtype == np.int64
    assert samples.names == ("a",)
    again = Samples(samples.times, samples.points)
    assert again.points is samples.points, "what is safe already is not copied"
    assert Samples(times, []).points.shape == (0, 2)
    assert Samples(times).points is None


def test_subclass_converts_its_own_arrays():
    samples = MarkedSamples([1, 2], marked=[0, 1])
    assert (samples.times.dtype, samples.marked.dtype) == (np.float64, np.bool_)
    assert not samples.marked.flags.writeable
    assert Samples([1.0]).times.tolist() == [1.0], "the base class has no such field"


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_value_that_is_not_finite_is_found_at_any_place(bad):
    assert all_finite(np.zeros(0))
    assert all_finite(np.full(5, 1e300)), "large is not infinite"
    for place in range(5):
        values = np.zeros(5)
        values[place] = bad
        assert not all_finite(values)
        assert not all_finite(np.stack([np.zeros(5), values])[:, place]), "of a column, too"


def test_largest_is_the_largest_magnitude():
    assert largest(np.array([1.0, -3.0, 2.0])) == 3.0
    assert largest(np.zeros(0)) == 0.0
    assert np.isnan(largest(np.array([1.0, np.nan, 2.0])))


def test_sealed_array_is_not_copied():
    mine = np.zeros(3)
    seal(mine)
    assert readonly(mine) is mine


def test_any_true_finds_a_true_element():
    mask = np.zeros(5, dtype=bool)
    assert not any_true(mask)
    assert not any_true(mask[:0])
    mask[4] = True
    assert any_true(mask)
