"""Memory under a random hand: window after window, each acted on and closed, takes no more than the one before."""

from __future__ import annotations

import ctypes
import ctypes.util
import gc
import subprocess
import sys
from dataclasses import replace
from statistics import median

import pytest
from PySide6.QtCore import QCoreApplication, QEvent
from PySide6.QtGui import QPixmapCache
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_maps.maps.image_atlas import AtlasTile, ImageAtlas
from tactile_maps.maps.model.tactile_image import vertex_weights
from tactile_widgets.session.backends import INLINE
from tactile_widgets.views.map import map_view
from tactile_widgets.views.robot.actors import skin_actors
from tests.widgets.support.random_user import RandomUser
from tests.widgets.support.window_driver import close_window, open_window, run

WARM_UP = 10
MEASURED = 8
ACTS = 100
"""Windows until the caches of the session, of Qt and of the graphics are full, windows compared, acts in each."""
GROWTH = 0.05
_OPENINGS = """
import sys
from PySide6.QtCore import QEvent
from PySide6.QtWidgets import QApplication
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_widgets.window.application import make_application, picture_window, release_memory_between_scenes

make_application()
window = picture_window("dark", (1400, 900))
release_memory_between_scenes(window)
for number in range(14):
    window.live.show_prepared(prepare_cached(load_scene(("arm", "ur5e")[number % 2])))
    window.live.runner.run_for(0.05)
    window.live.pump()
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
    QApplication.processEvents()
    window.robot_view.display.draw_now(quality=1.0)
    pages = int(open("/proc/self/statm").read().split()[1])
    print(pages, flush=True)
window.close()
"""


class _HeapUse(ctypes.Structure):
    """``struct mallinfo2`` of glibc."""

    _fields_ = [
        (name, ctypes.c_size_t)
        for name in (
            "arena",
            "ordblks",
            "smblks",
            "hblks",
            "hblkhd",
            "usmblks",
            "fsmblks",
            "uordblks",
            "fordblks",
            "keepcost",
        )
    ]


@pytest.fixture(scope="module")
def heap_bytes():
    """Return the number of allocated bytes of the process, including native libraries and arrays."""
    library = ctypes.CDLL(ctypes.util.find_library("c"))
    if not hasattr(library, "mallinfo2"):
        pytest.skip("needs mallinfo2 of glibc >= 2.33")
    library.mallinfo2.restype = _HeapUse

    def ask() -> int:
        use = library.mallinfo2()
        return use.uordblks + use.hblkhd

    return ask


@pytest.fixture
def own_weights(shared_weights, monkeypatch):
    """Let each window compute its interpolation weights: those shared by tests fill 130 MB over many windows."""
    monkeypatch.setattr(AtlasTile, "of", AtlasTile.of.__wrapped__)
    monkeypatch.setattr(map_view, "ImageAtlas", ImageAtlas)
    monkeypatch.setattr(skin_actors, "vertex_weights", vertex_weights)


def act_in_a_window(seed, prepared, folder):
    """Open a window on a copy of a scene, with which all that is computed for it is discarded, act, and close it."""
    folder.mkdir()
    window = open_window(folder, INLINE)
    skin = replace(prepared.skin)
    map_ = replace(prepared.map, skin=skin)
    window.live.show_prepared(replace(prepared, robot=replace(prepared.robot), skin=skin, map=map_))
    QApplication.processEvents()
    with RandomUser(window, seed, folder, lambda seconds: run(window, seconds)) as user:
        user.run(ACTS)
    close_window(window)


def let_go():
    """Delete the objects that wait for deletion, and Qt's pictures of icons, which fill 10 MB over 20 windows."""
    for _ in range(3):
        QTest.qWait(20)
        QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
        gc.collect()
    QPixmapCache.clear()


@pytest.mark.long
def test_memory_is_constant_after_warm_up(qtbot, prepared, own_files, own_weights, tmp_path, heap_bytes):
    heap = []
    blocks = []
    for number in range(WARM_UP + MEASURED):
        act_in_a_window(700 + number, prepared, tmp_path / str(number))
        let_go()
        heap.append(heap_bytes())
        blocks.append(sys.getallocatedblocks())
    half = MEASURED // 2
    for measured in (heap, blocks):
        first = median(measured[WARM_UP : WARM_UP + half])
        last = median(measured[-half:])
        assert last < (1 + GROWTH) * first, measured


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_memory_does_not_grow_while_ten_robots_are_opened(tmp_path, monkeypatch):
    monkeypatch.setenv("TACTILE_MAPS_CACHE", str(tmp_path))
    found = subprocess.run([sys.executable, "-c", _OPENINGS], capture_output=True, text=True, check=True)
    pages = [int(line) for line in found.stdout.split()]
    assert len(pages) == 14
    assert max(pages[-2:]) < 1.05 * max(pages[2:4]), "each of the two robots was opened five times more"
