"""The run behind a row: as the study measured it, and refused where there is none."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import UsageError
from app.studies.path_time import force_feedback
from app.studies.path_time.replay import replay_row
from app.studies.running.study_table import read_study_table
from app.studies.testbeds.path_following import TrueContact
from assets import asset

NOMINAL = read_study_table(asset("findings", "force-feedback.csv")).rows[0]


@pytest.mark.parametrize("change", [{"robot": "nobody"}, {"factor": "delay", "level": "word"}])
def test_a_row_of_no_case_is_refused(change):
    with pytest.raises(UsageError, match="of no case of this study"):
        replay_row(force_feedback.FACTORS, {**NOMINAL, **change})


@pytest.mark.long
def test_the_run_has_the_error_that_the_row_tells():
    replay = replay_row(force_feedback.FACTORS, NOMINAL)
    prepared, errors = replay.session.prepared, []
    truth = TrueContact(prepared.robot, prepared.skin, prepared.map)

    def look(frame):
        if frame.task is not None and frame.task.target is not None and replay.session.total_normal_force > 0:
            errors.append((frame.tick, truth.error(frame.task.target, frame.objects[0, :3, 3], frame.posture)))

    with replay.session.watched(look):
        replay.play()
    moving = [error for tick, error in errors if tick > min(replay.inputs)]
    assert 1e3 * np.percentile(moving, 95) == pytest.approx(NOMINAL["error_mm"], rel=0.02)


@pytest.mark.long
def test_another_map_that_is_believed_is_refused():
    from app.studies.path_time import representation

    factor = next(factor for factor in representation.FACTORS if factor.name == "taxels misplaced")
    with pytest.raises(UsageError, match="believes another map"):
        replay_row(representation.FACTORS, {**NOMINAL, "factor": factor.name, "level": factor.levels[0]})
