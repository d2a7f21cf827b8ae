"""How well does each controller follow, on which robot, and what does skin add to a force-torque sensor?"""

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
from tactile_maps.studies.testbeds.fixed_ball import SKIN_LINKS, forearm_skin_scene, with_finger, with_fixed_ball
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
"""Tasks of the contact, all about the place of the first contact, at ``GOAL`` and 10 mm/s."""
COMPARED = "figure of eight"
"""Path on which the controllers are compared, with ``SEEDS`` seeds; all other cases have ``FEW_SEEDS``."""
SEEDS = 10
FEW_SEEDS = 3
SECOND_CONTACT = "eight beside a finger"
"""Path during which a second finger touches the same link."""
SENSORS: Mapping[str, ReadingSettings] = {
    "skin": ReadingSettings(),
    "wrench": ReadingSettings(estimator="lumped"),
    "noisy wrench": ReadingSettings(estimator="lumped", wrench_noise=1 / 16),
}
"""Input of the controllers: taxels with noise, or a force-torque sensor in the link, ideal or with realistic noise."""
FORCE_ONLY: ControllerName = "hold_force"
"""Controller that only holds and has no task. Impedance has no force goal and uses no contacts, so it is left out."""
GOAL = 3.0
"""[N]"""
NOISE = 100.0
"""Noise of a taxel [Pa]."""
FINGER_FORCE = 2.0
"""Force of the second finger [N]."""
GAIN_SHARE = 0.5
"""Share of the force gain at the onset of oscillation that a controller gets; never more than its default."""
_TAXELS = 1000
_HELD = 3.0
_LONGEST = 3.0
_CALM = 0.002
_SENSORS_NOTE = (
    "The wrench locates a single contact better than taxels do. Of two contacts it measures only the sum, which "
    "acts between them or not on the skin at all. The supervisor detects that no single contact explains it and "
    "stops the arm."
)


def cases(quick: bool, seed: int) -> list[Case]:
    """Return every controller on every robot along every path with every sensor; the one without a task only holds.

    The cases of ``COMPARED`` with skin come first, sorted by seed, so that an aborted run contains complete seeds.
    """
    if quick:
        kinds = [("line", "hybrid", "skin"), ("line", "hybrid", "noisy wrench"), ("held", FORCE_ONLY, "skin")]
        return _cases(kinds, [seed])
    kinds = [
        (path, controller, sensor)
        for path in PATHS
        for controller in (*CONTROL_SCHEMES, FORCE_ONLY)
        for sensor in SENSORS
        if controller != FORCE_ONLY or path == "held"
    ]
    compared = [kind for kind in kinds if _is_compared(*kind)]
    others = [kind for kind in kinds if not _is_compared(*kind)]
    return _cases(compared, range(seed, seed + SEEDS)) + _cases(others, range(seed, seed + FEW_SEEDS))


def _is_compared(path: str, controller: str, sensor: str) -> bool:
    return sensor == "skin" and path == ("held" if controller == FORCE_ONLY else COMPARED)


def _cases(kinds: Sequence[tuple[str, str, str]], seeds: Sequence[int]) -> list[Case]:
    return [
        {"robot": robot, "path": path, "controller": controller, "sensor": sensor, "seed": seed}
        for seed in seeds
        for robot in SKIN_LINKS
        for path, controller, sensor in kinds
    ]


def measure(case: Case) -> list[Row]:
    """Return one row: errors of place and force, times and limits of one round, and the gain of the controller."""
    setup, settings, stable = _run_of(case)
    run = run_path(setup, settings, _longest(settings))
    gains = {"force_gain": settings.force_gain, "stable_gain": stable}
    # With the second finger, the sum of all forces says nothing about the ball.
    force = _force_errors(run) if case["path"] != SECOND_CONTACT else {}
    return [{**_place_errors(run), **force, **_limits(run, settings), **gains}]


def _run_of(case: Case) -> tuple[PathSetup, ControlSettings, float]:
    """Robot and controller of a case, and the largest stable force gain."""
    settings = settings_for(case["controller"], case["path"])
    setup = setup_for(case["robot"], case["sensor"], case["seed"], touched=case["path"] == SECOND_CONTACT)
    stable = predicted_gain_limit(_force_loop(case["robot"], case["seed"]), settings)
    return setup, replace(settings, force_gain=min(GAIN_SHARE * stable, settings.force_gain)), stable


def _longest(settings: ControlSettings) -> float:
    nominal = duration(settings)
    return nominal if settings.task != "follow_path" else _LONGEST * nominal


def replay(row: Row) -> CaseReplay:
    """Return the run behind a row.

    Raises:
        UsageError: The row does not belong to a case of this study.
    """
    try:
        setup, settings, _ = _run_of({**row, "seed": int(number_or(row["seed"], 0))})
    except (KeyError, ValueError) as error:
        raise UsageError("the row does not belong to a case of this study", value=error) from error
    return replay_path(setup, settings, number_or(row.get("finished_s"), _longest(settings)))


def settings_for(controller: ControllerName, path: str) -> ControlSettings:
    """Return the default settings, the same for all controllers."""
    return ControlSettings(controller=controller, gains="as_given", force_goal=GOAL, **PATHS[path])


