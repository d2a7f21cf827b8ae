"""What the controller is doing, in words that fit what it does."""

from __future__ import annotations

from dataclasses import replace

import pytest

from app.control.command import ControlSettings
from app.control.report import TaskReport
from app.control.settings_check import CHOICES
from tests.widgets.hand_made import leaf_map, touched
from widgets.panels.task_words import task_words

MAP = leaf_map()
NOBODY, ONE, TWO = touched(MAP), touched(MAP, [10]), touched(MAP, [10, 300])


def said(task, frame, *limits, law="hybrid", error=None, way=0.0, transfer="", report=True, **settings):
    assert len(TWO.regions) == 2
    told = TaskReport(error=error, way=way, transfer=transfer) if report else None
    return task_words(ControlSettings(law=law, task=task, **settings), replace(frame, task=told, why_limited=limits))


@pytest.mark.parametrize("task", CHOICES["task"])
def test_every_task_waits_and_works_in_its_own_words(task):
    waiting, working = said(task, NOBODY), said(task, TWO, error=0.001)
    assert waiting != working
    assert waiting.startswith(("Waiting", "Ready"))


@pytest.mark.parametrize(
    ("task", "frame", "words"),
    [
        ("keep_force", ONE, "Keeping 3.0\u202fN"),
        ("balance", ONE, "Keeping 3.0\u202fN"),
        ("balance", TWO, "Balancing 2 contacts"),
        ("retreat", ONE, "Retreating from 1 contact"),
        ("retreat", TWO, "Retreating from 2 contacts"),
        ("hold_point", ONE, "Holding the point, 1.2\u202fmm off"),
        ("guide", ONE, "Following the hand, 1.2\u202fmm off"),
        ("follow_path", ONE, "Following the path, 34\u202fmm along it, 1.2\u202fmm off"),
    ],
)
def test_work_is_told_with_its_numbers(task, frame, words):
    at_a_place = task in ("hold_point", "guide", "follow_path")
    assert said(task, frame, error=0.0012 if at_a_place else None, way=0.0341) == words


def test_a_path_that_waits_says_so():
    words = said("follow_path", ONE, "the path waits for the contact", error=0.0104)
    assert words == "Waiting for the contact, 10.4\u202fmm off"


def test_what_went_wrong_comes_first():
    assert said("keep_force", NOBODY, "contact lost") == "Looking for the contact it just lost"
    assert said("keep_force", ONE, "stopped: 41 N of force, more than 40 N; lift what touches") == "Standing still"


@pytest.mark.parametrize(
    ("state", "word"), [("look", "Looking"), ("lift", "Carrying"), ("press", "Carrying"), ("return", "back")]
)
def test_a_contact_that_is_carried_over_a_crossing_is_told(state, word):
    assert word in said("follow_path", NOBODY, transfer=state)


def test_laws_without_a_task_say_what_they_do():
    assert said("guide", ONE, law="impedance", report=False) == "Holding the rest posture"
    assert said("guide", NOBODY, law="hold_force", report=False) == "Waiting for a contact"
    assert said("guide", ONE, law="hold_force", report=False, force_goal=4.0) == "Keeping 4.0\u202fN"
