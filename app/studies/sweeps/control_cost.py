"""What does accuracy cost in time, in contact motion control: which controller follows a path how fast, knowing how
much?

What is wrong with a robot's knowledge of its skin is made real by factor and level, one at a time around a nominal: the
rate, delay and noise of the readings, the map, the calibration, the estimator. Gains for a skin that is read slowly and
late are by the theory of sampled loops, and so is the bound of time that the figures show beside what was measured.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from app.contacts.force_estimation.estimate import ESTIMATORS, EstimatorName
from app.contacts.pipeline import ReadingSettings
from app.control.command import ControlSettings
from app.control.controllers import CONTROL_SCHEMES
from app.control.joint_impedance import INNER_FREQUENCY
from app.control.limit_texts import limit_texts
from app.flattening.methods import METHODS
from app.maps.build import build_map
from app.maps.jacobian import JacobianKind
from app.maps.learned.as_tactile_map import learned_tactile_map
from app.maps.learned.methods import LEARNING_METHODS
from app.maps.paths import path_about
from app.maps.tactile_map import TactileMap
from app.session.prepare import PreparedScene
from app.skin.calibration_error import ErrorUnit, with_calibration_error
from app.studies.figures import BarChart, Figure, Panel
from app.studies.rows import Case, Cell, Row, distinct, number_or, scaled
from app.studies.study import Study
from app.studies.sweeps.speed_search import SpeedSearchResult, Tolerances, find_fastest_speed
from app.studies.testbeds.force_loop import critical_gain
from app.studies.testbeds.path_following import PathSetup, beside_ball, forearm_skin_scene, place_to_press
from app.tactile.babbling import BabbleSpec, babble
from app.tactile.sensor_effects import Noise, Sampling, SensorEffects

TAXELS = {"arm": 1600, "ur5e": 2000, "icub": 500}
"""About 8 mm apart."""
RATE = 50.0
"""The nominal one [Hz]."""
TICK = 0.005
"""Of control [s], unless the skin is read more often."""
WRENCH_NOISE = 0.06
"""Of the lumped sensor [N]: what an ATI Mini45 resolves."""
TOUCHES = 4000
"""Of the babbling that maps are learned from."""


@dataclass(frozen=True)
class SkinKnowledge:
    """What a controller knows a skin by.

    Attributes:
        rate: Readings a second [Hz].
        delay: Readings by which they come late.
        noise: Standard deviation on every taxel [Pa].
        map: How the map is made: a method, or a way to learn.
        misplaced: Error of the calibration along each axis [m].
        by: What is misplaced as one.
        estimator: From readings to force.
    """

    rate: float = RATE
    delay: int = 0
    noise: float = 0.0
    map: str = "symmetric-dirichlet"
    misplaced: float = 0.0
    by: ErrorUnit = "taxel"
    estimator: EstimatorName = "area-sum"


NOMINAL: Mapping[str, float | str] = {
    "tolerance": 3.0,
    "rate": RATE,
    "delay": 0,
    "noise": 0.0,
    "map": "symmetric-dirichlet",
    "misplaced": 0.0,
    "estimator": "area-sum",
}
"""The level of each factor while another is not: millimetres, hertz, readings, pascals, a name, millimetres, a name."""
FACTORS: Mapping[str, Sequence[float | str]] = {
    "tolerance": (1.0, 1.5, 2.0, 5.0),
    "rate": (10.0, 20.0, 100.0, 1000.0),
    "delay": (1, 2, 5),
    "noise": (100.0, 300.0, 1000.0),
    "map": ("lscm", "harmonic", "unroll", "information-distance", "self-organising"),
    "misplaced": (0.5, 1.0, 2.0, 3.0, 5.0, 7.0),
    "estimator": tuple(name for name in ESTIMATORS if name != "area-sum"),
}
"""The other levels."""


def knowledge_with(factor: str, level: float | str, by: ErrorUnit = "taxel") -> SkinKnowledge:
    """The nominal knowledge with one factor at a level."""
    if factor == "misplaced":
        return SkinKnowledge(misplaced=1e-3 * float(level), by=by)
    if factor == "map":
        return SkinKnowledge(map=str(level))
    if factor == "estimator":
        return SkinKnowledge(estimator=next(name for name in ESTIMATORS if name == level))
    if factor == "delay":
        return SkinKnowledge(delay=int(level))
    if factor == "noise":
        return SkinKnowledge(noise=float(level))
    return SkinKnowledge(rate=float(level)) if factor == "rate" else SkinKnowledge()


def setup_of(robot: str, knowledge: SkinKnowledge, seed: int) -> PathSetup:
    """A robot beside its ball, known so; everything random from the seed.

    Raises:
        TactileMapsError: The robot is not installed, or the map cannot be made.

    Cost: 3 s for a robot and seed, kept; a map of its own 1 s, a learned one 5 s, kept too.
    """
    tick = min(TICK, 1.0 / knowledge.rate)
    return setup_knowing(_robot_beside_ball(robot, tick, seed), knowledge, seed)


def setup_knowing(prepared: PreparedScene, knowledge: SkinKnowledge, seed: int) -> PathSetup:
    """A prepared robot beside something that touches it, known so."""
    sensor = SensorEffects(
        noise=Noise(knowledge.noise) if knowledge.noise else None,
        sampling=Sampling(knowledge.rate, knowledge.delay / knowledge.rate),
    )
    noise = WRENCH_NOISE if knowledge.estimator == "lumped" else 0.0
    reading = ReadingSettings(estimator=knowledge.estimator, wrench_noise=noise)
    believed = believed_map(prepared, knowledge.map, knowledge.misplaced, knowledge.by, seed)
    return PathSetup(prepared, believed, sensor, reading)


@lru_cache(maxsize=4)
def _robot_beside_ball(robot: str, tick: float, seed: int) -> PreparedScene:
    prepared = forearm_skin_scene(robot, TAXELS[robot], seed)
    return beside_ball(prepared, taxel=place_to_press(prepared), tick=tick, seed=seed)


def believed_map(prepared: PreparedScene, map_: str, sd: float, by: ErrorUnit, seed: int) -> TactileMap | None:
    """The map that is believed; None for the true one."""
    if map_ == SkinKnowledge.map and not sd:
        return None
    return _believed(prepared, map_, sd, by, seed)


@lru_cache(maxsize=8)
def _believed(prepared: PreparedScene, map_: str, sd: float, by: ErrorUnit, seed: int) -> TactileMap:
    skin = with_calibration_error(prepared.skin, sd, seed=seed, by=by)
    if map_ in METHODS:
        return build_map(skin, method=map_)
    readings = babble(skin, BabbleSpec(touches=TOUCHES, seed=seed))
    return learned_tactile_map(skin, LEARNING_METHODS[map_](readings, seed=seed))


STIFFNESS = 2000.0
"""Of contact and posture loop in series, about, where the usual cover is pressed with a few newtons [N/m]."""
LAG = 2.0 / INNER_FREQUENCY
"""Of the posture loop, which is critically damped [s]."""
_FORCE_SHARE = 0.5
"""Share of the greatest gain without overshoot that the force gets: contact is stiffer the harder it is pressed."""


def tune_gains(settings: ControlSettings, period: float, delay: int) -> ControlSettings:
    """The same settings with gains as high as loops without overshoot allow, and no higher than the given force gain.

    The map's loop gets 1 / (T / L* + e LAG): the greatest gain L* / T without overshoot of a sampled loop, with the
    posture loop's lag as an additional dead time, for which it is 1 / (e LAG). The force's loop gets its share of
    L* / (k T), with the given gain as if it were a lag.

    Args:
        settings: Of a controller.
        period: From one reading of the skin to the next [s].
        delay: Periods by which readings come late.
    """
    wait = period / critical_gain(delay)
    position = 1.0 / (wait + math.e * LAG)
    slower = 1.0 + settings.force_gain * STIFFNESS * wait / _FORCE_SHARE
    return replace(
        settings,
        gains="as_given",
        position_gain=position,
        force_gain=settings.force_gain / slower,
        integral_time=settings.integral_time * slower,
    )


def least_time(length: float, tolerance: float, period: float, delay: int) -> float:
    """Seconds for a path of ``length`` [m] within ``tolerance`` [m], if the controller is not told its speed: l T / (L*
    e).
    """
    return length * period / (critical_gain(delay) * tolerance)


BOUND = "theory, without feed-forward of the speed"
_DRAWS, _SURE = 2000, (2.5, 97.5)
_FACTOR_FIGURES = {
    "tolerance": (
        "Time against the tolerance on the body",
        "mm, 95 % of the errors within",
        "Theory's l T / (L* e) counts the skin's readings alone. Here the posture loop lags by 50 ms besides, which "
        "the path's speed, fed forward, does not make good: so it takes several times longer, and less so for more "
        "tolerance, until it is the force that limits.",
    ),
    "rate": (
        "Time against the rate at which the skin is read",
        "readings a second",
        "Where readings are slow it takes about as long as theory says; where they are fast, the posture loop's lag of "
        "50 ms, which the ideal servo of the theory lacks, sets the time, and a higher rate gains nothing.",
    ),
    "delay": (
        "Time against the delay of the readings",
        "readings late, and a half",
        "Readings that come at once are waited for less long than the posture loop's lag of 50 ms, which theory's "
        "ideal servo has not. With more delay theory's wait is the longer one; what is then faster than theory is so "
        "since controllers feed the path's speed forward.",
    ),
    "noise": (
        "Time against noise on every taxel",
        "Pa (none at 10)",
        "The theory predicts ripple from noise, not time: noise moves the centre of pressure and the force that is "
        "read, and "
        "takes from the tolerance what is then missing for speed.",
    ),
    "misplaced": (
        "Time against the error of the calibration",
        "mm along each axis (none at 0.25)",
        "The theory covers the map's Jacobian alone, which inverts for single triangles from 2 mm on and with two "
        "rings of "
        "taxels does not. The normal is wrong sooner: along a wrong one a push slides and a slide presses, so that the "
        "force limits the speed before the Jacobian does; two rings keep some degrees of the error where a triangle "
        "keeps tens.",
    ),
}
_DRAWN_FOR_ZERO = {"noise": 10.0, "misplaced": 0.25}
_FACTOR_BARS = {"map": "how the map is made", "estimator": "how readings become a force"}


def figures(rows: Sequence[Row]) -> list[Figure | BarChart]:
    """Seconds against each factor, a panel a robot; bars where levels are names."""
    made: list[Figure | BarChart] = []
    for factor, (title, x, note) in _FACTOR_FIGURES.items():
        of = _rows_with_nominal(rows, factor)
        if of:
            made.append(Figure(title, x, "seconds for the path", _panels(of, factor), note=note))
    for factor, words in _FACTOR_BARS.items():
        of = _rows_with_nominal(rows, factor)
        made += [
            BarChart(
                f"Time by {words}, {robot}",
                "seconds for the path, median over seeds",
                {f"{controller}, {level}": middle for (controller, level), middle in _by_name(of, robot).items()},
                note=_impossible_note(of, robot),
            )
            for robot in distinct(of, "robot")
        ]
    return made


def _rows_with_nominal(rows: Sequence[Row], factor: str) -> list[Row]:
    """The rows of a factor, levels rising, with those of the nominal as one of its levels."""
    of = [row for row in rows if row["factor"] == factor and row["level"] != NOMINAL[factor]]
    # What is misplaced by nothing is so by taxel and by module; the raw Jacobian's nominal stands with the misplaced.
    nominal = [row for row in rows if row["level"] in ("", 0.0) and row["factor"] in ("nominal", "misplaced")]
    for by, jacobian in dict.fromkeys((row["by"], row["jacobian"]) for row in of):
        same = {"factor": factor, "level": NOMINAL[factor], "by": by}
        of += [{**row, **same} for row in nominal if row["jacobian"] == jacobian]
    return of if isinstance(NOMINAL[factor], str) else sorted(of, key=lambda row: number_or(row["level"], 0.0))


def _panels(rows: Sequence[Row], factor: str) -> list[Panel]:
    panels = []
    for kind in dict.fromkeys((row["robot"], row["by"], row["jacobian"]) for row in rows):
        robot, by, jacobian = kind
        of = [row for row in rows if (row["robot"], row["by"], row["jacobian"]) == kind]
        said = f"{robot}, by {by}, {jacobian} Jacobian" if factor == "misplaced" else str(robot)
        panels.append(_panel(said, of, factor))
    return panels


def _panel(title: str, rows: Sequence[Row], factor: str) -> Panel:
    curves, intervals = {}, {}
    for controller in distinct(rows, "controller"):
        of = [row for row in rows if row["controller"] == controller]
        found = [
            (_level_position(factor, level), *bootstrap_median(_seconds(of, level))) for level in distinct(of, "level")
        ]
        curves[str(controller)] = [(x, middle) for x, middle, _, _ in found]
        intervals[str(controller)] = [(x, low, high) for x, _, low, high in found]
    if factor in ("tolerance", "rate", "delay"):
        curves[BOUND] = [
            (_level_position(factor, level), _time_bound(rows, level)) for level in distinct(rows, "level")
        ]
    return Panel(title, curves, intervals)


def bootstrap_median(seconds: Sequence[float]) -> tuple[float, float, float]:
    """Median over seeds, and its 95 % bootstrap interval; infinite where most of them cannot.

    Args:
        seconds: One a seed; inf where it cannot.
    """
    values = np.asarray(seconds, dtype=np.float64)
    drawn = np.sort(np.random.default_rng(0).choice(values, (_DRAWS, len(values))), axis=1)
    # Percentiles between inf and a number are no number: the nearest value counts.
    low, high = np.percentile(drawn[:, len(values) // 2], _SURE, method="nearest")
    return float(np.sort(values)[len(values) // 2]), float(low), float(high)


def _seconds(rows: Sequence[Row], level: object) -> list[float]:
    return [number_or(row["seconds"], math.inf) for row in rows if row["level"] == level]


def _time_bound(rows: Sequence[Row], level: object) -> float:
    return next(number_or(row["bound_s"], math.inf) for row in rows if row["level"] == level)


def _level_position(factor: str, level: object) -> float:
    """Where a level is drawn: a logarithm knows no zero."""
    value = number_or(level, 0.0)
    return value + 0.5 if factor == "delay" else max(value, _DRAWN_FOR_ZERO.get(factor, value))


def _by_name(rows: Sequence[Row], robot: object) -> dict[tuple[str, str], float]:
    """The median over seeds by controller and level."""
    of = [row for row in rows if row["robot"] == robot]
    kinds = dict.fromkeys((str(row["controller"]), str(row["level"])) for row in of)
    return {
        (controller, level): bootstrap_median(
            [
                number_or(row["seconds"], math.inf)
                for row in of
                if (row["controller"], row["level"]) == (controller, level)
            ]
        )[0]
        for controller, level in kinds
    }


def _impossible_note(rows: Sequence[Row], robot: object) -> str:
    """What most seeds cannot do at any speed."""
    names = [
        f"{controller}, {level}" for (controller, level), middle in _by_name(rows, robot).items() if math.isinf(middle)
    ]
    return f"Not possible at any speed: {'; '.join(names)}." if names else ""


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
_QUICK_CONTROLLERS = ("hybrid", "qp")


def cases(quick: bool, seed: int) -> list[Case]:
    """Every controller on every robot at every level of one factor at a time, for some seeds."""
    return [
        {
            "robot": robot,
            "controller": controller,
            "factor": factor,
            "level": level,
            "jacobian": jacobian,
            "by": by,
            "seed": number,
        }
        | ({"quick": True} if quick else {})
        for number in range(seed, seed + (1 if quick else SEEDS))
        for robot in (ROBOTS[:1] if quick else ROBOTS)
        for factor, level, jacobian, by in _levels(robot, quick)
        for controller in (_QUICK_CONTROLLERS if quick else CONTROL_SCHEMES)
    ]


def _levels(robot: str, quick: bool) -> Iterator[tuple[str, float | str, JacobianKind, ErrorUnit]]:
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
    knowledge = knowledge_with(case["factor"], case["level"], case["by"])
    setup = setup_of(case["robot"], knowledge, case["seed"])
    period = 1.0 / knowledge.rate
    settings = replace(
        tune_gains(ControlSettings(controller=case["controller"], task="follow_path"), period, knowledge.delay),
        jacobian=case["jacobian"],
    )
    if case.get("quick"):
        settings = replace(settings, path_size=QUICK_SIZE)
    tolerance = float(case["level"] if case["factor"] == "tolerance" else NOMINAL["tolerance"])
    wanted = Tolerances(1e-3 * tolerance, BAND_N)
    length = path_about(settings.path_kind, np.zeros(2), settings.path_size).length
    found = find_fastest_speed(setup, settings, wanted, length=length, refinements=1 if case.get("quick") else 2)
    bound = least_time(length, wanted.error, period, knowledge.delay)
    return [{"tolerance_mm": tolerance, **result_row(found, settings), "bound_s": bound}]


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


STUDY = Study(
    "control-cost",
    "How fast can each controller follow a contact path within a tolerance on the body, and what does it cost to "
    "know the skin less well?",
    "Each robot has skin with taxels 8 mm apart on its forearm, at home beside a fixed ball of 30 mm radius. The "
    "controller slides the ball once along a figure of eight of 30 mm (91 mm of way; quick cases 20 mm, 61 mm), "
    "drawn on the map about the place first touched, at 3 N. Time is the shortest for which 95 % of the errors on "
    f"the body are within {NOMINAL['tolerance']:g} mm, the force is within {BAND_N:g} N for 95 % of the time, and "
    "contact is never lost; it is found by bisection over the speed. Errors are from where the ball truly touches "
    "the true skin to where the path lies on it, and forces are true ones, whatever is read. The skin is read 50 "
    "times a second, at once and without noise, the map is our own, taxels are where they are believed, forces are "
    "pressure times area: one of these at a time is otherwise. Gains follow rate and delay by the non-oscillating "
    "gain L* of a "
    "sampled loop. Seeds differ in taxels, noise and calibration, the same for all controllers and levels; points "
    "are medians over them, upright lines their 95 % bootstrap interval. What is missing in a diagram is not "
    "possible at any speed from 4 to 128 mm/s; its row has the least error.",
    cases,
    measure,
    figures,
)
