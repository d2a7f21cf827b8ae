"""Notes on a recording are stored next to it, marks made while recording inside it; its bytes never change."""

from __future__ import annotations

import pytest

from tactile_maps.core.errors import RecordingError
from tactile_maps.recording.encoding.annotations import (
    Annotations,
    LabelledEpisode,
    Mark,
    Outcome,
    annotations_file,
    load_annotations,
    save_annotations,
)
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import Recorder
from tactile_maps.session.session import Session

SAID = Annotations(
    marks=(Mark(60, "touch"), Mark(150, "release")),
    episodes=(LabelledEpisode(60, 150, "press", "press the arm gently", Outcome.SUCCESS),),
    label="first try",
    outcome=Outcome.FAILURE,
)


@pytest.fixture
def copy(recording, tmp_path):
    path = tmp_path / "copy.mcap"
    path.write_bytes(recording.read_bytes())
    return path


def test_notes_are_stored_next_to_the_recording_and_leave_its_bytes_unchanged(copy):
    before = copy.read_bytes()
    assert load_annotations(copy) is None
    save_annotations(copy, SAID)
    assert load_annotations(copy) == SAID
    assert annotations_file(copy).name == "copy.notes.json"
    assert RecordingPlayer(copy).annotations() == SAID
    assert copy.read_bytes() == before


@pytest.mark.long
def test_marks_set_while_recording_are_in_the_file(prepared, tmp_path):
    path = tmp_path / "marked.mcap"
    session = Session(prepared)
    with Recorder(prepared, path) as recorder:
        recorder.mark(Mark(0, "before"))
        for _ in range(5):
            recorder.write(session.tick(), session.inputs)
        recorder.mark(Mark(3, "now"))
    player = RecordingPlayer(path)
    assert player.annotations().marks == (Mark(0, "before"), Mark(3, "now"))
    assert player.complete
    save_annotations(path, Annotations())
    assert player.annotations().marks == (), "what is said later is what holds"


def test_damaged_file_is_named_with_a_remedy(copy):
    annotations_file(copy).write_text('{"marks": [{"tick": "late"}]}')
    with pytest.raises(RecordingError, match=r"copy\.notes\.json.*Delete the file"):
        load_annotations(copy)


@pytest.mark.long
def test_notes_of_a_replaced_recording_are_rejected(copy):
    began = RecordingPlayer(copy).began
    save_annotations(copy, SAID, of=began)
    assert RecordingPlayer(copy).annotations() == SAID
    save_annotations(copy, SAID, of=str(int(began) - 1))
    with pytest.raises(RecordingError, match="another recording"):
        RecordingPlayer(copy).annotations()


def test_each_tick_has_one_mark_and_each_range_one_episode():
    said = SAID.with_mark(Mark(60, "other")).with_episode(LabelledEpisode(60, 150, "push"))
    assert [mark.name for mark in said.marks] == ["other", "release"]
    assert [one.label for one in said.episodes] == ["push"]
    assert said.without_mark(Mark(60, "other")).without_episode(said.episodes[0]).marks == (Mark(150, "release"),)


def test_trimmed_part_contains_its_annotations():
    part = SAID.within(100, 150)
    assert part.marks == (Mark(150, "release"),)
    assert [(one.first, one.last) for one in part.episodes] == [(100, 150)]
    assert SAID.within(151, 200).episodes == ()


@pytest.mark.parametrize(
    "make", [lambda: LabelledEpisode(5, 4, "back"), lambda: Mark(1, "x" * 3000), lambda: Annotations(label="x" * 3000)]
)
def test_invalid_annotations_are_rejected(make):
    with pytest.raises(RecordingError):
        make()
