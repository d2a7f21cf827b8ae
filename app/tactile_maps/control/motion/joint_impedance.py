"""Joint impedance of one natural frequency at any posture, and the desired posture that it holds.

A ``PostureReference`` is a desired posture that controllers move by joint velocities, held by a stiff joint impedance.
The bounds on speeds that all controllers respect are here as well.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactile_maps.control.motion.command import JointCommand
from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind
from tactile_maps.core.arrays import BoolArray, FloatArray, any_true, largest
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot

MIN_INERTIA = 1e-3
"""Smallest inertia of a joint [kg m²] for its stiffness, so that a weightless joint still holds."""
RESPONSE_TOLERANCE = 0.3
"""Relative difference of a joint's frequency or damping ratio from the requested one that is not reported."""


class JointImpedance:
    """Joint stiffness and damping that give every joint the same natural frequency at the current posture.

    A joint alone, with the others held, has exactly this frequency and damping ratio. In seven published arms at random
    postures, modes of coupled joints have 0.57 to 32 times the frequency and at least 0.54 of the damping ratio. With
    the inertia at home, which is almost zero for some joints of a straight arm, the smallest were 0.05 and 0.09.

    Args:
        configuration: The robot at its current posture, which the owner updates.
        frequency: Natural frequency [rad/s]; the stiffness is the joint's inertia times its square.
        damping_ratio: 1 is critical. The damping is  2 ratio frequency inertia  less the joint's own damping.
        same_lag: Whether a joint whose own damping exceeds this is made stiffer, see ``joint_impedance``.

    Cost: 4 us a command.
    """

    def __init__(
        self, configuration: Configuration, *, frequency: float, damping_ratio: float, same_lag: bool = False
    ) -> None:
        self._configuration = configuration
        self._frequency = frequency
        self._damping_ratio = damping_ratio
        self._same_lag = same_lag

    @property
    def stiffness(self) -> FloatArray:
        """(n,) at the current posture [N m/rad, or N/m for a slide]."""
        return self.about(self._configuration.posture).stiffness

    @property
    def damping(self) -> FloatArray:
        """(n,) of the joints under this impedance [N m s/rad, or N s/m]: the commanded damping and their own."""
        own = self._configuration.joint_damping
        commanded = self.about(self._configuration.posture).damping
        return own + commanded

    def deviation(self) -> Limit | None:
        """Return the joint whose frequency or damping ratio is farthest from the requested one, alone and with the
        others held; None if all are within ``RESPONSE_TOLERANCE``.

        Joints lighter than ``MIN_INERTIA`` are faster, joints with much damping of their own are slower.
        """
        inertia = self._configuration.inertia()
        frequency = np.sqrt(self.stiffness / inertia)
        damping_ratio = self.damping / (2 * frequency * inertia)
        error = np.maximum(abs(frequency / self._frequency - 1), abs(damping_ratio / self._damping_ratio - 1))
        if not (error > RESPONSE_TOLERANCE).any():
            return None
        worst = int(error.argmax())
        return Limit(
            LimitKind.JOINT_RESPONSE,
            (self._configuration.joint_names[worst],),
            value=float(frequency[worst]),
            damping_ratio=float(damping_ratio[worst]),
        )

    def about(self, posture: FloatArray) -> JointCommand:
        """Return the command that holds ``posture`` (n,)."""
        return joint_impedance(
            self._configuration.inertia(),
            posture,
            frequency=self._frequency,
            damping_ratio=self._damping_ratio,
            own_damping=self._configuration.joint_damping,
            same_lag=self._same_lag,
        )


STOP_FREQUENCY = 8.0
"""Natural frequency at which a stopped arm holds its place [rad/s]: softly, so that what presses it is relieved."""
_BRAKE_FREQUENCY = 20.0
"""Critical damping at this frequency [rad/s] is added where a stopped arm gives way too fast."""


