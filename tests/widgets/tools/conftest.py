"""Fixtures of the tools: a map of a tube, a sheet and a cap, a worker that replies at once or when released, and
settings that are accepted.
"""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt

from tactile_widgets.tools.control.control_settings_editor import ControlSettingsEditor
from tactile_widgets.tools.control.path_tool import PathTool
from tactile_widgets.tools.registry import PATH
from tactile_widgets.views.map.painting import map_painter
from tactile_widgets.views.overlays.callouts import place_callouts
from tests.widgets.support.executors import InlineSceneJobs
from tests.widgets.support.map_view_driver import (
    SHEET,
    MapViewDriver,
    middle,
    open_editor,
    set_path_kind,
    small_document,
)


@pytest.fixture(scope="module")
def document():
    return small_document()


@pytest.fixture
def worker(request):
    """Parametrized indirectly, of that kind."""
    return getattr(request, "param", InlineSceneJobs)()


@pytest.fixture
def editor(worker, document):
    return open_editor(worker, document)


@pytest.fixture
def lead(document):
    """Settings editor with the requested settings in ``asked`` and the notifications in ``heard``."""
    made = ControlSettingsEditor()
    made.asked = []
    made.heard = []
    made.settings_requested.connect(made.asked.append)
    made.notified.connect(made.heard.append)
    made.show_map(document.map)
    made.set_enabled(enabled=True)
    return made


@pytest.fixture
def hand(qtbot, lead, tool, document):
    """Driver of the tool on the map."""
    return MapViewDriver(qtbot, open_editor(InlineSceneJobs(), document), tool, kind=PATH)


@pytest.fixture
def tool(lead):
    return PathTool(lead)


@pytest.fixture
def corners(document):
    return middle(document, SHEET) + np.array([[-0.03, -0.03], [0.0, 0.03], [0.03, -0.03]])


@pytest.fixture
def drawn(hand, lead, corners):
    """Draw a polyline through the corners and return the current path."""
    set_path_kind(lead, "polyline")
    for corner in corners:
        hand.click(corner)
    hand.key(Qt.Key.Key_Return)
    assert len(lead.settings.path) == 3
    return hand


@pytest.fixture
def painted_captions(monkeypatch):
    """Returns the boxes of the captions of contacts that the map view paints [px]."""
    placed = []

    def place(*arguments):
        placed[:] = [callout.box for callout in place_callouts(*arguments)]
        return place_callouts(*arguments)

    monkeypatch.setattr(map_painter, "place_callouts", place)

    def paint(view):
        view.viewport().repaint()
        return [*placed]

    return paint
