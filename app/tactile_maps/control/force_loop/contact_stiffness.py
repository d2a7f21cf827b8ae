"""Stiffness of a contact, measured during the arm's own approach: change of force over displacement along the normal.

The motion of a touching hand changes the force too, so not every change counts. Over a window of readings the force is
fitted with the displacement of the skin and time, F = a + k x + c t, and k is used only if the arm's own motion
explains
the force:

* The commanded posture moved the skin in the same direction, at least half as far: the skin was not merely pushed.
* The standard error of k is at most a tenth of k; other motion would leave residuals.
* A steady motion of the other side, c t, explains less than a sixth as much.

An unmeasured contact has the nominal stiffness. A softer contact is accepted only if two of the last three windows,
which share no readings, agree: an object that moves by chance as the arm does would have to do so twice. A stiffer one
is accepted at once, and dropped if the next window does not confirm it: a window is short where the arm turns back, and
the cover's damping then counts as stiffness.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

NEAR = 0.3
"""Largest difference of the forces in a window, as a share of the latest: covers stiffen under pressure."""
LEAST_READINGS = 5
MOST_READINGS = 64
"""Smallest and largest number of readings in a window."""
LEAST_CHANGE = 0.05
"""Smallest change of force in a window, as a share of the latest force."""
CERTAIN = 0.1
STEADY = 0.15
OWN = 0.5
"""Ratios that a window must satisfy: standard error of k to k (at most), change of force by the steady motion of the
other side to that by the arm's motion (at most), commanded to measured displacement of the skin (at least)."""
_WINDOWS = 3
_AGREE = 2
"""Number of windows that are kept, and of those that must agree."""
_TINY = 1e-9


@dataclass(frozen=True)
class MeasuredStiffness:
    """Stiffness from one window.

    Attributes:
        stiffness: Stiffness [N/m].
        force: Mean force of the window [N].
    """

    stiffness: float
    force: float

    def at(self, force: float) -> float:
        """Return the stiffness at another ``force`` [N].

        A contact that is pressed harder may stiffen with the root of the force, like a ball on foam. With less force it
        is not assumed to be softer.
        """
        return self.stiffness * max(force / self.force, 1.0) ** 0.5

    def nearest(self, latest: float, force: float) -> float:
        """Return the stiffness of this window at a ``force`` [N], next to the value of the ``latest`` window there
        [N/m].

        A contact stiffens at most with the root of its force, and may not stiffen at all: a later value between the two
        is confirmed. Without this, the UR5e's stiffness measured at 1.4 N would be 18 % too high at 3 N.
        """
        most = self.at(force)
        return latest if self.stiffness <= latest <= most else most


class _Sample(NamedTuple):
    time: float
    way: float
    commanded: float
    force: float


class StiffnessEstimator:
    """Estimates the stiffness of one contact. Mutable; ``reset`` discards it.

    Args:
        nominal: Stiffness until it has been measured [N/m].

    Cost: 2 µs a tick, 40 µs if a window is full of new readings.
    """

    def __init__(self, nominal: float) -> None:
        self._nominal = nominal
        self.reset()

    def reset(self) -> None:
        """Start with a new contact that has not been measured."""
        self._time = self._way = self._commanded = 0.0
        self._late: deque[tuple[float, float, float]] = deque()
        self._window: deque[_Sample] = deque(maxlen=MOST_READINGS)
        self._measured: deque[MeasuredStiffness] = deque(maxlen=_WINDOWS)

    def look(self, force: float, way: float, commanded: float, dt: float, delay: float) -> None:
        """Add one tick.

        Args:
            force: Latest reading [N]; a repeated reading counts once.
            way: Outward displacement of the contact point since the last tick [m].
            commanded: Displacement that the commanded posture would have caused [m].
            dt: Time since the last tick [s].
            delay: Time from a sample to its arrival [s], and so the age of the position that belongs to the force.
        """
        self._time = self._time + dt
        self._way = self._way + way
        self._commanded = self._commanded + commanded
        self._late.append((self._time, self._way, self._commanded))
        while len(self._late) > round(delay / dt) + 1:
            self._late.popleft()
        if len(self._late) <= round(delay / dt):
            return  # the position of the arm at this sample is unknown
        if not force > 0:  # an estimate may be NaN, or belong to a contact that pulls
            self._window.clear()
            return
        if self._window and force == self._window[-1].force:
            return
        self._window.append(_Sample(*self._late[0], force))
        while abs(self._window[0].force - force) > NEAR * force:
            self._window.popleft()
        readings = len(self._window)
        for latest in (readings, readings // 2, LEAST_READINGS):  # the fit may hold only after an initial transient
            found = _explained(list(self._window)[-latest:])
            if found is not None:
                self._measured.append(found)
                self._window.clear()
                return

    @property
    def measured(self) -> bool:
        """Whether enough windows have measured the stiffness."""
        return len(self._measured) >= _AGREE

    def stiffness(self, force: float) -> float:
        """Return the stiffness at a ``force`` [N/m].

        It is that of the last window, or the value that two of the last three windows reach if that is larger. The
        nominal value replaces missing windows.
        """
        latest = self._measured[-1].at(force) if self._measured else self._nominal
        known = [one.nearest(latest, force) for one in self._measured]
        borne_out = sorted([*known, *[self._nominal] * (_WINDOWS - len(known))])[_WINDOWS - _AGREE]
        return max(borne_out, known[-1]) if self.measured else max([*known, self._nominal])


def _explained(samples: Sequence[_Sample]) -> MeasuredStiffness | None:
    """Return the stiffness from one window; None if the arm's own motion does not explain the force."""
    if len(samples) < LEAST_READINGS or abs(samples[-1].force - samples[0].force) < LEAST_CHANGE * samples[-1].force:
        return None
    window = np.array(samples)
    mean = float(window[:, 3].mean())
    time, way, commanded, force = (window - window.mean(axis=0)).T
    if float(commanded.dot(way)) < OWN * float(way.dot(way)):
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
