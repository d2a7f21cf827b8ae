"""The last seconds of what is plotted: samples in ring buffers, spans of limits, times of changed settings. No Qt.

``SampleHistory`` keeps a few named series, ``TaxelHistory`` all taxels, so that one selected now shows its past;
``LimitHistory`` the spans in which each limit bounded the controller, said for a while after they ended so that none
flickers by unread; ``EventHistory`` when contact events were, ``SettingChanges`` when settings were changed.
``VectorHistory`` keeps a vector, as the posture is. ``stage_times`` sums the sensor's effects to one stage.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
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

    A series is NaN at samples that said nothing of it, which the plots draw as gaps. Of more samples than are kept,
    each span of time keeps the lowest and the highest: no peak is lost, however short.

    Args:
        seconds: How far back to keep [s]; also the width of the window shown.
        capacity: Most samples kept, two for each span of time.
    """

    def __init__(self, *, seconds: float = 10.0, capacity: int = 2048) -> None:
        self.seconds = seconds
        self._samples = VectorHistory(seconds=seconds, capacity=capacity)
        # When each series came, or last had a number [s]; in the order of the samples' columns.
        self._said: dict[str, float] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """The series, in the order they first came."""
        return tuple(self._said)

    @property
    def latest(self) -> float | None:
        """Time of the newest sample [s]; None when there is none."""
        return self._samples.latest

    def clear(self) -> None:
        """Forget all samples and series."""
        self._said = {}
        self._samples.keep(())
        self._samples.clear()

    def add(self, time: float, values: dict[str, float]) -> None:
        """Keep ``values`` at ``time`` [s]; time running backwards or jumping ahead starts a new history.

        Cost: 10 µs.
        """
        latest = self.latest
        if latest is not None and not 0 <= time - latest <= self.seconds:
            self.clear()
        if new := values.keys() - self._said.keys():
            self._said |= {name: time for name in values if name in new}
            self._samples.widen(len(self._said))
        self._said |= {name: time for name, value in values.items() if isfinite(value)}
        self._samples.add(time, np.array([values.get(name, np.nan) for name in self._said]))

    def series(self, name: str) -> tuple[FloatArray, FloatArray]:
        """Ages (k,) [s], rising to 0 at the newest sample, and the values (k,) of the last ``seconds``; maybe none."""
        if name not in self._said:
            return np.zeros(0), np.zeros(0)
        return self._samples.series(self.names.index(name))

    def forget_silent(self) -> tuple[str, ...]:
        """Drop the series that said nothing in the last ``seconds``; their names. Cost: 0.1 µs a series."""
        latest = self.latest
        silent = tuple(name for name, said in self._said.items() if latest is not None and latest - said > self.seconds)
        if silent:
            self._samples.keep([number for number, name in enumerate(self._said) if name not in silent])
            for name in silent:
                del self._said[name]
        return silent


class TaxelHistory:
    """Pressures of every taxel, so that one selected now shows what it felt before. Mutable: ``add`` and ``clear``.

    Args:
        seconds: How far back to keep [s].
        capacity: Most frames kept; ten seconds at 100 a second. They take 4 bytes a taxel each. Of more, each taxel's
            highest pressure in a span of time is kept.
    """

    def __init__(self, *, seconds: float = 10.0, capacity: int = 1000) -> None:
        self.seconds = seconds
        self._times = np.full(capacity, np.nan)
        self._pressures = np.zeros((capacity, 0), np.float32)
        self._count = 0
        self._span = seconds / capacity
        self._span_start = -np.inf

    def clear(self) -> None:
        """Forget everything."""
        self._count = 0
        self._times.fill(np.nan)
        self._span_start = -np.inf

    def add(self, time: float, pressures: FloatArray) -> None:
        """Keep pressures (taxels,) [Pa] at ``time`` [s]; another skin, or time that jumps, starts a new history."""
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
        """How many taxels there are; 0 before any reading."""
        return int(self._pressures.shape[1])

    def traces(self, taxels: IntArray) -> tuple[FloatArray, FloatArray]:
        """Ages (n,) [s], rising to 0, and pressures (n, k) [kPa] of ``taxels`` (k,) in the last ``seconds``.

        Cost: 1 ms for all of 1000 taxels at 60 frames a second.
        """
        order = _oldest_first(self._count, len(self._times))
        ages = self._times[order] - self._times[order[-1:]]
        kept = ages >= -self.seconds
        return ages[kept], 1e-3 * self._pressures[np.ix_(order[kept], taxels)].astype(float)


