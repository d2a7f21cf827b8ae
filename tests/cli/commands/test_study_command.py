"""``study`` from the command line to files on disk."""

from __future__ import annotations

import json
import time

import pytest

from tactile_maps.cli.commands import study as study_command
from tactile_maps.studies.catalogue import STUDY_NAMES, load_study
from tactile_widgets.__main__ import main

QUICKEST = ("image-cost",)
"""All of its cases in a second; the others take ten seconds to some minutes."""


@pytest.mark.long
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in QUICKEST else pytest.mark.long) for name in STUDY_NAMES]
)
def test_quick_run_writes_table_and_page(name, tmp_path, capsys):
    assert main(["study", name, "--quick", "--json", "-o", str(tmp_path / "out")]) == 0
    found = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert found["name"] == name
    assert len(found["rows"]) >= len(load_study(name).cases(True, 0)) > 1
    assert found["seconds"] > 0
    files = sorted((tmp_path / "out").iterdir())
    assert [file.suffix for file in files] == [".jsonl", ".csv", ".html", ".json", ".parquet"]
    assert sorted(found["files"]) == [str(file) for file in files[1:]]
    assert all(file.stat().st_size > 200 for file in files)


def test_unknown_study_is_a_usage_error_that_lists_the_names(tmp_path, capsys):
    assert main(["study", "coffee-cost", "-o", str(tmp_path)]) == 2
    found = capsys.readouterr().err
    assert "coffee-cost" in found
    assert "map-cost or image-cost" in found


def test_negative_number_of_jobs_is_a_usage_error(tmp_path, capsys):
    assert main(["study", "map-cost", "--jobs", "-1", "-o", str(tmp_path)]) == 2
    assert "--jobs" in capsys.readouterr().err


def interrupted_after(count):
    found = []

    def progress(text, share):
        found.append(text)
        if len(found) == count:
            raise KeyboardInterrupt

    return lambda: progress


@pytest.mark.long
def test_ctrl_c_keeps_finished_cases_for_resume(tmp_path, capsys, monkeypatch):
    words = ["study", "image-cost", "--quick", "--json", "-o", str(tmp_path)]
    monkeypatch.setattr(study_command, "progress_line", interrupted_after(2))
    assert main(words) == 130
    assert "2 of 12 cases are kept; continue with the same command and --resume" in capsys.readouterr().err
    assert sorted(file.suffix for file in tmp_path.iterdir()) == [".html", ".jsonl"]
    assert main(words) == 2
    assert "--overwrite replaces it" in capsys.readouterr().err
    monkeypatch.setattr(study_command, "progress_line", lambda: lambda text, share: None)
    assert main([*words, "--resume"]) == 0
    resumed = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert (resumed["cases"], resumed["known"]) == (12, 2)
    assert len(resumed["rows"]) >= 12


@pytest.mark.long
def test_expired_budget_ends_the_study_with_a_partial_table(tmp_path, capsys, monkeypatch):
    words = ["study", "image-cost", "--quick", "--json", "-o", str(tmp_path)]
    clock = time.monotonic
    later = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: clock() + later[0])
    monkeypatch.setattr(study_command, "progress_line", lambda: lambda text, share: later.__setitem__(0, 3600.0))
    assert main([*words, "--budget", "30min"]) == 0
    found = json.loads(capsys.readouterr().out.splitlines()[-1])
    [undecided] = found["undecided"]
    assert undecided == "The time is over, and 11 of 12 cases are missing: 0 of 1 seeds are complete."
    assert found["rows"]
    assert undecided in (tmp_path / "image-cost.html").read_text(encoding="utf8")
    assert main([*words, "--budget", "soon"]) == 2
    assert "must be a time such as 90s, 30min or 2h: soon" in capsys.readouterr().err


def test_budget_that_ends_before_the_first_case_is_reported(tmp_path, capsys):
    words = ["study", "image-cost", "--quick", "--json", "-o", str(tmp_path)]
    assert main([*words, "--budget", "0.0000001s"]) == 1
    printed = capsys.readouterr()
    assert json.loads(printed.out.splitlines()[-1])["rows"] == []
    assert "the budget ended before the first case" in printed.err
