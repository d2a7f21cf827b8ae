"""What must be true of the window after whatever was done to it: nothing unforeseen, a whole map, a session that lives
or says why not, and actions as the state has them.
"""

from __future__ import annotations

import re
import sys
import traceback

import numpy as np
from PySide6.QtCore import QtMsgType, qInstallMessageHandler

from tactile_maps.flattening.bijectivity import crossings, flipped
from tactile_widgets.common.mode import Mode

HARMLESS = re.compile(r"This plugin does not support|not accepted by receiving widget")
"""Said by the off-screen plugin, and by QTest of an event that nobody wanted."""
LOUD = (QtMsgType.QtWarningMsg, QtMsgType.QtCriticalMsg, QtMsgType.QtFatalMsg)


class WindowFault(Exception):
    """Something is not as it must be."""


class WindowChecks:
    """Listens to what nobody foresaw, and looks; used as a context.

    Args:
        window: To look at.
    """

    def __init__(self, window) -> None:
        self._window = window
        self._unforeseen: list[str] = []
        self._warnings: list[str] = []
        self._halts: list[str] = []
        self._whole: dict[int, object] = {}
        window.live.halted.connect(self._halts.append)

    def __enter__(self) -> WindowChecks:
        self._hook = sys.excepthook
        sys.excepthook = self._on_unforeseen
        self._handler = qInstallMessageHandler(self._on_message)
        return self

    def __exit__(self, *_error: object) -> None:
        sys.excepthook = self._hook
        qInstallMessageHandler(self._handler)
        self._whole.clear()

    def _on_unforeseen(self, kind, error, trace) -> None:
        self._unforeseen.append("".join(traceback.format_exception(kind, error, trace)))

    def _on_message(self, kind, _context, text) -> None:
        if kind in LOUD and not HARMLESS.search(text):
            self._warnings.append(f"{text}\n{''.join(traceback.format_stack(limit=8))}")

    def check(self) -> None:
        """Look.

        Raises:
            WindowFault: With what is wrong.
        """
        _require(not self._unforeseen, "an exception that nobody caught", *self._unforeseen)
        _require(not self._window.notifier._faults, "an unexpected error was told", self._window.notifier._faults)
        _require(not self._warnings, "Qt warned", *self._warnings)
        self._check_map()
        self._check_session()
        self._check_actions()

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
            _require(not halted, "a session that stands still is shown as running")
        if halted and live.mode is Mode.PAUSED:
            _require(self._halts, "a session stands still and nobody was told", failure)
        for name in ("posture", "velocity", "pressures", "objects"):
            _require(np.isfinite(getattr(frame, name)).all(), f"{name} with what is no number")

    def _check_actions(self) -> None:
        window = self._window
        tracker = window.presenters.state
        read = tracker._read()
        _require(read == tracker.state, "actions are shown as of another state", tracker.state, read)
        for spec in window.context.actions.specs:
            action = window.action(spec.name)
            _require(action.isEnabled() == spec.enabled(read), f"{spec.name} is enabled, or not, against the state")
            if spec.checked is not None:
                _require(action.isChecked() == spec.checked(read), f"{spec.name} is down, or not, against the state")


def _require(holds: object, *words: object) -> None:
    if not holds:
        raise WindowFault("\n".join(map(str, words)))
