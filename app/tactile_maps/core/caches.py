"""Results that are kept: as long as the value exists from which they were computed, or for arrays of equal content."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import wraps
from hashlib import blake2b
from typing import ParamSpec, TypeVar, TypeVarTuple
from weakref import finalize, ref

import numpy as np
from numpy.typing import ArrayLike

_Values = TypeVarTuple("_Values")
_Made = TypeVar("_Made")
_Arguments = ParamSpec("_Arguments")


def weak_cache(make: Callable[[*_Values], _Made]) -> Callable[[*_Values], _Made]:
    """Decorate a function to be called once for the same values; its result is discarded together with any of them.

    Unlike ``functools.cache`` this does not keep values alive, and unlike a cached property the result is not pickled
    with the value. It is meant for frozen values that are compared by identity, such as a mesh or a skin; names may be
    among them. The result must not refer to a value, which would then never be released. Two threads that call at the
    same time may both compute the result.
    """
    made: dict[tuple[object, ...], _Made] = {}

    @wraps(make)
    def known(*values: *_Values) -> _Made:
        key = tuple(value if isinstance(value, str) else ref(value) for value in values)
        if key in made:
            return made[key]
        result = made[key] = make(*values)
        for value in values:
            if not isinstance(value, str):
                finalize(value, made.pop, key, None)  # also at exit: native libraries report objects that outlive it
        return result

    return known


def content_cache(
    content: Callable[_Arguments, Iterable[ArrayLike]], *, most: int
) -> Callable[[Callable[_Arguments, _Made]], Callable[_Arguments, _Made]]:
    """Decorate a function to be called once for each content of its arguments.

    Unlike ``weak_cache`` it also knows copies, such as those in a scene that is opened again or received from another
    process. Two threads that call at the same time may both compute the result.

    Args:
        content: Returns all that the result depends on, as arrays, from the arguments of the function.
        most: Number of results that are kept; those longest unused are discarded first.

    Cost of a known result: 1 ms for each megabyte of content.
    """

    def decorate(make: Callable[_Arguments, _Made]) -> Callable[_Arguments, _Made]:
        made: dict[bytes, _Made] = {}

        @wraps(make)
        def known(*args: _Arguments.args, **kwargs: _Arguments.kwargs) -> _Made:
            key = _digest(content(*args, **kwargs))
            result = made.pop(key, None)  # and last again
            if result is None:
                result = make(*args, **kwargs)
            made[key] = result
            while len(made) > most:
                del made[next(iter(made))]
            return result

        return known

    return decorate


def _digest(arrays: Iterable[ArrayLike]) -> bytes:
    digest = blake2b(digest_size=16)
    for array in map(np.asarray, arrays):
        digest.update(f"{array.dtype.str}{array.shape}".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.digest()
