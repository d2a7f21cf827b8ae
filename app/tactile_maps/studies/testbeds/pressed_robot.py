"""A robot held at home, pressed by a probe, run at one time step: how it gives way, how the contact holds, what
stepping costs.

The same scene for whatever steps in time. The truth is a run with a time step of 0.05 ms by the one integrator that no
stiffness upsets.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import mujoco
import numpy as np

from tactile_maps.control.motion.command import JointCommand
from tactile_maps.control.motion.joint_impedance import joint_impedance
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import SimulationError, SkinError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.library import load_robot
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.effects import Effects, Integrator
from tactile_maps.scene.object_meshes import primitive_mesh
from tactile_maps.scene.objects import ObjectSpec, SceneObject
from tactile_maps.scene.stability import PROBE_MASS
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.model.model_names import body_name
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.skin.fitting.cover import CoverSpec, cover_robot
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer

PRESS_FORCE = 10.0
"""The probe's motors push so hard [N]."""
ARRIVED = 0.1
"""The probe's motors have come to their end by then [s]; the arm then gives way until it carries the force."""
_RADIUS = 0.012
_AWAY = 0.002
_BEYOND = 0.05
_FREQUENCY = 30.0
_DAMPING = 1.0
_ROOM = 0.01
_CANDIDATES = 400
"""The probe starts so far from other links [m]; so many taxels are looked at for that."""


@dataclass(frozen=True, eq=False)
class PressedRobot:
    """What the studies simulate.

    Attributes:
        robot: Our own arm.
        skin: On upper arm, forearm and hand.
        probe: A ball of 12 mm and 0.1 kg that presses with ``PRESS`` along an axis of the world.
        at: Where on the skin.
        command: Holds the arm at home.
    """

    robot: Robot
    skin: Skin
    probe: SceneObject
    at: SurfacePoint
    command: JointCommand


@lru_cache(maxsize=4)
def pressed_arm(taxels: int, seed: int = 0) -> PressedRobot:
    """The arm in so many taxels. Cost: 1 s at 1,000, kept."""
    robot = load_robot("arm")
    return press_robot(
        robot, cover_robot(robot, CoverSpec(("upper_arm", "forearm", "hand"), taxels=taxels, seed=seed)), "forearm"
    )


def press_robot(robot: Robot, skin: Skin, link: str = "") -> PressedRobot:
    """A robot held at home, with the probe beside its skin.

    Args:
        robot: Any.
        skin: Its skin.
        link: Which link is pressed; by default the one where skin faces an axis of the world best and is free.

    Raises:
        SkinError: Nothing there has skin.
    """
    configuration = Configuration(robot)
    number, axis = _place_to_press(robot, skin, configuration, link)
    at = skin.taxel_point(number)
    touched = configuration.pose(skin.link(at)).points(skin.position(at))
    way = [(seconds, *(touched + along * axis)) for seconds, along in
           ((0.0, _RADIUS + _AWAY), (ARRIVED, -_BEYOND), (3600.0, -_BEYOND))]  # fmt: skip
    spec = ObjectSpec("probe", "probe", size=(_RADIUS,), mass=PROBE_MASS, friction=0.0, max_force=PRESS_FORCE)
    spec = replace(spec, path=tuple((float(t), float(x), float(y), float(z)) for t, x, y, z in way))
    command = joint_impedance(configuration.inertia(), robot.home, frequency=_FREQUENCY, damping_ratio=_DAMPING)
    return PressedRobot(robot, skin, SceneObject(spec, primitive_mesh(spec)), at, command)


def _place_to_press(robot: Robot, skin: Skin, configuration: Configuration, link: str) -> tuple[int, FloatArray]:
    """The taxel whose normal comes nearest to an axis of the world and has room for the probe, and that axis.

    Of equals the first; where none of the best has room, the one that has most.
    """
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    facing = np.full((len(skin), 6), -np.inf)
    places = np.zeros((len(skin), 3))
    for first, patch in zip(skin.first[:-1], skin.patches, strict=True):
        if link in ("", patch.link) and len(patch.taxels):
            own = slice(first, first + len(patch.taxels))
            pose = configuration.pose(patch.link)
            facing[own] = pose.directions(patch.taxels.normals) @ axes.T
            places[own] = pose.points(patch.taxels.positions)
    order = np.argsort(-facing.max(axis=1), kind="stable")[:_CANDIDATES]
    order = order[np.isfinite(facing[order].max(axis=1))]
    if not len(order):
        raise SkinError("there is no skin to press", place=link or "robot", remedy="Cover a link")
    towards = axes[facing[order].argmax(axis=1)]
    links = [skin.link(skin.taxel_point(taxel)) for taxel in order.tolist()]
    best = (-np.inf, 0)
    for number, room in enumerate(_room(robot, skin, links, places[order] + (_RADIUS + _AWAY) * towards)):
        best = max(best, (min(room, _ROOM), -number))
        if room >= _ROOM:
            break
    return int(order[-best[1]]), towards[-best[1]]


