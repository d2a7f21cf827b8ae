"""Memory under a random hand: window after window, each acted on and closed, takes no more than the one before."""

from __future__ import annotations

import ctypes
import ctypes.util
import gc
import os
import subprocess
import sys
from dataclasses import replace
from statistics import median

import numpy as np
import pytest
from PySide6.QtCore import QCoreApplication, QEvent
from PySide6.QtGui import QPixmapCache
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_maps.session.prepared_cache import prepare_cached
from tactile_widgets.session.backends import INLINE
from tactile_widgets.window.application import make_application
from tests.support.bounded_process import ROOT
from tests.widgets.support.random_user import RandomUser
from tests.widgets.support.samples import coarse
from tests.widgets.support.window_driver import close_window, open_window, run

TAXELS = 150
WARM_UP = 10
MEASURED = 8
ACTS = 100
"""Windows until the caches of the session, of Qt and of the graphics are full, windows compared, acts in each."""
GROWTH = 0.05
_WINDOWS = """
import sys
from pathlib import Path
from tests.widgets.window.test_memory import use_after_windows

for use in use_after_windows(Path(sys.argv[1])):
    print(*use, flush=True)
"""
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


def heap_reader():
    """Return a function for the allocated bytes of the process, with native libraries and arrays; None without one."""
    library = ctypes.CDLL(ctypes.util.find_library("c"))
    if not hasattr(library, "mallinfo2"):
        return None
    library.mallinfo2.restype = _HeapUse

    def ask() -> int:
        use = library.mallinfo2()
        return use.uordblks + use.hblkhd

    return ask


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


def use_after_windows(folder):
    """Yield the allocated bytes and the number of Python's blocks after each window."""
    _application = make_application()
    heap_bytes = heap_reader()
    prepared = prepare_cached(coarse(TAXELS))
    for number in range(WARM_UP + MEASURED):
        act_in_a_window(700 + number, prepared, folder / str(number))
        let_go()
        yield heap_bytes(), sys.getallocatedblocks()


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="reads the heap of glibc")
def test_memory_is_constant_after_warm_up(tmp_path):
    """The windows have their own process: what other tests share and leave would hide growth, or look like it."""
    if heap_reader() is None:
        pytest.skip("needs mallinfo2 of glibc >= 2.33")
    own = {name: str(tmp_path / "home") for name in ("HOME", "XDG_DATA_HOME", "XDG_STATE_HOME", "XDG_CONFIG_HOME")}
    command = [sys.executable, "-c", _WINDOWS, str(tmp_path)]
    found = subprocess.run(command, cwd=ROOT, env=os.environ | own, capture_output=True, text=True)
    assert found.returncode == 0, found.stderr
    heap, blocks = np.array([line.split() for line in found.stdout.splitlines()], dtype=int).T
    assert len(heap) == WARM_UP + MEASURED
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
