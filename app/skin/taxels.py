"""Taxels of one patch: where they sit on its surface and which area each answers for."""

from __future__ import annotations

from dataclasses import dataclass

from app.arrays import FloatArray, IntArray, readonly


@dataclass(frozen=True, eq=False)
class Quadrature:
    """Evenly spread points that carry the patch's area; contact pressure is evaluated here, then summed by taxel.

    About ten a taxel: fewer miss contacts smaller than the pitch, more bring nothing.

    Attributes:
        positions: (q, 3) [m], link frame.
        normals: (q, 3) outward unit normals, link frame.
        areas: (q,) [m²]; they sum to the area that the taxels answer for.
        taxel: (q,) index of the taxel that each point belongs to, within the patch.
    """

    positions: FloatArray
    normals: FloatArray
    areas: FloatArray
    taxel: IntArray

    def __post_init__(self) -> None:
        for name in ("positions", "normals", "areas"):
            object.__setattr__(self, name, readonly(getattr(self, name)))
        object.__setattr__(self, "taxel", readonly(self.taxel, int))


@dataclass(frozen=True, eq=False)
class Taxels:
    """The taxels of one patch.

    Attributes:
        positions: (n, 3) [m], link frame, on the patch's surface.
        normals: (n, 3) outward unit normals.
        faces: (n,) triangle of the patch's surface that holds each taxel.
        weights: (n, 3) barycentric weights in that triangle.
        areas: (n,) [m²], each > 0; the sum of its quadrature points' areas.
        neighbours: (e, 2) pairs of taxels whose areas touch on the body (a seam does not separate them), i < j.
        quadrature: Where pressure is evaluated.
    """

    positions: FloatArray
    normals: FloatArray
    faces: IntArray
    weights: FloatArray
    areas: FloatArray
    neighbours: IntArray
    quadrature: Quadrature

    def __post_init__(self) -> None:
        for name in ("positions", "normals", "weights", "areas"):
            object.__setattr__(self, name, readonly(getattr(self, name)))
        for name in ("faces", "neighbours"):
            object.__setattr__(self, name, readonly(getattr(self, name), int))

    def __len__(self) -> int:
        return len(self.positions)
