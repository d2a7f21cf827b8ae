"""Input and output of controllers: settings and their ranges, the joint command, the report of a task.

``controller_registry`` checks settings from scenes, recordings and users.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from math import inf, pi
from typing import Literal, TypeAlias, get_args

from tactile_maps.core.arrays import ArrayFields, FloatArray, set_fields
from tactile_maps.core.codec import LATER, AnyFloat
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
class JointCommand(ArrayFields):
    """Joint impedance command: torque = stiffness (posture - q) - damping q' + torque.

    Attributes:
        posture: (n,) desired posture [rad, or m for a slide].
        stiffness: (n,) [N m/rad], >= 0.
        damping: (n,) [N m s/rad], >= 0.
        torque: (n,) added torque [N m].
    """

    posture: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    torque: FloatArray

    def torque_at(self, posture: FloatArray, velocity: FloatArray | float) -> FloatArray:
        """Return the total commanded torque (n,) [N m] at a posture and velocity (n,)."""
        return self.stiffness * (self.posture - posture) - self.damping * velocity + self.torque


@dataclass(frozen=True)
class ControlSettings:
    """Settings of the controller panel.

    Attributes:
        controller: A ``ControllerName`` or the name of a plug-in's controller. ``impedance`` holds the rest posture
            like a spring; ``hold_force`` retreats from or follows a touch so that the contact force stays at
            ``force_goal``, and returns to rest when the touch ends. The others perform a task: see ``controllers``.
        stiffness: Natural frequency of the joints in the impedance controller [rad/s]: each joint's torque stiffness
            is its current inertia times the square, so that one slider suits a shoulder and a wrist.
        damping_ratio: Damping ratio of the joints in the impedance controller; 1 is critical.
        force_goal: Desired contact force [N].
        force_gain: Approach or retreat speed per newton of force error [m/s/N].
        integral_time: Time in which a constant error doubles the output [s]; inf for none.
        task: Task of a controller with a task, see ``tasks``.
        position_gain: Speed on the map per error on the map [1/s].
        gains: Whether gains too high for the period and delay of the skin's readings are reduced, see ``gain_limits``.
        inertia_time: Time constant of the speed in the admittance and the parallel controller [s].
        jacobian: Kind of Jacobian between body and map.
        path_kind: Shape of ``path``; if that is empty, shape of the default path about the place first touched.
        path: Points on the map [m]: the corners of a polyline or spline, two ends of a lemniscate, two corners of a
            raster. ``hold_point`` uses the first.
        path_size: Length of a default path [m].
        path_speed: Speed along the path, on the map [m/s].
        starts: A new number restarts the task, for example a path at its beginning.
        max_force: A contact with more force [N] stops the arm; the QP keeps contacts under 80 % of it in slow
            approaches (table in the guide).
        max_impact: Largest force with which a taxel may hit an object at rest [N], see ``approach_speed``; inf for no
            bound. Joints move more slowly where the force would be larger.
        shear_goal: Desired force of the object along the skin [N] in ``keep_force`` and ``hold_point``, for skins that
            measure shear; 0 for none.
        shear_direction: Its direction on the map, from the x axis towards the y axis [rad].
        shear_threshold: Force along the skin with which a hand begins to move the arm in ``guide`` [N]; inf to follow
            the place of the hand only, as on skins that do not measure shear.
        max_shear: Largest force along the skin [N]: a contact with more yields along the skin. inf for no bound.
        friction_use: Largest share of its friction that a contact may use, for skins that measure shear; while it is
            exceeded the force goal rises, see ``grip``. inf for no bound.

    Raises:
        SceneError: A value is not a number (truth values and texts are rejected). ``check_settings`` checks ranges.

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
    max_impact: AnyFloat = field(default=inf, metadata=LATER)
    friction_use: AnyFloat = field(default=inf, metadata=LATER)
    shear_goal: float = field(default=0.0, metadata=LATER)
    shear_direction: float = field(default=0.0, metadata=LATER)
    shear_threshold: AnyFloat = field(default=0.3, metadata=LATER)
    max_shear: AnyFloat = field(default=inf, metadata=LATER)

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
    "integral_time": (0.05, inf),
    "position_gain": (0.0, 20.0),
    "inertia_time": (0.0, 0.5),
    "path_size": (0.005, 0.2),
    "path_speed": (0.0, 0.2),
    "max_force": (1.0, 200.0),
    "max_impact": (1.0, inf),
    "friction_use": (0.1, inf),
    "shear_goal": (0.0, 20.0),
    "shear_direction": (-pi, pi),
    "shear_threshold": (0.0, inf),
    "max_shear": (0.0, inf),
}
"""Smallest and largest value of each setting; also the range of the panel's sliders."""
CHOICES: dict[str, tuple[str, ...]] = {
    "controller": get_args(ControllerName),
    "task": get_args(TaskName),
    "jacobian": get_args(JacobianKind),
    "gains": get_args(GainsMode),
    "path_kind": get_args(PathKind),
}
"""Values of the settings that are chosen from a list, without controllers of plug-ins."""
MOST_POINTS = 2000
"""Largest number of points of a path."""
MOST_STARTS = 10**9
"""Largest number of starts of a task."""


def is_number(value: object) -> bool:
    """Return whether a value is a number other than a truth value."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def range_remedy(name: str) -> str:
    """Return the remedy for a number out of its range."""
    low, high = RANGES[name]
    return f"Choose {low:g} to {high:g}"


class RegraspState(Enum):
    """Phase of moving a contact to another place of the skin."""

    PLAN = "plan"
    """A path is planned while the contact is still held."""
    LIFT = "lift"
    CARRY = "carry"
    PRESS = "press"
    RETURN = "return"
    """The arm returns to the old place."""
    ARRIVED = "arrived"
    FAILED = "failed"

    @property
    def moves(self) -> bool:
        """Whether the arm moves without a task for any contact."""
        return self not in (RegraspState.PLAN, RegraspState.ARRIVED, RegraspState.FAILED)


@dataclass(frozen=True)
class TaskReport:
    """Progress of a task.

    Attributes:
        target: Desired place of the contact on the body; None if it may be anywhere.
        error: Distance on the map from the contact to the target [m]; None without a contact or target.
        force_goal: Desired force of the first controlled contact [N]; None without one.
        controlled: Ids of the contacts whose force is controlled, the task's own contact first.
        laid_at: (2,) place on the map about which a default path is centred [m]; None for a drawn path.
        way: Distance covered along the path [m].
        energy: Net energy given to contacts since the first of them touched [J]; negative if the arm received energy.
        tank: Energy that may still be given [J].
        piece: Number of the path's part, between two crossings, that contains the target.
        regrasp: Phase of a regrasp over a crossing; None without one.
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
