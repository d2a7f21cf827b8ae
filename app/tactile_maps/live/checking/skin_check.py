"""States of a guided check: the skin at rest, then one part after another is pressed, then the result.

The check receives readings as they come and uses their times; it neither waits nor reads a clock, so that a recorded
stream gives the same result as a live one. Keys of the user (next, skip, back) are optional: a part that was pressed
and released is left after a pause, and one that is not felt is left when the patience ends.

What was felt is judged against the readings at rest: a taxel is felt above six standard deviations of its noise, and
above a minimum in the unit of the readings. The baseline follows slow drift while nothing is felt.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum, StrEnum

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import LiveError
from tactile_maps.live.channels.channel_swaps import SwapDetector, SwappedChannels
from tactile_maps.live.checking.parts import SkinPart, adjacent_parts, part_numbers, parts_of
from tactile_maps.skin.model.skin import Skin

_DEVIATIONS = 6.0
"""Standard deviations of the noise at rest above which a taxel is felt."""
_NOISY = 8.0
"""A channel is noisy above this multiple of the median noise."""
_LEAST_AT_REST = 10
"""Minimum number of readings of the skin at rest."""
RELEASED = 0.3
"""A touch ends once every taxel has been below this share of its peak, or below its limit, for so many seconds."""
_DRIFT_SECONDS = 2.0
"""Time constant with which the baseline follows the readings while nothing is felt [s]."""
_RECOVERY = 5.0
"""Time after a touch for which the baseline of its taxels follows faster [s]: covers recover slowly."""
_RECOVERY_SECONDS = 0.3
"""Time constant during the recovery [s]."""
_AS_STRONG = 0.5
"""Parts that respond with at least this share of the strongest one respond too."""
_ATTEMPTS = 3
"""Number of unclear touches after which a part is left."""


class CheckStage(Enum):
    """Stage of a check."""

    REST = "rest"
    PRESS = "press"
    DONE = "done"


class Outcome(StrEnum):
    """Outcome of a part; the value is displayed."""

    FELT = "felt"
    NOTHING = "nothing felt"
    OTHER = "another part responded"
    SEVERAL = "several parts responded"
    SKIPPED = "skipped"
    OPEN = "not checked"


@dataclass(frozen=True)
class CheckSettings:
    """Settings of a check.

    Attributes:
        rest: Time for which the skin must not be touched at the start [s].
        patience: Time after which a part that is not felt is left [s].
        pause: Time without a touch after which a part that was felt in part is left [s].
        least: Smallest change that counts as felt, in the unit of the readings.
        ordered: Whether the parts are pressed in their order; False for a recording of any touches.

    Raises:
        LiveError: A number is out of range.
    """

    rest: float = 2.0
    patience: float = 20.0
    pause: float = 2.0
    least: float = 1.0
    ordered: bool = True

    def __post_init__(self) -> None:
        for name in ("rest", "patience", "pause", "least"):
            value = getattr(self, name)
            if not (math.isfinite(value) and 0 < value < 1e9):
                raise LiveError("a setting of the check is out of range", place=name, value=value)


@dataclass(frozen=True)
class PartResult:
    """Result of a part.

    Attributes:
        outcome: Its outcome.
        others: Numbers of the other parts that responded.
        seconds: Time that it took [s].
    """

    outcome: Outcome = Outcome.OPEN
    others: tuple[int, ...] = ()
    seconds: float = 0.0


@dataclass
class _Touch:
    """Attempts at the requested part."""

    since: float
    began: float
    peak: FloatArray
    pressed: bool = False
    last: float = -math.inf
    wrong: list[tuple[int, ...]] = field(default_factory=list)


class SkinCheck:
    """A guided check of a skin. Mutable.

    Args:
        skin: The skin.
        settings: Times and thresholds.

    Attributes:
        skin: Value of the argument.
        settings: Value of the argument.
        parts: Parts in the order in which they are requested.
        results: Result of each part.
        stage: Current stage.
        current: Number of the part to press.
        note: Remark on the newest touch, for the user; empty if there is none.
        readings: Number of readings.
        touches: Number of touches that have ended; those less than ``RELEASED`` apart count as one.
        baseline: (taxels,) value at rest; NaN where none arrived.
        noise: (taxels,) standard deviation at rest.
        limit: (taxels,) change above which a taxel is felt.
        rise: (taxels,) largest change above the baseline.
        fall: (taxels,) largest change below the baseline.
        extreme: (taxels,) value at the largest change.
        held: (taxels,) number of successive readings that had exactly this value.
        steady: (taxels,) largest number of successive equal readings at rest.
        changed: (taxels,) whether the value has ever changed.
        highest: (taxels,) largest value.
        lowest: (taxels,) smallest value.
        felt_in: (parts, taxels) whether a taxel was felt while a part was requested.
    """

    def __init__(self, skin: Skin, settings: CheckSettings | None = None) -> None:
        count = len(skin)
        self.skin = skin
        self.settings = settings or CheckSettings()
        self.parts: tuple[SkinPart, ...] = parts_of(skin)
        self._part_of = part_numbers(skin, self.parts)
        self._adjacent = adjacent_parts(skin, self.parts)
        self.results = [PartResult() for _ in self.parts]
        self.stage = CheckStage.REST
        self.current = 0
        self.note = ""
        self.readings = 0
        self.touches = 0
        self.baseline = np.full(count, np.nan)
        self.noise = np.zeros(count)
        self.limit = np.full(count, np.inf)
        self.rise = np.zeros(count)
        self.fall = np.zeros(count)
        self.extreme = np.full(count, np.nan)
        self.held: IntArray = np.zeros(count, dtype=np.int64)
        self.steady: IntArray = np.zeros(count, dtype=np.int64)
        self._run: IntArray = np.zeros(count, dtype=np.int64)
        self.changed: BoolArray = np.zeros(count, dtype=bool)
        self.highest = np.full(count, -np.inf)
        self.lowest = np.full(count, np.inf)
        self.felt_in: BoolArray = np.zeros((len(self.parts), count), dtype=bool)
        self._noisy: BoolArray = np.zeros(count, dtype=bool)
        self._first = np.full(count, np.nan)
        self._counts: IntArray = np.zeros(count, dtype=np.int64)
        self._sum = np.zeros(count)
        self._squares = np.zeros(count)
        self._before = np.full(count, np.nan)
        self._recovering = np.full(count, -np.inf)
        self._started: float | None = None
        self._time = -math.inf
        self._touch = _Touch(0.0, 0.0, np.zeros(count))
        self._swaps = SwapDetector(skin)

    @property
    def part(self) -> SkinPart | None:
        """Part to press; None at rest, at the end, and where the order is free."""
        return self.parts[self.current] if self.stage is CheckStage.PRESS and self.settings.ordered else None

    @property
    def felt(self) -> BoolArray:
        """(taxels,) whether each was felt so far."""
        return np.maximum(self.rise, self.fall) > self.limit

    @property
    def any_pressed(self) -> bool:
        """Whether anything was pressed, as far as responses and keys show."""
        unpressed = (Outcome.OPEN, Outcome.SKIPPED)
        return bool(self.felt.any()) or any(result.outcome not in unpressed for result in self.results)

    @property
    def heard(self) -> BoolArray:
        """(taxels,) whether a value of each arrived."""
        return np.isfinite(self.lowest)

    @property
    def noisy(self) -> BoolArray:
        """(taxels,) whether the noise at rest is far above that of the skin."""
        return self._noisy

    @property
    def swapped(self) -> tuple[SwappedChannels, ...]:
        """Channels of one part that seem to be exchanged, from the changes of all readings."""
        return self._swaps.swapped

    def add(self, values: FloatArray, time: float) -> None:
        """Use a reading.

        Args:
            values: (taxels,) newest value of each taxel in the unit of the readings; NaN where none arrived.
            time: Time of the reading [s]; earlier ones than the newest are ignored.
        """
        if self.stage is CheckStage.DONE or time < self._time:
            return
        passed = 0.0 if self._started is None else time - self._time
        self._started = time if self._started is None else self._started
        self._time = time
        self.readings += 1
        self.changed |= ~np.isnan(self._before) & (self._before != values) & ~np.isnan(values)
        self.highest = np.fmax(self.highest, values)
        self.lowest = np.fmin(self.lowest, values)
        self._swaps.add(values, time)
        if self.stage is CheckStage.REST:
            self._rest(values, time - self._started)
        else:
            self._press(values, passed)
        self._before = values.copy()

    def next(self) -> None:
        """Leave the requested part; it counts as pressed."""
        if self.stage is CheckStage.PRESS:
            self._leave(self._outcome())

    def skip(self) -> None:
        """Leave the requested part without a result."""
        if self.stage is CheckStage.PRESS:
            self._leave(Outcome.SKIPPED)

    def back(self) -> None:
        """Ask for the previous part again; its result is discarded, except what its channels have shown."""
        if self.stage is CheckStage.REST or not self.parts:
            return
        last = self.stage is CheckStage.DONE
        self.stage = CheckStage.PRESS
        self.current = len(self.parts) - 1 if last else max(self.current - 1, 0)
        self.results[self.current] = PartResult()
        self.felt_in[self.current] = False
        self._ask()

    def finish(self) -> None:
        """End the check, for example because the source has ended; parts that were not reached stay open.

        Raises:
            LiveError: The skin at rest was not measured.
        """
        if self.stage is CheckStage.REST:
            found = f"{self.readings} readings"
            remedy = f"Leave the skin untouched for {self.settings.rest:g} s at the start, at {_LEAST_AT_REST} readings"
            raise LiveError("the readings ended before the skin at rest was measured", value=found, remedy=remedy)
        if self.stage is CheckStage.PRESS and self._touch.pressed:
            self._end_touch()
        if self.stage is CheckStage.PRESS and self.settings.ordered and self.felt_in[self.current].any():
            self._leave(self._outcome())
        if not self.settings.ordered:
            for number, part in enumerate(self.parts):
                if self.felt[part.taxels].any():
                    self.results[number] = PartResult(Outcome.FELT)
        self.stage = CheckStage.DONE

    def _rest(self, values: FloatArray, passed: float) -> None:
        heard = ~np.isnan(values)
        self._first = np.where(np.isnan(self._first), values, self._first)
        away = np.where(heard, values - self._first, 0.0)  # deviations from the first value: no cancellation
        self._counts += heard
        self._sum += away
        self._squares += away * away
        self._run = np.where(values == self._before, self._run + 1, 1)
        self.steady = np.maximum(self.steady, self._run)
        if passed < self.settings.rest or self.readings < _LEAST_AT_REST:
            return
        counts = np.maximum(self._counts, 1)
        mean = self._sum / counts
        self.baseline = self._first + mean
        self.noise = np.sqrt(np.maximum(self._squares / counts - mean * mean, 0.0))
        known = self.noise[self._counts > 0]
        usual = float(np.median(known)) if len(known) else 0.0
        self._noisy = self.noise > np.maximum(_NOISY * usual, self.settings.least)
        self.limit = np.maximum(_DEVIATIONS * np.maximum(self.noise, usual), self.settings.least)
        self.stage = CheckStage.PRESS
        self._ask()

    def _ask(self) -> None:
        self._touch = _Touch(self._time, self._time, np.zeros(len(self.skin)))

    def _press(self, values: FloatArray, passed: float) -> None:
        new = np.isnan(self.baseline) & ~np.isnan(values)
        self.baseline = np.where(new, values, self.baseline)  # a channel that was silent at rest
        self.limit = np.where(new, np.maximum(_DEVIATIONS * np.median(self.noise), self.settings.least), self.limit)
        change = np.nan_to_num(values - self.baseline)
        size = np.abs(change)
        self._keep_extremes(values, change, size)
        touch = self._touch
        below = np.maximum(self.limit, RELEASED * touch.peak)
        touching = bool(((size > below) & ~self._noisy).any())
        if touching:
            touch.pressed = True
            touch.last = self._time
            touch.peak = np.maximum(touch.peak, size)
        elif not touch.pressed:
            quiet = size <= self.limit
            recovers = self._time < self._recovering
            follow = -np.expm1(-passed / np.where(recovers, _RECOVERY_SECONDS, _DRIFT_SECONDS))
            self.baseline = np.where(quiet, self.baseline + follow * change, self.baseline)
        if touch.pressed and self._time - touch.last >= RELEASED:
            self.baseline += change  # a cover that recovers slowly would seem to be touched again
            self._recovering[touch.peak > self.limit] = self._time + _RECOVERY
            self._end_touch()
        elif self.settings.ordered and not touch.pressed:
            self._wait()

    def _keep_extremes(self, values: FloatArray, change: FloatArray, size: FloatArray) -> None:
        before = np.maximum(self.rise, self.fall)
        higher = size > before
        repeats = (size == before) & (values == self._before) & (values == self.extreme)
        self.held = np.where(higher, 1, self.held + repeats)
        self.extreme = np.where(higher, values, self.extreme)
        self.rise = np.maximum(self.rise, change)
        self.fall = np.maximum(self.fall, -change)

    def _end_touch(self) -> None:
        """Judge which parts a touch has pressed."""
        self.touches += 1
        touch = self._touch
        felt = touch.peak > self.limit
        peak = np.where(felt, touch.peak, 0.0)
        touch.peak = np.zeros(len(peak))
        touch.pressed = False
        if not self.settings.ordered:
            return
        strength = np.bincount(self._part_of, weights=peak, minlength=len(self.parts))
        loud = np.flatnonzero(strength >= max(_AS_STRONG * strength.max(), np.finfo(float).tiny)).tolist()
        if self.current not in loud and self.felt_in[self.current].any():
            self._leave(Outcome.FELT)  # the user has moved on to the next part
            if self.stage is not CheckStage.PRESS:
                return
            touch = self._touch
        far = [part for part in loud if part != self.current and not self._adjacent[self.current, part]]
        if self.current in loud and not far:
            self._felt(felt)
        else:
            self._unclear(felt, tuple(part for part in loud if part != self.current))

    def _felt(self, felt: BoolArray) -> None:
        self.felt_in[self.current] |= felt
        self.note = ""
        self._touch.last = self._time
        missing = self.missing
        if not len(missing):
            self._leave(Outcome.FELT)

    def _unclear(self, felt: BoolArray, others: tuple[int, ...]) -> None:
        """Ask once more, unless the same other part responds twice, or too many touches were unclear."""
        touch = self._touch
        again = others in touch.wrong
        touch.wrong.append(others)
        names = self.names(others)
        own = self.parts[self.current].name
        own_felt = bool(felt[self.parts[self.current].taxels].any())
        if again or len(touch.wrong) >= _ATTEMPTS:
            self.felt_in[self.current] |= felt
            alone = len(others) == 1 and not own_felt
            self._leave(Outcome.OTHER if alone else Outcome.SEVERAL, others)
        elif len(others) == 1 and not own_felt:
            self.note = _sentence(f"{names} responded instead")
        else:
            self.note = (
                f"Several parts were felt: {own}, {names}." if own_felt else f"Several parts were felt: {names}."
            )
        touch.since = self._time

    def _wait(self) -> None:
        touch = self._touch
        if self.felt_in[self.current].any():
            if self._time - max(touch.last, touch.since) >= self.settings.pause:
                self._leave(Outcome.FELT)
        elif self._time - touch.since >= self.settings.patience:
            self._leave(self._outcome())

    def _outcome(self) -> Outcome:
        """Outcome of the requested part if it is left now."""
        own = self.parts[self.current].taxels
        if self.felt_in[self.current][own].any() or (self._touch.peak > self.limit)[own].any():
            return Outcome.FELT
        return Outcome.SEVERAL if self._touch.wrong else Outcome.NOTHING

    def _leave(self, outcome: Outcome, others: tuple[int, ...] = ()) -> None:
        touch = self._touch
        if outcome is Outcome.FELT:
            self.felt_in[self.current] |= touch.peak > self.limit
        if outcome is Outcome.SEVERAL and not others:
            others = tuple(sorted({part for wrong in touch.wrong for part in wrong}))
        self.results[self.current] = PartResult(outcome, others, self._time - touch.began)
        name = self.parts[self.current].name
        said = f"{outcome}: {self.names(others)}" if others else str(outcome)
        self.note = "" if outcome is Outcome.FELT else _sentence(f"{name}: {said}")
        if self.current + 1 >= len(self.parts):
            self.stage = CheckStage.DONE
            return
        self.current += 1
        self._ask()

    @property
    def prompt(self) -> str:
        """Instruction for the user, beginning in lower case unless a note precedes it."""
        if self.stage is CheckStage.REST:
            return f"leave the skin untouched for {self.settings.rest:g} s"
        if (part := self.part) is None:
            return "done"
        left = len(self.missing)
        if len(self.pressed) and left:
            return f"{part.name}: {left} of {len(part.taxels)} taxels are not felt yet; press them, or wait"
        ask = f"press {part.name} ({self.current + 1} of {len(self.parts)})"
        return f"{self.note} {ask[0].upper()}{ask[1:]}" if self.note else ask

    @property
    def missing(self) -> IntArray:
        """(k,) taxels of the requested part that send values and were not felt yet."""
        part = self.part
        if part is None:
            return np.zeros(0, dtype=np.int64)
        known = self.felt_in[self.current] | (self._touch.peak > self.limit)
        return part.taxels[self.heard[part.taxels] & ~known[part.taxels]]

    @property
    def pressed(self) -> IntArray:
        """(k,) taxels of the requested part that were felt."""
        part = self.part
        if part is None:
            return np.zeros(0, dtype=np.int64)
        known = self.felt_in[self.current] | (self._touch.peak > self.limit)
        return part.taxels[known[part.taxels]]

    def names(self, parts: Sequence[int]) -> str:
        """Return the names of parts, by their numbers."""
        return ", ".join(self.parts[part].name for part in parts)


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}."
