"""Free bodies on a link without skin, which collides by the shapes of the robot's model."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from tactile_maps.robots.model.robot import Link, Robot
from tactile_maps.scene.effects import Effects, Integrator
from tactile_maps.simulation.simulation import Simulation
from tests.support.scene_objects import thing
from tests.support.touch import bar, bar_skin, hold

pytestmark = pytest.mark.long

GRAVITY = 9.81
TOP = 0.02
SHAPES = {"box": 0.01, "cylinder": 0.01, "mesh": 0.015, "sphere": 0.02}
"""Half the height of each [m]."""
DEPTHS = {"box": 1.08e-4, "cylinder": 1.09e-4, "mesh": 1.08e-4, "sphere": 3.67e-4}
"""Depth at rest [m], as the guide states it."""
STEPS = [pytest.param(name, marks=() if name == "implicitfast" else pytest.mark.long) for name in get_args(Integrator)]


def two_bars(attributes: str) -> Robot:
    """Return the fixed bar, and one like it at y = 0.5 m whose geom has these ``attributes``."""
    one = bar(hinged=False)
    body = one.mjcf[one.mjcf.index('<body name="bar">') : one.mjcf.index("</worldbody>")]
    other = body.replace('name="bar"', 'name="bare" pos="0 0.5 0"').replace("<geom ", f"<geom {attributes} ")
    text = one.mjcf.replace("</worldbody>", other + "</worldbody>")
    return Robot("bars", "by hand", text, {}, (*one.links, Link("bare", one.links[0].mesh)), (), np.zeros(0))


def placed(
    shape: str, *, slope: float = 0.0, friction: float | None = 0.5, mass: float = 0.5, geom: str = "", **effects
) -> Simulation:
    """A free body on the bare bar; ``slope`` [rad] turns gravity towards +x."""
    said = {"mesh": thing("box", size=(0.04, 0.03, 0.03)).mesh} if shape == "mesh" else {}
    at = (0.15, 0.5, TOP + SHAPES[shape] - DEPTHS[shape])
    body = thing(shape, at=at, mass=mass, friction=friction, **said)
    expected = {"contact": "environment", "gravity": "on", "friction": True, **effects}
    simulation = Simulation(two_bars(geom), bar_skin(), Effects(**expected), objects=(body,))
    simulation._model.opt.gravity[:] = GRAVITY * np.sin(slope), 0.0, -GRAVITY * np.cos(slope)
    simulation._physics.forward()
    return simulation


def run(simulation: Simulation, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the force on the body from its acceleration (k, 3) [N/kg] and its place (k, 3) [m] after each step."""
    command = hold(two_bars(""), 0.0, 0.0)
    pushes = []
    places = []
    for _ in range(round(seconds / simulation.timestep)):
        simulation.step(1, command)
        pushes.append(simulation._data.qacc[:3] - simulation._model.opt.gravity)
        places.append(simulation.object_poses[0][:3, 3])
    return np.array(pushes), np.array(places)


@pytest.mark.parametrize("integrator", STEPS)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("mass", [0.005, 0.5, 50.0])
def test_body_rests_on_a_bare_link_with_its_weight(shape, mass, integrator):
    simulation = placed(shape, mass=mass, integrator=integrator)
    run(simulation, 0.5)
    pushes, places = run(simulation, 0.5)
    np.testing.assert_allclose(pushes[:, 2], GRAVITY, rtol=1e-3)
    assert pushes[:, 2].mean() == pytest.approx(GRAVITY, rel=1e-4)
    assert TOP + SHAPES[shape] - places[-1, 2] == pytest.approx(DEPTHS[shape], rel=0.03), "the same for all masses"
    assert np.linalg.norm(places[-1, :2] - places[0, :2]) < 2e-6


@pytest.mark.parametrize("skin", ["water-fill", "foundation"])
@pytest.mark.parametrize("integrator", STEPS)
@pytest.mark.parametrize("friction", [0.2, 0.5])
def test_body_stays_on_a_bare_link_below_the_friction_angle(friction, integrator, skin):
    """MuJoCo's tolerance of 1e-8 would stop the solver early: the body creeps by 0.14 mm/s (coefficient 0.2)."""
    slope = 0.95 * np.arctan(friction)
    simulation = placed("box", slope=slope, friction=friction, integrator=integrator, skin=skin)
    run(simulation, 0.5)
    _, places = run(simulation, 1.0)
    assert np.linalg.norm(places[-1, :2] - places[0, :2]) < 1e-5, "less than 0.01 mm/s"


@pytest.mark.parametrize("integrator", STEPS)
@pytest.mark.parametrize("friction", [0.2, 0.5])
def test_body_slides_on_a_bare_link_with_its_own_friction_coefficient(friction, integrator):
    """The coefficient of the link, MuJoCo's default of 1 or that of the model, does not count then."""
    slope = np.arctan(friction) + np.radians(5.0)
    for geom in ("", 'friction="0.8 0.005 0.0001"'):
        _, places = run(placed("box", slope=slope, friction=friction, integrator=integrator, geom=geom), 0.4)
        acceleration = 2 * np.polyfit(1e-3 * np.arange(1, len(places) + 1), places[:, 0], 2)[0]
        expected = GRAVITY * (np.sin(slope) - friction * np.cos(slope))
        assert acceleration == pytest.approx(expected, rel=0.01)


def test_larger_of_link_and_default_friction_is_used_if_none_is_stated():
    for coefficient, geom in ((0.5, 'friction="0.1 0.005 0.0001"'), (0.8, 'friction="0.8 0.005 0.0001"')):
        simulation = placed("box", friction=None, geom=geom)
        assert simulation._data.contact.friction[:, 0] == pytest.approx(coefficient)
