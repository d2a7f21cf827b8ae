"""Which controller follows how well, on which robot, and what does its skin buy over a force-torque sensor?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.controllers import CONTROL_SCHEMES
from tactile_maps.control.limit_texts import limit_texts
from tactile_maps.control.motion.command import ControllerName, ControlSettings
from tactile_maps.core.errors import UsageError
from tactile_maps.maps.paths import path_about
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.studies.base.figures import BarChart, Figure, panels
from tactile_maps.studies.base.rows import Case, Cell, Row, distinct, number, number_or, p95, rms, scaled
from tactile_maps.studies.path_time.replay import replay_path
from tactile_maps.studies.study.study import CaseReplay, Study
from tactile_maps.studies.testbeds.beside_ball import SKIN_LINKS, beside_ball, forearm_skin_scene, with_finger
from tactile_maps.studies.testbeds.force_loop import ForceLoop, force_loop_at_goal, predicted_gain_limit
from tactile_maps.studies.testbeds.path_following import PathRun, PathSetup, run_path
from tactile_maps.tactile.sensors.sensor_effects import Noise, SensorEffects

PATHS: Mapping[str, Mapping[str, Any]] = {
    "figure of eight": {"task": "follow_path", "path_kind": "lemniscate", "path_size": 0.03},
    "line": {"task": "follow_path", "path_kind": "polyline", "path_size": 0.03},
    "raster": {"task": "follow_path", "path_kind": "raster", "path_size": 0.02},
    "held": {"task": "hold_point"},
    "eight beside a finger": {"task": "follow_path", "path_kind": "lemniscate", "path_size": 0.03},
}
"""What is asked of the contact; all about the place first touched, at ``GOAL`` and 10 mm/s."""
SECOND_CONTACT = "eight beside a finger"
"""The path on which somebody else touches the same link as well."""
SENSORS: Mapping[str, ReadingSettings] = {
    "skin": ReadingSettings(),
    "wrench": ReadingSettings(estimator="lumped"),
    "noisy wrench": ReadingSettings(estimator="lumped", wrench_noise=1 / 16),
}
"""What control goes by: taxels with noise; a force-torque sensor in the link, perfect or with a real one's noise."""
FORCE_ONLY: ControllerName = "hold_force"
"""A controller without a task: it only holds. Impedance has no force goal and reads no contact: it cannot be asked."""
GOAL = 3.0
"""[N]"""
NOISE = 100.0
"""Of a taxel [Pa]."""
FINGER_FORCE = 2.0
"""How hard somebody else touches [N]."""
GAIN_SHARE = 0.5
"""Of the force gain from which on the force would swing, that a controller is given; and never more than it has by
itself.
"""
_TAXELS = 1000
_HELD = 3.0
_LONGEST = 3.0
_CALM = 0.002
_SENSORS_NOTE = (
    "Of a single contact the wrench knows the place better than taxels do; of two it knows but their sum, which "
    "acts somewhere between them or nowhere on the skin. The supervisor sees that no single touch explains it and "
    "stops the arm."
)


def cases(quick: bool, seed: int) -> list[Case]:
    """Every controller on every robot along every path by every sensor; the one without a task only holds."""
    controllers: tuple[str, ...] = (*CONTROL_SCHEMES, FORCE_ONLY)
    kinds = [
        (path, controller, sensor)
        for path in PATHS
        for controller in controllers
        for sensor in SENSORS
        if controller != FORCE_ONLY or path == "held"
    ]
    seeds = range(seed, seed + 3)
    if quick:
        kinds = [("line", "hybrid", "skin"), ("line", "hybrid", "noisy wrench"), ("held", FORCE_ONLY, "skin")]
        seeds = seeds[:1]
    return [
        {"robot": robot, "path": path, "controller": controller, "sensor": sensor, "seed": each}
        for robot in SKIN_LINKS
        for each in seeds
        for path, controller, sensor in kinds
    ]


def measure(case: Case) -> list[Row]:
    """One row: errors of place and force, times and bounds of one round, and the gain the controller had."""
    setup, settings, stable = _run_of(case)
    course = run_path(setup, settings, _longest(settings))
    gains = {"force_gain": settings.force_gain, "stable_gain": stable}
    # What truly presses is the sum of all: beside a finger it says nothing of the ball.
    force = _force_errors(course) if case["path"] != SECOND_CONTACT else {}
    return [{**_place_errors(course), **force, **_limits(course, settings), **gains}]


def _run_of(case: Case) -> tuple[PathSetup, ControlSettings, float]:
    """What a case runs: robot and controller, and the force gain up to which its loop is stable."""
    settings = settings_for(case["controller"], case["path"])
    setup = setup_for(case["robot"], case["sensor"], case["seed"], touched=case["path"] == SECOND_CONTACT)
    stable = predicted_gain_limit(_force_loop(case["robot"], case["seed"]), settings)
    return setup, replace(settings, force_gain=min(GAIN_SHARE * stable, settings.force_gain)), stable


def _longest(settings: ControlSettings) -> float:
    nominal = duration(settings)
    return nominal if settings.task != "follow_path" else _LONGEST * nominal


def replay(row: Row) -> CaseReplay:
    """The run behind a row.

    Raises:
        UsageError: The row is of no case of this study.
    """
    try:
        setup, settings, _ = _run_of({**row, "seed": int(number_or(row["seed"], 0))})
    except (KeyError, ValueError) as error:
        raise UsageError("the row is of no case of this study", value=error) from error
    return replay_path(setup, settings, number_or(row.get("finished_s"), _longest(settings)))


def settings_for(controller: ControllerName, path: str) -> ControlSettings:
    """The same for all controllers, as they are by default."""
    return ControlSettings(controller=controller, gains="as_given", force_goal=GOAL, **PATHS[path])


