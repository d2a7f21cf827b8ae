"""The foundation against the analytic sphere on a Winkler bed, by energy, by symmetry, and by its refusal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.model.robot import Link
from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tactile_maps.tactile.mechanics.contact_notes import NOTED_BIAS, ContactNoteKind
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Box, Cylinder, Plane, Sphere
from tactile_maps.tactile.models import foundation
from tactile_maps.tactile.models.foundation import STABLE
from tests.support.scene_objects import thing
from tests.support.surfaces import sheet
from tests.support.touch import bar, bar_skin, hold, no_command, pair

LAYER = ElasticLayer()
EFFECTS = Effects(contact="environment", skin="foundation", gravity="off")
FINE = bar_skin(1000, finer=3)


def held(kind: str, depth: float, **said) -> Simulation:
    """A thing fixed ``depth`` deep in the skin of a bar that cannot move either, after one step."""
    half = {"sphere": 0.02, "box": 0.01, "cylinder": 0.01, "mesh": 0.02, "plane": 0.0}[kind]
    turn = (180.0, 0.0, 0.0) if kind == "plane" else (0.0, 0.0, 0.0)
    body = thing(kind, at=(0.2, 0.0, 0.02 + half - depth), turn=turn, **said)
    simulation = Simulation(bar(), FINE, EFFECTS, objects=(body,))
    simulation.step(1, no_command(bar()))
    return simulation


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize(("radius", "depth"), [(0.01, 2e-3), (0.02, 1e-3), (0.04, 5e-4), (0.04, 1e-3), (0.08, 1e-3)])
def test_ball_on_a_bed_of_springs_follows_the_closed_form(radius, depth):
    """Depths R - s along the ball's radii, s from R - d to R, felt across the plane: F = pi K (R - d) d².

    That is Johnson's pi K R d² (4.3) where d is small. The mean over places, for points are few under a small patch.
    """
    forces = []
    for x in np.linspace(0.15, 0.25, 9):
        body = thing("sphere", size=(radius,), at=(x, 0.001, 0.02 + radius - depth))
        forces.append(Simulation(bar(), FINE, EFFECTS, objects=(body,)).sense() @ FINE.areas)
    assert np.mean(forces) == pytest.approx(np.pi * LAYER.foundation * (radius - depth) * depth**2, rel=0.03)


def test_flat_face_on_a_bed_of_springs_follows_the_closed_form():
    depth = 2e-4
    force = held("box", depth).sense() @ FINE.areas
    assert force == pytest.approx(LAYER.foundation * 0.06 * 0.05 * depth, rel=0.05)
    radius = 0.03
    force = held("cylinder", depth).sense() @ FINE.areas
    assert force == pytest.approx(LAYER.foundation * np.pi * radius**2 * depth, rel=0.05)
    assert held("plane", depth).sense() @ FINE.areas == pytest.approx(
        LAYER.foundation * FINE.areas.sum() * depth, rel=1e-9
    )


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("kind", ["sphere", "box", "cylinder", "mesh"])
def test_sum_of_pressure_times_area_is_the_force_on_the_bar(kind):
    body = thing(kind, at=(0.3, 0.0, {"sphere": 0.0397, "mesh": 0.0397}.get(kind, 0.0298)))
    simulation = Simulation(bar(), FINE, EFFECTS, objects=(body,))
    simulation.step(800, hold(bar(), 3000.0, 60.0))
    assert abs(simulation.velocity[0]) < 1e-9
    pushed = simulation._data.qfrc_applied[0]
    assert pushed == pytest.approx(3000.0 * simulation.posture[0], rel=1e-6)
    lever = FINE.patches[0].taxels.quadrature
    force = np.concatenate([forces for _, forces in simulation._touch._felt])
    points = np.concatenate([points for points, _ in simulation._touch._felt])
    assert simulation.sense() @ FINE.areas == pytest.approx(force.sum(), rel=1e-6)
    assert force @ lever.positions[points, 0] == pytest.approx(pushed, rel=0.02), "straight down, at its lever"


def test_both_bodies_receive_equal_and_opposite_forces():
    ball = thing("sphere", at=(0.25, 0.03, 0.0393), mass=0.4)
    simulation = Simulation(bar(), FINE, EFFECTS, objects=(ball,))
    model = simulation._model
    data = simulation._data
    data.qvel[:] = np.linspace(-0.5, 0.5, model.nv)
    simulation.step(1, no_command(bar()))
    force = data.qfrc_applied[1:4]
    assert force[2] > 1
    own = data.xmat[2].reshape(3, 3) @ data.qfrc_applied[4:7]  # a free joint's torque is in the body's own frame
    about_hinge = -np.cross((0.25, 0.03, 0.0393), force) - own
    assert data.qfrc_applied[0] == pytest.approx(about_hinge[1], rel=1e-6)


def dropped(layer: ElasticLayer, timestep: float, *, speed: float = 0.3, mass: float = 0.3) -> tuple[float, float]:
    """Coefficient of restitution of a ball thrown on a fixed bar, and its greatest share of kinetic energy after."""
    ball = thing("sphere", at=(0.2, 0.0, 0.0405), mass=mass)
    robot = bar(hinged=False)
    simulation = Simulation(robot, FINE, replace(EFFECTS, timestep=timestep), objects=(ball,), layer=layer)
    simulation._data.qvel[2] = -speed
    touched = False
    for _ in range(round(0.1 / timestep)):
        simulation.step(1, no_command(robot))
        touched = touched or simulation.sense().any()
    assert touched
    return simulation._data.qvel[2] / speed, np.linalg.norm(simulation._data.qvel[:3]) / speed


@pytest.mark.long
def test_bounce_does_not_depend_on_the_time_step():
    fine = dropped(LAYER, 5e-5)[0]
    coarse = dropped(LAYER, 5e-4)[0]
    assert coarse == pytest.approx(fine, abs=0.03)


@pytest.mark.long
def test_cover_too_stiff_for_the_time_step_is_rejected_with_the_longest_step():
    robot = bar(hinged=False)
    light = thing("box", at=(0.2, 0.0, 0.0299), mass=0.05)
    stiffness = LAYER.foundation * 0.06 * 0.05
    longest = STABLE * np.sqrt(0.05 / stiffness)
    assert longest < 5e-4
    with pytest.raises(SimulationError, match=r"box on bar.*too stiff for the time step") as caught:
        Simulation(robot, FINE, replace(EFFECTS, timestep=5e-4), objects=(light,))
    assert float(caught.value.remedy.split("at most ")[1].split(" ms")[0]) == pytest.approx(1e3 * longest, rel=0.1)
    fine = Simulation(robot, FINE, replace(EFFECTS, timestep=0.9 * longest), objects=(light,))
    fine.step(100, no_command(robot))


@pytest.mark.long
def test_covers_of_two_links_act_in_series_and_both_read_the_same_force():
    robot, skin = pair()
    simulation = Simulation(robot, skin, Effects(contact="self", skin="foundation"))
    simulation.step(800, replace(hold(robot, 0.0, 40.0), torque=np.array([7.0])))
    assert abs(simulation.velocity[0]) < 1e-6
    force = simulation.sense() * skin.areas
    first = skin.first[1]
    assert force[:first].sum() == pytest.approx(7.0, rel=1e-6)
    assert force[first:].sum() == pytest.approx(force[:first].sum(), rel=1e-9)
    assert simulation.posture[0] - 0.03 == pytest.approx(7.0 / (0.5 * LAYER.foundation * 0.01), rel=0.01)


def bent_skin(radius: float) -> Skin:
    """Skin on the bar that bends about x, convex for a radius [m] > 0; its middle is that of the flat one."""

    def height(x, y):
        return 0 * x if np.isinf(radius) else np.sign(radius) * (np.sqrt(radius**2 - (y - 0.04) ** 2) - abs(radius))

    flat = sheet(60, 60, width=0.08, height=0.08, shape=height)
    surface = Mesh(flat.vertices + [0.16, -0.04, 0.02], flat.faces)
    return Skin((Patch("top", "bar", surface, place_evenly(surface, 400, seed=0)),))


@pytest.mark.sampled(4)
@pytest.mark.parametrize("radius", [np.inf, 0.1, 0.06, -0.1, -0.06])
@pytest.mark.parametrize("kind", ["sphere", "cylinder", "box"])
def test_ratio_of_readings_to_force_is_stated_on_curved_skin(kind, radius):
    """Less than the force on convex skin, more on concave skin, exact on flat skin."""
    half = {"sphere": 0.05, "cylinder": 0.01, "box": 0.01}[kind]
    size = {"sphere": (0.05,), "cylinder": (0.015, 0.02), "box": (0.04, 0.03, 0.02)}[kind]
    body = thing(kind, at=(0.2, 0.0, 0.02 + half - 2e-3), size=size)
    skin = bent_skin(radius)
    (patch,) = skin.patches
    robot = replace(bar(hinged=False), links=(Link("bar", patch.surface),))
    simulation = Simulation(robot, skin, EFFECTS, objects=(body,))
    simulation.step(1, no_command(robot))
    force = -simulation.wrenches()["bar"][2]
    ratio = simulation.sense() @ skin.areas / force
    assert force > 5
    if np.isinf(radius):
        assert ratio == pytest.approx(1.0, rel=1e-9)
    else:
        assert 0 < np.sign(radius) * (1 - ratio) < 0.15
    stated = [note for note in simulation.notes if note.kind is ContactNoteKind.BENT_SKIN]
    assert len(stated) == (abs(ratio - 1) > NOTED_BIAS)
    for note in stated:
        assert note.bodies == (kind, "bar")
        assert note.ratio == pytest.approx(ratio, rel=1e-3)


def flat_contact(kind: str, size: tuple[float, ...], *, turn: tuple[float, float, float]) -> tuple[Simulation, float]:
    """A fixed body pressed into a square of flat skin of 80 mm, and the sum of the readings [N]."""
    skin = bent_skin(np.inf)
    (patch,) = skin.patches
    half = size[0] if kind == "sphere" else size[2] / 2
    body = thing(kind, at=(0.2003, 0.0007, 0.02 + half - 1e-3), size=size, turn=turn)
    robot = replace(bar(hinged=False), links=(Link("bar", patch.surface),))
    simulation = Simulation(robot, skin, EFFECTS, objects=(body,))
    simulation.step(1, no_command(robot))
    return simulation, float(simulation.sense() @ skin.areas)


def test_tilted_box_within_flat_skin_is_pushed_only_along_the_normal():
    """Sliding or turning on a flat bed changes no depth, although few points are under the sides."""
    simulation, read = flat_contact("box", (0.03, 0.024, 0.02), turn=(0.7, 1.3, 20.0))
    (wrench,) = simulation._touch.wrenches
    assert read > 5
    assert -wrench.force == pytest.approx([0.0, 0.0, read], abs=1e-9 * read)
    assert abs(wrench.torque[2]) < 1e-9 * read * 0.03
    assert simulation.notes == ()


@pytest.mark.long
def test_ball_within_flat_skin_receives_no_torque():
    """Forces along its radii have no torque about its centre, wherever the points are."""
    simulation, read = flat_contact("sphere", (0.02,), turn=(0.0, 0.0, 0.0))
    (wrench,) = simulation._touch.wrenches
    arm = wrench.point - simulation._data.xpos[wrench.other]
    assert np.linalg.norm(arm[:2]) > 1e-6, "the points are not symmetric about the ball"
    assert np.cross(arm, wrench.force) + wrench.torque == pytest.approx(np.zeros(3), abs=1e-8 * read * 0.02)


@pytest.mark.parametrize("shape", [Sphere(0.03), Box((0.03, 0.02, 0.01)), Cylinder(0.03, 0.01), Plane()])
def test_normals_of_a_shape_are_gradients_of_its_distance(shape):
    points = np.random.default_rng(1).uniform(-0.04, 0.04, (400, 3))
    step = 1e-7
    slopes = [shape.distance(points + step * axis) - shape.distance(points - step * axis) for axis in np.eye(3)]
    normals = foundation._gradient(shape, points)
    assert normals == pytest.approx(np.transpose(slopes) / (2 * step), abs=1e-6)


def test_normal_equidistant_from_two_sides_of_a_box_is_between_them():
    """Within rounding of the distances, so that mirrored bodies press alike."""
    places = np.array([[0.025, 0.025 + 1e-12, 0.0], [-0.025, 0.025 - 1e-12, 0.0]])
    normals = foundation._gradient(Box((0.03, 0.03, 0.03)), places)
    assert normals == pytest.approx(np.array([[1, 1, 0], [-1, 1, 0]]) / np.sqrt(2), abs=1e-9)


def test_face_wider_than_the_flat_skin_presses_along_its_own_normal():
    """There the border of the skin is pressed, and it is the face that has no friction."""
    simulation, read = flat_contact("box", (0.12, 0.12, 0.02), turn=(0.0, 0.5, 0.0))
    (wrench,) = simulation._touch.wrenches
    slope = np.radians(0.5)
    assert read > 20
    assert -wrench.force / read == pytest.approx([np.tan(slope), 0.0, 1.0], abs=1e-6)


@pytest.mark.long
def test_points_at_the_border_of_a_flat_part_are_found():
    skin = bent_skin(np.inf)
    simulation, _ = flat_contact("sphere", (0.02,), turn=(0.0, 0.0, 0.0))
    bed = simulation._touch._pairs[0].bed
    reach = np.abs(bed.positions[:, :2] - [0.2, 0.0]).max(axis=1)
    spacing = np.sqrt(np.median(skin.patches[0].taxels.quadrature.areas))
    assert not bed.on_rim[reach < 0.04 - 3 * spacing].any()
    assert bed.on_rim[reach > 0.04 - spacing / 2].mean() > 0.5


@pytest.mark.parametrize(
    "swapped",
    [pytest.param(False, id="convex first"), pytest.param(True, id="flat first", marks=pytest.mark.long)],
)
def test_readings_of_two_links_in_contact_agree_on_curved_skin(swapped):
    """One side determines the force; both sides read the same, though the reading differs from the resultant."""
    robot, flat = pair()
    left, right = flat.patches
    depth, y, z = 0.004, *left.surface.vertices.T[1:]
    bulge = depth * (1 - (y**2 + z**2) / 0.05**2)
    surface = Mesh(left.surface.vertices + np.outer(bulge, [1.0, 0, 0]), left.surface.faces)
    bent = Patch("left", "left", surface, place_evenly(surface, 40, seed=0))
    skin = Skin((right, bent) if swapped else (bent, right))
    simulation = Simulation(robot, skin, Effects(contact="self", skin="foundation", timestep=5e-4))
    simulation.step(300, replace(hold(robot, 0.0, 40.0), torque=np.array([20.0])))
    force = simulation.sense() * skin.areas
    first, second = np.split(force, [skin.first[1]])
    wrenches = simulation.wrenches()
    assert wrenches["left"][:3] == pytest.approx(-wrenches["right"][:3], abs=1e-14)
    assert first.sum() > 10
    assert first.sum() == pytest.approx(second.sum(), rel=1e-12)


@pytest.mark.long
def test_distant_body_needs_one_search():
    ball = thing("sphere", at=(0.2, 0.0, 1.0), mass=0.4)
    simulation = Simulation(bar(), FINE, EFFECTS, objects=(ball,))
    simulation.step(10, no_command(bar()))
    pair_ = simulation._touch._pairs[0]
    room = pair_._room
    near = pair_._near
    assert room == pytest.approx(0.96, abs=0.01)
    simulation.step(10, no_command(bar()))
    assert pair_._near is near


@pytest.mark.long
def test_deep_body_presses_only_the_side_that_faces_it():
    """A plane that swallows a tube presses its underside alone."""
    simulation = held("plane", 1e-3)
    assert (simulation.sense() >= 0).all()
    below = thing("plane", at=(0.0, 0.0, 0.5))
    swallowed = Simulation(bar(hinged=False), FINE, EFFECTS, objects=(below,))
    swallowed.step(1, no_command(bar(hinged=False)))
    assert not swallowed.sense().any(), "the skin on top looks the same way as the plane"


@pytest.mark.long
def test_body_that_presses_through_the_cover_is_rejected_by_name():
    """It would sink in altogether and meet no spring any more."""
    ball = thing("sphere", at=(0.2, 0.0, 0.0399), mass=50.0, guided=True)
    robot = bar(hinged=False)
    simulation = Simulation(robot, FINE, replace(EFFECTS, gravity="on"), objects=(ball,))
    with pytest.raises(SimulationError, match=r"sphere on bar at 0\.\d+ s: the layer is pressed through .*mm deep"):
        simulation.step(1000, no_command(robot))
    assert simulation.object_poses[0][2, 3] > 0.02, "it is not in yet"
