"""Objects in the physics: shape, mass, freedom, motors, springs and paths."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.objects import MIN_MOVING_MASS, OBJECT_KINDS
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.model.object_geoms import (
    PROBE_STIFFNESS,
    ProbePath,
    has_body,
    hull_notes,
    is_simulated,
)
from tactile_maps.simulation.simulation import Simulation
from tests.support.scene_objects import thing
from tests.support.touch import bar, bar_skin, no_command

WORLD = Effects(contact="environment")
FAR = (5.0, 1.0, 2.0)


def model_with(*things, effects=WORLD):
    return assemble(bar(), bar_skin(), effects, objects=things)


def alone(*things, seconds: float, effects=WORLD) -> Simulation:
    simulation = Simulation(bar(), bar_skin(), effects, objects=things)
    simulation.step(round(seconds / simulation.timestep), no_command(bar()))
    return simulation


@pytest.mark.parametrize(
    ("kind", "shape", "size"),
    [
        ("box", "BOX", (0.03, 0.025, 0.01)),
        ("plate", "BOX", (0.03, 0.03, 0.01)),
        ("sphere", "SPHERE", (0.02, 0, 0)),
        ("probe", "SPHERE", (0.01, 0, 0)),
        ("cylinder", "CYLINDER", (0.03, 0.01, 0)),
        ("plane", "PLANE", (0.5, 0.5, 1)),
    ],
)
def test_primitives_have_the_size_stated_in_the_scene(kind, shape, size):
    geom = model_with(thing(kind, at=FAR)).geom(f"tactile-maps/object {kind}")
    assert geom.type[0] == getattr(mujoco.mjtGeom, f"mjGEOM_{shape}")
    assert geom.size == pytest.approx(size)


@pytest.mark.parametrize("kind", ["box", "sphere", "cylinder", "mesh"])
def test_object_with_mass_is_free_and_without_mass_fixed(kind):
    free = model_with(thing(kind, at=FAR, mass=0.7))
    fixed = model_with(thing(kind, at=FAR))
    assert free.body(f"tactile-maps/object {kind}").mass[0] == pytest.approx(0.7)
    assert (free.nv, fixed.nv) == (7, 1)


def test_guided_weight_falls_straight_in_any_orientation():
    weight = thing("cylinder", at=(5.0, 1.0, 20.0), turn=(30.0, 40.0, 50.0), mass=0.7, guided=True)
    assert model_with(weight).nv == 2
    simulation = alone(weight, seconds=1.0)
    assert simulation.object_poses[0, :3, 3] == pytest.approx((5.0, 1.0, 20.0 - 0.5 * 9.81), rel=2e-3)
    assert simulation.object_poses[0, :3, :3] == pytest.approx(weight.spec.pose.rotation)


def test_spring_of_a_plate_has_the_stated_stiffness_along_its_axis():
    plate = thing("plate", at=FAR, turn=(90.0, 0.0, 0.0), mass=0.5, stiffness=300.0, damping=1.0)
    simulation = Simulation(bar(), bar_skin(), WORLD, objects=(plate,))
    body = simulation._model.body("tactile-maps/object plate").id
    push = np.array([1.0, 2.0, 3.0])
    simulation._data.xfrc_applied[body, :3] = push
    simulation.step(3000, no_command(bar()))
    axis = plate.spec.pose.rotation[:, 2]
    moved = simulation.object_poses[0, :3, 3] - FAR
    assert moved == pytest.approx((axis @ push / 300.0) * axis, abs=1e-9)


def test_plate_oscillates_with_the_stated_damping():
    plate = thing("plate", at=FAR, mass=0.5, stiffness=300.0, damping=0.1)
    simulation = Simulation(bar(), bar_skin(), Effects(contact="environment", timestep=1e-4), objects=(plate,))
    omega = np.sqrt(300.0 / 0.5)
    share = 0.1
    simulation._data.qpos[1] = 0.01
    period = 2 * np.pi / (omega * np.sqrt(1 - share**2))
    simulation.step(round(period / 1e-4), no_command(bar()))
    left = (simulation.object_poses[0, :3, 3] - FAR) @ plate.spec.pose.rotation[:, 2]
    assert left == pytest.approx(0.01 * np.exp(-share * omega * period), rel=5e-3)


def test_probe_repeats_its_path():
    path = ((0.0, *FAR), (1.0, 5.2, 1.0, 2.0), (2.0, *FAR))
    probe = thing("probe", at=(9.0, 9.0, 9.0), path=path)
    simulation = Simulation(bar(), bar_skin(), WORLD, objects=(probe,))
    assert simulation.object_poses[0, :3, 3] == pytest.approx(FAR), "it starts on its path"
    lag = 2 * np.sqrt(MIN_MOVING_MASS / PROBE_STIFFNESS)
    for seconds in (0.5, 2.5):
        simulation.step(round((seconds - simulation.time) / 0.001), no_command(bar()))
        assert simulation.object_poses[0, 0, 3] == pytest.approx(5.1 - 0.2 * lag, abs=2e-4)


def test_motors_of_a_probe_never_exceed_their_force():
    probe = thing("probe", at=FAR, mass=2.0, max_force=3.0, path=((0.0, *FAR), (0.001, 9.0, 9.0, 2.0), (9.0, 9, 9, 2)))
    simulation = Simulation(bar(), bar_skin(), WORLD, objects=(probe,))
    for _ in range(50):
        simulation.step(1, no_command(bar()))
        assert np.abs(simulation._data.actuator_force[1:]).max() <= 3.0
    assert simulation._data.actuator_force[1] == 3.0


def test_probe_path_gives_the_position_at_any_time():
    path = ProbePath(thing("probe", path=((0.5, 0.0, 0.0, 0.0), (1.0, 1.0, 0.0, 0.0), (2.0, 1.0, 2.0, 0.0))).spec)
    for time, place in ((0.0, (0, 0, 0)), (0.5, (0, 0, 0)), (0.75, (0.5, 0, 0)), (1.5, (1, 1, 0)), (2.75, (0.5, 0, 0))):
        assert path.place(time) == pytest.approx(place), time
    assert ProbePath(thing("probe", at=FAR).spec).place(7.0) == pytest.approx(FAR)
    assert ProbePath(thing("probe", path=((0.0, *FAR),)).spec).place(7.0) == pytest.approx(FAR)


def test_simulated_kinds_follow_the_contact_effect():
    takers = {
        mode: {kind for kind in OBJECT_KINDS if is_simulated(kind, Effects(contact=mode))}
        for mode in ("off", "probe", "environment", "self", "all")
    }
    assert takers["off"] == takers["self"] == set()
    assert takers["probe"] == {"probe"}
    assert takers["environment"] == takers["all"] == set(OBJECT_KINDS)
    assert not any(is_simulated(kind, Effects(contact="all", dynamics=False)) for kind in OBJECT_KINDS)
    assert not has_body(model_with(effects=Effects()), thing("box").spec)


@pytest.mark.parametrize("kind", ["box", "sphere", "cylinder", "plane"])
def test_convex_mesh_has_no_note_about_its_hull(kind):
    assert hull_notes(thing("mesh", mesh=thing(kind).mesh)) == ()
    assert hull_notes(thing(kind)) == ()


def test_hull_above_hollow_faces_is_noted_even_without_hollow_vertices():
    """The top is folded along one diagonal: 0.02 m of air are over the middles of its faces, which are inclined."""
    corners = np.array([[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0], [0, 0, 0.01], [0.1, 0, 0.04],
                        [0.1, 0.1, 0.01], [0, 0.1, 0.04]])  # fmt: skip
    faces = np.array([[0, 3, 2], [0, 2, 1], [0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6],
                      [3, 0, 4], [3, 4, 7], [4, 5, 6], [4, 6, 7]])  # fmt: skip
    (note,) = hull_notes(thing("mesh", mesh=Mesh(corners, faces)))
    assert note.depth == pytest.approx(0.0217, rel=0.01)
