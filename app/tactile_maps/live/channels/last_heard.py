"""Time of the newest value of each taxel and joint, and detection of skin parts that repeat the same values.

A part is a module if the skin states modules, otherwise a patch. A part is frozen if it has repeated its values for
more than ``FROZEN_SECONDS`` and for ``FROZEN_FACTOR`` times its longest pause so far. The rule applies only to a part
that has varied for ``LEARN_SECONDS`` and ``LEARN_CHANGES`` changes, so the stream itself defines how quiet a part may
be. A pause in which the part was frozen does not count as one of its pauses.

- A part with noise changes with nearly every reading and is frozen after ``FROZEN_SECONDS``.
- A quantised part that changes now and then is frozen after five times its longest pause.
- A part that has not varied yet, such as an untouched skin without noise, is never frozen.

Time passes only while readings arrive, so a pause of the stream does not count.
"""

from __future__ import annotations

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import names_text
from tactile_maps.skin.model.skin import Skin

FROZEN_SECONDS = 0.5
FROZEN_FACTOR = 5.0
LEARN_SECONDS = 2.0
LEARN_CHANGES = 100
_LONGEST_STEP = 0.1
"""A longer time between readings [s] is a pause of the stream, of which only this much counts."""


class LastHeard:
    """Times of the newest values, and repeated values, of all taxels and joints. Mutable.

    Args:
        skin: The skin.
        joints: Number of joints.

    Attributes:
        taxels: (taxels,) time at which each taxel's newest value was measured, by the receiver's clock [s];
            -inf before the first.
        joints: (joints,) the same for joint positions.
        arrived: Arrival of the newest reading [s]; -inf before the first.
    """

    def __init__(self, skin: Skin, joints: int) -> None:
        self._skin = skin
        self._count = joints
        modules = skin.identity.modules
        self._names_modules = modules is not None
        self.part_numbers, part_of = np.unique(skin.patch_of if modules is None else modules, return_inverse=True)
        self._part_of: IntArray = part_of.ravel()
        self._sizes = np.bincount(self._part_of, minlength=len(self.part_numbers))
        self.reset()

    def reset(self) -> None:
        """Discard all observations."""
        parts = len(self.part_numbers)
        self.taxels: FloatArray = np.full(len(self._skin), -np.inf)
        self.joints: FloatArray = np.full(self._count, -np.inf)
        self.arrived = -np.inf
        self._clock = 0.0
        self._first: FloatArray = np.full(parts, np.inf)
        self._last: FloatArray = np.zeros(parts)
        self._longest: FloatArray = np.zeros(parts)
        self._changes: IntArray = np.zeros(parts, np.int64)

    def add(self, taxels: IntArray, joints: list[int], changed: BoolArray, arrived: float, measured: float) -> None:
        """Add a reading. Cost: 15 µs for 1000 taxels.

        Args:
            taxels: (k,) taxels with a value in the reading.
            joints: Numbers of the joints with a position in the reading.
            changed: (k,) True where the value differs from the previous one.
            arrived: Arrival of the reading [s].
            measured: ``arrived`` minus the age of the reading [s].
        """
        if self.arrived > -np.inf:
            self._clock += min(max(arrived - self.arrived, 0.0), _LONGEST_STEP)
        self.arrived = arrived
        self.taxels[taxels] = measured
        self.joints[joints] = measured
        varied = np.zeros(len(self.part_numbers), dtype=bool)
        varied[self._part_of[taxels[changed]]] = True
        usual = varied & ~self.frozen
        self._longest[usual] = np.maximum(self._longest[usual], self._clock - self._last[usual])
        self._last[varied] = self._clock
        self._first[varied] = np.minimum(self._first[varied], self._clock)
        self._changes[varied] += 1

    @property
    def frozen(self) -> BoolArray:
        """(parts,) True for a part that repeats its values."""
        learned = (self._changes >= LEARN_CHANGES) & (self._last - self._first >= LEARN_SECONDS)
        return learned & (self._clock - self._last > np.maximum(FROZEN_SECONDS, FROZEN_FACTOR * self._longest))

    def frozen_text(self) -> str:
        """Return the names of the frozen parts and the time for which each has repeated its values."""
        parts = np.flatnonzero(self.frozen).tolist()
        return names_text([f"{self._part_name(part)} for {self._clock - self._last[part]:.2f} s" for part in parts])

    def taxel_names(self, chosen: BoolArray) -> list[str]:
        """Return the names of the ``chosen`` taxels (taxels,); a part that is chosen as a whole is named as such."""
        whole = np.bincount(self._part_of[chosen], minlength=len(self._sizes)) == self._sizes
        single = np.flatnonzero(chosen & ~whole[self._part_of]).tolist()
        parts = [self._part_name(part) for part in np.flatnonzero(whole).tolist()]
        return parts + list(map(self._skin.taxel_text, single))

    def _part_name(self, part: int) -> str:
        number = int(self.part_numbers[part])
        return f"module {number}" if self._names_modules else f"patch {self._skin.patches[number].name}"
