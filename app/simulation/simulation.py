"""One scene simulated: an arm under impedance commands, things around it, hands on it, and what its skin reports."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeAlias

import mujoco
import numpy as np

from app.arrays import FloatArray
from app.errors import SimulationError
from app.robots.robot import Robot
from app.scene.effects import Effects
from app.scene.objects import Body
from app.simulation.carry_state import JointState, joint_states, restore
from app.simulation.fingers import Fingers
from app.simulation.guard import check_command
from app.simulation.impedance import Impedance
from app.simulation.link_wrenches import add_loads
from app.simulation.object_geoms import rest_pose
from app.simulation.physics import Physics
from app.skin.skin import Skin
from app.touch.layer import Layer
from app.touch.load import Load
from app.touch.models.foundation import Foundation
from app.touch.models.model import ContactModel
from app.touch.models.table import MODELS
from app.touch.poke import PokeInput, PokePressed, PokeState
from app.touch.sensor.chain import SensorChain
from app.touch.sensor.effects import SensorEffects

Reading: TypeAlias = Callable[[FloatArray], FloatArray]
_COVER = Layer()
_STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION)


class Simulation:
    """One robot with one skin. Mutable; ``reset`` starts again. Deterministic: same calls, same numbers, bit for bit.

    Args:
        robot: The robot.
        skin: Its skin.
        effects: What to simulate; ``use`` changes it live.
        objects: What else is there.
        layer: What the skin's cover is made of.
        tick: From one reading of the skin to the next [s].
        seed: Of what is random in the sensor.

    Raises:
        RobotError: MuJoCo refuses the model.
        MeshError: A mesh object is no solid.
    """

    def __init__(
        self,
        robot: Robot,
        skin: Skin,
        effects: Effects,
        *,
        objects: Sequence[Body] = (),
        layer: Layer = _COVER,
        tick: float = 0.005,
        seed: int = 0,
    ) -> None:
        self._robot, self._skin, self._effects = robot, skin, effects
        self._objects, self._layer, self._tick, self._seed = tuple(objects), layer, tick, seed
        self._physics = Physics(robot, skin, effects, self._objects, layer)
        self._fingers = Fingers(self._model, skin, layer, yields=effects.dynamics)
        self._touch = self._build_touch(self._physics, effects)
        self._chain: SensorChain | None = None
        self._use_sensor(effects)
        self.reset()

    def reset(self) -> None:
        """The robot at home and at rest, objects where the scene has them, no fingers, time zero, a fresh sensor."""
        self._command: Impedance | None = None
        self._left: dict[str, JointState] = {}
        self._left_poses: dict[str, FloatArray] = {}
        self._fingers.reset()
        self._physics.start(self._robot.home)
        if self._chain is not None:
            self._chain.reset()

    def apply(self, poke: PokeInput) -> None:
        """Let a hand do something, from the next step on.

        Raises:
            SimulationError: There is no such place, the finger is too stiff, or fingers are off.
        """
        if self._effects.fingers:
            self._physics.refresh()
            self._fingers.apply(self._data, poke)
        elif isinstance(poke, PokePressed):
            remedy = "Switch the effect fingers on"
            raise SimulationError("nobody can poke here", value=f"finger {poke.id}", remedy=remedy)

    def step(self, count: int, command: Impedance) -> None:
        """Advance ``count`` time steps under one command.

        Args:
            count: How many.
            command: Posture, stiffness, damping and added torque for each joint.

        Raises:
            SimulationError: The command holds something that is no number, the state left the numbers that mean
                something, or the layer is too stiff; the state is then the last good one.
        """
        if command is not self._command:
            check_command(self._robot, command)
            self._physics.take(command)
            self._command = command
        hand = self._fingers.push if len(self._fingers) else None
        if self._effects.dynamics:
            self._physics.step(count, hand)
        else:
            self._physics.pose_at(command.posture, count, hand)

    def use(self, effects: Effects) -> None:
        """Simulate with other effects from now on. The state stays: joints by name, fingers, what the sensor remembers.

        An object that nothing can touch any more stands where it was left until something can.

        Raises:
            RobotError: MuJoCo refuses the model; nothing changed then, as with the others.
            MeshError: A mesh object is no solid.
            SimulationError: A finger is too stiff for the new time step.
        """
        old, physics, touch = self._physics, self._physics, self._touch
        if _of_physics(effects) != _of_physics(self._effects):
            physics = self._carried(effects)
        if physics is not old or _of_touch(effects) != _of_touch(self._effects):
            touch = self._build_touch(physics, effects)
        if physics is not old:
            self._fingers.use(physics.model, physics.data, yields=effects.dynamics)
            self._leave_behind(physics)
        if not effects.fingers:
            self._fingers.reset()
        self._physics, self._touch, self._effects = physics, touch, effects
        self._use_sensor(effects)

    def sense(self) -> FloatArray:
        """(taxels,) what the taxels report [Pa] of the last step's loads; zeros without a skin model."""
        pressures = np.zeros(len(self._skin))
        for _, read in self.readings:
            pressures = read(pressures)
        return pressures

    @property
    def readings(self) -> tuple[tuple[str, Reading], ...]:
        """The stages of one reading by name, each from the pressures (taxels,) [Pa] of the one before.

        The first, ``touch``, asks the physics and takes no notice of what it is given. To be called in turn, once a
        tick. Empty without a skin model.
        """
        if self._touch is None:
            return ()
        return (("touch", self._feel), *(self._chain.stages if self._chain else ()))

    @property
    def effects(self) -> Effects:
        """What is simulated."""
        return self._effects

    @property
    def notes(self) -> tuple[str, ...]:
        """What is not as it should be, for people: how meshes touch, what the contact model had to do instead."""
        return (*self._physics.notes, *(self._touch.notes if self._touch else ()))

    @property
    def object_poses(self) -> FloatArray:
        """(k, 4, 4) ``T_world_object`` of every object; one that the physics leaves out stands still."""
        poses = np.zeros((len(self._objects), 4, 4))
        for row, thing in zip(poses, self._objects, strict=True):
            pose = self._physics.pose(thing.spec.name)
            row[:] = self._left_poses.get(thing.spec.name, rest_pose(thing.spec)) if pose is None else pose
        return poses

    @property
    def pokes(self) -> tuple[PokeState, ...]:
        """All fingers on the skin."""
        self._physics.refresh()
        return self._fingers.states(self._data)

    @property
    def loads(self) -> tuple[Load, ...]:
        """All that truly presses the skin at the last step, fingers first, whatever the sensor makes of it."""
        return (*self._fingers.loads(), *self._physics.loads())

    @property
    def pressing(self) -> float:
        """How hard all of it presses the skin at the last step [N], each by the force along its own normal.

        Where the contact model makes the forces itself, the whole force of each: it knows no friction.
        """
        pushes = self._touch.pushes if isinstance(self._touch, Foundation) else ()
        return sum(load.force for load in self.loads) + sum(float(np.linalg.norm(push.force)) for push in pushes)

    def wrenches(self) -> dict[str, FloatArray]:
        """By link with skin, (6,) what all that touches it does to it at the last step, fingers included.

        Force [N] and torque [N m] about the link's origin, link frame; see ``link_wrenches``.
        """
        wrenches = self._physics.wrenches()
        add_loads(wrenches, self._fingers.loads())
        return wrenches

    @property
    def posture(self) -> FloatArray:
        """(n,) of the robot [rad, or m]."""
        return self._data.qpos[: len(self._robot.joints)].copy()

    @property
    def velocity(self) -> FloatArray:
        """(n,) of the robot [rad/s, or m/s]."""
        return self._data.qvel[: len(self._robot.joints)].copy()

    @property
    def time(self) -> float:
        """Simulated seconds since the reset."""
        return float(self._data.time)

    @property
    def timestep(self) -> float:
        """Of the physics [s]."""
        return float(self._model.opt.timestep)

    def state(self) -> FloatArray:
        """Everything the future depends on as one vector: of MuJoCo, the fingers, the sensor, and what stands aside."""
        state = np.zeros(mujoco.mj_stateSize(self._model, _STATE))
        mujoco.mj_getState(self._model, self._data, state, _STATE)
        aside = [joint.position for joint in self._left.values()]
        sensor = [self._chain.state()] if self._chain else []
        return np.concatenate([state, self._physics.numbers(), self._fingers.numbers(), *sensor, *aside])

    @property
    def _model(self) -> mujoco.MjModel:
        return self._physics.model

    @property
    def _data(self) -> mujoco.MjData:
        return self._physics.data

    def _feel(self, _: FloatArray) -> FloatArray:
        assert self._touch is not None
        return self._touch.pressures(self.loads)

    def _carried(self, effects: Effects) -> Physics:
        """The physics of other effects in the present state; objects that come back do so at rest."""
        physics = Physics(self._robot, self._skin, effects, self._objects, self._layer)
        if self._command is not None:
            physics.take(self._command)
        states = {**self._left, **joint_states(self._model, self._data)}
        restore(physics, states, self.time)
        return physics

    def _leave_behind(self, physics: Physics) -> None:
        """Remember where those objects are that the new physics does not have."""
        here, there = joint_states(self._model, self._data), joint_states(physics.model, physics.data)
        poses = self.object_poses
        left = {**self._left, **{name: state.at_rest for name, state in here.items()}}
        self._left = {name: state for name, state in left.items() if name not in there}
        self._left_poses = {
            thing.spec.name: pose
            for thing, pose in zip(self._objects, poses, strict=True)
            if physics.pose(thing.spec.name) is None
        }

    def _build_touch(self, physics: Physics, effects: Effects) -> ContactModel | None:
        if effects.skin == "off":
            return None
        return physics.touch or MODELS[effects.skin].build(self._skin, self._layer, effects.sensor)

    def _use_sensor(self, effects: Effects) -> None:
        """Keep what an effect that stays on remembers; without a stage there is no chain."""
        stages = replace(effects.sensor, area_averaging=None)
        if effects.skin == "off" or stages == SensorEffects():
            self._chain = None
        elif self._chain is None:
            self._chain = SensorChain(self._skin, stages, tick=self._tick, seed=self._seed)
        else:
            self._chain.use(stages)


def _of_physics(effects: Effects) -> Effects:
    """The part of the effects that needs another model."""
    inside = effects.skin in ("foundation", "depth")
    sensor = replace(SensorEffects(), area_averaging=effects.sensor.area_averaging if inside else None)
    return replace(effects, sensor=sensor, fingers=True, skin=effects.skin if inside else "off")


def _of_touch(effects: Effects) -> tuple[object, ...]:
    """The part of the effects that needs another contact model."""
    return effects.skin, effects.sensor.area_averaging
