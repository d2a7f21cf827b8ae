"""What every tool is tried on: a tube, a sheet and a cap; a worker that answers at once or when let go, and settings
that are granted.
"""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt

from tactile_widgets.tools.control.control_settings_editor import ControlSettingsEditor
from tactile_widgets.tools.control.path_tool import PathTool
from tactile_widgets.tools.registry import PATH
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
    """It remembers in ``asked`` all settings wished for, and in ``heard`` what it said."""
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
    """On the map, with the tool."""
    return MapViewDriver(qtbot, open_editor(InlineSceneJobs(), document), tool, kind=PATH)


@pytest.fixture
def tool(lead):
    return PathTool(lead)


@pytest.fixture
def corners(document):
    return middle(document, SHEET) + np.array([[-0.03, -0.03], [0.0, 0.03], [0.03, -0.03]])


@pytest.fixture
def drawn(hand, lead, corners):
    """A polyline through the corners, as in force."""
    set_path_kind(lead, "polyline")
    for corner in corners:
        hand.click(corner)
    hand.key(Qt.Key.Key_Return)
    assert len(lead.settings.path) == 3
    return hand
