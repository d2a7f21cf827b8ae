"""Jobs of scenes in a process: opened, edited, replaced, cancelled and killed."""

from __future__ import annotations

import multiprocessing as mp
import os
import signal
from dataclasses import replace

import pytest

from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.reflatten import apply_result, set_method
from tactile_maps.maps.image_atlas import ImageSettings
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.verify import verify
from tactile_maps.scene.scene_file import scene_to_toml
from tactile_maps.session.link_levels import links_digest
from tactile_widgets.jobs.executor import ProcessExecutor
from tactile_widgets.jobs.scene_jobs import SceneFile, SceneJobs
from tests.support.recordings import record
from tests.widgets.support.samples import coarse

LONG = 60_000


@pytest.fixture(scope="module")
def only_worker(qapp, scene_cache):
    """Shared worker, because the start of its process takes longer than most jobs."""
    made = SceneJobs(ProcessExecutor("prepare"))
    yield made
    made.close()
    made.deleteLater()
    assert not mp.active_children(), "a process outlived its tests"


@pytest.fixture
def worker(only_worker):
    """The worker, with nothing to do before and after each test, and one process at most."""
    yield only_worker
    assert not only_worker.busy
    assert not only_worker.editing
    assert len(mp.active_children()) <= 1, "a process was replaced but not ended"


@pytest.fixture
def document(prepared):
    """The small arm's map, to be edited."""
    return MapDocument.of(prepared.map)


@pytest.fixture
def scene():
    """Few taxels and triangles, so that preparing takes half a second."""
    return coarse(60)


def test_scene_is_prepared(worker, scene, qtbot):
    stages = []
    worker.progressed.connect(lambda text, done: stages.append((text, done)))
    with qtbot.waitSignal(worker.prepared, timeout=LONG) as got:
        worker.prepare(scene)
        assert worker.busy
    assert len(got.args[0].skin) == 60
    assert not worker.busy
    assert len(stages) > 3
    assert [done for _, done in stages] == sorted(done for _, done in stages), "progress never goes back"


@pytest.mark.parametrize("look", [pytest.param(ImageSettings(), marks=pytest.mark.long), ImageSettings("nearest", 200)])
def test_tactile_image_precedes_the_scene_and_shows_its_charts(worker, scene, qtbot, look):
    came = []
    worker.image_made.connect(came.append)
    worker.image = look
    with qtbot.waitSignal(worker.prepared, timeout=LONG) as got:
        worker.prepare(scene)
    worker.image = ImageSettings()
    worker.image_made.disconnect(came.append)
    (image,) = came
    assert image.look == look
    assert image.skin is got.args[0].skin
    assert all(tile.chart is chart for tile, chart in zip(image.tiles, got.args[0].map.charts, strict=True))


