"""The robot view without a window: empty or with the small arm, and its signals."""

from __future__ import annotations

import pytest

from tests.widgets.support.heard import Heard
from tests.widgets.support.robot_view_driver import open_view, skin_pixel


@pytest.fixture
def empty(qtbot):
    view = open_view(qtbot)
    yield view
    view.close_view()


@pytest.fixture
def view(empty, prepared):
    empty.show_prepared(prepared)
    empty.display.draw_now()
    return empty


@pytest.fixture
def heard(view):
    return Heard(view, drawn=view.display.drawn)


@pytest.fixture
def skin(view, prepared):
    """A pixel on the skin with skin all around it."""
    return skin_pixel(view, prepared)
