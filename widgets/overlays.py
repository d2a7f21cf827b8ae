"""What is shown of the map besides touch, as the user set it: one ground under the touch, and marks on or off."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import Enum


class Ground(Enum):
    """What bare skin looks like; each value is the end of the name of the action that chooses it."""

    PRESSURE = "pressure"
    ANGLE = "angle"
    AREA = "area"
    CHECKER = "checker"
    CIRCLES = "circles"

    @property
    def title(self) -> str:
        """As in the legend."""
        return _TITLES[self]


_TITLES = {
    Ground.PRESSURE: "Pressure",
    Ground.ANGLE: "Stretch of angles",
    Ground.AREA: "Stretch of areas",
    Ground.CHECKER: "Checker",
    Ground.CIRCLES: "Circles",
}


@dataclass(frozen=True)
class Overlays:
    """The setting of View > Overlay.

    Attributes:
        ground: What bare skin looks like.
        seams: Whether cuts are dashed.
        border: Whether the skin's end is lined.
        pins: Whether pins are shown, whatever the tool.
        contours: Whether touched areas are lined.
        shapes: Whether contacts have their ellipse, and the circle in which their centre lies.
        taxel_ids: Whether taxels are numbered.
        dots: Whether each taxel is a dot of its own, instead of a picture interpolated between them.
    """

    ground: Ground = Ground.PRESSURE
    seams: bool = True
    border: bool = True
    pins: bool = False
    contours: bool = True
    shapes: bool = True
    taxel_ids: bool = False
    dots: bool = False

    def with_mark(self, name: str, *, shown: bool) -> Overlays:
        """The same with one mark on or off; ``name`` is one of ``MARKS``."""
        marks = {mark: getattr(self, mark) for mark in MARKS} | {name: shown}
        return Overlays(self.ground, **marks)

    def to_text(self) -> str:
        """For the settings' file: the ground and the marks that are on."""
        return " ".join([self.ground.value, *(name for name in MARKS if getattr(self, name))])

    @classmethod
    def from_text(cls, text: str) -> Overlays:
        """From the settings' file; what is not known there is as it first was."""
        ground, *marks = text.split() or [""]
        if ground not in [known.value for known in Ground]:
            return cls()
        return cls(Ground(ground), **{name: name in marks for name in MARKS})


MARKS = tuple(field.name for field in fields(Overlays) if field.name != "ground")
