"""The skin: patches on links, the taxels of each patch, and all taxels numbered through.

A taxel sits on its patch's surface and answers for an area; the area is carried by quadrature points, where pressure is
evaluated before it is summed by taxel.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from app.core.arrays import FloatArray, IntArray, freeze_arrays, readonly
from app.core.errors import Finding, SkinError
from app.geometry.mesh import Mesh, SurfacePoint
from app.skin.identity import NO_IDENTITY, TaxelIdentity, TaxelName, join_identities


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
        freeze_arrays(self, "positions", "normals", "areas")
        freeze_arrays(self, "taxel", dtype=np.int64)


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
        identity: What the robot's electronics call each of them, where a file stated it.

    Raises:
        SkinError: The identity is of another number of taxels.
    """

    positions: FloatArray
    normals: FloatArray
    faces: IntArray
    weights: FloatArray
    areas: FloatArray
    neighbours: IntArray
    quadrature: Quadrature
    identity: TaxelIdentity = NO_IDENTITY

    def __post_init__(self) -> None:
        freeze_arrays(self, "positions", "normals", "weights", "areas")
        freeze_arrays(self, "faces", "neighbours", dtype=np.int64)
        if self.identity.known and len(self.identity) != len(self.positions):
            found = f"{len(self.identity)} of {len(self.positions)} taxels"
            raise SkinError("the identity is of another number of taxels", place="identity", value=found)

    def __len__(self) -> int:
        return len(self.positions)


@dataclass(frozen=True, eq=False)
class Patch:
    """A piece of skin that covers one link.

    Attributes:
        name: Unique in the skin.
        link: Name of the link that it covers.
        surface: The outer surface in the link frame, not cut: what a finger meets. Connected and manifold.
        taxels: What it feels with.
    """

    name: str
    link: str
    surface: Mesh
    taxels: Taxels


@dataclass(frozen=True, eq=False)
class Skin:
    """All patches of a robot; taxel numbers run through the patches in order.

    Attributes:
        patches: In a stable order.
        findings: What was noticed and repaired while making it.

    Example:
        >>> at = skin.taxel_point(30)
        >>> skin.link(at), skin.position(at).shape, skin.areas.shape
        ('hand', (3,), (60,))
    """

    patches: tuple[Patch, ...]
    findings: tuple[Finding, ...] = ()

    @cached_property
    def first(self) -> IntArray:
        """(patches + 1,) number of each patch's first taxel; the last entry is the number of taxels."""
        return readonly(np.cumsum([0, *(len(p.taxels) for p in self.patches)]), np.int64)

    def __len__(self) -> int:
        """The number of taxels."""
        return int(self.first[-1])

    @cached_property
    def areas(self) -> FloatArray:
        """(n,) [m²]."""
        return readonly(np.concatenate([p.taxels.areas for p in self.patches]) if self.patches else np.zeros(0))

    @cached_property
    def patch_of(self) -> IntArray:
        """(n,) patch index of each taxel."""
        return readonly(np.repeat(np.arange(len(self.patches)), np.diff(self.first)), np.int64)

    @cached_property
    def neighbours(self) -> IntArray:
        """(e, 2) neighbouring taxels, numbered through the skin."""
        pairs = [p.taxels.neighbours + start for p, start in zip(self.patches, self.first[:-1], strict=True)]
        return readonly(np.concatenate(pairs) if pairs else np.zeros((0, 2)), np.int64)

    @cached_property
    def identity(self) -> TaxelIdentity:
        """Of all taxels, numbered through the skin; what only some patches state is None here."""
        return join_identities([patch.taxels.identity for patch in self.patches if len(patch.taxels)])

    def taxel_name(self, taxel: int) -> TaxelName:
        """What the robot's electronics call taxel number ``taxel``, as far as its patch states it."""
        patch = int(self.patch_of[taxel])
        return self.patches[patch].taxels.identity.name(taxel - int(self.first[patch]))

    def taxels_with_id(self, number: int) -> IntArray:
        """(k,) running numbers of the taxels whose hardware id is ``number``: several where boards repeat ids."""
        found = [
            start + np.flatnonzero(patch.taxels.identity.ids == number)
            for patch, start in zip(self.patches, self.first[:-1], strict=True)
            if patch.taxels.identity.ids is not None
        ]
        return readonly(np.concatenate(found) if found else np.zeros(0), np.int64)

    def taxel_point(self, taxel: int) -> SurfacePoint:
        """Where taxel number ``taxel`` sits."""
        patch = int(self.patch_of[taxel])
        taxels, local = self.patches[patch].taxels, taxel - int(self.first[patch])
        a, b, c = taxels.weights[local]
        return SurfacePoint(patch, int(taxels.faces[local]), (float(a), float(b), float(c)))

    def position(self, at: SurfacePoint) -> FloatArray:
        """(3,) [m], link frame of the patch's link."""
        return self.patches[at.patch].surface.point(at.face, at.weights)

    def normal(self, at: SurfacePoint) -> FloatArray:
        """(3,) outward unit normal, link frame."""
        return self.patches[at.patch].surface.normal(at.face, at.weights)

    def link(self, at: SurfacePoint) -> str:
        """Name of the link under the point."""
        return self.patches[at.patch].link
