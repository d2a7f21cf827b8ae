"""The worker: a real process that prepares, is cancelled, replaced and killed, and never takes the window with it."""

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
from tactile_widgets.workers.scene_worker import OpenScene, SceneWorker
from tactile_widgets.workers.worker_process import SourceToken
from tests.support.recordings import record
from tests.widgets.support.samples import coarse

LONG = 60_000
HERE = SourceToken("here")


@pytest.fixture(scope="module")
def only_worker(qapp):
    """One for all: to start its process takes longer than most of what it is asked."""
    made = SceneWorker()
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


@pytest.fixture(scope="module")
def prepared(coarse_prepared):
    """It is sent to a process."""
    return coarse_prepared


@pytest.fixture
def document(prepared):
    """The small arm's map, to be edited."""
    return MapDocument.of(prepared.map)


@pytest.fixture
def scene():
    """Few taxels and triangles, so that preparing takes half a second."""
    return coarse(60)


def test_a_scene_comes_back_prepared(worker, scene, qtbot):
    stages = []
    worker.progressed.connect(lambda text, done: stages.append((text, done)))
    with qtbot.waitSignal(worker.prepared, timeout=LONG) as got:
        worker.prepare(scene)
        assert worker.busy
    assert len(got.args[0].skin) == 60
    assert not worker.busy
    assert len(stages) > 3
    assert [done for _, done in stages] == sorted(done for _, done in stages), "progress never goes back"


@pytest.mark.parametrize("look", [ImageSettings(), ImageSettings("nearest", 200)])
def test_its_live_image_comes_before_it_and_is_of_its_charts(worker, scene, qtbot, look):
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


