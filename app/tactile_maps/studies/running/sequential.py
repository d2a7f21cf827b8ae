"""Runs spent where they decide: whole seeds first, no more seeds of what is settled, and what is left open said.

A **group** is what a case asks without its seed. The effect of a group is what its value differs from the nominal
group's of the same seeds: paired, so that what a seed does to both cancels. It is settled once the 95 % bootstrap
interval of its median lies on one side of a band about zero (it differs) or within it (it is equivalent), with a least
number of seeds. Looking again after each seed makes a wrong answer more likely than 5 % for effects as large as the
band is wide; the band and the least number guard the others.
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
"""The settings of a case that are not its seed, as JSON."""
SEED = "seed"
_LONGEST = 12
"""So many groups that are open are told one by one."""


class Settled(Enum):
    """What the seeds so far say of a group's effect."""

    DIFFERS = "differs"
    EQUIVALENT = "equivalent"
    OPEN = "open"


@dataclass(frozen=True)
class PairedEffect:
    """What a study's seeds are to decide.

    Attributes:
        keys: The settings that make a group.
        value: Of a row, in the unit of the band; infinite where it cannot; None where it says nothing.
        nominal: The settings, instead of a group's own, of the nominal group it is compared with.
        band: An effect within plus and minus this is as good as none.
        least: Seeds before anything is settled.
        words: An effect as a person reads it.
    """

    keys: tuple[str, ...]
    value: Callable[[Row], float | None]
    nominal: Mapping[str, str | float | int]
    band: float
    least: int = 5
    words: Callable[[float], str] = "{:.3g}".format

    def group(self, case: Case | Row) -> Group:
        """Of a case, or of its row."""
        return json.dumps([case.get(key) for key in self.keys])

    def compared_with(self, case: Case | Row) -> Group:
        """The nominal group of a case."""
        return self.group({**case, **self.nominal})

    def effects(self, rows: Sequence[Row]) -> dict[Group, list[float]]:
        """Of each group but the nominal ones, one effect for each seed that has both."""
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
        """What so many seeds say, and the interval of the effect; None where there is no seed."""
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
        """The groups that need no more seeds; a nominal one when none that is compared with it does."""
        effects = self.effects(rows)
        found = {group for group, known in effects.items() if self.verdict(known)[0] is not Settled.OPEN}
        needed = {self.compared_with(row) for row in rows if self.group(row) in effects.keys() - found}
        return found | ({self.compared_with(row) for row in rows} - needed)


@dataclass(frozen=True)
class Outcome:
    """How a run within a budget ended.

    Attributes:
        spared: Cases that were not measured, as their group was settled.
        undecided: What the table does not decide, and why, as sentences.
    """

    spared: int
    undecided: tuple[str, ...]


def run_within(run: CaseRun, *, until: float, effect: PairedEffect | None = None) -> Outcome:
    """Measure cases seed by seed until the time is over or all that is asked is settled.

    Args:
        run: The cases, some of which may be done.
        until: When to stop, by ``time.monotonic``.
        effect: What is to be decided; None measures every seed of every group.

    Raises:
        TactileMapsError: As ``CaseRun.go_on``.
    """
    seeds = list(dict.fromkeys(case.get(SEED) for case in run.cases))
    order = sorted(range(len(run.cases)), key=lambda number: seeds.index(run.cases[number].get(SEED)))
    if effect is None:
        run.go_on(order, until=until)
        return Outcome(0, _missing(run, run.missing))
    settled: set[Group] = set()
    for seed in seeds:
        asked = [n for n in order if run.cases[n].get(SEED) == seed and effect.group(run.cases[n]) not in settled]
        run.go_on(asked, until=until)
        settled |= effect.settled(run.rows)
    spared = {number for number in run.missing if effect.group(run.cases[number]) in settled}
    missing = _missing(run, [number for number in run.missing if number not in spared])
    return Outcome(len(spared), (*missing, *_open(effect, run.rows, settled)))


def _missing(run: CaseRun, numbers: Sequence[int]) -> tuple[str, ...]:
    """How many cases the time did not suffice for, and how many seeds are whole."""
    if not numbers:
        return ()
    seeds = {case.get(SEED) for case in run.cases}
    whole = len(seeds - {run.cases[number].get(SEED) for number in numbers})
    return (f"Time was out before {len(numbers)} of {len(run.cases)} cases: {whole} of {len(seeds)} seeds are whole.",)


def _open(effect: PairedEffect, rows: Sequence[Row], settled: Collection[Group]) -> list[str]:
    told = []
    for group, known in effect.effects(rows).items():
        if group in settled:
            continue
        _, interval = effect.verdict(known)
        words = ", ".join(str(value) for value in json.loads(group) if value not in (None, ""))
        if interval is None:
            told.append(f"{words}: no seed can be compared.")
        else:
            span = f"{effect.words(interval.low)} and {effect.words(interval.high)}"
            told.append(f"{words}: the effect is between {span}; seeds: {len(known)}.")
    more = len(told) - _LONGEST
    return told if more <= 0 else [*told[:_LONGEST], f"And {more} more."]
