"""Shear where links of the robot touch each other: third law on both sides, statics, and Coulomb's law in motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.motion.command import JointCommand
from tactile_maps.robots.model.robot import Joint, Link, Robot
from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.contact_notes import ContactNoteKind
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tests.support.touch import hold, pair

PRESS = 8.0
GRAVITY = 9.81
FRICTION = 0.5
JOINTS = ("x", "y", "z", "turn")
_BLOCKS = """<mujoco model="blocks"><compiler angle="radian"/><worldbody>
<body name="left" pos="-0.065 0 0"><inertial pos="0 0 0" mass="0.2" diaginertia="0.01 0.01 0.01"/>
<joint name="x" type="slide" axis="1 0 0" range="-0.05 0.05" limited="true"/>
<joint name="y" type="slide" axis="0 1 0" range="-0.05 0.05" limited="true"/>
<joint name="z" type="slide" axis="0 0 1" range="-0.05 0.05" limited="true"/>
<geom type="box" size="0.05 0.05 0.05"/></body>
<body name="right" pos="0.065 0 0"><inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
<joint name="turn" type="hinge" axis="1 0 0" range="-3 3" limited="true"/>
<geom type="box" size="0.05 0.05 0.05"/></body></worldbody></mujoco>"""


def blocks() -> tuple[Robot, Skin]:
    """A block on slides along x, y and z before one that turns about x, with skin on the faces that meet.

    Without meshes the skin bears all of the load: the sides of a block would bear a thousandth of it at the edges.
    """
    _, skin = pair()
    links = (Link("left", None), Link("right", None))
    slides = tuple(Joint(name, -0.05, 0.05, slide=True) for name in JOINTS[:3])
    joints = (*slides, Joint("turn", -3.0, 3.0))
    return Robot("blocks", "by hand", _BLOCKS, {}, links, joints, np.zeros(4)), skin


def axes_of_faces(skin: Skin) -> np.ndarray:
    """Axes of the taxels on both faces; the first tangent is z on the left and y on the right face."""
    left = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
    right = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])
    return np.stack([left if patch == 0 else right for patch in skin.patch_of])


def touching(model: str = "water-fill", *, gravity: str = "off", **effects) -> tuple[Simulation, JointCommand]:
    """Both blocks, and the command that presses them together and holds all but z."""
    robot, skin = blocks()
    on = {"contact": "self", "friction": True, "shear": True, "skin": model, "gravity": gravity, **effects}
    simulation = Simulation(
        robot, skin, Effects(**on), layer=ElasticLayer(friction=FRICTION), frames=lambda: axes_of_faces(skin)
    )
    command = replace(
        hold(robot, 0.0, 0.0),
        stiffness=np.array([0.0, 2000.0, 0.0, 20.0]),
        damping=np.array([40.0, 40.0, 0.0, 2.0]),
        torque=np.array([PRESS, 0.0, 0.0, 0.0]),
    )
    return simulation, command


def forces(simulation: Simulation) -> np.ndarray:
    """(2, 3) sum of the shear that each face reads, world frame [N]; call it after ``sense``."""
    skin = simulation._skin
    frames = axes_of_faces(skin)
    taxels = np.einsum("n,nk,nkd->nd", skin.areas, simulation.shear, frames[:, :2])
    data = simulation._data
    return np.array(
        [
            data.body(patch.link).xmat.reshape(3, 3) @ taxels[skin.patch_of == number].sum(axis=0)
            for number, patch in enumerate(skin.patches)
        ]
    )


def read(simulation: Simulation, command: JointCommand, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Return pressures (taxels,) [Pa] and ``forces`` (2, 3) after some steps.

    The contacts are those of the poses before the last step; the right block turns by then.
    """
    simulation.step(steps, command)
    turned = simulation._data.body("right").xmat.copy()
    pressures = simulation.sense()
    left, right = forces(simulation)
    now = simulation._data.body("right").xmat.reshape(3, 3)
    return pressures, np.array([left, turned.reshape(3, 3) @ now.T @ right])


