"""An unforeseen problem becomes a sentence and a file."""

from __future__ import annotations

from app.crash_log import explain, write_crash_log


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
    text = explain(_problem())
    assert "ZeroDivisionError" in text
    assert "crash" in text
    assert "\n" not in text


def test_a_folder_that_cannot_be_written_is_said(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "file"))
    assert "could not be written" in explain(_problem())
