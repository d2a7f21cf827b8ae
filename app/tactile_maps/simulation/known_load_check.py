"""The known-load check: a known weight on the skin must read its weight.

A ball on a vertical guide is lowered onto level, unobstructed skin while the robot is held in its home posture, without
friction and sensor effects. With every contact model that conserves force, the pressures must add up to m g. Without
the guide the ball would roll off a round link. The ball is large, so that the skin under it faces one way; it touches
at one point, because a flat foot would rock between several.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import SimulationError
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import Mesh, SurfacePoint
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.object_meshes import primitive_mesh
from tactile_maps.scene.objects import ObjectSpec, SceneObject
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.skin.link_hulls import hull_points
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer

_LEVEL = 0.93
"""Vertical component of normals that count as level: 21 degrees."""
_ABOVE = 0.0002
_BULGE = 0.003
"""Height of the weight above its resting place at the start, and largest gap between hull and skin there [m]."""


def find_level_place(robot: Robot, skin: Skin, *, radius: float) -> tuple[SurfacePoint, tuple[float, float, float]]:
    """Return the place for the weight and the initial position of its centre, world frame [m].

    Among the unobstructed places it is the one where the skin is most level and most parallel to the collision hull.
    Where the two differ, the weight would rest on another part than the one that is read.

    Args:
        robot: The robot, in its home posture.
        skin: Its skin.
        radius: Radius of the weight, a ball [m].

    Raises:
        SimulationError: No place is level and unobstructed.
    """
    kinematics = Configuration(robot)
    best = 0.0
    found: list[tuple[float, int, FloatArray]] = []
    for number, patch in enumerate(skin.patches):
        pose = kinematics.pose(patch.link)
        places = pose.points(patch.taxels.positions)
        up = pose.directions(patch.taxels.normals)[:, 2]
        heights, level = _resting_heights(pose.points(hull_points(robot, skin, patch.link)), places, radius)
        best = max(best, float(up.max(initial=0.0)))
        good = (up >= _LEVEL) & (level >= _LEVEL) & (heights - radius - places[:, 2] < _BULGE)
        for taxel in np.flatnonzero(good):
            penalty = abs(up[taxel] / level[taxel] - 1) + 1 - level[taxel]
            middle = np.array([*places[taxel, :2], heights[taxel] + _ABOVE])
            found.append((float(penalty), int(skin.first[number] + taxel), middle))
    sky = _Clearance(robot, kinematics, radius)
    for _, number, middle in sorted(found, key=lambda row: row[:2]):
        at = skin.taxel_point(number)
        if sky.is_free(skin.link(at), middle):
            return at, (float(middle[0]), float(middle[1]), float(middle[2]))
    raise SimulationError(
        "at home no part of the skin is level and unobstructed",
        value=f"the best faces up by {best:.2f}",
        remedy="Weigh on a robot whose home posture holds some skin level",
    )


def _resting_heights(cloud: FloatArray, places: FloatArray, radius: float) -> tuple[FloatArray, FloatArray]:
    """Return the resting height of a ball on the hull of ``cloud`` (n, 3) above each of ``places`` (k, 3), world [m].

    Returns:
        (k,) height of its middle, and (k,) vertical component of the hull's normal where it rests.
    """
    facets = ConvexHull(cloud).equations
    normals, offsets = np.split(facets[facets[:, 2] > 1e-9], [3], axis=1)
    # The ball touches when the facet with the largest distance is one radius away.
    heights = (radius - offsets - normals[:, :2] @ places[:, :2].T) / normals[:, 2:]
    return heights.min(axis=0), normals[heights.argmin(axis=0), 2]


class _Clearance:
    """Test of a weight against the links. Search trees are built once, for the links near it.

    Args:
        robot: The robot.
        kinematics: Its posture.
        radius: Radius of the weight [m].
    """

    def __init__(self, robot: Robot, kinematics: Configuration, radius: float) -> None:
        self._robot = robot
        self._kinematics = kinematics
        self._radius = radius
        self._trees: dict[str, ClosestPoint] = {}

    def is_free(self, wearer: str, middle: FloatArray) -> bool:
        """Whether a weight at ``middle`` (3,), world [m], is clear of all links but the one called ``wearer``."""
        return not any(
            self._is_near(link.name, link.mesh, middle)
            for link in self._robot.links
            if link.mesh is not None and len(link.mesh.faces) and link.name != wearer
        )

    def _is_near(self, name: str, mesh: Mesh, middle: FloatArray) -> bool:
        local = self._kinematics.pose(name).inverse.points(middle)
        low, high = mesh.bounds
        if (local < low - 2 * self._radius).any() or (local > high + 2 * self._radius).any():
            return False
        if name not in self._trees:
            self._trees[name] = ClosestPoint(mesh)
        return float(self._trees[name].query(local[None])[2][0]) < 1.1 * self._radius


GRAVITY = 9.81
"""[m/s²]."""
_RADIUS = 0.03
_HOLD = 60.0
_STABLE = 0.3
_CHECK = 0.05
_STILL = 4
_LONGEST = 10.0


@dataclass(frozen=True)
class WeighingResult:
    """Result of the known-load check.

    Attributes:
        model: The contact model.
        expected_N: The weight [N].
        read_N: Sum of pressure x area over all taxels, times the vertical component of the skin's normal there [N].
        error: Relative error, (read - expected) / expected.
        patch: Name of the patch on which the weight rests.
        place: Place on the skin.
        seconds: Simulated time until the weight was at rest [s].
    """

    model: str
    expected_N: float
    read_N: float
    error: float
    patch: str
    place: SurfacePoint
    seconds: float


def weigh(robot: Robot, skin: Skin, layer: ElasticLayer, model: str, *, mass: float = 0.1) -> WeighingResult:
    """Place a weight on the skin and read it.

    Args:
        robot: The robot, held stiffly in its home posture.
        skin: Its skin, with at least one taxel.
        layer: The skin's cover.
        model: Name of the contact model.
        mass: Mass of the weight [kg], 0.001 to 50.

    Raises:
        SimulationError: No skin is level and unobstructed in the home posture, no taxel reads the weight, or the weight
            does not come to rest on the skin.

    Cost: about 1 s of simulated time.
    """
    if model == "off" or not 1e-3 <= mass <= 50.0:
        place, value = ("model", model) if model == "off" else ("mass", f"{mass:g} kg")
        remedy = "Choose a contact model and 0.001 to 50 kg"
        raise SimulationError(
            "the known-load check cannot run with these values", place=place, value=value, remedy=remedy
        )
    at, middle = find_level_place(robot, skin, radius=_RADIUS)
    spec = ObjectSpec("weight", "sphere", (_RADIUS,), middle, mass=mass, guided=True)
    # Half of the largest stable step of an explicit spring of this stiffness and mass.
    timestep = float(np.clip(_STABLE * np.sqrt(mass / layer.stiffness), 1e-5, 1e-3))
    effects = Effects(contact="environment", fingers=False, skin=model, timestep=timestep)
    simulation = Simulation(robot, skin, effects, objects=(SceneObject(spec, primitive_mesh(spec)),), layer=layer)
    read = _until_rest(simulation, robot, skin, at, mass)
    expected = mass * GRAVITY
    patch = skin.patches[at.patch].name
    return WeighingResult(model, expected, read, (read - expected) / expected, patch, at, simulation.time)


@dataclass(frozen=True, eq=False)
class _HoldCommand:
    """Command that holds the home posture so stiffly that a weight moves it by less than a degree."""

    posture: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    torque: FloatArray


def _hold_command(robot: Robot) -> _HoldCommand:
    inertia = Configuration(robot).inertia()
    return _HoldCommand(robot.home, _HOLD**2 * inertia, 2 * _HOLD * inertia, np.zeros_like(inertia))


def _until_rest(simulation: Simulation, robot: Robot, skin: Skin, at: SurfacePoint, mass: float) -> float:
    """Step until neither the weight nor the reading changes, and return the vertical sum of the reading [N]."""
    command = _hold_command(robot)
    kinematics = Configuration(robot)
    still = 0
    read = 0.0
    start = height = float(simulation.object_poses[0, 2, 3])
    while still < _STILL:
        simulation.step(round(_CHECK / simulation.timestep), command)
        kinematics.update(simulation.posture)
        upwards = float(kinematics.pose(skin.link(at)).directions(skin.normal(at))[2])
        before = read
        read = upwards * float(simulation.sense() @ skin.areas)
        above = height
        height = float(simulation.object_poses[0, 2, 3])
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
        raise SimulationError(
            "the weight rests on the skin, but no taxel reads pressure", value=f"{read:.4g} N", remedy=remedy
        )
    return read
