"""Joint impedance from one frequency, and the wanted posture it holds.

The same slider suits a shoulder and a wrist (``JointImpedance``). A ``PostureReference`` is a wanted posture that
controllers move by joint velocities, held by a stiff joint impedance; here are also the bounds on speeds that all of
them keep.
"""

from __future__ import annotations

import numpy as np

from app.control.command import JointCommand
from app.control.limits import ActiveLimits, Limit, LimitKind
from app.core.arrays import BoolArray, FloatArray, any_true, largest, readonly
from app.robots.robot import Robot

MIN_INERTIA = 1e-3
"""Floor of a joint's inertia [kg m²] for choosing its stiffness, so that a weightless joint still holds."""


class JointImpedance:
    """Second-order joints of one natural frequency about any posture; the gains are worked out once.

    Args:
        inertia: (n,) each joint's inertia at home [kg m²].
        frequency: [rad/s]; stiffness is inertia times its square.
        damping_ratio: Damping is 2 ratio frequency inertia; 1 is critical.

    Attributes:
        stiffness: (n,) [N m/rad].
        damping: (n,) [N m s/rad].
    """

    def __init__(self, inertia: FloatArray, *, frequency: float, damping_ratio: float) -> None:
        weight = np.maximum(inertia, MIN_INERTIA)
        self.stiffness = readonly(weight * frequency**2)
        self.damping = readonly(2 * damping_ratio * frequency * weight)
        self._no_torque = readonly(np.zeros(len(weight)))

    def about(self, posture: FloatArray) -> JointCommand:
        """The command that holds ``posture`` (n,)."""
        return JointCommand(posture, self.stiffness, self.damping, self._no_torque)


def joint_impedance(
    inertia: FloatArray, posture: FloatArray, *, frequency: float, damping_ratio: float
) -> JointCommand:
    """The same in one go, for gains that may be others at the next tick."""
    return JointImpedance(inertia, frequency=frequency, damping_ratio=damping_ratio).about(posture)


def joint_limits(robot: Robot) -> tuple[FloatArray, FloatArray]:
    """Lower and upper limits (n,) of all joints."""
    return np.array([j.lower for j in robot.joints]), np.array([j.upper for j in robot.joints])


MAX_POINT_SPEED = 0.25
"""Of a touched point [m/s]."""
MAX_JOINT_SPEED = 1.5
"""Of any joint [rad/s]."""
WEAK = MAX_POINT_SPEED / MAX_JOINT_SPEED
"""How little a joint velocity may move a point before damping sets in [m/rad]: there the greatest speed of a point asks
for the greatest of a joint."""
DAMPING = WEAK / 2**0.5
"""Of least squares [m/rad] where nothing moves the point. Its square falls with that of a direction's gain s, to zero
at WEAK; this much makes the answer 2 s / (s² + WEAK²) per speed, which is nowhere more than at WEAK."""
INNER_FREQUENCY = 40.0
"""Natural frequency of the inner posture loop [rad/s]; well above the force loop's."""
HOME_RATE = 1.5
"""How fast the wanted posture returns to rest once nothing touches [1/s]."""
HOME_SPEED = 0.6
"""And never faster than this [rad/s]."""
MAX_LEAD = 0.3
"""How far the wanted posture may run ahead of an arm that something holds back [rad]."""


class PostureReference:
    """The wanted posture. Mutable; ``reset`` forgets it, and the next posture found is where it starts.

    Args:
        robot: Whose joints; it may have none.
        inertia: (n,) each joint's inertia at home [kg m²].

    Attributes:
        wanted: (n,) None until it starts.
        impedance: What holds it.
        lower: (n,) limits of the joints.
        upper: (n,).
    """

    def __init__(self, robot: Robot, inertia: FloatArray) -> None:
        self.impedance = JointImpedance(inertia, frequency=INNER_FREQUENCY, damping_ratio=1.0)
        self.lower, self.upper = joint_limits(robot)
        self._names = tuple(joint.name for joint in robot.joints)
        self.reset()

    def reset(self) -> None:
        """Start afresh."""
        self.wanted: FloatArray | None = None
        self._homing = np.zeros_like(self.lower)

    def start(self, posture: FloatArray, torque: FloatArray) -> None:
        """Start where the stiff impedance asks of an arm at rest in ``posture`` (n,) for just ``torque`` (n,) [N m]."""
        self.wanted = posture + np.clip(torque / self.impedance.stiffness, -MAX_LEAD, MAX_LEAD)
        self._homing = np.zeros_like(posture)

    def start_posture(self, posture: FloatArray) -> FloatArray:
        """(n,) the wanted posture, or the one found."""
        return posture if self.wanted is None else self.wanted

    def stop_homing(self) -> None:
        """Whatever moved it home has stopped."""
        self._homing[:] = 0.0

    def home_speed(self, start: FloatArray, rest: FloatArray, dt: float, *, most: float = HOME_SPEED) -> FloatArray:
        """(n,) towards rest, exponentially, no faster than ``most``, starting gently (first-order lag of 0.2 s)."""
        aim = np.clip(HOME_RATE * (rest - start), -most, most)
        self._homing = self._homing + min(dt / 0.2, 1.0) * (aim - self._homing)
        return self._homing

    def move(self, posture: FloatArray, speed: FloatArray, dt: float, limits: ActiveLimits) -> JointCommand:
        """Move the wanted posture from where it is; bounded by the joints' limits and by what holds the arm back."""
        wanted = self.start_posture(posture) + dt * speed
        near = np.minimum(np.maximum(wanted, posture - MAX_LEAD), posture + MAX_LEAD)
        self.wanted = np.minimum(np.maximum(near, self.lower), self.upper)
        if any_true(self.wanted != wanted):
            if any_true(near != wanted):
                limits.add(Limit(LimitKind.HELD_BACK))
            self.tell_joint_limits(self.wanted != near, limits)
        return self.command_at(self.wanted)

    def tell_joint_limits(self, stuck: BoolArray, limits: ActiveLimits) -> None:
        """Say which joints are ``stuck`` (n,) at their limits, if any are."""
        if stuck.any():
            names = tuple(name for name, held in zip(self._names, stuck.tolist(), strict=True) if held)
            limits.add(Limit(LimitKind.JOINT_LIMIT, names))

    def command_at(self, posture: FloatArray) -> JointCommand:
        """The stiff impedance about a posture."""
        return self.impedance.about(posture)


def at_limit(reference: PostureReference, start: FloatArray, speed: FloatArray) -> BoolArray:
    """(n,) which joints would leave their range from ``start`` (n,)."""
    return ((start <= reference.lower) & (speed < 0)) | ((start >= reference.upper) & (speed > 0))


def limit_joint_speed(speed: FloatArray, limits: ActiveLimits) -> FloatArray:
    """The joint velocity (n,), all of it slower if a joint would be too fast."""
    fastest = largest(speed)
    if fastest <= MAX_JOINT_SPEED:
        return speed
    limits.add(Limit(LimitKind.JOINT_SPEED))
    return speed * (MAX_JOINT_SPEED / fastest)
