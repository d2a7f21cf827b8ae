"""Memory under a random hand: window after window, each acted on and closed, takes no more than the one before."""

from __future__ import annotations

import ctypes
import ctypes.util
import gc
import sys
from statistics import median

import pytest
from PySide6.QtCore import QCoreApplication, QEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_widgets.session.backends import INLINE
from tests.widgets.support.random_user import RandomUser
from tests.widgets.support.window_driver import close_window, open_window, run

WARM_UP = 10
MEASURED = 8
ACTS = 100
"""Windows until the caches of the session, of Qt and of the graphics are full, windows compared, acts in each."""
GROWTH = 0.05


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
    """Answers how many bytes the process has allocated and not given back: native libraries and arrays as well."""
    library = ctypes.CDLL(ctypes.util.find_library("c"))
    if not hasattr(library, "mallinfo2"):
        pytest.skip("needs mallinfo2 of glibc >= 2.33")
    library.mallinfo2.restype = _HeapUse

    def ask() -> int:
        use = library.mallinfo2()
        return use.uordblks + use.hblkhd

    return ask


@pytest.fixture(scope="module")
def prepared(coarse_prepared):
    """Maps of it are measured, and patches flattened, ten times as soon."""
    return coarse_prepared


def act_in_a_window(seed, prepared, folder):
    """Open a window, do anything in it, and close it."""
    folder.mkdir()
    window = open_window(folder, INLINE)
    window.live.show_prepared(prepared)
    QApplication.processEvents()
    with RandomUser(window, seed, folder, lambda seconds: run(window, seconds)) as user:
        user.run(ACTS)
    close_window(window)


def let_go():
    """Of what waits to be deleted."""
    for _ in range(3):
        QTest.qWait(20)
        QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
        gc.collect()


@pytest.mark.long
def test_memory_is_flat_after_warm_up(qtbot, prepared, own_files, tmp_path, heap_bytes):
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
