"""A robot held at home and pressed by a probe, simulated with one time step: compliance, contact and cost of stepping.

The scene is the same for all integrators and time steps. The reference is a run with a time step of 0.05 ms by the only
integrator that is stable for any stiffness.
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
"""Maximum force of the probe's motors [N]."""
ARRIVED = 0.1
"""Time at which the path of the probe ends [s]; the arm then yields until it supports the force."""
_RADIUS = 0.012
_AWAY = 0.002
_BEYOND = 0.05
_FREQUENCY = 30.0
_DAMPING = 1.0
_ROOM = 0.01
_CANDIDATES = 400
"""Initial distance of the probe from other links [m], and number of taxels that are checked for it."""


@dataclass(frozen=True, eq=False)
class PressedRobot:
    """Scene of the studies.

    Attributes:
        robot: Our own arm.
        skin: Skin on upper arm, forearm and hand.
        probe: Ball of 12 mm and 0.1 kg that presses with ``PRESS_FORCE`` along an axis of the world.
        at: Place of the contact on the skin.
        command: Command that holds the arm at home.
    """

    robot: Robot
    skin: Skin
    probe: SceneObject
    at: SurfacePoint
    command: JointCommand


@lru_cache(maxsize=4)
def pressed_arm(taxels: int, seed: int = 0) -> PressedRobot:
    """Return the arm with so many taxels. Cost: 1 s at 1,000; cached."""
    robot = load_robot("arm")
    return press_robot(
        robot, cover_robot(robot, CoverSpec(("upper_arm", "forearm", "hand"), taxels=taxels, seed=seed)), "forearm"
    )


def press_robot(robot: Robot, skin: Skin, link: str = "") -> PressedRobot:
    """Return a robot held at home, with the probe above its skin.

    Args:
        robot: Any robot.
        skin: Its skin.
        link: Link to press; by default the one with a free place whose skin faces an axis of the world best.

    Raises:
        SkinError: The link has no skin.
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
    """The taxel whose normal is nearest to an axis of the world and that has space for the probe, and that axis.

    The first of equal ones; if none of the best taxels has space, the one with the most.
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
        raise SkinError("no skin to press", place=link or "robot", remedy="Cover a link")
    towards = axes[facing[order].argmax(axis=1)]
    links = [skin.link(skin.taxel_point(taxel)) for taxel in order.tolist()]
    best = (-np.inf, 0)
    for number, room in enumerate(_room(robot, skin, links, places[order] + (_RADIUS + _AWAY) * towards)):
        best = max(best, (min(room, _ROOM), -number))
        if room >= _ROOM:
            break
    return int(order[-best[1]]), towards[-best[1]]


def _room(robot: Robot, skin: Skin, links: Sequence[str], places: FloatArray) -> Iterator[float]:
    """Distance of the probe at each place (k, 3) from everything except the link there, at home [m], up to ``_ROOM``.

    Negative inside the convex hull of that link, which the solver's contacts touch: above a hollow the probe would not
    reach the skin.
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
"""Duration of yielding, and of holding after that [s]."""
SAMPLE_MS = 8.0
"""Period of posture samples while the arm yields [ms]; a multiple of every time step."""
STEADY_SHARE = 0.05
"""Maximum error and ripple of the force of a steady contact, as a share of the force."""
REFERENCE_EFFECTS = Effects(gravity="off", contact="probe", fingers=False, integrator="discrete", timestep=5e-5)
"""Effects of the reference: a short step by the only integrator that is stable for any stiffness."""


@dataclass(frozen=True, eq=False)
class PressRun:
    """Results of a run.

    Attributes:
        postures: (k, joints) posture every 8 ms while the arm yields [rad].
        forces: (n,) contact force at every step after that [N].
        seconds: (k,) wall time for each 8 ms of stepping.
        stopped: Reason of an early end; empty without one.
    """

    postures: FloatArray
    forces: FloatArray
    seconds: FloatArray
    stopped: str = ""

    @property
    def ms(self) -> float:
        """Median wall time of a simulated second [ms]."""
        return 1e6 * float(np.median(self.seconds)) / SAMPLE_MS

    @property
    def p95_ms(self) -> float:
        """95th percentile of the wall time of a simulated second [ms]."""
        return 1e6 * float(np.percentile(self.seconds, 95)) / SAMPLE_MS

    @property
    def lost(self) -> float:
        """Share of the steps without contact."""
        return float((self.forces <= 0).mean())

    def posture_error(self, fine: PressRun) -> float | None:
        """Return the root mean square error over time and joints [rad]; None without joints."""
        return float(np.sqrt(np.mean((self.postures - fine.postures) ** 2))) if self.postures.size else None

    def force_errors(self, fine: PressRun) -> tuple[float, float]:
        """Return the error of the mean force and the ripple (standard deviation), as shares of the true force.

        Raises:
            SimulationError: The reference run has no contact.
        """
        true = float(fine.forces.mean())
        if not true > 0:
            raise SimulationError("the probe does not reach the skin", remedy="Cover a side of a link that is free")
        return abs(float(self.forces.mean()) - true) / true, float(self.forces.std()) / true

    def steady(self, fine: PressRun) -> bool:
        """Return whether the contact is steady."""
        return not self.stopped and max(self.force_errors(fine)) < STEADY_SHARE and not self.lost


def run_press(arm: PressedRobot, effects: Effects, layer: ElasticLayer) -> PressRun:
    """Let the probe press the robot for 1.2 s: first timed and sampled every 8 ms, then measured at every step.

    A contact may bounce from step to step and appear steady at a lower sampling rate.

    Args:
        arm: The robot and its probe.
        effects: Effects with time step and integrator; 8 ms must be a whole number of steps.
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
    """Return the effects of a run with an integrator and a time step."""
    return replace(REFERENCE_EFFECTS, integrator=integrator, timestep=1e-3 * timestep_ms)
