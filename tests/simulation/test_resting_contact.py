"""Bodies at rest, sticking and sliding on flat skin: against statics and Coulomb's law, with every integrator."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.load import robot_of_mesh
from tactile_maps.scene.effects import Effects, Integrator
from tactile_maps.scene.scene_file import scene_for
from tactile_maps.session.prepare import prepare
from tactile_maps.session.session import Session
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.skin.fitting.cover import CoverSpec, cover_robot
from tactile_maps.skin.model.skin import Skin
from tactile_maps.studies.testbeds.fixed_ball import with_fixed_ball
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tests.support.scene_objects import thing
from tests.support.touch import bar, bar_skin, each_point_a_taxel, hold, plate

MASS = 0.5
GRAVITY = 9.81
TOP = 0.02
USUAL = ("implicitfast", "discrete")
INTEGRATORS = [pytest.param(name, marks=() if name in USUAL else pytest.mark.long) for name in get_args(Integrator)]
SHAPES = {"box": 0.01, "cylinder": 0.01, "mesh box": 0.015}
"""Half the height of each [m]."""


def resting(
    shape: str,
    integrator: str,
    *,
    slope: float = 0.0,
    friction: float = 0.5,
    mass: float = MASS,
    stiffness: float = 2e4,
    depth: float | None = None,
    felt_by: Skin | None = None,
    **effects,
) -> Simulation:
    """A free body on the fixed flat bar, as deep as it rests; ``slope`` [rad] turns gravity towards +x."""
    kind = "mesh" if shape == "mesh box" else shape
    said = {"mesh": thing("box", size=(0.04, 0.03, 0.03)).mesh} if kind == "mesh" else {}
    deep = mass * GRAVITY * np.cos(slope) / stiffness if depth is None else depth
    body = thing(kind, at=(0.15, 0.0, TOP + SHAPES[shape] - deep), mass=mass, friction=friction, **said)
    expected = {"contact": "environment", "gravity": "on", "friction": True, "integrator": integrator, **effects}
    robot = bar(hinged=False)
    simulation = Simulation(
        robot, felt_by or bar_skin(), Effects(**expected), objects=(body,), layer=ElasticLayer(stiffness)
    )
    simulation._model.opt.gravity[:] = GRAVITY * np.sin(slope), 0.0, -GRAVITY * np.cos(slope)
    simulation._physics.forward()
    return simulation


def run(simulation: Simulation, seconds: float, *, every: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """Return the normal force on the skin (k,) [N] and the pose of the body (k, 4, 4), once every so many steps."""
    command = hold(bar(hinged=False), 0.0, 0.0)
    forces = []
    poses = []
    for _ in range(round(seconds / simulation.timestep / every)):
        simulation.step(every, command)
        forces.append(simulation.total_normal_force)
        poses.append(simulation.object_poses[0])
    return np.array(forces), np.array(poses)


def turned(pose: np.ndarray, start: np.ndarray) -> float:
    """Return the angle between two poses [deg]."""
    return float(np.degrees(Rotation.from_matrix(pose[:3, :3] @ start[:3, :3].T).magnitude()))


@pytest.mark.sampled(3)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("friction", [True, False])
def test_body_rests_with_its_weight_without_rotating(shape, integrator, friction):
    """A single contact point would let the force of a box vary by 15 % and turn it by 11 degrees per second."""
    simulation = resting(shape, integrator, depth=0.0, friction=0.5 if friction else 0.0)
    run(simulation, 0.5)
    forces, poses = run(simulation, 0.5)
    np.testing.assert_allclose(forces, MASS * GRAVITY, rtol=1e-4)
    assert turned(poses[-1], poses[0]) < 0.01
    assert np.linalg.norm(poses[-1][:2, 3] - poses[0][:2, 3]) < 1e-6
    depth = TOP + SHAPES[shape] - poses[-1][2, 3]
    assert depth == pytest.approx(MASS * GRAVITY / 2e4, rel=0.01), "a face is as stiff as stated"


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("edges", [1, 2], ids=["edge", "corner"])
def test_edges_and_corners_are_as_stiff_as_stated(edges, integrator):
    half = 0.02
    diagonal = [0.02 * np.sqrt(2), 0.02 * np.sqrt(3)][edges - 1]
    tilt = (45.0, 0.0, 0.0) if edges == 1 else (45.0, float(np.degrees(np.arctan(np.sqrt(0.5)))), 0.0)
    body = thing("box", size=(2 * half,) * 3, at=(0.15, 0.0, TOP + diagonal), turn=tilt, mass=MASS, guided=True)
    effects = Effects(contact="environment", gravity="on", integrator=integrator)
    simulation = Simulation(bar(hinged=False), bar_skin(), effects, objects=(body,), layer=ElasticLayer(2e4))
    forces, poses = run(simulation, 1.0)
    assert forces[-1] == pytest.approx(MASS * GRAVITY, rel=1e-6)
    assert TOP + diagonal - poses[-1][2, 3] == pytest.approx(MASS * GRAVITY / 2e4, rel=0.01)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("mass", [0.05, 0.5, 20.0])
@pytest.mark.parametrize("share", [0.35, 0.95])
@pytest.mark.parametrize("shape", ["box", "cylinder"])
def test_body_below_the_friction_angle_stays(shape, share, mass, integrator):
    """MuJoCo's friction creeps: it is viscous up to Coulomb's force."""
    stiffness = 2e4 if mass > 0.1 else 2e3
    slope = share * np.arctan(0.5)
    simulation = resting(shape, integrator, slope=slope, mass=mass, stiffness=stiffness)
    run(simulation, 0.5)
    forces, poses = run(simulation, 1.0)
    assert abs(poses[-1][0, 3] - poses[0][0, 3]) < 1e-4, "less than 0.1 mm/s"
    np.testing.assert_allclose(forces, mass * GRAVITY * np.cos(slope), rtol=2e-3)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("friction", [0.2, 0.5])
def test_body_beyond_the_friction_angle_slides_by_the_coulomb_law(friction, integrator):
    slope = np.arctan(friction) + np.radians(5.0)
    simulation = resting("box", integrator, slope=slope, friction=friction)
    forces, poses = run(simulation, 0.4)
    expected = GRAVITY * (np.sin(slope) - friction * np.cos(slope))
    times = 0.005 * np.arange(1, len(poses) + 1)
    assert 2 * np.polyfit(times, poses[:, 0, 3], 2)[0] == pytest.approx(expected, rel=0.01)
    np.testing.assert_allclose(forces[20:], MASS * GRAVITY * np.cos(slope), rtol=0.02)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize(("friction", "error"), [(0.5, 0.02), (0.9, 0.03)])
def test_sliding_body_is_braked_by_the_coulomb_law(friction, error, integrator):
    simulation = resting("box", integrator, friction=friction)
    simulation._data.qvel[0] = 0.8
    simulation._physics.forward()
    _, poses = run(simulation, 0.05, every=1)
    times = simulation.timestep * np.arange(len(poses))
    assert -2 * np.polyfit(times, poses[:, 0, 3], 2)[0] == pytest.approx(friction * GRAVITY, rel=error)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_fast_sliding_body_does_not_hop(integrator):
    """The effect of friction on the normal direction of MuJoCo's convex model is limited."""
    slope = np.radians(40.0)
    simulation = resting("box", integrator, slope=slope, friction=0.5)
    forces, poses = run(simulation, 0.35, every=1)
    assert np.ptp(poses[:, 0, 3]) > 0.1
    assert (forces[20:] > 0.9 * MASS * GRAVITY * np.cos(slope)).all(), "contact is never lost"
    depth = -simulation._data.contact.dist.min()
    resting_depth = MASS * GRAVITY * np.cos(slope) / 2e4
    # ``discrete`` rebuilds its constraints, so that what friction adds cannot be subtracted: it lifts the body.
    assert (0.0 if integrator == "discrete" else 0.75) * resting_depth < depth < resting_depth


