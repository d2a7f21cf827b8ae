"""What every effect of the sensor answers, and what each is built for."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol
from zlib import crc32

import numpy as np

from app.arrays import FloatArray
from app.errors import SimulationError
from app.skin.skin import Skin


@dataclass(frozen=True, eq=False)
class Readout:
    """The skin that is read, how often, and where its chance comes from.

    Attributes:
        skin: Whose taxels.
        tick: From one reading to the next [s].
        seed: Of everything that is drawn, >= 0.

    Raises:
        SimulationError: Tick or seed is no such number.
    """

    skin: Skin
    tick: float
    seed: int

    def __post_init__(self) -> None:
        if not (math.isfinite(self.tick) and self.tick > 0):
            raise SimulationError("a sensor cannot be read so often", place="tick", value=f"{self.tick} s")
        if self.seed < 0:
            raise SimulationError("a seed cannot be negative", place="seed", value=self.seed, remedy="Choose 0 or more")

    def stream(self, effect: str) -> np.random.Generator:
        """An effect's own random numbers from the start; what other effects draw does not move them."""
        seeds = np.random.SeedSequence([self.seed, crc32(effect.encode())])
        return np.random.Generator(np.random.SFC64(seeds))  # a fifth quicker at normal numbers than PCG64


class Stage(Protocol):
    """One effect at work. It may remember; everything it remembers is in its state."""

    def read(self, pressures: FloatArray) -> FloatArray:
        """(taxels,) what leaves the stage [Pa] for what enters it, one tick after the last call; never in place."""

    def reset(self) -> None:
        """Back to before the first reading, random numbers included."""

    def state(self) -> FloatArray:
        """(k,) all that changes from reading to reading; with spec and readout it determines the future bit for bit."""


class Effect(Protocol):
    """The choice of one effect, which can make its stage."""

    def stage(self, readout: Readout) -> Stage:
        """The effect at work, before its first reading."""
