"""Do the closed-form laws of sampled loops hold for our controllers, and where do they depart?"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from tactile_maps.studies.base.figures import Figure, Panel
from tactile_maps.studies.base.hypotheses import Hypothesis, Interval, Judgement, all_of, bootstrap_median, within
from tactile_maps.studies.base.rows import Case, Row, distinct, number_or
from tactile_maps.studies.loop_laws.predictions import COMPARISONS, IDEAL_JOINTS, OUR_SERVO, PERIOD
from tactile_maps.studies.study.study import Study

Law = Literal["settling", "onset", "ripple"]
DELAYS = range(5)
"""Of the readings, in periods."""
LOOP_GAINS = (0.05, 0.1, 0.2)
"""Whose ripple is measured."""
SEEDS = 10
ALIKE = (0.9, 1.1)
"""Measured over predicted: a tenth."""
_STEADY = (0.8, 1.25)
"""Variance times settling time over its middle: runs are finite."""
_SAMPLES = 600
_QUICK_SAMPLES = 200
"""Of a ripple's run, times the loop's gain."""
_LEFT = math.log(50.0)
"""Of a step, until 2 % are left."""


def cases(quick: bool, seed: int) -> list[Case]:
    """Each law by delay, with ideal joints and with our posture loop; ripple by gain and seed."""
    plants = (IDEAL_JOINTS,) if quick else (IDEAL_JOINTS, OUR_SERVO)
    delays = (0, 2) if quick else DELAYS
    same = {"controller": "hybrid", "x": 0.0, "seed": seed}
    steps: list[Case] = [
        {"law": law, "plant": plant, "what": what, "delay": delay, **same}
        for plant in plants
        for law, what in (("settling", "force"), ("settling", "place"), ("onset", "force"))
        for delay in delays
    ]
    ripples: list[Case] = [
        {"law": "ripple", "plant": IDEAL_JOINTS, "what": "force", "delay": 0, "controller": "hybrid", "x": gain,
         "samples": _QUICK_SAMPLES if quick else _SAMPLES, "seed": number}
        for number in range(seed, seed + (2 if quick else SEEDS))
        for gain in LOOP_GAINS
    ]  # fmt: skip
    return steps + ripples


def measure(case: Case) -> list[Row]:
    """One row: the figure measured, that of ideal joints by theory, and that by theory with the posture loop in it."""
    measured, predicted, explained = COMPARISONS[case["law"]](case)
    return [{"measured": measured, "predicted": predicted, "explained": explained}]


def figures(rows: Sequence[Row]) -> list[Figure]:
    """Measured beside predicted, by delay."""
    made = []
    for law, title, unit in (
        ("settling", "Settling of a step to 2 %", "s"),
        ("onset", "Stiffness from which on the force oscillates", "N/m"),
    ):
        of = [row for row in rows if row["law"] == law]
        if of:
            made.append(Figure(title, "readings late, and a half", unit, _panels(of)))
    return made


def _panels(rows: Sequence[Row]) -> list[Panel]:
    return [
        Panel(
            f"{plant}, {what}",
            {
                name: [(number_or(row["delay"], 0.0) + 0.5, number_or(row[key], math.inf)) for row in of]
                for name, key in _NAMES
            },
        )
        for plant in distinct(rows, "plant")
        for what in distinct(rows, "what")
        for of in [[row for row in rows if (row["plant"], row["what"]) == (plant, what)]]
    ]


_NAMES = (("measured", "measured"), ("theory", "predicted"), ("theory with the posture loop", "explained"))


def _of(rows: Sequence[Row], law: Law) -> list[Row]:
    return [row for row in rows if row["law"] == law and row["plant"] == IDEAL_JOINTS]


def _settling(rows: Sequence[Row]) -> Judgement:
    """Without delay a step settles at once, in one sample, which the rule of thumb does not cover."""
    late = [row for row in _of(rows, "settling") if row["delay"]]
    ratios = [
        number_or(row["measured"], math.inf) / (6.4 * (number_or(row["delay"], 0.0) + 0.5) * PERIOD) for row in late
    ]
    return _single(ratios, "settling time over 6.4 (d + 1/2) T")


def _onset(rows: Sequence[Row]) -> Judgement:
    of = _of(rows, "onset")
    ratios = [number_or(row["measured"], math.inf) / number_or(row["predicted"], math.inf) for row in of]
    return _single(ratios, "stiffness of onset over L_max / (k_f T)")


def _single(ratios: Sequence[float], words: str) -> Judgement:
    """There is no chance in these: an interval is its middle."""
    verdict = all_of([within(Interval(ratio, ratio, ratio), *ALIKE) for ratio in ratios])
    told = f"{min(ratios):.3g} to {max(ratios):.3g}" if ratios else "no rows"
    return Judgement(verdict, f"{words}: {told}", len(ratios))


def _ripple(rows: Sequence[Row]) -> Judgement:
    of = _of(rows, "ripple")
    products = {gain: [_product(row) for row in of if row["x"] == gain] for gain in LOOP_GAINS}
    known = {gain: bootstrap_median(found) for gain, found in products.items() if found}
    if not known:
        return Judgement(all_of([]), "no rows", 0)
    middle = sorted(interval.middle for interval in known.values())[len(known) // 2]
    scaled = {gain: Interval(*(value / middle for value in interval)) for gain, interval in known.items()}
    told = "; ".join(f"L = {gain}: {interval}" for gain, interval in scaled.items())
    verdict = all_of([within(interval, *_STEADY) for interval in scaled.values()])
    return Judgement(verdict, f"variance of the force times settling time, over its middle: {told}", len(of))


def _product(row: Row) -> float:
    """Variance by that of the noise, times samples to 2 % at that gain."""
    return number_or(row["measured"], math.inf) ** 2 * _LEFT / -math.log1p(-number_or(row["x"], 0.0))


STUDY = Study(
    "loop-laws",
    "Do the closed-form laws of sampled loops hold for our controllers, and where do they depart?",
    "A plate of skin of 4 kg on three slides is pressed on a ball that stands still, without friction, by ideal joints "
    f"or under the posture loop of 40 rad/s. The skin is read every {PERIOD:g} s, late by whole periods; the "
    "controller is the hybrid one, with the greatest gain without overshoot where a step settles. Ripple is that of "
    "the true force by the noise read, every 20 ms. Theory: a sampled integral loop with d samples of delay is stable "
    "below L = 2 sin(pi / (2 (2 d + 1))), has its greatest gain without overshoot at d^d / (d + 1)^(d + 1), and "
    "settles to 2 % in about 6.4 (d + 1/2) T. Where the posture loop departs from it, the third curve is theory with "
    "that loop.",
    cases,
    measure,
    figures,
    (
        Hypothesis("H3", "A step settles to 2 % in 6.4 (d + 1/2) T, within a tenth.", _settling),
        Hypothesis("H4", "Ripple squared times settling time is the same at every gain.", _ripple),
        Hypothesis("H5", "The force oscillates from a stiffness of L_max / (k_f T) on, within a tenth.", _onset),
    ),
)
