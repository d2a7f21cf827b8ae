"""What every kind of stimulus says, whatever its fingers do."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from app.errors import SceneError
from app.stimuli.place import Ground, Place
from app.stimuli.track import Track
from app.touch.poke import Finger

_LONG = 3600.0
_FAR = 100.0


@dataclass(frozen=True, kw_only=True)
class Stimulus(ABC):
    """A scripted touch, as a value. The kinds add where and how.

    Attributes:
        patch: Name of the patch; empty for the first.
        force: The finger never pushes harder [N].
        press: How fast the fingertip goes into the skin while it pushes less than that [m/s].
        radius: Of the fingertip [m].
        stiffness: Of the finger [N/m].
        rest: Time after the lift before the stimulus counts as ended [s]; at least one tick.
        begin: When, since the script began [s]; None when the stimulus before it in the script has ended.
        repeat: How often it is done, once after the other.

    Raises:
        SceneError: A number is out of its range.
    """

    kind: ClassVar[str] = ""
    ranges: ClassVar[Mapping[str, tuple[float, float]]] = {}

    patch: str = ""
    force: float = 4.0
    press: float = 0.012
    radius: float = 0.008
    stiffness: float = 1000.0
    rest: float = 0.6
    begin: float | None = None
    repeat: int = 1

    def __post_init__(self) -> None:
        ranges = {
            "force": (0.0, 100.0),
            "press": (0.0, 1.0),
            "radius": (1e-4, 0.1),
            "stiffness": (1e-3, 1e6),
            "rest": (0.0, _LONG),
            "begin": (0.0, 1e6),
            "repeat": (1, 100_000),
            **self.ranges,
        }
        for name, (low, high) in ranges.items():
            value = getattr(self, name)
            if value is not None and not low <= value <= high:
                raise self.refusal(name, value, f"Choose {low:g} to {high:g}")

    @property
    def tip(self) -> Finger:
        """The finger that does it."""
        return Finger(self.stiffness, self.radius, self.force, self.press)

    @abstractmethod
    def tracks(self, ground: Ground) -> tuple[Track, ...]:
        """What its fingers do, each from its press to its lift.

        Raises:
            SceneError: There is no such place on this skin.
        """

    def refusal(self, name: str, value: object, remedy: str) -> SceneError:
        """The error that says that a field cannot be so."""
        return SceneError(f"a {self.kind} cannot be so", place=f"{self.kind}.{name}", value=value, remedy=remedy)

    def check_place(self, name: str, place: Place) -> None:
        """Refuse what is neither two fractions nor three coordinates.

        Raises:
            SceneError: Naming the field.
        """
        low, high = (0.0, 1.0) if len(place) == 2 else (-_FAR, _FAR)
        if len(place) not in (2, 3) or not all(low <= value <= high for value in place):
            raise self.refusal(
                name, list(place), "Write [along, around], each 0 to 1, or [x, y, z] in metres of the link's frame"
            )
