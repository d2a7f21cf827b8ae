"""The force goal of contacts that would slip."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.contact_shear import ContactShear, Slip
from tactile_maps.control.controller_registry import settings_from
from tactile_maps.control.force_loop.grip import FALL, GripGoal
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.control.motion.unmeasured_force import _contact_torques
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import Finger, PokePressed, PokePulled
from tests.control.contacts import touch
from tests.control.test_controllers import arm_bench
from tests.support.touch import arm, bar

SETTINGS = ControlSettings(controller="hold_force", force_goal=3.0, friction_use=0.8)


def sheared(region, force, friction=0.5):
    """The contact with a force along the skin (3,) [N]."""
    return replace(region, shear=ContactShear(tuple(force), 0.0, 0.0, 1.0, Slip.STICKING, friction, estimated=False))


def dragged(force: float):
    """A contact with a force along the skin [N] and a friction of 0.5."""
    _, region, _ = arm_bench("hold_force")
    return sheared(region, (force, 0.0, 0.0))


def raised(contacts, settings=SETTINGS, grip=None, robot=None):
    """Goal and limits after one tick."""
    return (grip or GripGoal()).raised(settings, contacts, Configuration(robot or arm().robot), 0.005)


def between(first, second, *, apart=0.03, aside=0.0):
    """Two contacts of a bar that face each other, with forces along the skin in its x direction [N]."""
    inward = (np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0]))
    one, other = (touch(2.0, id_=k + 1, normal=inward[k])[0] for k in range(2))
    one = replace(one, link_position=np.array([0.3, 0.0, 0.0]))
    other = replace(other, link_position=np.array([0.3 + aside, 0.0, apart]))
    return sheared(one, (first, 0.0, 0.0)), sheared(other, (second, 0.0, 0.0))


@pytest.mark.parametrize(("force", "goal"), [(0.5, 3.0), (1.2, 3.0), (2.0, 5.0)])
def test_goal_makes_the_contact_use_the_stated_share_of_friction(force, goal):
    found, limits = raised([dragged(force)])
    assert found == pytest.approx(goal)
    assert [limit.kind for limit in limits] == ([LimitKind.FORCE_GOAL_RAISED] if goal > 3.0 else [])


def test_raised_goal_falls_slowly():
    grip = GripGoal()
    raised([dragged(2.0)], grip=grip)
    for _ in range(round(FALL / 0.005)):
        goal, _ = raised([dragged(0.0)], grip=grip)
    assert goal == pytest.approx(3.0 + 2.0 * np.exp(-1), rel=1e-2)


def test_goal_beyond_the_limit_is_reported():
    goal, (limit,) = raised([dragged(6.0)], replace(SETTINGS, max_force=10.0))
    assert goal == 8.0
    assert (limit.kind, limit.value, limit.bound) == (LimitKind.GRIP_LIMITED, pytest.approx(15.0), 8.0)


def test_goal_is_unchanged_without_the_setting():
    settings = replace(SETTINGS, friction_use=float("inf"))
    assert raised([dragged(6.0)], settings) == (3.0, ())


@pytest.mark.parametrize(("first", "second", "goal"), [(2.0, 2.0, 5.0), (7.0, -3.0, 5.0), (-3.0, 3.0, 3.0)])
def test_goal_of_opposing_contacts_is_the_load_over_the_sum_of_frictions(first, second, goal):
    """4 N on twice 0.5 of 0.8; what the contacts exert on each other through the object does not count."""
    held = between(first, second)
    assert raised(held, robot=bar())[0] == pytest.approx(goal)
    rough = replace(held[1], shear=replace(held[1].shear, friction=1.5))
    assert raised((held[0], rough), robot=bar())[0] == pytest.approx(max(3.0, abs(first + second) / 1.6))


@pytest.mark.parametrize("way", [{"aside": 0.03}, {"apart": -0.03}], ids=["side by side", "back to back"])
def test_contacts_that_do_not_oppose_each_other_have_separate_goals(way):
    assert raised(between(7.0, -3.0, **way), robot=bar())[0] == pytest.approx(7.0 / 0.4)


@pytest.mark.long
@pytest.mark.parametrize("friction_use", [0.7, float("inf")])
def test_pulled_contact_is_held_only_with_the_setting(friction_use):
    scene = load_scene("slip")
    settings = ControlSettings(controller="hold_force", force_goal=2.0, friction_use=friction_use)
    session = Session(prepare_cached(replace(scene, objects=(), control={})), settings=settings)
    skin = session.prepared.skin
    places = skin.patches[0].taxels.positions
    outward = skin.patches[0].taxels.normals
    taxel = int((outward @ outward.mean(axis=0)).argmax())
    away = np.linalg.norm(places - places[taxel] - 0.012 * np.array([0.0, 0.0, 1.0]), axis=1)
    session.submit(PokePressed(1, skin.taxel_point(taxel), Finger(stiffness=400.0, speed=0.05)))
    session.run_for(1.5)
    session.submit(PokePulled(1, skin.taxel_point(int(away.argmin()))))
    session.run_for(2.0)
    (region,) = session.frame.regions
    held = region.shear.slip is not Slip.SLIDING and region.force > 3.0
    assert held == (friction_use < 1), region.shear


@pytest.mark.long
@pytest.mark.parametrize("friction_use", [0.7, float("inf")])
def test_block_between_two_fingers_is_lifted_only_with_the_setting(friction_use):
    scene = load_scene("carry")
    settings = replace(settings_from(scene.control), friction_use=friction_use)
    frame = Session(prepare_cached(scene), settings=settings).run_for(4.0)
    assert frame.posture[0] > 0.02, "the hand has risen"
    table_to_block = frame.objects[2][2, 3] - 0.105
    assert (table_to_block > 0.02) == (friction_use < 1)
    assert abs(table_to_block) < 0.001 or friction_use < 1
    if friction_use < 1:
        forces = [region.force for region in frame.regions]
        assert forces == pytest.approx([0.3 * 9.81 / (0.7 * 2 * 0.8)] * 2, rel=0.15), "the weight over both frictions"


def test_measured_shear_explains_the_torques_of_a_dragged_contact():
    scene = load_scene("slip")
    prepared = prepare_cached(replace(scene, objects=(), control={}))
    session = Session(prepared, settings=ControlSettings(controller="hold_force", force_goal=3.0))
    skin = prepared.skin
    session.submit(PokePressed(1, skin.taxel_point(300), Finger(speed=0.05)))
    session.run_for(0.4)
    session.submit(PokePulled(1, skin.taxel_point(301)))
    frame = session.run_for(0.5)
    (region,) = frame.regions
    assert np.linalg.norm(region.shear.force) > 0.5
    configuration = Configuration(prepared.robot)
    configuration.update(frame.posture)
    world = configuration.pose(region.link).rotation @ (region.shear.force - region.force * region.link_normal)
    expected = world @ configuration.jacobian(region.link, region.link_position)
    np.testing.assert_allclose(_contact_torques(configuration, region)[0], expected)
