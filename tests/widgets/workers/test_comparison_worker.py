"""The process that runs laws side by side: real, cancelled, killed, and refused."""

from __future__ import annotations

import os
import signal

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.session.inputs import ControlChanged
from tactile_maps.studies.controller_comparison import MOST_SECONDS, Contender
from tactile_maps.tactile.poke import PokePressed
from tactile_widgets.workers.comparison_worker import (
    ComparisonRequest,
    ComparisonStimulus,
    ComparisonWorker,
    InlineComparisonWorker,
)
from tactile_widgets.workers.worker_process import SourceToken
from tests.support.recordings import record

START = 20_000
"""For a process to start on a busy machine [ms]."""
HERE = SourceToken("here")
LAWS = (Contender("A", ControlSettings(controller="hybrid")), Contender("B", ControlSettings(controller="qp")))


@pytest.fixture
def comparison_worker(qtbot):
    made = ComparisonWorker()
    yield made
    made.close()


def match(prepared, *, seconds=0.3):
    acts = ((0, ControlChanged(ControlSettings())), (2, PokePressed(1, prepared.skin.taxel_point(20))))
    return ComparisonRequest(ComparisonStimulus(prepared, acts, 1.0), LAWS, seconds, own_task=True)


def test_laws_are_run_beside_and_give_what_they_give_here(comparison_worker, prepared, qtbot):
    told = []
    comparison_worker.progressed.connect(lambda text, done: told.append(done))
    with qtbot.waitSignal(comparison_worker.compared, timeout=START) as beside:
        comparison_worker.run(match(prepared), HERE)
        assert comparison_worker.busy
    assert not comparison_worker.busy
    assert comparison_worker.process.pid is None, "it ends when it is done"
    assert told[0] == 0
    assert told[-1] == 1
    here = InlineComparisonWorker()
    with qtbot.waitSignal(here.compared) as inline:
        here.run(match(prepared), HERE)
    for one, other in zip(beside.args[0].value, inline.args[0].value, strict=True):
        assert np.array_equal(one.force, other.force)
        assert np.array_equal(one.joint_speed, other.joint_speed)
        assert not one.force.flags.writeable


def test_a_stimulus_is_read_from_a_recording_beside(comparison_worker, prepared, qtbot, tmp_path):
    session = record(prepared, tmp_path / "half.mcap", ticks=100)
    told = []
    comparison_worker.reading.connect(lambda _text, done: told.append(done))
    with qtbot.waitSignal(comparison_worker.read, timeout=START) as got:
        comparison_worker.read_stimulus(tmp_path / "half.mcap", HERE)
        assert comparison_worker.busy
    stimulus = got.args[0].value
    assert (stimulus.file, stimulus.touches) == ("half.mcap", 2), "the scripted touch and the one by hand"
    assert stimulus.seconds == pytest.approx(session.frame.time)
    assert told[0] == 0


def test_it_can_be_cancelled_and_asked_again(comparison_worker, prepared, qtbot):
    got = []
    comparison_worker.compared.connect(got.append)
    with qtbot.waitSignal(comparison_worker.progressed, timeout=START, check_params_cb=lambda _text, done: done > 0):
        comparison_worker.run(match(prepared, seconds=MOST_SECONDS), HERE)
    comparison_worker.close()
    assert not comparison_worker.busy
    with qtbot.waitSignal(comparison_worker.compared, timeout=START):
        comparison_worker.run(match(prepared), HERE)
    assert len(got) == 1


@pytest.mark.parametrize("make", [ComparisonWorker, InlineComparisonWorker])
def test_what_cannot_be_run_is_told(make, prepared, qtbot):
    made = make()
    with qtbot.waitSignal(made.failed, timeout=START) as failed:
        made.run(match(prepared, seconds=2 * MOST_SECONDS), HERE)
    assert "such a time" in failed.args[0].value
    assert not made.busy
    made.close()


def test_a_process_that_dies_is_told(comparison_worker, prepared, qtbot):
    with qtbot.waitSignal(comparison_worker.progressed, timeout=START, check_params_cb=lambda _text, done: done > 0):
        comparison_worker.run(match(prepared, seconds=MOST_SECONDS), HERE)
    with qtbot.waitSignal(comparison_worker.failed, timeout=START) as failed:
        os.kill(comparison_worker.process.pid, signal.SIGKILL)
    assert "ended unexpectedly" in failed.args[0].value
