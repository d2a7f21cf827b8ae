"""Fixtures of all widget tests: a small arm, windows that show it, and a check for leaks after each test."""

from __future__ import annotations

import gc
import os
from collections import Counter
from dataclasses import replace
from functools import lru_cache, wraps
from pathlib import Path

import psutil
import pytest
import shiboken6
from PySide6.QtCore import QCoreApplication, QEvent, QThread, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from vtkmodules.vtkRenderingCore import vtkRenderWindow

from tactile_maps.core.caches import content_cache
from tactile_maps.core.files import FOLDER_VARIABLE
from tactile_maps.editing.document import MapDocument
from tactile_maps.maps.image_atlas import AtlasTile, ImageAtlas
from tactile_maps.maps.model.tactile_image import vertex_weights
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_widgets.common.file_dialogs import FileDialog
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.jobs.executor import InlineExecutor
from tactile_widgets.jobs.scene_jobs import SceneJobs
from tactile_widgets.session.backends import INLINE
from tactile_widgets.views.map import map_view
from tactile_widgets.views.robot.actors import skin_actors
from tactile_widgets.window.application import release_memory
from tests.widgets.support.samples import coarse
from tests.widgets.support.window_driver import begin_again, close_window, open_window, window_facts

TAXELS = 150
RUN_CACHE = os.environ[FOLDER_VARIABLE]
"""Folder of prepared scenes that all processes of the run share."""


def _prepared(scene: Scene) -> PreparedScene:
    with pytest.MonkeyPatch.context() as patching:
        patching.setenv(FOLDER_VARIABLE, RUN_CACHE)
        return prepare_cached(scene)


@pytest.fixture(scope="session")
def small_arm() -> PreparedScene:
    """The shipped arm with few taxels, for tests that need its fine triangles. Cost: 3 s, once in a run."""
    scene = load_scene("arm")
    prepared = _prepared(replace(scene, cover=replace(scene.cover, taxels=TAXELS)))
    assert len(prepared.skin) == TAXELS
    return prepared


@pytest.fixture(scope="session")
def prepared(coarse_prepared) -> PreparedScene:
    """The prepared scene of the test; a module may replace it."""
    return coarse_prepared


@pytest.fixture(scope="session")
def coarse_prepared() -> PreparedScene:
    """The shipped arm with few taxels and a tenth of its triangles, whose map is shown and edited faster."""
    return _prepared(coarse(TAXELS))


def _tile_content(patch, chart, resolution, interpolation="barycentric"):
    return (
        chart.faces,
        chart.plane,
        patch.surface.vertices,
        patch.taxels.faces,
        patch.taxels.weights,
        resolution,
        interpolation,
    )


@wraps(ImageAtlas)
def _shared_atlas(map_, *, known=None, look):
    return _atlas_of(map_.skin, map_.charts, map_.layout, known, look)


@lru_cache(maxsize=8)
def _atlas_of(skin, charts, layout, known, look):
    return ImageAtlas(TactileMap(skin, charts, layout), known=known, look=look)


@pytest.fixture(scope="session", autouse=True)
def shared_weights():
    """Share interpolation weights, which depend only on the map, between windows; they cost 0.2 s for each."""
    tile_of = content_cache(_tile_content, most=32)(AtlasTile.of)

    @wraps(AtlasTile.of)
    def tile(patch, chart, *how):
        return replace(tile_of(patch, chart, *how), chart=chart)

    with pytest.MonkeyPatch.context() as patching:
        patching.setattr(AtlasTile, "of", tile)
        patching.setattr(map_view, "ImageAtlas", _shared_atlas)
        patching.setattr(skin_actors, "vertex_weights", lru_cache(maxsize=8)(vertex_weights))
        yield


@pytest.fixture(scope="module", autouse=True)
def shared_cache_unused():
    """The window prepares every scene that it opens, whatever tests of the same run have prepared."""
    with pytest.MonkeyPatch.context() as patching:
        patching.setenv(FOLDER_VARIABLE, "off")
        yield


@pytest.fixture(scope="module")
def scene_cache(shared_cache_unused):
    """Use scenes that other tests of the run have prepared."""
    with pytest.MonkeyPatch.context() as patching:
        patching.setenv(FOLDER_VARIABLE, RUN_CACHE)
        yield


@pytest.fixture
def editor(prepared):
    """Enabled editor of the small arm's map; computations finish at once."""
    made = MapEditor(SceneJobs(InlineExecutor("prepare")))
    made.open(MapDocument.of(prepared.map))
    made.set_enabled(enabled=True)
    return made


@pytest.fixture
def backends():
    """Backends of ``new_window``; a module that needs threads or processes replaces them."""
    return INLINE


@pytest.fixture
def own_files(tmp_path, monkeypatch):
    """Write recordings and copies of unsaved edits to the temporary folder of the test."""
    _write_into(tmp_path, monkeypatch)


