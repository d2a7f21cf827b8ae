"""The worker: a real process that prepares, is cancelled, replaced and killed, and never takes the window with it."""

from __future__ import annotations

import multiprocessing as mp
from dataclasses import replace

import pytest

from app.simulation.scene_file import load_scene
from widgets.worker import Worker

LONG = 60_000


@pytest.fixture
def worker():
    """A worker whose process is gone after the test."""
    made = Worker()
    yield made
    made.close()
    made.deleteLater()
    assert not mp.active_children(), "a process outlived its test"


@pytest.fixture
def scene():
    """Few taxels, so that preparing takes a second or two."""
    scene = load_scene("arm")
    return replace(scene, cover=replace(scene.cover, taxels=60))


def test_a_scene_comes_back_prepared_and_then_measured(worker, scene, qtbot):
    stages, got = [], []
    worker.progressed.connect(lambda text, done: stages.append((text, done)))
    for signal in (worker.prepared, worker.measured):
        signal.connect(got.append)
    with qtbot.waitSignal(worker.measured, timeout=LONG):
        worker.prepare(scene)
        assert worker.busy
    prepared, quality = got
    assert len(prepared.skin) == 60
    assert quality.to_json()["taxels"] == 60
    assert not worker.busy
    assert len(stages) > 3
    assert [done for _, done in stages] == sorted(done for _, done in stages), "progress never goes back"


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
    with qtbot.waitSignal(worker.measured, timeout=LONG):
        pass
    assert [prepared.scene.title for prepared in got] == ["second"]


def test_cancelling_drops_the_request_and_leaves_a_process_ready(worker, scene, qtbot):
    worker.prepare(scene)
    first = worker._process.pid
    worker.cancel()
    assert not worker.busy
    assert worker._process.is_alive()
    assert worker._process.pid != first
    with qtbot.assertNotEmitted(worker.failed, wait=200):
        assert not worker.busy


def test_a_process_that_died_at_rest_is_replaced(worker, scene, qtbot):
    worker.warm()
    worker._process.kill()
    worker._process.join()
    with qtbot.waitSignal(worker.prepared, timeout=LONG):
        worker.prepare(scene)


def test_a_process_that_dies_at_work_is_told_and_replaced(worker, scene, qtbot):
    worker.prepare(scene)
    with qtbot.waitSignal(worker.failed, timeout=LONG) as failure:
        worker._process.kill()
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
