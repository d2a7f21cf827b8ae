"""Hard cases of control: events during a contact."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import Finger, PokeMoved, PokePressed, PokeReleased
from tests.control.hard_cases.case import GOAL, OTHERS, SOME, STOPPED, HardCase, both, bounded_only, change, kept, rests
from tests.support.pressed_arm import Course, forearm, pressed_by_ball

TAXEL = 150


def by_hand(settings: ControlSettings) -> Session:
    """The arm alone."""
    return Session(forearm(), settings=settings)


def near_taxel() -> int:
    """The usual one."""
    return TAXEL


def far_taxel() -> int:
    """Return the taxel that is 60th nearest to the default taxel on the map."""
    points = forearm().map.taxel_points
    return int(np.argsort(np.linalg.norm(points - points[TAXEL], axis=1))[60])


def press(taxel: Callable[[], int] = near_taxel, *, finger: int = 1, **how: float):
    """A finger presses a taxel; which is asked when it happens, since the arm takes a second to make."""
    return lambda session: session.submit(PokePressed(finger, forearm().skin.taxel_point(taxel()), Finger(**how)))


def release(finger: int = 1):
    return lambda session: session.submit(PokeReleased(finger))


def slide(taxel: Callable[[], int], *, finger: int = 1):
    """The finger goes to another taxel at once."""
    return lambda session: session.submit(PokeMoved(finger, forearm().skin.taxel_point(taxel())))


def no_jumps(*times: float):
    """The true force is continuous at these times [s]."""

    def check(course: Course) -> None:
        for time in times:
            at = round(time / course.tick)
            assert np.abs(np.diff(course.pressed[at - 1 : at + 20])).max() < 0.25

    return check


def nearer(course: Course) -> None:
    """Two hands press more alike than they would alone."""
    forces = sorted(region.force for region in course.session.frame.regions)
    assert len(forces) == 2
    assert forces[1] - forces[0] < 3.0


def both_bounded(course: Course) -> None:
    assert len(course.session.frame.regions) == 2
    assert max(region.force for region in course.session.frame.regions) < 12.0


def not_led_away(course: Course) -> None:
    """The arm ends where it was."""
    assert np.abs(course.posture[-1] - course.posture[round(3.0 / course.tick)]).max() < 0.1


def aside(session: Session) -> None:
    point = session.frame.regions[0].map_point + [0.02, 0.02]
    change(path=(tuple(map(float, point)),))(session)


SWITCHES = {
    1.0 + 0.25 * k: change(controller=controller)
    for k, controller in enumerate(
        ("qp", "parallel", "admittance", "projection", "priority", "hold_force", "impedance")
    )
} | {2.55: change(controller="hybrid"), 2.8: change(controller="admittance")}
"""Every controller in turn; the impedance, which lets the arm go home, for 50 ms."""
CASES: dict[str, HardCase] = {
    "controllers are switched in mid-contact": HardCase(
        "each starts from the torque it finds: the force does not jump, and is kept by the last",
        lambda settings: pressed_by_ball(settings),
        both(no_jumps(*SWITCHES), kept(within=0.3, ripple=0.3)),
        {"task": "hold_point"},
        seconds=4.5,
        force=8.0,
        acts=SWITCHES,
    ),
    "the goal is changed in mid-contact": HardCase(
        "from 3 N to 6 N and back, without what the integral gathered in between",
        lambda settings: pressed_by_ball(settings),
        kept(),
        seconds=4.0,
        force=9.0,
        acts={1.0: change(force_goal=6.0), 2.0: change(force_goal=GOAL)},
        controllers=OTHERS,
    ),
    "too strong a hand": HardCase(
        "more than the greatest force stops the arm, which yields softly",
        by_hand,
        rests(1.0),
        {"max_force": 5.0, "force_gain": 0.001},
        seconds=2.0,
        force=16.0,
        acts={0.0: press(speed=0.03, max_force=15.0)},
        says=(STOPPED,),
    ),
    "a finger that tracks its place": HardCase(
        "it can never come to another point of the map: the arm is not led away, and says why",
        by_hand,
        not_led_away,
        {"task": "hold_point"},
        seconds=5.0,
        force=10.0,
        acts={0.0: press(speed=0.01, max_force=8.0), 1.0: aside},
        says=((LimitKind.CONTACT_STICKS,),),
    ),
    "a finger that jumps": HardCase(
        "to another place 60 taxels away, at once, and back: bounded, in touch again",
        by_hand,
        bounded_only,
        {"task": "hold_point"},
        seconds=4.0,
        force=12.0,
        acts={0.0: press(speed=0.02, max_force=8.0), 1.0: slide(far_taxel), 2.0: slide(near_taxel)},
        controllers=SOME,
    ),
    "taps": HardCase(
        "four touches of a tenth of a second: nothing gathers, and in the end it goes home",
        by_hand,
        rests(0.1),
        seconds=4.0,
        force=12.0,
        acts={
            t: act
            for k in range(4)
            for t, act in ((0.5 * k, press(speed=0.05, max_force=8.0)), (0.5 * k + 0.1, release()))
        },
        controllers=OTHERS,
    ),
    "a second contact": HardCase(
        "two hands are balanced",
        by_hand,
        nearer,
        {"task": "balance"},
        seconds=4.0,
        force=20.0,
        acts={
            0.0: press(speed=0.01, max_force=6.0),
            0.05: press(far_taxel, finger=2, speed=0.01, max_force=2.0),
        },
    ),
    "an unrelated second contact": HardCase(
        "the task is about the first; the second is a hand that presses as hard as it likes, and no harder",
        by_hand,
        both_bounded,
        {"task": "hold_point"},
        seconds=3.0,
        force=25.0,
        acts={
            0.0: press(speed=0.01, max_force=6.0),
            1.0: press(far_taxel, finger=2, speed=0.01, max_force=6.0),
        },
        controllers=OTHERS,
    ),
    "hands off while it is stopped": HardCase(
        "a stopped arm continues once nothing has touched it for a second",
        by_hand,
        rests(0.5),
        {"max_force": 5.0, "force_gain": 0.001},
        seconds=4.0,
        force=16.0,
        acts={0.0: press(speed=0.03, max_force=15.0), 1.0: release()},
        says=(STOPPED,),
        controllers=SOME,
    ),
}
