"""What is computed from a value that never changes, once for as long as the value lives."""

from __future__ import annotations

import atexit
from collections.abc import Callable
from functools import wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

_Value = TypeVar("_Value")
_Made = TypeVar("_Made")


def weak_cache(make: Callable[[_Value], _Made]) -> Callable[[_Value], _Made]:
    """Decorator: ``make`` is called once for each value, and what it made is forgotten with the value.

    Unlike ``functools.cache`` it keeps no value alive, and unlike a cached property it is not pickled with the value.
    For frozen values that are compared by identity, like a mesh or a skin; what is made must not refer to the value,
    which would then live for ever. Two threads that ask at the same time may both make it.
    """
    made: WeakKeyDictionary[_Value, _Made] = WeakKeyDictionary()
    atexit.register(made.clear)  # native libraries count what is left when the interpreter is gone

    @wraps(make)
    def known(value: _Value) -> _Made:
        found = made.get(value)
        if found is None:
            found = made[value] = make(value)
        return found

    return known
