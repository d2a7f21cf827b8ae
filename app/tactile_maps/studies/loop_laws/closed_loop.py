"""Closed loop of a controller with the plate of skin under a fixed ball, with ideal joints or simulated.

The ball is in the middle of the plate. Pressing is along z; moving the plate along x and y moves the ball on the map by
the same amount in the opposite direction. There is no friction. Readings have a constant period, are delayed by whole
periods, and are held in between; the controller runs at each tick.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from tactile_maps.contacts.detection.detection import ContactDetector
from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.controller_manager import ControllerManager
from tactile_maps.control.motion.command import ControlSettings, JointCommand
from tactile_maps.control.motion.observation import Observation
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import MapError
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.object_meshes import primitive_mesh
from tactile_maps.scene.objects import ObjectSpec, SceneObject
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.studies.loop_laws.gantry import Gantry, gantry
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.sensors.sensor_effects import Noise, Sampling, SensorEffects

IDEAL = math.inf
"""Servo frequency of joints that follow commands without delay."""
_RADIUS = 0.15
_FAST = 100.0

Settings = Callable[[int], ControlSettings]


@dataclass(frozen=True)
class Loop:
    """Plant and sensor of a closed loop.

    Attributes:
        period: Period of the readings of the skin [s].
        delay: Delay of the readings in periods.
        ticks: Controller ticks in a period.
        servo: Natural frequency of the posture loop [rad/s]; ``IDEAL`` for joints without inertia.
        lag: Time constant of ideal joints [s].
        stiffness: Stiffness of the contact [N/m].
        force: Initial contact force [N].
        noise: Standard deviation of the force reading of ideal joints [N], and of a taxel's pressure otherwise [Pa].
        stretch, turn: Map, see ``gantry``.
        seed: Seed of the noise.
    """

    period: float = 0.2
    delay: int = 0
    ticks: int = 1
    servo: float = IDEAL
    lag: float = 0.0
    stiffness: float = 2e4
    force: float = 3.0
    noise: float = 0.0
    stretch: float = 1.0
    turn: float = 0.0
    seed: int = 0

    @property
    def tick(self) -> float:
        """Duration of a tick [s]."""
        return self.period / self.ticks


@dataclass(frozen=True, eq=False)
class LoopResponse:
    """Response of a loop at each reading.

    Attributes:
        force: (k,) contact force [N].
        read: (k,) force reading from the skin [N]; zero without a contact.
        place: (k, 2) place of the contact on the map [m].
        error: (k,) distance of the contact from its goal on the map, as the controller sees it [m]; NaN without a goal.
    """

    force: FloatArray
    read: FloatArray
    place: FloatArray
    error: FloatArray


class _Plant(Protocol):
    @property
    def posture(self) -> FloatArray: ...

    @property
    def velocity(self) -> FloatArray: ...

    @property
    def force(self) -> float: ...

    def regions(self) -> tuple[ContactRegion, ...]: ...

    def move(self, command: JointCommand) -> None: ...


def run_loop(loop: Loop, settings: Settings, periods: int) -> LoopResponse:
    """Run the closed loop for a number of periods.

    Args:
        loop: Plant and sensor.
        settings: Returns the settings of the controller at each tick.
        periods: Number of periods.

    Cost: 0.2 ms a tick with ideal joints; simulated 0.4 ms and 5 µs a time step.
    """
    made = gantry(stretch=loop.stretch, turn=loop.turn)
    plant: _Plant = _IdealJoints(loop, made) if loop.servo == IDEAL else _SimulatedJoints(loop, made)
    manager = ControllerManager(made.robot, made.believed, settings(0))
    scale = np.array([loop.stretch**0.5, loop.stretch**-0.5])
    force = np.zeros(periods)
    read = np.zeros(periods)
    place = np.zeros((periods, 2))
    error = np.full(periods, np.nan)
    for tick in range(periods * loop.ticks):
        if settings(tick) != manager.settings:
            manager.settings = settings(tick)
        regions = plant.regions()
        command = manager.command(Observation(plant.posture, plant.velocity, regions, loop.tick))
        if tick % loop.ticks == 0:
            row = tick // loop.ticks
            report = manager.report
            force[row] = plant.force
            read[row] = regions[0].force if regions else 0.0
            place[row] = -plant.posture[:2] * scale
            error[row] = np.nan if report is None or report.error is None else report.error
        plant.move(command)
    return LoopResponse(force, read, place, error)


class _IdealJoints:
    """Joints without inertia against a spring, and exact readings of force and place of the contact."""

    def __init__(self, loop: Loop, made: Gantry) -> None:
        self._loop = loop
        self._made = made
        self._tick = 0
        self._noise = np.random.default_rng(loop.seed)
        self.posture = np.zeros(3)
        self.velocity = np.zeros(3)
        self._late: deque[ContactRegion] = deque(maxlen=loop.delay + 1)

    @property
    def force(self) -> float:
        return max(self._loop.force + self._loop.stiffness * float(self.posture[2]), 0.0)

    def regions(self) -> tuple[ContactRegion, ...]:
        if self._tick % self._loop.ticks == 0:
            seen = self._seen()
            self._late.extend([seen] * (1 if self._late else self._late.maxlen or 1))
        self._tick += 1
        late = self._late[0]
        return (late,) if late.force > 0 else ()

    def move(self, command: JointCommand) -> None:
        loop = self._loop
        share = 1.0 if loop.lag == 0 else -math.expm1(-loop.tick / loop.lag)
        before = self.posture
        self.posture = before + share * (command.posture - before)
        self.velocity = (self.posture - before) / loop.tick

    def _seen(self) -> ContactRegion:
        map_ = self._made.map
        believed = self._made.believed
        point = -self.posture[:2] * [self._loop.stretch**0.5, self._loop.stretch**-0.5]
        at = map_.to_body(point)
        if at is None:
            raise MapError("the ball has left the plate", value=point.tolist())
        read = self.force + (self._loop.noise * float(self._noise.standard_normal()) if self.force else 0.0)
        return ContactRegion(
            id=1,
            taxels=np.array([0]),
            force=read,
            area=1e-4,
            peak=1e4,
            map_point=point,
            at=at,
            link="plate",
            link_position=believed.skin.position(at),
            link_normal=believed.skin.normal(at),
        )


class _SimulatedJoints:
    """The plate in the physics engine, its joints held by the posture loop, read through the sensor's effects."""

    def __init__(self, loop: Loop, made: Gantry) -> None:
        self._loop = loop
        self._areas = made.skin.areas
        step = 5e-4 if loop.servo > _FAST else 1e-3
        sensor = SensorEffects(
            noise=Noise(loop.noise) if loop.noise else None,
            sampling=Sampling(1 / loop.period, loop.delay * loop.period),
        )
        effects = Effects(gravity="off", contact="environment", fingers=False, timestep=step, sensor=sensor)
        deep = loop.force / loop.stiffness
        ball = ObjectSpec("ball", "sphere", (_RADIUS,), at=(0.0, 0.0, _RADIUS - deep), friction=0.0)
        self._simulation = Simulation(
            made.robot,
            made.skin,
            effects,
            objects=(SceneObject(ball, primitive_mesh(ball)),),
            layer=ElasticLayer(stiffness=loop.stiffness),
            tick=loop.tick,
            seed=loop.seed,
        )
        self._detector = ContactDetector(made.believed)
        self._steps = round(loop.tick / step)
        self.force = 0.0

    @property
    def posture(self) -> FloatArray:
        return self._simulation.posture

    @property
    def velocity(self) -> FloatArray:
        return self._simulation.velocity

    def regions(self) -> tuple[ContactRegion, ...]:
        pressures = np.zeros(len(self._areas))
        for number, (_, read) in enumerate(self._simulation.readings):
            pressures = read(pressures)
            if number == 0:
                self.force = float(pressures @ self._areas)
        return self._detector.read(pressures)

    def move(self, command: JointCommand) -> None:
        self._simulation.step(self._steps, with_servo_frequency(command, self._loop.servo))


def with_servo_frequency(command: JointCommand, frequency: float) -> JointCommand:
    """Return the command with a critically damped posture loop of another natural frequency [rad/s]."""
    inertia = command.damping**2 / (4 * command.stiffness)  # of a critically damped loop
    return replace(command, stiffness=inertia * frequency**2, damping=2 * inertia * frequency)
