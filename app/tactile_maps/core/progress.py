"""Progress of long work, and of a part of it as a share of the whole."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

Progress: TypeAlias = Callable[[str, float], None]
"""Called with a description of the current step and the completed fraction, 0 to 1; may raise to cancel."""


def no_progress(_text: str, _fraction: float) -> None:
    """Ignore progress."""


def part_of_progress(progress: Progress, start: float, stop: float) -> Progress:
    """Return the progress of a part that extends from ``start`` to ``stop`` of the whole."""

    def report(text: str, fraction: float) -> None:
        progress(text, start + (stop - start) * fraction)

    return report
