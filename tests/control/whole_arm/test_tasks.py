"""Tasks of the controllers on the whole arm: next to a fixed ball, against a finger, and with unreadable taxels."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.contacts.pipeline import ContactPipeline
from tactile_maps.control.controller_manager import ControllerManager
from tactile_maps.control.controllers import CONTROL_SCHEMES
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import HOME_SPEED, MAX_JOINT_SPEED
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.control.motion.observation import Observation
from tactile_maps.session.inputs import ControlChanged
from tactile_maps.session.session import Session
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.tactile.poke import Finger, PokePressed, PokeReleased
from tests.control.hard_cases.case import GOAL
from tests.support.limits import kinds
from tests.support.pressed_arm import TICK, Course, forearm, pressed_by_ball
from tests.support.touch import arm

pytestmark = pytest.mark.long

STEADY = slice(round(2.0 / TICK), None)


def bounded(course: Course) -> None:
    assert np.isfinite(course.force).all()
    assert course.pressed.max() < 40.0
    assert course.speed.max() < 2 * MAX_JOINT_SPEED


def figure_of_eight(controller: str, *, taxel: int, radius: float = 0.03) -> Course:
    settings = ControlSettings(controller=controller, task="follow_path")
    course = Course(pressed_by_ball(settings, taxel=taxel, radius=radius), 10.0)
    bounded(course)
    assert course.force[STEADY].mean() == pytest.approx(3.0, abs=0.1)
    assert np.nanmedian(course.body_error[STEADY]) < 0.003
    assert np.nanpercentile(course.body_error[STEADY], 95) < 0.008
    assert LimitKind.CONTACT_LOST not in course.why
    return course


@pytest.mark.long
@pytest.mark.parametrize("controller", CONTROL_SCHEMES)
def test_path_is_followed_at_the_force_goal(controller):
    """A figure of eight of 30 mm at 10 mm/s: errors of the place that taxels 12 mm apart read are most of the error."""
    course = figure_of_eight(controller, taxel=188)
    assert not course.bare.any()
    assert course.force[STEADY].std() < 0.3


@pytest.mark.long
@pytest.mark.parametrize("controller", CONTROL_SCHEMES)
def test_path_is_followed_where_the_contact_centre_jumps(controller):
    """The centre jumps by a few mm where the ball leaves the last but one of three taxels.

    The ball is small enough not to touch the wrist, which has no skin; see the next test.
    """
    course = figure_of_eight(controller, taxel=150, radius=0.025)
    assert not course.bare.any()
    assert course.force[STEADY].std() < 0.3


@pytest.mark.long
@pytest.mark.parametrize("controller", CONTROL_SCHEMES)
def test_path_is_followed_where_a_bare_link_also_touches_the_ball(controller):
    """For half a second the wrist presses the ball from the side with up to 4 N, which no taxel reads.

    The parallel and the admittance scheme, which are slower, then let the force on the skin swing between 0.3 and 8 N.
    """
    course = figure_of_eight(controller, taxel=150, radius=0.032)
    assert 1.0 < course.bare.max() < 5.0
    if controller in ("parallel", "admittance"):
        assert course.force[STEADY].max() < 8.0
    else:
        assert course.force[STEADY].std() < 0.3


@pytest.mark.sampled(1)
@pytest.mark.parametrize("controller", CONTROL_SCHEMES)
def test_point_drawn_elsewhere_is_reached_and_held(controller):
    session = pressed_by_ball(ControlSettings(controller=controller, task="hold_point"))
    here = session.tick().regions[0].map_point
    target = (float(here[0]) + 0.012, float(here[1]) + 0.009)
    session.submit(ControlChanged(ControlSettings(controller=controller, task="hold_point", path=(target,))))
    course = Course(session, 6.0)
    bounded(course)
    assert course.error[0] > 0.012
    assert course.error[-1] < 0.002
    assert course.force[-1] == pytest.approx(3.0, abs=0.1)


@pytest.mark.long
@pytest.mark.parametrize("controller", ["parallel", "projection"])
def test_point_is_held_at_the_goal_against_a_finger_of_ten_times_the_force(controller):
    """The finger advances at 20 mm/s until it presses with 30 N."""
    session = Session(forearm(), settings=ControlSettings(controller=controller, task="hold_point"))
    session.submit(PokePressed(1, forearm().skin.taxel_point(150), Finger(speed=0.02, max_force=30.0)))
    course = Course(session, 6.0)
    bounded(course)
    assert course.last(course.pressed) == pytest.approx(3.0, abs=0.1)


CONTROL_TICK = 0.005


def pressed(taxel, *, seconds, goal=3.0, speed=0.006, **settings):
    """The finger's force at every tick, and the session afterwards."""
    session = Session(
        arm(), scripted=False, settings=ControlSettings(controller="hold_force", force_goal=goal, **settings)
    )
    session.submit(PokePressed(1, arm().skin.taxel_point(taxel), Finger(speed=speed, max_force=20.0)))
    return np.array([session.tick().pokes[0].force for _ in range(round(seconds / CONTROL_TICK))]), session


