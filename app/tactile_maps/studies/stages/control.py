"""Accuracy and time of controllers that follow a path, with the user's own robot, skin and map.

Time is the duration of a round of the path. The computing time of any controller is about a third of a millisecond and
does not affect the choice.
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
from tactile_maps.studies.study.work_precision import ErrorKind, Setting, Stage, Subject, Theory, Trial
from tactile_maps.studies.testbeds.fixed_ball import with_fixed_ball
from tactile_maps.studies.testbeds.path_following import PathSetup, run_path

SPEEDS_MM_S = (15.0, 30.0, 60.0)
SETTLING = 0.7
_LONGEST = 15.0
ERRORS = (
    ErrorKind(
        "body_mm",
        "Place on the body",
        "mm",
        "Distance of the true contact from the path: 95th percentile over time.",
        1e-2,
    ),
    ErrorKind("force_n", "Force", "N", "Error of the true force from its goal: 95th percentile over time.", 1e-3),
    ErrorKind("lost_percent", "Contact lost", "% of the time", "Share of the time without contact.", 1e-1),
)


def settings(subject: Subject) -> list[Setting]:
    """Return every controller with a task at every speed; none without a robot that can move."""
    if subject.prepared is None or not subject.prepared.robot.joints:
        return []
    return [
        Setting("control", controller, {"path_speed_mm_s": speed})
        for controller in _with_task()
        for speed in SPEEDS_MM_S
    ]


def trials(subject: Subject, setting: Setting) -> Iterator[Trial]:
    """Yield one round of a figure of eight of 30 mm at one speed, with its duration in milliseconds."""
    if subject.prepared is None:
        raise SimulationError("no robot to control", remedy="Open a robot")
    speed = float(setting.values["path_speed_mm_s"])
    control = with_stage_setting(settings_from(subject.prepared.scene.control), setting)
    run = run_path(_setup(subject), control, _LONGEST, settling=SETTLING)
    if run.finished is None:
        raise SimulationError(f"{speed:g} mm/s: {run.stopped or limit_texts(run.why_limited) or 'not finished'}")
    errors = {
        "body_mm": scaled(run.error_p95, 1e3),
        "force_n": run.force_p95(control.force_goal),
        "lost_percent": 100 * run.lost,
    }
    yield Trial(setting, f"{speed:g}\u202fmm/s", 1e3 * run.finished, errors, limit_texts(run.why_limited))


def with_stage_setting(settings: ControlSettings, setting: Setting) -> ControlSettings:
    """Return control settings with the controller and speed of this stage, following a path about the contact.

    Raises:
        SimulationError: The controller is unknown or has no task.
    """
    if not has_task(setting.method):
        remedy = f"Choose among: {', '.join(_with_task())}"
        raise SimulationError("unknown controller", value=setting.method, remedy=remedy)
    speed = 1e-3 * float(setting.values["path_speed_mm_s"])
    return replace(settings, controller=setting.method, task="follow_path", path_speed=speed)


def stage_setting_of(settings: ControlSettings) -> Setting:
    """Return the setting of this stage that control settings correspond to."""
    return Setting("control", settings.controller, {"path_speed_mm_s": round(1e3 * settings.path_speed, 6)})


def _with_task() -> tuple[str, ...]:
    """Controllers that follow a path; those of plug-ins are last."""
    return tuple(name for name in CONTROLLERS if has_task(name))


def _setup(subject: Subject) -> PathSetup:
    """Robot next to the ball, controlled with the edited map."""
    assert subject.prepared is not None
    pressed = _robot_with_ball(subject.prepared)
    map_ = subject.map
    return PathSetup(pressed, None if map_ is pressed.map else map_, pressed.scene.effects.sensor)


@lru_cache(maxsize=1)
def _robot_with_ball(prepared: PreparedScene) -> PreparedScene:
    return with_fixed_ball(prepared)


def fingerprint(subject: Subject) -> str:
    """Return a digest of the robot, its cover, its sensor, its controller and the map."""
    if subject.prepared is None:
        return ""
    scene = subject.prepared.scene
    digest = hashlib.blake2b(subject.prepared.robot.mjcf.encode(), digest_size=8)
    digest.update(repr((scene.layer, scene.effects.sensor, scene.control)).encode())
    for plane in subject.map.uv:
        digest.update(plane.tobytes())
    return digest.hexdigest()


def seconds(subject: Subject) -> float:
    """Return the approximate duration of all trials [s]."""
    return 3.0 + 1.2 * len(settings(subject))


def theory(subject: Subject, error: str) -> list[Theory]:
    """Return the place error l (T / L* + e LAG) / t: the lag of a sampled loop without feed-forward of the speed.

    l is the length of the path and t its duration. T is the period of the skin's readings, L* the largest gain of a
    sampled loop without overshoot. The lag of the posture loop counts as additional dead time, for which that gain is
    1 / (e LAG), see ``path_time.gains``.
    """
    if error != "body_mm" or subject.prepared is None:
        return []
    scene = subject.prepared.scene
    readings = skin_readings(scene.effects, scene.tick)
    length = path_length(settings_from(scene.control))
    wait = readings.period / critical_gain(round(readings.delay / readings.period)) + math.e * LAG

    def lag_mm(milliseconds: FloatArray) -> FloatArray:
        return 1e6 * length * wait / milliseconds

    source = "l (T / L* + e 50\u202fms) / t: lag of a sampled loop without feed-forward of the speed of the path"
    return [Theory("Theory: lag", source, lag_mm)]


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
    "One round of one path: there is no interval, and errors on other paths differ.",
    theory=theory,
)