class YieldingImpedance:
    """The soft impedance of a stopped arm, with more damping of joints that give way faster than allowed.

    Args:
        configuration: The robot at its current posture, which the owner updates.
        max_speed: (n,) speed of each joint above which it is braked [rad/s, or m/s for a slide].
    """

    def __init__(self, configuration: Configuration, max_speed: FloatArray) -> None:
        self._impedance = JointImpedance(configuration, frequency=STOP_FREQUENCY, damping_ratio=1.0)
        self._max_speed = max_speed

    def about(self, posture: FloatArray, velocity: FloatArray) -> JointCommand:
        """Return the command that holds ``posture`` (n,) of an arm with this ``velocity`` (n,).

        The brake is a damper on the speed above ``max_speed``: it only takes energy, and its torque does not jump.
        """
        command = self._impedance.about(posture)
        fast = np.abs(velocity) > self._max_speed
        if not any_true(fast):
            return command
        brake = np.where(fast, command.stiffness * (2 * _BRAKE_FREQUENCY / STOP_FREQUENCY**2), 0.0)
        torque = brake * np.sign(velocity) * self._max_speed
        return replace(command, damping=command.damping + brake, torque=torque)


def joint_impedance(
    inertia: FloatArray,
    posture: FloatArray,
    *,
    frequency: float,
    damping_ratio: float,
    own_damping: FloatArray | float = 0.0,
    same_lag: bool = False,
) -> JointCommand:
    """Return the command that holds ``posture`` (n,) in joints of the given ``inertia`` (n,) [kg m², or kg].

    Args:
        inertia: Diagonal of the mass matrix.
        posture: Posture to hold.
        frequency: Natural frequency of each joint [rad/s].
        damping_ratio: 1 is critical.
        own_damping: (n,) viscous damping that the joints have without a command [N m s/rad, or N s/m].
        same_lag: Whether a joint with too much damping of its own is made stiffer in the same proportion. It then
            follows a motion with the requested lag, damping over stiffness, and comes to rest without overshoot.
    """
    weight = np.maximum(inertia, MIN_INERTIA)
    requested = 2 * damping_ratio * frequency * weight
    stiffness = weight * frequency**2
    if same_lag:
        stiffness = stiffness * np.maximum(own_damping / requested, 1.0)
    return JointCommand(posture, stiffness, np.maximum(requested - own_damping, 0.0), np.zeros(len(weight)))


def joint_limits(robot: Robot) -> tuple[FloatArray, FloatArray]:
    """Return lower and upper limits (n,) of all joints."""
    return np.array([j.lower for j in robot.joints]), np.array([j.upper for j in robot.joints])


MAX_POINT_SPEED = 0.25
"""Largest speed of a contact point [m/s]."""
MAX_JOINT_SPEED = 1.5
"""Largest speed of a hinge [rad/s], where its model states no smaller one."""
MAX_SLIDE_SPEED = MAX_POINT_SPEED
"""Largest speed of a slide [m/s], where its model states no smaller one."""
INNER_FREQUENCY = 40.0
"""Natural frequency of the inner posture loop [rad/s]; well above that of the force loop."""


def posture_loop(configuration: Configuration) -> JointImpedance:
    """Return the stiff impedance that holds a desired posture.

    Args:
        configuration: The robot at its current posture, which the owner updates.
    """
    return JointImpedance(configuration, frequency=INNER_FREQUENCY, damping_ratio=1.0, same_lag=True)


HOME_RATE = 1.5
"""Rate at which the desired posture returns to rest once nothing touches [1/s]."""
HOME_SPEED = 0.6
"""Largest speed on the return to rest [rad/s]; slow joints and slides use the same share of their largest speed."""
MAX_LEAD = 0.3
MAX_SLIDE_LEAD = 0.1
"""Largest distance of the desired posture from the posture of an arm that something blocks [rad], and of slides [m]."""


def joint_speeds(robot: Robot) -> FloatArray:
    """Return the largest speed (n,) that controllers request of each joint [rad/s, or m/s for a slide]."""
    usual = (MAX_SLIDE_SPEED if joint.slide else MAX_JOINT_SPEED for joint in robot.joints)
    return np.array([min(most, joint.max_speed) for most, joint in zip(usual, robot.joints, strict=True)])