def setup_for(robot: str, sensor: str, seed: int, *, touched: bool = False) -> PathSetup:
    """The robot beside its ball, with the skin's noise and what control goes by.

    Args:
        robot: Of ``SKIN_LINKS``.
        sensor: Of ``SENSORS``.
        seed: Of noise and places.
        touched: Whether somebody else touches the same link.

    Raises:
        RobotError: It is not installed.
    """
    prepared = _with_finger(robot, seed) if touched else _robot_beside_ball(robot, seed)
    return PathSetup(prepared, sensor=SensorEffects(noise=Noise(NOISE)), reading=SENSORS[sensor])


@lru_cache(maxsize=3)
def _robot_beside_ball(robot: str, seed: int) -> PreparedScene:
    return beside_ball(forearm_skin_scene(robot, _TAXELS, seed), seed=seed)


@lru_cache(maxsize=3)
def _with_finger(robot: str, seed: int) -> PreparedScene:
    return with_finger(_robot_beside_ball(robot, seed), FINGER_FORCE)


@lru_cache(maxsize=3)
def _force_loop(robot: str, seed: int) -> ForceLoop:
    return force_loop_at_goal(
        PathSetup(_robot_beside_ball(robot, seed)),
        ControlSettings(controller="hybrid", force_goal=GOAL, force_gain=_CALM),
    )


def duration(settings: ControlSettings) -> float:
    """Of one round at the speed asked for, or of holding [s]."""
    if settings.task != "follow_path":
        return _HELD
    return path_about(settings.path_kind, np.zeros(2), settings.path_size).length / settings.path_speed


def _place_errors(course: PathRun) -> dict[str, float | None]:
    return {
        "body_rms_mm": scaled(course.error_rms, 1e3),
        "body_p95_mm": scaled(course.error_p95, 1e3),
        "map_rms_mm": scaled(rms(course.map_error), 1e3),
        "map_p95_mm": scaled(p95(course.map_error), 1e3),
    }


def _force_errors(course: PathRun) -> dict[str, float | None]:
    off = course.force - GOAL
    return {
        "force_bias_N": float(off.mean()) if off.size else None,
        "force_rms_N": rms(off),
        "force_p95_N": course.force_p95(GOAL),
    }


def _limits(course: PathRun, settings: ControlSettings) -> dict[str, str | float | None]:
    return {
        "finished_s": course.finished,
        "asked_s": duration(settings),
        "lost_percent": 100 * float((course.force <= 0).mean()) if len(course.force) else 100.0,
        "fastest_joint": float(course.speed.max(initial=0.0)),
        "energy_minimum_J": course.energy_minimum if settings.controller != FORCE_ONLY else None,
        "control_ms": course.control_ms,
        "control_p95_ms": course.control_p95_ms,
        "limited": limit_texts(course.why_limited),
        "stopped": course.stopped,
    }


def figures(rows: Sequence[Row]) -> list[Figure | BarChart]:
    """Place against force by the skin, a point a seed; then the sensors, and the controllers' cost."""
    shown = [row for row in rows if row["controller"] != FORCE_ONLY and row["path"] != "held"]
    by_skin = panels(
        [row for row in shown if row["sensor"] == "skin" and row["path"] != SECOND_CONTACT],
        lambda row: f"{row['robot']}, {row['path']}",
        lambda row: str(row["controller"]),
        x="force_rms_N",
        y="body_p95_mm",
    )
    found = dict.fromkeys((row["robot"], row["path"], row["sensor"]) for row in shown)
    # Quick runs have no eight: what they have is compared instead.
    sensors = [kind for kind in found if kind[1] in ("figure of eight", SECOND_CONTACT)] or list(found)
    by = {
        f"{r}, {path}, {by}": _median([row["body_p95_mm"] for row in shown if _matches(row, r, path, by)])
        for r, path, by in sensors
    }
    skin = [row for row in rows if row["sensor"] == "skin"]
    cost = {
        str(controller): _median([row["control_ms"] for row in skin if row["controller"] == controller])
        for controller in distinct(skin, "controller")
    }
    return [
        Figure("Place and force", "error of the force, rms [N]", "on the body, p95 [mm]", by_skin, least=1e-2),
        BarChart(
            "Tactile skin against force-torque sensor",
            "error on the body, p95, median over controllers and seeds [mm]",
            by,
            note=_SENSORS_NOTE,
        ),
        BarChart("Controller cost with tactile skin", "reading and control of one tick, median [ms]", cost),
    ]


def _matches(row: Row, robot: object, path: object, sensor: object) -> bool:
    return (row["robot"], row["path"], row["sensor"]) == (robot, path, sensor)


def _median(cells: Sequence[Cell]) -> float | None:
    """Of what is known; None where nothing is."""
    known = [value for value in map(number, cells) if value is not None]
    return float(np.median(known)) if known else None


STUDY = Study(
    "controller-accuracy",
    "How accurate is each controller on each robot, with tactile skin and with a force-torque sensor?",
    "Each robot has 1,000 taxels on its forearm and is pressed by a ball of 30 mm that stands still, at the "
    "flattest place that its joints move well. It leads the contact along the same paths about that place with 3 N at"
    " 10 mm/s, or holds it, with each controller as it comes but for the force gain: half of the one from which on "
    "the force would swing there by the theory of the whole arm, or the controller's own if less. Errors on the body"
    " are from where the ball truly touches to where the path wants it, those on the map as the controller has them; "
    "force is what truly presses. The skin reads with a noise of 100 Pa a taxel; the wrench is that of the whole "
    "link, exact or with the noise of a real sensor, and learns from the skin when there is contact. A robot that is "
    "not installed says so under problem.",
    cases,
    measure,
    figures,
    replay=replay,
)
