"""The known-load check: a weight laid on the skin must read its weight.

A ball on a vertical guide comes down where the skin lies level, the robot held at home, no friction, no sensor: with
every contact model that conserves force the pressures must add up to m g. Free, a weight would roll off a round link;
on a guide it rests where it is put. The ball is large, so that what it presses on faces one way, and touches in one
point: a flat foot would rest on any of many, and waver.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray
from app.errors import SimulationError
from app.geometry.surface_point import SurfacePoint
from app.robots.configuration import Configuration
from app.robots.robot import Robot
from app.scene.bodies import primitive
from app.scene.effects import Effects, SkinModel
from app.scene.objects import Body, ObjectSpec
from app.simulation.level_place import level_place
from app.simulation.simulation import Simulation
from app.skin.skin import Skin
from app.touch.layer import Layer

GRAVITY = 9.81
"""[m/s²]."""
_RADIUS = 0.03
_HOLD = 60.0
_STABLE = 0.3
_CHECK, _STILL, _LONGEST = 0.05, 4, 10.0


@dataclass(frozen=True)
class Weighed:
    """What a weight read.

    Attributes:
        model: The contact model.
        wanted_N: The weight [N].
        read_N: Sum of pressure x area over all taxels, times the vertical component of the skin's normal there [N].
        error: Relative, (read - wanted) / wanted.
        patch: Name of the patch it rests on.
        place: Where.
        seconds: Simulated until it rested [s].
    """

    model: str
    wanted_N: float
    read_N: float
    error: float
    patch: str
    place: SurfacePoint
    seconds: float


def weigh(robot: Robot, skin: Skin, layer: Layer, model: SkinModel, *, mass: float = 0.1) -> Weighed:
    """Lay a weight on the skin and read it.

    Args:
        robot: Held at home, stiffly.
        skin: At least one taxel.
        layer: The skin's cover.
        model: How contact becomes pressure.
        mass: [kg], 0.001 to 50.

    Raises:
        SimulationError: No place of the skin lies level and free at home, nothing senses, or the weight does not come
            to rest on the skin.

    Cost: about 1 s of simulated time.
    """
    if model == "off" or not 1e-3 <= mass <= 50.0:
        place, value = ("model", model) if model == "off" else ("mass", f"{mass:g} kg")
        remedy = "Choose a contact model and 0.001 to 50 kg"
        raise SimulationError("nothing can be weighed so", place=place, value=value, remedy=remedy)
    at, middle = level_place(robot, skin, radius=_RADIUS)
    spec = ObjectSpec("weight", "sphere", (_RADIUS,), middle, mass=mass, guided=True)
    # Half of what keeps an explicit spring of this stiffness under this mass stable.
    timestep = float(np.clip(_STABLE * np.sqrt(mass / layer.stiffness), 1e-5, 1e-3))
    effects = Effects(contact="environment", fingers=False, skin=model, timestep=timestep)
    simulation = Simulation(robot, skin, effects, objects=(Body(spec, primitive(spec)),), layer=layer)
    read = _until_rest(simulation, robot, skin, at, mass)
    wanted = mass * GRAVITY
    patch = skin.patches[at.patch].name
    return Weighed(model, wanted, read, (read - wanted) / wanted, patch, at, simulation.time)


@dataclass(frozen=True, eq=False)
class _Hold:
    """The home posture under a spring so stiff that a weight moves it by less than a degree."""

    posture: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    torque: FloatArray


def _hold(robot: Robot) -> _Hold:
    inertia = Configuration(robot).inertia()
    return _Hold(robot.home, _HOLD**2 * inertia, 2 * _HOLD * inertia, np.zeros_like(inertia))


def _until_rest(simulation: Simulation, robot: Robot, skin: Skin, at: SurfacePoint, mass: float) -> float:
    """Step until neither the weight nor the reading changes; the reading's vertical sum [N]."""
    command, kinematics, still, read = _hold(robot), Configuration(robot), 0, 0.0
    start = height = float(simulation.object_poses[0, 2, 3])
    while still < _STILL:
        simulation.step(round(_CHECK / simulation.timestep), command)
        kinematics.update(simulation.posture)
        upwards = float(kinematics.pose(skin.link(at)).directions(skin.normal(at))[2])
        before, read = read, upwards * float(simulation.sense() @ skin.areas)
        above, height = height, float(simulation.object_poses[0, 2, 3])
        calm = abs(read - before) < 1e-4 * mass * GRAVITY and abs(height - above) < 1e-6
        still = still + 1 if calm else 0
        if abs(start - height) > _RADIUS or simulation.time > _LONGEST:
            raise SimulationError(
                "the weight does not come to rest on the skin",
                place=f"after {simulation.time:.2f} s",
                value=f"{read:.4g} N, {1000 * (start - height):.1f} mm lower",
                remedy="Use a stiffer cover, a lighter weight or another contact model",
            )
    if not read > 0:
        remedy = "Use a contact model that conserves force"
        raise SimulationError("the weight rests, but no taxel feels it", value=f"{read:.4g} N", remedy=remedy)
    return read
