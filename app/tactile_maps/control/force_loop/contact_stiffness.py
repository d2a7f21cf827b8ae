"""How stiff a contact is, measured by the arm's own approach: change of force over way along the normal.

A moving hand changes the force too, so not every change counts. Over a window of readings the force is explained by the
way of the skin and by time, F = a + k x + c t, and k is taken only where the arm's own motion is what explains it:

* the posture that was commanded moved the skin the same way, at least half as far: the skin was not merely pushed,
* the fit leaves k certain to a tenth: what else moved would be left over,
* a steady motion of the other side, c t, explains less than a sixth as much.

What nobody has measured counts as stiff as nominal, and a softer contact is believed only when two of the last three
windows, which have no common reading, say so: one that moves by chance as the arm does would have to do so twice. A
stiffer one is believed at once, and no longer when the next one does not bear it out: where the arm turns back a window
is short, and the cover's damping counts as stiffness.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

NEAR = 0.3
"""Share of the latest force by which others of a window may differ: covers stiffen as they are pressed."""
LEAST_READINGS = 5
MOST_READINGS = 64
"""Of a window."""
LEAST_CHANGE = 0.05
"""Of the latest force, that the force has to change by in a window."""
CERTAIN = 0.1
STEADY = 0.15
OWN = 0.5
"""Standard error of k by k; change of force by the other side's steady motion by that of the arm's; commanded way of
the skin by the one it went."""
_WINDOWS = 3
_AGREE = 2
"""So many are remembered, of which so many have to agree."""
_TINY = 1e-9


@dataclass(frozen=True)
class MeasuredStiffness:
    """One window's.

    Attributes:
        stiffness: [N/m].
        force: At which, the window's mean [N].
    """

    stiffness: float
    force: float

    def at(self, force: float) -> float:
        """At another ``force`` [N]: what is pressed harder may stiffen with the root of it, as a ball on foam does;
        less is not taken for softer."""
        return self.stiffness * max(force / self.force, 1.0) ** 0.5

    def nearest(self, latest: float, force: float) -> float:
        """Return what this window says at a ``force`` [N], next to the value of the ``latest`` window there [N/m].

        A contact stiffens with the root of its force at most, and may not stiffen at all: a later value between the two
        is confirmed. Measured at 1.4 N, the UR5e's stiffness at 3 N would count as 18 % more than it is.
        """
        most = self.at(force)
        return latest if self.stiffness <= latest <= most else most


class _Sample(NamedTuple):
    time: float
    way: float
    wanted: float
    force: float


class StiffnessEstimator:
    """Follows one contact. Mutable; ``reset`` forgets it.

    Args:
        nominal: What counts until something is measured [N/m].

    Cost: 2 µs a tick, 40 µs where a window is full of news.
    """

    def __init__(self, nominal: float) -> None:
        self._nominal = nominal
        self.reset()

    def reset(self) -> None:
        """Another contact: nothing is measured."""
        self._time = self._way = self._wanted = 0.0
        self._late: deque[tuple[float, float, float]] = deque()
        self._window: deque[_Sample] = deque(maxlen=MOST_READINGS)
        self._measured: deque[MeasuredStiffness] = deque(maxlen=_WINDOWS)

    def look(self, force: float, way: float, wanted: float, dt: float, delay: float) -> None:
        """Take a tick.

        Args:
            force: Read last [N]; one that is read again and again counts once.
            way: By which the touched point went outward since the last tick [m].
            wanted: By which the commanded posture would have moved it [m].
            dt: [s].
            delay: From a sample to its arrival [s]: so old is the place that belongs to the force.
        """
        self._time = self._time + dt
        self._way = self._way + way
        self._wanted = self._wanted + wanted
        self._late.append((self._time, self._way, self._wanted))
        while len(self._late) > round(delay / dt) + 1:
            self._late.popleft()
        if len(self._late) <= round(delay / dt):
            return  # where the arm was when this was sampled nobody saw
        if not force > 0:  # an estimate may be none, or of a contact that pulls
            self._window.clear()
            return
        if self._window and force == self._window[-1].force:
            return
        self._window.append(_Sample(*self._late[0], force))
        while abs(self._window[0].force - force) > NEAR * force:
            self._window.popleft()
        readings = len(self._window)
        for latest in (readings, readings // 2, LEAST_READINGS):  # or only after what began it has died away
            found = _explained(list(self._window)[-latest:])
            if found is not None:
                self._measured.append(found)
                self._window.clear()
                return

    @property
    def measured(self) -> bool:
        """Whether windows enough have told it."""
        return len(self._measured) >= _AGREE

    def stiffness(self, force: float) -> float:
        """What counts at a ``force`` [N]: the last window's or, if that is more, what two of the last three reach;
        nominal stands in for what is missing [N/m]."""
        latest = self._measured[-1].at(force) if self._measured else self._nominal
        known = [one.nearest(latest, force) for one in self._measured]
        borne_out = sorted([*known, *[self._nominal] * (_WINDOWS - len(known))])[_WINDOWS - _AGREE]
        return max(borne_out, known[-1]) if self.measured else max([*known, self._nominal])


def _explained(samples: Sequence[_Sample]) -> MeasuredStiffness | None:
    """From one window; None where the arm's own motion does not explain the force."""
    if len(samples) < LEAST_READINGS or abs(samples[-1].force - samples[0].force) < LEAST_CHANGE * samples[-1].force:
        return None
    window = np.array(samples)
    mean = float(window[:, 3].mean())
    time, way, wanted, force = (window - window.mean(axis=0)).T
    if float(wanted.dot(way)) < OWN * float(way.dot(way)):
        return None
    rows = np.column_stack([way / max(float(np.ptp(way)), _TINY), time / float(np.ptp(time))])
    normal = rows.T.dot(rows)
    free = float(np.linalg.det(normal))
    if free < _TINY:
        return None
    (slope, drift), least = np.linalg.solve(normal, rows.T.dot(force)).tolist(), float(normal[1, 1]) / free
    rest = force - rows.dot((slope, drift))
    error = math.sqrt(float(rest.dot(rest)) / (len(rest) - 3) * least)
    if slope <= 0 or error > CERTAIN * slope or abs(drift) > STEADY * slope:
        return None
    return MeasuredStiffness(float(way.dot(force)) / float(way.dot(way)), mean)
