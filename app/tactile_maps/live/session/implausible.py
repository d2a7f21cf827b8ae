"""Impossible values in the readings of a real skin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NoReturn

from tactile_maps.live.readings.readings import MalformedReadingError


@dataclass
class ImplausibleValues:
    """Impossible values so far. Mutable.

    Attributes:
        count: Number of readings with an impossible value.
        text: The newest one: its name, value and range.
    """

    count: int = 0
    text: str = ""

    def report(self, text: str) -> None:
        """Count a reading that is used nevertheless."""
        self.count += 1
        self.text = text

    def refuse(self, problem: str, place: str, value: str, remedy: str) -> NoReturn:
        """Count a reading and raise MalformedReadingError."""
        self.report(f"{place}: {value}. {remedy}")
        raise MalformedReadingError(problem, place=place, value=value, remedy=remedy)
