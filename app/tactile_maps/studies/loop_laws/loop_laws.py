"""Do the closed-form laws of sampled loops hold for our controllers, and where do they deviate?"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from tactile_maps.studies.base.figures import Figure, Panel
from tactile_maps.studies.base.hypotheses import Hypothesis, Interval, Judgement, all_of, bootstrap_median, within
from tactile_maps.studies.base.rows import Case, Row, distinct, number_or
from tactile_maps.studies.loop_laws.predictions import COMPARISONS, IDEAL_JOINTS, OUR_SERVO, PERIOD
from tactile_maps.studies.study.study import Study

Quantity = Literal["settling", "onset", "ripple"]
DELAYS = range(5)
"""Delays of the readings in periods."""
LOOP_GAINS = (0.05, 0.1, 0.2)
"""Gains whose ripple is measured."""
SEEDS = 10
ALIKE = (0.9, 1.1)
"""Accepted range of measured over predicted."""
_STEADY = (0.8, 1.25)
"""Accepted range of variance times settling time over its median, for runs of finite length."""
_SAMPLES = 600
_QUICK_SAMPLES = 200
"""Samples of a ripple run, times the gain of the loop."""
_LEFT = math.log(50.0)
"""Time constants of a step until 2 % are left."""


def cases(quick: bool, seed: int) -> list[Case]:
    """Return each law by delay, with ideal joints and with our posture loop, and ripple by gain and seed."""
    plants = (IDEAL_JOINTS,) if quick else (IDEAL_JOINTS, OUR_SERVO)
    delays = (0, 2) if quick else DELAYS
    same = {"controller": "hybrid", "x": 0.0, "seed": seed}
    steps: list[Case] = [
        {"law": name, "plant": plant, "what": what, "delay": delay, **same}
        for plant in plants
        for name, what in (("settling", "force"), ("settling", "place"), ("onset", "force"))
        for delay in delays
    ]
    ripples: list[Case] = [
        {
            "law": "ripple",
            "plant": IDEAL_JOINTS,
            "what": "force",
            "delay": 0,
            "controller": "hybrid",
            "x": gain,
            "samples": _QUICK_SAMPLES if quick else _SAMPLES,
            "seed": number,
        }
        for number in range(seed, seed + (2 if quick else SEEDS))
        for gain in LOOP_GAINS
    ]
    return steps + ripples


def measure(case: Case) -> list[Row]:
    """Return one row: the measured value, the theory of ideal joints, and the theory with the posture loop."""
    measured, predicted, explained = COMPARISONS[case["law"]](case)
    return [{"measured": measured, "predicted": predicted, "explained": explained}]


def figures(rows: Sequence[Row]) -> list[Figure]:
    """Return measured and predicted values by delay."""
    made = []
    for name, title, unit in (
        ("settling", "Settling of a step to 2 %", "s"),
        ("onset", "Stiffness at the onset of oscillation", "N/m"),
    ):
        own = [row for row in rows if row["law"] == name]
        if own:
            made.append(Figure(title, "delay of the readings, plus one half", unit, _panels(own)))
    return made


def _panels(rows: Sequence[Row]) -> list[Panel]:
    return [
        Panel(
            f"{plant}, {what}",
            {
                name: [(number_or(row["delay"], 0.0) + 0.5, number_or(row[key], math.inf)) for row in own]
                for name, key in _NAMES
            },
        )
        for plant in distinct(rows, "plant")
        for what in distinct(rows, "what")
        for own in [[row for row in rows if (row["plant"], row["what"]) == (plant, what)]]
    ]


_NAMES = (("measured", "measured"), ("theory", "predicted"), ("theory with the posture loop", "explained"))


def _with_ideal_joints(rows: Sequence[Row], quantity: Quantity) -> list[Row]:
    return [row for row in rows if row["law"] == quantity and row["plant"] == IDEAL_JOINTS]


def _settling(rows: Sequence[Row]) -> Judgement:
    """Judge settling with delay; without delay a step settles in one sample, which the rule of thumb does not cover."""
    late = [row for row in _with_ideal_joints(rows, "settling") if row["delay"]]
    ratios = [
        number_or(row["measured"], math.inf) / (6.4 * (number_or(row["delay"], 0.0) + 0.5) * PERIOD) for row in late
    ]
    return _single(ratios, "settling time over 6.4 (d + 1/2) T")


def _onset(rows: Sequence[Row]) -> Judgement:
    own = _with_ideal_joints(rows, "onset")
    ratios = [number_or(row["measured"], math.inf) / number_or(row["predicted"], math.inf) for row in own]
    return _single(ratios, "stiffness of onset over L_max / (k_f T)")


def _single(ratios: Sequence[float], words: str) -> Judgement:
    """Judge deterministic ratios, whose intervals are single values."""
    verdict = all_of([within(Interval(ratio, ratio, ratio), *ALIKE) for ratio in ratios])
    span = f"{min(ratios):.3g} to {max(ratios):.3g}" if ratios else "no rows"
    return Judgement(verdict, f"{words}: {span}", len(ratios))


def _ripple(rows: Sequence[Row]) -> Judgement:
    own = _with_ideal_joints(rows, "ripple")
    products = {gain: [_product(row) for row in own if row["x"] == gain] for gain in LOOP_GAINS}
    known = {gain: bootstrap_median(found) for gain, found in products.items() if found}
    if not known:
        return Judgement(all_of([]), "no rows", 0)
    middle = sorted(interval.middle for interval in known.values())[len(known) // 2]
    scaled = {gain: Interval(*(value / middle for value in interval)) for gain, interval in known.items()}
    words = "; ".join(f"L = {gain}: {interval}" for gain, interval in scaled.items())
    verdict = all_of([within(interval, *_STEADY) for interval in scaled.values()])
    return Judgement(verdict, f"variance of the force times settling time, over its median: {words}", len(own))


def _product(row: Row) -> float:
    """Variance over that of the noise, times samples to 2 % at that gain."""
    return number_or(row["measured"], math.inf) ** 2 * _LEFT / -math.log1p(-number_or(row["x"], 0.0))


STUDY = Study(
    "loop-laws",
    "Do the closed-form laws of sampled loops hold for our controllers, and where do they deviate?",
    "A plate of skin of 4 kg on three slides is pressed on a fixed ball, without friction, by ideal joints "
    f"or under the posture loop of 40 rad/s. The skin is read every {PERIOD:g} s with a delay of whole periods; the "
    "controller is the hybrid one, with the largest gain without overshoot where a step settles. Ripple is that of "
    "the true force over the noise of the reading, every 20 ms. Theory: a sampled integral loop with d samples of "
    "delay is stable below L = 2 sin(pi / (2 (2 d + 1))), has its largest gain without overshoot at "
    "d^d / (d + 1)^(d + 1), and settles to 2 % in about 6.4 (d + 1/2) T. Where the posture loop deviates from it, the "
    "third curve is the theory with that loop.",
    cases,
    measure,
    figures,
    (
        Hypothesis("H3", "A step settles to 2 % in 6.4 (d + 1/2) T, within a tenth.", _settling),
        Hypothesis("H4", "Ripple squared times settling time is the same at every gain.", _ripple),
        Hypothesis("H5", "The force oscillates above a stiffness of L_max / (k_f T), within a tenth.", _onset),
    ),
)