class SpeedScale:
    """Unit in which the speeds of all joints of a robot can be compared: their own, or the share of their limits.

    Args:
        robot: The robot; None for hinges without limits of their own.

    Attributes:
        unit: "rad/s" or "m/s" where all joints have the same kind and limit, else "% of limit".
        bound: The limit in this unit.
    """

    def __init__(self, robot: Robot | None = None) -> None:
        joints = () if robot is None else robot.joints
        limits = np.array([MAX_JOINT_SPEED]) if robot is None or not joints else joint_speeds(robot)
        slides = {joint.slide for joint in joints}
        if len(slides) < 2 and (limits == limits[0]).all():
            self.unit = "m/s" if True in slides else "rad/s"
            self.bound = float(limits[0])
            self._units = np.ones(1)
        else:
            self.unit = "% of limit"
            self.bound = 100.0
            self._units = limits / self.bound

    def value(self, velocity: FloatArray) -> float:
        """Return the speed of the joint that is nearest to its limit, of joint velocities (n,)."""
        return float(np.abs(velocity / self._units).max(initial=0.0))


def joint_efforts(robot: Robot) -> FloatArray:
    """Return the largest torque or force (n,) of each joint [N m, or N for a slide]; inf where there is no limit."""
    return np.array([joint.max_effort for joint in robot.joints])


def within_effort(
    command: JointCommand, posture: FloatArray, velocity: FloatArray | float, efforts: FloatArray
) -> tuple[JointCommand, BoolArray]:
    """Return the command with its posture moved so that no torque exceeds ``efforts``, and the affected joints (n,).

    Args:
        command: Command to limit.
        posture: (n,) measured.
        velocity: (n,) measured.
        efforts: (n,) largest torque or force of each joint [N m, or N].
    """
    torque = command.torque_at(posture, velocity)
    excess = np.abs(torque) > efforts * (1 + 1e-9)
    if not any_true(excess):
        return command, excess
    too_much = torque - np.clip(torque, -efforts, efforts)
    held = excess & (command.stiffness > 0)  # torque that does not come from a spring is reduced directly
    change = np.divide(too_much, command.stiffness, out=np.zeros_like(torque), where=held)
    reduced = command.torque - np.where(excess & ~held, too_much, 0.0)
    return replace(command, posture=command.posture - change, torque=reduced), excess


