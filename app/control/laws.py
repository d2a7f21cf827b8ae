"""All laws by name, and what each heeds."""

from __future__ import annotations

from collections.abc import Callable

from app.control.admittance import Admittance
from app.control.command import ControlSettings
from app.control.hold_force import HoldForce
from app.control.hybrid import Hybrid
from app.control.impedance import ImpedancePosture
from app.control.law import Law
from app.control.map_sight import MapSight
from app.control.parallel import Parallel
from app.control.priority import Priority
from app.control.projection import Projection
from app.control.quadratic_program import QuadraticProgram
from app.control.rule import Rule
from app.control.task_keeper import TaskKeeper
from app.control.task_law import TaskLaw
from app.robots.robot import Robot

RULES: dict[str, Callable[[], Rule]] = {
    "admittance": Admittance,
    "hybrid": Hybrid,
    "parallel": Parallel,
    "projection": Projection,
    "priority": Priority,
    "qp": QuadraticProgram,
}
"""Laws with a task."""
_GAINS: dict[str, tuple[str, ...]] = {
    "impedance": ("stiffness", "damping_ratio"),
    "hold_force": ("force_goal", "force_gain", "integral_time"),
    "admittance": ("force_gain", "inertia_time"),
    "hybrid": ("force_gain", "integral_time"),
    "parallel": ("force_gain", "integral_time", "position_gain", "inertia_time"),
    "projection": ("force_gain", "integral_time"),
    "priority": ("force_gain", "integral_time"),
    "qp": ("force_gain", "integral_time"),
}
AT_A_PLACE = ("hold_point", "follow_path", "guide")
"""Tasks that want the contact at a place of the map."""


def heeded(settings: ControlSettings) -> frozenset[str]:
    """Names of the settings that make a difference to the law and task chosen, besides ``law``."""
    names = set(_GAINS[settings.law]) | ({"gains"} if settings.law != "impedance" else set())
    if settings.law not in RULES:
        return frozenset(names)
    names |= {"task", "max_force", "jacobian"}  # the normal, too, is taken by the Jacobian's word
    if settings.task != "retreat":
        names.add("force_goal")
    if settings.task in AT_A_PLACE:
        names.add("position_gain")
    if settings.task in ("hold_point", "follow_path"):
        names.add("path")
    if settings.task == "follow_path":
        names |= {"path_kind", "path_speed"} | ({"path_size"} if len(settings.path) < 2 else set())
    return frozenset(names)


def build_law(name: str, robot: Robot, keeper: TaskKeeper, sight: MapSight) -> Law:
    """A law by its name, one of ``settings_check.CHOICES``.

    Args:
        name: Which.
        robot: Whose joints.
        keeper: Of the task, shared by all laws.
        sight: Of the map.
    """
    if name == "impedance":
        return ImpedancePosture(robot)
    if name == "hold_force":
        return HoldForce(robot)
    return TaskLaw(robot, RULES[name](), keeper, sight)
