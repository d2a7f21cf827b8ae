"""What a person says about taxels that place themselves on a surface."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, get_args

import numpy as np

from app.arrays import BoolArray, FloatArray, IntArray, readonly
from app.errors import SkinError

Pattern = Literal["even", "hexagonal", "modules"]
MODULE_PITCH = 0.0065
"""Distance of taxels on the triangular modules of iCub and CySkin [m]."""
MAX_TAXELS = 100_000
_PITCHES = 1e-5, 1.0


@dataclass(frozen=True, eq=False)
class Ball:
    """Keep out of a ball: ``centre`` (3,) [m], ``radius`` [m], in the surface's frame."""

    centre: FloatArray
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", _vector(self.centre, "ball"))
        if not 0 < self.radius < np.inf:
            raise SkinError("a ball to keep out of needs a radius above zero", place="keep out", value=self.radius)


@dataclass(frozen=True, eq=False)
class Box:
    """Keep out of a box along the axes of the surface's frame: corners ``low`` and ``high`` (3,) [m]."""

    low: FloatArray
    high: FloatArray

    def __post_init__(self) -> None:
        for name in ("low", "high"):
            object.__setattr__(self, name, _vector(getattr(self, name), "box"))
        if (self.low > self.high).any():
            raise SkinError("a box to keep out of is inside out", place="keep out", value=self.low.tolist())


@dataclass(frozen=True)
class BorderStrip:
    """Keep ``width`` [m] away from the surface's border, measured along its edges."""

    width: float

    def __post_init__(self) -> None:
        if not 0 <= self.width < np.inf:
            raise SkinError("a strip to keep out of needs a width", place="keep out", value=self.width)


@dataclass(frozen=True, eq=False)
class Painted:
    """Keep off every face with a marked corner: ``vertices`` (n,) true where marked."""

    vertices: BoolArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", readonly(self.vertices, bool))


Zone: TypeAlias = Ball | Box | BorderStrip | Painted


@dataclass(frozen=True, eq=False)
class PlacementSpec:
    """Wanted taxels.

    Attributes:
        pitch: Distance between neighbours [m], over the surface on average where the density varies.
        taxels: How many. State it or the pitch, not both; for neither, modules have their usual pitch.
        pattern: ``even``; ``hexagonal``, a lattice that bends with the surface; ``modules`` of ten taxels, as many
            triangles as fit.
        density: Taxels per area in proportion to this: None for the same everywhere, ``curvature`` for more where the
            surface bends, or a value above zero for each vertex. Only ratios count, and only for ``even``.
        keep_out: Where no taxel lies and nothing is felt.
        seed: The same taxels from the same seed.
    """

    pitch: float | None = None
    taxels: int | None = None
    pattern: Pattern = "even"
    density: Literal["curvature"] | FloatArray | None = None
    keep_out: tuple[Zone, ...] = ()
    seed: int = 0

    def __post_init__(self) -> None:
        if self.pattern not in get_args(Pattern):
            remedy = f"Choose one of: {', '.join(get_args(Pattern))}"
            raise SkinError("there is no such pattern", place="pattern", value=self.pattern, remedy=remedy)
        self._check_number()
        if isinstance(self.density, str) and self.density != "curvature":
            raise SkinError("there is no such density", place="density", value=self.density, remedy=_DENSITIES)
        if self.density is not None and self.pattern != "even":
            raise SkinError("only the even pattern follows a density", place="density", value=self.pattern)
        if self.density is not None and not isinstance(self.density, str):
            object.__setattr__(self, "density", _positive(self.density))

    def on_part(self, vertices: IntArray, *, taxels: int | None = None) -> PlacementSpec:
        """The same for a part of the surface that has only ``vertices`` (k,) of it, in that order.

        Args:
            vertices: Numbers of the whole surface's vertices.
            taxels: The part's share, if a number was asked for.
        """
        density = self.density[vertices] if isinstance(self.density, np.ndarray) else self.density
        zones = (Painted(zone.vertices[vertices]) if isinstance(zone, Painted) else zone for zone in self.keep_out)
        return replace(self, taxels=taxels, density=density, keep_out=tuple(zones))

    def _check_number(self) -> None:
        if self.pattern == "modules":
            if self.taxels is not None:
                raise SkinError(
                    "as many modules are placed as fit", place="taxels", value=self.taxels, remedy="State a pitch"
                )
        elif (self.pitch is None) == (self.taxels is None):
            raise SkinError("state the pitch or the number of taxels", place="pitch", value=(self.pitch, self.taxels))
        if self.taxels is not None and not 1 <= self.taxels <= MAX_TAXELS:
            remedy = f"Choose 1 to {MAX_TAXELS:,}"
            raise SkinError("that number of taxels cannot be placed", place="taxels", value=self.taxels, remedy=remedy)
        if self.pitch is not None and not _PITCHES[0] <= self.pitch <= _PITCHES[1]:
            remedy = f"Choose {_PITCHES[0]} to {_PITCHES[1]} m"
            raise SkinError("that pitch cannot be made", place="pitch", value=f"{self.pitch} m", remedy=remedy)


_DENSITIES = "Choose curvature, or one value above zero for each vertex"


def _vector(values: FloatArray, where: str) -> FloatArray:
    own = readonly(values)
    if own.shape != (3,) or not np.isfinite(own).all():
        raise SkinError("three finite numbers are needed", place=where, value=own.tolist())
    return own


def _positive(values: FloatArray) -> FloatArray:
    own = readonly(values)
    if own.ndim != 1 or not (np.isfinite(own) & (own > 0)).all():
        raise SkinError("a density must be above zero everywhere", place="density", value=own, remedy=_DENSITIES)
    return own
