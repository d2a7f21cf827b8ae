"""The bench: a real process that prices effects and weighs a known load on copies of the scene."""

from __future__ import annotations

import multiprocessing as mp
import os
import signal

import pytest

from app.scene.scene import with_wish
from widgets.bench import MASS, Bench

LONG = 60_000


@pytest.fixture
def bench():
    """A bench whose process is gone after the test."""
    made = Bench()
    yield made
    made.close()
    made.deleteLater()
    assert not mp.active_children(), "a process outlived its test"


def test_a_load_is_weighed_beside(bench, prepared, qtbot):
    with qtbot.waitSignal(bench.weighed, timeout=LONG) as got:
        bench.weigh(prepared, prepared.scene.effects)
        assert bench.busy_weighing
    weighed = got.args[0]
    assert weighed.wanted_N == pytest.approx(9.81 * MASS)
    assert abs(weighed.error) < 0.01
    assert not bench.busy_weighing


def test_a_scene_without_a_skin_cannot_weigh_and_says_why(bench, prepared, qtbot):
    with qtbot.waitSignal(bench.failed, timeout=LONG) as got:
        bench.weigh(prepared, with_wish(prepared.scene, "skin", "off").effects)
    assert "weighed" in got.args[0]
    assert not bench.busy_weighing


def test_weighing_can_be_cancelled(bench, prepared, qtbot):
    told = []
    bench.weighed.connect(told.append)
    bench.weigh(prepared, prepared.scene.effects)
    bench.cancel_weighing()
    assert not bench.busy_weighing
    assert bench.process.pid is None
    bench.cancel_weighing()
    assert told == []


def test_prices_are_of_what_is_on_and_only_the_newest_is_measured(bench, prepared, qtbot):
    told = []
    bench.priced.connect(told.append)
    for wish in ("on", "auto", "on", "auto", "on"):
        bench.price(prepared, with_wish(prepared.scene, "noise", wish).effects)
    qtbot.waitUntil(lambda: not bench.process.waiting, timeout=LONG)
    assert len(told) <= 2
    assert "noise" in told[-1]
    assert "friction" not in told[-1]


def test_a_bench_that_dies_says_so_and_the_next_load_is_weighed(bench, prepared, qtbot):
    with qtbot.waitSignal(bench.failed, timeout=LONG) as got:
        bench.weigh(prepared, prepared.scene.effects)
        qtbot.waitUntil(lambda: bench.process.pid is not None, timeout=LONG)
        os.kill(bench.process.pid, signal.SIGKILL)
    assert "unexpectedly" in got.args[0]
    with qtbot.waitSignal(bench.weighed, timeout=LONG):
        bench.weigh(prepared, prepared.scene.effects)
