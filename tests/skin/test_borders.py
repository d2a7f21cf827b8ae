"""Contacts across the border of a skin and on bare parts of its link: closed forms, and agreement of all models."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import trimesh

from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.robots.model.robot import Link, Robot
from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.skin.model.bare_surface import with_bare_points
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tactile_maps.tactile.mechanics.contact_notes import ContactNoteKind
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Cylinder, Load, sphere_load
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS
from tactile_maps.tactile.poke import Finger, PokePressed
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects
from tests.support.scene_objects import thing
from tests.support.touch import bar, bar_skin, hold, no_command

LAYER = ElasticLayer()
SPREADING = ("water-fill", "punch", "half-space")
MODELS = (*CONTACT_MODELS, "foundation", "depth")
BORDER = 0.1
"""The skin of the bar begins here [m]; the bar itself at 0."""
SKIN = bar_skin(600, finer=4, length=0.2)
UP = np.array([0.0, 0.0, 1.0])
PLACES = (-0.02, -0.015, -0.012, -0.005, 0.0, 0.005, 0.012, 0.015, 0.02)
"""Distances of the middle of a contact from the border, positive on the skin [m]."""


@cache
def model(name):
    return CONTACT_MODELS[name].build(with_bare_points(bar(), SKIN), LAYER, SensorEffects())


def disc(along, radius, force, *, offset=0.0):
    """A flat disc on the top of the bar, pressed ``offset`` [m] from its middle."""
    point = np.array([BORDER + along, 0.0, 0.02])
    depth = 1e-4
    pose = Pose(np.eye(3), point + [0.0, 0.0, 0.01 - depth])
    return Load("bar", point + [offset, 0.0, 0.0], UP, force, Cylinder(radius, 0.01), pose, "disc")


def unread(felt):
    """Return the share of the load that a note says is not read."""
    (share,) = (note.share for note in felt.notes if note.kind is ContactNoteKind.PARTLY_OUTSIDE)
    return share


def beyond(middle):
    """Return the share of a disc of unit radius about ``middle`` at positive places."""
    u = float(np.clip(middle, -1, 1))
    return float(0.5 + (np.arcsin(u) + u * np.sqrt(1 - u * u)) / np.pi)


def beyond_paraboloid(middle):
    """Return the share at positive places of a pressure 1 - r² on a disc of unit radius about ``middle``."""
    u = float(np.clip(middle, -1, 1))
    return float(0.5 + (u * np.sqrt(1 - u * u) * (5 - 2 * u * u) + 3 * np.arcsin(u)) / (3 * np.pi))


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", SPREADING)
@pytest.mark.parametrize("along", PLACES)
def test_disc_across_the_border_is_read_by_its_area_on_the_skin(name, along):
    felt = model(name)
    force = 6.0
    pressures = felt.pressures([disc(along, 0.01, force)])
    expected = beyond(along / 0.01)
    read = float(pressures @ SKIN.areas) / force
    assert read == pytest.approx(expected, abs=0.02)
    if expected in (0.0, 1.0):
        assert read == pytest.approx(expected, abs=1e-12)
        kinds = {note.kind for note in felt.notes}
        assert kinds == ({ContactNoteKind.OUTSIDE_SKIN} if expected == 0 else set())
    else:
        assert read + unread(felt) == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("name", SPREADING)
@pytest.mark.parametrize("along", PLACES)
def test_ball_across_the_border_is_read_by_the_integral_over_the_skin(name, along):
    felt = model(name)
    force = 20.0
    radius = 0.04
    depth = np.sqrt(force / (np.pi * LAYER.foundation * radius))
    patch = np.sqrt(2 * radius * depth)
    load = sphere_load("bar", np.array([BORDER + along, 0.0, 0.02]), UP, force, radius, depth=depth)
    read = float(felt.pressures([load]) @ SKIN.areas) / force
    assert read == pytest.approx(beyond_paraboloid(along / patch), abs=0.02)


@cache
def tube():
    """A tube along x with a radius of 40 mm; its skin is 3 mm thick and begins at x = 0."""
    solid = trimesh.creation.cylinder(0.04, 0.3, sections=120)
    mesh = Mesh(np.asarray(solid.vertices)[:, [2, 0, 1]], np.asarray(solid.faces))
    steps = 60
    around = 120
    x = np.linspace(0.0, 0.12, steps + 1)
    turn = np.linspace(0, 2 * np.pi, around, endpoint=False)
    i, j = (k.ravel() for k in np.meshgrid(x, turn, indexing="ij"))
    vertices = np.stack([i, 0.04 * np.cos(j), 0.04 * np.sin(j)], axis=1)
    a = (np.arange(steps)[:, None] * around + np.arange(around)).ravel()
    b = (np.arange(steps)[:, None] * around + (np.arange(around) + 1) % around).ravel()
    faces = np.concatenate([np.stack([a, a + around, b + around], 1), np.stack([a, b + around, b], 1)])
    surface = Mesh(vertices, faces[:, ::-1])
    robot = Robot("tube", "by hand", "", {}, (Link("tube", mesh),), (), np.zeros(0))
    return robot, Skin((Patch("sleeve", "tube", surface, place_evenly(surface, 400, seed=0)),))


@pytest.mark.sampled(2)
@pytest.mark.parametrize("along", PLACES)
def test_ball_across_the_border_of_a_curved_skin_is_read_by_the_integral(along):
    robot, skin = tube()
    outward = skin.patches[0].taxels.normals
    assert (np.vecdot(outward[:, 1:], skin.patches[0].taxels.positions[:, 1:]) > 0).all()
    felt = CONTACT_MODELS["water-fill"].build(with_bare_points(robot, skin), LAYER, SensorEffects())
    force = 20.0
    radius = 0.04
    # Curvatures of the gap along and across the tube; Johnson, Contact Mechanics, 4.3.
    depth = np.sqrt(force / (np.pi * LAYER.foundation) * np.sqrt(1 / radius * (1 / radius + 1 / 0.04)))
    patch = np.sqrt(2 * radius * depth)
    load = sphere_load("tube", np.array([along, 0.0, 0.04]), UP, force, radius, depth=depth)
    read = float(felt.pressures([load]) @ skin.areas) / force
    assert read == pytest.approx(beyond_paraboloid(along / patch), abs=0.02)


@pytest.mark.parametrize("along", [-0.003, 0.0, 0.004])
def test_punch_keeps_the_moment_about_the_border(along):
    """Pressed next to its middle, the disc tilts: its pressure is linear, F / A (1 + 4 e x / r²)."""
    felt = model("punch")
    force = 6.0
    radius = 0.01
    offset = 0.0015
    read = float(felt.pressures([disc(along, radius, force, offset=offset)]) @ SKIN.areas) / force
    u = -along / radius
    first = 2 / 3 * (1 - u * u) ** 1.5 / np.pi  # moment of the area beyond u about the middle, over the area
    assert read == pytest.approx(beyond(along / radius) + 4 * offset / radius * first, abs=0.02)


@pytest.mark.parametrize("along", [-0.02, -0.012, 0.012, 0.02])
@pytest.mark.parametrize("name", CONTACT_MODELS)
def test_all_models_agree_on_which_bodies_touch_the_skin(name, along):
    felt = model(name)
    force = 3.0
    read = felt.pressures([disc(along, 0.01, force)]) @ SKIN.areas
    assert read == pytest.approx(force if along > 0 else 0.0, rel=1e-12)
    outside = {ContactNoteKind.OUTSIDE_SKIN} if along < 0 else set()
    assert {note.kind for note in felt.notes} == outside


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.long) for name in MODELS[:-1]] + ["depth"])
def test_every_model_reports_a_body_on_a_bare_part(name):
    """The body rests there, and nothing is read."""
    robot = bar(hinged=False)
    body = thing("box", at=(0.05, 0.0, 0.0299), mass=0.3)
    effects = Effects(contact="environment", skin=name, timestep=5e-4)
    simulation = Simulation(robot, SKIN, effects, objects=(body,))
    simulation.step(1000, no_command(robot))
    assert simulation.object_poses[0][2, 3] == pytest.approx(0.03, abs=3e-4), "it does not fall through"
    assert not simulation.sense().any()
    (note,) = simulation.notes
    assert (note.kind, note.bodies) == (ContactNoteKind.OUTSIDE_SKIN, ("box", "bar"))


def test_foundation_carries_the_whole_load_of_a_body_across_the_border():
    robot = bar(hinged=False)
    weight = 0.3 * 9.81
    body = thing("box", at=(0.11, 0.0, 0.0299), mass=0.3)
    effects = Effects(contact="environment", skin="foundation", timestep=5e-4)
    simulation = Simulation(robot, SKIN, effects, objects=(body,))
    simulation.step(400, no_command(robot))
    read, (note,) = float(simulation.sense() @ SKIN.areas), simulation.notes
    assert note.kind is ContactNoteKind.PARTLY_OUTSIDE
    assert simulation.total_normal_force == pytest.approx(weight, rel=1e-3)
    assert read + note.share * simulation.total_normal_force == pytest.approx(simulation.total_normal_force, rel=1e-6)
    assert note.share == pytest.approx(1 / 3, abs=0.02)


def test_forces_of_the_foundation_on_a_bare_part_are_equal_and_opposite():
    ball = thing("sphere", at=(0.05, 0.03, 0.0393), mass=0.4)
    effects = Effects(contact="environment", skin="foundation", gravity="off")
    simulation = Simulation(bar(), SKIN, effects, objects=(ball,))
    model = simulation._model
    data = simulation._data
    data.qvel[:] = np.linspace(-0.5, 0.5, model.nv)
    simulation.step(1, no_command(bar()))
    force = data.qfrc_applied[1:4]
    assert force[2] > 0.5
    own = data.xmat[2].reshape(3, 3) @ data.qfrc_applied[4:7]
    about_hinge = -np.cross((0.05, 0.03, 0.0393), force) - own
    assert data.qfrc_applied[0] == pytest.approx(about_hinge[1], rel=1e-6)


@pytest.mark.long
def test_weight_of_a_ball_is_the_same_anywhere_on_a_bare_part():
    """The depth that it needs for its weight does not depend on where it is: points are even enough."""
    forces = []
    for x in np.linspace(0.03, 0.06, 13):
        body = thing("sphere", at=(x, 0.001, 0.0592), size=(0.04,))
        effects = Effects(contact="environment", skin="foundation", gravity="off")
        forces.append(Simulation(bar(), SKIN, effects, objects=(body,)).total_normal_force)
    assert np.std(forces) < 0.03 * np.mean(forces)
    assert np.mean(forces) == pytest.approx(np.pi * LAYER.foundation * 0.0392 * 0.0008**2, rel=0.03)


@pytest.mark.sampled(4)
@pytest.mark.parametrize("name", MODELS)
def test_finger_at_the_border_is_partly_read(name):
    robot = bar(hinged=False)
    taxel = int(np.abs(SKIN.patches[0].taxels.positions - [BORDER, 0.0, 0.02]).sum(axis=1).argmin())
    simulation = Simulation(robot, SKIN, Effects(contact="environment", skin=name))
    simulation.apply(PokePressed(1, SKIN.taxel_point(taxel), Finger(max_force=10.0, radius=0.03)))
    simulation.step(2000, hold(robot, 0.0, 0.0))
    read = simulation.sense() @ SKIN.areas
    if name == "point":
        assert read == pytest.approx(10.0, rel=1e-12)
        assert simulation.notes == ()
        return
    (note,) = simulation.notes
    assert note.kind is ContactNoteKind.PARTLY_OUTSIDE
    assert 0.2 < note.share < 0.4
    if name != "depth":
        assert read == pytest.approx(10.0 * (1 - note.share), rel=1e-12)


def test_readings_without_bare_points_equal_those_of_the_skin_alone():
    """A link that has no mesh bears load only where it has skin."""
    alone = replace(bar(), links=(Link("bar", None),))
    assert with_bare_points(alone, SKIN) is SKIN
    read = CONTACT_MODELS["water-fill"].build(SKIN, LAYER, SensorEffects()).pressures([disc(0.0, 0.01, 3.0)])
    assert read @ SKIN.areas == pytest.approx(3.0, rel=1e-12)