def _write_into(folder: Path, patching: pytest.MonkeyPatch) -> None:
    patching.setattr("tactile_widgets.common.settings.usual_recordings_folder", lambda: folder / "recordings")
    patching.setenv("XDG_DATA_HOME", str(folder / "data"))  # where the trash is
    patching.setattr(
        "tactile_widgets.presenters.maps.map_file_presenter.user_state_path", lambda *_args, **_kwargs: folder / "state"
    )


@pytest.fixture
def choose_file(monkeypatch):
    """Function that lets a method of ``FileDialog`` return a path, as if the user had chosen it."""

    def choose(method, path):
        monkeypatch.setattr(FileDialog, method, lambda *_args: str(path))

    return choose


@pytest.fixture
def new_window(qtbot, prepared, backends, tmp_path, own_files):
    """Window on the small arm, created for this test.

    The shared window is hidden meanwhile: it has the same place and would receive the moves of the mouse.
    """
    covered = [widget for widget in QApplication.topLevelWidgets() if widget.isVisible()]
    for widget in covered:
        widget.hide()
    window = open_window(tmp_path, backends)
    window.live.show_prepared(prepared)
    QApplication.processEvents()
    yield window
    close_window(window)
    for widget in covered:
        widget.show()


@pytest.fixture
def window(new_window):
    """Window on the small arm: a new one, except in modules that return ``window_again`` instead."""
    return new_window


@pytest.fixture(scope="session")
def shared_window(qapp, coarse_prepared, tmp_path_factory):
    """The window of ``window_again``, in a list, and its initial facts."""
    folder = tmp_path_factory.mktemp("window")
    window = open_window(folder, INLINE)
    with pytest.MonkeyPatch.context() as patching:
        _write_into(folder, patching)
        window.live.show_prepared(coarse_prepared)
        QApplication.processEvents()
    held = [window]
    _OF_SHARED_WINDOW.update(id(thing) for thing in gc.get_objects() if isinstance(thing, _CHECKED))
    yield held, window_facts(window)
    _OF_SHARED_WINDOW.clear()
    held.clear()
    close_window(window)
    del window
    gc.unfreeze()
    _collect()  # without it nanobind would report its trees of triangles as leaks at exit


@pytest.fixture(scope="module")
def visible_window(shared_window):
    """The shared window, shown for the tests of a module; hidden elsewhere, because it would take the focus."""
    (window,), at_first = shared_window
    window.show()
    assert QTest.qWaitForWindowExposed(window)
    yield [window], at_first
    window.hide()


@pytest.fixture
def window_again(visible_window, prepared, own_files):
    """The shared window on the small arm, reset, which takes a tenth of the time of a new one.

    For tests that change only what ``begin_again`` resets. Fails if the previous test left something else.
    """
    (window,), at_first = visible_window
    begin_again(window, prepared, folded=at_first["folded"])
    assert window_facts(window) == at_first, "the previous test left something in the window"
    yield window
    window.presenters.map_files.give_up()


@pytest.fixture(autouse=True)
def nothing_left():
    """Fail a test that leaves a window, a running timer or thread, or a render window behind.

    Objects that exist before the test are frozen, so that only those of the test are collected and checked: 0.01 s
    instead of 0.7 s. Those that the shared window has dropped since, 9 MB for each session, are collected once the
    process has grown.
    """
    if _size() > _SIZE[0] + _GROWTH:
        gc.unfreeze()
        _flush_deferred_deletes()
        release_memory()
        _SIZE[0] = _size()
        gc.freeze()  # the next pass need not visit all objects again
    _collect()
    gc.freeze()
    before = Counter(_describe(widget) for widget in QApplication.topLevelWidgets())
    yield
    _collect()
    left = Counter(_describe(widget) for widget in QApplication.topLevelWidgets()) - before + _running()
    assert not left, f"left behind: {dict(left)}"


_GROWTH = 500_000_000
"""Growth of the process after which frozen objects are collected [bytes]."""
_SIZE = [0]
"""Size of the process after they were last collected [bytes]."""


def _size() -> int:
    return psutil.Process().memory_info().rss


def _collect() -> None:
    _flush_deferred_deletes()
    gc.collect()


_CHECKED = (vtkRenderWindow, QTimer, QThread)
_OF_SHARED_WINDOW: set[int] = set()
"""Identities of the shared window's objects: the code that sends motion ends the freeze that hides them."""


def _running() -> Counter[str]:
    """Count objects created since the freeze that must not outlive a test, by kind."""
    alive: Counter[str] = Counter()
    for thing in gc.get_objects():
        if id(thing) in _OF_SHARED_WINDOW:
            continue
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
        # Twice, because a deleted object may request the deletion of its children.
        for _ in range(2):
            QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
            QCoreApplication.processEvents()


def _describe(thing: object) -> str:
    name = thing.objectName() if hasattr(thing, "objectName") else ""
    return f"{type(thing).__name__} {name}".strip()
