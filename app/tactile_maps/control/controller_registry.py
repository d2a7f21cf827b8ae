"""Registry of controllers, built in and from plug-ins, and the check of control settings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from math import isfinite

import numpy as np

from tactile_maps.control.controllers import (
    CONTROL_SCHEMES,
    Controller,
    HoldForceController,
    ImpedanceController,
    TaskController,
)
from tactile_maps.control.motion.command import (
    CHOICES,
    MOST_POINTS,
    MOST_STARTS,
    RANGES,
    ControlSettings,
    JointCommand,
    is_number,
    range_remedy,
)
from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.control.motion.observation import Observation
from tactile_maps.control.motion.task_priority import ControlScheme
from tactile_maps.control.task_control.tasks import SHEAR_TASKS, TaskManager
from tactile_maps.core.errors import SceneError
from tactile_maps.core.plugins import Plugin, PluginObject, Registry, guard_call
from tactile_maps.core.toml import check_keys
from tactile_maps.robots.model.robot import Robot

BuildController = Callable[[Robot, TaskManager, MapKinematics], Controller]


@dataclass(frozen=True)
class ControllerEntry:
    """Description of one controller.

    Attributes:
        name: Name in settings.
        title: Name shown to users.
        tip: Description in one sentence without its full stop.
        build: Builds the controller from a robot, the task manager shared by all controllers, and the map's kinematics;
            see ``build_by_scheme``.
        settings: Fields of ``ControlSettings`` that it uses in addition to those of its task; shown as sliders.
        has_task: Whether it performs the task named in the settings, whose task manager then sets the contacts' goals.
    """

    name: str
    title: str
    tip: str
    build: BuildController
    settings: tuple[str, ...] = ()
    has_task: bool = False


def build_by_scheme(scheme: Callable[[], ControlScheme]) -> BuildController:
    """Return the ``build`` function of a task controller with its own control scheme, otherwise like the built-in ones.

    Args:
        scheme: Creates a new control scheme.
    """
    return lambda robot, task_manager, map_kinematics: TaskController(robot, scheme(), task_manager, map_kinematics)


def _guarded(plugin: Plugin, entry: ControllerEntry) -> ControllerEntry:
    """Return a plug-in's entry whose controllers return finite commands for each joint or raise."""
    unknown = sorted(set(entry.settings) - {field.name for field in fields(ControlSettings)})
    if unknown:
        raise plugin.error(f"it uses unknown settings: {', '.join(unknown)}")

    def build(
        make: Callable[[Robot, TaskManager, MapKinematics], Controller],
        robot: Robot,
        task_manager: TaskManager,
        map_kinematics: MapKinematics,
    ) -> PluginObject:
        def command(
            method: Callable[[ControlSettings, Observation], object],
            settings: ControlSettings,
            observation: Observation,
        ) -> JointCommand:
            return _checked_command(plugin, method(settings, observation), robot.home.shape)

        return PluginObject(
            plugin,
            make(robot, task_manager, map_kinematics),
            *("rest", "why_limited", "report", "use", "reset", "start", "command"),
            checks={"command": command, "why_limited": tuple, "needs_skin": bool},
            defaults={
                "needs_skin": lambda _: False,
                "stop": lambda controller: controller.reset,
                "hold_integrals": lambda _: lambda contacts: None,
            },
        )

    return replace(entry, build=guard_call(plugin, entry.build, "robot", "task_manager", "map_kinematics", check=build))


def _checked_command(plugin: Plugin, command: object, joints: tuple[int, ...]) -> JointCommand:
    if not isinstance(command, JointCommand):
        raise plugin.error("it gave no JointCommand", type(command).__name__)
    for part in fields(command):
        values = getattr(command, part.name)
        if values.shape != joints or not np.isfinite(values).all():
            raise plugin.error(f"it gave no finite {part.name} for each joint", f"shape {values.shape}")
    if (command.stiffness < 0).any() or (command.damping < 0).any():
        raise plugin.error("it gave a stiffness or damping below zero")
    return command


def _by_scheme(name: str, title: str, tip: str, *settings: str) -> ControllerEntry:
    return ControllerEntry(name, title, tip, build_by_scheme(CONTROL_SCHEMES[name]), settings, has_task=True)


CONTROLLERS: Registry[ControllerEntry] = Registry(
    "controllers",
    ControllerEntry,
    (
        ControllerEntry(
            "impedance",
            "Impedance",
            "Joint impedance: a spring to the rest posture, which yields to a touch and returns",
            lambda robot, task_manager, map_kinematics: ImpedanceController(robot),
            ("stiffness", "damping_ratio"),
        ),
        ControllerEntry(
            "hold_force",
            "Hold force",
            "The arm retreats from or follows a touch so that its force stays at the goal",
            lambda robot, task_manager, map_kinematics: HoldForceController(robot),
            ("force_goal", "force_gain", "integral_time"),
        ),
        _by_scheme(
            "admittance",
            "Admittance",
            "The force error drives a virtual mass with damping, and the arm follows it; no integral, "
            "so an error may stay",
            "force_gain",
            "inertia_time",
        ),
        _by_scheme(
            "hybrid",
            "Hybrid",
            "Force along the contact's normal, position across it: neither disturbs the other where "
            "the normal is right",
            "force_gain",
            "integral_time",
        ),
        _by_scheme(
            "parallel",
            "Parallel",
            "Position and force act in all directions, and the force integral prevails: the force is "
            "reached, the position yields",
            "force_gain",
            "integral_time",
            "position_gain",
            "inertia_time",
        ),
        _by_scheme(
            "projection",
            "Projection",
            "Errors are taken on the map as if it were isometric: cheapest, and wrong by as much as "
            "the map is stretched",
            "force_gain",
            "integral_time",
        ),
        _by_scheme(
            "priority",
            "Priority",
            "Strict order: force, then position on the map, then rest posture; lower priorities never "
            "disturb higher ones",
            "force_gain",
            "integral_time",
        ),
        _by_scheme(
            "qp",
            "Quadratic program",
            "Force and place within bounds on speed, acceleration, joints and forces: it slows down "
            "before a bound is met",
            "force_gain",
            "integral_time",
        ),
    ),
    _guarded,
)
"""Built-in controllers by name, then those of plug-ins."""


