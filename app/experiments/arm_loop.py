"""The force loop of a whole robot at a place it is pressed at: all joints, their coupled inertia, the posture loop.

What the theory of sampled loops leaves out of an arm: joints that move each other, a posture loop whose stiffness knows
of no coupling, and a contact that is as stiff as the pressed layer is at the goal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from scipy.linalg import expm

from app.arrays import FloatArray
from app.control.command import ControlChanged, ControlSettings
from app.control.gains import MIN_INERTIA
from app.control.reference import INNER_FREQUENCY
from app.errors import SkinError
from app.experiments.control_loops import grows
from app.experiments.control_setup import BALL, ControlSetup
from app.experiments.sampled_loop import Filter, onset
from app.robots.compile import compile_spec, robot_spec
from app.robots.configuration import Configuration
from app.session.session import Session

REST, WATCH = 1.5, 3.0
"""How long the force comes to rest before its goal is moved, and how long it is watched then [s]."""
_STEP = 0.05
_GUESS, _SLACK = 0.01, 1e-7


@dataclass(frozen=True, eq=False)
class ArmLoop:
    """A robot that is pressed, as a linear plant of its joints. Around it goes a law's sampled loop.

    Attributes:
        tick: Of the loop [s].
        moved: (3 n, 3 n) how offsets of joints, their speeds and the wanted posture go on in a tick.
        stiffness: Of the contact at the goal [N/m].
        push: (n,) joint velocity that moves the touched point outward at 1 m/s and not aside.
        outward: (n,) outward way of the point per offset of a joint [m/rad].
    """

    tick: float
    moved: FloatArray
    stiffness: float
    push: FloatArray
    outward: FloatArray

    def stable(self, law: Filter) -> bool:
        """Whether errors of the force die away under a law; offsets that press on nothing may stay."""
        size = len(self.moved) + 2
        step = np.stack([self._step(law, unit) for unit in np.eye(size)], axis=1)
        kept = np.arange(size) != (size - 1 if math.isinf(law.integral_time) else size)
        return bool(np.abs(np.linalg.eigvals(step[np.ix_(kept, kept)])).max() < 1 + _SLACK)

    def _step(self, law: Filter, state: FloatArray) -> FloatArray:
        joints = len(self.push)
        plant, (speed, gathered) = state[:-2].copy(), state[-2:]
        away = float(self.outward @ plant[:joints])
        error = -self.stiffness * away
        gathered = gathered + self.tick * error
        aim = law.gain * (error + gathered / law.integral_time)
        aim -= law.position_gain * away
        speed = speed + self.tick / law.inertia_time * (aim - speed) if law.inertia_time > self.tick else aim
        plant[2 * joints :] += self.tick * speed * self.push
        return np.concatenate([self.moved @ plant, [speed, gathered]])


def arm_loop(setup: ControlSetup, settings: ControlSettings) -> ArmLoop:
    """The loop about the posture in which the goal is held.

    Raises:
        SkinError: Nothing touches there.
    """
    session = rested(setup, settings)
    if not session.frame.regions:
        raise SkinError("nothing touches the skin there", place=setup.prepared.scene.name)
    region, robot = session.frame.regions[0], setup.prepared.robot
    configuration = Configuration(robot)
    servo = np.maximum(configuration.inertia(), MIN_INERTIA) * INNER_FREQUENCY**2
    configuration.update(session.frame.posture)
    normal = configuration.pose(region.link).rotation @ region.normal
    move = configuration.jacobian(region.link, region.point)
    outward = normal @ move
    # A ball on a bed of springs: F = pi K R depth², so dF = 2 sqrt(pi K R F) per way.
    stiffness = 2 * math.sqrt(math.pi * setup.prepared.scene.layer.foundation * BALL * settings.force_goal)
    inertia, damping = _dynamics(setup, session.frame.posture)
    n = len(servo)
    whole = np.zeros((3 * n, 3 * n))
    whole[:n, n : 2 * n] = np.eye(n)
    forces = [-np.diag(servo) - stiffness * np.outer(outward, outward), -np.diag(2 * servo / INNER_FREQUENCY + damping)]
    whole[n : 2 * n] = np.linalg.solve(inertia, np.hstack([*forces, np.diag(servo)]))
    tick = setup.prepared.scene.tick
    push = np.linalg.pinv(move, rcond=1e-6) @ normal
    return ArmLoop(tick, expm(whole * tick), stiffness, push, outward)


def rested(setup: ControlSetup, settings: ControlSettings) -> Session:
    """A session in which the force has come to its goal."""
    session = setup.session(settings)
    for _ in range(round(REST / setup.prepared.scene.tick)):
        session.tick()
    return session


def filter_of(settings: ControlSettings) -> Filter:
    """What a law is along the normal."""
    slow = settings.law in ("admittance", "parallel")
    return Filter(
        settings.force_gain,
        integral_time=math.inf if settings.law == "admittance" else settings.integral_time,
        position_gain=settings.position_gain if settings.law == "parallel" else 0.0,
        inertia_time=settings.inertia_time if slow else 0.0,
    )


def predicted_gain(loop: ArmLoop, settings: ControlSettings) -> float:
    """The force gain from which on the force swings [m/s/N]."""
    law = filter_of(settings)
    return onset(lambda gain: loop.stable(replace(law, gain=gain)), _GUESS)


def measured_gain(setup: ControlSetup, settings: ControlSettings, guess: float, *, steps: int = 4) -> float:
    """The same, found by trying: a small step of the goal dies away or grows.

    Args:
        setup: The robot beside its ball, its sensor exact.
        settings: Of the law; the force gain is tried.
        guess: Of the answer [m/s/N].
        steps: More are finer.
    """
    calm = replace(settings, gains="as_set", force_gain=0.3 * guess)

    def stable(gain: float) -> bool:
        session, forces = rested(setup, calm), []
        after = replace(settings, gains="as_set", force_gain=gain, force_goal=settings.force_goal + _STEP)
        session.submit(ControlChanged(after))
        for _ in range(round(WATCH / setup.prepared.scene.tick)):
            session.tick()
            forces.append(session.pressing - after.force_goal)
        return not grows(np.array(forces), 10 * _STEP)

    return onset(stable, guess, steps=steps)


def _dynamics(setup: ControlSetup, posture: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The robot's inertia matrix (n, n) at a posture, and its joints' own damping (n,)."""
    robot = setup.prepared.robot
    model = compile_spec(robot_spec(robot), source=robot.source)
    data, inertia = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    data.qpos[:] = posture
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, inertia)
    return inertia, np.array(model.dof_damping)
