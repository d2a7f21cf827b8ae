"""Checks of every step: the command before it, fast objects ahead of it, the state after it.

``check_command`` rejects an impedance command that is not finite, and ``unstable_servos`` notes servos that the
integrator cannot hold. ``TunnellingCheck`` stops a run before an object moves so far in one step that a contact could
be missed; afterwards it could not be detected. ``DivergenceGuard`` stops a run at the first invalid velocity and
reports the joint.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray, all_finite
from tactile_maps.core.errors import SimulationError
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.objects import SceneObject
from tactile_maps.simulation.model.model_names import body_name, is_hull, plain_name
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind


class ImpedanceCommand(Protocol):
    """Commanded joint motion, such as ``tactile_maps.control.motion.command.JointCommand`` (not imported here)."""

    @property
    def posture(self) -> FloatArray:
        """(n,) [rad]."""

    @property
    def stiffness(self) -> FloatArray:
        """(n,) [N m/rad]."""

    @property
    def damping(self) -> FloatArray:
        """(n,) [N m s/rad]."""

    @property
    def torque(self) -> FloatArray:
        """(n,) [N m]."""


MAX_SPEED = 1e3
"""Maximum joint speed [rad/s or m/s]: beyond any robot, but reached by a diverging integrator."""
_STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION)


class DivergenceGuard:
    """Check of one model's state for divergence, which keeps the last good state.

    The model must not reset itself on bad numbers (``mjDSBL_AUTORESET``), which would hide them.

    Args:
        model: The compiled model.
        data: Its state.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model = model
        self._data = data
        self._good = np.zeros(mujoco.mj_stateSize(model, _STATE))
        self._qvel = data.qvel
        self._limit = MAX_SPEED**2

    def keep(self) -> None:
        """Store the present state as the last good one. Cost: 0.5 µs."""
        mujoco.mj_getState(self._model, self._data, self._good, _STATE)

    def sound(self) -> bool:
        """Whether all joint velocities are finite and below ``MAX_SPEED``. Cost: 0.3 µs; 2 µs at high speeds.

        A position that is not finite follows from such a velocity.
        """
        # NaN compares false, so the test is for good values.
        if mujoco.mju_dot(self._qvel, self._qvel) <= self._limit:  # numpy would warn of an overflow
            return True
        return bool((np.abs(self._qvel) <= MAX_SPEED).all())

    def keep_if(self, check: Callable[[mujoco.MjData, int], None], data: mujoco.MjData) -> None:
        """Run ``check`` on the last step; if it fails, restore the state before the step.

        Raises:
            SimulationError: The error of the check.
        """
        try:
            check(data, 0)
        except SimulationError:
            self._back()
            raise

    def replay(self, step: Callable[[], None], count: int) -> None:
        """Repeat ``count`` steps one by one from the last good state, and stop at the first bad one.

        Args:
            step: Function that advances the physics by one step.
            count: Number of steps that were made in one call.

        Raises:
            SimulationError: The error of ``stop``.
        """
        self._back()
        for _ in range(count):
            self.keep()
            step()
            if not self.sound():
                self.stop()

    def stop(self) -> None:
        """Restore the state before the last step and raise an error about that step.

        Raises:
            SimulationError: Always; it states the first bad joint, its value, the simulated time and the energy before.
        """
        error = self._error()
        self._back()
        raise error

    def _back(self) -> None:
        mujoco.mj_setState(self._model, self._data, self._good, _STATE)

    def _error(self) -> SimulationError:
        model = self._model
        data = self._data
        dof = int(np.flatnonzero(~(np.abs(data.qvel) <= MAX_SPEED))[0])
        joint = model.joint(int(model.dof_jntid[dof]))
        position = data.qpos[joint.qposadr[0]]
        velocity = data.qvel[dof]
        time = data.time
        self._back()
        return SimulationError(
            "the simulation diverged",
            place=f"joint {plain_name(joint.name)} at {time:.3f} s",
            value=f"position {position:.3g}, velocity {velocity:.3g} a second, energy before {self._energy():.3g} J",
            remedy="Use softer gains, a softer finger or a smaller time step",
        )

    def _energy(self) -> float:
        """Kinetic energy [J] at the present state."""
        if not self._model.nv:
            return 0.0
        moved: FloatArray = np.zeros(self._model.nv)
        mujoco.mj_forward(self._model, self._data)
        mujoco.mj_mulM(self._model, self._data, moved, self._data.qvel)
        return 0.5 * float(self._data.qvel @ moved)


