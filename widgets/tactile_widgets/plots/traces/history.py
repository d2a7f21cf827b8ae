"""Data of the last seconds for the plots: samples in ring buffers, spans of limits, times of changed settings. No Qt.

``SampleHistory`` stores a few named series, ``TaxelHistory`` all taxels, so that a newly selected one shows its past;
``LimitHistory`` stores the spans in which each limit bounded the controller, and lists a limit for a while after it
ended so that it can be read; ``EventHistory`` stores the times of contact events, ``SettingChanges`` those of changed
settings. ``VectorHistory`` stores a vector such as the posture. ``stage_times`` sums the sensor's effects to one stage.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tactile_maps.contacts.events import ContactEvent, EventKind
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.timing import Timings
from tactile_maps.tactile.sensors.sensor_chain import SENSOR_STAGES
from tactile_maps.tactile.sensors.sensor_effects import SENSOR_KEYS


class SampleHistory:
    """Samples of named series over time. Mutable: ``add`` and ``clear``.

    A series is NaN at samples without a value of it, which the plots draw as gaps. If there are more samples than
    capacity, each time span keeps the lowest and the highest, so that no peak is lost, however short.

    Args:
        seconds: Duration of the history [s]; also the width of the displayed window.
        capacity: Maximum number of samples, two for each time span.
    """

    def __init__(self, *, seconds: float = 10.0, capacity: int = 2048) -> None:
        self.seconds = seconds
        self._capacity = capacity
        self.clear()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the series, in the order of their first sample."""
        return tuple(self._names)

    @property
    def latest(self) -> float | None:
        """Time of the newest sample [s]; None without samples."""
        return self._samples.latest

    def clear(self) -> None:
        """Discard all samples and series."""
        self._names: list[str] = []  # in the order of the samples' columns
        self._samples = VectorHistory(seconds=self.seconds, capacity=self._capacity)

    def add(self, time: float, values: dict[str, float]) -> None:
        """Store ``values`` at ``time`` [s]; time that runs backwards or jumps ahead starts a new history.

        Cost: 10 µs.
        """
        latest = self.latest
        if latest is not None and not 0 <= time - latest <= self.seconds:
            self.clear()
        if new := [name for name in values if name not in self._names]:
            self._names += new
            self._samples.widen(len(self._names))
        self._samples.add(time, np.array([values.get(name, np.nan) for name in self._names]))

    def series(self, name: str) -> tuple[FloatArray, FloatArray]:
        """Return ages (k,) [s], rising to 0 at the newest sample, and values (k,) of the last ``seconds``."""
        if name not in self._names:
            return np.zeros(0), np.zeros(0)
        return self._samples.series(self._names.index(name))


