"""What every tool that leads the arm is tried on: a tube, a sheet and a cap, and someone who grants all wishes."""

from __future__ import annotations

import pytest

from tests.widgets.map_hand import MapHand, open_editor, small_document
from widgets.control_tools.lead import Lead
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
