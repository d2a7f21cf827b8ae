"""Step response and status text of the controller panel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.motion.command import CHOICES, ControlSettings, TaskReport
from tactile_maps.control.motion.command import RegraspState as State
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_widgets.panels.control.controller_panel import StepResponseMonitor, step_response_text, task_status_text
from tests.widgets.support.samples import leaf_map, touched

TICK = 0.016


def follow(watch, seconds, *, start, goal, force):
    for k in range(round(seconds / TICK)):
        time = start + k * TICK
        watch.take(time, force(time - start) if callable(force) else force, goal)
    return start + seconds


def stepped(answer=lambda t: 6 - 3 * np.exp(-t / 0.1)):
    watch = StepResponseMonitor()
    now = follow(watch, 1.0, start=0.0, goal=3.0, force=3.0)
    follow(watch, 2.0, start=now, goal=6.0, force=answer)
    return watch


def test_first_goal_is_not_a_step():
    watch = StepResponseMonitor()
    follow(watch, 1.0, start=0.0, goal=3.0, force=0.0)
    assert watch.response is None


def test_step_response_is_measured():
    found = stepped().response
    assert (found.before, found.goal, found.overshoot) == (3.0, 6.0, 0.0)
    assert found.settling == pytest.approx(0.3, abs=2 * TICK)
    assert step_response_text(found).startswith("Goal 3.0 → 6.0\u202fN: 0\u202f% overshoot, settled in 0.3")


def test_overshoot_and_unsettled_response_are_stated():
    found = stepped(lambda t: 6.0 + 1.5 * np.exp(-t) * np.cos(8 * t)).response
    assert found.overshoot == pytest.approx(0.5, abs=0.02)
    assert step_response_text(stepped(lambda _t: 4.0).response).endswith("0\u202f% overshoot, not settled yet")


def test_continuous_slider_move_is_one_step():
    watch = StepResponseMonitor()
    now = follow(watch, 1.0, start=0.0, goal=3.0, force=3.0)
    for goal in (3.5, 4.0, 4.5, 5.0):
        now = follow(watch, 0.1, start=now, goal=goal, force=3.0)
    follow(watch, 1.0, start=now, goal=5.0, force=5.0)
    assert (watch.response.before, watch.response.goal) == (3.0, 5.0)


def test_goal_that_returned_is_not_a_step():
    watch = StepResponseMonitor()
    now = follow(watch, 1.0, start=0.0, goal=3.0, force=3.0)
    now = follow(watch, 0.1, start=now, goal=4.0, force=3.0)
    follow(watch, 0.5, start=now, goal=3.0, force=3.0)
    assert watch.response is None


def test_lost_contact_ends_the_measurement_and_its_return_is_not_a_step():
    watch = stepped()
    before = watch.response
    watch.take(3.1, 0.0, None)
    watch.take(3.2, 0.0, 6.0)
    assert watch.response.before == before.before
    assert watch.response.goal == before.goal


def test_other_change_ends_the_measurement():
    watch = stepped()
    before = watch.response
    watch.hold()
    follow(watch, 1.0, start=3.0, goal=6.0, force=20.0)
    assert watch.response == before
    follow(watch, 1.0, start=4.0, goal=2.0, force=2.0)
    assert watch.response.goal == 2.0, "until the next step"


def test_time_that_runs_backwards_resets_the_measurement():
    watch = stepped()
    watch.take(0.0, 0.0, 6.0)
    assert watch.response is None


MAP = leaf_map()
NO_CONTACT = touched(MAP)
ONE = touched(MAP, [10])
TWO = touched(MAP, [10, 300])


def said(task, frame, *limits, controller="hybrid", error=None, way=0.0, regrasp=None, report=True, **settings):
    assert len(TWO.regions) == 2
    task_report = TaskReport(error=error, way=way, regrasp=regrasp) if report else None
    return task_status_text(
        ControlSettings(controller=controller, task=task, **settings),
        replace(frame, task=task_report, why_limited=limits),
    )


@pytest.mark.parametrize("task", CHOICES["task"])
def test_every_task_has_texts_for_waiting_and_working(task):
    waiting = said(task, NO_CONTACT)
    working = said(task, TWO, error=0.001)
    assert waiting != working
    assert waiting.startswith(("Waiting", "Ready"))


@pytest.mark.parametrize(
    ("task", "frame", "words"),
    [
        ("keep_force", ONE, "Approaching 3.0\u202fN, now 8.6\u202fN"),
        ("balance", ONE, "Approaching 3.0\u202fN, now 8.6\u202fN"),
        ("balance", TWO, "Balancing 2 contacts"),
        ("retreat", ONE, "Retreating from 1 contact"),
        ("retreat", TWO, "Retreating from 2 contacts"),
        ("hold_point", ONE, "Holding the point, error 1.2\u202fmm"),
        ("guide", ONE, "Hand guiding, error 1.2\u202fmm"),
        ("follow_path", ONE, "Following path, 34\u202fmm along it, error 1.2\u202fmm"),
    ],
)
def test_status_of_a_task_contains_its_numbers(task, frame, words):
    at_a_place = task in ("hold_point", "guide", "follow_path")
    assert said(task, frame, error=0.0012 if at_a_place else None, way=0.0341) == words


def test_status_states_the_number_of_controlled_contacts():
    goal = max(region.force for region in TWO.regions)
    ids = tuple(region.id for region in TWO.regions)
    settings = ControlSettings(controller="hybrid", task="keep_force", force_goal=goal)
    for controlled, words in (
        (ids, f"Keeping {goal:.1f}\u202fN at 2 contacts"),
        (ids[:1], f"Keeping {goal:.1f}\u202fN"),
    ):
        assert task_status_text(settings, replace(TWO, task=TaskReport(controlled=controlled))) == words


def test_waiting_path_is_reported():
    words = said("follow_path", ONE, Limit(LimitKind.PATH_WAITS), error=0.0104)
    assert words == "Waiting for the contact, error 10.4\u202fmm"


def test_problem_is_reported_first():
    assert said("keep_force", NO_CONTACT, Limit(LimitKind.CONTACT_LOST)) == "Reacquiring contact"
    assert said("keep_force", ONE, Limit(LimitKind.STOPPED_BY_FORCE, value=41.0, bound=40.0)) == "Stopped"


@pytest.mark.parametrize(
    ("state", "word"),
    [
        (State.PLAN, "Planning"),
        (State.LIFT, "Regrasping"),
        (State.PRESS, "Regrasping"),
        (State.RETURN, "back"),
    ],
)
def test_regrasp_of_a_contact_is_reported(state, word):
    assert word in said("follow_path", NO_CONTACT, regrasp=state)


def test_controllers_without_a_task_describe_their_activity():
    assert said("guide", NO_CONTACT, controller="impedance", report=False) == "Holding its posture"
    assert said("guide", NO_CONTACT, controller="hold_force", report=False) == "Waiting for a contact"


@pytest.mark.parametrize(("frame", "words"), [(NO_CONTACT, "Moving to its posture"), (ONE, "Yielding to the touch")])
def test_moving_arm_is_not_reported_as_holding(frame, words):
    moving = replace(frame, posture=np.zeros(2), velocity=np.array([0.0, 0.1]))
    assert said("guide", moving, controller="impedance", report=False) == words


@pytest.mark.parametrize(("controller", "report"), [("hold_force", False), ("hybrid", True)])
def test_force_is_reported_as_kept_only_if_it_is_measured(controller, report):
    goal = ONE.regions[0].force
    kept = said("keep_force", ONE, controller=controller, report=report, force_goal=goal)
    assert kept == f"Keeping {goal:.1f}\u202fN"
    missed = said("keep_force", ONE, controller=controller, report=report, force_goal=0.5 * goal)
    assert missed == f"Approaching {0.5 * goal:.1f}\u202fN, now {goal:.1f}\u202fN"