def check_command(robot: Robot, command: ImpedanceCommand) -> None:
    """Reject a command that is not finite.

    Args:
        robot: The robot.
        command: Command for its joints.

    Raises:
        SimulationError: A value is not finite; the error names the first such joint.
    """
    for name in ("posture", "stiffness", "damping", "torque"):
        values = getattr(command, name)
        if all_finite(values):
            continue
        for joint, value in zip(robot.joints, values, strict=True):
            if not math.isfinite(value):
                raise SimulationError(
                    "the controller's output is not finite",
                    place=f"joint {joint.name}",
                    value=f"{name} {value}",
                    remedy="Check the controller's inputs and gains",
                )


_GROWTH = 1e-6
"""Growth of a motion per step that is within rounding."""
_HALVINGS = 30


def unstable_servos(
    model: mujoco.MjModel, data: mujoco.MjData, stiffness: FloatArray, damping: FloatArray
) -> tuple[ContactNote, ...]:
    """Return notes on servos that the integrator cannot hold at this time step and posture.

    Semi-implicit Euler evaluates servos at the start of the step: beyond a limit the arm gains energy without contact,
    slowly at first. The other integrators evaluate the damping at the end of the step and are stable for all servos of
    the controllers.

    The test is the spectral radius of one integrator step of the linearised joints  M q'' + D q' + K q = 0  (Hairer and
    Wanner, Solving ODEs II, IV.2 and IV.3). Contacts have their own limit and are not included.

    Args:
        model: The compiled model; the robot's joints come first.
        data: Its state.
        stiffness: (n,) stiffness of the servos [N m/rad].
        damping: (n,) their damping [N m s/rad].

    Cost: none with an implicit integrator, otherwise 0.3 ms.
    """
    count = len(stiffness)
    if not count or model.opt.integrator != mujoco.mjtIntegrator.mjINT_EULER:
        return ()
    full = np.zeros((model.nv, model.nv))
    apart = mujoco.MjData(model)
    apart.qpos[:] = data.qpos  # derived quantities in ``data`` must stay those of the last step
    mujoco.mj_kinematics(model, apart)
    mujoco.mj_comPos(model, apart)
    mujoco.mj_makeM(model, apart)
    mujoco.mj_fullM(model, apart, full)
    inertia = full[:count, :count]
    passive = model.dof_damping[:count]
    step = float(model.opt.timestep)
    growth, mode = _growth(inertia, stiffness, damping, passive, step)
    if growth <= 1 + _GROWTH:
        return ()
    low = 0.0
    high = step
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        stable = _growth(inertia, stiffness, damping, passive, middle)[0] <= 1 + _GROWTH
        low, high = (middle, high) if stable else (low, middle)
    joint = plain_name(model.joint(int(np.abs(mode).argmax())).name)
    return (ContactNote(ContactNoteKind.UNSTABLE_SERVO, (joint,), max_timestep=low),)


def _growth(
    inertia: FloatArray, stiffness: FloatArray, damping: FloatArray, passive: FloatArray, step: float
) -> tuple[float, FloatArray]:
    """Return the largest growth factor of a motion per step, and the share of each joint (n,) in that motion."""
    count = len(stiffness)
    # Velocities are updated first; passive damping is implicit.
    mass = inertia + step * np.diag(passive)
    spring = -step * np.linalg.solve(mass, np.diag(stiffness))
    keep = np.linalg.solve(mass, inertia - step * np.diag(damping))
    values, vectors = np.linalg.eig(np.block([[np.eye(count) + step * spring, step * keep], [spring, keep]]))
    factors = np.abs(values)
    worst = int(factors.argmax())
    return float(factors[worst]), np.abs(vectors[count:, worst])


_UNBOUNDED_GEOMS = (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_HFIELD)
"""Geoms without a far side."""


@dataclass(frozen=True, eq=False)
class _MovingObject:
    """Movable object: name, body, slice of its velocities, bounding radius [m], and geoms that it may touch."""

    name: str
    body: int
    motion: slice
    reach: float
    others: IntArray


@dataclass(frozen=True, eq=False)
class _MovingLink:
    """Movable link with skin: name, body, half its smallest width [m], bounding radius [m] about its centre (3,) in the
    link's frame, and fixed geoms that it may touch."""

    name: str
    body: int
    half: float
    reach: float
    middle: FloatArray
    others: IntArray


