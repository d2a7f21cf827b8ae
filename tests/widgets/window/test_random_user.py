"""The window under a random hand: no exception, no Qt warning, a whole map, a session alive, no freeze.

A fault names its seed, its act and the last twenty acts. The acts of a seed hang on nothing before it, so
``pytest "tests/widgets/window/test_random_user.py::test_ten_thousand_random_actions[7]"`` does the same again.
"""

from __future__ import annotations

import os

import pytest
from PySide6.QtCore import QTimer
from PySide6.QtTest import QTest

from tactile_widgets.session.backends import BACKGROUND
from tests.support.watchdog import Watchdog
from tests.widgets.support.random_user import RandomUser
from tests.widgets.support.small_scenes import SmallScenes, everything_that_opens, open_named
from tests.widgets.support.window_driver import run

ACTS = 100
WORKS = 50
BATCH = 500
BATCHES = 20
TAXELS = 120
FREEZE_ACTS = int(os.environ.get("TACTILE_MAPS_FREEZE_ACTS", "300"))
FREEZE = 1.0
"""Longer than this the window must not be away [s]."""


@pytest.fixture(scope="module")
def small_scenes():
    """All that ships, in few taxels."""
    return SmallScenes(TAXELS)


@pytest.fixture
def openable(new_window, small_scenes, monkeypatch):
    """Opens one of all scenes and robots that ship, by number; its name."""
    monkeypatch.setattr("tactile_widgets.jobs.scene_jobs.prepare_cached", small_scenes.prepare)
    names = everything_that_opens()

    def open_one(number: int) -> str:
        name = names[number % len(names)]
        open_named(new_window, name)
        return name

    return open_one


@pytest.mark.long
def test_random_user_leaves_a_consistent_window(new_window, tmp_path):
    with RandomUser(new_window, 2, tmp_path, lambda seconds: run(new_window, seconds)) as user:
        user.run(ACTS)
    assert user.done == ACTS


@pytest.fixture
def small_robots(new_window, monkeypatch):
    """Opens the arm or the slide, by number, with few taxels; its name."""
    small = SmallScenes(60)
    monkeypatch.setattr("tactile_widgets.jobs.scene_jobs.prepare_cached", small.prepare)

    def open_one(number: int) -> str:
        name = ("scene arm", "scene slide")[number % 2]
        open_named(new_window, name)
        return name

    return open_one


@pytest.mark.parametrize(
    ("seed", "works"), [(1, 15), *(pytest.param(seed, WORKS, marks=pytest.mark.long) for seed in range(1, BATCHES))]
)
def test_work_of_the_user_is_kept_or_asked_about(new_window, tmp_path, small_robots, seed, works):
    def pass_time(seconds: float) -> None:
        run(new_window, seconds)

    with RandomUser(new_window, seed, tmp_path, pass_time, scenes=small_robots, works=True) as user:
        user.run(works)
    assert user.done == works


@pytest.mark.long
@pytest.mark.parametrize("seed", range(BATCHES))
def test_ten_thousand_random_actions(new_window, tmp_path, openable, seed):
    """The acts run in batches, each in a new window; they open scenes and robots of all kinds."""
    with RandomUser(new_window, seed, tmp_path, lambda seconds: run(new_window, seconds), scenes=openable) as user:
        user.run(BATCH)
    assert user.done == BATCH


@pytest.mark.long
@pytest.mark.parametrize("backends", [BACKGROUND])
def test_window_never_freezes_for_a_second(new_window, tmp_path):
    """The window uses threads and processes as for a user; direct and deferred effects of an act count."""
    pulse = QTimer()
    pulse.setInterval(10)
    with Watchdog(FREEZE) as dog:
        pulse.timeout.connect(dog.beat)
        pulse.start()

        def let_it_run(seconds: float) -> None:
            QTest.qWait(round(1e3 * seconds))

        with RandomUser(new_window, 5, tmp_path, let_it_run, before=dog.begin) as user:
            user.run(FREEZE_ACTS)
        pulse.stop()
    own = [
        stall for stall in dog.stalls if stall.cpu > 0.5 * stall.seconds
    ]  # not of a machine that is busy with others
    assert not own, "\n".join(map(str, own))
