"""The one question every contact model answers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from app.arrays import FloatArray
from app.touch.load import Load


class ContactModel(Protocol):
    """From loads to pressures. It may remember neighbourhoods, never results.

    Attributes:
        notes: What it had to do instead of what it promises at the last reading, for people; empty when nothing.
    """

    notes: tuple[str, ...]

    def pressures(self, loads: Sequence[Load]) -> FloatArray:
        """(taxels,) mean pressure that each taxel feels [Pa]; loads add up."""
