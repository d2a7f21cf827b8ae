"""Named array types, read-only copies for frozen values, and fast functions for short arrays."""

from __future__ import annotations

import math
from dataclasses import is_dataclass
from inspect import get_annotations
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]


def readonly(values: ArrayLike, dtype: Any = np.float64) -> NDArray[Any]:
    """Return a contiguous, read-only copy; an array that already owns such data is returned unchanged.

    Cost: 0.3 µs for a short array of that type; a control tick freezes two dozen of them.
    """
    if type(values) is np.ndarray and values.dtype == dtype:
        flags = values.flags
        if not flags.writeable and flags.c_contiguous and values.base is None:
            return values
        own = values.copy()
    else:
        own = np.array(values, dtype=dtype, order="C")
    own.flags.writeable = False
    return own


def set_fields(value: object, **fields: object) -> None:
    """Set fields of a frozen dataclass; only for ``__post_init__``."""
    for name, field in fields.items():
        object.__setattr__(value, name, field)


_DTYPES: dict[str, Any] = {"FloatArray": np.float64, "IntArray": np.int64, "BoolArray": np.bool_}


class ArrayFields:
    """Base of frozen dataclasses whose array fields become read-only arrays of the annotated type, see ``readonly``.

    Fields annotated ``FloatArray``, ``IntArray`` or ``BoolArray`` are converted, also those with ``| None``, where None
    is kept. Class arguments state numbers of columns: with ``class Mesh(ArrayFields, vertices=3)``, ``vertices`` is
    reshaped to (n, 3), also an empty list. A subclass with a ``__post_init__`` of its own calls this one first.
    """

    _array_fields: ClassVar[tuple[tuple[str, Any, int | None], ...]] = ()

    def __init_subclass__(cls, **columns: int) -> None:
        kinds = {name: str(kind).removesuffix(" | None") for name, kind in get_annotations(cls).items()}
        cls._array_fields += tuple(
            (name, _DTYPES[kind], columns.get(name)) for name, kind in kinds.items() if kind in _DTYPES
        )

    def __post_init__(self) -> None:
        for name, dtype, columns in self._array_fields:
            given = getattr(self, name)
            if given is None:
                continue
            if columns is not None and np.shape(given)[1:] != (columns,):
                given = np.reshape(given, (-1, columns))
            own = readonly(given, dtype)
            if own is not given:
                object.__setattr__(self, name, own)


_ONE_THREAD = 8192
"""Number of entries up to which BLAS computes a scalar product on the calling thread."""


def dot(a: FloatArray, b: FloatArray) -> float:
    """Return the scalar product of two vectors (n,), computed on the calling thread.

    For 10,000 entries or more, ``a @ b`` uses further threads of BLAS. If their cores are busy, for example with a
    simulation, it waits for a time slice (8 ms measured, instead of 6 µs).
    """
    return float(a.dot(b) if len(a) < _ONE_THREAD else np.einsum("i,i", a, b))


def length(vector: FloatArray) -> float:
    """Return the Euclidean norm of a vector (n,). Cost: 0.3 µs if short; ``np.linalg.norm`` takes 1 µs."""
    return math.sqrt(vector.dot(vector))


def within_length(vector: FloatArray, most: float) -> FloatArray:
    """Return a vector (n,), shortened to the length ``most`` if it is longer."""
    found = length(vector)
    return vector * (most / found) if found > most else vector


def largest(values: FloatArray) -> float:
    """Return the largest magnitude in (n,), 0 if empty, NaN if any is NaN. Half the time of ``np.abs().max()``."""
    if not len(values):
        return 0.0
    sizes = np.abs(values)
    return float(sizes[sizes.argmax()])


def seal(*arrays: NDArray[Any]) -> None:
    """Make arrays read-only that have no other owner, so that frozen values need no copy of them, see ``readonly``."""
    for array in arrays:
        array.flags.writeable = False


def all_finite(values: FloatArray) -> bool:
    """Whether all values are finite. Cost: 0.5 µs for a short array, half the overhead of ``np.all``."""
    return 0 not in np.isfinite(values).tobytes()


def any_true(mask: BoolArray) -> bool:
    """Whether any value is true. Cost: 0.2 µs for a short array; see ``all_finite``."""
    return 1 in mask.tobytes()


def refreeze(value: Any) -> None:
    """Make every array inside a value read-only again, in place, because pickling does not keep that flag.

    Includes arrays in dataclasses, tuples, lists and dictionaries.
    """
    if isinstance(value, np.ndarray):
        value.flags.writeable = False
    elif isinstance(value, tuple | list):
        for item in value:
            refreeze(item)
    elif isinstance(value, dict):
        for item in value.values():
            refreeze(item)
    elif is_dataclass(value) and not isinstance(value, type):
        refreeze(dict(vars(value)))
