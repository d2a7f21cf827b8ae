"""What a controller asks of the joints, and the settings a person turns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from app.arrays import FloatArray, readonly
from app.maps.map_jacobian import JacobianKind

LawName: TypeAlias = Literal[
    "impedance", "hold_force", "admittance", "hybrid", "parallel", "projection", "priority", "qp"
]
TaskName: TypeAlias = Literal["keep_force", "hold_point", "follow_path", "balance", "retreat", "guide"]
GainsKind: TypeAlias = Literal["calm", "as_set"]
PathKind: TypeAlias = Literal["polyline", "spline", "lemniscate", "raster"]


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
        for name in ("posture", "stiffness", "damping", "torque"):
            object.__setattr__(self, name, readonly(getattr(self, name)))

    def torque_at(self, posture: FloatArray, velocity: FloatArray) -> FloatArray:
        """(n,) the whole torque [N m] that this asks for at a posture and velocity (n,)."""
        return self.stiffness * (self.posture - posture) - self.damping * velocity + self.torque


@dataclass(frozen=True)
class ControlSettings:
    """What the controller panel sets.

    Attributes:
        law: ``impedance`` holds the rest posture like a spring; ``hold_force`` retreats from or follows a touch so
            that the contact force stays at ``force_goal``, and returns to rest when the touch ends. The others do a
            task: see ``task_law``.
        stiffness: Of the joints in the impedance law, as natural frequency [rad/s]: each joint's torque stiffness is
            its inertia at home times the square, so that one slider suits a shoulder and a wrist.
        damping_ratio: 1 is critical.
        force_goal: Wanted contact force [N].
        force_gain: Approach or retreat speed per newton of force error [m/s/N].
        integral_time: Time in which a constant error doubles the answer [s]; inf for none.
        task: What a law with a task does, see ``task_keeper``.
        position_gain: Speed on the map per error on the map [1/s].
        gains: Whether gains that the skin is read too seldom or too late for are held lower, see ``loop_watch``.
        inertia_time: How slowly the admittance and the parallel law take up a speed [s].
        jacobian: Whose word is taken for how the map lies on the body.
        path_kind: How ``path`` is meant, or what is laid about the place first touched when it is empty.
        path: Points on the map [m]: the corners of a polyline or spline, two ends of a lemniscate, two corners of a
            raster. A held point is its first.
        path_size: How long a path is that nobody drew [m].
        path_speed: Along the path, on the map [m/s].
        starts: Another number than before starts the task afresh, as a path from its beginning.
        max_force: A contact with more [N] stops the arm; the QP keeps every contact under 80 % of it.
    """

    law: LawName = "impedance"
    stiffness: float = 8.0
    damping_ratio: float = 1.0
    force_goal: float = 3.0
    force_gain: float = 0.005
    integral_time: float = 0.3
    task: TaskName = "keep_force"
    position_gain: float = 4.0
    gains: GainsKind = "calm"
    inertia_time: float = 0.05
    jacobian: JacobianKind = "smoothed"
    path_kind: PathKind = "lemniscate"
    path: tuple[tuple[float, float], ...] = ()
    path_size: float = 0.03
    path_speed: float = 0.01
    starts: int = 0
    max_force: float = 40.0

    def __post_init__(self) -> None:
        # From a file points come as lists; a value has to compare and hash.
        object.__setattr__(self, "path", tuple(tuple(point) for point in self.path))


@dataclass(frozen=True)
class ControlChanged:
    """The controller's settings changed; an input, recorded like a poke.

    Attributes:
        settings: From now on.
        by: The event that triggered it, in words; empty where a person did it. A session derives what its behaviours do
            again, and takes no such input from outside.
    """

    settings: ControlSettings
    by: str = ""
