"""A map view on the screen, for tests of what it shows."""

import pytest

from tactile_widgets.common.colours import DARK, PressureScale
from tests.widgets.support.layered_map_view import layered_map_view


@pytest.fixture
def open_map_view(qtbot):
    """Opens dark map views of a size, each once something is in it."""

    def make(width, height, fill):
        view = layered_map_view(DARK, PressureScale(20.0))
        qtbot.addWidget(view)
        view.resize(width, height)
        fill(view)
        view.show()
        qtbot.waitExposed(view)
        return view

    return make
