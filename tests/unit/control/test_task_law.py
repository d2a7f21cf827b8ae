"""What all laws with a task share: supervision, energy, contacts that go along, going home or staying."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.control.hybrid import Hybrid
from app.control.map_sight import MapSight
from app.control.quadratic_program import QuadraticProgram
from app.control.task_keeper import TaskKeeper
from app.control.task_law import LOST_SPEED, TaskLaw
from tests.touch import arm, prepared_bar
from tests.unit.control.touched import TICK, touch, touch_on

BAR, STILL, BENT = prepared_bar(), np.zeros(1), np.array([0.5])


def law_on(prepared=BAR) -> TaskLaw:
    return TaskLaw(prepared.robot, Hybrid(), TaskKeeper(), MapSight(prepared.map))


def test_too_much_force_stops_it_softly_where_it_is():
    law, settings = law_on(), ControlSettings(law="hybrid", max_force=30.0)
    before = law.command(settings, BENT, STILL, touch(10.0), TICK)
    command = law.command(settings, BENT, STILL, touch(31.0), TICK)
    assert "31 N of force" in law.why_limited[0]
    assert command.posture == BENT
    assert (command.stiffness < 0.1 * before.stiffness).all()
    for _ in range(210):
        command = law.command(settings, STILL, STILL, (), TICK)
    assert law.why_limited == ()
    assert abs(command.posture[0]) < 0.01, "it goes on from where it is"


@pytest.mark.parametrize(("task", "stays"), [("keep_force", False), ("guide", True), ("retreat", True)])
def test_after_the_touch_it_goes_home_or_stays(task, stays):
    law, posture = law_on(), BENT
    for tick in range(800):
        posture = law.command(ControlSettings(law="hybrid", task=task), posture, STILL, (), TICK).posture
        assert tick or posture == pytest.approx(BENT, abs=1e-3)
    assert (abs(posture[0]) > 0.4) == stays


def test_after_a_contact_was_lost_for_good_it_comes_home_slowly_and_says_so():
    """What it lost may stand in the way."""
    law, settings, posture = law_on(), ControlSettings(law="hybrid"), BENT
    law.command(settings, posture, STILL, touch(3.0), TICK)
    steps = []
    for _ in range(1600):
        before, posture = posture, law.command(settings, posture, STILL, (), TICK).posture
        steps.append(abs(posture[0] - before[0]) / TICK)
        slow = any("coming home slowly" in why for why in law.why_limited)
        assert slow or "contact lost" in law.why_limited or abs(posture[0]) < 0.011
    assert max(steps[100:]) == pytest.approx(LOST_SPEED, rel=0.01)


def test_giving_energy_for_long_is_slowed_to_nothing_and_said():
    """Something gives way for ever under the goal force."""
    law, settings = law_on(), ControlSettings(law="hybrid", force_goal=20.0, force_gain=0.015)
    posture, speeds = STILL, []
    velocity = np.array([-0.25 / 0.3])  # outward
    for _ in range(200):
        command = law.command(settings, posture, velocity, touch(15.0), TICK)
        speeds.append(float(law._speed[0]))
    assert speeds[0] == pytest.approx(-0.25, abs=0.01), "0.015 m/s per newton at 0.3 m"
    assert speeds[-1] == pytest.approx(0.0, abs=1e-6)
    assert any("energy given to the contact" in why for why in law.why_limited)
    assert law.tank.given == pytest.approx(15.0 * 0.25 * 1.0, rel=0.05)
    law.command(settings, posture, STILL, touch(25.0), TICK)
    assert law._speed[0] > 0, "it may always retreat"
    for _ in range(200):
        law.command(settings, posture, STILL, (), TICK)
    assert law.tank.given == 0.0, "a new contact starts with a full tank"
    assert command.posture.shape == (1,)


def test_a_contact_that_goes_along_with_the_skin_is_let_slide():
    prepared = arm()
    law, posture = law_on(prepared), prepared.robot.home
    pairs = prepared.skin.neighbours
    here, there = (int(taxel) for taxel in pairs[pairs[:, 0] > prepared.skin.first[1] + 40][0])
    settings = ControlSettings(law="hybrid", task="hold_point")
    law.command(settings, posture, np.zeros(7), (touch_on(prepared.map, here, 3.0),), TICK)
    speeds = []
    for _ in range(400):
        posture = law.command(settings, posture, np.zeros(7), (touch_on(prepared.map, there, 3.0),), TICK).posture
        speeds.append(np.abs(law._speed).max())
    assert speeds[10] > 0.01
    assert speeds[-1] == pytest.approx(0, abs=1e-9)
    assert law.why_limited == ("the contact goes along with the skin",)


def test_a_rule_is_told_of_contacts_that_the_task_is_not_about():
    """The program keeps the second one under its cap, though the first should be pressed more."""
    law = TaskLaw(BAR.robot, QuadraticProgram(), TaskKeeper(), MapSight(BAR.map))
    settings = ControlSettings(law="qp", max_force=40.0, force_goal=20.0)
    law.command(settings, STILL, STILL, touch(1.0), TICK)
    for _ in range(3):  # accelerations are bounded too
        law.command(settings, STILL, STILL, (*touch(33.0, id_=2), *touch(1.0)), TICK)
    assert "force cap" in law.why_limited
    assert law._speed[0] > 0, "away from it"


def test_every_limit_is_said_once():
    law = law_on()
    for _ in range(5):
        law.command(ControlSettings(law="hybrid", max_force=200.0), STILL, STILL, touch(100.0), TICK)
        assert len(set(law.why_limited)) == len(law.why_limited) > 0
