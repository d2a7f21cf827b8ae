"""Shortest time in which a contact path is followed within tolerances, by factor and level: cases and measurement.

Each factor makes one property of the robot's knowledge or skin worse than nominal. Gains for a skin with slow and
delayed readings follow from the theory of sampled loops, as does the bound of time in the figures.
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
"""Number of seeds for our own arm, and for the other robots."""
BAND_N = 0.6
QUICK_SIZE = 0.008
"""Size of the path in quick runs [m]."""
NOMINAL = "nominal"
"""Factor of cases in nominal conditions; their level is empty."""
METHOD = (
    "Each robot has skin with taxels 8 mm apart on its forearm, at home next to a fixed ball of 30 mm radius. The "
    "controller slides the contact once along a figure of eight of 30 mm (path of 91 mm; quick cases 8 mm, 24 mm), "
    "drawn on the map about the place of the first contact, at 3 N; on another, believed map, through the same places "
    "of the body. Time is the shortest for which 95 % of the errors on the body "
    f"are within {1e3 * Conditions().tolerance:g} mm, the force is within {BAND_N:g} N for 95 % of the time, and "
    "contact is never lost; it is found by bisection over the speed, to 9 % (quick cases: to a factor of two). Errors "
    "are distances from the true contact on the true skin to the target on the path, and forces are true forces, "
    "independent of the readings. In nominal conditions the skin is read 50 times a second without delay or noise, the "
    "map is our own, taxels are at their believed places, forces are pressure times area, and the controller is the "
    "hybrid one; a case changes one of these. Gains follow rate, delay and stiffness by the non-oscillating gain L* "
    "of a sampled loop. Seeds differ in taxels, noise and calibration, the same for all levels; points are medians "
    "over them, upright lines their 95 % bootstrap interval (an arrow: without an upper end). Points missing from a "
    "diagram are not possible at any speed from 4 to 128 mm/s; their rows contain the smallest error."
)


def list_cases(factors: Sequence[Factor], quick: bool, seed: int) -> list[Case]:
    """Return every level of one factor at a time, sorted by seed, so that an aborted run contains complete seeds.

    Args:
        factors: Factors to vary.
        quick: Use our own arm, one seed and one level of each factor.
        seed: The first seed.
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
    """Factor, level and Jacobian of each condition; the nominal ones first."""
    most = 1 if quick else None
    for jacobian in dict.fromkeys(jacobian for factor in factors for jacobian in factor.jacobians[:most]):
        yield NOMINAL, "", jacobian
    for factor in factors:
        for level in factor.few[:most] if few else factor.levels:
            for jacobian in factor.jacobians[:most]:
                yield factor.name, level, jacobian


def conditions_of(factors: Sequence[Factor], case: Case) -> Conditions:
    """Return the conditions of a case."""
    varied = {factor.name: factor for factor in factors}.get(case["factor"])
    conditions = Conditions() if varied is None else varied.conditions(case["level"])
    return replace(conditions, jacobian=case["jacobian"])


def settings_of(conditions: Conditions, size: float | None = None) -> ControlSettings:
    """Return the settings of the controller for a path of the usual or another size [m]."""
    settings = conditions.settings(ControlSettings(task="follow_path"))
    return settings if size is None else replace(settings, path_size=size)


def measure_case(factors: Sequence[Factor], case: Case) -> list[Row]:
    """Return one row: the shortest time within the tolerances, and its limiting factor."""
    conditions = conditions_of(factors, case)
    setup = setup_of(case["robot"], conditions, case["seed"])
    quick = bool(case.get("quick"))
    drawn = settings_of(conditions, QUICK_SIZE if quick else None)
    settings = with_path_on_body(drawn, setup)
    limits = Tolerances(conditions.tolerance, BAND_N)
    found = find_fastest_speed(setup, settings, limits, length=path_length(settings), refinements=0 if quick else 3)
    bound = least_time(path_length(drawn), limits.error, conditions.period, conditions.delay)
    return [{**result_row(found, settings), "bound_s": bound}]


def result_row(found: SpeedSearchResult, settings: ControlSettings) -> dict[str, Cell]:
    """Return the result of a search as columns of a table."""
    run = found.run
    return {
        "verdict": "cannot" if found.speed is None else "met",
        "seconds": None if found.speed is None or run.finished is None else run.finished,
        "speed_mm_s": None if found.speed is None else 1e3 * found.speed,
        "error_mm": scaled(run.error_p95, 1e3),
        "rms_mm": scaled(run.error_rms, 1e3),
        "force_n": run.force_p95(settings.force_goal),
        "force_bias_n": float(run.force.mean()) - settings.force_goal if len(run.force) else None,
        "in_band_percent": 100 * run.in_band(settings.force_goal, BAND_N),
        "lost_percent": 100 * run.lost,
        "fastest_joint": float(run.speed.max(initial=0.0)),
        "energy_min_j": run.energy_minimum,
        "limited_by": "" if found.limit is None else found.limit.value,
        "why_limited": limit_texts(run.why_limited),
        "position_gain": settings.position_gain,
        "force_gain": settings.force_gain,
        "runs": found.runs,
        "control_ms": run.control_ms,
    }
