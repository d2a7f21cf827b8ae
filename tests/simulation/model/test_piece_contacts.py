"""Contacts of links that collide in pieces: balls on the surface itself, no seams, one stiffness for all pieces."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.model.contact_stiffness import effective_count
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.model.model_names import is_hull, plain_name
from tactile_maps.simulation.model.piece_contacts import PieceContacts, piece_groups, shared_counts
from tactile_maps.skin.link_pieces import link_pieces, piece_name
from tests.support.hollows import hollow
from tests.support.scene_objects import thing


def assembled(shape: str, *objects, **effects) -> tuple[mujoco.MjModel, mujoco.MjData, PieceContacts]:
    robot, skin = hollow(shape)
    model = assemble(robot, skin, Effects(contact="environment", **effects), objects=objects)
    return model, mujoco.MjData(model), PieceContacts(model, robot, skin)


def test_points_with_equal_normals_share_stiffness_and_perpendicular_ones_do_not():
    depths = [3e-4, 1e-4, 2e-4]
    same = shared_counts(depths, np.tile([0.0, 0.6, 0.8], (3, 1)))
    np.testing.assert_allclose(same, effective_count(depths), rtol=1e-12)
    np.testing.assert_allclose(shared_counts(depths, np.eye(3)), np.array(depths) / 3e-4)
    opposite = shared_counts([1e-4, 1e-4], np.array([[0, 0, 1.0], [0, 0, -1.0]]))
    np.testing.assert_allclose(opposite, 1.0)


@pytest.mark.parametrize("angle", [0.1, 0.5, 0.785])
def test_two_walls_are_as_stiff_as_one_point_along_their_bisector(angle):
    normals = np.array([[np.sin(angle), 0, np.cos(angle)], [-np.sin(angle), 0, np.cos(angle)]])
    counts = shared_counts([np.cos(angle)] * 2, normals)
    assert (np.cos(angle) ** 2 / counts).sum() == pytest.approx(1.0 if angle <= np.pi / 4 else 2 * np.cos(angle) ** 2)


@pytest.mark.long
def test_pieces_of_a_link_are_one_group_with_the_parameters_of_one_pair():
    box = thing("box", at=(0.0, 0.0, 0.5), mass=1.0, friction=0.3)
    model, _, _ = assembled("groove", box, friction=True)
    pieces = link_pieces(*hollow("groove"), "block")
    names = [piece_name("block", number) for number in range(len(pieces.hulls))]
    geoms = [model.geom(name).id for name in names]
    assert {piece_groups(model)[geom] for geom in geoms} == {geoms[0]}
    assert piece_groups(model)[model.geom("tactile-maps/object box").id] == model.geom("tactile-maps/object box").id
    assert model.npair == 1
    assert model.pair_friction[0, 0] == 0.3
    assert model.geom_condim[geoms].tolist()[1:] == [3] * (len(geoms) - 1)
    assert {plain_name(name) for name in names} == {"block"}
    assert all(is_hull(name) for name in names)


def contacts_of(shape: str, body, **effects) -> list[tuple[float, np.ndarray]]:
    """Return depth and outward normal of each contact that is left of a body with the block."""
    model, data, pieces = assembled(shape, body, **effects)
    mujoco.mj_step1(model, data)
    pieces.correct(data, 0, list(range(data.ncon)))
    found = []
    for number in np.flatnonzero(data.contact.exclude == 0).tolist():
        contact = data.contact[number]
        own = model.geom(contact.geom[0]).name.startswith("tactile-maps/object")
        found.append((-contact.dist, (-1 if own else 1) * contact.frame[:3]))
    return found


@pytest.mark.parametrize("x", np.linspace(0.05, 0.056, 4))
@pytest.mark.parametrize("y", np.linspace(-0.021, 0.02, 4))
def test_ball_over_flat_pieces_has_one_contact_with_the_true_depth(x, y):
    found = contacts_of("bowl", thing("sphere", size=(0.01,), at=(x, y, 0.0099), mass=0.1))
    assert len(found) == 1
    assert found[0][0] == pytest.approx(1e-4, rel=1e-6)
    np.testing.assert_allclose(found[0][1], [0, 0, 1], atol=1e-9)


def test_ball_in_a_groove_has_a_contact_with_each_wall():
    height = 0.02 * np.sqrt(2) - 0.02 - 1e-4 * np.sqrt(2)
    found = contacts_of("groove", thing("sphere", at=(0.0, 0.001, height), mass=0.1))
    assert sorted(np.round(normal[0], 6) for _, normal in found) == [-0.707107, 0.707107]
    assert [depth for depth, _ in found] == pytest.approx([1e-4, 1e-4], rel=1e-6)


@pytest.mark.long
def test_box_over_seams_is_pushed_along_the_surface_only():
    """Seams would push its edge aside where it has just reached the next piece."""
    for x in np.linspace(0.02, 0.03, 5):
        box = thing("box", size=(0.02, 0.1, 0.01), at=(0.0, x - 0.025, 0.00499), mass=0.1)
        found = contacts_of("saddle", box)
        assert all(normal[2] > 0.5 for _, normal in found)
