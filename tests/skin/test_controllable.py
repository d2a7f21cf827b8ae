"""The share of the skin on which contact forces can be controlled."""

from __future__ import annotations

import pytest

from tactile_maps.robots.library import load_robot
from tactile_maps.skin.controllable import controllable_share
from tactile_maps.skin.fitting.cover import CoverSpec, cover_robot
from tests.support.generated_robots import arm, load

pytestmark = pytest.mark.long


def test_links_at_the_end_of_a_bent_arm_are_controllable():
    robot = load_robot("arm")
    skin = cover_robot(robot, CoverSpec(links=("base", "turret", "hand"), taxels=120))
    share = controllable_share(robot, skin)
    assert share["hand"] == 1.0
    assert share["turret"] < 0.3  # it turns about its own axis
    assert share["base"] == 0.0


def test_straight_arm_controls_less_than_with_its_chosen_home(tmp_path):
    bent = load(arm(1.0), tmp_path)
    straight = load(arm(1.0), tmp_path, home={"joint1": 0.0})
    skin = cover_robot(bent, CoverSpec(links=("link4",), taxels=60))
    assert controllable_share(bent, skin)["link4"] == pytest.approx(1.0, abs=0.1)
    assert controllable_share(straight, skin)["link4"] < 0.9
