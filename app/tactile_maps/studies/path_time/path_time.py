"""The shortest time in which a contact path is followed well enough, by factor and level of what a controller works
with: cases, the measurement of one, and its row.

What is wrong with a robot's knowledge of its skin is made real, one factor at a time around the nominal conditions.
Gains for a skin that is read slowly and late are by the theory of sampled loops, and so is the bound of time that the
figures show beside what was measured.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from tactile_maps.control.limit_texts import limit_texts
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.maps.model.jacobian import JacobianKind
from tactile_maps.studies.base.rows import Case, Cell, Row, scaled
from tactile_maps.studies.path_time.body_path import path_length, with_path_on_body
from tactile_maps.studies.path_time.conditions import Conditions, setup_of
from tactile_maps.studies.path_time.factors import Factor, Level
from tactile_maps.studies.path_time.gains import least_time
from tactile_maps.studies.path_time.speed_search import SpeedSearchResult, Tolerances, find_fastest_speed

ROBOTS = ("arm", "ur5e", "icub")
SEEDS = 10
FEW_SEEDS = 3
"""Of our own arm, and of the other robots."""
BAND_N = 0.6
QUICK_SIZE = 0.008
"""Of the path where time is short [m]."""
NOMINAL = "nominal"
"""The factor of cases in nominal conditions; their level is empty."""
METHOD = (
    "Each robot has skin with taxels 8 mm apart on its forearm, at home beside a fixed ball of 30 mm radius. The "
    "controller slides the ball once along a figure of eight of 30 mm (91 mm of way; quick cases 8 mm, 24 mm), drawn "
    "on the map about the place first touched, at 3 N; on another map that is believed, through the same places of the "
    "body. Time is the shortest for which 95 % of the errors on the body "
    f"are within {1e3 * Conditions().tolerance:g} mm, the force is within {BAND_N:g} N for 95 % of the time, and "
    "contact is never lost; it is found by bisection over the speed, to 9 % (quick cases: to a factor of two). Errors "
    "are from where the ball truly touches the true skin to where the path lies on it, and forces are true ones, "
    "whatever is read. In nominal conditions the skin is read 50 times a second, at once and without noise, the map is "
    "our own, taxels are where they are believed, forces are pressure times area, and the controller is the hybrid "
    "one: one of these at a time is otherwise. Gains follow rate, delay and stiffness by the non-oscillating gain L* "
    "of a sampled loop. Seeds differ in taxels, noise and calibration, the same for all levels; points are medians "
    "over them, upright lines their 95 % bootstrap interval (an arrow: without an upper end). What is missing in a "
    "diagram is not possible at any speed from 4 to 128 mm/s; its row has the least error."
)


def list_cases(factors: Sequence[Factor], quick: bool, seed: int) -> list[Case]:
    """Every level of one factor at a time; complete seeds first, so that a run that is stopped has whole ones.

    Args:
        factors: What is varied.
        quick: Our own arm, one seed and one level of each factor.
        seed: The first.
    """
    return [
        {"robot": robot, "factor": factor, "level": level, "jacobian": jacobian, "seed": seed + number}
        | ({"quick": True} if quick else {})
        for number in range(1 if quick else SEEDS)
        for robot in (ROBOTS[:1] if quick else ROBOTS)
        if robot == ROBOTS[0] or number < FEW_SEEDS
        for factor, level, jacobian in _levels(factors, few=quick or robot != ROBOTS[0], quick=quick)
    ]


def _levels(factors: Sequence[Factor], *, few: bool, quick: bool) -> Iterator[tuple[str, Level, JacobianKind]]:
    """Factor, level, and whose word is taken for the map's Jacobian; the nominal ones first."""
    most = 1 if quick else None
    for jacobian in dict.fromkeys(jacobian for factor in factors for jacobian in factor.jacobians[:most]):
        yield NOMINAL, "", jacobian
    for factor in factors:
        for level in factor.few[:most] if few else factor.levels:
            for jacobian in factor.jacobians[:most]:
                yield factor.name, level, jacobian


def conditions_of(factors: Sequence[Factor], case: Case) -> Conditions:
    """What a case is run under."""
    varied = {factor.name: factor for factor in factors}.get(case["factor"])
    conditions = Conditions() if varied is None else varied.conditions(case["level"])
    return replace(conditions, jacobian=case["jacobian"])


def settings_of(conditions: Conditions, size: float | None = None) -> ControlSettings:
    """The controller's settings for a path of the usual size, or another [m]."""
    settings = conditions.settings(ControlSettings(task="follow_path"))
    return settings if size is None else replace(settings, path_size=size)


def measure_case(factors: Sequence[Factor], case: Case) -> list[Row]:
    """One row: the shortest time that is well enough, and what it is bound by."""
    conditions = conditions_of(factors, case)
    setup = setup_of(case["robot"], conditions, case["seed"])
    quick = bool(case.get("quick"))
    about = settings_of(conditions, QUICK_SIZE if quick else None)
    settings = with_path_on_body(about, setup)
    wanted = Tolerances(conditions.tolerance, BAND_N)
    found = find_fastest_speed(setup, settings, wanted, length=path_length(settings), refinements=0 if quick else 3)
    bound = least_time(path_length(about), wanted.error, conditions.period, conditions.delay)
    return [{**result_row(found, settings), "bound_s": bound}]


def result_row(found: SpeedSearchResult, settings: ControlSettings) -> dict[str, Cell]:
    """What a search came to, for a table."""
    course = found.course
    return {
        "verdict": "cannot" if found.speed is None else "met",
        "seconds": None if found.speed is None or course.finished is None else course.finished,
        "speed_mm_s": None if found.speed is None else 1e3 * found.speed,
        "error_mm": scaled(course.error_p95, 1e3),
        "rms_mm": scaled(course.error_rms, 1e3),
        "force_n": course.force_p95(settings.force_goal),
        "force_bias_n": float(course.force.mean()) - settings.force_goal if len(course.force) else None,
        "in_band_percent": 100 * course.in_band(settings.force_goal, BAND_N),
        "lost_percent": 100 * course.lost,
        "fastest_joint": float(course.speed.max(initial=0.0)),
        "energy_min_j": course.energy_minimum,
        "limited_by": "" if found.limit is None else found.limit.value,
        "why_limited": limit_texts(course.why_limited),
        "position_gain": settings.position_gain,
        "force_gain": settings.force_gain,
        "runs": found.runs,
        "control_ms": course.control_ms,
    }