class VectorHistory:
    """Samples of a vector over time, such as the posture. Mutable: ``add`` and ``clear``.

    Of more samples than are kept, each span of time keeps the lowest and the highest of each number; NaN is neither.

    Args:
        seconds: How far back to keep [s].
        capacity: Most samples kept, two for each span of time.
    """

    def __init__(self, *, seconds: float = 10.0, capacity: int = 2048) -> None:
        self.seconds = seconds
        self._times = np.full(capacity, np.nan)
        self._values = np.zeros((capacity, 0))
        self._span = 2 * seconds / capacity
        self.clear()

    @property
    def latest(self) -> float | None:
        """Time of the newest sample [s]; None when there is none."""
        return float(self._times[(self._count - 1) % len(self._times)]) if self._count else None

    def clear(self) -> None:
        """Forget everything."""
        self._count = 0
        self._span_start = -np.inf
        self._in_span = 0

    def widen(self, size: int) -> None:
        """Let the vector have ``size`` numbers; those added were NaN in all samples before."""
        before = self._values
        self._values = np.full((len(before), size), np.nan)
        self._values[:, : before.shape[1]] = before

    def keep(self, numbers: Sequence[int]) -> None:
        """Let the vector have these of its numbers alone, in this order."""
        self._values = self._values[:, np.asarray(numbers, int)]

    def add(self, time: float, values: FloatArray) -> None:
        """Keep ``values`` (n,) at ``time`` [s]; another n, or time that jumps, starts a new history. Cost: 10 µs."""
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
        """The last two samples become the lowest and the highest of them and these, in the order they are in."""
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
        """Ages (k,) [s], rising to 0 at the newest sample, and that number (k,) of the last ``seconds``; maybe none."""
        if not self._count or not 0 <= number < self._values.shape[1]:
            return np.zeros(0), np.zeros(0)
        order = _oldest_first(self._count, len(self._times))
        ages = self._times[order] - self._times[order[-1]]
        kept = ages >= -self.seconds
        return ages[kept], self._values[order[kept], number]


def _oldest_first(count: int, size: int) -> IntArray:
    """Places in a ring of ``size`` that ``count`` samples were put into."""
    return np.arange(count) if count <= size else (np.arange(size) + count) % size


LIMIT_SHOWN_FOR = 1.0
"""How long a limit is still said after it ended [s]."""
_MERGE_SPANS_WITHIN = 0.1
"""What ends and begins again within this is one span [s]."""


class ShownLimit(NamedTuple):
    """One limit as it was last, and whether it is active now or only was."""

    limit: Limit
    active: bool


class LimitHistory:
    """Spans of time by limit. Mutable: ``take`` and ``clear``.

    Args:
        seconds: How far back to remember [s].
    """

    def __init__(self, *, seconds: float = 10.0) -> None:
        self.seconds = seconds
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._now: float | None = None
        self._spans: dict[LimitKind, list[list[float]]] = {}
        self._last: dict[LimitKind, Limit] = {}
        self._active: tuple[LimitKind, ...] = ()

    def take(self, time: float, limits: Sequence[Limit]) -> None:
        """These bound the controller at ``time`` [s]; time that jumps, or runs backwards, starts a new memory."""
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
    def told(self) -> tuple[ShownLimit, ...]:
        """Those active now as they came, then those that ended within ``LIMIT_SHOWN_FOR``, the newest first."""
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
        """Kind and spans of each limit remembered, first come first, as ages [s], 0 for now and below before."""
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


_LASTING_EVENTS = ("press", "stroke", "grasp", "self-touch")
"""What begins and ends; the other events are instants."""


class EventHistory:
    """Contact events by kind. Mutable: ``take`` and ``clear``.

    Args:
        seconds: How far back to remember [s].
    """

    def __init__(self, *, seconds: float = 10.0) -> None:
        self.seconds = seconds
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._now: float | None = None
        self._events: list[ContactEvent] = []

    def take(self, time: float, recent: Sequence[ContactEvent]) -> None:
        """The newest events up to ``time`` [s], newest first; time that jumps, or runs backwards, starts anew."""
        if self._now is not None and not 0 <= time - self._now <= self.seconds:
            self.clear()
        before = self._now
        self._now = time
        known = -np.inf if before is None else before
        self._events += [event for event in reversed(recent) if event.time > known]
        self._events = [event for event in self._events if time - event.time <= self.seconds]

    @property
    def rows(self) -> tuple[tuple[EventKind, tuple[tuple[float, float], ...]], ...]:
        """Kind and spans of the events remembered, first come first, as ages [s]: 0 for now and below before.

        What lasts still ends now; an event without duration ends when it begins.
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
"""Changes that follow each other within this are one, at the last of them [s]: a slider on its way."""


class SettingChanges:
    """Times of changes. Mutable: ``change``, ``at`` a time, and ``clear``.

    Args:
        seconds: How far back to remember [s].
    """

    def __init__(self, *, seconds: float = 10.0) -> None:
        self._seconds = seconds
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._now: float | None = None
        self._times: list[float] = []

    def at(self, time: float) -> None:
        """It is ``time`` [s] now; time that jumps, or runs backwards, forgets the changes before."""
        if self._now is not None and not 0 <= time - self._now <= self._seconds:
            self._times = []
        self._now = time
        self._times = [when for when in self._times if time - when <= self._seconds]

    def change(self) -> None:
        """Something was changed just now."""
        if self._now is None:
            return
        if self._times and self._now - self._times[-1] <= _MERGE_CHANGES_WITHIN:
            self._times.pop()
        self._times.append(self._now)

    @property
    def ages(self) -> tuple[float, ...]:
        """Of the changes [s], 0 for now and below before."""
        return () if self._now is None else tuple(when - self._now for when in self._times)


SENSOR_STAGE = "sensor"


def stage_times(timings: Timings) -> dict[str, float]:
    """Milliseconds by stage; the sensor's effects, each of which is timed, stand together after touch."""
    times: dict[str, float] = {}
    for stage, milliseconds in timings.ms.items():
        name = SENSOR_STAGE if stage in SENSOR_KEYS or stage in SENSOR_STAGES else stage
        times[name] = times.get(name, 0.0) + milliseconds
    return times
