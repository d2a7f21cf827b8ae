"""Vectors in the tangent plane of the skin as complex numbers, and turns between tangent planes."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.arrays import FloatArray

ComplexArray: TypeAlias = NDArray[np.complex128]


def plane_of(normal: FloatArray) -> FloatArray:
    """Return two unit vectors (3, 2) that form a right-handed frame with a unit normal (3,), as columns.

    Cost: 5 µs; with ``np.cross`` ten times as much.
    """
    x, y, z = normal.tolist()
    # The product of the normal and the axis that is farthest from it.
    across = ((0.0, z, -y), (-z, 0.0, x), (y, -x, 0.0))[int(np.abs(normal).argmin())]
    first = np.array(across)
    first /= np.linalg.norm(first)
    a, b, c = first.tolist()
    return np.array([[a, y * c - z * b], [b, z * a - x * c], [c, x * b - y * a]])


def as_complex(vectors: FloatArray) -> ComplexArray:
    """Return vectors (k, 2) as complex numbers (k,)."""
    return np.ascontiguousarray(vectors).view(np.complex128).ravel()


def as_vectors(numbers: ComplexArray) -> FloatArray:
    """Return complex numbers (k,) as vectors (k, 2)."""
    return numbers.view(np.float64).reshape(-1, 2)


def turned_into(frames: FloatArray, normal: FloatArray, plane: FloatArray) -> ComplexArray:
    """Return factors (k,) that turn a complex vector of ``plane`` into one along the axes t1 and t2 of each frame.

    The shortest rotation from n to m turns the plane into the tangent plane of a taxel; it moves a vector v across n to
    v - (m.v) / (1 + n.m) (n + m). Lengths do not change; conjugate factors turn back.

    Args:
        frames: (k, 3, 3) axes t1, t2 and n of the taxels, as rows.
        normal: (3,) unit normal of the plane; no taxel faces the opposite direction.
        plane: (3, 2) its axes, see ``plane_of``.
    """
    along = plane[:, 0]
    normals = frames[:, 2]
    share = (normals @ along) / (1.0 + normals @ normal)
    turned = along - share[:, None] * (normal + normals)
    return as_complex(np.einsum("ijk,ik->ij", frames[:, :2], turned))