class ContactHistory:
    """Forces of contacts, each from its first sample to its last. Mutable: ``add`` and ``clear``.

    A contact is dropped ``seconds`` after its last sample. Contacts that have ended take no time, unlike series of a
    ``SampleHistory``: hundreds of short touches may be kept.

    Args:
        seconds: Duration of the history [s].
    """

    def __init__(self, *, seconds: float = 10.0) -> None:
        self.seconds = seconds
        self.clear()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the contacts, in the order of their first sample."""
        return tuple(self._contacts)

    def clear(self) -> None:
        """Discard all contacts."""
        self._contacts: dict[str, VectorHistory] = {}
        self._present: tuple[str, ...] = ()
        self._ended: dict[str, float] = {}  # time of the last sample of each absent contact [s], rising
        self._latest = -np.inf

    def add(self, time: float, forces: dict[str, float]) -> None:
        """Store ``forces`` at ``time`` [s]; time that runs backwards or jumps ahead starts a new history."""
        if not 0 <= time - self._latest <= self.seconds:
            self.clear()
        self._ended |= {name: self._latest for name in self._present if name not in forces}
        while self._ended and time - next(iter(self._ended.values())) > self.seconds:
            name = next(iter(self._ended))
            del self._ended[name], self._contacts[name]
        for name, force in forces.items():
            if name not in self._contacts:
                self._contacts[name] = VectorHistory(seconds=self.seconds)
            if self._ended.pop(name, None) is not None:
                self._contacts[name].add(self._latest, np.array([np.nan]))  # a gap
            self._contacts[name].add(time, np.array([force]))
        self._present = tuple(forces)
        self._latest = time

    def series(self, name: str) -> tuple[FloatArray, FloatArray]:
        """Return ages (k,) [s] and forces (k,) of a contact in the last ``seconds``, NaN where it was absent."""
        if name not in self._contacts:
            return np.zeros(0), np.zeros(0)
        ages, forces = self._contacts[name].series(0)
        if name in self._ended:
            ages = np.append(ages, 0.0) + self._ended[name] - self._latest
            forces = np.append(forces, np.nan)
        kept = ages >= -self.seconds
        return ages[kept], forces[kept]


class TaxelHistory:
    """Pressures of all taxels, so that a newly selected taxel shows its past. Mutable: ``add`` and ``clear``.

    Args:
        seconds: Duration of the history [s].
        capacity: Maximum number of frames; the default is ten seconds at 100 frames per second. A frame takes 4 bytes
            per taxel. If there are more frames, the maximum pressure of each taxel in a time span is stored.
    """

    def __init__(self, *, seconds: float = 10.0, capacity: int = 1000) -> None:
        self.seconds = seconds
        self._times = np.full(capacity, np.nan)
        self._pressures = np.zeros((capacity, 0), np.float32)
        self._count = 0
        self._span = seconds / capacity
        self._span_start = -np.inf
        self._groups = np.zeros((capacity, 0), np.float32)
        self._grouped: tuple[IntArray, int] | None = None  # order of the taxels, and number of frames in _groups

    def clear(self) -> None:
        """Discard everything."""
        self._count = 0
        self._grouped = None
        self._times.fill(np.nan)
        self._span_start = -np.inf

    def add(self, time: float, pressures: FloatArray) -> None:
        """Store pressures (taxels,) [Pa] at ``time`` [s]; another skin, or time that jumps, starts a new history."""
        latest = self._times[(self._count - 1) % len(self._times)]
        if len(pressures) != self._pressures.shape[1]:
            self._pressures = np.empty((len(self._times), len(pressures)), np.float32)
            self.clear()
        elif self._count and not 0 <= time - latest <= self.seconds:
            self.clear()
        if time < self._span_start + self._span:
            last = (self._count - 1) % len(self._times)
            np.maximum(self._pressures[last], pressures, out=self._pressures[last], casting="unsafe")
            return
        self._span_start = time
        place = self._count % len(self._times)
        self._times[place] = time
        self._pressures[place] = pressures
        self._count += 1

    @property
    def count(self) -> int:
        """Number of taxels; 0 before any reading."""
        return int(self._pressures.shape[1])

    def traces(self, taxels: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return ages (n,) [s], rising to 0, and pressures (n, k) [kPa] of ``taxels`` (k,) in the last ``seconds``.

        Cost: 1 ms for 1000 taxels at 60 frames per second.
        """
        order = _oldest_first(self._count, len(self._times))
        ages = self._times[order] - self._times[order[-1:]]
        kept = ages >= -self.seconds
        return ages[kept], 1e-3 * self._pressures[np.ix_(order[kept], taxels)].astype(float)

    def highest(self, order: IntArray, starts: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return ages (n,) [s], rising to 0, and the highest pressures (n, k) [kPa] of k groups of taxels.

        Args:
            order: (taxels,) all taxels; pass the same array again for the same groups.
            starts: (k,) index in ``order`` of the first taxel of each group.

        Cost: 0.1 ms for each frame since the last call with these groups, with 1000 taxels.
        """
        size = len(self._times)
        known = 0
        if self._grouped is not None and self._grouped[0] is order and self._groups.shape[1] == len(starts):
            known = max(self._grouped[1] - 1, 0)  # the last frame may have changed
        else:
            self._groups = np.empty((size, len(starts)), np.float32)
        added = np.arange(max(known, self._count - size), self._count) % size
        if len(added):
            self._groups[added] = np.fmax.reduceat(self._pressures[np.ix_(added, order)], starts, axis=1)
        self._grouped = order, self._count
        rows = _oldest_first(self._count, size)
        ages = self._times[rows] - self._times[rows[-1:]]
        kept = ages >= -self.seconds
        return ages[kept], 1e-3 * self._groups[rows[kept]]

    def at(self, age: float, taxels: IntArray) -> FloatArray | None:
        """Return the pressures (k,) [Pa] of ``taxels`` at an age [s], 0 for the newest; None before the first."""
        rows = _oldest_first(self._count, len(self._times))
        ages = self._times[rows] - self._times[rows[-1:]]
        number = int(np.searchsorted(ages, age + 1e-9, side="right")) - 1
        return None if number < 0 else self._pressures[rows[number], taxels].astype(float)


class VectorHistory:
    """Samples of a vector over time, such as the posture. Mutable: ``add`` and ``clear``.

    If there are more samples than capacity, each time span keeps the lowest and highest value of each component,
    ignoring NaN.

    Args:
        seconds: Duration of the history [s].
        capacity: Maximum number of samples, two for each time span.
    """

    def __init__(self, *, seconds: float = 10.0, capacity: int = 2048) -> None:
        self.seconds = seconds
        self._times = np.full(capacity, np.nan)
        self._values = np.zeros((capacity, 0))
        self._span = 2 * seconds / capacity
        self.clear()

    @property
    def latest(self) -> float | None:
        """Time of the newest sample [s]; None without samples."""
        return float(self._times[(self._count - 1) % len(self._times)]) if self._count else None

    def clear(self) -> None:
        """Discard everything."""
        self._count = 0
        self._span_start = -np.inf
        self._in_span = 0

    def widen(self, size: int) -> None:
        """Extend the vector to ``size`` components; the new ones are NaN in all stored samples."""
        before = self._values
        self._values = np.full((len(before), size), np.nan)
        self._values[:, : before.shape[1]] = before

    def add(self, time: float, values: FloatArray) -> None:
        """Store ``values`` (n,) at ``time`` [s]; another n, or time that jumps, starts a new history. Cost: 10 µs."""
        size = len(self._times)
        latest = self.latest
        if len(values) != self._values.shape[1]:
            self._values = np.zeros((size, len(values)))
            self.clear()
        elif latest is not None and not 0 <= time - latest <= self.seconds:
            self.clear()
        if time >= self._span_start + self._span:
            self._span_start = time
            self._in_span = 0
        self._in_span += 1
        if self._in_span <= 2:
            place = self._count % size
            self._times[place] = time
            self._values[place] = values
            self._count += 1
        else:
            self._merge(time, values)

    def _merge(self, time: float, values: FloatArray) -> None:
        """Replace the last two samples by the minimum and maximum of them and ``values``, in their present order."""
        size = len(self._times)
        last = (self._count - 1) % size
        before = (self._count - 2) % size
        rises = self._values[before] <= self._values[last]
        three = self._values[before], self._values[last], values
        low = np.fmin.reduce(three)
        high = np.fmax.reduce(three)
        self._values[before] = np.where(rises, low, high)
        self._values[last] = np.where(rises, high, low)
        self._times[last] = time

    def series(self, number: int) -> tuple[FloatArray, FloatArray]:
        """Return ages (k,) [s], rising to 0 at the newest sample, and a component (k,) of the last ``seconds``."""
        if not self._count or not 0 <= number < self._values.shape[1]:
            return np.zeros(0), np.zeros(0)
        order = _oldest_first(self._count, len(self._times))
        ages = self._times[order] - self._times[order[-1]]
        kept = ages >= -self.seconds
        return ages[kept], self._values[order[kept], number]


def _oldest_first(count: int, size: int) -> IntArray:
    """Return the indices in a ring of ``size`` after ``count`` samples, oldest first."""
    return np.arange(count) if count <= size else (np.arange(size) + count) % size


LIMIT_SHOWN_FOR = 1.0
"""Time for which a limit is still listed after it ended [s]."""
_MERGE_SPANS_WITHIN = 0.1
"""Spans with a smaller gap between them are merged [s]."""


class ShownLimit(NamedTuple):
    """Limit with its last value, and whether it is active now."""

    limit: Limit
    active: bool


class LimitHistory:
    """Time spans in which each limit was active. Mutable: ``take`` and ``clear``.

    Args:
        seconds: Duration of the history [s].
    """

    def __init__(self, *, seconds: float = 10.0) -> None:
        self.seconds = seconds
        self.clear()

    def clear(self) -> None:
        """Discard everything."""
        self._now: float | None = None
        self._spans: dict[LimitKind, list[list[float]]] = {}
        self._last: dict[LimitKind, Limit] = {}
        self._active: tuple[LimitKind, ...] = ()

    def take(self, time: float, limits: Sequence[Limit]) -> None:
        """Store the limits active at ``time`` [s]; time that jumps or runs backwards starts a new history."""
        if self._now is not None and not 0 <= time - self._now <= self.seconds:
            self.clear()
        before = self._active
        self._now = time
        self._active = tuple(limit.kind for limit in limits)
        self._last |= {limit.kind: limit for limit in limits}
        for kind in self._active:
            spans = self._spans.setdefault(kind, [])
            if spans and (kind in before or time - spans[-1][1] <= _MERGE_SPANS_WITHIN):
                spans[-1][1] = time
            else:
                spans.append([time, time])
        self._forget(time)

    @property
    def recent(self) -> tuple[ShownLimit, ...]:
        """Active limits in their order, then limits that ended within ``LIMIT_SHOWN_FOR``, newest first."""
        if self._now is None:
            return ()
        ended = [(spans[-1][1], kind) for kind, spans in self._spans.items() if kind not in self._active]
        ended.sort(key=lambda pair: pair[0], reverse=True)
        recent = [kind for end, kind in ended if self._now - end <= LIMIT_SHOWN_FOR]
        return (
            *(ShownLimit(self._last[kind], True) for kind in self._active),
            *(ShownLimit(self._last[kind], False) for kind in recent),
        )

    @property
    def rows(self) -> tuple[tuple[LimitKind, tuple[tuple[float, float], ...]], ...]:
        """Kind and spans of each stored limit in order of occurrence, as ages [s]: 0 for now and negative before."""
        now = self._now
        if now is None:
            return ()
        return tuple(
            (kind, tuple((max(start - now, -self.seconds), end - now) for start, end in spans))
            for kind, spans in self._spans.items()
        )

    def _forget(self, now: float) -> None:
        oldest = now - self.seconds
        for kind in tuple(self._spans):
            self._spans[kind] = [span for span in self._spans[kind] if span[1] >= oldest]
            if not self._spans[kind]:
                del self._spans[kind], self._last[kind]


_LASTING_EVENTS = ("press", "stroke", "grasp", "self-touch", "slip")
"""Events with a beginning and an end; the others are instants."""


class EventHistory:
    """Contact events by kind. Mutable: ``take`` and ``clear``.

    Args:
        seconds: Duration of the history [s].
    """

    def __init__(self, *, seconds: float = 10.0) -> None:
        self.seconds = seconds
        self.clear()

    def clear(self) -> None:
        """Discard everything."""
        self._now: float | None = None
        self._events: list[ContactEvent] = []

    def take(self, time: float, recent: Sequence[ContactEvent]) -> None:
        """Store recent events (newest first) at ``time`` [s]; time that jumps or runs backwards clears the old ones."""
        if self._now is not None and not 0 <= time - self._now <= self.seconds:
            self.clear()
        before = self._now
        self._now = time
        known = -np.inf if before is None else before
        self._events += [event for event in reversed(recent) if event.time > known]
        self._events = [event for event in self._events if time - event.time <= self.seconds]

    @property
    def rows(self) -> tuple[tuple[EventKind, tuple[tuple[float, float], ...]], ...]:
        """Kind and spans of the stored events in the order of occurrence, as ages [s]: 0 for now and negative before.

        A span that is still active ends at 0; an event without duration ends when it begins.
        """
        now = self._now
        spans = dict[EventKind, dict[tuple[object, ...], tuple[float, float]]]()
        if now is None:
            return ()
        for number, event in enumerate(self._events):
            lasts = event.kind in _LASTING_EVENTS
            at = event.time - now
            mine = spans.setdefault(event.kind, {})
            if lasts and event.phase == "began":
                mine[event.contacts] = at, 0.0
            elif lasts:
                mine.pop(event.contacts, None)
                mine[event.contacts, number] = max(at - event.duration, -self.seconds), at
            else:
                mine[event.contacts, number] = at, at
        return tuple((kind, tuple(sorted(mine.values()))) for kind, mine in spans.items())


_MERGE_CHANGES_WITHIN = 0.4
"""Changes within this time of each other count as one, at the last of them [s], as while a slider is dragged."""


class SettingChanges:
    """Times of changed settings. Mutable: ``change``, ``at`` and ``clear``.

    Args:
        seconds: Duration of the history [s].
    """

    def __init__(self, *, seconds: float = 10.0) -> None:
        self._seconds = seconds
        self.clear()

    def clear(self) -> None:
        """Discard everything."""
        self._now: float | None = None
        self._times: list[float] = []

    def at(self, time: float) -> None:
        """Set the current time [s]; time that jumps or runs backwards discards earlier changes."""
        if self._now is not None and not 0 <= time - self._now <= self._seconds:
            self._times = []
        self._now = time
        self._times = [when for when in self._times if time - when <= self._seconds]

    def change(self) -> None:
        """Store a change at the current time."""
        if self._now is None:
            return
        if self._times and self._now - self._times[-1] <= _MERGE_CHANGES_WITHIN:
            self._times.pop()
        self._times.append(self._now)

    @property
    def ages(self) -> tuple[float, ...]:
        """Ages of the changes [s]: 0 for now and negative before."""
        return () if self._now is None else tuple(when - self._now for when in self._times)


SENSOR_STAGE = "sensor"


def stage_times(timings: Timings) -> dict[str, float]:
    """Return milliseconds by stage; the sensor's effects, timed one by one, are summed to one stage after touch."""
    times: dict[str, float] = {}
    for stage, milliseconds in timings.ms.items():
        name = SENSOR_STAGE if stage in SENSOR_KEYS or stage in SENSOR_STAGES else stage
        times[name] = times.get(name, 0.0) + milliseconds
    return times