@pytest.mark.long
@pytest.mark.sampled(3)
@pytest.mark.parametrize("integrator", ["implicitfast", "discrete"])
@pytest.mark.parametrize("torque", [(0.0, 0.0), (0.02, 0.03), (0.0, 0.05)])
@pytest.mark.parametrize("shape", SHAPES)
def test_centre_of_pressure_of_a_face_follows_from_statics(shape, torque, integrator):
    """A torque on the body moves the centre by torque over weight; punch is off by up to 30 mm with one point."""
    simulation = resting(shape, integrator, skin="punch", felt_by=each_point_a_taxel(bar_skin()))
    body = simulation._model.body(f"tactile-maps/object {simulation._objects[0].spec.name}").id
    simulation._data.xfrc_applied[body, 3:5] = torque
    run(simulation, 1.0)
    skin = simulation._skin
    forces = simulation.sense() * skin.areas
    (patch,) = skin.patches
    centre = forces @ patch.taxels.positions / forces.sum()
    away = np.array([torque[1], -torque[0]]) / (MASS * GRAVITY)
    assert forces.sum() == pytest.approx(MASS * GRAVITY, rel=1e-4)
    assert centre[:2] == pytest.approx(simulation.object_poses[0, :2, 3] + away, abs=1e-6)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("stiffness", [2e4, 2e5])
