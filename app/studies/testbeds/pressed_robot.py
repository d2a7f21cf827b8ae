"""A robot held at home, pressed by a probe, run at one time step: how it gives way, how the contact holds, what
stepping costs.

The same scene for whatever steps in time. The truth is a run with a time step of 0.05 ms by the one integrator that no
stiffness upsets.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from app.control.command import JointCommand
from app.control.joint_impedance import joint_impedance
from app.core.arrays import FloatArray
from app.core.errors import SimulationError, SkinError
from app.geometry.mesh import SurfacePoint
from app.robots.kinematics import Configuration
from app.robots.library import load_robot
from app.robots.robot import Robot
from app.scene.effects import Effects, Integrator
from app.scene.object_meshes import primitive_mesh
from app.scene.objects import ObjectSpec, SceneObject
from app.scene.stability import PROBE_MASS
from app.simulation.simulation import Simulation
from app.skin.cover import CoverSpec, cover_robot
from app.skin.skin import Skin
from app.tactile.elastic_layer import ElasticLayer

PRESS_FORCE = 10.0
"""The probe's motors push so hard [N]."""
ARRIVED = 0.1
"""The probe's motors have come to their end by then [s]; the arm then gives way until it carries the force."""
_RADIUS, _AWAY, _BEYOND = 0.012, 0.002, 0.05
_FREQUENCY, _DAMPING = 30.0, 1.0


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
        link: Which link is pressed; by default the one where skin faces an axis of the world best.

    Raises:
        SkinError: Nothing there has skin.
    """
    configuration = Configuration(robot)
    number, axis = _facing_an_axis(skin, configuration, link)
    at = skin.taxel_point(number)
    touched = configuration.pose(skin.link(at)).points(skin.position(at))
    way = [(seconds, *(touched + along * axis)) for seconds, along in
           ((0.0, _RADIUS + _AWAY), (ARRIVED, -_BEYOND), (3600.0, -_BEYOND))]  # fmt: skip
    spec = ObjectSpec("probe", "probe", size=(_RADIUS,), mass=PROBE_MASS, friction=0.0, max_force=PRESS_FORCE)
    spec = replace(spec, path=tuple((float(t), float(x), float(y), float(z)) for t, x, y, z in way))
    command = joint_impedance(configuration.inertia(), robot.home, frequency=_FREQUENCY, damping_ratio=_DAMPING)
    return PressedRobot(robot, skin, SceneObject(spec, primitive_mesh(spec)), at, command)


def _facing_an_axis(skin: Skin, configuration: Configuration, link: str) -> tuple[int, FloatArray]:
    """The taxel whose normal comes nearest to an axis of the world, and that axis; of equals the first."""
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    best = (-np.inf, 0, axes[0])
    for first, patch in zip(skin.first[:-1], skin.patches, strict=True):
        if link in ("", patch.link) and len(patch.taxels):
            facing = configuration.pose(patch.link).directions(patch.taxels.normals) @ axes.T
            taxel, axis = np.unravel_index(np.argmax(facing), facing.shape)
            if facing[taxel, axis] > best[0]:
                best = (float(facing[taxel, axis]), int(first + taxel), axes[axis])
    if not np.isfinite(best[0]):
        raise SkinError("there is no skin to press", place=link or "robot", remedy="Cover a link")
    return best[1], best[2]


SETTLING, HOLDING = 0.8, 0.4
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
    def lost(self) -> float:
        """Share of the steps at which nothing touched."""
        return float((self.forces <= 0).mean())

    def posture_error(self, fine: PressRun) -> float | None:
        """Root mean square over time and joints [rad]; None where there are no joints."""
        return float(np.sqrt(np.mean((self.postures - fine.postures) ** 2))) if self.postures.size else None

    def force_errors(self, fine: PressRun) -> tuple[float, float]:
        """Error of the mean force, and ripple of the force (standard deviation), as shares of the true force."""
        wanted = float(fine.forces.mean())
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
