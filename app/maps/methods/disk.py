"""A patch cut to a disk and made ready for any method: unit area, centred, with its first map."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from app.arrays import FloatArray, IntArray, readonly
from app.geometry.mesh import Mesh
from app.geometry.topology import boundary_loops
from app.maps.bijective import crossings
from app.maps.cut import CutSurface
from app.maps.methods.lscm import lscm
from app.maps.methods.tutte import evened, tutte
from app.maps.symmetric_dirichlet import SymmetricDirichlet

_STRAINED = 100.0
"""Mean energy of Tutte's map above which looking for a better start pays."""


@dataclass(frozen=True, eq=False)
class Disk:
    """A triangulated disk in space.

    Attributes:
        positions: (k, 3) of the cut's own vertices, scaled to unit area, so that no tolerance depends on the unit of
            length, and centred.
        faces: (m, 3), alike oriented, every vertex used.
    """

    positions: FloatArray
    faces: IntArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "positions", readonly(self.positions))
        object.__setattr__(self, "faces", readonly(self.faces, np.int64))

    @staticmethod
    def of(surface: Mesh, cut: CutSurface) -> Disk:
        """The disk that ``cut`` makes of ``surface``, which has an area."""
        positions = surface.vertices[cut.vertex_of]
        return Disk((positions - positions.mean(axis=0)) / np.sqrt(surface.area), cut.faces)

    @cached_property
    def loop(self) -> IntArray:
        """(b,) the border's vertices in order."""
        (loop,) = boundary_loops(self.faces)
        return loop

    @cached_property
    def energy(self) -> SymmetricDirichlet:
        """What maps of it are judged by."""
        return SymmetricDirichlet(self.positions, self.faces)

    @cached_property
    def start(self) -> FloatArray:
        """(k, 2) a one-to-one map of unit area: Tutte's, or where that is very uneven the best of three.

        Tutte's evened out once helps deep cups; on strips a thousand times longer than wide, which a circle can only
        press together, the conformal map is nearly the best already. It counts only where it is one-to-one.
        """
        first = self.scaled(tutte(self.positions, self.faces))
        if self.energy.energy(first) < _STRAINED:
            return first
        tried = [first, self.scaled(evened(self.positions, self.faces, first)), *self._conformal()]
        return min(tried, key=self.energy.energy)

    def _conformal(self) -> list[FloatArray]:
        try:
            plane = self.scaled(lscm(self.positions, self.faces, self.loop))
        except RuntimeError:  # libigl's only way to say that a system is singular
            return []
        return [plane] if np.isfinite(self.energy.energy(plane)) and not crossings(plane[self.loop]) else []

    def scaled(self, plane: FloatArray) -> FloatArray:
        """``plane`` (k, 2) enlarged to unit area, seen from the front."""
        area = self.area(plane)
        seen = plane * [1.0, -1.0] if area < 0 else plane
        return seen / np.sqrt(abs(area)) if area else plane

    def area(self, plane: FloatArray) -> float:
        """Signed area inside the border on ``plane`` (k, 2)."""
        here = plane[self.loop]
        after = np.roll(here, -1, axis=0)
        return float(0.5 * (here[:, 0] * after[:, 1] - here[:, 1] * after[:, 0]).sum())
