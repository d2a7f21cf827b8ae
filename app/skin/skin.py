"""The skin: patches on links, and their taxels numbered through."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from app.arrays import FloatArray, IntArray, readonly
from app.errors import Finding
from app.geometry.mesh import Mesh
from app.geometry.surface_point import SurfacePoint
from app.skin.taxels import Taxels


@dataclass(frozen=True, eq=False)
class Patch:
    """A piece of skin worn by one link.

    Attributes:
        name: Unique in the skin.
        link: Name of the link that wears it.
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
