"""Results that are computed once from an immutable value and kept as long as the value exists."""

from __future__ import annotations

import atexit
from collections.abc import Callable
from functools import wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

_Value = TypeVar("_Value")
_Made = TypeVar("_Made")


def weak_cache(make: Callable[[_Value], _Made]) -> Callable[[_Value], _Made]:
    """Decorate a function to be called once for each value; its result is discarded together with the value.

    Unlike ``functools.cache`` this does not keep values alive, and unlike a cached property the result is not pickled
    with the value. It is meant for frozen values that are compared by identity, such as a mesh or a skin. The result
    must not refer to the value, which would then never be released. Two threads that call at the same time may both
    compute the result.
    """
    made: WeakKeyDictionary[_Value, _Made] = WeakKeyDictionary()
    atexit.register(made.clear)  # native libraries report objects that outlive the interpreter

    @wraps(make)
    def known(value: _Value) -> _Made:
        found = made.get(value)
        if found is None:
            found = made[value] = make(value)
        return found

    return known
