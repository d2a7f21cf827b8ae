"""The foundation in a spherical bowl and on a dome: force, reading and depth at rest against integrals over the sphere.

A point of the skin at the distance r from the centre of a ball of radius R has the depth R - r. On a sphere of radius S
whose centre is at the distance e from the ball's, a ring of points has the area  dA = 2 pi (S / e) r dr,  so that force
and reading are integrals of polynomials in r.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from scipy.optimize import brentq

from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.model.robot import Link, Robot
from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.models.stated_errors import STATED_ERRORS
from tests.support.scene_objects import thing
from tests.support.surfaces import sheet
from tests.support.touch import bar, hold, no_command

LAYER = ElasticLayer()
EFFECTS = Effects(contact="environment", skin="foundation", gravity="off")
WIDTH = 0.08
GRAVITY = 9.81
SKINS = [-0.06, -0.1, -0.2, 0.06, 0.1]
"""Radii of the skin [m], negative for a bowl."""


def spherical_skin(radius: float) -> tuple[Robot, Skin]:
    """A fixed bar with a square of spherical skin, whose lowest or highest point is at (0.2, 0, 0.02)."""

    def height(x, y):
        middle = np.square(x - WIDTH / 2) + np.square(y - WIDTH / 2)
        return np.sign(radius) * (np.sqrt(radius**2 - middle) - abs(radius))

    flat = sheet(60, 60, width=WIDTH, height=WIDTH, shape=height)
    surface = Mesh(flat.vertices + [0.2 - WIDTH / 2, -WIDTH / 2, 0.02], flat.faces)
    skin = Skin((Patch("top", "bar", surface, place_evenly(surface, 400, seed=0)),))
    return replace(bar(hinged=False), links=(Link("bar", surface),)), skin


def on_sphere(radius: float, ball: float, depth: float) -> tuple[float, float]:
    """Force along the axis and sum of the readings [N] of a ball ``depth`` deep in a sphere."""
    size = abs(radius)
    bowl = radius < 0
    apart = size - ball + depth if bowl else size + ball - depth
    least = abs(size - apart)
    # Shares of the pressure along the axis and along the skin's normal, times r.
    axial = Polynomial([size**2 - apart**2, 0, -1]) if bowl else Polynomial([apart**2 - size**2, 0, 1])
    normal = Polynomial([size**2 - apart**2, 0, 1]) if bowl else Polynomial([apart**2 - size**2, 0, -1])
    scale = LAYER.foundation * 2 * np.pi * size / apart
    pressed = Polynomial([ball, -1])
    along, felt = ((pressed * share).integ() for share in (axial / (2 * apart), normal / (2 * size)))
    return scale * (along(ball) - along(least)), scale * (felt(ball) - felt(least))


def dense(radius: float, distance, cells: int = 1200) -> float:
    """Vertical force [N] on a spherical skin by a sum over a fine grid; ``distance`` of points (n, 3) from the body."""
    steps = (np.arange(cells) + 0.5) / cells * WIDTH - WIDTH / 2
    x, y = (axis.ravel() for axis in np.meshgrid(steps, steps))
    flank = np.sqrt(radius**2 - x**2 - y**2)
    points = np.stack([x, y, np.sign(radius) * (flank - abs(radius))], axis=1)
    areas = (WIDTH / cells) ** 2 * abs(radius) / flank
    nudge = np.array([0.0, 0.0, 1e-6])
    upward = (distance(points - nudge) - distance(points + nudge)) / 2e-6
    return float(LAYER.foundation * np.maximum(-distance(points), 0.0) @ (upward * areas))


@pytest.mark.sampled(2)
@pytest.mark.parametrize("radius", SKINS)
def test_closed_form_equals_the_dense_sum(radius):
    """And a nearly flat sphere has the force of a flat bed, pi K (R - d) d^2."""
    ball, depth = 0.04, 1e-3

    def distance(points):
        return np.linalg.norm(points - [0.0, 0.0, ball - depth], axis=1) - ball

    assert dense(radius, distance) == pytest.approx(on_sphere(radius, ball, depth)[0], rel=2e-3)
    flat = np.pi * LAYER.foundation * (ball - depth) * depth**2
    assert on_sphere(np.sign(radius) * 100.0, ball, depth)[1] == pytest.approx(flat, rel=2e-3)


def pressed(radius: float, kind: str, depth: float, height: float, **stated) -> Simulation:
    robot, skin = spherical_skin(radius)
    body = thing(kind, at=(0.2, 0.0, 0.02 + height - depth), **stated)
    simulation = Simulation(robot, skin, EFFECTS, objects=(body,))
    simulation.step(1, no_command(robot))
    return simulation


@pytest.mark.sampled(2)
@pytest.mark.parametrize("radius", SKINS)
@pytest.mark.parametrize(("ball", "depth"), [(0.02, 1e-3), (0.02, 2e-3), (0.04, 1e-3), (0.05, 5e-4), (0.05, 2e-3)])
def test_ball_force_in_bowl_and_on_dome_matches_the_integral(radius, ball, depth):
    """Force within 3 %: the facets of the skin are up to 6 um off the sphere. The reading follows the force."""
    simulation = pressed(radius, "sphere", depth, ball, size=(ball,))
    force = -simulation.wrenches()["bar"][2]
    expected, felt = on_sphere(radius, ball, depth)
    assert STATED_ERRORS["foundation"].force > 0.03
    assert force == pytest.approx(expected, rel=0.03)
    read = simulation.sense() @ np.concatenate([patch.taxels.areas for patch in simulation._skin.patches])
    assert read / force == pytest.approx(felt / expected, abs=0.004)
    assert (read > force) == (radius < 0)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("radius", [0.06, 0.1])
def test_roller_force_on_a_dome_matches_the_dense_sum(radius):
    size, depth = 0.015, 1e-3

    def distance(points):
        return np.hypot(points[:, 0], points[:, 2] - size + depth) - size

    simulation = pressed(radius, "cylinder", depth, size, size=(size, 0.07), turn=(90.0, 0.0, 0.0))
    assert -simulation.wrenches()["bar"][2] == pytest.approx(dense(radius, distance), rel=0.03)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("radius", SKINS)
def test_depth_of_a_weight_in_bowl_and_on_dome_matches_the_integral(radius):
    ball, mass = 0.03, 0.4
    expected = brentq(lambda deep: on_sphere(radius, ball, deep)[0] - mass * GRAVITY, 1e-5, 5e-3)
    robot, skin = spherical_skin(radius)
    body = thing("sphere", size=(ball,), at=(0.2, 0.0, 0.02 + ball - 0.95 * expected), mass=mass, guided=True)
    simulation = Simulation(robot, skin, replace(EFFECTS, gravity="on"), objects=(body,))
    simulation.step(1000, hold(robot, 0.0, 0.0))
    depth = 0.02 + ball - simulation.object_poses[0, 2, 3]
    assert depth == pytest.approx(expected, rel=0.015)
    assert -simulation.wrenches()["bar"][2] == pytest.approx(mass * GRAVITY, rel=1e-3)
