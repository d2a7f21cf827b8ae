"""What does accuracy cost in time, in contact motion control: which law follows a path how fast, knowing how much?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from app.control.command import ControlSettings
from app.control.laws import RULES
from app.control.map_path import path_about
from app.experiments.control_factors import FACTORS, NOMINAL, known_by, setup_of
from app.experiments.control_figures import figures
from app.experiments.control_gains import least_time, tuned
from app.experiments.experiment import Experiment
from app.experiments.speed_search import Found, Wanted, fastest
from app.experiments.sweep import Case, Row
from app.maps.map_jacobian import JacobianKind
from app.skin.misplace import Unit

ROBOTS = ("arm", "ur5e", "icub")
SEEDS = 5
BAND_N = 0.6
_FEW: Mapping[str, Sequence[float | str]] = {
    "rate": (10.0, 1000.0),
    "delay": (2,),
    "noise": (1000.0,),
    "map": ("lscm", "information-distance"),
    "misplaced": (3.0,),
    "estimator": ("lumped",),
}
"""Levels on robots other than our own arm."""
_QUICK: Mapping[str, Sequence[float | str]] = {
    "tolerance": (5.0,),
    "rate": (10.0, 100.0),
    "delay": (2,),
    "noise": (1000.0,),
    "map": ("lscm",),
    "misplaced": (2.0,),
    "estimator": ("lumped",),
}
QUICK_SIZE = 0.02
"""Of the path where time is short [m]."""
_QUICK_LAWS = ("hybrid", "qp")


def cases(quick: bool, seed: int) -> list[Case]:
    """Every law on every robot at every level of one factor at a time, for some seeds."""
    return [
        {"robot": robot, "law": law, "factor": factor, "level": level, "jacobian": jacobian, "by": by, "seed": number}
        | ({"quick": True} if quick else {})
        for number in range(seed, seed + (1 if quick else SEEDS))
        for robot in (ROBOTS[:1] if quick else ROBOTS)
        for factor, level, jacobian, by in _levels(robot, quick)
        for law in (_QUICK_LAWS if quick else RULES)
    ]


def _levels(robot: str, quick: bool) -> Iterator[tuple[str, float | str, JacobianKind, Unit]]:
    """Factor, level, whose word is taken for the map's Jacobian, and what is misplaced as one."""
    factors = _QUICK if quick else (FACTORS if robot == ROBOTS[0] else _FEW)
    yield "nominal", "", "smoothed", "taxel"
    if not quick:
        yield "misplaced", NOMINAL["misplaced"], "raw", "taxel"
    for factor, levels in factors.items():
        for level in levels:
            yield factor, level, "smoothed", "taxel"
            if factor == "misplaced":
                yield factor, level, "raw", "taxel"
            if factor == "misplaced" and not quick:
                yield factor, level, "smoothed", "module"
                yield factor, level, "raw", "module"


def measure(case: Case) -> list[Row]:
    """One row: the shortest time that is well enough, and what it is bound by."""
    knowledge = known_by(case["factor"], case["level"], case["by"])
    setup = setup_of(case["robot"], knowledge, case["seed"])
    period = 1.0 / knowledge.rate
    settings = replace(
        tuned(ControlSettings(law=case["law"], task="follow_path"), period, knowledge.delay), jacobian=case["jacobian"]
    )
    if case.get("quick"):
        settings = replace(settings, path_size=QUICK_SIZE)
    tolerance = float(case["level"] if case["factor"] == "tolerance" else NOMINAL["tolerance"])
    wanted = Wanted(1e-3 * tolerance, BAND_N)
    length = path_about(settings.path_kind, np.zeros(2), settings.path_size).length
    found = fastest(setup, settings, wanted, length=length, refinements=1 if case.get("quick") else 2)
    bound = least_time(length, wanted.error, period, knowledge.delay)
    return [{"tolerance_mm": tolerance, **row(found, settings), "bound_s": bound}]


def row(found: Found, settings: ControlSettings) -> dict[str, float | str | int]:
    """What a search came to, for a table."""
    course, met = found.course, found.speed == found.speed
    return {
        "verdict": "met" if met else "cannot",
        "seconds": course.finished if met else float("nan"),
        "speed_mm_s": 1e3 * found.speed,
        "error_mm": 1e3 * course.error_p95,
        "rms_mm": 1e3 * course.error_rms,
        "force_n": course.force_p95(settings.force_goal),
        "in_band_percent": 100 * course.in_band(settings.force_goal, BAND_N),
        "lost_percent": 100 * course.lost,
        "fastest_joint": float(course.speed.max(initial=0.0)),
        "energy_min_j": course.energy_minimum,
        "limited_by": found.limit,
        "why_limited": "; ".join(course.why_limited),
        "position_gain": settings.position_gain,
        "force_gain": settings.force_gain,
        "runs": found.runs,
        "control_ms": course.control_ms,
    }


EXPERIMENT = Experiment(
    "control-cost",
    "In how short a time can a contact be led along a path within a tolerance on the body, and what does it cost to "
    "know the skin less well?",
    "Each robot wears skin with taxels 8 mm apart on its forearm, at home beside a fixed ball of 30 mm radius. The "
    "law slides the ball once along a figure of eight of 30 mm (91 mm of way; the quick cases 20 mm, 61 mm of way), "
    "drawn on the map about the place first touched, at 3 N. Time is the shortest for which 95 % of the errors on "
    f"the body are within {NOMINAL['tolerance']:g} mm, the force is within {BAND_N:g} N for 95 % of the time, and "
    "contact is never lost; it is found by bisection over the speed. Errors are from where the ball truly touches "
    "the true skin to where the path lies on it, and forces are true ones, whatever is read. The skin is read 50 "
    "times a second, at once and without noise, the map is our own, taxels are where they are believed, forces are "
    "pressure times area: one of these at a time is otherwise. Gains follow rate and delay by the calm gain L* of a "
    "sampled loop. Seeds differ in taxels, noise and calibration, and are the same for all laws and levels; points "
    "are medians over them, upright lines their 95 % bootstrap interval. What is missing in a diagram is not "
    "possible at any speed from 4 to 128 mm/s; its row tells the least error.",
    cases,
    measure,
    figures,
)
