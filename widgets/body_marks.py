"""What an edit tool marks on the body, as places of the skin: the robot view hides what something else hides."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from app.arrays import IntArray
from app.geometry.surface_point import SurfacePoint
from widgets.colours import Theme
from widgets.task_shown import SkinLine

SEAM_INK = "#343b44"
"""Of seams on the skin, whose ground is light in both themes."""


class Role(Enum):
    """What a mark means; each has its colour and its dash or shape."""

    SEAM = "seam"
    HELD = "held"
    OFFERED = "offered"
    ERASED = "erased"
    PIN = "pin"
    WANTED = "wanted"
    SKETCHED = "sketched"

    @property
    def dashed(self) -> bool:
        """Whether its line is dashed: what is cut, and what could be."""
        return self in (Role.SEAM, Role.OFFERED, Role.SKETCHED)

    def ink(self, theme: Theme) -> str:
        """Its colour, as hex."""
        if self is Role.ERASED:
            return theme.fault
        if self in (Role.WANTED, Role.SKETCHED):
            return theme.intent
        return {Role.SEAM: SEAM_INK, Role.PIN: "#ffffff"}.get(self, theme.accent)


@dataclass(frozen=True, eq=False)
class BodyLine:
    """A line along edges.

    Attributes:
        patch: Which patch.
        vertices: (k,) of the patch's surface, in order.
        role: What it means.
    """

    patch: int
    vertices: IntArray
    role: Role


@dataclass(frozen=True, eq=False)
class BodyStroke:
    """A line anywhere on one patch.

    Attributes:
        line: Where.
        role: What it means.
    """

    line: SkinLine
    role: Role


@dataclass(frozen=True)
class BodySpot:
    """A small diamond.

    Attributes:
        at: Where on the skin.
        role: What it means.
        large: Whether it is under the pointer.
    """

    at: SurfacePoint
    role: Role
    large: bool = False


@dataclass(frozen=True, eq=False)
class BodyTint:
    """An area around vertices, seen through.

    Attributes:
        patch: Which patch.
        vertices: (k,) of the patch's surface.
    """

    patch: int
    vertices: IntArray


@dataclass(frozen=True, eq=False)
class BodyMarks:
    """All of a tool's marks at one moment; the very same object as long as nothing changes."""

    lines: tuple[BodyLine, ...] = ()
    spots: tuple[BodySpot, ...] = ()
    tints: tuple[BodyTint, ...] = ()
    strokes: tuple[BodyStroke, ...] = ()


NO_MARKS = BodyMarks()
