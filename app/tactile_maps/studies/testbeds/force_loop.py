"""Force loop of a whole robot in contact: all joints, their coupled inertia, and the posture loop.

The theory of sampled loops omits these properties of an arm: coupled joints, a posture loop whose stiffness ignores the
coupling, and the stiffness and damping of the pressed layer at the goal.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from scipy.linalg import expm

from tactile_maps.control.force_loop.pressed_arm import LoopFilter
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import posture_loop
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import SkinError, UsageError
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.mujoco_spec import compile_spec, robot_spec
from tactile_maps.session.session import Session
from tactile_maps.simulation.physics import Physics
from tactile_maps.studies.testbeds.path_following import PathSetup
from tactile_maps.tactile.models.foundation import RELAXATION, FoundationModel

REST = 1.5
"""Time for the force to settle [s]."""
_GUESS = 0.01
_SLACK = 1e-7
_WIDENINGS = 10
_PROBED = 5e-5
"""Motion of the point in both directions to measure the stiffness [m]: 0.25 of 3 N. The springs of the layer are
discrete, and over a shorter distance their number would matter (2 %)."""


@dataclass(frozen=True)
class Filter:
    """A controller of force or place as a linear filter.

    Attributes:
        gain: Speed per error [1/s on the map, m/s/N for a force].
        integral_time: Integral time [s].
        position_gain: Gain of the parallel controller along the normal [1/s].
        inertia_time: Time constant of the speed [s].
        angle: Directional error of the corrections [rad].
    """

    gain: float
    integral_time: float = math.inf
    position_gain: float = 0.0
    inertia_time: float = 0.0
    angle: float = 0.0


def stability_limit(is_stable: Callable[[float], bool], guess: float, *, steps: int = 10) -> float:
    """Return the limit of stability of a parameter, to a part in 2^steps of half an octave.

    Args:
        is_stable: Whether a value is stable.
        guess: Estimate of the limit, within a factor of 60.
        steps: Number of bisections.

    Raises:
        UsageError: There is no such limit near the guess.
    """
    low = 0.8 * guess
    high = 1.25 * guess
    for _ in range(_WIDENINGS):
        if not is_stable(low):
            low, high = low / 1.5, low
        elif is_stable(high):
            low = high
            high = 1.5 * high
        else:
            break
    else:
        remedy = f"Guess a value between {low:.2g} and {high:.2g}, or check whether anything is stable at all"
        raise UsageError("no stability limit near the guess", value=guess, remedy=remedy)
    for _ in range(steps):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if is_stable(middle) else (low, middle)
    return math.sqrt(low * high)


@dataclass(frozen=True, eq=False)
class ForceLoop:
    """A robot in contact as a linear plant of its joints, around which a controller closes a sampled loop.

    Attributes:
        tick: Period of the loop [s].
        moved: (3 n, 3 n) change in a tick of joint offsets, their speeds and the target posture.
        stiffness: Stiffness of the contact at the goal [N/m].
        push: (n,) joint velocity that moves the contact point outward at 1 m/s, without lateral motion.
        outward: (n,) outward motion of the point per joint offset [m/rad].
        shown: (3 n,) force of the reading at the end of a tick over the stiffness [m], per state at its start.
    """

    tick: float
    moved: FloatArray
    stiffness: float
    push: FloatArray
    outward: FloatArray
    shown: FloatArray

    @staticmethod
    def of_joints(
        tick: float,
        inertia: FloatArray,
        servo: FloatArray,
        damping: FloatArray,
        stiffness: float,
        push: FloatArray,
        outward: FloatArray,
        *,
        averaged: bool,
        relaxation: float = 0.0,
    ) -> ForceLoop:
        """Return the loop of joints under servos, with a point that presses on a layer.

        Args:
            tick: Period of the loop [s].
            inertia: (n, n) mass matrix.
            servo: (n,) stiffness of the servos.
            damping: (n,) damping of the servos and of the joints themselves.
            stiffness: See the attributes.
            push: See the attributes.
            outward: See the attributes.
            averaged: Whether a reading is the mean over the tick instead of the value at its end.
            relaxation: Damping over stiffness of the layer [s]; its force is that of  depth + relaxation * speed.
        """
        n = len(push)
        size = 3 * n
        layer = stiffness * np.outer(outward, outward)
        held = np.diag(servo)
        block = np.zeros((2 * size, 2 * size))
        block[:n, n : 2 * n] = np.eye(n)
        forces = [-held - layer, -np.diag(damping) - relaxation * layer, held]
        block[n : 2 * n, :size] = np.linalg.solve(inertia, np.hstack(forces))
        block[:size, size:] = np.eye(size)
        over_tick = expm(tick * block)  # the upper right block is the integral over the tick (Van Loan 1978)
        moved = over_tick[:size, :size]
        reading = over_tick[:size, size:] / tick if averaged else moved
        shown = outward @ reading[:n] + relaxation * outward @ reading[n : 2 * n]
        return ForceLoop(tick, moved, stiffness, push, outward, shown)

    def stable(self, controller: Filter) -> bool:
        """Whether force errors decay under a controller; offsets that cause no force may remain."""
        size = len(self.moved) + 3
        step = np.stack([self._step(controller, unit) for unit in np.eye(size)], axis=1)
        kept = np.arange(size) != (size - 1 if math.isinf(controller.integral_time) else size)
        return bool(np.abs(np.linalg.eigvals(step[np.ix_(kept, kept)])).max() < 1 + _SLACK)

    def _step(self, controller: Filter, state: FloatArray) -> FloatArray:
        joints = len(self.push)
        plant, (read, speed, gathered) = state[:-3].copy(), state[-3:]
        away = float(self.outward @ plant[:joints])
        error = -self.stiffness * read
        gathered = gathered + self.tick * error
        aim = controller.gain * (error + gathered / controller.integral_time)
        aim -= controller.position_gain * away
        speed = (
            speed + self.tick / controller.inertia_time * (aim - speed) if controller.inertia_time > self.tick else aim
        )
        plant[2 * joints :] += self.tick * speed * self.push
        return np.concatenate([self.moved @ plant, [self.shown @ plant, speed, gathered]])


def force_loop_at_goal(setup: PathSetup, settings: ControlSettings) -> ForceLoop:
    """Return the loop about the posture in which the goal is held.

    Raises:
        SkinError: There is no contact.
    """
    session = settled_session(setup, settings)
    if not session.frame.regions:
        raise SkinError("no contact with the skin", place=setup.prepared.scene.name)
    region = session.frame.regions[0]
    robot = setup.prepared.robot
    configuration = Configuration(robot)
    configuration.update(session.frame.posture)
    servo = posture_loop(configuration).about(configuration.posture)
    normal = configuration.pose(region.link).rotation @ region.link_normal
    move = configuration.jacobian(region.link, region.link_position)
    outward = normal @ move
    push = np.linalg.pinv(move, rcond=1e-6) @ normal
    stiffness = contact_stiffness(setup, session.frame.posture, push)
    inertia, damping = _dynamics(setup, session.frame.posture)
    return ForceLoop.of_joints(
        setup.prepared.scene.tick,
        inertia,
        servo.stiffness,
        servo.damping + damping,
        stiffness,
        push,
        outward,
        averaged=setup.effects.time_averaging,
        relaxation=RELAXATION if setup.effects.skin == "foundation" else 0.0,
    )


def contact_stiffness(setup: PathSetup, posture: FloatArray, push: FloatArray) -> float:
    """Return the increase of force per motion of the contact point along its normal with fixed joints [N/m].

    Measured from force and penetration of the foundation at two postures near the given one. A formula would depend on
    the curvature of the skin there and on everything else that is touched. The stiffness of the solver's own contacts
    is that of the layer in any posture.

    Args:
        setup: Robot and object in contact.
        posture: (n,) posture in contact.
        push: (n,) joint velocity that moves the contact point outward at 1 m/s, without lateral motion.
    """
    prepared = setup.prepared
    scene = prepared.scene
    physics = Physics(prepared.robot, prepared.skin, setup.effects, prepared.objects, scene.layer)
    foundation = physics.touch
    if not isinstance(foundation, FoundationModel):
        return scene.layer.stiffness

    def force(way: float) -> float:
        physics.start(posture + way * push)
        return sum(float(np.linalg.norm(wrench.force)) for wrench in foundation.wrenches)

    return (force(_PROBED) - force(-_PROBED)) / (2 * _PROBED)


def settled_session(setup: PathSetup, settings: ControlSettings) -> Session:
    """Return a session whose force has settled at its goal."""
    session = setup.session(settings)
    for _ in range(round(REST / setup.prepared.scene.tick)):
        session.tick()
    return session


def controller_filter(settings: ControlSettings) -> Filter:
    """Return the linear filter of a controller along the contact normal."""
    loop = LoopFilter.of(settings)
    return Filter(settings.force_gain, loop.integral_time, loop.position_gain, loop.inertia_time)


def predicted_gain_limit(loop: ForceLoop, settings: ControlSettings) -> float:
    """Return the force gain at the onset of oscillation [m/s/N]."""
    controller = controller_filter(settings)
    return stability_limit(lambda gain: loop.stable(replace(controller, gain=gain)), _GUESS)


def _dynamics(setup: PathSetup, posture: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Inertia matrix (n, n) of the robot in a posture, and the damping of its joints (n,)."""
    robot = setup.prepared.robot
    model = compile_spec(robot_spec(robot), source=robot.source)
    data = mujoco.MjData(model)
    inertia = np.zeros((model.nv, model.nv))
    data.qpos[:] = posture
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, inertia)
    return inertia, np.array(model.dof_damping)
