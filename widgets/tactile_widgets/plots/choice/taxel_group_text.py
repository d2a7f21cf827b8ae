"""A group of taxels that a person names, as the text that a plot's key and the settings' file have. No Qt."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

_RANGE = re.compile(r"(\d{1,9})(?:-(\d{1,9}))?")
_MOST = 1_000_000
"""Taxels in one group: no skin has more, and a settings' file that says so is not believed."""


@dataclass(frozen=True)
class TaxelGroup:
    """Taxels under one name.

    Attributes:
        name: What a person calls it.
        taxels: Their numbers, rising, at least one.
    """

    name: str
    taxels: tuple[int, ...]

    @property
    def text(self) -> str:
        """Like ``palm=3-9,12``."""
        return f"{self.name}={_ranges(self.taxels)}"

    @classmethod
    def parse(cls, text: str) -> TaxelGroup | None:
        """From such a text; None where that names no group."""
        name, _, said = text.rpartition("=")
        found = [_RANGE.fullmatch(part) for part in said.split(",")]
        spans = [(int(one[1]), int(one[2] or one[1])) for one in found if one is not None]
        if not name or len(spans) != len(found) or sum(max(last - first, 0) + 1 for first, last in spans) > _MOST:
            return None
        taxels = sorted({taxel for first, last in spans for taxel in range(first, last + 1)})
        return cls(name, tuple(taxels)) if taxels else None


def _ranges(taxels: Iterable[int]) -> str:
    numbers = sorted(set(taxels))
    breaks = [index for index, (one, other) in enumerate(pairwise(numbers), 1) if other != one + 1]
    runs = [numbers[start:end] for start, end in pairwise((0, *breaks, len(numbers)))]
    return ",".join(f"{run[0]}-{run[-1]}" if len(run) > 1 else f"{run[0]}" for run in runs)
