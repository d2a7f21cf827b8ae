"""The run behind a row: as the study measured it, and refused where there is none."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import UsageError
from app.studies.path_time import force_feedback, representation
from app.studies.path_time.replay import replay_row
from app.studies.running.study_table import read_study_table
from app.studies.testbeds.path_following import TrueContact
from assets import asset


def _row(study, **cells):
    """The first of our arm's rows with these cells."""
    rows = read_study_table(asset("findings", f"{study}.csv")).rows
    return next(row for row in rows if row["robot"] == "arm" and all(str(row[k]) == v for k, v in cells.items()))


NOMINAL = _row("force-feedback")


@pytest.mark.parametrize("change", [{"robot": "nobody"}, {"factor": "delay", "level": "word"}])
def test_a_row_of_no_case_is_refused(change):
    with pytest.raises(UsageError, match="of no case of this study"):
        replay_row(force_feedback.FACTORS, {**NOMINAL, **change})


MISPLACED = _row("representation", factor="taxels misplaced", level="2.0", jacobian="smoothed")
TUTTE = _row("representation", factor="map by geometry", level="tutte", jacobian="smoothed")


@pytest.mark.long
@pytest.mark.parametrize(
    ("study", "row"), [(force_feedback, NOMINAL), (representation, MISPLACED), (representation, TUTTE)],
    ids=["nominal", "taxels misplaced", "another map"],
)  # fmt: skip
def test_the_run_has_the_error_that_the_row_tells(study, row):
    replay = replay_row(study.FACTORS, row)
    prepared, errors = replay.session.prepared, []
    truth = TrueContact(prepared.robot, prepared.skin, replay.session.map)

    def look(frame):
        if frame.task is not None and frame.task.target is not None and replay.session.total_normal_force > 0:
            errors.append((frame.tick, truth.error(frame.task.target, frame.objects[0, :3, 3], frame.posture)))

    with replay.session.watched(look):
        replay.play()
    moving = [error for tick, error in errors if tick > min(replay.inputs)]
    assert 1e3 * np.percentile(moving, 95) == pytest.approx(row["error_mm"], rel=0.02)


@pytest.mark.long
def test_a_learned_map_is_refused():
    with pytest.raises(UsageError, match="has triangles of its own"):
        replay_row(representation.FACTORS, {**NOMINAL, "factor": "map learned", "level": "information-distance"})
