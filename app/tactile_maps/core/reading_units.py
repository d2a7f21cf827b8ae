"""What the values of taxels, and sums over them, may be called: the one place from which their units are told.

Within the program every reading is a number that stands for pascals, and every contact a number that stands for
newtons; where a real skin is not calibrated, one count stands for 1 kPa and nothing for a newton. Whoever shows such a
number asks here for its unit.
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
    """Of the readings that are shown."""

    CALIBRATED = "calibrated"
    """Pressures in kPa, whose sums over areas are forces in N: a simulated skin, or a calibrated one."""
    PRESSURE = "pressure"
    """The sender says that they are pressures; what the untouched skin says is not taken off, so sums are no forces."""
    COUNTS = "counts"
    """Of the electronics: no unit, and no force."""

    @property
    def unit(self) -> str:
        """Of one taxel's reading: ``kPa`` or ``counts``."""
        return _WORDS[self].unit

    @property
    def noun(self) -> str:
        """``pressure`` or ``reading``."""
        return _WORDS[self].noun.lower()

    @property
    def force(self) -> str | None:
        """Unit of a contact's sum; None where no force may be claimed."""
        return "N" if _WORDS[self].force else None

    @property
    def title(self) -> str:
        """Like "Pressure (kPa)", for scales and axes."""
        words = _WORDS[self]
        return f"{words.noun} ({words.unit})"

    @property
    def axis_label(self) -> str:
        """Like "pressure [kPa]", for figures of papers."""
        return f"{self.noun} [{self.unit}]"

    @property
    def strength_title(self) -> str:
        """Like "Contact force (N)": of how hard contacts are; without a unit where no force may be claimed."""
        return "Contact strength (relative)" if self.force is None else f"Contact force ({self.force})"

    def reading(self, pascals: float, digits: int = 1) -> str:
        """Like "4.2 kPa"."""
        return f"{1e-3 * pascals:.{digits}f}{THIN}{self.unit}"

    def force_words(self, newtons: float, digits: int = 1, *, space: str = THIN) -> str | None:
        """Like "4.2 N"; None where no force may be claimed."""
        return None if self.force is None else f"{newtons:.{digits}f}{space}{self.force}"

    def contact_words(self, newtons: float, peak: float, digits: int = 1, *, space: str = THIN) -> str:
        """How hard a contact is: its force, or where none may be claimed its highest reading."""
        told = self.force_words(newtons, digits, space=space)
        return f"{1e-3 * peak:.0f}{space}{self.unit}" if told is None else told


_WORDS = {
    ReadingUnits.CALIBRATED: _Words("kPa", "Pressure", True),
    ReadingUnits.PRESSURE: _Words("kPa", "Pressure", False),
    ReadingUnits.COUNTS: _Words("counts", "Reading", False),
}