def test_ball_rolls_about_the_centre_of_its_contact(stiffness, integrator):
    """Friction acts in the middle of the overlap, nearer than the radius by half the depth: soft covers slow a ball."""
    slope = np.radians(5.0)
    radius = 0.02
    body = thing("sphere", at=(0.08, 0.0, TOP + radius - MASS * GRAVITY / stiffness), mass=MASS)
    effects = Effects(contact="environment", gravity="on", friction=True, integrator=integrator)
    simulation = Simulation(
        bar(hinged=False), bar_skin(), effects, objects=(body,), layer=ElasticLayer(stiffness=stiffness)
    )
    simulation._model.opt.gravity[:] = GRAVITY * np.sin(slope), 0.0, -GRAVITY * np.cos(slope)
    simulation._physics.forward()
    _, poses = run(simulation, 0.6)
    lever = radius - 0.5 * MASS * GRAVITY * np.cos(slope) / stiffness
    times = 0.005 * np.arange(1, len(poses) + 1)
    found = 2 * np.polyfit(times, poses[:, 0, 3], 2)[0]
    assert found == pytest.approx(GRAVITY * np.sin(slope) / (1 + 0.4 * (radius / lever) ** 2), rel=5e-4)


TURRET = """<mujoco><worldbody><body name="turret" pos="0 0 0.5">
<joint name="turn" axis="0 0 1" range="-2 2" armature="0.01"/><geom type="cylinder" size="0.06 0.08" mass="2"/>
</body></worldbody></mujoco>"""


def test_link_with_its_centre_of_mass_on_its_axis_is_as_stiff_as_its_cover(tmp_path):
    file = tmp_path / "turret.xml"
    file.write_text(TURRET)
    scene = scene_for(str(file))
    turret = prepare(replace(scene, cover=replace(scene.cover, links=("turret",), taxels=60), stimuli=()))
    positions = turret.skin.patches[0].taxels.positions
    taxel = int(np.argmax(positions[:, 0] - 10 * np.abs(positions[:, 2])))
    session = Session(with_fixed_ball(turret, taxel=taxel, radius=0.02, depth=1e-3, model="water-fill"))
    session.tick()
    assert session.total_normal_force == pytest.approx(1e-3 * turret.scene.layer.stiffness, rel=0.03)


@pytest.mark.long
@pytest.mark.parametrize("pitch", [0.005, 0.006, 0.007])
def test_box_rests_flat_on_a_finely_divided_flat_skin(pitch):
    """Corners inside the flat face of the hull would give one contact, which changes its place each tick."""
    top = plate((-0.06, -0.06, 0.04), (0.12, 0, 0), (0, 0.12, 0), steps=(24, 24))
    bottom = plate((-0.06, 0.06, 0.0), (0.12, 0, 0), (0, -0.12, 0), steps=(24, 24))
    faces = np.concatenate([top.faces, bottom.faces + len(top.vertices)])
    block = Mesh(np.concatenate([top.vertices, bottom.vertices]), faces)
    robot = robot_of_mesh(block, name="block", source="block.obj")
    (link,) = (link.name for link in robot.links)
    skin = cover_robot(robot, CoverSpec((link,), pitch=pitch))
    height = Configuration(robot).pose(link).points(skin.patches[0].surface.vertices)[:, 2].max()
    body = thing("box", size=(0.05, 0.05, 0.05), at=(0, 0, height + 0.025 - 2 * GRAVITY / 2e4), mass=2.0)
    effects = Effects(contact="environment", gravity="on", friction=True)
    force, poses = run(Simulation(robot, skin, effects, objects=(body,), layer=ElasticLayer(2e4)), 0.3)
    np.testing.assert_allclose(force[len(force) // 2 :], 2 * GRAVITY, rtol=1e-3)
    assert np.abs(poses[:, 2, :2]).max() < 1e-4, "it does not tilt"