class TunnellingCheck:
    """Check of the speed of movable objects, and of links with skin near fixed objects.

    A body that is first detected beyond the middle of another would be pushed out on the far side. (The foundation,
    whose links have no solid shape, checks its own layer.)

    Args:
        model: The compiled model.
        objects: Objects in the model.

    Attributes:
        needed: Whether any body could pass through another.
    """

    def __init__(self, model: mujoco.MjModel, objects: Sequence[SceneObject]) -> None:
        self._model = model
        self._half: FloatArray = model.geom_aabb[:, 3:].min(axis=1)
        bodies = [
            (scene_object.spec.name, int(model.body(body_name(scene_object.spec)).id)) for scene_object in objects
        ]
        self._movers = [self._mover(name, body) for name, body in bodies if model.body_dofnum[body]]
        fixed = [body for _, body in bodies if not model.body_dofnum[body]]
        self._links = _moving_links(model, np.flatnonzero(np.isin(model.geom_bodyid, fixed)))
        # No point of a robot is faster than this times the norm of its joint velocities.
        self._lever = math.sqrt(max(model.nv, 1)) * max(float(model.stat.extent), 1.0)
        self._thinnest = min((link.half + self._half[link.others].min() for link in self._links), default=math.inf)
        self.needed = bool(self._movers or self._links)

    def check(self, data: mujoco.MjData, count: int) -> None:
        """Check the next ``count`` steps at the present speeds; 0 checks the last step, before kinematics.

        Cost: 1.5 µs for each object that moves, and 0.5 µs for all links; 20 µs for each where the robot may be faster
        than the thinnest link and fixed object together allow.

        Raises:
            SimulationError: An object could pass through another on its way; nothing is changed.
        """
        step = self._model.opt.timestep
        for mover in self._movers:
            speed = float(np.linalg.norm(data.qvel[mover.motion]))
            if speed * step > mover.reach:
                self._look(data, mover, speed, count)
        if self._links and self._lever * step * math.sqrt(mujoco.mju_dot(data.qvel, data.qvel)) > self._thinnest:
            for link in self._links:
                self._look_at_link(data, link, count)

    def _look_at_link(self, data: mujoco.MjData, link: _MovingLink, count: int) -> None:
        step = self._model.opt.timestep
        motion = np.zeros(6)
        mujoco.mj_objectVelocity(self._model, data, mujoco.mjtObj.mjOBJ_XBODY, link.body, motion, 0)
        middle = data.xmat[link.body].reshape(3, 3) @ link.middle
        speed = float(
            np.linalg.norm(motion[3:] + np.cross(motion[:3], middle)) + np.linalg.norm(motion[:3]) * link.reach
        )
        thin = link.others[speed * step > link.half + self._half[link.others]]
        away = np.linalg.norm(data.geom_xpos[thin] - data.xpos[link.body] - middle, axis=1)
        near = thin[away <= self._model.geom_rbound[thin] + link.reach + speed * step * (count + 1)]
        if near.size:
            self._refuse(data, "a link", link.name, int(near[0]), speed, link.half)

    def _look(self, data: mujoco.MjData, mover: _MovingObject, speed: float, count: int) -> None:
        step = self._model.opt.timestep
        thin = mover.others[speed * step > mover.reach + self._half[mover.others]]
        away = np.linalg.norm(data.geom_xpos[thin] - data.xpos[mover.body], axis=1)
        # Poses are those before the last step.
        near = thin[away <= self._model.geom_rbound[thin] + mover.reach + speed * step * (count + 1)]
        if near.size:
            self._refuse(data, "an object", mover.name, int(near[0]), speed, mover.reach)

    def _refuse(self, data: mujoco.MjData, what: str, name: str, met: int, speed: float, half: float) -> None:
        longest = (half + float(self._half[met])) / speed
        other = plain_name(self._model.body(self._model.geom_bodyid[met]).name)
        raise SimulationError(
            f"{what} is too fast for the time step",
            place=f"{name} near {other} at {data.time:.3f} s",
            value=f"{speed:.3g} m/s, {1e3 * speed * self._model.opt.timestep:.3g} mm a step",
            remedy=f"It could pass through undetected: use a time step of at most {1e3 * longest:.2g} ms",
        )

    def _mover(self, name: str, body: int) -> _MovingObject:
        model = self._model
        first = int(model.body_dofadr[body])
        count = min(int(model.body_dofnum[body]), 3)
        own = model.geom_bodyid == body
        others = np.flatnonzero(~own & ~np.isin(model.geom_type, _UNBOUNDED_GEOMS))
        return _MovingObject(
            name, body, slice(first, first + count), float(model.geom_rbound[own].max(initial=0.0)), others
        )


def _moving_links(model: mujoco.MjModel, fixed: IntArray) -> list[_MovingLink]:
    """Return the movable links with skin, with those of the ``fixed`` geoms that have a far side."""
    solid = fixed[~np.isin(model.geom_type[fixed], _UNBOUNDED_GEOMS)]
    hulls = [geom for geom in range(model.ngeom) if is_hull(model.geom(geom).name)]
    return [
        _MovingLink(
            plain_name(model.body(int(model.geom_bodyid[geom])).name),
            int(model.geom_bodyid[geom]),
            float(model.geom_aabb[geom, 3:].min()),
            float(model.geom_rbound[geom]),
            model.geom_pos[geom].copy(),
            solid,
        )
        for geom in hulls
        if solid.size and model.body_weldid[model.geom_bodyid[geom]]
    ]
