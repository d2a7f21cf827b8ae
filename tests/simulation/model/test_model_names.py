"""A robot may call its parts as it likes: nothing of it is taken for a hull or an object."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import RobotError
from tactile_maps.geometry.remesh.refine import subdivide
from tactile_maps.robots.load import load_robot_file
from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.model.contact_stiffness import unstable_contacts
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.model.model_names import body_name, is_hull, is_object, plain_name, shape_name
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.skin.link_hulls import hull_name
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tests.support.scene_objects import thing
from tests.support.touch import hold

TWO_LINKS = """<mujoco><compiler angle="radian"/><worldbody><body name="upper">
<inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/><joint name="{joint}" axis="0 1 0" range="-1 1"/>
<geom name="{first}" type="box" size="0.1 0.1 0.1"/>
<body name="{link}" pos="0.5 0 0"><inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
<joint name="second" axis="0 1 0" range="-1 1"/><geom name="{second}" type="box" size="0.1 0.1 0.1"/>
</body></body></worldbody></mujoco>"""
PLAIN = {"joint": "one", "first": "a", "second": "b", "link": "lower"}
CLASHING = {"joint": "object ball", "first": "skin upper", "second": "object ball", "link": "object ball"}
OBJECTS = {"joint": "skin upper", "first": "object floor", "second": "skin upper", "link": "object floor"}
BALL = thing("box", name="ball", size=(0.04, 0.04, 0.04), at=(0.0, 0.0, 0.121), mass=1.0)
FLOOR = thing("plane", name="floor", at=(0.0, 0.0, -0.3))


def robot_with(tmp_path, names):
    path = tmp_path / "robot.xml"
    path.write_text(TWO_LINKS.format(**names))
    return load_robot_file(path)


def skin_of(robot):
    surface = subdivide(robot.link("upper").mesh, longest=0.02).mesh
    return Skin((Patch("upper", "upper", surface, place_evenly(surface, 200, seed=0)),))


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("names", [CLASHING, OBJECTS])
@pytest.mark.parametrize("skin", ["half-space", "foundation", "depth"])
def test_renamed_robot_is_simulated_identically(tmp_path, names, skin):
    runs = []
    for robot in (robot_with(tmp_path, PLAIN), robot_with(tmp_path, names)):
        effects = Effects(contact="all", gravity="on", skin=skin)
        simulation = Simulation(robot, skin_of(robot), effects, objects=(BALL, FLOOR))
        pressures = []
        for _ in range(60):
            simulation.step(2, hold(robot, 500.0, 50.0))
            pressures.append(simulation.sense())
        assert np.any(pressures), "the ball has come down on the skin"
        runs.append(np.concatenate([*pressures, simulation.state(), simulation.object_poses.ravel()]))
    np.testing.assert_array_equal(*runs)


def test_notes_use_the_names_of_the_model_files(tmp_path):
    robot = robot_with(tmp_path, CLASHING)
    layer = ElasticLayer(stiffness=1e8)
    model = assemble(robot, skin_of(robot), Effects(contact="all"), objects=(BALL,), layer=layer)
    notes = unstable_contacts(model, layer)
    assert any(set(note.bodies) == {"upper", "ball"} for note in notes)
    assert not any("tactile-maps" in name for note in notes for name in note.bodies)


@pytest.mark.parametrize("part", list(PLAIN))
def test_reserved_names_are_rejected(tmp_path, part):
    with pytest.raises(RobotError, match=r"robot\.xml.*name is reserved.*tactile-maps/skin upper.*does not begin"):
        robot_with(tmp_path, {**PLAIN, part: "tactile-maps/skin upper"})


def test_name_identifies_its_element():
    assert is_hull(hull_name("upper"))
    assert not is_hull("skin upper")
    assert is_object(body_name(BALL.spec))
    assert not is_object("object ball")
    assert not is_object(shape_name(0))
    assert [plain_name(name) for name in (hull_name("a"), body_name(BALL.spec), body_name(FLOOR.spec), "b")] == [
        "a",
        "ball",
        "floor",
        "b",
    ]
