"""A contact taken to another place of the skin: the way, the going, and who keeps it."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.motion.command import RegraspState as State
from tactile_maps.control.motion.limits import Limit, LimitKind, RegraspFailure
from tactile_maps.control.path_following.regrasp import BUMP, HARDER, JOINT_SPEED, LONGEST, RegraspManager
from tactile_maps.control.path_following.surface_path import PathCrossing
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts import TICK, touch_on
from tests.support.touch import arm, bar, taxel_near


def ends():
    """A taxel at the end of the forearm's skin, and one of the hand's on the same side."""
    skin = arm().skin
    forearm, hand = (skin.patches[k].taxels.positions for k in (1, 2))
    low = forearm[forearm[:, 2].argmax()]
    high = hand[hand[:, 2].argmax()]
    return taxel_near(skin, 1, low), taxel_near(skin, 2, high)


DT = 0.02
PITCH = 0.02


class Ride:
    """A carrier whose arm does at once what is asked; ``felt`` says what touches, by state and posture."""

    def __init__(self, leaves=None, enters=None) -> None:
        prepared = arm()
        first, second = ends()
        self.leaves = first if leaves is None else leaves
        self.enters = second if enters is None else enters
        self.carrier = RegraspManager(prepared.robot)
        self.configuration = Configuration(prepared.robot)
        skin = prepared.skin
        held = touch_on(prepared.map, self.leaves, 3.0)
        crossing = PathCrossing(0.1, skin.taxel_point(self.leaves), skin.taxel_point(self.enters))
        assert self.carrier.request(crossing, held, (held,), skin, PITCH)
        self.posture = prepared.robot.home.copy()
        self.states = []
        self.said = []
        self.speeds = []

    def go(self, felt, ticks=3000):
        """Until it is over; the contact in hand at the end."""
        for _ in range(ticks):
            speed = self.carrier.speed(self.posture, arm().robot.home, self.configuration, DT)
            if speed is not None:
                self.posture = self.posture + DT * speed
                self.configuration.update(self.posture)
                self.speeds.append(speed)
            region = self.carrier.watch(felt(self.carrier.state), DT)
            if not self.states or self.states[-1] != self.carrier.state:
                self.states.append(self.carrier.state)
                self.said.append(self.carrier.limit)
            if self.carrier.state in (State.ARRIVED, State.FAILED):
                return region
        raise AssertionError(f"it never ended: {self.states}")

    def place(self, taxel):
        at = arm().skin.taxel_point(taxel)
        skin = arm().skin
        return self.configuration.pose(skin.link(at)).points(skin.position(at))


def nothing(_state):
    return ()


def at(taxel, *, id_=7, force=2.0):
    return touch_on(arm().map, taxel, force, id_=id_)


def test_it_lifts_carries_and_presses_until_it_feels_the_place():
    ride = Ride()
    start = ride.place(ride.leaves)
    arrived = ride.go(lambda state: (at(ride.enters),) if state == State.PRESS and len(ride.speeds) % 50 == 0 else ())
    assert ride.states == [
        State.PLAN,
        State.LIFT,
        State.CARRY,
        State.PRESS,
        State.ARRIVED,
    ]
    assert ride.said[1] == Limit(LimitKind.REGRASP_MOVES, ("forearm", "hand"))
    assert arrived.id == 7
    assert np.linalg.norm(ride.place(ride.enters) - start) < 0.03
    speeds = np.array(ride.speeds)
    assert np.abs(speeds).max() <= JOINT_SPEED * (1 + 1e-9)
    assert np.abs(np.diff(speeds, axis=0)).max() < 2 * JOINT_SPEED * DT / 0.1, "without jumps"


def test_where_nothing_is_it_goes_back_and_says_so():
    ride = Ride()
    held = ride.go(lambda state: (at(ride.leaves),) if state == State.RETURN else ())
    assert ride.states == [
        State.PLAN,
        State.LIFT,
        State.CARRY,
        State.PRESS,
        State.RETURN,
        State.FAILED,
    ]
    assert ride.carrier.limit.cause is RegraspFailure.NOTHING_THERE
    assert ride.said[4] == Limit(LimitKind.REGRASP_RETURNS, ("forearm", "hand"), cause=RegraspFailure.NOTHING_THERE)
    assert held.link == "forearm"
    assert np.linalg.norm(ride.posture - arm().robot.home) < 0.6, "on the last leg"


def test_with_nothing_at_either_place_it_ends_with_no_contact():
    ride = Ride()
    assert ride.go(nothing) is None
    assert ride.posture == pytest.approx(arm().robot.home, abs=0.02)


def test_a_bump_on_the_way_turns_it_back_and_a_brush_does_not():
    ride = Ride()
    ride.go(
        lambda state: (at(5, force=2 * BUMP),) if state == State.CARRY else (at(ride.leaves),) * (state == State.RETURN)
    )
    assert ride.states == [State.PLAN, State.LIFT, State.RETURN, State.FAILED]
    assert ride.carrier.limit.cause is RegraspFailure.OBSTACLE
    brushed = Ride()
    brushed.go(lambda state: (at(brushed.enters),) if state == State.PRESS else (at(5, force=0.5 * BUMP),))
    assert brushed.states[-1] == State.ARRIVED
    known = Ride()
    known.go(lambda state: (at(known.enters),) if state == State.PRESS else (at(5, id_=1, force=9.0),))
    assert known.states[-1] == State.ARRIVED, "it was there before"


def test_a_lift_that_presses_harder_than_before_is_broken_off():
    ride = Ride()
    held = at(ride.leaves, id_=1, force=3.0)
    harder = at(ride.leaves, id_=1, force=3.0 + 1.1 * HARDER)
    ride.go(lambda state: (held if state is State.PLAN else harder,))
    assert ride.states == [State.PLAN, State.LIFT, State.RETURN, State.FAILED]
    assert ride.carrier.limit.cause is RegraspFailure.NO_LIFT
    little = at(ride.leaves, id_=1, force=3.0 + 0.9 * HARDER)
    lifted = Ride()
    lifted.go(lambda state: (held if state is State.PLAN else little,))
    assert lifted.carrier.limit.cause is RegraspFailure.OBJECT_FOLLOWS, "it was lifted, and only then came along"


def test_what_comes_along_is_brought_back():
    ride = Ride()
    ride.go(lambda _state: (at(ride.leaves, id_=1),))
    assert ride.carrier.limit.cause is RegraspFailure.OBJECT_FOLLOWS
    assert ride.states[-1] == State.FAILED


def test_it_never_takes_longer_than_it_may():
    ride = Ride()
    for _ in range(400):
        if ride.carrier.speed(ride.posture, arm().robot.home, ride.configuration, DT) is not None:
            break
        ride.carrier.watch((), DT)
    ticks = 0
    while ride.carrier.state not in (State.FAILED, State.ARRIVED):  # an arm that does not move at all
        ride.carrier.speed(ride.posture + 0.5, arm().robot.home, ride.configuration, DT)
        ride.carrier.watch((), DT)
        ticks += 1
        assert ticks * DT < 4 * LONGEST
    assert ride.carrier.limit.cause is RegraspFailure.TIMEOUT
    assert ticks * DT > LONGEST


def test_the_place_that_cannot_come_is_refused_before_anything_is_let_go():
    _, hand = ends()
    ride = Ride(hand, 5)
    ride.go(lambda _state: (at(hand),))
    assert ride.states == [State.PLAN, State.FAILED]
    assert ride.carrier.limit.cause is RegraspFailure.UNREACHABLE
    assert ride.carrier.limit.value > 0.0, "by so much"
    assert not ride.speeds


def asked(carrier) -> bool:
    leaves, enters = ends()
    skin = arm().skin
    held = touch_on(arm().map, leaves, 3.0)
    crossing = PathCrossing(0.1, skin.taxel_point(leaves), skin.taxel_point(enters))
    return carrier.request(crossing, held, (held,), skin, 0.02)


def ticked(carrier, ticks=400):
    """Its speed as soon as the arm moves."""
    robot = arm().robot
    configuration = Configuration(arm().robot)
    for _ in range(ticks):
        speed = carrier.speed(robot.home, robot.home, configuration, TICK)
        if speed is not None:
            return speed
        carrier.watch((), TICK)
    raise AssertionError("it found no way")


@pytest.mark.parametrize("robot", [None, bar(hinged=False)])
def test_without_an_arm_nothing_is_carried(robot):
    carrier = RegraspManager(robot)
    assert not asked(carrier)
    assert (carrier.state, carrier.limit) == (None, None)


def test_first_a_way_is_looked_for_and_the_arm_stands():
    carrier = RegraspManager(arm().robot)
    assert asked(carrier)
    assert carrier.state == State.PLAN
    assert not carrier.moves
    assert carrier.speed(arm().robot.home, arm().robot.home, Configuration(arm().robot), TICK) is None
    assert carrier.limit == Limit(LimitKind.REGRASP_PLANNED, ("forearm", "hand"))
    assert ticked(carrier).any()
    assert carrier.moves
    assert carrier.state == State.LIFT
    assert carrier.crossing.way == 0.1


def test_a_reset_lets_go_of_it():
    carrier = RegraspManager(arm().robot)
    assert asked(carrier)
    ticked(carrier)
    carrier.reset()
    assert (carrier.state, carrier.limit, carrier.moves, carrier.crossing) == (None, None, False, None)
    assert carrier.watch((), TICK) is None
    assert carrier.speed(arm().robot.home, arm().robot.home, Configuration(arm().robot), TICK) is None
    assert asked(carrier), "and another may begin"
