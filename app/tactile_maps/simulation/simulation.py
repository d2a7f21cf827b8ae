"""Simulation of one scene: a robot under impedance commands, objects, fingers, and the readings of the skin.

When effects change during a run, the state is transferred to the new model by joint name, including that of objects
that are removed and added again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import mujoco
import numpy as np

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray
from tactile_maps.core.errors import SimulationError
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.objects import SceneObject
from tactile_maps.simulation.contact_loads import add_loads
from tactile_maps.simulation.fingers import Fingers
from tactile_maps.simulation.model.object_geoms import initial_pose
from tactile_maps.simulation.physics import Physics
from tactile_maps.simulation.robot_contacts import RobotContacts
from tactile_maps.simulation.step_checks import ImpedanceCommand, check_command
from tactile_maps.skin.model.bare_surface import with_bare_points
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.contact_notes import ContactNote
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Load
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS, WITH_SHEAR, ContactModel, receptive_field
from tactile_maps.tactile.models.foundation import FoundationModel
from tactile_maps.tactile.models.point import PointModel
from tactile_maps.tactile.models.shear import ShearLoad, ShearModel
from tactile_maps.tactile.models.water_fill import WaterFillModel
from tactile_maps.tactile.poke import PokeInput, PokePressed, PokeState
from tactile_maps.tactile.sensors.sensor_chain import SensorChain
from tactile_maps.tactile.sensors.sensor_effects import ALIVE, Readout, SensorEffects, axis_matrices

_POSITIONS = {mujoco.mjtJoint.mjJNT_FREE: 7, mujoco.mjtJoint.mjJNT_BALL: 4}
_VELOCITIES = {mujoco.mjtJoint.mjJNT_FREE: 6, mujoco.mjtJoint.mjJNT_BALL: 3}


@dataclass(frozen=True, eq=False)
class JointState(ArrayFields):
    """State of a joint at one instant.

    Attributes:
        position: Coordinates [rad, m].
        velocity: Velocity [rad/s, m/s].
        acceleration: Acceleration of the last step, the initial guess of the solver.
    """

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray

    @property
    def at_rest(self) -> JointState:
        """The state without motion."""
        return JointState(self.position, 0 * self.velocity, 0 * self.acceleration)


def joint_states(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, JointState]:
    """Return the states of all joints by name."""
    states = {}
    for joint in range(model.njnt):
        at, way = _slices(model, joint)
        states[model.joint(joint).name] = JointState(data.qpos[at], data.qvel[way], data.qacc_warmstart[way])
    return states


def restore_joint_states(physics: Physics, states: Mapping[str, JointState], time: float) -> None:
    """Set the states of joints and the time; other joints are unchanged.

    Args:
        physics: Physics to change, in any state.
        states: States by joint name.
        time: Simulated time [s].
    """
    model = physics.model
    data = physics.data
    data.time = time
    warm = np.zeros(model.nv)
    for joint in range(model.njnt):
        state = states.get(model.joint(joint).name)
        if state is not None:
            at, way = _slices(model, joint)
            data.qpos[at] = state.position
            data.qvel[way] = state.velocity
            warm[way] = state.acceleration
    physics.forward()
    data.qacc_warmstart[:] = warm


def _slices(model: mujoco.MjModel, joint: int) -> tuple[slice, slice]:
    """Slices of the joint's coordinates in ``qpos`` and ``qvel``."""
    kind = mujoco.mjtJoint(int(model.jnt_type[joint]))
    at = int(model.jnt_qposadr[joint])
    way = int(model.jnt_dofadr[joint])
    return slice(at, at + _POSITIONS.get(kind, 1)), slice(way, way + _VELOCITIES.get(kind, 1))


SensorStage: TypeAlias = Callable[[FloatArray], FloatArray]
_COVER = ElasticLayer()
_STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION)