def _room(robot: Robot, skin: Skin, links: Sequence[str], places: FloatArray) -> Iterator[float]:
    """How far the probe at each place (k, 3) is at home from all but the link there [m], up to ``_ROOM``.

    Negative where it is within the convex hull of that link, which the solver's contacts touch: above a hollow the skin
    would not be reached.
    """
    spec = ObjectSpec("ball", "sphere", size=(_RADIUS,), at=(0.0, 0.0, 0.0))
    ball = SceneObject(spec, primitive_mesh(spec))
    model = assemble(robot, skin, replace(REFERENCE_EFFECTS, contact="environment"), objects=(ball,))
    data = mujoco.MjData(model)
    body = model.body(body_name(spec))
    data.qpos[: len(robot.home)] = robot.home
    touching = (model.geom_contype | model.geom_conaffinity) > 0
    touching[np.concatenate([model.pair_geom1, model.pair_geom2])] = True  # the skin's
    touching &= model.geom_bodyid != body.id
    for link, place in zip(links, places, strict=True):
        model.body_pos[body.id] = place
        mujoco.mj_kinematics(model, data)
        room = _ROOM
        for geom in np.flatnonzero(touching).tolist():
            away = mujoco.mj_geomDistance(model, data, int(body.geomadr[0]), geom, _ROOM, None)
            if model.geom_bodyid[geom] != model.body(link).id or away < 0:
                room = min(room, away)
        yield room


SETTLING = 0.8
HOLDING = 0.4
"""How long it gives way, and how long it is held then [s]."""
SAMPLE_MS = 8.0
"""From one look at the posture to the next, while it gives way [ms]; a multiple of every time step."""
STEADY_SHARE = 0.05
"""Share of the force by which a steady contact may be off or ripple."""
REFERENCE_EFFECTS = Effects(gravity="off", contact="probe", fingers=False, integrator="discrete", timestep=5e-5)
"""The truth: a short step by the one integrator that no stiffness upsets."""


@dataclass(frozen=True, eq=False)
class PressRun:
    """What a run showed.

    Attributes:
        postures: (k, joints) every 8 ms while it gives way [rad].
        forces: (n,) of the contact at every step after that [N].
        seconds: (k,) wall time of each 8 ms of stepping.
        stopped: Why it ended before its time; empty when it did not.
    """

    postures: FloatArray
    forces: FloatArray
    seconds: FloatArray
    stopped: str = ""

    @property
    def ms(self) -> float:
        """Wall milliseconds of a simulated second, the median over the looks."""
        return 1e6 * float(np.median(self.seconds)) / SAMPLE_MS

    @property
    def p95_ms(self) -> float:
        """The same of the slowest but 5 % of the looks."""
        return 1e6 * float(np.percentile(self.seconds, 95)) / SAMPLE_MS

    @property
    def lost(self) -> float:
        """Share of the steps at which nothing touched."""
        return float((self.forces <= 0).mean())

    def posture_error(self, fine: PressRun) -> float | None:
        """Root mean square over time and joints [rad]; None where there are no joints."""
        return float(np.sqrt(np.mean((self.postures - fine.postures) ** 2))) if self.postures.size else None

    def force_errors(self, fine: PressRun) -> tuple[float, float]:
        """Error of the mean force, and ripple of the force (standard deviation), as shares of the true force.

        Raises:
            SimulationError: In the run that counts as the truth nothing touches.
        """
        wanted = float(fine.forces.mean())
        if not wanted > 0:
            raise SimulationError("the probe does not reach the skin", remedy="Cover a side of a link that is free")
        return abs(float(self.forces.mean()) - wanted) / wanted, float(self.forces.std()) / wanted

    def steady(self, fine: PressRun) -> bool:
        """Whether the contact holds as it should."""
        return not self.stopped and max(self.force_errors(fine)) < STEADY_SHARE and not self.lost


def run_press(arm: PressedRobot, effects: Effects, layer: ElasticLayer) -> PressRun:
    """Let the probe press the robot for 1.2 s: first timed and looked at every 8 ms, then felt at every step.

    A contact that bounces does so from step to step; looked at now and then it may seem to be still.

    Args:
        arm: What is pressed.
        effects: With the time step and the integrator; a whole number of steps are 8 ms.
        layer: The cover.
    """
    simulation = Simulation(arm.robot, arm.skin, effects, objects=(arm.probe,), layer=layer)
    postures: list[FloatArray] = []
    forces: list[float] = []
    seconds: list[float] = []
    stopped = ""
    try:
        for _ in range(round(1e3 * SETTLING / SAMPLE_MS)):
            start = time.perf_counter()
            simulation.step(round(1e-3 * SAMPLE_MS / effects.timestep), arm.command)
            seconds.append(time.perf_counter() - start)
            postures.append(simulation.posture)
        for _ in range(round(HOLDING / effects.timestep)):
            simulation.step(1, arm.command)
            forces.append(float(simulation.sense() @ arm.skin.areas))
    except SimulationError as error:
        stopped = str(error)
    return PressRun(np.array(postures), np.array(forces), np.array(seconds), stopped)


def effects_at_step(integrator: Integrator, timestep_ms: float) -> Effects:
    """The effects of a run by one integrator at one time step."""
    return replace(REFERENCE_EFFECTS, integrator=integrator, timestep=1e-3 * timestep_ms)
