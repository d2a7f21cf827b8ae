"""A contact that is regrasped at another place of the skin."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.motion.command import RegraspState as State
from tactile_maps.control.motion.limits import Limit, LimitKind, RegraspFailure
from tactile_maps.control.path_following.regrasp import BUMP, HARDER, JOINT_SPEED, LONGEST, RegraspManager
from tactile_maps.control.path_following.surface_path import PathCrossing
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts import touch_on
from tests.support.touch import arm, bar, taxel_near

DT = 0.02
FORWARD = [State.PLAN, State.LIFT, State.CARRY, State.PRESS]
BACK = [State.RETURN, State.FAILED]


def ends():
    """A taxel at the end of the forearm's skin, and one of the hand's on the same side."""
    skin = arm().skin
    forearm, hand = (skin.patches[k].taxels.positions for k in (1, 2))
    return taxel_near(skin, 1, forearm[forearm[:, 2].argmax()]), taxel_near(skin, 2, hand[hand[:, 2].argmax()])


OLD, NEW = ends()


def at(taxel, *, id_=7, force=2.0):
    return touch_on(arm().map, taxel, force, id_=id_)


def request(manager, leaves=OLD, enters=NEW) -> bool:
    skin = arm().skin
    held = at(leaves, id_=1, force=3.0)
    crossing = PathCrossing(0.1, skin.taxel_point(leaves), skin.taxel_point(enters))
    return manager.request(crossing, held, (held,), skin, 0.02)


class Ride:
    """A regrasp by an arm that follows at once."""

    def __init__(self, leaves=OLD, enters=NEW) -> None:
        self.manager = RegraspManager(arm().robot)
        self.configuration = Configuration(arm().robot)
        self.posture = arm().robot.home.copy()
        self.states = []
        self.limits = []
        self.speeds = []
        assert request(self.manager, leaves, enters)

    def tick(self, contacts=lambda _: (), *, blocked=False):
        """The contact once it has arrived; ``contacts`` returns those of each state. A blocked arm does not move."""
        speed = self.manager.speed(self.posture + (0.5 if blocked else 0.0), arm().robot.home, self.configuration, DT)
        if speed is not None and not blocked:
            self.posture = self.posture + DT * speed
            self.configuration.update(self.posture)
            self.speeds.append(speed)
        found = self.manager.watch(contacts(self.manager.state), DT)
        if not self.states or self.states[-1] != self.manager.state:
            self.states.append(self.manager.state)
            self.limits.append(self.manager.limit)
        return found

    def go(self, contacts, ticks=3000):
        """The contact at the end."""
        for _ in range(ticks):
            found = self.tick(contacts)
            if self.over:
                return found
        raise AssertionError(f"it does not end: {self.states}")

    @property
    def over(self):
        return self.manager.state in (State.ARRIVED, State.FAILED)

    @property
    def cause(self):
        return self.manager.limit.cause

    def place(self, taxel):
        point = arm().skin.taxel_point(taxel)
        return self.configuration.pose(arm().skin.link(point)).points(arm().skin.position(point))


@pytest.mark.long
def test_arm_lifts_carries_and_presses_until_the_new_place_is_touched():
    ride = Ride()
    start = ride.place(OLD)
    arrived = ride.go(lambda state: (at(NEW),) if state is State.PRESS and len(ride.speeds) % 50 == 0 else ())
    assert ride.states == [*FORWARD, State.ARRIVED]
    assert ride.limits[:2] == [
        Limit(LimitKind.REGRASP_PLANNED, ("forearm", "hand")),
        Limit(LimitKind.REGRASP_MOVES, ("forearm", "hand")),
    ]
    assert arrived.id == 7
    assert np.linalg.norm(ride.place(NEW) - start) < 0.03
    speeds = np.array(ride.speeds)
    assert np.abs(speeds).max() <= JOINT_SPEED * (1 + 1e-9)
    assert np.abs(np.diff(speeds, axis=0)).max() < 2 * JOINT_SPEED * DT / 0.1, "without jumps"


@pytest.mark.long
def test_arm_returns_if_nothing_is_at_the_new_place():
    ride = Ride()
    held = ride.go(lambda state: (at(OLD),) if state is State.RETURN else ())
    assert ride.states == [*FORWARD, *BACK]
    cause = RegraspFailure.NOTHING_THERE
    assert ride.cause is cause
    assert ride.limits[4] == Limit(LimitKind.REGRASP_RETURNS, ("forearm", "hand"), cause=cause)
    assert held.link == "forearm"
    assert np.linalg.norm(ride.posture - arm().robot.home) < 0.6, "on the last leg"
    lost = Ride()
    assert lost.go(lambda _: ()) is None, "nothing at either place"
    assert lost.posture == pytest.approx(arm().robot.home, abs=0.02)


@pytest.mark.parametrize(
    ("on_the_way", "cause"),
    [
        (lambda state: (at(5, force=2 * BUMP),) if state is State.CARRY else (), RegraspFailure.OBSTACLE),
        (lambda state: (at(5, force=0.5 * BUMP),), None),
        (lambda state: (at(5, id_=1, force=9.0),), None),  # there before
        (lambda state: (at(OLD, id_=1, force=3.0 + 1.1 * HARDER * (state is not State.PLAN)),), RegraspFailure.NO_LIFT),
        (lambda state: (at(OLD, id_=1, force=3.0 + 0.9 * HARDER),), RegraspFailure.OBJECT_FOLLOWS),
    ],
    ids=["bump", "brush", "known", "pressed harder by the lift", "object follows"],
)
def test_arm_turns_back_at_obstacles(on_the_way, cause):
    ride = Ride()
    ride.go(lambda state: {State.PRESS: (at(NEW),), State.RETURN: (at(OLD),)}.get(state) or on_the_way(state))
    if cause is None:
        assert ride.states[-1] is State.ARRIVED
    else:
        carried = [State.CARRY] if cause is RegraspFailure.OBJECT_FOLLOWS else []
        assert [state for state in ride.states if state not in carried] == [State.PLAN, State.LIFT, *BACK]
        assert ride.cause is cause


def test_blocked_arm_gives_up_after_the_longest_time():
    ride = Ride()
    while not ride.manager.moves:
        ride.tick()
    ticks = 0
    while not ride.over:
        ride.tick(blocked=True)
        ticks += 1
        assert ticks * DT < 4 * LONGEST
    assert ride.cause is RegraspFailure.TIMEOUT
    assert ticks * DT > LONGEST


def test_unreachable_place_is_rejected_before_the_contact_is_released():
    ride = Ride(NEW, 5)
    ride.go(lambda _: (at(NEW),))
    assert ride.states == [State.PLAN, State.FAILED]
    assert ride.cause is RegraspFailure.UNREACHABLE
    assert ride.manager.limit.value > 0.0
    assert not ride.speeds


@pytest.mark.parametrize("robot", [None, bar(hinged=False)])
def test_no_regrasp_without_an_arm(robot):
    manager = RegraspManager(robot)
    assert not request(manager)
    assert (manager.state, manager.limit) == (None, None)


def test_reset_discards_the_regrasp():
    ride = Ride()
    manager = ride.manager
    assert (manager.state, manager.moves, manager.crossing.way) == (State.PLAN, False, 0.1)
    while not manager.moves:
        ride.tick()
    manager.reset()
    assert (manager.state, manager.limit, manager.moves, manager.crossing) == (None, None, False, None)
    assert manager.watch((), DT) is None
    assert manager.speed(ride.posture, ride.posture, ride.configuration, DT) is None
    assert request(manager), "another may begin"
