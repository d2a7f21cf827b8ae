"""Stated stiffness is real stiffness: a cover given in N/m measures that in N/m, on any link, posture and body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from app.robots.configuration import Configuration
from app.scene.effects import Effects
from app.simulation.simulation import Simulation
from app.touch.layer import Layer
from tests.things import thing
from tests.touch import arm, hold

TAXELS = (20, 150, 280)
"""On upper arm, forearm and hand."""


def facing(normal: np.ndarray) -> tuple[float, ...]:
    """Turns [deg] that bring the z axis to ``normal``."""
    z = normal / np.linalg.norm(normal)
    x = np.cross([0.0, 1.0, 0.3], z)
    x /= np.linalg.norm(x)
    return tuple(Rotation.from_matrix(np.stack([x, np.cross(z, x), z], axis=1)).as_euler("xyz", degrees=True))


def pressed(
    kind: str,
    taxel: int,
    turned: float,
    deep: float,
    layer: Layer,
    *,
    held: float = 20000.0,
    seconds: float = 1.5,
    **effects,
) -> Simulation:
    """A thing fixed or sprung ``deep`` in the arm's skin, joints held at a posture ``turned`` from home, at rest."""
    prepared = arm()
    robot = replace(prepared.robot, home=prepared.robot.home + turned * np.sin(np.arange(7)))
    at = prepared.skin.taxel_point(taxel)
    configuration = Configuration(robot)
    pose = configuration.pose(prepared.skin.link(at))
    normal = pose.directions(prepared.skin.normal(at))
    half = {"probe": 0.01, "sphere": 0.02, "mesh": 0.02}.get(kind, 0.01)
    said = {"plate": {"stiffness": 2000.0, "damping": 1.0, "mass": 0.2}, "probe": {"mass": 0.2}}.get(kind, {})
    centre = pose.points(prepared.skin.position(at)) + (half - deep) * normal
    body = thing(kind, at=tuple(centre), turn=facing(normal), **said)
    simulation = Simulation(
        robot, prepared.skin, Effects(contact="environment", **effects), objects=(body,), layer=layer
    )
    simulation.step(round(seconds / simulation.timestep), hold(robot, held, 0.015 * held))
    return simulation


def measured(simulation: Simulation) -> tuple[float, float]:
    """Force [N] and stiffness [N/m] of the one contact."""
    (load,) = simulation._physics.loads()
    (depth,) = -simulation._data.contact.dist
    return load.force, load.force / depth


@pytest.mark.parametrize("taxel", TAXELS)
@pytest.mark.parametrize("kind", ["probe", "sphere", "box", "cylinder", "mesh", "plate"])
def test_a_contact_measures_what_the_layer_states(kind, taxel):
    for turned, stiffness in ((0.0, 2e4), (0.3, 5e4), (-0.4, 5e3)):
        deep = 5e-3 if kind in ("probe", "plate") else 5e-4
        force, found = measured(pressed(kind, taxel, turned, deep, Layer(stiffness=stiffness)))
        assert force > 0.5
        assert found == pytest.approx(stiffness, rel=0.01)


@pytest.mark.parametrize("integrator", ["implicitfast", "discrete", "euler", "implicit", "rk4"])
def test_whatever_integrates(integrator):
    for friction in (False, True):
        how = {"held": 200.0, "seconds": 5.0, "integrator": integrator, "friction": friction}
        assert measured(pressed("sphere", 150, 0.2, 5e-4, Layer(stiffness=2e4), **how))[1] == pytest.approx(
            2e4, rel=0.01
        )


@pytest.mark.parametrize("held", [200.0, 2000.0, 20000.0])
def test_an_implicit_integrator_is_as_stiff_however_stiff_the_joints_are(held):
    """``discrete`` weighs bodies with their servos: without care the contact would be up to seven times as stiff."""
    run = pressed("sphere", 150, 0.2, 5e-4, Layer(stiffness=2e4), held=held, integrator="discrete")
    assert measured(run)[1] == pytest.approx(2e4, rel=0.01)


def test_more_force_goes_deeper_in_proportion():
    """A plate on a known spring: its own springs' ratio gives the skin's stiffness without looking at contacts."""
    prepared, depths, forces = arm(), [], []
    for deep in (2e-3, 5e-3, 9e-3):
        simulation = pressed("plate", 150, 0.0, deep, Layer(stiffness=2e4))
        rest = simulation._objects[0].spec.pose
        back = (simulation.object_poses[0, :3, 3] - rest.translation) @ rest.rotation[:, 2]
        forces.append(2000.0 * back)
        depths.append(-simulation._data.contact.dist[0])
        assert simulation.sense() @ prepared.skin.areas == pytest.approx(forces[-1], rel=1e-4)
    slopes = np.diff(forces) / np.diff(depths)
    assert slopes == pytest.approx(np.full(2, 2e4), rel=0.01)


@pytest.mark.parametrize("taxel", [241, 283, 289])
def test_a_plane_is_one_contact_too(taxel):
    """Lying on a plane a hull has up to four contacts in MuJoCo, which would be four times as stiff."""
    prepared = arm()
    robot, home, at = prepared.robot, Configuration(prepared.robot), prepared.skin.taxel_point(taxel)
    normal = home.pose(prepared.skin.link(at)).directions(prepared.skin.normal(at))
    cloud = np.concatenate([home.pose(link.name).points(link.mesh.vertices) for link in robot.links])
    wall = thing("plane", at=tuple(((cloud @ normal).max() - 5e-4) * normal), turn=facing(-normal))
    simulation = Simulation(robot, prepared.skin, Effects(contact="environment"), objects=(wall,))
    simulation.step(1000, hold(robot, 20000.0, 300.0))
    assert measured(simulation)[1] == pytest.approx(2e4, rel=0.01)
