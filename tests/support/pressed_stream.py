"""Stream of readings of a skin whose modules are pressed one after another, with faults of channels."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from tactile_maps.skin.model.skin import Skin, TaxelIdentity
from tests.support.touch import bar_skin

RATE = 20.0
"""Readings per second [Hz]."""
REST = 200.0
"""Value of an untouched taxel."""


def skin_with_modules(taxels: int = 48, modules: int = 4) -> Skin:
    """Return the bar's skin, whose modules follow each other along the bar, with ids from 100."""
    skin = bar_skin(taxels)
    (patch,) = skin.patches
    along = np.argsort(np.argsort(patch.taxels.positions[:, 0], kind="stable"), kind="stable")
    size = taxels // modules
    identity = TaxelIdentity(100 + np.arange(taxels), 10 + along // size, along % size)
    return Skin((replace(patch, taxels=replace(patch.taxels, identity=identity)),))


def pressed(
    skin: Skin,
    touches: Iterable[Sequence[int]],
    *,
    change: Callable[[np.ndarray, int], np.ndarray] = lambda values, number: values,
    rest: float = 2.5,
    gap: float = 2.5,
    noise: float = 1.0,
    force: float = 100.0,
) -> Iterator[tuple[np.ndarray, float]]:
    """Yield (values, time) of the skin at rest, then of each touch: its taxels are pressed for 0.5 s and released.

    Args:
        skin: The skin.
        touches: Taxels of each touch.
        change: Changes the values (taxels,) of a reading, whose number it receives too.
        rest: Time at rest at the start [s].
        gap: Time between two touches [s].
        noise: Standard deviation of the noise.
        force: Change of a pressed taxel.
    """
    random = np.random.default_rng(3)
    spans = [(np.zeros(0, dtype=int), rest)]
    for touch in touches:
        spans += [(np.asarray(touch, dtype=int), 0.5), (np.zeros(0, dtype=int), gap)]
    number = 0
    for taxels, seconds in spans:
        for _ in range(round(seconds * RATE)):
            values = REST + noise * random.standard_normal(len(skin))
            values[taxels] += force
            yield change(values, number), number / RATE
            number += 1
