"""Invariants of the window: no unexpected error, a valid map, a session that runs or states why not, actions that fit
the state, and no work of the user lost without a question.
"""

from __future__ import annotations

import re
import sys
import traceback
from dataclasses import replace
from functools import partial

import numpy as np
from PySide6.QtCore import QtMsgType, qInstallMessageHandler
from PySide6.QtWidgets import QApplication, QMessageBox

from tactile_maps.editing.document_file import load_document
from tactile_maps.flattening.bijectivity import crossings, flipped
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.runtime_settings import RuntimeSettings
from tactile_widgets.common.mode import Mode
from tactile_widgets.panels.model.skin_panel import SkinPanel
from tests.widgets.support.window_driver import kept_documents

HARMLESS = re.compile(r"This plugin does not support|not accepted by receiving widget")
"""Messages of the off-screen plugin, and of QTest about an event that no widget accepted."""
LOUD = (QtMsgType.QtWarningMsg, QtMsgType.QtCriticalMsg, QtMsgType.QtFatalMsg)


class WindowFault(Exception):
    """Something is not as it must be."""


def _note_unforeseen(noted: list[str], kind, error, trace) -> None:
    noted.append("".join(traceback.format_exception(kind, error, trace)))


class WindowChecks:
    """Collects unexpected errors and checks the invariants; a context manager.

    Args:
        window: Window to check.
    """

    def __init__(self, window) -> None:
        self._window = window
        self._unforeseen: list[str] = []
        self._warnings: list[str] = []
        self._halts: list[str] = []
        self._work = KeptWork(window)
        self._whole: dict[int, object] = {}
        window.live.halted.connect(self._halts.append)

    def __enter__(self) -> WindowChecks:
        self._hook = sys.excepthook
        # Not a method: a thread keeps the hook with which it was started, and would keep the window.
        sys.excepthook = partial(_note_unforeseen, self._unforeseen)
        self._handler = qInstallMessageHandler(self._on_message)
        return self

    def __exit__(self, *_error: object) -> None:
        sys.excepthook = self._hook
        qInstallMessageHandler(self._handler)
        self._whole.clear()

    def _on_message(self, kind, _context, text) -> None:
        if kind in LOUD and not HARMLESS.search(text):
            self._warnings.append(f"{text}\n{''.join(traceback.format_stack(limit=8))}")

    def check(self) -> None:
        """Look.

        Raises:
            WindowFault: With what is wrong.
        """
        _require(not self._unforeseen, "an uncaught exception", *self._unforeseen)
        _require(not self._window.notifier._faults, "an unexpected error was reported", self._window.notifier._faults)
        _require(not self._warnings, "Qt warned", *self._warnings)
        self._check_map()
        self._check_session()
        self._check_actions()
        self._work.check()

    def _check_map(self) -> None:
        document = self._window.editor.document
        if document is None:
            return
        charts = {id(chart): chart for chart in document.charts}
        for key, chart in charts.items():
            if self._whole.get(key) is not chart:
                _require(np.isfinite(chart.plane).all(), "a map with places that are no numbers")
                _require(not flipped(chart.plane, chart.faces).any(), "a map with turned triangles")
                _require(not crossings(chart.plane[chart.border]), "a map whose border crosses itself")
        self._whole = charts

    def _check_session(self) -> None:
        live = self._window.live
        if (runner := live.runner) is None:
            return
        with runner.lock:
            session = runner.session
            failure = session.failure
            halted = runner.halted
            frame = session.frame
        if failure is not None:
            _require(halted, "a session that failed runs on", failure)
        if live.mode is Mode.RUNNING:
            _require(not halted, "a stopped session is shown as running")
        if halted and live.mode is Mode.PAUSED:
            _require(self._halts, "a session stopped without a report", failure)
        for name in ("posture", "velocity", "pressures", "objects"):
            _require(np.isfinite(getattr(frame, name)).all(), f"{name} with what is no number")

    def _check_actions(self) -> None:
        window = self._window
        tracker = window.presenters.state
        read = tracker._read()
        _require(read == tracker.state, "actions are shown as of another state", tracker.state, read)
        for spec in window.context.actions.specs:
            action = window.action(spec.name)
            expected = spec.enabled(read) and spec.name not in window.context.actions.install
            _require(action.isEnabled() == expected, f"{spec.name} is enabled, or not, against the state")
            if spec.checked is not None:
                _require(action.isChecked() == spec.checked(read), f"{spec.name} is down, or not, against the state")


