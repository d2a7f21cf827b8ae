"""Which law follows how well, on which robot, and what does its skin buy over a force-torque sensor?"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from app.arrays import FloatArray
from app.contacts.reading_settings import ReadingSettings
from app.control.command import ControlSettings, LawName
from app.control.laws import RULES
from app.control.map_path import path_about
from app.experiments.arm_loop import ArmLoop, arm_loop, predicted_gain
from app.experiments.bars import Bars
from app.experiments.control_course import Course, run_course
from app.experiments.control_setup import SLEEVES, ControlSetup, beside_ball, over, sleeved
from app.experiments.experiment import Experiment
from app.experiments.plot import Figure, Panel
from app.experiments.sweep import Case, Row
from app.scene.bodies import make_bodies
from app.scene.objects import ObjectSpec
from app.session.prepare import Prepared
from app.touch.sensor.effects import SensorEffects
from app.touch.sensor.noise import Noise

PATHS: Mapping[str, Mapping[str, Any]] = {
    "figure of eight": {"task": "follow_path", "path_kind": "lemniscate", "path_size": 0.03},
    "line": {"task": "follow_path", "path_kind": "polyline", "path_size": 0.03},
    "raster": {"task": "follow_path", "path_kind": "raster", "path_size": 0.02},
    "held": {"task": "hold_point"},
    "eight beside a finger": {"task": "follow_path", "path_kind": "lemniscate", "path_size": 0.03},
}
"""What is asked of the contact; all about the place first touched, at ``GOAL`` and 10 mm/s."""
TOUCHED = "eight beside a finger"
"""The path on which somebody else touches the same link as well."""
SENSORS: Mapping[str, ReadingSettings] = {
    "skin": ReadingSettings(),
    "wrench": ReadingSettings(estimator="lumped"),
    "noisy wrench": ReadingSettings(estimator="lumped", wrench_noise=1 / 16),
}
"""What control goes by: taxels with noise; a force-torque sensor in the link, perfect or with a real one's noise."""
HOLDS: LawName = "hold_force"
"""A law without a task: it only holds. Impedance has no goal of force and reads no contact: it cannot be asked."""
GOAL = 3.0
"""[N]"""
NOISE = 100.0
"""Of a taxel [Pa]."""
FINGER = 2.0
"""How hard somebody else touches [N]."""
SHARE = 0.5
"""Of the force gain from which on the force would swing, that a law is given; and never more than it has by itself."""
_TAXELS, _HELD, _LONGEST, _CALM = 1000, 3.0, 3.0, 0.002
_FINGER_RADIUS, _BEYOND = 0.012, 0.03
_SENSORS_NOTE = (
    "Of a single contact the wrench knows the place better than taxels do; of two it knows but their sum, which "
    "acts somewhere between them or nowhere on the skin, and the arm leads the wrong point along the path."
)


def cases(quick: bool, seed: int) -> list[Case]:
    """Every law on every robot along every path by every sensor; the one without a task only holds."""
    robots, paths, sensors = tuple(SLEEVES), tuple(PATHS), tuple(SENSORS)
    laws: tuple[str, ...] = (*RULES, HOLDS)
    seeds: Sequence[int] = range(seed, seed + 3)
    if quick:
        paths, sensors, laws, seeds = (
            ("line", "held"),
            ("skin", "noisy wrench"),
            ("hybrid", "qp", "hold_force"),
            (seed,),
        )
    return [
        {"robot": robot, "path": path, "law": law, "sensor": sensor, "seed": each}
        for robot in robots
        for each in seeds
        for path in paths
        for law in laws
        for sensor in sensors
        if law != HOLDS or path == "held"
    ]


