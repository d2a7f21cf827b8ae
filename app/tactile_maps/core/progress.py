"""How long work says how far it is: one type for all of it, and a part of a work told as a share of the whole."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

Progress: TypeAlias = Callable[[str, float], None]
"""Told what is being done and how far it is, 0 to 1; may raise to cancel."""


def no_progress(_text: str, _fraction: float) -> None:
    """Nobody asks how far it is."""


def part_of_progress(progress: Progress, start: float, stop: float) -> Progress:
    """For work that is the part from ``start`` to ``stop`` of what ``progress`` is told of."""

    def report(text: str, fraction: float) -> None:
        progress(text, start + (stop - start) * fraction)

    return report