def test_references_of_a_scene_file_are_checked_with_line_numbers(worker, scene, qtbot, tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(f"{scene_to_toml(scene)}\n[[motion]]\nposture = {{ elbow_ptch = 1 }}\n")
    with qtbot.waitSignal(worker.failed, timeout=LONG) as failure:
        worker.prepare(SceneFile(path))
        assert worker.busy
    assert "own.toml, line" in failure.args[0]
    assert "elbow_pitch" in failure.args[0]
    path.write_text(f"{scene_to_toml(scene)}\n[[stimuli]]\nkind = 'poke'\npatch = 'nose'\n")
    with qtbot.waitSignal(worker.failed, timeout=LONG) as failure:
        worker.prepare(SceneFile(path))
    line = path.read_text().splitlines().index("patch = 'nose'") + 1
    assert f"own.toml, line {line}, stimuli.patch: unknown patch (found: nose)" in failure.args[0]
    path.write_text(scene_to_toml(scene))
    with qtbot.waitSignal(worker.prepared, timeout=LONG) as got:
        worker.prepare(SceneFile(path))
    assert len(got.args[0].skin) == 60


def test_invalid_scene_fails_with_its_message_and_the_next_one_opens(worker, scene, qtbot):
    with qtbot.waitSignal(worker.failed, timeout=LONG) as failure:
        worker.prepare(replace(scene, robot="no-such-robot"))
    assert "no-such-robot" in failure.args[0]
    assert not worker.busy
    with qtbot.waitSignal(worker.prepared, timeout=LONG):
        worker.prepare(scene)


@pytest.mark.long
def test_newest_request_replaces_others(worker, scene, qtbot):
    got = []
    worker.prepared.connect(got.append)
    worker.prepare(replace(scene, title="first"))
    worker.prepare(replace(scene, title="second"))
    qtbot.waitUntil(lambda: not worker.executor.busy, timeout=LONG)
    assert [prepared.scene.title for prepared in got] == ["second"]


@pytest.mark.long
def test_cancelling_drops_the_request_and_prepares_a_process(worker, scene, qtbot):
    worker.prepare(scene)
    first = worker.executor.pid
    worker.cancel()
    assert not worker.busy
    assert worker.executor.pid is not None
    assert worker.executor.pid != first
    with qtbot.assertNotEmitted(worker.failed, wait=200):
        assert not worker.busy


@pytest.mark.long
def test_death_of_the_process_is_reported_and_it_is_replaced(worker, scene, qtbot):
    worker.prepare(scene)
    with qtbot.waitSignal(worker.failed, timeout=LONG) as failure:
        os.kill(worker.executor.pid, signal.SIGKILL)
    assert "ended unexpectedly" in failure.args[0]
    assert not worker.busy
    with qtbot.waitSignal(worker.prepared, timeout=LONG):
        worker.prepare(scene)


class Edits(list):
    """Everything that was reported of edits, as (kind, value)."""

    def start(self, worker, request):
        worker.reflatten(
            request,
            lambda result: self.append(("finished", result)),
            lambda text: self.append(("failed", text)),
            lambda text, share: self.append(("progressed", (text, share))),
        )

    def ends(self):
        """Return what ended edits."""
        return [entry for entry in self if entry[0] != "progressed"]


@pytest.fixture
def edits():
    return Edits()


def test_patch_is_flattened_with_progress(worker, document, edits, qtbot):
    edits.start(worker, set_method(document, [0], "lscm"))
    assert worker.editing
    assert not worker.busy
    qtbot.waitUntil(lambda: not worker.editing, timeout=LONG)
    assert edits[0][0] == "progressed"
    ((kind, result),) = edits.ends()
    assert kind == "finished"
    assert apply_result(document, result).charts[0].method == "lscm"


def test_rejected_edit_reports_the_reason(worker, document, edits, qtbot):
    request = set_method(document, [0], "lscm")
    request = replace(request, jobs=(replace(request.jobs[0], edit=replace(request.jobs[0].edit, method="nosuch")),))
    edits.start(worker, request)
    qtbot.waitUntil(lambda: not worker.editing, timeout=LONG)
    ((kind, text),) = edits.ends()
    assert kind == "failed"
    assert "nosuch" in text


@pytest.mark.long
def test_cancelled_edit_reports_nothing(worker, document, edits, qtbot):
    edits.start(worker, set_method(document, [0], "lscm"))
    worker.cancel_edit()
    edits.start(worker, set_method(document, [1], "arap"))
    qtbot.waitUntil(lambda: not worker.editing, timeout=LONG)
    assert [result.request.jobs[0].number for _, result in edits.ends()] == [1]


@pytest.fixture
def recording(prepared, tmp_path):
    """Half a second, with an edit."""
    record(prepared, tmp_path / "half.mcap", ticks=100)
    return tmp_path / "half.mcap"


@pytest.mark.long
def test_recording_is_read_as_in_this_process(worker, recording, qtbot):
    stages = []
    worker.progressed.connect(lambda text, done: stages.append((text, done)))
    with qtbot.waitSignal(worker.opened, timeout=LONG) as got:
        worker.open_recording(recording)
        assert worker.busy
    (there,), here = got.args, RecordingPlayer(recording)
    assert not worker.busy
    assert stages[0] == ("Reading the recording", 0.0)
    assert len(there) == len(here) == 100
    assert verify(there).identical
    assert (there.frame(99).pressures == here.frame(99).pressures).all()
    arrays = (there.times, there.prepared.skin.areas, there.runtime_settings_at(99).map.charts[0].plane)
    assert not any(array.flags.writeable for array in arrays)


def test_damaged_recording_fails_with_its_message(worker, tmp_path, qtbot):
    path = tmp_path / "bad.mcap"
    path.write_bytes(b"nothing of the sort")
    with qtbot.waitSignal(worker.failed, timeout=LONG) as failure:
        worker.open_recording(path)
    assert str(path) in failure.args[0]
    assert not worker.busy


@pytest.mark.long
def test_recording_replaces_a_scene_and_an_edit_and_can_be_cancelled(worker, document, scene, recording, edits, qtbot):
    got = []
    for fact in (worker.prepared, worker.opened):
        fact.connect(got.append)
    worker.prepare(scene)
    worker.open_recording(recording)
    worker.cancel()
    assert not worker.busy
    edits.start(worker, set_method(document, [0], "lscm"))
    worker.open_recording(recording)
    assert "dropped" in edits.ends()[0][1]
    qtbot.waitUntil(lambda: not worker.executor.busy, timeout=LONG)
    assert len(got) == 1
    assert isinstance(got[0], RecordingPlayer)


@pytest.mark.long
def test_scene_replaces_an_edit_and_rejects_another(worker, document, scene, edits, qtbot):
    edits.start(worker, set_method(document, [0], "lscm"))
    worker.prepare(scene)
    assert edits.ends() == [("failed", "")]
    edits.start(worker, set_method(document, [0], "lscm"))
    assert "being opened" in edits[-1][1]
    with qtbot.waitSignal(worker.prepared, timeout=LONG):
        pass


@pytest.mark.long
def test_death_of_the_process_fails_an_edit(worker, document, edits, qtbot):
    edits.start(worker, set_method(document, [0], "slim"))
    os.kill(worker.executor.pid, signal.SIGKILL)
    qtbot.waitUntil(lambda: not worker.editing, timeout=LONG)
    assert "the map before it is kept" in edits[-1][1]


@pytest.mark.long
def test_coarser_links_are_made_after_all_other_jobs(worker, prepared, document, edits, qtbot):
    """An edit goes before them, and they come all the same."""
    order = []
    made = []
    worker.levels_made.connect(made.append)
    worker.levels_made.connect(lambda _levels: order.append("levels"))
    with qtbot.waitSignal(worker.levels_made, timeout=LONG):
        worker.make_levels(prepared.robot)
        worker.make_levels(prepared.robot)  # already requested
        edits.start(worker, set_method(document, [0], "lscm"))
        assert not order
    assert [kind for kind, _ in edits.ends()] == ["finished"]
    assert made[0].digest == links_digest(prepared.robot)


@pytest.mark.long
def test_full_links_are_drawn_if_the_process_dies(worker, prepared, qtbot):
    worker.warm()
    qtbot.waitUntil(lambda: worker.executor.ready, timeout=LONG)
    with qtbot.assertNotEmitted(worker.failed), qtbot.assertNotEmitted(worker.levels_made):
        worker.make_levels(prepared.robot)
        os.kill(worker.executor.pid, signal.SIGKILL)
        qtbot.waitUntil(lambda: worker.executor.pid is None, timeout=LONG)