class PostureReference:
    """Desired posture of the joints. Mutable; ``reset`` discards it, and it restarts at the next measured posture.

    Args:
        robot: Robot to be controlled; it may have no joints.
        configuration: The robot at its current posture, which the owner updates.

    Attributes:
        desired: (n,) desired posture; None until it starts.
        impedance: Impedance that holds the posture.
        lower: (n,) lower limits of the joints.
        upper: (n,) upper limits of the joints.
        max_speed: (n,) largest speeds of the joints [rad/s, or m/s for a slide].
        bounded: Whether the last move was bounded by the torque of a joint, or slower than requested. Integrals must
            not grow then.
    """

    def __init__(self, robot: Robot, configuration: Configuration) -> None:
        self.impedance = posture_loop(configuration)
        self.lower, self.upper = joint_limits(robot)
        self.max_speed = joint_speeds(robot)
        self._efforts = joint_efforts(robot)
        self._lead = np.array([MAX_SLIDE_LEAD if joint.slide else MAX_LEAD for joint in robot.joints])
        self._names = robot.joint_names
        self.reset()

    def reset(self) -> None:
        """Discard the desired posture."""
        self.desired: FloatArray | None = None
        self.bounded = False
        self._homing = np.zeros_like(self.lower)

    def start(self, posture: FloatArray, torque: FloatArray) -> None:
        """Start at the posture whose command for an arm at rest in ``posture`` (n,) has this ``torque`` (n,) [N m]."""
        self.desired = posture + np.clip(torque / self.impedance.stiffness, -self._lead, self._lead)
        self._homing = np.zeros_like(posture)

    def start_posture(self, posture: FloatArray) -> FloatArray:
        """Return the desired posture (n,), or the measured one before the start."""
        return posture if self.desired is None else self.desired

    def stop_homing(self) -> None:
        """Stop the motion to the rest posture."""
        self._homing[:] = 0.0

    def home_speed(self, start: FloatArray, rest: FloatArray, dt: float, *, most: float = HOME_SPEED) -> FloatArray:
        """Return the speed (n,) towards rest: exponential, with a gentle start (first-order lag of 0.2 s).

        Args:
            start: (n,) desired posture.
            rest: (n,) rest posture.
            dt: Time step [s].
            most: Largest speed of a hinge [rad/s]; see ``slow_speed``.
        """
        bound = self.slow_speed(most)
        aim = np.clip(HOME_RATE * (rest - start), -bound, bound)
        self._homing = self._homing + min(dt / 0.2, 1.0) * (aim - self._homing)
        return self._homing

    def slow_speed(self, speed: float) -> FloatArray:
        """Return the joint speeds (n,) that are the same share of the largest ones as ``speed`` is of a hinge's."""
        return self.max_speed * (speed / MAX_JOINT_SPEED)

    def move(
        self,
        posture: FloatArray,
        speed: FloatArray,
        dt: float,
        limits: ActiveLimits,
        *,
        velocity: FloatArray | float = 0.0,
        slowed: bool = False,
    ) -> JointCommand:
        """Advance the desired posture; it stays within the limits of joints and torques, and near a blocked arm.

        Args:
            posture: (n,) measured posture.
            speed: (n,) speed of the desired posture.
            dt: Time step [s].
            limits: Collects the bounds that apply.
            velocity: (n,) measured.
            slowed: Whether ``speed`` is less than the controller requests.
        """
        deviation = self.impedance.deviation()
        if deviation is not None:
            limits.add(deviation)
        desired = self.start_posture(posture) + dt * speed
        near = np.minimum(np.maximum(desired, posture - self._lead), posture + self._lead)
        self.desired = np.minimum(np.maximum(near, self.lower), self.upper)
        if any_true(self.desired != desired):
            if any_true(near != desired):
                limits.add(Limit(LimitKind.HELD_BACK, self._named(near != desired)))
            self.report_joint_limits(self.desired != near, limits)
        command, excess = within_effort(self.command_at(self.desired), posture, velocity, self._efforts)
        torque_limited = any_true(excess)
        self.bounded = torque_limited or slowed
        if torque_limited:
            self.desired = command.posture
            limits.add(Limit(LimitKind.TORQUE_LIMIT, self._named(excess)))
        return command

    def report_joint_limits(self, stuck: BoolArray, limits: ActiveLimits) -> None:
        """Add a limit for the joints that are ``stuck`` (n,) at their limits, if there are any."""
        if stuck.any():
            limits.add(Limit(LimitKind.JOINT_LIMIT, self._named(stuck)))

    def _named(self, joints: BoolArray) -> tuple[str, ...]:
        return tuple(name for name, found in zip(self._names, joints.tolist(), strict=True) if found)

    def command_at(self, posture: FloatArray) -> JointCommand:
        """Return the stiff impedance about a posture."""
        return self.impedance.about(posture)


def at_limit(reference: PostureReference, start: FloatArray, speed: FloatArray) -> BoolArray:
    """Return which joints (n,) would leave their range from ``start`` (n,)."""
    return ((start <= reference.lower) & (speed < 0)) | ((start >= reference.upper) & (speed > 0))


def limit_joint_speed(speed: FloatArray, max_speed: FloatArray, limits: ActiveLimits) -> FloatArray:
    """Return the joint velocity (n,), scaled down if a joint would exceed ``max_speed`` (n,)."""
    share = largest(speed / max_speed)
    if share <= 1:
        return speed
    limits.add(Limit(LimitKind.JOINT_SPEED))
    return speed / share
