"""Errors say what a person can do; an unforeseen problem becomes a sentence and a file."""

from __future__ import annotations

import pickle

import pytest

from app.core.errors import (
    MeshError,
    RobotError,
    TactileMapsError,
    UsageError,
    describe_unexpected_error,
    write_crash_log,
)


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (MeshError("it is broken"), "it is broken."),
        (MeshError("it is broken", file="a.obj"), "a.obj: it is broken."),
        (
            RobotError("it is broken", file="a.obj", place="face 3", value=7, remedy="Mend it"),
            "a.obj, face 3: it is broken (found: 7). Mend it.",
        ),
        (UsageError("no", value=0), "no (found: 0)."),
    ],
)
def test_the_message_is_one_sentence_a_person_can_act_on(error, text):
    assert str(error) == text


def test_a_huge_value_is_shortened():
    assert len(str(TactileMapsError("no", value="x" * 10_000))) < 200
    assert "\n" not in str(TactileMapsError("no", value="a\nb"))


def test_an_error_crosses_processes_whole():
    error = RobotError("it is broken", file="a.xml", place="line 1", value=[1], remedy="Mend it")
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is RobotError
    assert str(copy) == str(error)
    assert (copy.problem, copy.file, copy.place, copy.remedy) == ("it is broken", "a.xml", "line 1", "Mend it")


def _problem() -> ZeroDivisionError:
    try:
        return 1 // 0
    except ZeroDivisionError as error:
        return error


def test_the_details_are_kept(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    path = write_crash_log(_problem())
    assert tmp_path in path.parents
    assert "_problem" in path.read_text()


def test_a_person_is_told_a_sentence(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    text = describe_unexpected_error(_problem())
    assert "ZeroDivisionError" in text
    assert "crash" in text
    assert "\n" not in text


def test_a_folder_that_cannot_be_written_is_said(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "file"))
    assert "could not be written" in describe_unexpected_error(_problem())
