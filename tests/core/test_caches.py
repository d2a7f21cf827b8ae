"""Computed once for each value, and forgotten with it; computed once for each content."""

from __future__ import annotations

import gc
import weakref
from dataclasses import dataclass

import numpy as np

from tactile_maps.core.caches import content_cache, weak_cache


@dataclass(frozen=True, eq=False)
class Value:
    number: int


class Made:
    """A thing that can be waited for to go."""


def test_cached_result_is_made_once_per_value_and_deleted_with_it():
    asked = []

    @weak_cache
    def made_of(value: Value) -> Made:
        asked.append(value.number)
        return Made()

    first = Value(1)
    twin = Value(1)
    assert made_of(first) is made_of(first)
    assert made_of(twin) is not made_of(first)
    assert asked == [1, 1]
    made = weakref.ref(made_of(first))
    del first
    gc.collect()
    assert made() is None


def test_result_of_several_values_is_deleted_with_any_of_them():
    asked = []

    @weak_cache
    def made_of(value: Value, other: Value, name: str) -> Made | None:
        asked.append((value.number, other.number, name))
        return None if name == "none" else Made()

    values = {number: Value(number) for number in (1, 2, 3)}
    assert made_of(values[1], values[2], "a") is made_of(values[1], values[2], "a")
    assert made_of(values[1], values[2], "none") is made_of(values[1], values[2], "none") is None
    assert asked == [(1, 2, "a"), (1, 2, "none")]
    made = [weakref.ref(made_of(values[1], values[other], "b")) for other in (2, 3)]
    del values[2]
    gc.collect()
    assert made[0]() is None
    assert made[1]() is made_of(values[1], values[3], "b")


def test_result_is_made_once_for_equal_content_and_kept_while_used():
    asked = []

    @content_cache(lambda *arrays: arrays, most=2)
    def total(*arrays):
        asked.append([array.tolist() for array in arrays])
        return sum(float(array.sum()) for array in arrays)

    one = np.array([1.0, 2.0])
    assert total(one) == total(one.copy()) == 3.0
    assert len(asked) == 1
    assert total(one.reshape(1, 2)) == 3.0, "another shape"
    assert total(one) == 3.0
    assert total(one.astype(np.float32)) == 3.0, "another type; the result unused for the longest time is discarded"
    assert len(asked) == 3
    total(one)
    assert len(asked) == 3
    total(one.reshape(1, 2))
    assert len(asked) == 4


def test_content_is_not_joined_across_arrays():
    made = content_cache(lambda *arrays: arrays, most=8)(lambda *arrays: len(arrays))
    assert made(np.zeros(2), np.zeros(1)) == made(np.zeros(1), np.zeros(2)) == 2
    assert made(np.zeros(3)) == 1
