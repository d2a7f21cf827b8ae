"""The triangles of the OBJ and STL files that most robots come with, in a third of the time of a reader for everything.

Each reader gives what trimesh gives, bit for bit once corners at one place share a vertex, and None for whatever it is
not sure of: polygons, indices counted from the end, several materials, text where numbers should be. trimesh then reads
the file, or says what is wrong with it.
"""

from __future__ import annotations

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray

_STL_HEADER = 80
_STL_FACE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])


def read_plain_obj(data: bytes) -> tuple[FloatArray, IntArray] | None:
    """Vertices (n, 3) that faces use, in the file's order, and faces (m, 3) of an OBJ file of one material.

    Normals and texture coordinates are not looked at. Cost: 5 ms for a file of 1 MB.
    """
    text = data.strip().replace(b"\r\n", b"\n")
    if b"\\\n" in text or b"usemtl" in text.partition(b"\nf")[2]:
        return None
    lines = text.split(b"\n")
    rows = [line.split() for line in lines if line[:1] == b"f"]
    places = [line for line in lines if line[:2] == b"v "]
    if not places or {(row[0], len(row)) for row in rows} != {(b"f", 4)}:
        return None
    try:
        vertices = np.loadtxt(places, usecols=(1, 2, 3), comments=None, ndmin=2)
        corners = np.array([[int(corner.partition(b"/")[0]) for corner in row[1:]] for row in rows])
    except (ValueError, OverflowError):
        return None
    if corners.min() < 1 or corners.max() > len(vertices) or not np.isfinite(vertices).all():
        return None
    used = np.zeros(len(vertices), dtype=bool)
    used[corners - 1] = True
    return vertices[used], (np.cumsum(used) - 1)[corners - 1]


def read_binary_stl(data: bytes) -> tuple[FloatArray, IntArray] | None:
    """Vertices (3 m, 3), three for each face, and faces (m, 3) of a binary STL file; None of one in text.

    A file that states no faces has none, whatever follows: trimesh would search gigabytes for text.
    """
    start = _STL_HEADER + 4
    count = int.from_bytes(data[_STL_HEADER:start], "little")
    if len(data) < start or (count and len(data) != start + count * _STL_FACE.itemsize):
        return None
    corners = np.frombuffer(data, _STL_FACE, count, start)["corners"]
    return corners.reshape(-1, 3).astype(np.float64), np.arange(3 * count).reshape(-1, 3)
