"""Units of taxel readings and of sums over them, for every text that shows one.

Within the program every reading is in pascals and every contact force in newtons. For a real skin that is not
calibrated, one count is stored as 1 kPa, and sums have no unit.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

THIN = "\u202f"


class _Words(NamedTuple):
    unit: str
    noun: str
    force: bool


class ReadingUnits(Enum):
    """Units of displayed readings."""

    CALIBRATED = "calibrated"
    """Pressures in kPa, whose sums over areas are forces in N: a simulated or calibrated skin."""
    PRESSURE = "pressure"
    """Pressures according to the sender; the offset of the untouched skin is included, so sums are not forces."""
    COUNTS = "counts"
    """Raw counts of the electronics, without unit; sums are not forces."""

    @property
    def unit(self) -> str:
        """Unit of one taxel's reading: ``kPa`` or ``counts``."""
        return _WORDS[self].unit

    @property
    def noun(self) -> str:
        """``pressure`` or ``reading``."""
        return _WORDS[self].noun.lower()

    @property
    def force(self) -> str | None:
        """Unit of a contact's sum; None if the sum is not a force."""
        return "N" if _WORDS[self].force else None

    @property
    def title(self) -> str:
        """Title of scales and axes, such as "Pressure (kPa)"."""
        words = _WORDS[self]
        return f"{words.noun} ({words.unit})"

    @property
    def axis_label(self) -> str:
        """Axis label of figures for papers, such as "pressure [kPa]"."""
        return f"{self.noun} [{self.unit}]"

    @property
    def strength_title(self) -> str:
        """Title of contact strengths, such as "Contact force (N)"; without a unit if sums are not forces."""
        return "Contact strength (relative)" if self.force is None else f"Contact force ({self.force})"

    def reading(self, pascals: float, digits: int = 1) -> str:
        """Return a reading as text, such as "4.2 kPa"."""
        return f"{1e-3 * pascals:.{digits}f}{THIN}{self.unit}"

    def force_words(self, newtons: float, digits: int = 1, *, space: str = THIN) -> str | None:
        """Return a force as text, such as "4.2 N"; None if sums are not forces."""
        return None if self.force is None else f"{newtons:.{digits}f}{space}{self.force}"

    def contact_words(self, newtons: float, peak: float, digits: int = 1, *, space: str = THIN) -> str:
        """Return the strength of a contact as text: its force, or its highest reading if sums are not forces."""
        force = self.force_words(newtons, digits, space=space)
        return f"{1e-3 * peak:.0f}{space}{self.unit}" if force is None else force


_WORDS = {
    ReadingUnits.CALIBRATED: _Words("kPa", "Pressure", True),
    ReadingUnits.PRESSURE: _Words("kPa", "Pressure", False),
    ReadingUnits.COUNTS: _Words("counts", "Reading", False),
}