def setup_for(robot: str, sensor: str, seed: int, *, touched: bool = False) -> PathSetup:
    """Return the robot next to its ball, with the noise of the skin and the input of the controllers.

    Args:
        robot: Name in ``SKIN_LINKS``.
        sensor: Name in ``SENSORS``.
        seed: Seed of noise and places.
        touched: Whether a second finger touches the same link.

    Raises:
        RobotError: The robot is not installed.
    """
    prepared = _with_finger(robot, seed) if touched else _robot_with_ball(robot, seed)
    return PathSetup(prepared, sensor=SensorEffects(noise=Noise(NOISE)), reading=SENSORS[sensor])


@lru_cache(maxsize=3)
def _robot_with_ball(robot: str, seed: int) -> PreparedScene:
    return with_fixed_ball(forearm_skin_scene(robot, _TAXELS, seed), seed=seed)


@lru_cache(maxsize=3)
def _with_finger(robot: str, seed: int) -> PreparedScene:
    return with_finger(_robot_with_ball(robot, seed), FINGER_FORCE)


@lru_cache(maxsize=3)
def _force_loop(robot: str, seed: int) -> ForceLoop:
    return force_loop_at_goal(
        PathSetup(_robot_with_ball(robot, seed)),
        ControlSettings(controller="hybrid", force_goal=GOAL, force_gain=_CALM),
    )


def duration(settings: ControlSettings) -> float:
    """Return the duration of one round at the requested speed, or of holding [s]."""
    if settings.task != "follow_path":
        return _HELD
    return path_about(settings.path_kind, np.zeros(2), settings.path_size).length / settings.path_speed


def _place_errors(run: PathRun) -> dict[str, float | None]:
    return {
        "body_rms_mm": scaled(run.error_rms, 1e3),
        "body_p95_mm": scaled(run.error_p95, 1e3),
        "map_rms_mm": scaled(rms(run.map_error), 1e3),
        "map_p95_mm": scaled(p95(run.map_error), 1e3),
    }


def _force_errors(run: PathRun) -> dict[str, float | None]:
    off = run.force - GOAL
    return {
        "force_bias_N": float(off.mean()) if off.size else None,
        "force_rms_N": rms(off),
        "force_p95_N": run.force_p95(GOAL),
    }


def _limits(run: PathRun, settings: ControlSettings) -> dict[str, str | float | None]:
    return {
        "finished_s": run.finished,
        "asked_s": duration(settings),
        "lost_percent": 100 * float((run.force <= 0).mean()) if len(run.force) else 100.0,
        "fastest_joint": float(run.speed.max(initial=0.0)),
        "energy_minimum_J": run.energy_minimum if settings.controller != FORCE_ONLY else None,
        "control_ms": run.control_ms,
        "control_p95_ms": run.control_p95_ms,
        "limited": limit_texts(run.why_limited),
        "stopped": run.stopped,
    }


def figures(rows: Sequence[Row]) -> list[Figure | BarChart]:
    """Return place against force with skin, a point a seed; then the sensors, and the cost of the controllers."""
    shown = [row for row in rows if row["controller"] != FORCE_ONLY and row["path"] != "held"]
    by_skin = panels(
        [row for row in shown if row["sensor"] == "skin" and row["path"] != SECOND_CONTACT],
        lambda row: f"{row['robot']}, {row['path']}",
        lambda row: str(row["controller"]),
        x="force_rms_N",
        y="body_p95_mm",
    )
    found = dict.fromkeys((row["robot"], row["path"], row["sensor"]) for row in shown)
    # Quick runs have no figure of eight and compare the paths that they have.
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
    against = BarChart(
        "Tactile skin against force-torque sensor",
        "error on the body, p95, median over controllers and seeds [mm]",
        by,
        note=_SENSORS_NOTE,
    )
    return [
        Figure("Place and force", "error of the force, rms [N]", "on the body, p95 [mm]", by_skin, least=1e-2),
        *([against] if len(distinct(shown, "sensor")) > 1 else []),
        BarChart("Controller cost with tactile skin", "reading and control of one tick, median [ms]", cost),
    ]


def _matches(row: Row, robot: object, path: object, sensor: object) -> bool:
    return (row["robot"], row["path"], row["sensor"]) == (robot, path, sensor)


def _median(cells: Sequence[Cell]) -> float | None:
    """Median of the known cells; None without any."""
    known = [value for value in map(number, cells) if value is not None]
    return float(np.median(known)) if known else None


STUDY = Study(
    "controller-accuracy",
    "How accurate is each controller on each robot, with tactile skin and with a force-torque sensor?",
    "Each robot has 1,000 taxels on its forearm, which is pressed by a fixed ball of 30 mm at the flattest place that "
    "its joints move well. The controller leads the contact along the same paths about that place with 3 N at "
    "10 mm/s, or holds it. All controllers have their default settings except the force gain: half of the gain at the "
    "onset of oscillation by the theory of the whole arm, or the default if that is less. Errors on the body are "
    "distances from the true contact to the target on the path, errors on the map are those that the controller "
    "sees, and forces are true contact forces. The skin has a noise of 100 Pa a taxel; the wrench is that of the "
    "whole link, exact or with the noise of a real sensor, and the skin detects whether there is contact. Rows of a "
    "robot that is not installed state this under problem.",
    cases,
    measure,
    figures,
    replay=replay,
)