def has_task(controller: str) -> bool:
    """Whether the controller with this name performs tasks."""
    return controller in CONTROLLERS and CONTROLLERS[controller].has_task


TASKS_AT_A_PLACE = ("hold_point", "follow_path", "guide")
"""Tasks that keep the contact at a position on the map."""


def effective_settings(settings: ControlSettings) -> frozenset[str]:
    """Return the names of the settings that affect the selected controller and task, other than ``controller``."""
    entry = CONTROLLERS[settings.controller]
    names = {*entry.settings, "max_force"}
    if settings.controller != "impedance":
        names |= {"gains", "max_impact"}
    if settings.controller != "impedance" and settings.task != "retreat":
        names.add("friction_use")
    if not entry.has_task:
        return frozenset(names)
    names |= {"task", "jacobian", "max_shear"}  # the Jacobian setting also selects the normal
    if settings.task in SHEAR_TASKS:
        names |= {"shear_goal"} | ({"shear_direction"} if settings.shear_goal else set())
    if settings.task == "guide":
        names.add("shear_threshold")
    if settings.task != "retreat":
        names.add("force_goal")
    if settings.task in TASKS_AT_A_PLACE:
        names.add("position_gain")
    if settings.task in ("hold_point", "follow_path"):
        names.add("path")
    if settings.task == "follow_path":
        names |= {"path_kind", "path_speed"} | ({"path_size"} if len(settings.path) < 2 else set())
    return frozenset(names)


def build_controller(name: str, robot: Robot, task_manager: TaskManager, map_kinematics: MapKinematics) -> Controller:
    """Build a controller by name.

    Args:
        name: One of ``CONTROLLERS``.
        robot: Robot to be controlled.
        task_manager: Task manager shared by all controllers.
        map_kinematics: Kinematics of the map.
    """
    return CONTROLLERS[name].build(robot, task_manager, map_kinematics)


def check_settings(settings: ControlSettings) -> ControlSettings:
    """Return the settings unchanged if all values are valid.

    Raises:
        SceneError: Names the setting, its value and its range.
    """
    for name, known in CHOICES.items():
        value = getattr(settings, name)
        if value not in known and not (name == "controller" and value in CONTROLLERS):
            remedy = f"Choose {', '.join(known[:-1])} or {known[-1]}"
            if name == "controller":
                remedy = CONTROLLERS.remedy(str(value))
            raise SceneError("this is not one of the choices", place=f"control.{name}", value=value, remedy=remedy)
    for name, (low, high) in RANGES.items():
        value = getattr(settings, name)
        if not low <= value <= high:  # NaN is in no range
            raise SceneError(
                "that setting is out of range", place=f"control.{name}", value=value, remedy=range_remedy(name)
            )
    if type(settings.starts) is not int or not 0 <= settings.starts <= MOST_STARTS:
        raise SceneError(
            "the number of starts is out of range",
            place="control.starts",
            value=settings.starts,
            remedy=f"Choose 0 to {MOST_STARTS}",
        )
    _check_path(settings)
    return settings


def _check_path(settings: ControlSettings) -> None:
    path = settings.path
    good = all(len(point) == 2 and all(is_number(x) and isfinite(x) for x in point) for point in path)
    if not good or len(path) > MOST_POINTS:
        raise SceneError(
            "this is not a path on the map",
            place="control.path",
            value=path[:3],
            remedy=f"Give up to {MOST_POINTS} points of two finite numbers in metres",
        )


def settings_from(values: Mapping[str, object]) -> ControlSettings:
    """Read settings from a scene's table.

    Raises:
        SceneError: A key is unknown or a value out of range.
    """
    check_keys(values, ControlSettings, place="control")
    try:
        settings = ControlSettings(**values)  # type: ignore[arg-type]
    except TypeError as error:
        remedy = "Give a list of points of two numbers in metres"
        raise SceneError(
            "this is not a path on the map", place="control.path", value=values["path"], remedy=remedy
        ) from error
    return check_settings(settings)


def scene_values(settings: ControlSettings) -> dict[str, str | float | tuple[tuple[float, float], ...]]:
    """Return the settings that differ from the defaults, as a scene's table that ``settings_from`` reads."""
    default = ControlSettings()
    values = {field.name: getattr(settings, field.name) for field in fields(settings)}
    return {name: value for name, value in values.items() if value != getattr(default, name)}
