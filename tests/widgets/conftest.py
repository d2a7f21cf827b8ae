"""What every widget test stands on: a small real arm in its skin, and a look after each test for what it left."""

from __future__ import annotations

import gc
from collections import Counter
from dataclasses import replace
from functools import lru_cache

import pytest
import shiboken6
from PySide6.QtCore import QCoreApplication, QEvent, QThread, QTimer
from PySide6.QtWidgets import QApplication
from vtkmodules.vtkRenderingCore import vtkRenderWindow

from app.editing.document import MapDocument
from app.scene.scene_file import load_scene
from app.session.prepare import PreparedScene, prepare
from tests.widgets.support.samples import coarse
from widgets.common.colours import DARK, apply_theme
from widgets.common.settings import Settings
from widgets.document.map_editor import MapEditor
from widgets.map_view.live_image import AtlasTile
from widgets.session.backends import INLINE
from widgets.window.main_window import MainWindow
from widgets.workers.scene_worker import InlineSceneWorker

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
def tiles_made_once():
    """A live image depends on nothing but charts and how it is made: 0.15 s of each window otherwise."""
    of = lru_cache(maxsize=32)(AtlasTile.of)  # patches and charts are what they are, not what is in them
    with pytest.MonkeyPatch.context() as patching:
        patching.setattr(AtlasTile, "of", of)
        yield


@pytest.fixture
def editor(prepared):
    """On the small arm's map, taking edits; what is computed is there at once."""
    made = MapEditor(InlineSceneWorker())
    made.open(MapDocument.of(prepared.map))
    made.set_enabled(enabled=True)
    return made


@pytest.fixture
def backends():
    """All of the window's work is done when a test asks for it; one that wants a process says so."""
    return INLINE


@pytest.fixture
def window(qtbot, prepared, backends, tmp_path, monkeypatch):
    """The window on the small arm, without the scripted hand's touch in the way."""
    monkeypatch.setattr("widgets.presenters.session_presenter.recordings_folder", lambda: tmp_path / "recordings")
    monkeypatch.setattr(
        "widgets.presenters.map_file_presenter.user_state_path", lambda *_args, **_kwargs: tmp_path / "state"
    )
    apply_theme(QApplication.instance(), DARK)
    made = MainWindow(Settings(tmp_path / "window.ini"), backends=backends)
    made.resize(1400, 900)
    made.show()
    qtbot.waitExposed(made)
    made.live.show_prepared(prepared)
    QApplication.processEvents()
    yield made
    made.presenters.map_files.give_up()
    made.close()
    made.deleteLater()


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
