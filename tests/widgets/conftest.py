"""What every widget test stands on: a small real arm in its skin, and a look after each test for what it left."""

from __future__ import annotations

import gc
from collections import Counter
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import pytest
import shiboken6
from PySide6.QtCore import QCoreApplication, QEvent, QThread, QTimer
from PySide6.QtWidgets import QApplication
from vtkmodules.vtkRenderingCore import vtkRenderWindow

from tactile_maps.editing.document import MapDocument
from tactile_maps.maps.image_atlas import AtlasTile, ImageAtlas
from tactile_maps.maps.model.tactile_image import vertex_weights
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepare import PreparedScene, prepare
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.jobs.executor import InlineExecutor
from tactile_widgets.jobs.scene_jobs import SceneJobs
from tactile_widgets.session.backends import INLINE
from tactile_widgets.views.map import map_view
from tactile_widgets.views.robot.actors import skin_actors
from tests.widgets.support.samples import coarse
from tests.widgets.support.window_driver import begin_again, close_window, open_window, window_facts

TAXELS = 150


@pytest.fixture(scope="session")
def prepared() -> PreparedScene:
    """The arm we ship, in three patches with few taxels; seconds to make, so made once."""
    scene = load_scene("arm")
    prepared = prepare(replace(scene, cover=replace(scene.cover, taxels=TAXELS)))
    assert len(prepared.skin) == TAXELS
    return prepared


@pytest.fixture(scope="session")
def coarse_prepared() -> PreparedScene:
    """The same arm in a thick skin, of a tenth of the triangles: for what measures maps, or prepares them beside."""
    return prepare(coarse(TAXELS))


@pytest.fixture(scope="session", autouse=True)
def weights_made_once():
    """How touch is painted depends on nothing but the map and how it is done: 0.2 s of each window otherwise."""
    with pytest.MonkeyPatch.context() as patching:
        # Patches, charts and maps are what they are, not what is in them.
        patching.setattr(AtlasTile, "of", lru_cache(maxsize=32)(AtlasTile.of))
        patching.setattr(map_view, "ImageAtlas", lru_cache(maxsize=8)(ImageAtlas))
        patching.setattr(skin_actors, "vertex_weights", lru_cache(maxsize=8)(vertex_weights))
        yield


@pytest.fixture
def editor(prepared):
    """On the small arm's map, taking edits; what is computed is there at once."""
    made = MapEditor(SceneJobs(InlineExecutor("prepare")))
    made.open(MapDocument.of(prepared.map))
    made.set_enabled(enabled=True)
    return made


@pytest.fixture
def backends():
    """All of the window's work is done when a test asks for it; one that wants a process says so."""
    return INLINE


@pytest.fixture
def own_files(tmp_path, monkeypatch):
    """Recordings and copies of unsaved edits are written for this test alone."""
    _write_into(tmp_path, monkeypatch)


def _write_into(folder: Path, patching: pytest.MonkeyPatch) -> None:
    patching.setattr(
        "tactile_widgets.presenters.session.session_presenter.recordings_folder", lambda: folder / "recordings"
    )
    for presenter in ("recordings_presenter", "study_presenter"):
        patching.setattr(
            f"tactile_widgets.presenters.files.{presenter}.recordings_folder", lambda: folder / "recordings"
        )
    patching.setenv("XDG_DATA_HOME", str(folder / "data"))  # where the trash is
    patching.setattr(
        "tactile_widgets.presenters.maps.map_file_presenter.user_state_path", lambda *_args, **_kwargs: folder / "state"
    )


@pytest.fixture
def new_window(qtbot, prepared, backends, tmp_path, own_files):
    """The window on the small arm, made for this test."""
    made = open_window(tmp_path, backends)
    made.live.show_prepared(prepared)
    QApplication.processEvents()
    yield made
    close_window(made)


@pytest.fixture
def window(new_window):
    """The window on the small arm: made for each test, but where a module takes ``window_again`` instead."""
    return new_window


@pytest.fixture(scope="module")
def module_window(qapp, prepared, tmp_path_factory):
    """A window on the small arm for the tests of a module, and how it is at first."""
    folder = tmp_path_factory.mktemp("window")
    made = open_window(folder, INLINE)
    with pytest.MonkeyPatch.context() as patching:
        _write_into(folder, patching)
        made.live.show_prepared(prepared)
        QApplication.processEvents()
    held = [made]
    yield held, window_facts(made)
    held.clear()
    close_window(made)
    del made
    gc.unfreeze()
    _collect()  # or at the end of all tests its trees of triangles would be told as leaks


@pytest.fixture
def window_again(module_window, prepared, own_files):
    """The module's window on the small arm, as new: that spares half of what it takes to make one.

    For tests that change nothing else than ``begin_again`` undoes; it fails for what the test before left.
    """
    (made,), at_first = module_window
    begin_again(made, prepared, folded=at_first["folded"])
    assert window_facts(made) == at_first, "the test before left something in the window"
    yield made
    made.presenters.map_files.give_up()


@pytest.fixture(scope="module", autouse=True)
def collected_after():
    """What a module's fixtures leave is garbage again once they are gone."""
    yield
    gc.unfreeze()


@pytest.fixture(autouse=True)
def nothing_left(collected_after):
    """Fail a test that leaves a window, a running timer or thread, or a live render window behind.

    What lives before the test is frozen: afterwards only what the test made is collected and looked through (0.01 s;
    all of the process's objects, of several libraries, take 0.7 s).
    """
    _collect()
    gc.freeze()
    before = Counter(_describe(widget) for widget in QApplication.topLevelWidgets())
    yield
    _collect()
    left = Counter(_describe(widget) for widget in QApplication.topLevelWidgets()) - before + _running()
    assert not left, f"left behind: {dict(left)}"


def _collect() -> None:
    _flush_deferred_deletes()
    gc.collect()


def _running() -> Counter[str]:
    """What was made since the freeze and should not outlive a test, by kind."""
    alive: Counter[str] = Counter()
    for thing in gc.get_objects():
        kind = type(thing)
        if issubclass(kind, vtkRenderWindow):
            alive[kind.__name__] += 1
        elif issubclass(kind, QTimer) and shiboken6.isValid(thing) and thing.isActive():
            alive[f"running QTimer of {_describe(thing.parent())}"] += 1
        elif issubclass(kind, QThread) and shiboken6.isValid(thing) and thing.isRunning():
            alive["running QThread"] += 1
    return alive


def _flush_deferred_deletes() -> None:
    if QCoreApplication.instance() is not None:
        # Twice: what is deleted first may ask for its children's deletion.
        for _ in range(2):
            QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
            QCoreApplication.processEvents()


def _describe(thing: object) -> str:
    name = thing.objectName() if hasattr(thing, "objectName") else ""
    return f"{type(thing).__name__} {name}".strip()
