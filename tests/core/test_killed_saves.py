"""A program that ends before any system call of a save leaves the old file or the new one, never a part of one.

The system's own rule makes two system calls the only instants that differ: see ``tests.support.kill_at_system_calls``.
The saves run in a process of one thread, since a fork keeps no other.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import pytest

from tactile_maps.core.errors import Finding, RecordingError
from tactile_maps.core.files import claim_folder, claim_folders_with
from tactile_maps.editing.arrange import move
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.document_file import save_document
from tactile_maps.recording.encoding.frame_codec import encode_frame
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import Recorder
from tactile_maps.recording.recover import recover
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.session import Session
from tactile_maps.skin.model.skin_file import save_skin
from tactile_maps.stimuli.stimulus_file import save_stimuli
from tactile_maps.studies.study.report import StudyResult, write_report
from tactile_maps.studies.study.study import Study
from tests.support.child_process import Child
from tests.support.kill_at_system_calls import can_trace, killed_at_each_system_call
from tests.support.touch import prepared_bar

FRAMES = 40
SECONDS = 300.0


@cache
def bar() -> PreparedScene:
    return prepared_bar()


@cache
def frames() -> tuple[Frame, ...]:
    session = Session(bar())
    return tuple(session.tick() for _ in range(FRAMES))


def save_map(path: Path, *, moved: bool) -> None:
    document = MapDocument.of(bar().map)
    save_document(move(document, [0], (0.2, 0.1)) if moved else document, path)


def save_report(path: Path, *, moved: bool) -> None:
    study = Study(path.stem, "What?", "By trying.", lambda quick, seed: [], lambda case: [], lambda rows: [])
    write_report(StudyResult(study, [{"error": float(moved)}], {}, 1.0, 1, 1, True), path.parent)


def save_touches(path: Path, *, moved: bool) -> None:
    save_stimuli(load_scene("arm").stimuli if moved else (), path)


def save_bar(path: Path, *, moved: bool) -> None:
    findings = (Finding("moved", "bar", "for the test"),) if moved else ()
    save_skin(replace(bar().skin, findings=findings), path)


SAVES: dict[str, Callable[..., None]] = {
    "map.npz": save_map,
    "skin.npz": save_bar,
    "study.csv": save_report,
    "touches.toml": save_touches,
}


def old_or_new(folder: Path, name: str, every: int) -> int:
    """Return the number of kills, one before each ``every``-th system call of a save; the file is complete."""
    path = folder / name
    save = SAVES[name]
    save(path, moved=True)
    new = path.read_bytes()
    save(path, moved=False)
    old = path.read_bytes()
    assert old != new
    seen: list[bytes] = []
    others = set(os.listdir(folder))
    for _ in killed_at_each_system_call(partial(save, path, moved=True), every=every):
        seen.append(path.read_bytes())
        left = set(os.listdir(folder)) - others
        assert all(one.startswith(".tactile-maps-") and one.endswith(".part") for one in left), left
        save(path, moved=False)
    assert set(seen) == {old, new}
    return len(seen)


def record_all(path: Path) -> None:
    with Recorder(bar(), path) as recorder:
        for frame in frames():
            recorder.write(frame, [])


def recorded_so_far(folder: Path, every: int) -> list[tuple[int, int]]:
    """After each kill while recording: the bytes on the disk, and the frames that are read back."""
    path = folder / "a.mcap"
    fixed = folder / "fixed.mcap"
    kept = []
    record_all(path)
    whole = RecordingPlayer(path)
    expected = [encode_frame(whole.frame(at)) for at in range(FRAMES)]
    path.unlink()
    for _ in killed_at_each_system_call(partial(record_all, path), every=every):
        size = path.stat().st_size if path.exists() else 0
        try:
            recover(path, fixed, overwrite=True)
        except RecordingError:
            kept.append((size, 0))  # not even the robot is on the disk yet, or nothing but it
        else:
            player = RecordingPlayer(fixed)
            kept.append((size, len(player)))
            assert [encode_frame(player.frame(at)) for at in range(len(player))] == expected[: len(player)]
        path.unlink(missing_ok=True)
    return kept


def recovered(folder: Path, every: int) -> list[bool]:
    """Return for each kill during recovery whether the recovered file exists; it must be complete."""
    path = folder / "a.mcap"
    fixed = folder / "fixed.mcap"
    there = []
    record_all(path)
    source = path.read_bytes()
    for _ in killed_at_each_system_call(partial(recover, path, fixed), every=every):
        there.append(fixed.exists())
        if fixed.exists():
            assert RecordingPlayer(fixed).complete
            assert len(RecordingPlayer(fixed)) == FRAMES
            fixed.unlink()
        assert path.read_bytes() == source
    return there


def claimed(folder: Path) -> int:
    """Return the number of system calls for claiming a folder; a process killed in between blocks no other."""
    (folder / "1").mkdir()
    (folder / "1" / "copy").write_bytes(b"unsaved")
    tried = 0
    for _ in killed_at_each_system_call(partial(claim_folder, folder, without="copy")):
        tried += 1
        claim = claim_folder(folder, without="copy")
        assert claim.folder == folder / "2"
        (left,) = claim_folders_with(folder, "copy")
        assert (left.folder / "copy").read_bytes() == b"unsaved"
        claim.release()
        left.release()
    return tried


@pytest.fixture(scope="module")
def child() -> Iterator[Child]:
    process = Child()
    if not process.call(can_trace, seconds=SECONDS):
        pytest.skip("this system does not let a process follow its child's system calls")
    yield process
    process.close()


@pytest.mark.parametrize(
    ("name", "every"),
    [
        ("map.npz", 1),
        ("touches.toml", 1),
        ("study.csv", 4),
        pytest.param("skin.npz", 1, marks=pytest.mark.long),
        pytest.param("study.csv", 1, marks=pytest.mark.long),
    ],
)
def test_killed_save_leaves_the_old_file_or_the_new_one(child, tmp_path, name, every):
    assert child.call(old_or_new, tmp_path, name, every, seconds=SECONDS) >= 8


@pytest.mark.parametrize("every", [61, pytest.param(1, marks=pytest.mark.long)])
def test_killed_recording_keeps_all_but_the_last_chunk(child, tmp_path, every):
    kept = [frames for _, frames in sorted(child.call(recorded_so_far, tmp_path, every, seconds=SECONDS))]
    assert kept == sorted(kept), "the more is on the disk the more is read back"
    assert kept[0] == 0
    assert kept[-1] >= FRAMES - 20, "at most a chunk is lost"


@pytest.mark.long
@pytest.mark.parametrize("every", [23, pytest.param(1, marks=pytest.mark.long)])
def test_killed_recovery_leaves_a_complete_file_or_no_file(child, tmp_path, every):
    there = child.call(recovered, tmp_path, every, seconds=SECONDS)
    assert not there[0]
    assert there[-1] or every > 1


@pytest.mark.long
def test_killed_process_releases_its_autosave_folder(child, tmp_path):
    assert child.call(claimed, tmp_path, seconds=SECONDS) >= 4
