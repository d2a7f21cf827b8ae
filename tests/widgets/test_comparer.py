"""The process that runs laws side by side: real, cancelled, killed, and refused."""

from __future__ import annotations

import os
import signal

import numpy as np
import pytest

from app.control.command import ControlChanged, ControlSettings
from app.session.side_by_side import MOST_SECONDS, Contender
from app.touch.poke import PokePressed
from widgets.law_comparison.comparer import Comparer, InlineComparer, Match
from widgets.law_comparison.occasion import Occasion

START = 20_000
"""For a process to start on a busy machine [ms]."""
LAWS = (Contender("A", ControlSettings(law="hybrid")), Contender("B", ControlSettings(law="qp")))


@pytest.fixture
def comparer(qtbot):
    made = Comparer()
    yield made
    made.close()


def match(prepared, *, seconds=0.3):
    acts = ((0, ControlChanged(ControlSettings())), (2, PokePressed(1, prepared.skin.taxel_point(20))))
    return Match(Occasion(prepared, acts, 1.0), LAWS, seconds, own_task=True)


def test_laws_are_run_beside_and_give_what_they_give_here(comparer, prepared, qtbot):
    told = []
    comparer.progressed.connect(lambda text, done: told.append(done))
    with qtbot.waitSignal(comparer.compared, timeout=START) as beside:
        comparer.run(match(prepared))
        assert comparer.busy
    assert not comparer.busy
    assert comparer.process.pid is None, "it ends when it is done"
    assert told[0] == 0
    assert told[-1] == 1
    here = InlineComparer()
    with qtbot.waitSignal(here.compared) as inline:
        here.run(match(prepared))
    for one, other in zip(beside.args[0], inline.args[0], strict=True):
        assert np.array_equal(one.force, other.force)
        assert np.array_equal(one.joint_speed, other.joint_speed)
        assert not one.force.flags.writeable


def test_it_can_be_cancelled_and_asked_again(comparer, prepared, qtbot):
    got = []
    comparer.compared.connect(got.append)
    with qtbot.waitSignal(comparer.progressed, timeout=START, check_params_cb=lambda _text, done: done > 0):
        comparer.run(match(prepared, seconds=MOST_SECONDS))
    comparer.close()
    assert not comparer.busy
    with qtbot.waitSignal(comparer.compared, timeout=START):
        comparer.run(match(prepared))
    assert len(got) == 1


@pytest.mark.parametrize("make", [Comparer, InlineComparer])
def test_what_cannot_be_run_is_told(make, prepared, qtbot):
    made = make()
    with qtbot.waitSignal(made.failed, timeout=START) as failed:
        made.run(match(prepared, seconds=2 * MOST_SECONDS))
    assert "such a time" in failed.args[0]
    assert not made.busy
    made.close()


def test_a_process_that_dies_is_told(comparer, prepared, qtbot):
    with qtbot.waitSignal(comparer.progressed, timeout=START, check_params_cb=lambda _text, done: done > 0):
        comparer.run(match(prepared, seconds=MOST_SECONDS))
    with qtbot.waitSignal(comparer.failed, timeout=START) as failed:
        os.kill(comparer.process.pid, signal.SIGKILL)
    assert "ended unexpectedly" in failed.args[0]
