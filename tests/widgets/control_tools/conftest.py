"""What every tool that leads the arm is tried on: a tube, a sheet and a cap, and someone who grants all wishes."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt

from tests.widgets.control_tools.path_hand import shape
from tests.widgets.map_hand import SHEET, MapHand, middle, open_editor, small_document
from widgets.control_tools.lead import Lead
from widgets.control_tools.path_tool import PathTool
from widgets.tools import Tool
from widgets.worker import InlineWorker


@pytest.fixture(scope="module")
def document():
    return small_document()


@pytest.fixture
def lead(document):
    """It remembers in ``asked`` all settings wished for, and in ``heard`` what it said."""
    made = Lead()
    made.asked, made.heard = [], []
    made.wished.connect(made.asked.append)
    made.told.connect(made.heard.append)
    made.show_map(document.map)
    made.set_enabled(enabled=True)
    return made


@pytest.fixture
def hand(qtbot, lead, tool, document):
    """On the map, with the tool."""
    return MapHand(qtbot, open_editor(InlineWorker(), document), tool, kind=Tool.PATH)


@pytest.fixture
def tool(lead):
    return PathTool(lead)


@pytest.fixture
def corners(document):
    return middle(document, SHEET) + np.array([[-0.03, -0.03], [0.0, 0.03], [0.03, -0.03]])


@pytest.fixture
def drawn(hand, lead, corners):
    """A polyline through the corners, as in force."""
    shape(lead, "polyline")
    for corner in corners:
        hand.click(corner)
    hand.key(Qt.Key.Key_Return)
    assert len(lead.settings.path) == 3
    return hand
