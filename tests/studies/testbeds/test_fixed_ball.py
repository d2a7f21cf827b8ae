"""A robot in contact with a fixed ball, and a finger elsewhere."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.studies.testbeds.fixed_ball import place_to_press, points_above, with_finger, with_fixed_ball
from tactile_maps.studies.testbeds.path_following import PathSetup
from tests.support.pressed_arm import forearm
from tests.support.touch import prepared_bar


@pytest.mark.long
def test_finger_presses_with_its_force_far_from_the_ball():
    prepared = with_finger(with_fixed_ball(forearm(), taxel=150), 2.0)
    ball, finger = (thing.spec for thing in prepared.objects)
    skin = points_above(prepared, np.arange(len(prepared.skin)), 0.0)
    away = np.linalg.norm(skin - ball.at, axis=1)
    assert np.linalg.norm(skin[away.argmax()] - finger.path[-1][1:]) == pytest.approx(0.03, abs=1e-6)
    session = PathSetup(prepared).session(ControlSettings(controller="hybrid", task="hold_point", force_goal=3.0))
    for _ in range(240):
        session.tick()
    felt = sorted(region.force for region in session.frame.regions)
    assert felt == pytest.approx([2.0, 3.0], rel=0.1), "the finger's spring ends at its force, the ball is held at 3 N"
    assert session.total_normal_force == pytest.approx(5.0, rel=0.05)


@pytest.mark.long
def test_places_to_press_range_from_flat_to_curved():
    prepared = forearm()
    taxels = prepared.skin.patches[0].taxels

    def bend(taxel):
        near = np.linalg.norm(taxels.positions - taxels.positions[taxel], axis=1) < 0.02
        return np.arccos((taxels.normals[near] @ taxels.normals[taxel]).min())

    places = [place_to_press(prepared, bend=share) for share in (0.0, 0.5, 1.0)]
    assert places[0] == place_to_press(prepared)
    assert bend(places[0]) < bend(places[1]) < bend(places[2])


def test_place_on_a_robot_with_few_joints_does_not_depend_on_them():
    """Fewer than three joints move no taxel in all directions."""
    assert place_to_press(prepared_bar()) == place_to_press(prepared_bar(hinged=False))
