"""``study`` from the command line to files on disk."""

from __future__ import annotations

import json

import pytest

from app.__main__ import main
from app.cli.commands import study as study_command
from app.studies.catalogue import STUDY_NAMES

QUICKEST = ("image-cost",)
"""All of its cases in a second; the others take ten seconds to some minutes."""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in QUICKEST else pytest.mark.long) for name in STUDY_NAMES]
)
def test_a_quick_run_writes_table_and_page(name, tmp_path, capsys):
    assert main(["study", name, "--quick", "--json", "-o", str(tmp_path / "out")]) == 0
    told = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert told["name"] == name
    assert len(told["rows"]) > 10
    assert told["seconds"] > 0
    files = sorted((tmp_path / "out").iterdir())
    assert sorted(told["files"]) == [str(file) for file in files]
    assert [file.suffix for file in files] == [".csv", ".html", ".json"]
    assert all(file.stat().st_size > 1000 for file in files)


def test_an_unknown_name_is_bad_usage_and_lists_the_names(tmp_path, capsys):
    assert main(["study", "coffee-cost", "-o", str(tmp_path)]) == 2
    told = capsys.readouterr().err
    assert "coffee-cost" in told
    assert "map-cost or image-cost" in told


def test_jobs_below_zero_are_bad_usage(tmp_path, capsys):
    assert main(["study", "map-cost", "--jobs", "-1", "-o", str(tmp_path)]) == 2
    assert "--jobs" in capsys.readouterr().err


def test_ctrl_c_ends_it_with_nothing_written(tmp_path, capsys, monkeypatch):
    def interrupted(text, share):
        raise KeyboardInterrupt

    monkeypatch.setattr(study_command, "progress_line", lambda: interrupted)
    assert main(["study", "map-cost", "--quick", "-o", str(tmp_path / "out")]) == 130
    assert not (tmp_path / "out").exists()
    assert "interrupted" in capsys.readouterr().err