def forearm_taxels():
    return [int(taxel) for taxel in range(arm().skin.first[1] + 5, arm().skin.first[2], 15)]


@pytest.mark.long
@pytest.mark.parametrize(
    ("goal", "every"), [(3.0, 3), *(pytest.param(goal, 1, marks=pytest.mark.long) for goal in (1.0, 3.0, 8.0))]
)
def test_force_settles_at_the_goal(goal, every):
    """A finger that keeps advancing at 6 mm/s and would press with 20 N. How stiff it is the arm cannot measure, so
    the gain stays a little lower.
    """
    for taxel in forearm_taxels()[::every]:
        force, session = pressed(taxel, seconds=5.0, goal=goal)
        assert np.abs(force[400:] / goal - 1).max() < 0.05, f"taxel {taxel}"
        assert {one.kind for one in session.frame.why_limited} <= {LimitKind.FORCE_GAIN_HELD}, f"taxel {taxel}"


def test_force_without_integral_lags_by_the_speed_over_the_gain():
    """The arm retreats as fast as the finger advances in equilibrium: gain e = speed."""
    force, _ = pressed(forearm_taxels()[2], seconds=3.0, force_gain=0.015, gains="as_given", integral_time=float("inf"))
    assert force[-1] - 3.0 == pytest.approx(0.006 / 0.015, rel=0.05)


def test_arm_returns_gently_after_the_finger_left():
    _, session = pressed(forearm_taxels()[2], seconds=4.0)
    away = np.abs(session.frame.posture - arm().robot.home).max()
    assert away > 0.02
    session.submit(PokeReleased(1))
    speeds = []
    postures = [session.frame.command.posture]
    for _ in range(1200):
        frame = session.tick()
        speeds.append(np.abs(frame.velocity).max())
        postures.append(frame.command.posture)
    assert np.abs(np.diff(postures, axis=0)).max() / CONTROL_TICK <= HOME_SPEED * (1 + 1e-9)
    assert max(speeds) < 1.5 * HOME_SPEED
    assert frame.posture == pytest.approx(arm().robot.home, abs=1e-3)


BAD = {"one taxel": slice(150, 151), "all taxels": slice(None), "one far away": slice(0, 1)}
FAULT = 1.0
REPAIRED = 2.0
END = 5.0
"""Times of the fault, of its end and of the end of the run [s]."""


class Run:
    """A session loop of the test's own, with faulty readings for some time.

    Attributes:
        pressed: (k,) what truly presses [N].
        postures: (k, n).
        commanded: (k, n).
        said: (k,) why the manager was limited.
    """

    def __init__(self, controller: str, where: slice, value: float) -> None:
        scene = pressed_by_ball(ControlSettings()).prepared
        simulation = Simulation(
            scene.robot, scene.skin, scene.scene.effects, objects=scene.objects, layer=scene.scene.layer, tick=TICK
        )
        sense = ContactPipeline(scene.robot, scene.map, scene.scene.effects.sensor)
        manager = ControllerManager(scene.robot, scene.map, ControlSettings(controller=controller, task="hold_point"))
        rows = []
        self.said = []
        for k in range(round(END / TICK)):
            pressures = simulation.sense().copy()
            if FAULT <= k * TICK < REPAIRED:
                pressures[where] = value
            regions = sense.read(k, k * TICK, simulation.posture, pressures)
            readable = bool(np.isfinite(pressures).all())
            command = manager.command(
                Observation(simulation.posture, simulation.velocity, regions, TICK, readable=readable)
            )
            rows.append(
                (simulation.total_normal_force, np.abs(simulation.velocity).max(), simulation.posture, command.posture)
            )
            self.said.append(manager.why_limited)
            simulation.step(round(scene.scene.tick / scene.scene.effects.timestep), command)
        pressed, speed, postures, commanded = zip(*rows, strict=True)
        self.pressed = np.array(pressed)
        self.speed = np.array(speed)
        self.postures = np.array(postures)
        self.commanded = np.array(commanded)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("value", [float("nan"), float("inf")])
@pytest.mark.parametrize("where", BAD)
@pytest.mark.parametrize("controller", ["hybrid", "qp", "hold_force"])
def test_arm_stops_while_the_skin_is_unreadable(controller, where, value):
    run = Run(controller, BAD[where], value)
    broken = slice(round(FAULT / TICK), round(REPAIRED / TICK))
    assert np.isfinite(run.commanded).all()
    unread = LimitKind.SKIN_UNREADABLE if controller == "hold_force" else LimitKind.STOPPED_UNREADABLE
    assert all(unread in kinds(said) for said in run.said[broken])
    assert np.abs(run.postures[broken] - run.postures[broken][0]).max() < 0.02
    assert run.pressed.max() < 8.0
    assert run.speed.max() < MAX_JOINT_SPEED
    if controller == "hold_force":  # without a safety stop: it continues where it stopped
        assert run.pressed[-1] == pytest.approx(GOAL, abs=0.1)
        assert run.said[-1] == ()
    else:  # it continues when nothing has touched for a second
        later = run.said[round((REPAIRED + 0.5) / TICK)]
        assert later == (Limit(LimitKind.STOPPED_UNREADABLE),)
