"""How high water stands over a floor: the level at which a bed of springs carries a force."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from app.arrays import BoolArray, FloatArray, IntArray, dot


class Wet(NamedTuple):
    """The floors under water, and the level.

    Attributes:
        points: (k,) indices of the floors, rising.
        floors: (k,) their heights.
        areas: (k,) theirs.
        level: Of the water, at least as high as they.
    """

    points: IntArray
    floors: FloatArray
    areas: FloatArray
    level: float


class Guess:
    """Which floors were under water the last time: where to begin, never the answer. Mutable.

    Attributes:
        mask: (n,) whether each was, as bytes; empty before the first time.
        points: (k,) which.
        areas: (k,) theirs.
        total: Their sum.
    """

    __slots__ = ("areas", "mask", "points", "total")

    def __init__(self) -> None:
        self.mask = b""

    def update(self, wet: BoolArray, floors: FloatArray, areas: FloatArray) -> None:
        """Take the floors that are ``wet`` (n,), or the lowest if none is."""
        self.mask, points = wet.tobytes(), wet.nonzero()[0]
        self.points: IntArray = points if points.size else floors.argmin(0, keepdims=True)
        self.areas: FloatArray = areas.take(self.points)
        self.total = float(self.areas.sum())


def fill(floors: FloatArray, areas: FloatArray, volume: float, *, guess: Guess | None = None) -> Wet:
    """The level d with  sum areas max(0, d - floors) = volume,  exactly.

    Newton's method on a convex function made of straight pieces: for the floors of one piece the level is known, and if
    those are the floors below it, it is the answer. From any piece the first step leads to the answer or above, and
    from there down, so it ends. Nothing is sorted, and the answer does not depend on the guess.

    Args:
        floors: (n,) heights, not all inf; those of inf stay dry.
        areas: (n,) > 0.
        volume: >= 0; one so small that it rounds to nothing wets the lowest floor alone.
        guess: Of the same floors at another height; it is brought up to date.

    Cost: 2 µs when the guess is right, else 4 µs more for each of one to four steps, for 100 floors.
    """
    guess = Guess() if guess is None else guess
    if not guess.mask:
        guess.update(floors < math.inf, floors, areas)
    for _ in range(len(floors) + 2):
        here = floors.take(guess.points)
        level = (volume + dot(guess.areas, here)) / guess.total
        below = floors < level
        if below.tobytes() == guess.mask:
            return Wet(guess.points, here, guess.areas, level)
        guess.update(below, floors, areas)
    here = floors.take(guess.points)  # two levels apart by rounding take turns: a floor lies just between
    return Wet(guess.points, here, guess.areas, float(np.max(here, initial=level)))
