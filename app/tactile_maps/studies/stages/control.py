"""Which controller follows a path how well in how short a time, on the user's own robot, skin and map.

Time is the robot's: how long a round of the path takes. A controller's own computing is a third of a millisecond with
any of them, and no reason to choose by.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache

from tactile_maps.control.controller_registry import CONTROLLERS, has_task, settings_from
from tactile_maps.control.force_loop.sampled_loop import critical_gain
from tactile_maps.control.limit_texts import limit_texts
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import SimulationError
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.session import skin_readings
from tactile_maps.studies.base.rows import scaled
from tactile_maps.studies.path_time.body_path import path_length
from tactile_maps.studies.path_time.gains import LAG
from tactile_maps.studies.study.work_precision import ErrorKind, Law, Setting, Stage, Subject, Trial
from tactile_maps.studies.testbeds.beside_ball import beside_ball
from tactile_maps.studies.testbeds.path_following import PathSetup, run_path

SPEEDS_MM_S = (15.0, 30.0, 60.0)
SETTLING = 0.7
_LONGEST = 15.0
ERRORS = (
    ErrorKind("body_mm", "Place on the body", "mm", "Distance of the true contact from the path: 95th percentile over "
              "time.", 1e-2),
    ErrorKind("force_n", "Force", "N", "Error of the true force from its goal: 95th percentile over time.",
              1e-3),
    ErrorKind("lost_percent", "Contact lost", "% of the time", "Share of the time without contact.", 1e-1),
)  # fmt: skip


def settings(subject: Subject) -> list[Setting]:
    """Every controller with a task at every speed; none where there is no robot that can move."""
    if subject.prepared is None or not subject.prepared.robot.joints:
        return []
    return [
        Setting("control", controller, {"path_speed_mm_s": speed})
        for controller in _with_task()
        for speed in SPEEDS_MM_S
    ]


def trials(subject: Subject, setting: Setting) -> Iterator[Trial]:
    """One round of a figure of eight of 30 mm at one speed, and the milliseconds that it takes."""
    if subject.prepared is None:
        raise SimulationError("there is no robot to control", remedy="Open a robot")
    speed = float(setting.values["path_speed_mm_s"])
    asked = with_stage_setting(settings_from(subject.prepared.scene.control), setting)
    course = run_path(_setup(subject), asked, _LONGEST, settling=SETTLING)
    if course.finished is None:
        raise SimulationError(f"{speed:g} mm/s: {course.stopped or limit_texts(course.why_limited) or 'not finished'}")
    errors = {
        "body_mm": scaled(course.error_p95, 1e3),
        "force_n": course.force_p95(asked.force_goal),
        "lost_percent": 100 * course.lost,
    }
    yield Trial(setting, f"{speed:g}\u202fmm/s", 1e3 * course.finished, errors, limit_texts(course.why_limited))


def with_stage_setting(settings: ControlSettings, setting: Setting) -> ControlSettings:
    """Settings of a controller with a controller and a speed of this stage, following a path about what touches.

    Raises:
        SimulationError: There is no such controller.
    """
    speed = 1e-3 * float(setting.values["path_speed_mm_s"])
    return replace(settings, controller=_checked_controller(setting.method), task="follow_path", path_speed=speed)


def stage_setting_of(settings: ControlSettings) -> Setting:
    """What settings of a controller are in this stage."""
    return Setting("control", settings.controller, {"path_speed_mm_s": round(1e3 * settings.path_speed, 6)})


def _with_task() -> tuple[str, ...]:
    """Controllers that follow a path, those of plug-ins last."""
    return tuple(name for name in CONTROLLERS if has_task(name))


def _checked_controller(name: str) -> str:
    if not has_task(name):
        raise SimulationError(
            "there is no such controller", value=name, remedy=f"Choose among: {', '.join(_with_task())}"
        )
    return name


def _setup(subject: Subject) -> PathSetup:
    """The robot beside the ball, known by the map as it is edited."""
    assert subject.prepared is not None
    beside = _robot_beside_ball(subject.prepared)
    map_ = subject.map
    return PathSetup(beside, None if map_ is beside.map else map_, beside.scene.effects.sensor)


@lru_cache(maxsize=1)
def _robot_beside_ball(prepared: PreparedScene) -> PreparedScene:
    return beside_ball(prepared)


def fingerprint(subject: Subject) -> str:
    """The robot, its cover, what the sensor does, and how the map lies."""
    if subject.prepared is None:
        return ""
    scene = subject.prepared.scene
    digest = hashlib.blake2b(subject.prepared.robot.mjcf.encode(), digest_size=8)
    digest.update(repr((scene.layer, scene.effects.sensor, scene.control)).encode())
    for plane in subject.map.uv:
        digest.update(plane.tobytes())
    return digest.hexdigest()


def seconds(subject: Subject) -> float:
    """About how long all of it takes."""
    return 3.0 + 1.2 * len(settings(subject))


def laws(subject: Subject, error: str) -> list[Law]:
    """Of the place l (T / L* + e LAG) / t: the lag of a sampled loop behind a path of length l done in t, if the
    controller is not told its speed.

    T is the period of the skin's readings, L* the greatest gain of a sampled loop that does not overshoot; the posture
    loop's lag counts as additional dead time, for which that gain is 1 / (e LAG), see ``path_time.gains``.
    """
    if error != "body_mm" or subject.prepared is None:
        return []
    scene = subject.prepared.scene
    readings = skin_readings(scene.effects, scene.tick)
    length = path_length(settings_from(scene.control))
    wait = readings.period / critical_gain(round(readings.delay / readings.period)) + math.e * LAG

    def lag_mm(milliseconds: FloatArray) -> FloatArray:
        return 1e6 * length * wait / milliseconds

    source = "l (T / L* + e 50\u202fms) / t: how far a sampled loop lags whose controller is not told the path's speed"
    return [Law("Theory: lag", source, lag_mm)]


STAGE = Stage(
    "control",
    "Control",
    "How fast and how accurately does each controller follow a contact path?",
    _with_task(),
    ERRORS,
    settings,
    trials,
    fingerprint,
    seconds,
    "One round of one path: there is no interval, and another path errs otherwise.",
    laws=laws,
)
