"""Computed once for each value, and forgotten with it."""

from __future__ import annotations

import gc
import weakref
from dataclasses import dataclass

from tactile_maps.core.weak_cache import weak_cache


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
