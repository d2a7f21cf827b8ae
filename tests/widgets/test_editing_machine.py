"""A restless person at the window: whatever is clicked, dragged, undone, saved or poked, the map stays whole.

``TACTILE_MAPS_EDITS=10000`` does so many acts instead of a few hundred, and tells what they left in memory.
"""

from __future__ import annotations

import gc
import os
import sys
import tempfile
from pathlib import Path
from typing import ClassVar

import numpy as np
import psutil
import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)
from PySide6.QtCore import QCoreApplication, QEvent, QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from app.editing.document import MapDocument
from app.editing.document_file import load_document
from app.editing.reflatten import set_lengths, set_method
from app.maps.bijective import flipped
from app.maps.methods.table import METHODS
from widgets.engines import INLINE
from widgets.main_window import MainWindow
from widgets.settings import Settings
from widgets.tools import Tool

ACTS = int(os.environ.get("TACTILE_MAPS_EDITS", "160"))
A_ROUND = 40
_LEFT = Qt.MouseButton.LeftButton

taxels = st.integers(0, 149)
several = st.sets(st.integers(0, 2), min_size=1)
steps = st.tuples(st.integers(-150, 150), st.integers(-150, 150))
simple = st.sampled_from(
    ("mirror", "true_size", "repack", "hide_patches", "show_patches", "align_left", "align_middle", "add_pin",
     "remove_pin", "select_pins", "undo", "redo", "save_map", "cancel_edit")
)  # fmt: skip


class RestlessPerson(RuleBasedStateMachine):
    """Acts on a real window; every one of them must leave it whole."""

    prepared = None
    done = 0
    memory: ClassVar[list[float]] = []

    @initialize()
    def open(self):
        self.folder = tempfile.TemporaryDirectory()
        self.window = MainWindow(Settings(Path(self.folder.name) / "window.ini"), engines=INLINE)
        self.window.resize(1100, 700)
        self.window.show()
        self.window.live.show_prepared(self.prepared)
        self.window.editing.files._file.path = Path(self.folder.name) / "map.npz"
        self.editor, self.view = self.window.editor, self.window.map_view
        self.first = self.editor.document
        self.failures = []
        self.window.live.halted.connect(self.failures.append)
        QApplication.processEvents()

    def teardown(self):
        if not hasattr(self, "window"):
            return
        self.editor.cancel()
        if len(self.editor.history.names) <= 1000:
            self.editor.go(0)
            assert self.editor.document.layout == MapDocument.of(self.prepared.map).layout
            assert self.editor.document is self.first
        self.window.editing.files.give_up()
        self.window.close()
        self.window.deleteLater()
        self.folder.cleanup()
        QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
        QApplication.processEvents()
        del self.window, self.editor, self.view, self.first
        gc.collect()
        type(self).memory.append(psutil.Process().memory_info().rss / 2**20)

    def pixel(self, taxel):
        return self.view.pixel_of(self.prepared.skin.taxel_point(taxel)).toPoint()

    def drag(self, start, by, *, drop=False):
        """Press, move in three steps, then lift, or give up by Escape."""
        viewport = self.view.viewport()
        QTest.mousePress(viewport, _LEFT, pos=start)
        for share in (0.3, 0.7, 1.0):
            QTest.mouseMove(viewport, start + QPoint(round(share * by[0]), round(share * by[1])))
        if drop:
            QTest.keyClick(self.view, Qt.Key.Key_Escape)
        QTest.mouseRelease(viewport, _LEFT, pos=start + QPoint(*by))

    @rule(tool=st.sampled_from([Tool.ARRANGE, Tool.PINS, Tool.SEAMS, Tool.INTEREST]), taxel=taxels, by=steps,
          drop=st.booleans())  # fmt: skip
    def drags(self, tool, taxel, by, drop):
        self.window.seeing.set_tool(tool)
        self.drag(self.pixel(taxel), by, drop=drop)

    @rule(tool=st.sampled_from([Tool.ARRANGE, Tool.PINS, Tool.SEAMS, Tool.INTEREST]), taxel=taxels)
    def clicks(self, tool, taxel):
        self.window.seeing.set_tool(tool)
        QTest.mouseClick(self.view.viewport(), _LEFT, pos=self.pixel(taxel))

    @rule(chosen=several, name=simple)
    def commands(self, chosen, name):
        self.editor.select(chosen)
        self.window.action(name).trigger()

    @rule(chosen=several, method=st.sampled_from(sorted(METHODS)))
    def lays_flat(self, chosen, method):
        self.editor.ask(lambda document: set_method(document, chosen, method))

    @rule(patch=st.integers(0, 2), lengths=st.floats(0, 1))
    def slides(self, patch, lengths):
        self.editor.ask(lambda document: set_lengths(document, [patch], lengths))

    @rule(accept=st.booleans())
    def proposes(self, accept):
        self.window.action("propose_seam").trigger()
        self.editor.accept() if accept else self.editor.decline()

    @rule(share=st.floats(0, 1))
    def goes_back(self, share):
        self.editor.go(round(share * (len(self.editor.history.names) - 1)))

    @precondition(lambda self: self.window.editing.files.path.exists())
    @rule()
    def reloads(self):
        saved = load_document(self.window.editing.files.path)
        assert self.window.editing.files.open(str(self.window.editing.files.path))
        assert self.editor.document.layout == saved.layout
        for one, other in zip(self.editor.document.charts, saved.charts, strict=True):
            assert np.array_equal(one.plane, other.plane)

    @rule(taxel=taxels)
    def pokes(self, taxel):
        self.window.seeing.set_tool(Tool.POKE)
        QTest.mousePress(self.view.viewport(), _LEFT, pos=self.pixel(taxel))
        self.window.live.runner.run_for(0.04)
        self.window.live.pump()
        QTest.mouseRelease(self.view.viewport(), _LEFT, pos=self.pixel(taxel))

    @rule(width=st.integers(900, 1500), height=st.integers(500, 1000))
    def resizes(self, width, height):
        self.window.resize(width, height)
        QApplication.processEvents()

    @invariant()
    def whole(self):
        if not hasattr(self, "window"):
            return
        type(self).done += 1
        document = self.editor.document
        assert not self.editor.gesture, "no hand is left holding"
        assert not self.failures
        for chart in document.charts:
            assert not flipped(chart.plane, chart.faces).any()
        self.window.live.runner.run_for(0.01)
        assert self.window.live.runner.session.map is document.map, "touch goes on on the map that is shown"
        self.window.live.pump()
        self.view.viewport().repaint()


@pytest.mark.filterwarnings("error")
def test_whatever_a_restless_person_does_the_map_stays_whole(prepared, qapp, tmp_path, monkeypatch):
    monkeypatch.setattr("widgets.map_files.user_state_path", lambda *_args, **_kwargs: tmp_path / "state")
    RestlessPerson.prepared, RestlessPerson.done = prepared, 0
    run_state_machine_as_test(
        RestlessPerson,
        settings=settings(
            max_examples=max(ACTS // A_ROUND, 1),
            stateful_step_count=A_ROUND,
            deadline=None,
            derandomize=True,
            database=None,
            suppress_health_check=list(HealthCheck),
        ),
    )
    if ACTS > 1000:
        first, last = RestlessPerson.memory[3], RestlessPerson.memory[-1]
        sys.stderr.write(f"\n{RestlessPerson.done} acts, {first:.0f} MB after 4 windows, {last:.0f} MB in the end\n")
    assert RestlessPerson.done >= 0.5 * ACTS
