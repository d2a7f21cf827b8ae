"""Bodies that are wedged between two skins, or between a skin and a bare link, against statics."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tactile_maps.control.motion.command import JointCommand
from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.model.robot import Link, Robot
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.objects import SceneObject
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS
from tests.support.hollows import hollow
from tests.support.scene_objects import thing
from tests.support.touch import hold, pair

pytestmark = pytest.mark.long

LAYER = ElasticLayer(2e4)
MASS = 0.3
GRAVITY = 9.81
WEIGHT = MASS * GRAVITY
PUSH = 10.0
"""Force that closes the gap between two blocks [N]."""
HALF = 0.02
"""Half the distance between inclined walls [m]."""
_WALLS = """<mujoco model="walls"><compiler angle="radian"/><worldbody>
<body name="left" pos="-{x} 0 0" quat="{w} 0 -{y} 0"><inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
<geom type="box" size="0.05 0.05 0.05"/></body>
<body name="right" pos="{x} 0 0" quat="{w} 0 {y} 0"><inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
<geom type="box" size="0.05 0.05 0.05"/></body></worldbody></mujoco>"""


@cache
def walls(degrees: float) -> tuple[Robot, Skin]:
    """Return two fixed blocks that form a V; their inner sides have skin and lean outward by an angle."""
    blocks, skin = pair()
    angle = np.radians(degrees)
    text = _WALLS.format(x=HALF + 0.05 / np.cos(angle), w=np.cos(angle / 2), y=np.sin(angle / 2))
    links = tuple(Link(link.name, link.mesh) for link in blocks.links)
    return Robot("walls", "by hand", text, {}, links, (), np.zeros(0)), skin


def keystone(degrees: float, *, friction: float) -> SceneObject:
    """Return a body that fits between the walls."""
    lean = np.tan(np.radians(degrees))
    vertices = np.array(
        [[side * (HALF + lean * z), y, z] for z in (-0.02, 0.02) for y in (-0.02, 0.02) for side in (-1, 1)]
    )
    squares = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    mesh = Mesh(vertices, np.array([part for a, b, c, d in squares for part in ((a, b, c), (a, c, d))]))
    return thing("mesh", mesh=mesh, mass=MASS, friction=friction)


def ball(degrees: float, *, friction: float) -> SceneObject:
    """Return a ball on a vertical guide that touches both walls."""
    return thing("sphere", size=(HALF * np.cos(np.radians(degrees)),), mass=MASS, friction=friction, guided=True)


BODIES = {"keystone": keystone, "ball": ball}


def sums(simulation: Simulation, skin: Skin) -> FloatArray:
    """Return the sum of the readings of each patch [N]."""
    return np.bincount(skin.patch_of, simulation.sense() * skin.areas)


def close(robot: Robot) -> JointCommand:
    """Return the command that closes the gap between two blocks."""
    one = np.ones(len(robot.joints))
    return JointCommand(robot.home, 0 * one, 30 * one, PUSH * one)


def wedged(model: str, *, turn: float, skin: Skin) -> Simulation:
    """Return a free box between two blocks, of which one is pushed towards the other for 0.8 s."""
    robot = pair()[0]
    box = thing("box", size=(0.022 if turn else 0.03, 0.06, 0.03), turn=(0.0, turn, 0.0), mass=0.1)
    effects = Effects(contact="environment", gravity="on", friction=True, skin=model, fingers=False)
    simulation = Simulation(robot, skin, effects, objects=(box,), layer=LAYER)
    simulation.step(800, close(robot))
    return simulation


@pytest.mark.sampled(1)
@pytest.mark.parametrize("turn", [0.0, 12.0], ids=["on faces", "on edges"])
@pytest.mark.parametrize("model", CONTACT_MODELS)
def test_both_skins_read_the_force_that_squeezes_a_box(model: str, turn: float) -> None:
    skin = pair()[1]
    simulation = wedged(model, turn=turn, skin=skin)
    left, right = sums(simulation, skin)
    assert [left, right] == pytest.approx([PUSH, PUSH], rel=1e-3)
    assert left == pytest.approx(right, rel=1e-3)
    assert not simulation.notes


@pytest.mark.parametrize("number", [0, 1])
def test_one_skin_reads_the_force_that_squeezes_a_box_against_a_bare_link(number: int) -> None:
    skin = Skin((pair()[1].patches[number],))
    assert sums(wedged("water-fill", turn=0.0, skin=skin), skin) == pytest.approx([PUSH], rel=1e-3)


def falling(body: SceneObject, degrees: float, *, friction: bool, speed: float = 0.0) -> Simulation:
    """Return a body 0.9 s after it started between the walls, at a speed downward [m/s]."""
    robot, skin = walls(degrees)
    effects = Effects(contact="environment", gravity="on", friction=friction, skin="punch", fingers=False)
    simulation = Simulation(robot, skin, effects, objects=(body,), layer=LAYER)
    simulation._data.qvel[0 if body.spec.guided else 2] = -speed
    simulation.step(900, hold(robot, 0.0, 0.0))
    return simulation


@pytest.mark.sampled(1)
@pytest.mark.parametrize("degrees", [10.0, 20.0])
@pytest.mark.parametrize("kind", BODIES)
def test_inclined_skins_read_the_force_of_a_wedge_without_friction(kind: str, degrees: float) -> None:
    simulation = falling(BODIES[kind](degrees, friction=0.0), degrees, friction=False)
    expected = WEIGHT / (2 * np.sin(np.radians(degrees)))
    assert sums(simulation, walls(degrees)[1]) == pytest.approx([expected] * 2, rel=2e-3)
    assert not simulation.notes


@pytest.mark.parametrize("kind", BODIES)
def test_forces_of_a_wedge_with_friction_depend_on_its_history(kind: str) -> None:
    """Statics leaves them open between the limits of sliding up and down."""
    degrees = 20.0
    friction = 0.2
    angle = np.radians(degrees)
    low, high = (WEIGHT / (2 * (np.sin(angle) + sign * friction * np.cos(angle))) for sign in (1, -1))
    read = []
    for speed in (0.0, 0.5):
        simulation = falling(BODIES[kind](degrees, friction=friction), degrees, friction=True, speed=speed)
        left, right = sums(simulation, walls(degrees)[1])
        assert left == pytest.approx(right, rel=1e-3)
        assert low < left < high
        total = sum(wrench[:3] @ np.array([0, 0, 1]) for wrench in _in_world(simulation, angle))
        assert total == pytest.approx(-WEIGHT, rel=2e-3)
        read.append(left)
    assert read[1] > 3 * read[0]


def _in_world(simulation: Simulation, angle: float) -> list[FloatArray]:
    """Return the force on each wall [N], world frame, friction included."""
    turned = []
    for link, sign in (("left", -1), ("right", 1)):
        cosine = np.cos(sign * angle)
        sine = np.sin(sign * angle)
        turned.append(np.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]]) @ simulation.wrenches()[link][:3])
    return turned


@pytest.mark.sampled(1)
@pytest.mark.parametrize("model", CONTACT_MODELS)
def test_box_in_a_groove_of_one_link_loads_both_walls(model: str) -> None:
    robot, skin = hollow("groove")
    side = 0.02
    box = thing(
        "box", size=(side, 0.06, side), at=(0.0, 0.0, side / np.sqrt(2) - 0.02), turn=(0.0, 45.0, 0.0), mass=MASS
    )
    box = replace(box, spec=replace(box.spec, friction=0.0))
    effects = Effects(contact="environment", gravity="on", skin=model, fingers=False)
    simulation = Simulation(robot, skin, effects, objects=(box,), layer=LAYER)
    simulation.step(300, hold(robot, 0.0, 0.0))
    assert [load.force for load in simulation.loads] == pytest.approx([WEIGHT / np.sqrt(2)] * 2, rel=2e-3)
    assert float(simulation.sense() @ skin.areas) == pytest.approx(WEIGHT * np.sqrt(2), rel=2e-3)