def measure(case: Case) -> list[Row]:
    """One row: errors of place and force, times and bounds of one round, and the gain the law had."""
    settings = settings_for(case["law"], case["path"])
    setup = setup_for(case["robot"], case["sensor"], case["seed"], touched=case["path"] == TOUCHED)
    stable = predicted_gain(_loop(case["robot"], case["seed"]), settings)
    settings = replace(settings, force_gain=min(SHARE * stable, settings.force_gain))
    nominal = duration(settings)
    course = run_course(setup, settings, nominal if settings.task != "follow_path" else _LONGEST * nominal)
    gains = {"force_gain": settings.force_gain, "stable_gain": stable}
    # What truly presses is the sum of all: beside a finger it says nothing of the ball.
    force = _forces(course) if case["path"] != TOUCHED else {}
    return [{**_places(course), **force, **_bounds(course, settings), **gains}]


def settings_for(law: LawName, path: str) -> ControlSettings:
    """The same for all laws, as they are by default."""
    return ControlSettings(law=law, gains="as_set", force_goal=GOAL, **PATHS[path])


def setup_for(robot: str, sensor: str, seed: int, *, touched: bool = False) -> ControlSetup:
    """The robot beside its ball, with the skin's noise and what control goes by.

    Args:
        robot: Of ``SLEEVES``.
        sensor: Of ``SENSORS``.
        seed: Of noise and places.
        touched: Whether somebody else touches the same link.

    Raises:
        RobotError: It is not installed.
    """
    prepared = _touched(robot, seed) if touched else _beside(robot, seed)
    return ControlSetup(prepared, sensor=SensorEffects(noise=Noise(NOISE)), reading=SENSORS[sensor])


@lru_cache(maxsize=3)
def _beside(robot: str, seed: int) -> Prepared:
    return beside_ball(sleeved(robot, _TAXELS, seed), seed=seed)


@lru_cache(maxsize=3)
def _touched(robot: str, seed: int) -> Prepared:
    """Also a finger that pushes with ``FINGER`` where the link is farthest from the ball."""
    prepared = _beside(robot, seed)
    scene, (ball, *_) = prepared.scene, prepared.scene.objects
    surface = over(prepared, np.arange(len(prepared.skin)), 0.0)
    farthest = np.array([int(np.argmax(np.linalg.norm(surface - ball.at, axis=1)))])
    outside, inside = (over(prepared, farthest, height)[0].tolist() for height in (_FINGER_RADIUS + 0.002, -_BEYOND))
    path = ((0.0, *outside), (0.2, *inside), (3600.0, *inside))
    finger = ObjectSpec(
        "finger",
        "probe",
        (_FINGER_RADIUS,),
        mass=0.1,
        friction=0.0,
        max_force=FINGER,
        path=path,
    )
    with_finger = replace(scene, objects=(ball, finger))
    return replace(prepared, scene=with_finger, objects=make_bodies(with_finger))


@lru_cache(maxsize=3)
def _loop(robot: str, seed: int) -> ArmLoop:
    return arm_loop(
        ControlSetup(_beside(robot, seed)), ControlSettings(law="hybrid", force_goal=GOAL, force_gain=_CALM)
    )


def duration(settings: ControlSettings) -> float:
    """Of one round at the speed asked for, or of holding [s]."""
    if settings.task != "follow_path":
        return _HELD
    return path_about(settings.path_kind, np.zeros(2), settings.path_size).length / settings.path_speed


def _places(course: Course) -> dict[str, float | None]:
    return {
        "body_rms_mm": _known(1e3 * course.error_rms),
        "body_p95_mm": _known(1e3 * course.error_p95),
        "map_rms_mm": _known(1e3 * _rms(course.map_error)),
        "map_p95_mm": _known(1e3 * _p95(course.map_error)),
    }


def _forces(course: Course) -> dict[str, float | None]:
    off = course.force - GOAL
    return {
        "force_bias_N": _known(float(off.mean())),
        "force_rms_N": _known(_rms(off)),
        "force_p95_N": _known(course.force_p95(GOAL)),
    }


