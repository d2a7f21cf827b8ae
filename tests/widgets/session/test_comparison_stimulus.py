"""Functions that compare controllers and read a stimulus in the background."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.session.inputs import ControlChanged
from tactile_maps.studies.controller_comparison import Contender
from tactile_maps.tactile.poke import PokePressed
from tactile_widgets.dialogs.controller_comparison.comparison_run import run_comparison
from tactile_widgets.jobs.executor import InlineExecutor, Job, ProcessExecutor
from tactile_widgets.session.comparison_stimulus import ComparisonStimulus, read_stimulus
from tests.support.recordings import record

pytestmark = pytest.mark.long

CONTENDERS = (Contender("A", ControlSettings(controller="hybrid")), Contender("B", ControlSettings(controller="qp")))


def test_process_returns_the_traces_that_this_process_computes(prepared, qtbot):
    acts = ((0, ControlChanged(ControlSettings())), (2, PokePressed(1, prepared.skin.taxel_point(20))))
    stimulus = ComparisonStimulus(prepared, acts, 1.0)
    results = []
    shares = []
    for make in (InlineExecutor, ProcessExecutor):
        executor = make("test")
        executor.start(
            Job(run_comparison, stimulus, CONTENDERS, 0.3, True, died=""),
            results.append,
            progressed=lambda _text, share: shares.append(share),
        )
        qtbot.waitUntil(lambda executor=executor: not executor.busy, timeout=60_000)
        executor.close()
    assert shares[-1] == 1
    for here, there in zip(*results, strict=True):
        assert np.array_equal(here.force, there.force)
        assert np.array_equal(here.joint_speed, there.joint_speed)


def test_stimulus_of_a_recording_has_its_touches_and_duration(prepared, tmp_path):
    session = record(prepared, tmp_path / "half.mcap", ticks=100)
    stimulus = read_stimulus(tmp_path / "half.mcap", lambda *_progress: None)
    assert (stimulus.file, stimulus.touches) == ("half.mcap", 2), "the scripted touch and the manual one"
    assert stimulus.seconds == pytest.approx(session.frame.time)
