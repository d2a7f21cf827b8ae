"""What goes into a controller and comes out of it: settings and their ranges, the joint command, the report of its
task.

Settings are checked where they come in, from a scene, a recording or a person: see ``controller_registry``.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Literal, TypeAlias, get_args

from tactile_maps.core.arrays import FloatArray, freeze_arrays, set_fields
from tactile_maps.core.codec import AnyFloat
from tactile_maps.core.errors import SceneError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.jacobian import JacobianKind
from tactile_maps.maps.paths import PathKind

ControllerName: TypeAlias = Literal[
    "impedance", "hold_force", "admittance", "hybrid", "parallel", "projection", "priority", "qp"
]
TaskName: TypeAlias = Literal["keep_force", "hold_point", "follow_path", "balance", "retreat", "guide"]
GainsMode: TypeAlias = Literal["limited", "as_given"]


@dataclass(frozen=True, eq=False)
class JointCommand:
    """A joint impedance command: torque = stiffness (posture - q) - damping q' + torque.

    Attributes:
        posture: (n,) wanted posture [rad, or m for a slide].
        stiffness: (n,) [N m/rad], >= 0.
        damping: (n,) [N m s/rad], >= 0.
        torque: (n,) added torque [N m].
    """

    posture: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    torque: FloatArray

    def __post_init__(self) -> None:
        freeze_arrays(self, "posture", "stiffness", "damping", "torque")

    def torque_at(self, posture: FloatArray, velocity: FloatArray | float) -> FloatArray:
        """(n,) the whole torque [N m] that this asks for at a posture and velocity (n,)."""
        return self.stiffness * (self.posture - posture) - self.damping * velocity + self.torque


@dataclass(frozen=True)
class ControlSettings:
    """What the controller panel sets.

    Attributes:
        controller: A ``ControllerName`` or that of a plug-in. ``impedance`` holds the rest posture like a spring;
            ``hold_force`` retreats from or follows a touch so that the contact force stays at ``force_goal``, and
            returns to rest when the touch ends. The others do a task: see ``controllers``.
        stiffness: Of the joints in the impedance controller, as natural frequency [rad/s]: each joint's torque
            stiffness is its current inertia times the square, so that one slider suits a shoulder and a wrist.
        damping_ratio: 1 is critical.
        force_goal: Wanted contact force [N].
        force_gain: Approach or retreat speed per newton of force error [m/s/N].
        integral_time: Time in which a constant error doubles the answer [s]; inf for none.
        task: What a controller with a task does, see ``tasks``.
        position_gain: Speed on the map per error on the map [1/s].
        gains: Whether gains that the skin is read too seldom or too late for are held lower, see ``force_loop``.
        inertia_time: How slowly the admittance and the parallel controller take up a speed [s].
        jacobian: Whose word is taken for how the map lies on the body.
        path_kind: How ``path`` is meant, or what is laid about the place first touched when it is empty.
        path: Points on the map [m]: the corners of a polyline or spline, two ends of a lemniscate, two corners of a
            raster. A held point is its first.
        path_size: How long a path is that nobody drew [m].
        path_speed: Along the path, on the map [m/s].
        starts: Another number than before starts the task afresh, as a path from its beginning.
        max_force: A contact with more [N] stops the arm; the QP keeps contacts under 80 % of it in slow approaches
            (table in the guide).

    Raises:
        SceneError: A number is none: truth values and texts are refused here, ranges by ``check_settings``.

    Example:
        >>> settings = tm.ControlSettings(controller="hold_force", force_goal=2.0)
        >>> tm.Session.of(robot, tactile_map, settings=settings).settings.force_goal
        2.0
    """

    controller: str = "impedance"
    stiffness: float = 8.0
    damping_ratio: float = 1.0
    force_goal: float = 3.0
    force_gain: float = 0.005
    integral_time: AnyFloat = 0.3
    task: TaskName = "keep_force"
    position_gain: float = 4.0
    gains: GainsMode = "limited"
    inertia_time: float = 0.05
    jacobian: JacobianKind = "smoothed"
    path_kind: PathKind = "lemniscate"
    path: tuple[tuple[float, float], ...] = ()
    path_size: float = 0.03
    path_speed: float = 0.01
    starts: int = 0
    max_force: float = 40.0

    def __post_init__(self) -> None:
        for name in RANGES:
            if not is_number(getattr(self, name)):
                problem = "that setting must be a number"
                value = getattr(self, name)
                raise SceneError(problem, place=f"control.{name}", value=value, remedy=range_remedy(name))
        # From a file points come as lists; a value has to compare and hash.
        set_fields(self, path=tuple(tuple(point) for point in self.path))


RANGES: dict[str, tuple[float, float]] = {
    "stiffness": (0.5, 40.0),
    "damping_ratio": (0.1, 3.0),
    "force_goal": (0.0, 20.0),
    "force_gain": (0.0, 0.05),
    "integral_time": (0.05, float("inf")),
    "position_gain": (0.0, 20.0),
    "inertia_time": (0.0, 0.5),
    "path_size": (0.005, 0.2),
    "path_speed": (0.0, 0.2),
    "max_force": (1.0, 200.0),
}
"""Smallest and largest value by setting; the panel's sliders end here."""
CHOICES: dict[str, tuple[str, ...]] = {
    "controller": get_args(ControllerName),
    "task": get_args(TaskName),
    "jacobian": get_args(JacobianKind),
    "gains": get_args(GainsMode),
    "path_kind": get_args(PathKind),
}
"""Values of the settings that are chosen from a list, without controllers of plug-ins."""
MOST_POINTS = 2000
"""Of a path."""
MOST_STARTS = 10**9
"""Of a task."""


def is_number(value: object) -> bool:
    """Whether it is a number; truth values are none."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def range_remedy(name: str) -> str:
    """What to do about a number out of its range."""
    low, high = RANGES[name]
    return f"Choose {low:g} to {high:g}"


class RegraspState(Enum):
    """Where a contact is on its way to another place of the skin."""

    PLAN = "plan"
    """A path is planned while the contact is still held."""
    LIFT = "lift"
    CARRY = "carry"
    PRESS = "press"
    RETURN = "return"
    """To the old place."""
    ARRIVED = "arrived"
    FAILED = "failed"

    @property
    def moves(self) -> bool:
        """Whether the arm is on the way, without a task for any contact."""
        return self in _MOVES


_MOVES = frozenset({RegraspState.LIFT, RegraspState.CARRY, RegraspState.PRESS, RegraspState.RETURN})


@dataclass(frozen=True)
class TaskReport:
    """How the task goes.

    Attributes:
        target: Where on the body the contact is wanted; None where it may be anywhere.
        error: From the contact to the target, on the map [m]; None without a contact or target.
        force_goal: Wanted of the contact that the task is about [N]; None where none is wanted.
        controlled: Ids of the contacts whose force is controlled, the one that the task is about first.
        laid_at: (2,) the place on the map about which a path lies that nobody drew [m]; None for no such path.
        way: Walked along the path [m].
        energy: Net energy given to contacts since the first of them touched [J]; below zero the arm took it.
        tank: What may still be given [J].
        piece: Number of the path's part, between two crossings, where the target is.
        regrasp: How a contact is taken over a crossing; None while none is.
    """

    target: SurfacePoint | None = None
    error: float | None = None
    force_goal: float | None = None
    controlled: tuple[int, ...] = ()
    laid_at: tuple[float, float] | None = None
    way: float = 0.0
    energy: float = 0.0
    tank: float = 0.0
    piece: int = 0
    regrasp: RegraspState | None = None