def _bounds(course: Course, settings: ControlSettings) -> dict[str, str | float | None]:
    return {
        "finished_s": _known(course.finished),
        "asked_s": duration(settings),
        "lost_percent": 100 * float((course.force <= 0).mean()) if len(course.force) else 100.0,
        "fastest_joint": float(course.speed.max(initial=0.0)),
        "energy_minimum_J": course.energy_minimum if settings.law != HOLDS else None,
        "control_ms": course.control_ms,
        "control_p95_ms": course.control_p95_ms,
        "limited": "; ".join(course.why_limited),
        "stopped": course.stopped,
    }


def _rms(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else math.nan


def _p95(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(np.percentile(known, 95)) if len(known) else math.nan


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def figures(rows: Sequence[Row]) -> list[Figure | Bars]:
    """Place against force by the skin, a point a seed; then the sensors, and the laws' cost."""
    shown = [row for row in rows if row["law"] != HOLDS and row["path"] != "held"]
    panels = [
        Panel(f"{robot}, {path}", _curves([row for row in shown if _of(row, robot, path, "skin")]))
        for robot, path in dict.fromkeys((row["robot"], row["path"]) for row in shown)
        if path != TOUCHED
    ]
    sensors = [
        (robot, path, sensor)
        for robot, path, sensor in dict.fromkeys((row["robot"], row["path"], row["sensor"]) for row in shown)
        if path in ("figure of eight", TOUCHED)
    ]
    by = {f"{r}, {path}, {by}": _median(shown, "body_p95_mm", r, path, by) for r, path, by in sensors}
    skin = [row for row in rows if row["sensor"] == "skin"]
    cost = {
        str(law): float(np.median([_number(row["control_ms"]) for row in skin if row["law"] == law]))
        for law in dict.fromkeys(row["law"] for row in skin)
    }
    return [
        Figure("Place and force", "error of the force, rms [N]", "on the body, p95 [mm]", panels, least=1e-2),
        Bars("What the skin buys", "error on the body, p95, median over laws and seeds [mm]", by, note=_SENSORS_NOTE),
        Bars("What a law costs by the skin", "reading and control of one tick, median [ms]", cost),
    ]


def _curves(rows: Sequence[Row]) -> dict[str, list[tuple[float, float]]]:
    return {
        str(law): [(_number(row["force_rms_N"]), _number(row["body_p95_mm"])) for row in rows if row["law"] == law]
        for law in dict.fromkeys(row["law"] for row in rows)
    }


def _of(row: Row, robot: object, path: object, sensor: object) -> bool:
    return (row["robot"], row["path"], row["sensor"]) == (robot, path, sensor)


def _median(rows: Sequence[Row], key: str, robot: object, path: object, sensor: object) -> float:
    """Of what is known; nan where nothing is."""
    values = [_number(row[key]) for row in rows if _of(row, robot, path, sensor)]
    known = [value for value in values if math.isfinite(value)]
    return float(np.median(known)) if known else math.nan


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else math.nan


EXPERIMENT = Experiment(
    "control-laws",
    "Which law follows how well on which robot, and what does its skin buy over a force-torque sensor?",
    "Each robot wears 1,000 taxels on its forearm and is pressed by a ball of 30 mm that stands still, at the "
    "flattest place that its joints move well. It leads the contact along the same paths about that place with 3 N at"
    " 10 mm/s, or holds it, with each law as it comes but for the force gain: that is half of the one from which on "
    "the force would swing there by the theory of the whole arm, or the law's own if that is less. Errors on the body"
    " are from where the ball truly touches to where the path wants it, those on the map as the law sees them; the "
    "force is what truly presses. The skin reads with a noise of 100 Pa a taxel; the wrench is that of the whole "
    "link, exact or with the noise of a real sensor, and is told by the skin when there is contact. A robot that is "
    "not installed says so under problem.",
    cases,
    measure,
    figures,
)