class KeptWork:
    """Checks that the work of the user is kept after every act: in the window, in a file, or by a question.

    Args:
        window: Window to check.
    """

    def __init__(self, window) -> None:
        self._window = window
        self._run = None
        self._made: tuple[object, object] | None = None  # document and settings, in the session before
        self._unsaved: tuple[str, ...] = ()
        self._choice = None  # in the Skin panel, not applied yet
        self._unopened = None  # chosen in the Skin panel for a robot that is not open yet
        self._asked = False
        self._in_file: list[tuple[object, object]] = []

    def check(self) -> None:
        """Look.

        Raises:
            WindowFault: With what is lost.
        """
        live = self._window.live
        document = self._window.editor.document
        files = self._window.presenters.map_files
        choice = files.choice
        unsaved = tuple(name for name in files.unsaved if not name.startswith("chosen skin"))
        if live.run is None or live.live_input is not None or document is None:
            self._unsaved = tuple(part for part in self._unsaved if part in unsaved)  # saved in the meantime
            steps = [] if document is None else [step.document for step in self._window.editor.history._steps]
            if self._made is not None and any(one is self._made[0] for one in steps):
                self._made = document, self._made[1]  # edited in the meantime, or undone
            self._choice = choice
            self._note_question()
            return
        made = document, _control_of(live.run.made)
        if live.run is not self._run and self._made is not None and self._unsaved and not self._asked:
            saved = not {"map", "skin"} & {*self._unsaved}  # then it is in a file, or in that of the scene
            _require(saved or self._has(document, self._made[0]), "the edited map is lost", self._unsaved)
            kept = made[1] == self._made[1] or self._steps_back()
            _require(kept, "controller, path, contact detection or effects are lost", self._unsaved)
        if live.run is not self._run and self._choice is not None and not self._asked:
            kept = choice is not None or self._applied(live.run.prepared.scene)
            _require(kept, "the chosen skin is lost", self._choice)
        if live.run is not self._run and self._unopened is not None and not self._asked:
            opened = live.run.prepared.robot.name == self._unopened.robot
            _require(files.unopened is not None or opened, "the skin for a robot that is not open is lost")
        self._unopened = files.unopened
        if choice is not None and live.replay.player is None:
            _require(self._shows(choice), "the panel shows another skin than the chosen one", choice)
        self._choice = choice
        self._run = live.run
        self._made = made
        self._unsaved = unsaved
        self._check_files(document, live.run)
        self._note_question()

    def _has(self, document, before) -> bool:
        """Whether a document is shown, can be redone, or is kept for undo of a change of the skin."""
        steps = [step.document for step in self._window.editor.history._steps]
        kept = [one.history.present for one in kept_documents(self._window)]
        return any(one is before for one in (document, *steps, *kept))

    def _applied(self, scene) -> bool:
        """Whether a scene has skin on the links of the choice, and on no others."""
        return {*self._choice.links} == {*scene.cover.links, *(grid.link for grid in scene.grids)}

    def _shows(self, choice) -> bool:
        """Whether the Skin panel shows the choice, once it lists links."""
        panel = self._window.column.get(SkinPanel)
        return not panel.tree.rows or panel.cover == choice or panel.apply.text() == "Open"

    def _steps_back(self) -> bool:
        """Whether another step of the skin is shown, which has its own path."""
        return bool(kept_documents(self._window))

    def _note_question(self) -> None:
        """A question stays asked while what it is about has not happened yet."""
        boxes = [box.objectName() for box in self._window.findChildren(QMessageBox) if box.isVisible()]
        pending = self._window.loading_bar.busy or QApplication.activeModalWidget() is not None
        self._asked = bool({"leave", "restore"} & {*boxes}) or (self._asked and pending)

    def _check_files(self, document, run) -> None:
        """Saved work is in the files, unless something else was written there since."""
        files = self._window.presenters.map_files
        first = self._window.editor.history._steps[0].document
        known = document, _control_of(run.made)
        if self._unsaved or files._file is None or any(one == known for one in self._in_file):
            return
        self._in_file = [*self._in_file[-9:], known]
        if document is not first and not files._file.changed_elsewhere:
            _require(load_document(files.path).layout == document.layout, "the map in the file is another")
        path = self._window.presenters.scene_file.path
        stated = RuntimeSettings.of_scene(run.prepared if path is None else _scene_in(path, run.prepared))
        _require(_control_of(stated) == known[1], "controller, path, contact detection or effects are in no file", path)


def _control_of(settings: RuntimeSettings) -> tuple[object, ...]:
    return replace(settings.settings, starts=0), settings.behaviours, settings.reading, settings.effects


def _scene_in(path, prepared):
    return replace(prepared, scene=load_scene(str(path)))


def _require(holds: object, *words: object) -> None:
    if not holds:
        raise WindowFault("\n".join(map(str, words)))
