"""Do the laws do what the theory of sampled loops says, with ideal joints and in the simulator?"""

from __future__ import annotations

import math
from collections.abc import Sequence

from app.control.laws import RULES
from app.experiments.control_setup import SLEEVES
from app.experiments.experiment import Experiment
from app.experiments.sweep import Case, Row
from app.experiments.theory_figures import figures
from app.experiments.theory_rows import FAST, IDEAL_JOINTS, LAGGING, LAWS, OURS, PERIOD, PLANTS, ROWS

DELAYS = range(5)
_LOOPS = ("force", "place")
_STRETCHES, _TURNS = (1.18, 1.55, 2.0, 3.0, 5.0), (5.0, 15.0, 30.0, 45.0, 60.0, 75.0)

Point = dict[str, object]


def cases(quick: bool, seed: int) -> list[Case]:
    """Every figure's points, for ideal joints and simulated ones."""
    delays = (0, 2) if quick else tuple(DELAYS)
    found = _of_laws(delays)
    for plant in (IDEAL_JOINTS, OURS) if quick else PLANTS:
        points = [point for delay in delays for point in _of_a_delay(delay)]
        points += [*_without_delay(quick), *_of_one_delay(plant, quick)]
        found += [{"plant": plant, **point} for point in points]
    found += _lagging(quick) + _of_arms(quick)
    return [{"figure": "", "what": "force", "law": "hybrid", "delay": 1, **case, "seed": seed} for case in found]


def _of_a_delay(delay: int) -> list[Point]:
    loops: list[Point] = [{"figure": name, "what": what} for name in ("stability", "settling") for what in _LOOPS]
    loops += [{"figure": "onset", "what": "force"}]
    loops += [{"figure": "behind", "what": what} for what in ("as seen", "in truth", "in truth, told of it")]
    return [{**loop, "delay": delay, "x": delay + 0.5} for loop in loops]


def _without_delay(quick: bool) -> list[Point]:
    """Ripple at loop gains; Routh's bound at position gains."""
    samples, gains = (100, (0.2, 0.4)) if quick else (800, (0.05, 0.1, 0.2, 0.4))
    noisy: list[Point] = [{"figure": "ripple", "delay": 0, "x": gain, "samples": samples} for gain in gains]
    places, times = ((10.0,), (0.2,)) if quick else ((1.0, 3.0, 10.0), (0.2, 0.4))
    bound: Point = {"figure": "routh", "law": "parallel", "delay": 0}
    bounds = [{**bound, "x": x, "inertia": t, "what": f"inertia time {t:g} s"} for t in times for x in places]
    return [*noisy, *bounds]


def _of_one_delay(plant: str, quick: bool) -> list[Point]:
    """Maps stretched and turned; a posture loop that is asked more and more often."""
    stretches, turns = ((2.0,), (30.0,)) if quick else (_STRETCHES, _TURNS)
    shaped: list[Point] = [
        {"figure": "stretch", "what": law, "law": law, "x": x} for law in ("projection", "hybrid") for x in stretches
    ]
    shaped += [{"figure": "turn", "what": "place", "x": x} for x in turns]
    often = _periods(quick) if plant != FAST else ()
    return shaped + [{"figure": "lag", "what": "posture loop, d = 1", "x": period} for period in often]


def _of_laws(delays: Sequence[int]) -> list[Point]:
    """The onset of all other laws, with ideal joints."""
    laws = [law for law in LAWS if law != "hybrid"]
    point: Point = {"plant": IDEAL_JOINTS, "figure": "onset", "what": "force"}
    return [{**point, "law": law, "delay": delay, "x": delay + 0.5} for law in laws for delay in delays]


def _lagging(quick: bool) -> list[Point]:
    """Ideal joints that lag."""
    point: Point = {"plant": LAGGING, "figure": "lag"}
    delays = (0, 1)
    return [{**point, "what": f"{LAGGING}, d = {d}", "x": t, "delay": d} for t in _periods(quick) for d in delays]


def _of_arms(quick: bool) -> list[Point]:
    """Whole robots beside a ball."""
    robots, laws = (("arm",), ("hybrid",)) if quick else (tuple(SLEEVES), tuple(RULES))
    point: Point = {"figure": "arms", "delay": 0, "x": 0.0}
    return [{"plant": robot, **point, "what": robot, "robot": robot, "law": law} for robot in robots for law in laws]


def _periods(quick: bool) -> tuple[float, ...]:
    return (0.25,) if quick else (0.02, 0.05, 0.1, 0.25, 1.0)


def measure(case: Case) -> list[Row]:
    """One row: what was measured and what both theories say, and how far it is off each [%]."""
    measured, predicted, explained = ROWS[case["figure"]](case)
    x = case["x"]
    if case["figure"] == "ripple":
        x = 0.02 * math.log(50) / -math.log1p(-case["x"])
    elif case["figure"] == "settling":
        x = PERIOD * case["x"]
    elif case["figure"] == "arms":
        x = explained
    return [
        {
            "x": x,
            "measured": measured,
            "theory": predicted,
            "explained": explained,
            "off_percent": _off(measured, predicted),
            "explained_off_percent": _off(measured, explained),
        }
    ]


def _off(measured: float, predicted: float) -> float | None:
    return 100 * (measured / predicted - 1) if predicted else None


EXPERIMENT = Experiment(
    "control-theory",
    "Do the laws do what the theory of sampled loops says, and where the simulator departs, why?",
    "A plate of skin of 4 kg on three slides is pressed on a ball that stands still, without friction. Joints are "
    "ideal, or simulated under the posture loop of 40 rad/s that all laws use, or under one ten times as fast. The "
    "skin is read every 0.25 s unless said otherwise, late by whole periods. Each loop comes to rest at a calm gain; "
    "then a goal is moved. A loop counts as unstable when errors grow; limits are found to 3 %. The theory is that of"
    " ideal joints; the other line has the posture loop, the plate's mass and the contact's own spring and damper in "
    "it.",
    cases,
    measure,
    figures,
)
