"""Several contacts on the whole arm: all that press above the goal are kept at it, and what is not is named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.controllers import CONTROL_SCHEMES
from tactile_maps.control.motion.command import CHOICES, ControlSettings
from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import Finger, PokePressed, PokeReleased
from tactile_maps.tactile.sensors.sensor_effects import Sampling
from tests.support.pressed_arm import TICK, forearm
from tests.support.touch import arm

pytestmark = pytest.mark.long

GOAL = 3.0
ADVANCING = Finger(speed=0.006, max_force=20.0)
KEEPING = ("hold_force", *CONTROL_SCHEMES)
WITHIN = {"admittance": 1.6, "parallel": 0.5}
"""Largest error at the end [N]. Without an integral one finger at 6 mm/s is met with 1.2 N more, and two with 1.5 N;
the parallel scheme ends in a small limit cycle."""


def taxel_of(link: str, share: float) -> int:
    """The taxel after a share of those of a link of the arm."""
    skin = arm().skin
    taxels = [taxel for taxel in range(len(skin)) if skin.link(skin.taxel_point(taxel)) == link]
    return taxels[int(len(taxels) * share)]


def pressed(controller, prepared, taxels, *, seconds, task="keep_force", released=None):
    """Forces of advancing fingers (k, 2), of which the second begins at 0.5 s, and the last frame.

    Args:
        controller: By name.
        prepared: Robot, skin and map.
        taxels: Of the two fingers.
        seconds: How long.
        task: Of the controller.
        released: When the second finger leaves [s]; None for never.
    """
    settings = ControlSettings(controller=controller, task=task, force_goal=GOAL)
    session = Session(prepared, scripted=False, settings=settings)
    forces = np.zeros((round(seconds / TICK), 2))
    for k in range(len(forces)):
        for number, begins in enumerate((0.0, 0.5), start=1):
            if k == round(begins / TICK):
                session.submit(PokePressed(number, prepared.skin.taxel_point(taxels[number - 1]), ADVANCING))
        if released is not None and k == round(released / TICK):
            session.submit(PokeReleased(2))
        frame = session.tick()
        for poke, number in zip(frame.pokes, (1, 2), strict=False):
            forces[k, number - 1] = poke.force
    return forces, session.frame


PLACES = {
    "one link, side by side": (forearm, lambda: (150, 188)),
    "one link, two sides": (forearm, lambda: (150, 315)),
    "two links": (arm, lambda: (taxel_of("forearm", 1 / 2), taxel_of("upper_arm", 1 / 3))),
}


@pytest.mark.sampled(1)
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("controller", KEEPING)
def test_two_fingers_of_seven_times_the_force_are_kept_at_the_goal(controller, place):
    """They advance at 6 mm/s until they press with 20 N; a controller of one contact lets the other do so."""
    prepared, taxels = PLACES[place]
    forces, frame = pressed(controller, prepared(), taxels(), seconds=6.0)
    assert forces[-100:] == pytest.approx(GOAL, abs=WITHIN.get(controller, 0.1))
    assert forces.max() < 6.0
    assert frame.task is None or set(frame.task.controlled) == {region.id for region in frame.regions}
    assert not {LimitKind.CONTACTS_OPPOSED, LimitKind.CONTACT_IMMOBILE} & {limit.kind for limit in frame.why_limited}


@pytest.mark.long
@pytest.mark.parametrize("controller", ["hybrid", "hold_force", "projection", "priority", "qp"])
def test_soft_and_stiff_finger_are_kept_at_the_goal_with_a_slow_skin(controller):
    """Fingers of 1 and 100 kN/m at 50 Hz, 20 ms late. With the gain of the soft one, the force of the other swings."""
    prepared = forearm()
    settings = ControlSettings(controller=controller, force_goal=GOAL)
    session = Session(prepared, scripted=False, settings=settings)
    sensor = replace(session.effects.sensor, sampling=Sampling(50.0, 0.02))
    session = Session(prepared, scripted=False, settings=settings, effects=replace(session.effects, sensor=sensor))
    forces = np.zeros((round(6.0 / TICK), 2))
    for k in range(len(forces)):
        for number, begins, taxel, stiffness, speed in ((1, 0.0, 150, 1e3, 0.003), (2, 2.0, 188, 1e5, 0.006)):
            if k == round(begins / TICK):
                finger = Finger(stiffness=stiffness, speed=speed)
                session.submit(PokePressed(number, prepared.skin.taxel_point(taxel), finger))
        frame = session.tick()
        for poke, number in zip(frame.pokes, (1, 2), strict=False):
            forces[k, number - 1] = poke.force
    assert forces[-200:].mean(axis=0) == pytest.approx(GOAL, abs=0.15)
    assert np.ptp(forces[-200:], axis=0) == pytest.approx(0, abs=0.3)


@pytest.mark.long
@pytest.mark.parametrize("controller", KEEPING)
def test_contact_that_the_joints_cannot_also_relieve_is_reported(controller):
    """The joints hardly move the skin outward in the middle of the upper arm."""
    taxels = taxel_of("forearm", 1 / 2), taxel_of("upper_arm", 1 / 2)
    forces, frame = pressed(controller, arm(), taxels, seconds=6.0)
    (limit,) = (limit for limit in frame.why_limited if limit.kind is LimitKind.CONTACTS_OPPOSED)
    (named,) = (region for region in frame.regions if region.link == "upper_arm")
    assert (limit.names, limit.value, limit.bound) == (("upper_arm",), pytest.approx(named.force, rel=0.05), GOAL)
    assert named.force > 2 * GOAL
    assert forces[-100:, 0] == pytest.approx(GOAL, abs=WITHIN.get(controller, 0.1))
    assert frame.task is None or named.id not in frame.task.controlled


@pytest.mark.long
@pytest.mark.parametrize("controller", KEEPING)
def test_other_contact_is_kept_when_one_of_them_leaves(controller):
    forces, frame = pressed(controller, forearm(), (150, 188), seconds=7.0, released=4.0)
    assert forces[-100:, 0] == pytest.approx(GOAL, abs=WITHIN.get(controller, 0.1))
    assert forces[-100:, 1].max() == 0.0
    assert frame.task is None or len(frame.task.controlled) == 1


@pytest.mark.long
@pytest.mark.parametrize("controller", ["hybrid", "parallel", "priority", "qp"])
def test_point_is_held_while_another_finger_is_kept_at_the_goal(controller):
    forces, frame = pressed(controller, forearm(), (150, 188), seconds=6.0, task="hold_point")
    assert forces[-100:] == pytest.approx(GOAL, abs=WITHIN.get(controller, 0.1))
    assert frame.task is not None
    assert frame.task.error < 0.002


@pytest.mark.sampled(3)
@pytest.mark.parametrize("controller", [name for name in CHOICES["controller"] if name != "impedance"])
def test_any_contact_above_the_largest_force_stops_the_arm(controller):
    """The first is light, the second comes faster than the arm yields."""
    settings = ControlSettings(controller=controller, max_force=15.0)
    session = Session(forearm(), scripted=False, settings=settings)
    session.press(forearm().skin.taxel_point(150), force=1.0, finger=1)
    session.submit(PokePressed(2, forearm().skin.taxel_point(315), Finger(speed=0.4, max_force=40.0)))
    for _ in range(400):
        frame = session.tick()
        if any(region.force > settings.max_force for region in frame.regions):
            break
    else:
        pytest.fail("no contact was above the greatest force")
    assert any(limit.kind is LimitKind.STOPPED_BY_FORCE for limit in frame.why_limited)