class Simulation:
    """Simulation of a robot with its skin. Mutable; ``reset`` restarts it.

    It is deterministic: the same calls give the same numbers, bit for bit.

    Args:
        robot: The robot.
        skin: Its skin.
        effects: Effects to simulate; ``use`` changes them during a run.
        objects: Objects of the scene.
        layer: The skin's cover.
        tick: Time between readings of the skin [s].
        seed: Seed of the sensor's random numbers.
        frames: Function that returns the axes t1, t2 and n of each taxel in its link's frame, (taxels, 3, 3); called
            when shear is switched on, which needs it.

    Raises:
        RobotError: MuJoCo refuses the model.
        MeshError: A mesh object is not a solid.
    """

    def __init__(
        self,
        robot: Robot,
        skin: Skin,
        effects: Effects,
        *,
        objects: Sequence[SceneObject] = (),
        layer: ElasticLayer = _COVER,
        tick: float = 0.005,
        seed: int = 0,
        frames: Callable[[], FloatArray] | None = None,
    ) -> None:
        self._robot = robot
        self._skin = skin
        self._frames = frames
        self._effects = effects
        self._objects = tuple(objects)
        self._layer = layer
        self._tick = tick
        self._seed = seed
        self._physics = Physics(robot, skin, effects, self._objects, layer)
        averages = effects.time_averaging
        self._fingers = Fingers(self._model, skin, layer, yields=effects.dynamics, averages=averages)
        self._fingers.friction = layer.friction if effects.shear else 0.0
        self._touch: ContactModel | None = None
        self._touch = self._build_touch(self._physics, effects)
        self._chain: SensorChain | None = None
        self._axes: FloatArray | None = None
        self._mixed: FloatArray | None = None
        self._shear_chains: tuple[SensorChain, ...] = ()
        self._contact_search: RobotContacts | None = None  # built on first use
        self._use_sensor(effects)
        self.reset()

    def reset(self) -> None:
        """Restore the initial state: robot and objects at rest as in the scene, no fingers, time zero, a new sensor."""
        self._command: ImpedanceCommand | None = None
        self._drive_torque: FloatArray | None = None
        self._left: dict[str, JointState] = {}
        self._left_poses: dict[str, FloatArray] = {}
        self._fingers.reset()
        self._physics.start(self._robot.home)
        if (shear := self._shear) is not None:
            shear.reset()
        for chain in self._chains:
            chain.reset()

    def apply(self, poke: PokeInput) -> None:
        """Press, move or release a finger, from the next step on.

        Raises:
            SimulationError: The place is not on the skin, the finger is too stiff, or fingers are off.
        """
        if self._effects.fingers:
            self._physics.refresh()
            self._fingers.apply(self._data, poke)
        elif isinstance(poke, PokePressed):
            remedy = "Switch the effect fingers on"
            raise SimulationError(
                "fingers are off, so the skin cannot be poked", value=f"finger {poke.id}", remedy=remedy
            )

    def step(self, count: int, command: ImpedanceCommand) -> None:
        """Advance ``count`` time steps under one command.

        Args:
            count: Number of steps.
            command: Posture, stiffness, damping and added torque for each joint.

        Raises:
            SimulationError: The command is not finite, the simulation diverged, or the layer is too stiff; the state is
                then the last good one.
        """
        if command is not self._command:
            check_command(self._robot, command)
            self._physics.apply_command(command)
            self._command = command
        self._fingers.begin()
        fingers = self._fingers.push if len(self._fingers) else None
        if self._effects.dynamics:
            before = self.posture, self.velocity
            self._physics.step(count, fingers)
            self._drive_torque = self._mean_torque(*before, command, count)
        else:
            self._drive_torque = None
            self._physics.pose_at(command.posture, count, fingers)

    def use(self, effects: Effects) -> None:
        """Change the effects and keep the state of joints (by name), fingers and sensor.

        An object that takes no part in contacts any more keeps its pose until it does again.

        Raises:
            RobotError: MuJoCo refuses the model. After any of these errors nothing is changed.
            MeshError: A mesh object is not a solid.
            SimulationError: A finger is too stiff for the new time step.
        """
        old = self._physics
        physics = self._physics
        touch = self._touch
        if _physics_effects(effects) != _physics_effects(self._effects):
            physics = self._carried(effects)
        if physics is not old or _contact_model_effects(effects) != _contact_model_effects(self._effects):
            touch = self._build_touch(physics, effects)
        if physics is not old:
            averages = effects.time_averaging
            self._fingers.use(physics.model, physics.data, yields=effects.dynamics, averages=averages)
            self._leave_behind(physics)
        self._fingers.friction = self._layer.friction if effects.shear else 0.0
        if not effects.fingers:
            self._fingers.reset()
        self._physics = physics
        self._touch = touch
        self._effects = effects
        physics.felt = effects.skin != "off"
        self._contact_search = None
        self._use_sensor(effects)

    def touching(self, posture: FloatArray) -> str:
        """Return the contacts that the robot would have in ``posture`` (n,), in words; empty without contact.

        Cost: 0.1 ms; after a change of effects also that of assembling the model.
        """
        if self._contact_search is None:
            self._contact_search = RobotContacts(self._robot, self._skin, self._effects, self._objects, self._layer)
        return self._contact_search.words(joint_states(self._model, self._data), posture)

    def place(self, posture: FloatArray) -> None:
        """Put the robot into ``posture`` (n,) at rest. It must not touch anything there."""
        data = self._data
        count = len(self._robot.joints)
        data.qpos[:count] = posture
        data.qvel[:count] = 0.0
        data.qacc_warmstart[:count] = 0.0
        self._drive_torque = None
        self._physics.forward()

    def sense(self) -> FloatArray:
        """(taxels,) readings [Pa] for the loads of the last step; zeros without a skin model.

        With time averaging they are for the mean loads of the last call of ``step``.
        """
        pressures = np.zeros(len(self._skin))
        for _, read in self.readings:
            pressures = read(pressures)
        return pressures

    @property
    def readings(self) -> tuple[tuple[str, SensorStage], ...]:
        """Stages of one reading by name; each takes the pressures (taxels,) [Pa] of the previous one.

        The first, ``touch``, reads the loads and ignores its argument. Call all in order, once a tick. Empty without a
        skin model.
        """
        touch = self._touch
        if touch is None:
            return ()
        first = ("touch", lambda _: self._measured(touch.pressures(self.loads)))
        return (first, *(self._chain.stages if self._chain else ()))

    def turn_frames(self) -> None:
        """Read the axes of the taxels again, because the map has changed."""
        if self._shear is not None and self._frames is not None:
            self._shear.frames = self._frames()

    @property
    def shear(self) -> FloatArray | None:
        """(taxels, 2) true traction along t1 and t2 of each taxel at the last reading [Pa]; None without shear."""
        return None if self._shear is None else self._shear.tractions

    def sense_shear(self) -> FloatArray | None:
        """Return the shear (taxels, 2) that the sensor reads at the last reading [Pa]; None without shear.

        Call it once a tick, after the readings of the pressure.
        """
        felt = self.shear if self._mixed is None or self.shear is None else self._mixed
        if felt is None or not self._shear_chains:
            return felt
        columns = zip(self._shear_chains, np.ascontiguousarray(felt.T), strict=True)
        return np.column_stack([chain.read(column) for chain, column in columns])

    @property
    def sheared(self) -> tuple[ShearLoad, ...]:
        """True loads with friction at the last reading, and how much of the skin under them sticks."""
        return () if self._shear is None else self._shear.loads

    @property
    def effects(self) -> Effects:
        """Effects that are simulated."""
        return self._effects

    @property
    def notes(self) -> tuple[ContactNote, ...]:
        """Notes of the physics and of the contact model."""
        of_shear = () if self._shear is None else self._shear.notes
        return (*self._physics.notes, *(self._touch.notes if self._touch else ()), *of_shear)

    @property
    def broken_taxels(self) -> BoolArray:
        """(taxels,) True for dead or stuck taxels."""
        return np.zeros(len(self._skin), dtype=bool) if self._chain is None else self._chain.dead != ALIVE

    @property
    def object_poses(self) -> FloatArray:
        """(k, 4, 4) ``T_world_object`` of every object; one that is not in the physics keeps its pose."""
        poses = np.zeros((len(self._objects), 4, 4))
        for row, scene_object in zip(poses, self._objects, strict=True):
            pose = self._physics.pose(scene_object.spec.name)
            row[:] = (
                self._left_poses.get(scene_object.spec.name, initial_pose(scene_object.spec)) if pose is None else pose
            )
        return poses

    @property
    def pokes(self) -> tuple[PokeState, ...]:
        """States of all fingers on the skin."""
        self._physics.refresh()
        return self._fingers.states(self._data)

    @property
    def loads(self) -> tuple[Load, ...]:
        """True loads on the skin at the last step, fingers first, without effects of the sensor.

        With time averaging they are the mean over the steps of the last call of ``step``.
        """
        return (*self._fingers.loads(), *self._physics.loads())

    @property
    def total_normal_force(self) -> float:
        """Sum of the normal forces on the skin at the last step [N], each along its own normal.

        Where the contact model computes the forces, it is the sum of their magnitudes, because they have no friction.
        With time averaging it is the mean over the steps of the last call of ``step``.
        """
        pushed = self._touch.total_force if isinstance(self._touch, FoundationModel) else 0.0
        return sum(load.force for load in self.loads) + pushed

    def wrenches(self) -> dict[str, FloatArray]:
        """Return the contact wrench (6,) on each link with skin at the last step, fingers included.

        Force [N] and torque [N m] about the link's origin, link frame; see ``contact_loads``. With time averaging it is
        the mean over the steps of the last call of ``step``.
        """
        wrenches = self._physics.wrenches()
        add_loads(wrenches, self._fingers.loads())
        return wrenches

    def sum_wrenches(self, on: bool) -> None:
        """Set whether ``wrenches`` follow time averaging. Off saves 20 µs a contact and step if they are not read."""
        self._physics.sums_wrenches = on

    @property
    def posture(self) -> FloatArray:
        """(n,) joint positions of the robot [rad or m]."""
        return self._data.qpos[: len(self._robot.joints)].copy()

    @property
    def velocity(self) -> FloatArray:
        """(n,) joint velocities of the robot [rad/s or m/s]."""
        return self._data.qvel[: len(self._robot.joints)].copy()

    @property
    def drive_torque(self) -> FloatArray | None:
        """(n,) mean torque of the robot's drives in the last call of ``step`` [N m, or N for a slide].

        It is what torque sensors in the joints would read, without the torque that compensates gravity. None before the
        first step and without dynamics.
        """
        return self._drive_torque

    @property
    def time(self) -> float:
        """Simulated time since the reset [s]."""
        return float(self._data.time)

    @property
    def timestep(self) -> float:
        """Time step of the physics [s]."""
        return float(self._model.opt.timestep)

    def state(self) -> FloatArray:
        """Complete state as one vector: MuJoCo, fingers, sensor, and objects outside the physics."""
        state = np.zeros(mujoco.mj_stateSize(self._model, _STATE))
        mujoco.mj_getState(self._model, self._data, state, _STATE)
        aside = [joint.position for joint in self._left.values()]
        sensor = [chain.state() for chain in self._chains]
        shear = [] if self._shear is None else [self._shear.numbers()]
        return np.concatenate([state, self._fingers.numbers(), *sensor, *shear, *aside])

    @property
    def _shear(self) -> ShearModel | None:
        touch = self._touch
        return touch.shear if isinstance(touch, PointModel | WaterFillModel) else None

    @property
    def _chains(self) -> tuple[SensorChain, ...]:
        """Chains of all channels that have any stage."""
        return () if self._chain is None else (self._chain, *self._shear_chains)

    @property
    def _model(self) -> mujoco.MjModel:
        return self._physics.model

    @property
    def _data(self) -> mujoco.MjData:
        return self._physics.data

    def _mean_torque(
        self, posture: FloatArray, velocity: FloatArray, command: ImpedanceCommand, count: int
    ) -> FloatArray:
        """(n,) mean torque of ``count`` steps under ``command`` that began in ``posture`` with ``velocity``.

        A step uses the spring's torque at its start and the damper's at its end; Euler uses both at the start.
        """
        speed = (self.posture - posture) / (count * self.timestep)
        middle = 0.5 * (posture + self.posture) - 0.5 * self.timestep * speed
        if self._effects.integrator == "euler":
            speed = speed - (self.velocity - velocity) / count
        spring = command.stiffness * (command.posture - middle)
        return np.asarray(spring - command.damping * speed + command.torque)

    def _carried(self, effects: Effects) -> Physics:
        """Return physics with other effects in the present state; objects that come back are at rest."""
        physics = Physics(self._robot, self._skin, effects, self._objects, self._layer)
        physics.sums_wrenches = self._physics.sums_wrenches
        if self._command is not None:
            physics.apply_command(self._command)
        states = {**self._left, **joint_states(self._model, self._data)}
        restore_joint_states(physics, states, self.time)
        return physics

    def _leave_behind(self, physics: Physics) -> None:
        """Store the states of objects that are not in the new physics."""
        here = joint_states(self._model, self._data)
        there = joint_states(physics.model, physics.data)
        poses = self.object_poses
        left = {**self._left, **{name: state.at_rest for name, state in here.items()}}
        self._left = {name: state for name, state in left.items() if name not in there}
        self._left_poses = {
            scene_object.spec.name: pose
            for scene_object, pose in zip(self._objects, poses, strict=True)
            if physics.pose(scene_object.spec.name) is None
        }

    def _build_touch(self, physics: Physics, effects: Effects) -> ContactModel | None:
        if effects.skin == "off":
            return None
        skin = with_bare_points(self._robot, self._skin)
        touch = physics.touch or CONTACT_MODELS[effects.skin].build(skin, self._layer, effects.sensor)
        if effects.shear and effects.skin in WITH_SHEAR and self._frames is not None:
            assert isinstance(touch, PointModel | WaterFillModel)
            touch.shear = ShearModel(skin, self._layer, receptive_field(skin, effects.sensor), self._frames())
            if self._shear is not None:
                touch.shear.resume(self._shear)
        return touch

    def _measured(self, pressures: FloatArray) -> FloatArray:
        """Return the pressures (taxels,) that the taxels' channels measure, and store the shear that they measure."""
        shear = self.shear
        if self._axes is None or shear is None:
            self._mixed = None
            return pressures
        channels = np.einsum("nij,nj->ni", self._axes, np.column_stack([shear, pressures]))
        self._mixed = channels[:, :2]
        return np.ascontiguousarray(channels[:, 2])

    def _use_sensor(self, effects: Effects) -> None:
        """Change the sensor's stages; those that stay on keep their state. No stage means no chain."""
        self._axes = axis_matrices(effects.sensor, Readout(self._skin, self._tick, self._seed))
        stages = effects.sensor.stages
        if effects.skin == "off" or stages == SensorEffects():
            self._chain = None
            self._shear_chains = ()
            return
        if self._chain is None:
            self._chain = self._made_chain(stages, 0)
        if self._shear is None:
            self._shear_chains = ()
        elif not self._shear_chains:
            self._shear_chains = tuple(self._made_chain(stages, channel) for channel in (1, 2))
        for chain in self._chains:
            chain.use(stages, averages=effects.time_averaging)

    def _made_chain(self, stages: SensorEffects, channel: int) -> SensorChain:
        return SensorChain(self._skin, stages, tick=self._tick, seed=self._seed, channel=channel)


def _physics_effects(effects: Effects) -> Effects:
    """Return the part of the effects that the model depends on."""
    inside = effects.skin in ("foundation", "depth")
    sensor = replace(SensorEffects(), area_averaging=effects.sensor.area_averaging if inside else None)
    return replace(effects, sensor=sensor, fingers=True, skin=effects.skin if inside else "off")


def _contact_model_effects(effects: Effects) -> tuple[object, ...]:
    """Return the part of the effects that the contact model depends on."""
    return effects.skin, effects.sensor.area_averaging
