"""Contact points between shapes with faces: their direction, and the points of a cylinder's cap."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tactile_maps.scene.effects import Effects
from tactile_maps.scene.objects import SceneObject
from tactile_maps.simulation.model.contact_points import centre_on_cap, centre_on_side, correct_normal, frame_along
from tactile_maps.simulation.model.model_assembly import assemble
from tests.support.scene_objects import thing
from tests.support.touch import bar, bar_skin

TOP = 0.02


def touching(body: SceneObject, **joint) -> tuple[mujoco.MjModel, mujoco.MjData, list[int]]:
    """The fixed body on the bar turned by ``angle``, with the contacts that MuJoCo finds."""
    model = assemble(bar(), bar_skin(), Effects(contact="environment"), objects=(body,))
    data = mujoco.MjData(model)
    data.qpos[0] = joint.get("angle", 0.0)
    mujoco.mj_fwdPosition(model, data)
    return model, data, list(range(data.ncon))


def test_finely_divided_ball_is_pushed_along_the_normal_of_the_plane_it_touches():
    """MuJoCo takes the normal of one of the ball's faces, which is up to 5 degrees off."""
    model, data, numbers = touching(thing("mesh", at=(0.3, 0.01, TOP + 0.02 - 2e-4)))
    assert data.contact.frame[0, 2] < 0.997
    assert correct_normal(model, data, numbers)
    mujoco.mj_makeConstraint(model, data)
    assert data.contact.frame[0, :3] == pytest.approx((0, 0, 1), abs=1e-9)
    deepest = int(data.contact.dist.argmin())
    assert data.contact.dist[deepest] == pytest.approx(-2e-4, rel=1e-4)
    assert data.contact.pos[deepest] == pytest.approx((0.3, 0.01, TOP - 1e-4), abs=1e-5)


@pytest.mark.parametrize("angle", [0.0, -1e-3, -2e-2])
def test_contact_points_of_a_box_on_a_plane_are_unchanged(angle):
    """Also those of a tilted box: they are its corners, and the normal is that of the plane."""
    model, data, numbers = touching(thing("box", at=(0.3, 0.01, TOP + 0.01 - 2e-4)), angle=angle)
    before = data.contact.pos.copy(), data.contact.dist.copy()
    assert len(numbers) == 4
    assert not correct_normal(model, data, numbers)
    assert not centre_on_cap(model, data, numbers)
    assert np.array_equal(data.contact.pos, before[0])
    assert np.array_equal(data.contact.dist, before[1])


@pytest.mark.parametrize("angle", [0.0, -1e-3])
@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (180.0, 0.0, 77.0)])
def test_contact_points_of_a_disc_are_four_equally_spaced_points_on_its_rim(turn, angle):
    model, data, numbers = touching(thing("cylinder", at=(0.3, 0.01, TOP + 0.01 - 2e-4), turn=turn), angle=angle)
    normal = data.contact.frame[0, :3].copy()
    found = data.contact.pos.copy() + 0.0
    plane = found[0] - 0.5 * data.contact.dist[0] * -normal
    assert centre_on_cap(model, data, numbers)
    centre = data.contact.pos.mean(axis=0)
    assert centre[:2] == pytest.approx((0.3, 0.01), abs=1e-6)
    sides = np.linalg.norm(np.diff(data.contact.pos, axis=0, append=data.contact.pos[:1]), axis=1)
    assert sides == pytest.approx(np.full(4, 0.03 * np.sqrt(2)), rel=1e-4)
    on_plane = data.contact.pos + 0.5 * data.contact.dist[:, None] * normal
    assert (on_plane - plane) @ normal == pytest.approx(np.zeros(4), abs=1e-12), "depths are those below the plane"


def test_disc_extending_beyond_the_skin_keeps_its_points():
    model, data, numbers = touching(thing("cylinder", at=(0.385, 0.01, TOP + 0.01 - 2e-4)))
    before = data.contact.pos.copy()
    assert not centre_on_cap(model, data, numbers)
    assert np.array_equal(data.contact.pos, before)


@pytest.mark.parametrize("normal", [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.6, 0.0, -0.8), (1 / 3, 2 / 3, 2 / 3)])
def test_contact_frame_is_right_handed(normal):
    frame = frame_along(np.array(normal))
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(frame) == pytest.approx(1)
    np.testing.assert_array_equal(frame[0], normal)


@pytest.mark.parametrize("angle", [0.0, -1e-3])
def test_points_of_a_roller_are_on_its_deepest_line(angle):
    """MuJoCo's points are up to 30 um off, and each gives the roller a torque."""
    roller = thing("cylinder", size=(0.012, 0.03), at=(0.3033, 0.01, TOP + 0.012 - 2e-4), turn=(90.0, 0.0, 31.0))
    model, data, numbers = touching(roller, angle=angle)
    normal = data.contact.frame[0, :3].copy()
    assert len(numbers) == 2
    data.contact.pos[numbers, 0] += 2e-5
    assert centre_on_side(model, data, numbers)
    geom = int(data.contact.geom[0, 0])
    arms = data.contact.pos[numbers] - data.geom_xpos[geom]
    axis = data.geom_xmat[geom].reshape(3, 3)[:, 2]
    across = arms - np.outer(arms @ axis, axis)
    assert np.cross(across, normal) == pytest.approx(0.0, abs=1e-5 * 0.012 + abs(normal @ axis) * 0.012)
    assert not centre_on_cap(model, data, numbers)


def test_contact_points_of_a_disc_and_a_box_are_not_biased_to_a_side():
    for body in (thing("cylinder", at=(0.3, 0.01, TOP + 0.0098)), thing("box", at=(0.3, 0.01, TOP + 0.0098))):
        model, data, numbers = touching(body)
        assert numbers
        assert not centre_on_side(model, data, numbers)


def test_normal_in_the_opposite_direction_is_not_used_as_a_correction():
    """Just as shapes meet, the distance of MuJoCo may have any direction."""
    model, data, numbers = touching(thing("mesh", at=(0.3, 0.01, TOP + 0.02 - 2e-4)))
    data.contact.frame[numbers] *= -1.0
    before = data.contact.frame.copy()
    assert not correct_normal(model, data, numbers)
    assert np.array_equal(data.contact.frame, before)
