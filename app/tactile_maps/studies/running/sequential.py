"""Runs within a time budget: complete seeds first, no further seeds for settled groups, and a list of open questions.

A **group** is a case without its seed. The effect of a group is the difference of its value from that of the nominal
group for the same seeds; pairing cancels the common effect of a seed. A group is settled once the 95 % bootstrap
interval of the median effect is on one side of a band about zero (it differs) or within the band (it is equivalent),
with a minimum number of seeds. Repeated testing makes an error more likely than 5 % for effects of about the width of
the band; the band and the minimum number protect the others.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TypeAlias

from tactile_maps.studies.base.hypotheses import Interval, bootstrap_median
from tactile_maps.studies.base.rows import Case, Row
from tactile_maps.studies.running.case_run import CaseRun

Group: TypeAlias = str
"""Settings of a case without its seed, as JSON."""
SEED = "seed"
_LONGEST = 12
"""Maximum number of open groups that are listed."""


class Settled(Enum):
    """Conclusion from the seeds so far about the effect of a group."""

    DIFFERS = "differs"
    EQUIVALENT = "equivalent"
    OPEN = "open"


@dataclass(frozen=True)
class PairedEffect:
    """Definition of the effect that the seeds of a study are to decide.

    Attributes:
        keys: Settings that define a group.
        value: Value of a row, in the unit of the band; infinite for a failure; None without a value.
        nominal: Settings of the nominal group that differ from those of the compared group.
        band: Effects between minus and plus this value count as none.
        least: Minimum number of seeds.
        words: Formats an effect for people.
    """

    keys: tuple[str, ...]
    value: Callable[[Row], float | None]
    nominal: Mapping[str, str | float | int]
    band: float
    least: int = 5
    words: Callable[[float], str] = "{:.3g}".format

    def group(self, case: Case | Row) -> Group:
        """Return the group of a case or row."""
        return json.dumps([case.get(key) for key in self.keys])

    def compared_with(self, case: Case | Row) -> Group:
        """Return the nominal group of a case or row."""
        return self.group({**case, **self.nominal})

    def effects(self, rows: Sequence[Row]) -> dict[Group, list[float]]:
        """Return the effects of each group except the nominal ones, one for each seed that has both values."""
        values = {(self.group(row), row.get(SEED)): self.value(row) for row in rows if "problem" not in row}
        found: dict[Group, list[float]] = {}
        for row in rows:
            group = self.group(row)
            nominal = self.compared_with(row)
            if group == nominal:
                continue
            known = found.setdefault(group, [])
            one = values.get((group, row.get(SEED)))
            other = values.get((nominal, row.get(SEED)))
            if one is not None and other is not None and math.isfinite(other):
                known.append(one - other)
        return found

    def verdict(self, effects: Sequence[float]) -> tuple[Settled, Interval | None]:
        """Return the conclusion from effects, and their interval; None without effects."""
        if not effects:
            return Settled.OPEN, None
        interval = bootstrap_median(effects)
        if len(effects) < self.least:
            return Settled.OPEN, interval
        if interval.low > self.band or interval.high < -self.band:
            return Settled.DIFFERS, interval
        if -self.band <= interval.low and interval.high <= self.band:
            return Settled.EQUIVALENT, interval
        return Settled.OPEN, interval

    def settled(self, rows: Sequence[Row]) -> set[Group]:
        """Return the groups that need no more seeds; a nominal group when all groups compared with it are settled."""
        effects = self.effects(rows)
        found = {group for group, known in effects.items() if self.verdict(known)[0] is not Settled.OPEN}
        needed = {self.compared_with(row) for row in rows if self.group(row) in effects.keys() - found}
        return found | ({self.compared_with(row) for row in rows} - needed)


@dataclass(frozen=True)
class Outcome:
    """Result of a run within a budget.

    Attributes:
        spared: Number of cases not measured because their group was settled.
        undecided: Questions that the table does not decide, and why, as sentences.
    """

    spared: int
    undecided: tuple[str, ...]


def run_within(run: CaseRun, *, until: float, effect: PairedEffect | None = None) -> Outcome:
    """Measure cases seed by seed until the time is over or all groups are settled.

    Args:
        run: The cases, some of which may be finished.
        until: Time to stop, by ``time.monotonic``.
        effect: Effect to decide; None to measure every seed of every group.

    Raises:
        TactileMapsError: Same as for ``CaseRun.go_on``.
    """
    seeds = list(dict.fromkeys(case.get(SEED) for case in run.cases))
    order = sorted(range(len(run.cases)), key=lambda number: seeds.index(run.cases[number].get(SEED)))
    if effect is None:
        run.go_on(order, until=until)
        return Outcome(0, _missing(run, run.missing))
    settled: set[Group] = set()
    for seed in seeds:
        pending = [n for n in order if run.cases[n].get(SEED) == seed and effect.group(run.cases[n]) not in settled]
        run.go_on(pending, until=until)
        settled |= effect.settled(run.rows)
    spared = {number for number in run.missing if effect.group(run.cases[number]) in settled}
    missing = _missing(run, [number for number in run.missing if number not in spared])
    return Outcome(len(spared), (*missing, *_open(effect, run.rows, settled)))


def _missing(run: CaseRun, numbers: Sequence[int]) -> tuple[str, ...]:
    """Number of cases that the time did not suffice for, and number of complete seeds."""
    if not numbers:
        return ()
    seeds = {case.get(SEED) for case in run.cases}
    whole = len(seeds - {run.cases[number].get(SEED) for number in numbers})
    left = f"{len(numbers)} of {len(run.cases)} cases are missing"
    return (f"The time is over, and {left}: {whole} of {len(seeds)} seeds are complete.",)


def _open(effect: PairedEffect, rows: Sequence[Row], settled: Collection[Group]) -> list[str]:
    sentences = []
    for group, known in effect.effects(rows).items():
        if group in settled:
            continue
        _, interval = effect.verdict(known)
        words = ", ".join(str(value) for value in json.loads(group) if value not in (None, ""))
        if interval is None:
            sentences.append(f"{words}: no seed can be compared.")
        else:
            span = f"{effect.words(interval.low)} and {effect.words(interval.high)}"
            sentences.append(f"{words}: the effect is between {span}; seeds: {len(known)}.")
    more = len(sentences) - _LONGEST
    return sentences if more <= 0 else [*sentences[:_LONGEST], f"And {more} more."]
