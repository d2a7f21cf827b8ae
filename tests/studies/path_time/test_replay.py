"""Replay of the run of a row: equal to the measurement, and rejected for a row without a run."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tactile_maps.core.assets import asset
from tactile_maps.core.errors import UsageError
from tactile_maps.studies.path_time import force_feedback, replay, representation
from tactile_maps.studies.path_time.body_path import with_path_on_body
from tactile_maps.studies.path_time.conditions import setup_of
from tactile_maps.studies.path_time.path_time import conditions_of, settings_of
from tactile_maps.studies.path_time.replay import replay_row
from tactile_maps.studies.running.study_table import read_study_table
from tactile_maps.studies.testbeds.path_following import TrueContact, run_path


@cache
def _rows(study):
    return read_study_table(asset("findings", f"{study}.csv")).rows


def _row(study, **cells):
    """The first of our arm's rows with these cells."""
    own = (row for row in _rows(study) if row["robot"] == "arm")
    return next(row for row in own if all(str(row[k]) == v for k, v in cells.items()))


NOMINAL = _row("force-feedback")


@pytest.mark.parametrize("change", [{"robot": "nobody"}, {"factor": "delay", "level": "word"}])
def test_row_without_a_case_is_rejected(change):
    with pytest.raises(UsageError, match="does not belong to a case of this study"):
        replay_row(force_feedback.FACTORS, {**NOMINAL, **change})


MISPLACED = _row("representation", factor="taxels misplaced", level="2.0", jacobian="smoothed")
TUTTE = _row("representation", factor="map by geometry", level="tutte", jacobian="smoothed")
SADDLE = _row("representation", factor="body", level="saddle of 40 mm")


@pytest.mark.long
@pytest.mark.parametrize(
    ("study", "row"),
    [(force_feedback, NOMINAL), (representation, MISPLACED), (representation, TUTTE), (representation, SADDLE)],
    ids=["nominal", "taxels misplaced", "another map", "another body"],
)
def test_replay_of_a_row_has_the_error_of_the_run_that_the_study_measures(study, row):
    conditions = conditions_of(study.FACTORS, row)
    setup = setup_of("arm", conditions, row["seed"])
    settings = with_path_on_body(settings_of(conditions), setup)
    measured = run_path(setup, replace(settings, path_speed=1e-3 * row["speed_mm_s"]), row["seconds"])
    run = replay_row(study.FACTORS, row)
    prepared = run.session.prepared
    errors = []
    truth = TrueContact(prepared.robot, prepared.skin, run.session.map)

    def look(frame):
        if frame.task is not None and frame.task.target is not None and run.session.total_normal_force > 0:
            errors.append((frame.tick, truth.error(frame.task.target, frame.objects[0, :3, 3], frame.posture)))

    with run.session.watched(look):
        run.play()
    moving = [error for tick, error in errors if tick > min(run.inputs)]
    assert np.percentile(moving, 95) == pytest.approx(measured.error_p95, rel=0.02)


@pytest.mark.parametrize(
    ("factor", "level"), [("map learned", "information-distance"), ("map by geometry", "isomap")], ids=str
)
def test_map_between_taxels_is_rejected_before_any_work(monkeypatch, factor, level):
    monkeypatch.setattr(replay, "setup_of", lambda *_: pytest.fail("seconds for nothing"))
    with pytest.raises(UsageError, match="cannot be replayed.*Choose a row of another factor, or .*lscm") as found:
        replay_row(representation.FACTORS, {**NOMINAL, "factor": factor, "level": level})
    assert found.value.value == f"{factor} {level}"
