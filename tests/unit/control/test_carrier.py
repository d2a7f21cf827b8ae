"""One contact at a time is taken elsewhere, by an arm that can."""

from __future__ import annotations

import pytest

from app.control.carrier import Carrier
from app.control.laid_path import Crossing
from app.robots.configuration import Configuration
from tests.touch import arm, bar
from tests.unit.control.test_carry_plan import ends
from tests.unit.control.touched import TICK, touch_on


def asked(carrier) -> bool:
    leaves, enters = ends()
    skin, held = arm().skin, touch_on(arm().map, leaves, 3.0)
    crossing = Crossing(0.1, skin.taxel_point(leaves), skin.taxel_point(enters))
    return carrier.ask(crossing, held, (held,), skin, 0.02)


def ticked(carrier, ticks=400):
    """Its speed as soon as the arm moves."""
    robot, configuration = arm().robot, Configuration(arm().robot)
    for _ in range(ticks):
        speed = carrier.speed(robot.home, robot.home, configuration, TICK)
        if speed is not None:
            return speed
        carrier.watch((), TICK)
    raise AssertionError("it found no way")


@pytest.mark.parametrize("robot", [None, bar(hinged=False)])
def test_without_an_arm_nothing_is_carried(robot):
    carrier = Carrier(robot)
    assert not asked(carrier)
    assert (carrier.state, carrier.says, carrier.reason) == ("", "", "")


def test_first_a_way_is_looked_for_and_the_arm_stands():
    carrier = Carrier(arm().robot)
    assert asked(carrier)
    assert carrier.state == "look"
    assert not carrier.moves
    assert carrier.speed(arm().robot.home, arm().robot.home, Configuration(arm().robot), TICK) is None
    assert carrier.says == "looking for a way to the hand"
    assert ticked(carrier).any()
    assert carrier.moves
    assert carrier.state == "lift"
    assert carrier.crossing.way == 0.1


def test_a_reset_lets_go_of_it():
    carrier = Carrier(arm().robot)
    assert asked(carrier)
    ticked(carrier)
    carrier.reset()
    assert (carrier.state, carrier.says, carrier.moves, carrier.crossing) == ("", "", False, None)
    assert carrier.watch((), TICK) is None
    assert carrier.speed(arm().robot.home, arm().robot.home, Configuration(arm().robot), TICK) is None
    assert asked(carrier), "and another may begin"
