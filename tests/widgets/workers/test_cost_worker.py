"""The bench: a real process that prices effects and weighs a known load on copies of the scene."""

from __future__ import annotations

import multiprocessing as mp
import os
import signal

import pytest

from tactile_maps.scene.scene import with_override
from tactile_widgets.workers.cost_worker import MASS, CostWorker
from tactile_widgets.workers.worker_process import SourceToken
from tests.support.touch import prepared_bar

LONG = 60_000
SHORT = 0.1
"""For prices [s]: which they are, not how exact."""
HERE = SourceToken("here")


@pytest.fixture(scope="module")
def prepared():
    """A bar on a hinge: its ticks, of which thousands are timed, are the cheapest."""
    return prepared_bar()


@pytest.fixture(scope="module")
def cost_worker(qapp):
    """One for all tests that leave its process alone: to start one takes longer than most of them."""
    made = CostWorker(seconds=SHORT)
    yield made
    _end(made)


@pytest.fixture
def fresh_worker(cost_worker):
    """One whose process has not been started; it is gone after the test."""
    others = mp.active_children()
    made = CostWorker(seconds=SHORT)
    yield made
    _end(made, others)


def _end(worker, others=()):
    worker.close()
    worker.deleteLater()
    assert [p.pid for p in mp.active_children()] == [p.pid for p in others], "a process outlived its tests"


def test_a_load_is_weighed_beside(cost_worker, prepared, qtbot):
    with qtbot.waitSignal(cost_worker.weighed, timeout=LONG) as got:
        cost_worker.weigh(prepared, prepared.scene.effects, HERE)
        assert cost_worker.busy_weighing
    weighed = got.args[0].value
    assert weighed.wanted_N == pytest.approx(9.81 * MASS)
    assert abs(weighed.error) < 0.01
    assert not cost_worker.busy_weighing


def test_a_scene_without_a_skin_cannot_weigh_and_says_why(cost_worker, prepared, qtbot):
    with qtbot.waitSignal(cost_worker.failed, timeout=LONG) as got:
        cost_worker.weigh(prepared, with_override(prepared.scene, "skin", "off").effects, HERE)
    assert "known-load check cannot run" in got.args[0].value
    assert not cost_worker.busy_weighing


def test_weighing_can_be_cancelled(fresh_worker, prepared, qtbot):
    told = []
    fresh_worker.weighed.connect(told.append)
    fresh_worker.weigh(prepared, prepared.scene.effects, HERE)
    fresh_worker.cancel_weighing()
    assert not fresh_worker.busy_weighing
    assert fresh_worker.process.pid is None
    fresh_worker.cancel_weighing()
    assert told == []


def test_prices_are_of_what_is_on_and_only_the_newest_is_measured(cost_worker, prepared, qtbot):
    told = []
    cost_worker.priced.connect(told.append)
    for wish in ("on", "auto", "on", "auto", "on"):
        cost_worker.price(prepared, with_override(prepared.scene, "noise", wish).effects, HERE)
    qtbot.waitUntil(lambda: not cost_worker.process.waiting, timeout=LONG)
    assert len(told) <= 2
    assert "noise" in told[-1].value
    assert "friction" not in told[-1].value


def test_prices_that_were_overtaken_are_told_to_nobody(cost_worker, prepared, qtbot):
    told = []
    cost_worker.priced.connect(told.append)
    cost_worker.price(prepared, with_override(prepared.scene, "noise", "on").effects, HERE)
    first = cost_worker.process.waiting
    cost_worker.price(prepared, with_override(prepared.scene, "noise", "auto").effects, HERE)
    assert cost_worker.process.waiting == first, "the newer one waits until the older is done"
    qtbot.waitUntil(lambda: not cost_worker.process.waiting, timeout=LONG)
    assert len(told) == 1
    assert "noise" not in told[0].value


def test_results_know_what_they_were_asked_for(cost_worker, prepared, qtbot):
    """Also where another scene has been shown since: whoever receives them drops them by their token."""
    there = HERE.next()
    got = []
    cost_worker.priced.connect(got.append)
    with qtbot.waitSignal(cost_worker.weighed, timeout=LONG) as weighed:
        cost_worker.price(prepared, prepared.scene.effects, HERE)
        cost_worker.weigh(prepared, prepared.scene.effects, there)
    assert [result.token for result in got] == [HERE]
    assert weighed.args[0].token == there


def test_a_bench_that_dies_says_so_and_the_next_load_is_weighed(fresh_worker, prepared, qtbot):
    with qtbot.waitSignal(fresh_worker.failed, timeout=LONG) as got:
        fresh_worker.weigh(prepared, prepared.scene.effects, HERE)
        qtbot.waitUntil(lambda: fresh_worker.process.pid is not None, timeout=LONG)
        os.kill(fresh_worker.process.pid, signal.SIGKILL)
    assert "unexpectedly" in got.args[0].value
    with qtbot.waitSignal(fresh_worker.weighed, timeout=LONG):
        fresh_worker.weigh(prepared, prepared.scene.effects, HERE)
