"""The log of cases: what is written is read back whatever ended the program, and nothing is thrown away unasked."""

from __future__ import annotations

import math
from contextlib import closing
from functools import partial

import pytest

from tactile_maps.core.errors import ExportError, UsageError
from tactile_maps.studies.running.case_log import CaseLog, case_key

ROWS = [{"a": 0.1 + 0.2, "b": math.inf, "c": None, "d": "ä"}]


def measure(case):
    return []


def other(case):
    return []


@pytest.fixture
def log_file(tmp_path):
    path = tmp_path / "deep" / "x.cases.jsonl"
    with closing(CaseLog(path)) as log:
        log.keep("one", ROWS)
        log.keep("two", [])
    return path


def resumed(path):
    with closing(CaseLog(path, resume=True)) as log:
        return log.done, log.torn


def test_stored_rows_are_read_bit_for_bit(log_file):
    assert resumed(log_file) == ({"one": ROWS, "two": []}, 0)


def test_truncated_logs_keep_their_complete_lines(log_file):
    data = log_file.read_bytes()
    first = data.index(b"\n") + 1
    for size in (*range(0, len(data), 7), first - 1, first, len(data) - 1):
        log_file.write_bytes(data[:size])
        kept = (["one"] if size >= first else []) + (["two"] if size == len(data) else [])
        assert list(resumed(log_file)[0]) == kept
        with closing(CaseLog(log_file, resume=True)) as log:
            log.keep("three", ROWS)
        assert list(resumed(log_file)[0]) == [*kept, "three"]


def test_damaged_line_loses_only_its_own_case(log_file):
    data = log_file.read_bytes()
    log_file.write_bytes(b"\0" * 20 + data[20:])
    assert resumed(log_file) == ({"two": []}, 1)


def test_interrupted_runs_are_deleted_only_on_request(log_file):
    before = log_file.read_bytes()
    with pytest.raises(UsageError, match=r"an interrupted run .found: 2 cases.*--resume.*--overwrite"):
        CaseLog(log_file)
    assert log_file.read_bytes() == before
    with closing(CaseLog(log_file, overwrite=True)) as log:
        assert log.done == {}
    assert log_file.read_bytes() == b""


def test_finished_run_is_continued_or_replaced_only_on_request(log_file):
    with closing(CaseLog(log_file, resume=True)) as log:
        log.end()
    with pytest.raises(UsageError, match=r"a finished run .found: 2 cases.*--resume.*--overwrite"):
        CaseLog(log_file)
    assert list(resumed(log_file)[0]) == ["one", "two"]
    with closing(CaseLog(log_file, overwrite=True)) as log:
        assert log.done == {}


def test_second_run_with_the_same_log_is_rejected(log_file):
    with closing(CaseLog(log_file, resume=True)), pytest.raises(UsageError, match="another run writes here"):
        CaseLog(log_file, resume=True)
    assert len(resumed(log_file)[0]) == 2


def test_unwritable_log_is_named(tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(ExportError, match="the folder cannot be created"):
        CaseLog(tmp_path / "taken" / "x.jsonl")


def test_cases_are_identified_by_settings_study_and_code():
    key = case_key("study", measure, {"a": 1, "b": 2.0})
    assert key == case_key("study", measure, {"b": 2.0, "a": 1})
    assert key != case_key("study", measure, {"a": 1, "b": 2.5})
    assert key == case_key("study", partial(measure), {"a": 1, "b": 2.0})
    assert key != case_key("another", measure, {"a": 1, "b": 2.0})
    with pytest.raises(UsageError, match="only numbers and words"):
        case_key("study", measure, {"a": object()})
