"""Bodies on skin with hollows: they rest on the surface itself, and every contact model feels them there."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects
from tests.support.hollows import BOWL_DEPTH, GROOVE_DEPTH, bowl_and_ball, hollow, raised
from tests.support.scene_objects import thing
from tests.support.touch import hold

MASS = 0.2
GRAVITY = 9.81
RADIUS = 0.02
LAYER = ElasticLayer(2e4)
WEIGHT = MASS * GRAVITY
HEIGHTS = {
    "flat": RADIUS,
    "bowl": RADIUS - BOWL_DEPTH,
    "groove": RADIUS * np.sqrt(2) - GROOVE_DEPTH,
    "saddle": RADIUS,
}
"""Height of the middle of a ball that touches without force [m]."""
NORMAL_FORCE = {"groove": WEIGHT * np.sqrt(2)}
"""Sum of the forces on both walls; on the others it is the weight."""


def ball_on(shape, *, at=(0.0, 0.0), mass=MASS, **effects):
    """Return a guided ball at rest on a block, or one that starts where it touches."""
    robot, skin = hollow(shape)
    ball = thing("sphere", at=(*at, HEIGHTS[shape]), mass=mass, guided=True)
    stated = {"contact": "environment", "gravity": "on", **effects}
    return Simulation(robot, skin, Effects(**stated), objects=(ball,), layer=LAYER)


def run(simulation, steps):
    """Advance, and return the place (3,) of the body."""
    simulation.step(steps, hold(hollow("flat")[0], 0.0, 0.0))
    return simulation.object_poses[0][:3, 3]


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("integrator", ["implicitfast", "discrete"])
@pytest.mark.parametrize("shape", HEIGHTS)
def test_ball_rests_on_the_surface_with_its_weight(shape, integrator):
    """A ball on the convex hull would rest 22 mm above a bowl."""
    simulation = ball_on(shape, integrator=integrator)
    place = run(simulation, 200)
    assert place[2] == pytest.approx(HEIGHTS[shape] - WEIGHT / LAYER.stiffness, abs=5e-5)
    carried = sum(load.force * load.normal for load in simulation.loads)
    np.testing.assert_allclose(carried, [0, 0, WEIGHT], rtol=1e-4, atol=0.05 * WEIGHT)
    assert len(simulation.loads) == (2 if shape == "groove" else 1)


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize(("along", "height"), [(-0.02, 0.0), (0.0, 3e-3), (0.01, 3e-3)])
def test_box_rests_on_bare_link_or_on_raised_skin(along, height):
    """A box on the convex hull would rest 2 mm above the bare link."""
    robot, skin = raised()
    half = 8e-3
    box = thing("box", at=(along, 0.0, height + half), mass=MASS, size=(2 * half,) * 3, guided=True)
    effects = Effects(contact="environment", gravity="on")
    simulation = Simulation(robot, skin, effects, objects=(box,), layer=LAYER)
    simulation.step(200, hold(robot, 0.0, 0.0))
    assert simulation.object_poses[0][2, 3] == pytest.approx(height + half - WEIGHT / LAYER.stiffness, abs=2e-4)


def test_ball_between_faces_of_a_bowl_is_one_load_with_its_weight():
    """Their forces across the mean normal cancel; the sum of both would be more."""
    simulation = ball_on("bowl", at=(0.012, 0.007), mass=2.0)
    run(simulation, 250)
    (load,) = simulation.loads
    assert np.linalg.norm(simulation.wrenches()["block"][:3]) == pytest.approx(load.force, rel=1e-6)
    contact = simulation._data.contact
    felt = simulation._data.efc_force[contact.efc_address[contact.exclude == 0]]
    assert len(felt) > 1
    assert felt.sum() > 1.00001 * load.force


def test_means_over_the_tick_keep_both_walls_of_a_groove():
    simulation = ball_on("groove", time_averaging=True)
    run(simulation, 200)
    run(simulation, 5)
    assert sorted(round(load.normal[0], 6) for load in simulation.loads) == [-0.707107, 0.707107]
    assert [load.force for load in simulation.loads] == pytest.approx([WEIGHT / np.sqrt(2)] * 2, rel=1e-3)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("model", CONTACT_MODELS)
@pytest.mark.parametrize("shape", HEIGHTS)
def test_models_measure_the_weight_under_the_ball(shape, model):
    simulation = ball_on(shape)
    skin = hollow(shape)[1]
    run(simulation, 200)
    touch = CONTACT_MODELS[model].build(skin, LAYER, SensorEffects())
    forces = touch.pressures(simulation.loads) * skin.areas
    assert not touch.notes
    assert forces.sum() == pytest.approx(NORMAL_FORCE.get(shape, WEIGHT), rel=2e-3)
    middle = forces @ skin.patches[0].taxels.positions / forces.sum()
    assert np.abs(middle[:2]).max() < (6e-3 if model == "point" else 1.5e-3)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("shape", HEIGHTS)
def test_foundation_carries_the_ball_on_the_surface(shape):
    """Taxels feel what acts along their normals, and points are finite: on 200 taxels a tenth of the weight is off."""
    simulation = ball_on(shape, skin="foundation")
    skin = hollow(shape)[1]
    place = run(simulation, 500)
    forces = simulation.sense() * skin.areas
    middle = forces @ skin.patches[0].taxels.positions / forces.sum()
    assert forces.sum() == pytest.approx(NORMAL_FORCE.get(shape, WEIGHT), rel=0.12)
    assert np.abs(middle[:2]).max() < 1.5e-3
    assert HEIGHTS[shape] - 2e-3 < place[2] < HEIGHTS[shape]


@pytest.mark.parametrize("shape", HEIGHTS)
def test_depth_model_measures_a_heavy_ball_where_it_rests(shape):
    """A light one presses a spot that is smaller than the distance between taxels."""
    mass = 6.0
    simulation = ball_on(shape, skin="depth", mass=mass)
    skin = hollow(shape)[1]
    place = run(simulation, 200)
    forces = simulation.sense() * skin.areas
    middle = forces @ skin.patches[0].taxels.positions / forces.sum()
    assert place[2] == pytest.approx(HEIGHTS[shape] - mass * GRAVITY / LAYER.stiffness, abs=1e-4)
    assert np.abs(middle[:2]).max() < 4e-3


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("place", [(0.0, 0.0), (0.012, 0.007), (0.004, -0.001)])
def test_bowl_is_as_stiff_as_stated(place):
    depths = []
    for mass in (0.1, 1.1):
        simulation = ball_on("bowl", at=place, mass=mass)
        depths.append(run(simulation, 250)[2])
        forces = [load.normal[2] for load in simulation.loads]
    slope = float(np.mean(forces)) ** 2
    assert depths[0] - depths[1] == pytest.approx(GRAVITY / LAYER.stiffness / slope, rel=0.01)


@pytest.mark.long
def test_box_across_a_bowl_rests_on_the_rim():
    robot, skin = hollow("bowl")
    box = thing("box", size=(0.115, 0.03, 0.02), at=(0.0, 0.0, 0.01), mass=MASS)
    simulation = Simulation(
        robot, skin, Effects(contact="environment", gravity="on", friction=True), objects=(box,), layer=LAYER
    )
    place = run(simulation, 300)
    assert place[2] == pytest.approx(0.01 - WEIGHT / LAYER.stiffness, abs=1e-4)
    assert np.abs(place[:2]).max() < 1e-4
    assert simulation.total_normal_force == pytest.approx(WEIGHT, rel=0.01)


@pytest.mark.long
def test_seams_between_pieces_do_not_disturb_a_sliding_body():
    """A ball slides along the flat rim of a bowl, over seams between its pieces."""
    robot, skin = hollow("bowl")
    ball = thing("sphere", size=(0.01,), at=(0.055, -0.03, 0.01 - WEIGHT / LAYER.stiffness), mass=MASS)
    simulation = Simulation(robot, skin, Effects(contact="environment", gravity="on"), objects=(ball,), layer=LAYER)
    simulation._data.qvel[1] = 0.2
    places = []
    forces = []
    touched = set()
    for _ in range(100):
        places.append(run(simulation, 3))
        forces.append(simulation.total_normal_force)
        touched |= set(simulation._data.contact.geom.ravel().tolist())
    assert len(touched) > 3, "several pieces"
    assert places[-1][1] > 0.025
    np.testing.assert_allclose(forces, WEIGHT, rtol=0.01)
    assert np.abs(np.array(places)[:, 0] - 0.055).max() < 1e-6, "no lateral kick"


def test_repeated_runs_are_identical_bit_for_bit():
    first, second = (run(ball_on("bowl", at=(0.01, 0.004)), 60) for _ in range(2))
    assert first.tobytes() == second.tobytes()


@pytest.mark.parametrize("first", ["ball", pytest.param("block", marks=pytest.mark.long)])
@pytest.mark.parametrize(
    "model", ["foundation", *(pytest.param(model, marks=pytest.mark.long) for model in (*CONTACT_MODELS, "depth"))]
)
def test_link_rests_in_the_bowl_of_another(model, first):
    """The ball is inside the hull of the bowl at home and touches nothing."""
    robot, skin = bowl_and_ball(0.005, first=first)
    simulation = Simulation(robot, skin, Effects(contact="self", gravity="on", skin=model), layer=LAYER)
    simulation.step(400, hold(robot, 0.0, 3.0))
    height = 0.005 + float(simulation.posture[0])
    forces = simulation.sense() * skin.areas
    sums = np.split(forces, [skin.first[1]])
    if model == "foundation":
        assert HEIGHTS["bowl"] - 2e-3 < height < HEIGHTS["bowl"]
    else:
        assert height == pytest.approx(HEIGHTS["bowl"] - WEIGHT / LAYER.stiffness, abs=4e-4), "faces of ball and bowl"
    if model != "depth":
        assert [float(each.sum()) for each in sums] == pytest.approx([WEIGHT] * 2, rel=0.03)