def test_what_a_scene_file_names_is_checked_there_and_a_mistake_has_its_line(worker, scene, qtbot, tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(f"{scene_to_toml(scene)}\n[[motion]]\nposture = {{ elbow_ptch = 1 }}\n")
    with qtbot.waitSignal(worker.failed, timeout=LONG) as failure:
        worker.prepare(OpenScene(path))
        assert worker.busy
    assert "own.toml, line" in failure.args[0]
    assert "elbow_pitch" in failure.args[0]
    path.write_text(scene_to_toml(scene))
    with qtbot.waitSignal(worker.prepared, timeout=LONG) as got:
        worker.prepare(OpenScene(path))
    assert len(got.args[0].skin) == 60


def test_a_bad_scene_fails_with_its_own_words_and_the_next_one_works(worker, scene, qtbot):
    with qtbot.waitSignal(worker.failed, timeout=LONG) as failure:
        worker.prepare(replace(scene, robot="no-such-robot"))
    assert "no-such-robot" in failure.args[0]
    assert not worker.busy
    with qtbot.waitSignal(worker.prepared, timeout=LONG):
        worker.prepare(scene)


def test_the_newest_request_wins(worker, scene, qtbot):
    got = []
    worker.prepared.connect(got.append)
    worker.prepare(replace(scene, title="first"))
    worker.prepare(replace(scene, title="second"))
    qtbot.waitUntil(lambda: not worker.process.waiting, timeout=LONG)
    assert [prepared.scene.title for prepared in got] == ["second"]


def test_cancelling_drops_the_request_and_leaves_a_process_ready(worker, scene, qtbot):
    worker.prepare(scene)
    first = worker.process.pid
    worker.cancel()
    assert not worker.busy
    assert worker.process.pid is not None
    assert worker.process.pid != first
    with qtbot.assertNotEmitted(worker.failed, wait=200):
        assert not worker.busy


def test_a_process_that_died_at_rest_is_replaced(worker, scene, qtbot):
    worker.warm()
    os.kill(worker.process.pid, signal.SIGKILL)
    os.waitid(os.P_PID, worker.process.pid, os.WEXITED | os.WNOWAIT)
    with qtbot.waitSignal(worker.prepared, timeout=LONG):
        worker.prepare(scene)


def test_a_process_that_dies_at_work_is_told_and_replaced(worker, scene, qtbot):
    worker.prepare(scene)
    with qtbot.waitSignal(worker.failed, timeout=LONG) as failure:
        os.kill(worker.process.pid, signal.SIGKILL)
    assert "ended unexpectedly" in failure.args[0]
    assert not worker.busy
    with qtbot.waitSignal(worker.prepared, timeout=LONG):
        worker.prepare(scene)


def test_closing_ends_the_process_and_may_be_repeated(worker):
    worker.warm()
    assert mp.active_children()
    worker.close()
    worker.close()
    assert not mp.active_children()


def test_a_patch_is_laid_flat_anew_with_progress(worker, document, qtbot):
    told = []
    worker.edit_progressed.connect(lambda text, done: told.append((text, done)))
    with qtbot.waitSignal(worker.reflattened, timeout=LONG) as got:
        worker.reflatten(set_method(document, [0], "lscm"), HERE)
        assert worker.editing
        assert not worker.busy
    assert apply_result(document, got.args[0].value).charts[0].method == "lscm"
    assert not worker.editing
    assert told


def test_an_edit_that_is_refused_says_why(worker, document, qtbot):
    request = set_method(document, [0], "lscm")
    request = replace(
        request, jobs=(replace(request.jobs[0], wanted=replace(request.jobs[0].wanted, method="nosuch")),)
    )
    with qtbot.waitSignal(worker.edit_failed, timeout=LONG) as failure:
        worker.reflatten(request, HERE)
    assert "nosuch" in failure.args[0].value


def test_a_cancelled_edit_never_comes(worker, document, qtbot):
    got = []
    worker.reflattened.connect(got.append)
    worker.reflatten(set_method(document, [0], "lscm"), HERE)
    worker.cancel_edit()
    with qtbot.waitSignal(worker.reflattened, timeout=LONG):
        worker.reflatten(set_method(document, [1], "arap"), HERE)
    assert [result.value.request.jobs[0].number for result in got] == [1]


@pytest.fixture
def recording(prepared, tmp_path):
    """Half a second, with an edit."""
    record(prepared, tmp_path / "half.mcap", ticks=100)
    return tmp_path / "half.mcap"


def test_a_recording_comes_back_as_it_would_be_read_here(worker, recording, qtbot):
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


def test_a_bad_recording_fails_with_its_own_words(worker, tmp_path, qtbot):
    path = tmp_path / "bad.mcap"
    path.write_bytes(b"nothing of the sort")
    with qtbot.waitSignal(worker.failed, timeout=LONG) as failure:
        worker.open_recording(path)
    assert str(path) in failure.args[0]
    assert not worker.busy


def test_a_recording_takes_the_place_of_a_scene_and_of_an_edit_and_can_be_cancelled(
    worker, document, scene, recording, qtbot
):
    got = []
    for fact in (worker.prepared, worker.opened, worker.reflattened):
        fact.connect(got.append)
    worker.prepare(scene)
    worker.open_recording(recording)
    worker.cancel()
    assert not worker.busy
    worker.reflatten(set_method(document, [0], "lscm"), HERE)
    with qtbot.waitSignal(worker.edit_failed, timeout=LONG) as dropped:
        worker.open_recording(recording)
    assert "dropped" in dropped.args[0].value
    qtbot.waitUntil(lambda: not worker.process.waiting, timeout=LONG)
    assert len(got) == 1
    assert isinstance(got[0], RecordingPlayer)


def test_a_scene_goes_before_an_edit(worker, document, scene, qtbot):
    with qtbot.waitSignal(worker.edit_failed, timeout=LONG) as dropped:
        worker.reflatten(set_method(document, [0], "lscm"), HERE)
        worker.prepare(scene)
    assert dropped.args[0].value == ""
    with qtbot.waitSignal(worker.edit_failed, timeout=LONG) as refused:
        worker.reflatten(set_method(document, [0], "lscm"), HERE)
    assert "being opened" in refused.args[0].value
    with qtbot.waitSignal(worker.prepared, timeout=LONG):
        pass


def test_a_process_that_dies_at_an_edit_is_told(worker, document, qtbot):
    with qtbot.waitSignal(worker.edit_failed, timeout=LONG) as failure:
        worker.reflatten(set_method(document, [0], "slim"), HERE)
        os.kill(worker.process.pid, signal.SIGKILL)
    assert "the map before it is kept" in failure.args[0].value


def test_coarser_links_are_made_when_nothing_else_is_to_be_done(worker, prepared, document, qtbot):
    """An edit goes before them, and they come all the same."""
    order = []
    made = []
    worker.levels_made.connect(made.append)
    worker.levels_made.connect(lambda _levels: order.append("levels"))
    worker.reflattened.connect(lambda _result: order.append("edit"))
    with qtbot.waitSignals([worker.levels_made, worker.reflattened], timeout=LONG):
        worker.make_levels(prepared.robot)
        worker.make_levels(prepared.robot)  # that is asked for already
        worker.reflatten(set_method(document, [0], "lscm"), HERE)
    assert order == ["edit", "levels"]
    assert made[0].digest == links_digest(prepared.robot)


def test_links_whose_process_dies_are_drawn_as_they_are(worker, prepared, qtbot):
    worker.warm()
    qtbot.waitUntil(lambda: worker.process.ready, timeout=LONG)
    with qtbot.assertNotEmitted(worker.failed), qtbot.assertNotEmitted(worker.levels_made):
        worker.make_levels(prepared.robot)
        os.kill(worker.process.pid, signal.SIGKILL)
        qtbot.waitUntil(lambda: worker.process.pid is None, timeout=LONG)