@pytest.mark.parametrize("model", ["point", "water-fill", "punch"])
def test_block_held_by_friction_shears_both_faces_with_its_weight(model):
    simulation, command = touching(model, gravity="on")
    held = replace(
        command, stiffness=np.array([0.0, 2000.0, 20_000.0, 20.0]), damping=np.array([40.0, 40.0, 100.0, 2.0])
    )
    simulation.step(500, held)
    pressures, (left, right) = read(simulation, command, 300)
    weight = 0.2 * GRAVITY
    assert np.abs(simulation.velocity).max() < 1e-4, "it is held"
    np.testing.assert_allclose(left, [0.0, 0.0, weight], atol=2e-3)
    np.testing.assert_allclose(right, -left, atol=1e-12 * weight)
    areas = simulation._skin.areas
    faces = simulation._skin.patch_of == 0
    assert pressures[faces] @ areas[faces] == pytest.approx(PRESS, rel=1e-4)
    assert pressures[~faces] @ areas[~faces] == pytest.approx(pressures[faces] @ areas[faces], rel=1e-12)
    assert {sheared.load.link for sheared in simulation.sheared} == {"left", "right"}


@pytest.mark.parametrize(
    "model", ["point", *(pytest.param(model, marks=pytest.mark.long) for model in ("water-fill", "punch"))]
)
def test_shear_of_moving_links_is_equal_and_opposite_at_every_reading(model):
    """A block is dragged along y while the other turns: sums, torques and used friction agree on both sides."""
    simulation, command = touching(model)
    simulation.step(300, command)
    largest = 0.0
    for tick in range(60):
        drag = replace(command, posture=np.array([0.0, 0.02 * np.sin(0.2 * tick), 0.0, 0.01 * tick]))
        pressures, (left, right) = read(simulation, drag, 5)
        size = np.linalg.norm(left)
        largest = max(largest, size)
        np.testing.assert_allclose(right, -left, atol=1e-12 * max(size, 0.01 * PRESS))
        one, other = simulation.sheared
        assert one.load.torque == pytest.approx(other.load.torque, abs=1e-12 * PRESS * 0.05)
        assert one.usage == pytest.approx(other.usage, rel=1e-9)
        taxels = np.linalg.norm(simulation.shear, axis=1)
        assert (taxels <= FRICTION * pressures * (1 + 1e-9) + 1e-9).all()
    assert largest == pytest.approx(FRICTION * PRESS, rel=0.02), "it slid"


def test_sliding_face_has_the_coulomb_force_against_its_motion():
    simulation, command = touching()
    simulation.step(300, command)
    for sign in (1.0, -1.0):
        drag = replace(command, posture=np.array([0.0, 0.03 * sign, 0.0, 0.0]))
        pressures, (left, right) = read(simulation, drag, 20)
        assert sign * simulation.velocity[1] > 0.05
        face = simulation._skin.patch_of == 0
        limit = FRICTION * float(pressures[face] @ simulation._skin.areas[face])
        np.testing.assert_allclose(left, [0.0, -sign * limit, 0.0], atol=0.01 * limit)
        np.testing.assert_allclose(right, -left, atol=1e-12 * PRESS)
        assert [sheared.stuck for sheared in simulation.sheared] == [0.0, 0.0]
    assert not [note for note in simulation.notes if note.kind is ContactNoteKind.FRICTION_EXCEEDED]


def test_rotating_face_applies_torque_to_the_other():
    """Torsion without a net force: the shear of each face circles about the middle."""
    simulation, command = touching()
    simulation.step(300, command)
    turning = replace(command, posture=np.array([0.0, 0.0, 0.0, 0.005]))
    turning = replace(turning, stiffness=np.array([0.0, 2000.0, 2000.0, 20.0]))
    _, (left, right) = read(simulation, turning, 400)
    one, other = simulation.sheared
    assert np.linalg.norm(left) < 0.2 * FRICTION * PRESS
    np.testing.assert_allclose(right, -left, atol=1e-12 * PRESS)
    assert abs(one.load.torque) > 0.02 * FRICTION * PRESS
    skin = simulation._skin
    for number, sheared in ((0, one), (1, other)):
        own = skin.patch_of == number
        frames = axes_of_faces(skin)[own]
        taxels = np.einsum("n,nk,nkd->nd", skin.areas[own], simulation.shear[own], frames[:, :2])
        arms = skin.patches[number].taxels.positions - sheared.load.point
        twist = np.cross(arms, taxels).sum(axis=0) @ sheared.load.normal
        assert twist == pytest.approx(sheared.load.torque, rel=0.1), "taxels read the mean over their cells"


def test_averaged_shear_of_both_sides_agrees():
    simulation, command = touching(time_averaging=True)
    simulation.step(300, command)
    drag = replace(command, posture=np.array([0.0, 0.03, 0.0, 0.0]))
    _, (left, right) = read(simulation, drag, 10)
    assert np.linalg.norm(left) > 0.5 * FRICTION * PRESS
    np.testing.assert_allclose(right, -left, atol=1e-12 * PRESS)
